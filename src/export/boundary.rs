//! Faces with the orientation of their surface, for formats without reversed faces.

use std::sync::Arc;

use glam::DVec3;

use crate::brep::{Coedge, EdgeUse, Face, Shell};
use crate::error::Result;
use crate::nurbs::{NurbsCurve, NurbsSurface};
use crate::progress::Silent;

/// A part of a loop: the curve in (u, v) and, except at a pole, the curve in space with the same
/// parameter.
pub(super) struct Bound {
    pub in_parameters: NurbsCurve,
    pub in_space: Option<NurbsCurve>,
}

impl Bound {
    /// The parts between knots where one of the curves may have a kink.
    pub(super) fn smooth_parts(self) -> Result<Vec<Self>> {
        let mut cuts = vec![];
        for curve in std::iter::once(&self.in_parameters).chain(&self.in_space) {
            let knots = curve.knots();
            let kinks = knots.distinct().filter(|(_, times)| *times >= knots.degree());
            let (start, end) = knots.domain();
            cuts.extend(kinks.map(|(at, _)| at).filter(|&at| start < at && at < end));
        }
        cuts.sort_by(f64::total_cmp);
        cuts.dedup();
        let (mut parts, mut rest) = (vec![], self);
        for at in cuts {
            let (before, in_parameters) = rest.in_parameters.split(at, &mut Silent)?;
            let in_space = rest.in_space.map(|curve| curve.split(at, &mut Silent)).transpose()?;
            let (part, after) = in_space.unzip();
            parts.push(Self { in_parameters: before, in_space: part });
            rest = Self { in_parameters, in_space: after };
        }
        parts.push(rest);
        Ok(parts)
    }

    fn reversed(&self) -> Result<Self> {
        let in_space = self.in_space.as_ref().map(|curve| curve.reversed(&mut Silent));
        Ok(Self {
            in_parameters: self.in_parameters.reversed(&mut Silent)?,
            in_space: in_space.transpose()?,
        })
    }
}

/// The surface of a face with the face's normals. For a reversed face, u and v are exchanged.
pub(super) fn oriented_surface(face: &Face) -> Result<Arc<NurbsSurface>> {
    if face.is_reversed() {
        return Ok(Arc::new(face.surface().transposed(&mut Silent)?));
    }
    Ok(Arc::clone(face.surface()))
}

/// The curves in (u, v) of a face's loops on its [`oriented_surface`].
pub(super) fn oriented_loops(face: &Face) -> Result<Vec<Vec<NurbsCurve>>> {
    let loops = face.loops().iter().map(|of_loop| {
        if !face.is_reversed() {
            return Ok(of_loop.curves().to_vec());
        }
        of_loop.curves().iter().rev().map(|curve| exchanged(curve)?.reversed(&mut Silent)).collect()
    });
    loops.collect()
}

/// The loops of a face in a shell, on its [`oriented_surface`].
pub(super) fn oriented_bounds(shell: &Shell, index: usize) -> Result<Vec<Vec<Bound>>> {
    let mut loops = bounds(shell, index)?;
    if shell.faces()[index].is_reversed() {
        for of_loop in &mut loops {
            of_loop.reverse();
            for bound in of_loop {
                bound.in_parameters = exchanged(&bound.in_parameters)?;
                *bound = bound.reversed()?;
            }
        }
    }
    Ok(loops)
}

/// The loops of a face in a shell, on its own surface.
pub(super) fn bounds(shell: &Shell, index: usize) -> Result<Vec<Vec<Bound>>> {
    let mut loops = vec![];
    for (l, coedges) in shell.coedges(index).iter().enumerate() {
        let uses = (0..).map(|place| EdgeUse { face: index, in_loop: l, place });
        let of_loop = coedges.iter().zip(uses).map(|(coedge, at)| bound(shell, coedge, at));
        loops.push(of_loop.collect::<Result<Vec<Bound>>>()?);
    }
    Ok(loops)
}

fn bound(shell: &Shell, coedge: &Coedge, at: EdgeUse) -> Result<Bound> {
    let Some(edge) = coedge.edge else {
        return Ok(Bound { in_parameters: coedge.curve.clone(), in_space: None });
    };
    let in_space = Some(shell.edges()[edge].curve.clone());
    let along_edge = Bound { in_parameters: shell.pcurve(at)?, in_space };
    if coedge.forward { Ok(along_edge) } else { along_edge.reversed() }
}

/// A curve in (u, v) with u and v exchanged.
fn exchanged(curve: &NurbsCurve) -> Result<NurbsCurve> {
    let points = curve.control_points().iter().map(|p| DVec3::new(p.y, p.x, 0.0)).collect();
    NurbsCurve::new(points, curve.weights().map(<[f64]>::to_vec), curve.knots().clone())
}
