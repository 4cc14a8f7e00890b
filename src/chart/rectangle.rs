//! The rectangle around places in a plane.

use glam::DVec2;

use crate::cloud::{area, hull, least_rectangle};

/// In how many n-ths n points scattered over a rectangle leave more of it than the rectangle of
/// least area around them does: the expected share of its sides, two gaps along each.
const BY_CHANCE: f64 = 4.0;

/// A rectangle: places become coordinates in [0, 1]².
#[derive(Clone, Copy, Debug)]
pub(super) struct Rectangle {
    /// The direction of u.
    pub(super) along: DVec2,
    low: DVec2,
    /// Lengths along u and v.
    pub(super) size: DVec2,
}

impl Rectangle {
    /// The one of least area; the one along the given axes if that is larger by no more than chance.
    pub(super) fn around(places: &[DVec2]) -> Self {
        let straight = Self::along(places, DVec2::X);
        let least = Self::along(places, least_rectangle(places).0);
        let by_chance = 1.0 - BY_CHANCE / places.len() as f64;
        let turned = least.size.element_product() < by_chance * straight.size.element_product();
        if turned { least } else { straight }
    }

    fn along(places: &[DVec2], along: DVec2) -> Self {
        let turned = places.iter().map(|place| turn(along, *place));
        let empty = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let (low, high) = turned.fold(empty, |(low, high), p| (low.min(p), high.max(p)));
        Self { along, low, size: high - low }
    }

    /// The coordinates of a place.
    pub(super) fn uv(&self, place: DVec2) -> DVec2 {
        let local = turn(self.along, place) - self.low;
        let share = |d: usize| if self.size[d] > 0.0 { local[d] / self.size[d] } else { 0.5 };
        DVec2::new(share(0), share(1)).clamp(DVec2::ZERO, DVec2::ONE)
    }

    /// Share of the rectangle inside the places' convex hull, in that of as many places scattered
    /// evenly over one (A. Rényi, R. Sulanke, *Über die konvexe Hülle von n zufällig gewählten
    /// Punkten*, 1963).
    pub(super) fn filled(&self, places: &[DVec2]) -> f64 {
        let n = places.len() as f64;
        let around = ((n - 1.0) / (n + 1.0)).powi(2);
        let evenly = ((1.0 - 8.0 / 3.0 * n.ln() / n) / around).clamp(0.5, 1.0);
        area(&hull(places)) / self.size.element_product() / evenly
    }
}

/// A place by the axes of which the first has this direction.
fn turn(along: DVec2, place: DVec2) -> DVec2 {
    DVec2::new(along.dot(place), along.perp_dot(place))
}
