//! Validation of any surface against any points.

use glam::{DVec2, DVec3};

use super::defects::defects;
use super::error_terms::Comparison;
use super::settings::{DefectSettings, TermSettings};
use crate::cloud::{Bounds, KdTree, items_at, random_sample};
use crate::diagnostic::Diagnostic;
use crate::error::Result;
use crate::nurbs::{ClosestPointSearch, NurbsSurface};
use crate::observe::{Observations, ObserveSettings};
use crate::progress::Observer;
use crate::worker_pool;

/// Finds the defects of any surface against any points; a valid surface has none.
///
/// ```
/// use neurbs::{DVec3, NurbsSurface, validate::validate, progress::Silent};
/// let points: Vec<DVec3> =
///     (0..100).map(|i| DVec3::new(f64::from(i % 10), f64::from(i / 10), 0.0)).collect();
/// let flat = |x: [f64; 4]| {
///     let net = x.iter().flat_map(|&x| [DVec3::new(x, 0.0, 0.0), DVec3::new(x, 9.0, 0.0)]);
///     NurbsSurface::clamped(net.collect(), (4, 2), 3)
/// };
/// assert!(validate(&flat([0.0, 3.0, 6.0, 9.0])?, &points, &mut Silent)?.is_empty());
/// let found = validate(&flat([0.0, 20.0, -11.0, 9.0])?, &points, &mut Silent)?;
/// assert_eq!(found[0].code(), "folded");
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`crate::Error::Interrupted`] if the observer stops it.
pub fn validate(
    surface: &NurbsSurface,
    points: &[DVec3],
    observer: &mut dyn Observer,
) -> Result<Vec<Diagnostic>> {
    worker_pool::run_observed(points.len(), observer, |observer| found(surface, points, observer))
}

fn found(
    surface: &NurbsSurface,
    points: &[DVec3],
    observer: &mut dyn Observer,
) -> Result<Vec<Diagnostic>> {
    let (settings, limits) = (ObserveSettings::STANDARD, DefectSettings::STANDARD);
    let fold_sample = items_at(points, &random_sample(points, limits.max_points));
    let points = items_at(points, &random_sample(points, settings.max_sample));
    let (mut uv, distances) =
        ClosestPointSearch::new(surface)?.closest_parameters(&points, observer)?;
    // The error terms take parameters on [0, 1]².
    let (u, v) = (surface.knots_u().domain(), surface.knots_v().domain());
    let (low, size) = (DVec2::new(u.0, v.0), DVec2::new(u.1 - u.0, v.1 - v.0));
    for uv in &mut uv {
        *uv = (*uv - low) / size;
    }
    let surface = surface.with_domain((0.0, 1.0), (0.0, 1.0))?;
    let observations = Observations::of(&points, settings);
    let closed = closed(&surface);
    let compared = Comparison {
        observations: &observations,
        tree: &KdTree::new(&fold_sample),
        surface: &surface,
        closed,
        uv: &uv,
        distances: &distances,
    };
    defects(&compared, Bounds::of(&points).diagonal(), &TermSettings::STANDARD, &limits)
}

/// Whether u and v of a surface over [0, 1]² are closed: it ends where it begins.
fn closed(surface: &NurbsSurface) -> [bool; 2] {
    /// Points along opposite boundary curves that are compared.
    const SAMPLES: usize = 9;
    let near = f64::EPSILON.sqrt() * surface.size();
    let places = || (0..SAMPLES).map(|i| i as f64 / (SAMPLES - 1) as f64);
    let meets = |a: DVec3, b: DVec3| a.distance(b) <= near;
    [
        places().all(|v| meets(surface.point(0.0, v), surface.point(1.0, v))),
        places().all(|u| meets(surface.point(u, 0.0), surface.point(u, 1.0))),
    ]
}
