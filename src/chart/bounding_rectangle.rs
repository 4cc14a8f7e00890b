//! The bounding rectangle of places in a plane, and parameters on it.

use glam::DVec2;

use super::settings::RectangleSettings;
use crate::cloud::{convex_hull, in_axes, min_area_rectangle, polygon_area};

const SETTINGS: RectangleSettings = RectangleSettings::STANDARD;

/// A rectangle that gives places coordinates in [0, 1]².
#[derive(Clone, Copy, Debug)]
pub(super) struct BoundingRectangle {
    /// The direction of u.
    pub(super) along: DVec2,
    low: DVec2,
    /// Lengths along u and v.
    pub(super) size: DVec2,
}

impl BoundingRectangle {
    /// The rectangle of least area, or the one along the axes if it is larger only by chance.
    pub(super) fn around(places: &[DVec2]) -> Self {
        let straight = Self::along(places, DVec2::X);
        let least = Self::along(places, min_area_rectangle(places).0);
        let by_chance = 1.0 - SETTINGS.chance_gaps / places.len() as f64;
        let turned = least.size.element_product() < by_chance * straight.size.element_product();
        if turned { least } else { straight }
    }

    /// The rectangle with this direction of u.
    fn along(places: &[DVec2], along: DVec2) -> Self {
        let turned = places.iter().map(|place| in_axes(*place, along));
        let empty = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let (low, high) = turned.fold(empty, |(low, high), p| (low.min(p), high.max(p)));
        Self { along, low, size: high - low }
    }

    /// The parameters of a place.
    pub(super) fn uv(&self, place: DVec2) -> DVec2 {
        let local = in_axes(place, self.along) - self.low;
        let share = |d: usize| if self.size[d] > 0.0 { local[d] / self.size[d] } else { 0.5 };
        DVec2::new(share(0), share(1)).clamp(DVec2::ZERO, DVec2::ONE)
    }

    /// Share of the rectangle inside the places' convex hull, over that of as many evenly scattered
    /// places (A. Rényi, R. Sulanke, *Über die konvexe Hülle von n zufällig gewählten
    /// Punkten*, 1963).
    pub(super) fn filled(&self, places: &[DVec2]) -> f64 {
        let n = places.len() as f64;
        let around = ((n - 1.0) / (n + 1.0)).powi(2);
        let evenly = ((1.0 - 8.0 / 3.0 * n.ln() / n) / around).clamp(0.5, 1.0);
        polygon_area(&convex_hull(places)) / self.size.element_product() / evenly
    }
}
