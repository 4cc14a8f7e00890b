//! Sections: the curves of all loops of a shell before they are joined to edges.

use glam::DVec3;

use super::crease::{split_at, split_at_creases};
use super::edge_curve::edge_curve;
use super::face::Face;
use super::settings::BrepSettings;
use crate::error::Result;
use crate::nurbs::{CurveSearch, NurbsCurve};

/// A curve of a loop, or a part of one.
#[derive(Clone, Debug)]
pub(super) struct Section {
    pub face: usize,
    pub in_loop: usize,
    /// The curve in (u, v).
    pub curve: NurbsCurve,
    /// The curve in space, with the same parameter.
    pub in_space: NurbsCurve,
    /// Whether the curve in space is one point within the tolerance.
    pub is_point: bool,
}

impl Section {
    pub(super) fn new(
        (face, in_loop): (usize, usize),
        surface: &Face,
        curve: NurbsCurve,
        tolerance: f64,
    ) -> Result<Self> {
        let accuracy = BrepSettings::STANDARD.edge_curve * tolerance;
        let in_space = edge_curve(surface.surface(), &curve, accuracy)?;
        let points = in_space.control_points();
        let is_point = points.iter().all(|point| point.distance(points[0]) <= tolerance);
        Ok(Self { face, in_loop, curve, in_space, is_point })
    }

    pub(super) fn start(&self) -> DVec3 {
        self.in_space.control_points()[0]
    }

    pub(super) fn end(&self) -> DVec3 {
        let points = self.in_space.control_points();
        points[points.len() - 1]
    }

    /// The point in space at a share of the parameter's range.
    pub(super) fn point(&self, share: f64) -> DVec3 {
        let (start, end) = self.in_space.knots().domain();
        self.in_space.point(start + share * (end - start))
    }

    /// The parts between parameters.
    fn split(self, cuts: Vec<f64>) -> Result<Vec<Self>> {
        let curves = split_at(self.curve.clone(), cuts.clone())?;
        let in_space = split_at(self.in_space.clone(), cuts)?;
        let part = |(curve, in_space)| Self { curve, in_space, ..self.clone() };
        Ok(curves.into_iter().zip(in_space).map(part).collect())
    }
}

/// The sections of all loops, split at the creases of their surfaces.
pub(super) fn sections(faces: &[Face], tolerance: f64) -> Result<Vec<Section>> {
    let mut all = vec![];
    for (f, face) in faces.iter().enumerate() {
        for (l, of_loop) in face.loops().iter().enumerate() {
            for curve in of_loop.curves() {
                for part in split_at_creases(face.surface(), curve.clone())? {
                    all.push(Section::new((f, l), face, part, tolerance)?);
                }
            }
        }
    }
    Ok(all)
}

/// Splits sections at ends of sections of other faces that lie on them.
pub(super) fn split_at_ends(sections: Vec<Section>, tolerance: f64) -> Result<Vec<Section>> {
    let mut ends: Vec<(usize, DVec3)> =
        sections.iter().flat_map(|s| [(s.face, s.start()), (s.face, s.end())]).collect();
    ends.sort_by(|a, b| a.1.x.total_cmp(&b.1.x));
    let mut all = Vec::with_capacity(sections.len());
    for section in sections {
        let cuts = if section.is_point { vec![] } else { cuts(&section, &ends, tolerance)? };
        all.extend(section.split(cuts)?);
    }
    Ok(all)
}

/// The parameters of the ends on a section; `ends` are the faces and points, by x.
fn cuts(section: &Section, ends: &[(usize, DVec3)], tolerance: f64) -> Result<Vec<f64>> {
    let points = section.in_space.control_points();
    let low = points.iter().copied().reduce(DVec3::min).unwrap_or_default() - tolerance;
    let high = points.iter().copied().reduce(DVec3::max).unwrap_or_default() + tolerance;
    let first = ends.partition_point(|(_, point)| point.x < low.x);
    let near = ends[first..].iter().take_while(|(_, point)| point.x <= high.x);
    let near = near.filter(|(face, point)| {
        let own = [section.start(), section.end()].iter().any(|p| p.distance(*point) <= tolerance);
        *face != section.face && !own && low.cmple(*point).all() && point.cmple(high).all()
    });
    let near: Vec<DVec3> = near.map(|(_, point)| *point).collect();
    if near.is_empty() {
        return Ok(vec![]);
    }
    let search = CurveSearch::new(&section.in_space)?;
    let mut found: Vec<(f64, DVec3)> = near
        .iter()
        .map(|point| search.closest_point(*point))
        .filter(|closest| closest.distance <= tolerance)
        .map(|closest| (closest.u, closest.point))
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Several faces end at the same place.
    found.dedup_by(|a, b| a.1.distance(b.1) <= 2.0 * tolerance);
    let (start, end) = section.curve.knots().domain();
    Ok(found.into_iter().map(|(at, _)| at).filter(|at| start < *at && *at < end).collect())
}
