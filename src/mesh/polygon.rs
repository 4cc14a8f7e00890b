//! What triangles and segments of the parameters have in common with a rectangle.

use glam::DVec2;

/// A triangle, or what is left of it within a rectangle.
pub(super) struct Polygon {
    corners: [DVec2; 7],
    count: usize,
}

impl Polygon {
    pub(super) fn of(triangle: [DVec2; 3]) -> Self {
        let mut corners = [DVec2::ZERO; 7];
        corners[..3].copy_from_slice(&triangle);
        Self { corners, count: 3 }
    }

    pub(super) fn corners(&self) -> &[DVec2] {
        &self.corners[..self.count]
    }

    /// Whether it has no area in common with a rectangle: a side of one of them has all of the
    /// other one on its outer side.
    pub(super) fn misses(&self, low: DVec2, high: DVec2) -> bool {
        let corners = self.corners();
        let (mut least, mut most) = (corners[0], corners[0]);
        for &corner in corners {
            (least, most) = (least.min(corner), most.max(corner));
        }
        if least.cmpge(high).any() || most.cmple(low).any() {
            return true;
        }
        (0..corners.len()).any(|k| {
            let (a, along) = (corners[k], corners[(k + 1) % corners.len()] - corners[k]);
            // The rectangle's corner that is furthest to the left, where the polygon lies.
            let x = if along.y > 0.0 { low.x } else { high.x };
            let y = if along.x > 0.0 { high.y } else { low.y };
            along.perp_dot(DVec2::new(x, y) - a) <= 0.0
        })
    }

    /// Moves to where a rectangle is the unit square.
    pub(super) fn stretch(&mut self, low: DVec2, high: DVec2) {
        self.corners.iter_mut().for_each(|corner| *corner = (*corner - low) / (high - low));
    }

    /// Cuts off what lies outside a rectangle, side by side (I. E. Sutherland, G. W. Hodgman, 1974).
    pub(super) fn clip(&mut self, low: DVec2, high: DVec2) {
        for (axis, at, sign) in
            [(0, low.x, 1.0), (0, high.x, -1.0), (1, low.y, 1.0), (1, high.y, -1.0)]
        {
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

/// The part of a segment within a rectangle, if there is one.
pub(super) fn clip((a, b): (DVec2, DVec2), low: DVec2, high: DVec2) -> Option<(DVec2, DVec2)> {
    let along = b - a;
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let (x, step) = (a[axis], along[axis]);
        if step == 0.0 {
            if x < low[axis] || x > high[axis] {
                return None;
            }
            continue;
        }
        let (s, t) = ((low[axis] - x) / step, (high[axis] - x) / step);
        from = from.max(s.min(t));
        to = to.min(s.max(t));
    }
    let at = |t: f64| if t == 1.0 { b } else { (a + t * along).clamp(low, high) };
    (from < to).then(|| (at(from), at(to)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(corners: &[DVec2]) -> f64 {
        let turn = |k: usize| corners[k].perp_dot(corners[(k + 1) % corners.len()]);
        (0..corners.len()).map(turn).sum::<f64>() / 2.0
    }

    #[test]
    fn the_parts_of_a_triangle_add_up() {
        let triangle = [DVec2::ZERO, DVec2::new(1.0, 0.1), DVec2::new(0.3, 1.0)];
        let cuts = [0.0, 0.25, 0.4, 1.0];
        let (mut sum, mut length) = (0.0, 0.0);
        for (u, v) in cuts.windows(2).flat_map(|u| cuts.windows(2).map(move |v| (u, v))) {
            let (low, high) = (DVec2::new(u[0], v[0]), DVec2::new(u[1], v[1]));
            let mut part = Polygon::of(triangle);
            let misses = part.misses(low, high);
            part.clip(low, high);
            assert_eq!(misses, part.corners().len() < 3);
            if !misses {
                sum += area(part.corners());
            }
            let inside = clip((triangle[1], triangle[2]), low, high);
            length += inside.map_or(0.0, |(a, b)| a.distance(b));
        }
        assert!((sum - area(&triangle)).abs() < 1e-15);
        assert!((length - triangle[1].distance(triangle[2])).abs() < 1e-15);
    }

    #[test]
    fn a_rectangle_within_a_triangle_stays_whole() {
        let mut part =
            Polygon::of([DVec2::splat(-1.0), DVec2::new(4.0, -1.0), DVec2::new(-1.0, 4.0)]);
        part.clip(DVec2::ZERO, DVec2::ONE);
        assert_eq!((part.corners().len(), area(part.corners())), (4, 1.0));
    }
}
