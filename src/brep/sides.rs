//! The sides of a surface's rectangle, as a loop.

use glam::DVec3;

use super::loops::Loop;
use crate::error::Result;
use crate::nurbs::{NurbsCurve, NurbsSurface};

/// The four sides, counter-clockwise from the corner with the smallest parameters: along u at the
/// first v, along v at the last u, and back in both.
///
/// The curves' parameters are u or v, or decrease with it on the way back.
pub(super) fn rectangle(surface: &NurbsSurface) -> Result<Loop> {
    let ((u0, u1), (v0, v1)) = (surface.knots_u().domain(), surface.knots_v().domain());
    let side = |from: (f64, f64), to: (f64, f64), (start, end): (f64, f64)| {
        let point = |(u, v)| DVec3::new(u, v, 0.0);
        NurbsCurve::line(point(from), point(to))?.with_domain(start, end)
    };
    Ok(Loop::new(vec![
        side((u0, v0), (u1, v0), (u0, u1))?,
        side((u1, v0), (u1, v1), (v0, v1))?,
        side((u1, v1), (u0, v1), (u0, u1))?,
        side((u0, v1), (u0, v0), (v0, v1))?,
    ]))
}
