//! Projection of points onto a surface, and parameter correction (J. Hoschek, *Intrinsic
//! parametrization for approximation*, 1988).
//!
//! The search is local, from known parameters. The global one is
//! [`crate::nurbs::ClosestPointSearch`].

use glam::{DVec2, DVec3};

use super::patches::{Evaluation, Patches, Tangents, evaluate_all};
use super::settings::{LeastSquaresSettings, ProjectionSettings};
use crate::nurbs::NurbsSurface;
use crate::worker_pool::install;

const SETTINGS: ProjectionSettings = ProjectionSettings::STANDARD;
const LEAST_SQUARES: LeastSquaresSettings = LeastSquaresSettings::STANDARD;

/// The projection of a point: the foot point on the surface, at a local minimum of the distance.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Projection {
    pub(super) uv: DVec2,
    /// The unit normal there.
    pub(super) normal: DVec3,
    /// The vector from the surface to the point.
    pub(super) offset: DVec3,
    /// Whether the foot point lies on the border, so that the point may be beyond the surface.
    pub(super) border: bool,
}

/// Projections of points by `steps` Gauss-Newton steps from parameters `uv`. No step increases the
/// distance. Parameters in closed directions are periodic, others stay in the domain.
pub(super) fn projections(
    surface: &NurbsSurface,
    closed: [bool; 2],
    points: &[DVec3],
    uv: &[DVec2],
    steps: usize,
) -> Vec<Projection> {
    let (domain, patches) = (Domain::of(surface, closed), Patches::of(surface));
    evaluate_all(&ProjectionTask { domain, patches, points, uv, steps }, points.len())
}

/// Like [`projections`], but the surface is extended beyond its open borders, by this share of the
/// domain.
pub(super) fn extended_projections(
    surface: &NurbsSurface,
    closed: [bool; 2],
    beyond: f64,
    points: &[DVec3],
    uv: &[DVec2],
    steps: usize,
) -> Vec<Projection> {
    let domain = Domain::of(surface, closed).extended(beyond);
    evaluate_all(
        &ProjectionTask { domain, patches: Patches::of(surface), points, uv, steps },
        points.len(),
    )
}

struct ProjectionTask<'a> {
    domain: Domain,
    patches: Patches<'a>,
    points: &'a [DVec3],
    uv: &'a [DVec2],
    steps: usize,
}

impl Evaluation for ProjectionTask<'_> {
    type Output = Projection;

    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    fn evaluate(&self, index: usize) -> Projection {
        self.domain.project_point(&self.patches, self.points[index], self.uv[index], self.steps)
    }
}

/// Parameters and distances of the points' projections onto a polynomial surface, from parameters
/// near them: parameter correction by four Gauss-Newton steps, none of which increases the
/// distance.
///
/// ```
/// use neurbs::{DVec2, DVec3, NurbsSurface, fit::project};
/// let net = vec![DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::X + DVec3::Y];
/// let square = NurbsSurface::clamped(net, (2, 2), 1)?;
/// let above = [DVec3::new(0.25, 0.5, 2.0)];
/// let (uv, distances) = project(&square, (false, false), &above, &[DVec2::splat(0.4)]);
/// assert!(uv[0].distance(DVec2::new(0.25, 0.5)) < 1e-12 && distances == [2.0]);
/// # Ok::<(), neurbs::Error>(())
/// ```
#[must_use]
pub fn project(
    surface: &NurbsSurface,
    closed: (bool, bool),
    points: &[DVec3],
    uv: &[DVec2],
) -> (Vec<DVec2>, Vec<f64>) {
    let steps = SETTINGS.first_steps;
    let projections = install(|| projections(surface, closed.into(), points, uv, steps));
    projections.iter().map(|projection| (projection.uv, projection.offset.length())).unzip()
}

/// The parameters that are allowed.
struct Domain {
    low: DVec2,
    high: DVec2,
    closed: [bool; 2],
}

