//! Exact recovery of a control net from points of its surface.

use glam::DVec3;

use super::options::{Aspect, ReconstructOptions};
use super::{fitted, relay};
use crate::chart::Kind;
use crate::cloud::{self, Normalization};
use crate::error::{Error, Result};
use crate::fit::{Flat, Recovery, recovered};
use crate::nurbs::NurbsSurface;
use crate::progress::Observer;

/// Finds the B-spline surface with a net of this shape on which all points lie.
///
/// The surface is open, of degree 3 where the net has rows and columns enough, with uniform knots.
/// A fit with that net comes first; from there parameters and net are solved for together.
///
/// # Errors
///
/// Those of [`cloud::check`]; [`Error::Parameter`] if no such surface is found;
/// [`Error::Interrupted`] if the observer stops it.
pub fn recover_net(
    points: &[DVec3],
    shape: (usize, usize),
    observer: &mut dyn Observer,
) -> Result<NurbsSurface> {
    let options = ReconstructOptions {
        grid: Some(shape),
        aspect: Aspect::Fixed,
        kind: Some(Kind::Sheet),
        clean: false,
        robust: false,
        ..ReconstructOptions::default()
    };
    options.check(points.len())?;
    relay::in_pool(points.len(), observer, |observer| {
        let bounds = cloud::checked_bounds(points, observer)?;
        let near = fitted::reconstruct(points, &bounds, &options, observer)?;
        let frame = Normalization::of(points);
        let local: Vec<DVec3> = points.iter().map(|&point| frame.apply(point)).collect();
        let surface = near.surface.map_control_points(|point| frame.apply(point))?;
        let from = Flat {
            surface: &surface,
            uv: &near.uv,
            fairness: near.report.fairness.unwrap_or(0.0),
            closed: (false, false),
        };
        match recovered(&local, None, None, &from, true, observer)? {
            Recovery::Found(found) => found.map_control_points(|point| frame.undo(point)),
            Recovery::InVain | Recovery::Hopeless => {
                let (rows, cols) = shape;
                let must = format!("on a surface with a net of {rows} × {cols} control points");
                let rms = near.report.deviations.rms;
                let got = format!("points that are {rms:e} off the nearest one found, rms");
                Err(Error::parameter("points", must, got))
            }
        }
    })
}
