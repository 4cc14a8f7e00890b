//! The defects of any surface beside any points.

use glam::{DVec2, DVec3};

use super::defects::{DefectSettings, defects};
use super::terms::{Compared, TermSettings};
use crate::cloud::{Bounds, KdTree, items_at, random_sample};
use crate::diagnostic::Diagnostic;
use crate::error::Result;
use crate::nurbs::{ClosestPointSearch, NurbsSurface};
use crate::observe::{Observations, ObserveSettings};
use crate::progress::Observer;

/// Finds the defects of a surface through points, of whatever origin; none of a valid one.
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
    let (settings, wanted) = (ObserveSettings::default(), DefectSettings::default());
    let many = items_at(points, &random_sample(points, wanted.points));
    let points = items_at(points, &random_sample(points, settings.sample));
    let (mut uv, distances) =
        ClosestPointSearch::new(surface)?.closest_parameters(&points, observer)?;
    // The terms take parameters on [0, 1]².
    let (u, v) = (surface.knots_u().domain(), surface.knots_v().domain());
    let (low, size) = (DVec2::new(u.0, v.0), DVec2::new(u.1 - u.0, v.1 - v.0));
    for uv in &mut uv {
        *uv = (*uv - low) / size;
    }
    let surface = surface.with_domain((0.0, 1.0), (0.0, 1.0))?;
    let seen = Observations::of(&points, settings);
    let closed = closed(&surface);
    let compared = Compared {
        seen: &seen,
        tree: &KdTree::new(&many),
        surface: &surface,
        closed,
        uv: &uv,
        distances: &distances,
        diagonal: Bounds::of(&points).diagonal(),
    };
    defects(&compared, &TermSettings::default(), &wanted)
}

/// In which directions a surface over [0, 1]² ends where it begins.
fn closed(surface: &NurbsSurface) -> [bool; 2] {
    /// Places along the rims that are compared.
    const PLACES: usize = 9;
    let near = f64::EPSILON.sqrt() * surface.size();
    let places = || (0..PLACES).map(|i| i as f64 / (PLACES - 1) as f64);
    let meets = |a: DVec3, b: DVec3| a.distance(b) <= near;
    [
        places().all(|v| meets(surface.point(0.0, v), surface.point(1.0, v))),
        places().all(|u| meets(surface.point(u, 0.0), surface.point(u, 1.0))),
    ]
}