impl Domain {
    fn of(surface: &NurbsSurface, closed: [bool; 2]) -> Self {
        let (u, v) = (surface.knots_u().domain(), surface.knots_v().domain());
        Self { low: DVec2::new(u.0, v.0), high: DVec2::new(u.1, v.1), closed }
    }

    /// The domain extended at both ends of open directions, by this share of its size.
    fn extended(self, share: f64) -> Self {
        let open = self.closed.map(|closed| if closed { 0.0 } else { share });
        let more = DVec2::from_array(open) * (self.high - self.low);
        Self { low: self.low - more, high: self.high + more, ..self }
    }

    fn restricted(&self, at: DVec2) -> DVec2 {
        let place = |d: usize| {
            let (low, high) = (self.low[d], self.high[d]);
            if !self.closed[d] {
                return at[d].clamp(low, high);
            }
            if (low..=high).contains(&at[d]) {
                return at[d];
            }
            // The end of the domain is its beginning. Rounding must not lead beyond it.
            (low + (at[d] - low).rem_euclid(high - low)).min(high)
        };
        DVec2::new(place(0), place(1))
    }

    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    fn project_point(
        &self,
        patches: &Patches<'_>,
        point: DVec3,
        from: DVec2,
        steps: usize,
    ) -> Projection {
        let size = self.high - self.low;
        let mut at = self.restricted(from);
        let mut here = patches.at(at);
        for _ in 0..steps {
            let offset = point - here.point;
            let gradient = DVec2::new(offset.dot(here.u), offset.dot(here.v));
            let blocked = [0, 1].map(|d| self.is_blocked(at, gradient, d));
            let step = step(&here, offset, blocked);
            let longest = (step.abs() / size).max_element();
            if longest.is_nan() {
                break;
            }
            if longest <= SETTINGS.converged_step {
                // Taken without a comparison of distances, which rounding would decide.
                at = self.restricted(at + step);
                break;
            }
            let mut share = (SETTINGS.max_step / longest).min(1.0);
            let mut moved = false;
            for _ in 0..=SETTINGS.max_halvings {
                let next = self.restricted(at + share * step);
                let there = patches.at(next);
                if there.point.distance_squared(point)
                    <= SETTINGS.max_increase * offset.length_squared()
                {
                    (at, here, moved) = (next, there, true);
                    break;
                }
                share *= 0.5;
            }
            if !moved {
                break;
            }
        }
        let border =
            (0..2).any(|d| !self.closed[d] && (at[d] <= self.low[d] || at[d] >= self.high[d]));
        Projection { uv: at, normal: here.normal(), offset: point - here.point, border }
    }

    /// Whether a parameter is at the end of its range, and the step would lead beyond.
    fn is_blocked(&self, at: DVec2, gradient: DVec2, d: usize) -> bool {
        let beyond = (at[d] <= self.low[d] && gradient[d] < 0.0)
            || (at[d] >= self.high[d] && gradient[d] > 0.0);
        !self.closed[d] && beyond
    }
}

/// The Gauss-Newton step in parameters that removes the tangential residual. Directions that are
/// `blocked` do not move.
#[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
#[inline(always)]
fn step(here: &Tangents, offset: DVec3, blocked: [bool; 2]) -> DVec2 {
    let (uu, uv, vv) = (here.u.length_squared(), here.u.dot(here.v), here.v.length_squared());
    let (ru, rv) = (offset.dot(here.u), offset.dot(here.v));
    let alone = |r: f64, square: f64| if square > 0.0 { r / square } else { 0.0 };
    match blocked {
        [true, true] => DVec2::ZERO,
        [true, false] => DVec2::new(0.0, alone(rv, vv)),
        [false, true] => DVec2::new(alone(ru, uu), 0.0),
        [false, false] => {
            let det = uu * vv - uv * uv;
            if det > LEAST_SQUARES.zero_ratio * uu * vv {
                DVec2::new(vv * ru - uv * rv, uu * rv - uv * ru) / det
            } else {
                DVec2::new(alone(ru, uu), alone(rv, vv))
            }
        }
    }
}
