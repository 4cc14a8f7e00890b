//! The curves around a trimmed face, in (u, v) and in space, and their extent.

use glam::DVec3;

use super::crease::split_at_creases;
use super::edge_curve::edge_curve;
use super::face::Face;
use super::loops::bridged;
use crate::error::Result;
use crate::nurbs::{BezierCurve, NurbsCurve};

/// Largest distance between a curve in space and the surface, as a fraction of the surface's size.
const ACCURACY: f64 = 1e-9;

/// Rounding errors of a point, as a fraction of its largest coordinate.
const ROUNDING: f64 = 4e-15;

/// Halvings of a piece at most. Its control points converge to it quadratically, so that this meets
/// rounding.
const MAX_HALVINGS: u32 = 26;

/// A curve around a face.
#[derive(Clone, Debug)]
pub(super) struct BorderCurve {
    /// The curve in (u, v).
    pub uv: NurbsCurve,
    /// The curve in space, with the same parameter.
    pub in_space: NurbsCurve,
}

impl BorderCurve {
    /// The curves of all loops of a face, split at the creases of its surface.
    pub(super) fn of(face: &Face) -> Result<Vec<Self>> {
        let surface = face.surface();
        let (low, high) = surface.net_box();
        let largest = low.abs().max(high.abs()).max_element();
        let accuracy = (ACCURACY * surface.size()).max(ROUNDING * largest).max(f64::MIN_POSITIVE);
        let mut all = vec![];
        for of_loop in face.loops() {
            for curve in bridged(of_loop)? {
                for uv in split_at_creases(surface, curve)? {
                    let in_space = edge_curve(surface, &uv, accuracy)?;
                    all.push(Self { uv, in_space });
                }
            }
        }
        Ok(all)
    }
}

/// The smallest and largest coordinates of curves.
pub(super) fn extents(curves: &[BorderCurve]) -> Result<(DVec3, DVec3)> {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for curve in curves {
        for piece in BezierCurve::of(&curve.in_space)? {
            for (k, axis) in DVec3::AXES.into_iter().enumerate() {
                let mut below = -low[k];
                extend(&piece, axis, MAX_HALVINGS, &mut high[k]);
                extend(&piece, -axis, MAX_HALVINGS, &mut below);
                low[k] = -below;
            }
        }
    }
    Ok((low, high))
}

/// Raises the largest known coordinate in a direction to that of a piece.
fn extend(piece: &BezierCurve, direction: DVec3, halvings: u32, reached: &mut f64) {
    *reached = reached.max(piece.start().dot(direction)).max(piece.end().dot(direction));
    let bound = piece.control_points().map(|point| point.dot(direction)).fold(f64::MIN, f64::max);
    if bound <= *reached || halvings == 0 {
        return;
    }
    for half in piece.halves() {
        extend(&half, direction, halvings - 1, reached);
    }
}
