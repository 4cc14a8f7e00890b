//! The outline of a region: curves that are proved to be simple and disjoint.

use std::sync::Arc as Shared;

use super::border::Border;
use super::clip::{ClippedLoop, clipped};
use super::closed_polygon::{is_inside, polygons_cross, sampled, signed_area};
use super::level::{Closeness, Level};
use super::loop_curves::loop_curves;
use super::outside::outside_shares;
use super::places::Rectangle;
use super::polygon::polygon;
use super::ragged::in_band;
use super::settings::OutlineSettings;
use crate::brep::Face;
use crate::error::{Error, Result};
use crate::nurbs::{NurbsCurve, NurbsSurface};

const SETTINGS: OutlineSettings = OutlineSettings::STANDARD;

/// How a border became curves: the first of these that holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LoopForm {
    /// Arcs between corners, or one smooth curve.
    Arcs,
    /// The same with corners that are less certain and up to twice as many control points, so that
    /// no place is far.
    DenseArcs,
    /// One smooth curve with up to four times as many control points and half the offset.
    Smooth,
    /// One curve with a control point for each place, as smooth as the border allows.
    Banded,
    /// A polygon with few sides.
    Polygon,
    /// The polygon through all places of the border.
    FullPolygon,
}

impl LoopForm {
    fn next(self) -> Option<Self> {
        match self {
            Self::Arcs => Some(Self::DenseArcs),
            Self::DenseArcs => Some(Self::Smooth),
            Self::Smooth => Some(Self::Banded),
            Self::Banded => Some(Self::Polygon),
            Self::Polygon => Some(Self::FullPolygon),
            Self::FullPolygon => None,
        }
    }

    /// Whether the loop is a polygon.
    #[must_use]
    pub fn is_polygon(self) -> bool {
        self >= Self::Polygon
    }
}

/// A border with its curves, unwrapped.
#[derive(Clone, Debug)]
pub(super) struct Outline {
    pub form: LoopForm,
    /// The step in its form: bands become narrower.
    step: usize,
    pub corners: usize,
    pub curves: Vec<NurbsCurve>,
}

impl Outline {
    /// The first form from `form` on whose curves follow the border.
    fn of(
        border: &Border,
        surface: &NurbsSurface,
        rectangle: &Rectangle,
        (mut form, mut step, offset): (LoopForm, usize, f64),
    ) -> Result<Self> {
        loop {
            let made = Self::in_form(border, rectangle, (form, step), offset)?;
            let is_there = made.is_some();
            match made {
                Some(made) if form.is_polygon() || made.follows(border, surface)? => {
                    return Ok(made);
                }
                _ => (form, step) = closer(form, step, is_there),
            }
        }
    }

    /// The curves in one form; `None` if the places do not determine them.
    fn in_form(
        border: &Border,
        rectangle: &Rectangle,
        (form, step): (LoopForm, usize),
        offset: f64,
    ) -> Result<Option<Self>> {
        let level = |knots, band, corner_cost: Option<f64>| {
            let offset = if corner_cost.is_some() { offset } else { 0.5 * offset };
            Level { closeness: Closeness { knots, band }, offset, corner_cost }
        };
        let level = match form {
            LoopForm::Arcs => level(1.0, f64::INFINITY, Some(1.0)),
            LoopForm::DenseArcs => level(2.0, SETTINGS.band, Some(SETTINGS.closer_corner_cost)),
            _ => level(4.0, SETTINGS.band, None),
        };
        let plain = |curves| Some(Self { form, step, corners: 0, curves });
        Ok(match form {
            LoopForm::Arcs | LoopForm::DenseArcs | LoopForm::Smooth => {
                let made = loop_curves(border, rectangle, level)?;
                made.map(|made| Self { form, step, corners: made.corners, curves: made.curves })
            }
            LoopForm::Banded => in_band(border, level, step)?.and_then(|curve| plain(vec![curve])),
            LoopForm::Polygon => plain(polygon(border, SETTINGS.simplify * border.spacing)?),
            LoopForm::FullPolygon => plain(polygon(border, -1.0)?),
        })
    }

    /// Whether few places of the border lie outside, none far.
    fn follows(&self, border: &Border, surface: &NurbsSurface) -> Result<bool> {
        let outside = outside_shares(border, &self.curves, surface)?;
        let far = outside.iter().copied().fold(0.0, f64::max);
        let count = outside.iter().filter(|distance| **distance > SETTINGS.outside).count();
        let few = (SETTINGS.outside_share * border.len() as f64).max(1.0);
        Ok(far <= SETTINGS.farthest_outside && count as f64 <= few)
    }
}

/// The form after one that does not hold; the same one's next step if there is one. `is_there` says
/// whether the places determine curves in this form.
fn closer(form: LoopForm, step: usize, is_there: bool) -> (LoopForm, usize) {
    if form == LoopForm::Banded && is_there {
        return (form, step + 1);
    }
    (form.next().unwrap_or(LoopForm::FullPolygon), 0)
}

