//! The sides of a face's loops in a grid of boxes, to find those near a rectangle or a point.
//!
//! All coordinates are (u, v) scaled to lengths like those in space.

use glam::DVec2;

use super::outline::Outline;

/// Boxes along the longer side of the grid, for each square root of the number of sides.
const BOXES_PER_ROOT: f64 = 2.0;

/// Boxes along a side of the grid at most.
const MAX_BOXES: f64 = 512.0;

/// The sides in a grid.
#[derive(Debug)]
pub(super) struct SideGrid {
    low: DVec2,
    /// Boxes per length.
    density: f64,
    shape: (usize, usize),
    boxes: Vec<Vec<u32>>,
    sides: Vec<ScaledSide>,
}

#[derive(Clone, Copy, Debug)]
struct ScaledSide {
    ends: [DVec2; 2],
    bulge: f64,
}

impl SideGrid {
    pub(super) fn new(outline: &Outline, scale: DVec2) -> Self {
        let sides: Vec<ScaledSide> = outline
            .sides
            .iter()
            .map(|side| {
                let ends = side.nodes.map(|k| scale * outline.nodes[k].uv);
                ScaledSide { ends, bulge: side.bulge }
            })
            .collect();
        let ends = || sides.iter().flat_map(|side| side.ends);
        let low = ends().reduce(DVec2::min).unwrap_or_default();
        let size = ends().reduce(DVec2::max).unwrap_or_default() - low;
        let longest = size.max_element().max(f64::MIN_POSITIVE);
        let count = (BOXES_PER_ROOT * (sides.len() as f64).sqrt()).ceil().min(MAX_BOXES);
        let density = count / longest;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
        let boxes = |size: f64| (size * density).floor() as usize + 1;
        let shape = (boxes(size.x), boxes(size.y));
        let boxes = vec![vec![]; shape.0 * shape.1];
        let mut this = Self { low, density, shape, boxes, sides };
        for k in 0..this.sides.len() {
            let [a, b] = this.sides[k].ends;
            let (from, to) = this.range(a.min(b), a.max(b));
            for (i, j) in (from.0..=to.0).flat_map(|i| (from.1..=to.1).map(move |j| (i, j))) {
                let (low, high) = this.rectangle((i, j));
                if distance_from_rectangle([a, b], low, high) <= 0.1 / density {
                    this.boxes[i * shape.1 + j].push(u32::try_from(k).unwrap_or(u32::MAX));
                }
            }
        }
        this
    }

    /// The boxes that meet a rectangle.
    fn range(&self, low: DVec2, high: DVec2) -> ((usize, usize), (usize, usize)) {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let index = |at: f64, low: f64, count: usize| {
            ((at - low) * self.density).clamp(0.0, (count - 1) as f64) as usize
        };
        let at =
            |p: DVec2| (index(p.x, self.low.x, self.shape.0), index(p.y, self.low.y, self.shape.1));
        (at(low), at(high))
    }

    fn rectangle(&self, (i, j): (usize, usize)) -> (DVec2, DVec2) {
        let low = self.low + DVec2::new(i as f64, j as f64) / self.density;
        (low, low + 1.0 / self.density)
    }

    /// Whether a side comes near a rectangle, whose size is the length that near refers to: nearer
    /// than a `share` of the shorter of it and the side.
    pub(super) fn is_near(&self, low: DVec2, high: DVec2, size: f64, share: f64) -> bool {
        let margin = share * size;
        let (from, to) = self.range(low - margin, high + margin);
        let near = |k: &u32| {
            let ScaledSide { ends, bulge } = self.sides[*k as usize];
            let length = ends[0].distance(ends[1]);
            distance_from_rectangle(ends, low, high) <= share * size.min(length) + 2.0 * bulge
        };
        (from.0..=to.0)
            .any(|i| (from.1..=to.1).any(|j| self.boxes[i * self.shape.1 + j].iter().any(near)))
    }
}

/// A lower bound of the distance of a segment from a rectangle, zero if they meet.
fn distance_from_rectangle([a, b]: [DVec2; 2], low: DVec2, high: DVec2) -> f64 {
    // Separation along the axes and across the segment (H. Gottschalk et al., 1996).
    let gap = (low - a.max(b)).max(a.min(b) - high).max(DVec2::ZERO);
    let along = (b - a).normalize_or_zero();
    let (center, half) = (0.5 * (low + high), 0.5 * (high - low));
    let reach = half.x * along.y.abs() + half.y * along.x.abs();
    let across = along.perp_dot(center - a).abs() - reach;
    gap.length().max(across)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_that_miss_a_rectangle_have_a_distance() {
        let (low, high) = (DVec2::ZERO, DVec2::ONE);
        let distance =
            |a: (f64, f64), b: (f64, f64)| distance_from_rectangle([a.into(), b.into()], low, high);
        assert_eq!(distance((0.5, 0.5), (3.0, 3.0)), 0.0);
        assert_eq!(distance((2.0, 0.0), (3.0, 1.0)), 1.0);
        assert_eq!(distance((0.0, 1.5), (1.5, 0.0)), 0.0);
        assert!(distance((1.0, 1.5), (1.5, 1.0)) > 0.3);
    }
}
