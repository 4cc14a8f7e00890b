//! The defects of a surface beside its points.

use glam::DVec3;

use super::fold_over::folds;
use super::samples::Samples;
use crate::cloud::Bounds;
use crate::diagnostic::Diagnostic;
use crate::error::Result;
use crate::nurbs::{ClosestPointSearch, ClosestPointSlices, NurbsSurface};
use crate::progress::Observer;

/// Shares from which on a surface is folded, and shares of the diagonal from which on it overshoots
/// and its points are thick.
const FOLDED: f64 = 0.01;
const OVERSHOOT: f64 = 0.1;
const THICK: f64 = 0.11;

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
    let count = points.len();
    let (mut uv, mut feet) = (vec![glam::DVec2::ZERO; count], vec![DVec3::ZERO; count]);
    let (mut distances, mut converged) = (vec![0.0; count], vec![false; count]);
    let found = ClosestPointSlices {
        uv: &mut uv,
        points: &mut feet,
        distances: &mut distances,
        converged: &mut converged,
    };
    ClosestPointSearch::new(surface)?.closest_points(points, found, observer)?;
    let squares: f64 = distances.iter().map(|distance| distance * distance).sum();
    defects(surface, points, (squares / count as f64).sqrt(), observer)
}

/// The defects of a surface whose distance from the points is known, as a root mean square.
pub(crate) fn defects(
    surface: &NurbsSurface,
    points: &[DVec3],
    rms: f64,
    observer: &mut dyn Observer,
) -> Result<Vec<Diagnostic>> {
    let samples = Samples::of(surface, observer)?;
    let (rows, cols) = (samples.rows, samples.cols);
    let pairs = rows * (cols - 1) + cols * (rows - 1);
    let share = folds(&samples, points).len() as f64 / pairs as f64;
    let bounds = Bounds::of(points);
    let diagonal = bounds.diagonal();
    let outside = |place: &DVec3| place.distance(place.clamp(bounds.min, bounds.max));
    let distance = samples.places.iter().map(outside).fold(0.0, f64::max);
    let found = [
        (share > FOLDED).then_some(Diagnostic::Folded { share }),
        (distance > OVERSHOOT * diagonal).then_some(Diagnostic::Overshoot { distance, diagonal }),
        (rms > THICK * diagonal).then_some(Diagnostic::Thick { rms, diagonal }),
    ];
    Ok(found.into_iter().flatten().collect())
}
