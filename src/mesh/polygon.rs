//! The intersection of a triangle of the parameters with a rectangle.

use glam::{BVec2, DVec2};

/// A triangle, or its intersection with a rectangle.
pub(super) struct Polygon {
    corners: [DVec2; 7],
    count: usize,
}

impl Polygon {
    /// The whole triangle.
    pub(super) fn of(triangle: [DVec2; 3]) -> Self {
        let mut corners = [DVec2::ZERO; 7];
        corners[..3].copy_from_slice(&triangle);
        Self { corners, count: 3 }
    }

    /// The corners, counter-clockwise if the triangle is.
    pub(super) fn corners(&self) -> &[DVec2] {
        &self.corners[..self.count]
    }

    /// Whether the polygon is more than a point or a segment.
    pub(super) fn has_area(&self) -> bool {
        self.count > 2
    }

    /// Transforms to coordinates in which the rectangle is the unit square.
    pub(super) fn stretch(&mut self, low: DVec2, high: DVec2) {
        self.corners.iter_mut().for_each(|corner| *corner = (*corner - low) / (high - low));
    }

    /// Clips the polygon at each side of a rectangle (I. E. Sutherland, G. W. Hodgman, 1974).
    pub(super) fn clip(&mut self, low: DVec2, high: DVec2) {
        for (axis, at, sign) in
            [(0, low.x, 1.0), (0, high.x, -1.0), (1, low.y, 1.0), (1, high.y, -1.0)]
        {
            let outside = |corner: &DVec2| sign * (corner[axis] - at) < 0.0;
            if !self.corners().iter().any(outside) {
                continue;
            }
            let (before, count) = (self.corners, self.count);
            self.count = 0;
            let mut push = |corner: DVec2| {
                if self.count == 0 || self.corners[self.count - 1] != corner {
                    self.corners[self.count] = corner;
                    self.count += 1;
                }
            };
            for k in 0..count {
                let (a, b) = (before[k], before[(k + 1) % count]);
                let (from, to) = (sign * (a[axis] - at), sign * (b[axis] - at));
                if from >= 0.0 {
                    push(a);
                }
                if from * to < 0.0 {
                    let mut cut = a.lerp(b, from / (from - to));
                    cut[axis] = at;
                    push(cut);
                }
            }
        }
    }
}

/// Whether the intersection of a triangle with a rectangle has no area.
///
/// That is the case if a side of one of them separates them.
pub(super) fn disjoint([a, b, c]: [DVec2; 3], low: DVec2, high: DVec2) -> bool {
    let all = |outside: fn(DVec2, DVec2) -> BVec2, end: DVec2| {
        (outside(a, end) & outside(b, end) & outside(c, end)).any()
    };
    if all(DVec2::cmpge, high) || all(DVec2::cmple, low) {
        return true;
    }
    [(a, b), (b, c), (c, a)].into_iter().any(|(a, b)| {
        let along = b - a;
        // The triangle is to the left of this side; (x, y) is the leftmost corner of the rectangle.
        let x = if along.y > 0.0 { low.x } else { high.x };
        let y = if along.x > 0.0 { high.y } else { low.y };
        along.perp_dot(DVec2::new(x, y) - a) <= 0.0
    })
}

/// Whether a point lies in a triangle or on its sides.
pub(super) fn contains([a, b, c]: [DVec2; 3], at: DVec2) -> bool {
    [(a, b), (b, c), (c, a)].into_iter().all(|(a, b)| (b - a).perp_dot(at - a) >= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(corners: &[DVec2]) -> f64 {
        let turn = |k: usize| corners[k].perp_dot(corners[(k + 1) % corners.len()]);
        (0..corners.len()).map(turn).sum::<f64>() / 2.0
    }

    #[test]
    fn the_clipped_parts_of_a_triangle_add_up_to_its_area() {
        let triangle = [DVec2::ZERO, DVec2::new(1.0, 0.1), DVec2::new(0.3, 1.0)];
        let cuts = [0.0, 0.25, 0.4, 1.0];
        let mut sum = 0.0;
        for (u, v) in cuts.windows(2).flat_map(|u| cuts.windows(2).map(move |v| (u, v))) {
            let (low, high) = (DVec2::new(u[0], v[0]), DVec2::new(u[1], v[1]));
            let mut part = Polygon::of(triangle);
            let disjoint = disjoint(triangle, low, high);
            part.clip(low, high);
            assert_ne!(disjoint, part.has_area());
            if !disjoint {
                sum += area(part.corners());
            }
        }
        assert!((sum - area(&triangle)).abs() < 1e-15);
    }

    #[test]
    fn a_triangle_contains_its_sides() {
        let triangle = [DVec2::ZERO, DVec2::X, DVec2::Y];
        assert!(contains(triangle, DVec2::splat(0.5)) && contains(triangle, DVec2::splat(0.1)));
        assert!(!contains(triangle, DVec2::splat(0.6)) && !contains(triangle, DVec2::NEG_Y));
    }

    #[test]
    fn clipping_a_larger_triangle_gives_the_rectangle() {
        let mut part =
            Polygon::of([DVec2::splat(-1.0), DVec2::new(4.0, -1.0), DVec2::new(-1.0, 4.0)]);
        part.clip(DVec2::ZERO, DVec2::ONE);
        assert_eq!((part.corners().len(), area(part.corners())), (4, 1.0));
    }
}