/// The faces inside borders of one piece of the region, with the outlines that they are made of.
///
/// Where loops cross, or cannot be proved not to, they are replaced by closer ones, polygons in the
/// end. `None` if not even the polygons are simple, to rounding.
pub(super) fn faces(
    surface: &Shared<NurbsSurface>,
    rectangle: &Rectangle,
    borders: &[&Border],
    offset: f64,
) -> Result<Option<(Vec<Face>, Vec<Outline>)>> {
    let make =
        |k: usize, (form, step)| Outline::of(borders[k], surface, rectangle, (form, step, offset));
    let mut outlines: Vec<Outline> =
        (0..borders.len()).map(|k| make(k, (LoopForm::Arcs, 0))).collect::<Result<_>>()?;
    loop {
        let wrong = match proved(surface, rectangle, borders, &outlines)? {
            Proof::Holds(faces) => return Ok(Some((faces, outlines))),
            Proof::Fails(wrong) => wrong,
        };
        let open = |k: &usize| outlines[*k].form.next().is_some();
        let mut again: Vec<usize> = wrong.into_iter().filter(open).collect();
        if again.is_empty() {
            again = (0..outlines.len()).filter(open).collect();
        }
        if again.is_empty() {
            return Ok(None);
        }
        for k in again {
            outlines[k] = make(k, closer(outlines[k].form, outlines[k].step, true))?;
        }
    }
}

/// Faces whose loops are proved to be simple and disjoint, or the outlines of a loop that is not.
enum Proof {
    Holds(Vec<Face>),
    Fails(Vec<usize>),
}

/// Clips outlines to the rectangle and makes faces of them.
fn proved(
    surface: &Shared<NurbsSurface>,
    rectangle: &Rectangle,
    borders: &[&Border],
    outlines: &[Outline],
) -> Result<Proof> {
    // A chain must turn the way of its border.
    let turned = |k: &usize| {
        let area = signed_area(&outlines[*k].curves);
        !borders[*k].winds() && (area > 0.0) == borders[*k].is_hole()
    };
    let turned: Vec<usize> = (0..outlines.len()).filter(turned).collect();
    if !turned.is_empty() {
        return Ok(Proof::Fails(turned));
    }
    let chains: Vec<&[NurbsCurve]> = outlines.iter().map(|outline| &outline.curves[..]).collect();
    let spacing = borders.iter().map(|border| border.spacing).fold(f64::INFINITY, f64::min);
    let sliver =
        |curves: &[NurbsCurve]| is_sliver(curves, surface, rectangle, SETTINGS.sliver * spacing);
    let loops = clipped(&chains, rectangle, sliver)?;
    let mut faces = vec![];
    for group in nested(loops) {
        let curves = group.iter().map(|of| of.curves.clone()).collect();
        match Face::trimmed(Shared::clone(surface), curves) {
            Ok(face) => faces.push(face),
            Err(Error::Loop { index, .. }) => {
                let crossed = crossed(&group, index);
                return Ok(Proof::Fails(least_close(crossed, outlines)));
            }
            Err(error) => return Err(error),
        }
    }
    Ok(Proof::Holds(faces))
}

/// The chains of a loop and of those that cross it, as far as samples show.
fn crossed(group: &[ClippedLoop], index: usize) -> Vec<usize> {
    let Some(of) = group.get(index) else { return vec![] };
    let own = sampled(&of.curves);
    let mut chains = of.chains.clone();
    for other in group.iter().enumerate().filter(|(k, _)| *k != index).map(|(_, other)| other) {
        if polygons_cross(&own, &sampled(&other.curves)) {
            chains.extend(&other.chains);
        }
    }
    chains
}

/// Those of some chains that follow their borders least closely.
fn least_close(chains: Vec<usize>, outlines: &[Outline]) -> Vec<usize> {
    let form = |k: &usize| outlines[*k].form;
    let least = chains.iter().map(form).min();
    chains.into_iter().filter(|k| Some(form(k)) == least).collect()
}

/// Whether curves stay close to the side of the rectangle at which they begin and end.
fn is_sliver(
    curves: &[NurbsCurve],
    surface: &NurbsSurface,
    rectangle: &Rectangle,
    near: f64,
) -> bool {
    sampled(curves).into_iter().all(|at| {
        let at = at.clamp(rectangle.low, rectangle.high);
        (0..2).filter(|d| !rectangle.closed[*d]).any(|d| {
            [rectangle.low[d], rectangle.high[d]].into_iter().any(|side| {
                let mut on_side = at;
                on_side[d] = side;
                surface.point(at.x, at.y).distance(surface.point(on_side.x, on_side.y)) < near
            })
        })
    })
}

/// Groups of an outer loop and the loops inside of it.
fn nested(loops: Vec<ClippedLoop>) -> Vec<Vec<ClippedLoop>> {
    let (outer, inner): (Vec<_>, Vec<_>) =
        loops.into_iter().partition(|of| signed_area(&of.curves) > 0.0);
    let polygons: Vec<_> = outer.iter().map(|of| sampled(&of.curves)).collect();
    let mut groups: Vec<Vec<ClippedLoop>> = outer.into_iter().map(|of| vec![of]).collect();
    for hole in inner {
        let at = sampled(&hole.curves)[0];
        let around = polygons.iter().position(|polygon| is_inside(polygon, at)).unwrap_or(0);
        if let Some(group) = groups.get_mut(around) {
            group.push(hole);
        }
    }
    groups
}
