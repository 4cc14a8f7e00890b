//! Exact recovery of a control net from points of its surface.

use glam::DVec3;

use super::options::{Aspect, ReconstructOptions};
use super::reconstruct;
use crate::chart::Kind;
use crate::cloud::Normalization;
use crate::error::{Error, Result};
use crate::fit;
use crate::nurbs::NurbsSurface;
use crate::progress::Observer;
use crate::worker_pool;

/// Degree of the surface in both directions, lowered where the net has too few rows or columns.
const DEGREE: usize = 3;

/// Finds the B-spline surface with a net of this shape that passes through all points.
///
/// The surface is open and cubic, or of lower degree if the net is small, with uniform knots. A fit
/// with that net comes first. From it, parameters and net are solved simultaneously.
///
/// # Errors
///
/// Those of [`check`](crate::cloud::check); [`Error::Parameter`] if no such surface is found;
/// [`Error::Interrupted`] if the observer stops it.
pub fn recover_net(
    points: &[DVec3],
    shape: (usize, usize),
    observer: &mut dyn Observer,
) -> Result<NurbsSurface> {
    let (rows, cols) = shape;
    // With fewer points than unknown numbers, many surfaces pass through all points.
    let unknown_numbers = rows.saturating_mul(cols).saturating_mul(3);
    if points.len() < unknown_numbers {
        let must =
            format!("at least {unknown_numbers} for a net of {rows} × {cols} control points");
        return Err(Error::parameter("points", must, points.len()));
    }
    let options = ReconstructOptions {
        grid: Some(shape),
        aspect: Aspect::Fixed,
        kind: Some(Kind::Sheet),
        clean: false,
        robust: false,
        ..ReconstructOptions::default()
    };
    let near = reconstruct(points, &options, observer)?;
    worker_pool::run_observed(points.len(), observer, |observer| {
        let frame = Normalization::of(points);
        let local: Vec<DVec3> = points.iter().map(|&point| frame.apply(point)).collect();
        let degree = DEGREE.min(shape.0 - 1).min(shape.1 - 1);
        let found = fit::recover_net(&local, &near.uv, shape, degree, (false, false), observer)?;
        if let Some(found) = found {
            return found.map_control_points(|point| frame.undo(point));
        }
        let must = format!("on a surface with a net of {rows} × {cols} control points");
        let rms = near.report.deviations.rms;
        let got = format!("points whose rms distance from the nearest surface found is {rms:e}");
        Err(Error::parameter("points", must, got))
    })
}
