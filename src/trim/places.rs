//! Places: the distinct parameters of points on a surface, with the surface's points and tangents.

use std::cmp::Ordering;

use glam::{DVec2, DVec3};

use super::settings::PlaceSettings;
use crate::error::Result;
use crate::nurbs::{NurbsSurface, Outside};
use crate::progress::Observer;

const SETTINGS: PlaceSettings = PlaceSettings::STANDARD;

/// The distinct parameters of points, with what the surface is there.
#[derive(Clone, Debug)]
pub(super) struct Places {
    /// Parameters; in a closed direction below the end of the domain.
    pub uv: Vec<DVec2>,
    /// Points of the surface. Noise across the surface plays no part from here on.
    pub points: Vec<DVec3>,
    /// Tangents along u and v.
    pub tangents: Vec<[DVec3; 2]>,
    /// Root mean square lengths of the tangents.
    pub scale: DVec2,
    /// The rectangle of the surface.
    pub rectangle: Rectangle,
}

/// The parameter rectangle of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rectangle {
    pub low: DVec2,
    pub high: DVec2,
    /// Whether u and v close.
    pub closed: [bool; 2],
}

impl Rectangle {
    pub(super) fn of(surface: &NurbsSurface) -> Self {
        let ((u0, u1), (v0, v1)) = (surface.knots_u().domain(), surface.knots_v().domain());
        let closed = surface.closed();
        Self { low: DVec2::new(u0, v0), high: DVec2::new(u1, v1), closed: [closed.0, closed.1] }
    }

    pub(super) fn size(&self) -> DVec2 {
        self.high - self.low
    }

    /// The shortest way from one place to another, through the seams of closed directions.
    pub(super) fn way(&self, from: DVec2, to: DVec2) -> DVec2 {
        let (mut way, size) = (to - from, self.size());
        for d in 0..2 {
            if self.closed[d] {
                way[d] -= size[d] * (way[d] / size[d]).round();
            }
        }
        way
    }

    /// The same place inside the rectangle, in closed directions.
    pub(super) fn wrapped(&self, mut at: DVec2) -> DVec2 {
        let size = self.size();
        for d in 0..2 {
            if self.closed[d] {
                at[d] -= size[d] * ((at[d] - self.low[d]) / size[d]).floor();
                if at[d] >= self.high[d] {
                    at[d] = self.low[d];
                }
            }
        }
        at
    }
}

impl Places {
    /// The distinct places among parameters of points.
    ///
    /// Of very many places, one a square remains: the one nearest to its middle.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Parameter`] if a parameter is outside of the surface's domain.
    pub(super) fn of(
        surface: &NurbsSurface,
        uv: &[DVec2],
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let rectangle = Rectangle::of(surface);
        let step = uv.len().div_ceil(SETTINGS.scale_samples).max(1);
        let some: Vec<DVec2> = uv.iter().copied().step_by(step).collect();
        let scale = mean_lengths(&evaluated(surface, &some, observer)?.1);
        let uv: Vec<DVec2> = uv.iter().map(|at| rectangle.wrapped(*at)).collect();
        let step = DVec2::splat(SETTINGS.merge_share) * rectangle.size();
        let mut kept = one_a_cell(&uv, rectangle.low, step);
        if kept.len() > SETTINGS.max_places {
            let low = kept.iter().copied().reduce(DVec2::min).unwrap_or_default();
            let high = kept.iter().copied().reduce(DVec2::max).unwrap_or_default();
            let area = ((high - low) * scale).element_product();
            let side = (area / SETTINGS.max_places as f64).sqrt();
            kept = one_a_cell(&kept, low, side / scale);
        }
        let (points, tangents) = evaluated(surface, &kept, observer)?;
        Ok(Self { uv: kept, points, tangents, scale, rectangle })
    }

    pub(super) fn len(&self) -> usize {
        self.uv.len()
    }
}

/// Points and tangents of a surface.
fn evaluated(
    surface: &NurbsSurface,
    uv: &[DVec2],
    observer: &mut dyn Observer,
) -> Result<(Vec<DVec3>, Vec<[DVec3; 2]>)> {
    let mut out = vec![DVec3::ZERO; 4 * uv.len()];
    surface.derivatives(uv, 1, &mut out, Outside::Refuse, observer)?;
    Ok(out.chunks_exact(4).map(|table| (table[0], [table[2], table[1]])).unzip())
}

/// Root mean square lengths of tangents; 1 where all vanish.
fn mean_lengths(tangents: &[[DVec3; 2]]) -> DVec2 {
    let squares = tangents.iter().map(|[u, v]| DVec2::new(u.length_squared(), v.length_squared()));
    let mean = (squares.sum::<DVec2>() / tangents.len() as f64).map(f64::sqrt);
    mean.map(|length| if length > 0.0 { length } else { 1.0 })
}

/// The place nearest to the middle of each cell of a grid, in the order of the input.
fn one_a_cell(uv: &[DVec2], low: DVec2, step: DVec2) -> Vec<DVec2> {
    let mut cells: Vec<(DVec2, f64, usize)> = uv
        .iter()
        .enumerate()
        .map(|(index, at)| {
            let cell = ((at - low) / step).floor();
            (cell, ((at - low) / step - cell - 0.5).length_squared(), index)
        })
        .collect();
    let by_cell = |a: &(DVec2, f64, usize), b: &(DVec2, f64, usize)| {
        (a.0.x.total_cmp(&b.0.x)).then(a.0.y.total_cmp(&b.0.y))
    };
    cells.sort_unstable_by(|a, b| by_cell(a, b).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    cells.dedup_by(|a, b| by_cell(a, b) == Ordering::Equal);
    let mut kept: Vec<usize> = cells.into_iter().map(|(_, _, index)| index).collect();
    kept.sort_unstable();
    kept.into_iter().map(|index| uv[index]).collect()
}
