//! Strips of the plane that bend at corners, like an L, a U or a Z.

use glam::DVec2;

use super::quadrilateral::Quadrilateral;

/// A strip from end to end, of quadrilaterals that share the sides where it bends: u goes along it, v
/// across.
#[derive(Clone, Debug)]
pub(crate) struct Arms {
    arms: Vec<Quadrilateral>,
    /// Where each arm begins, as a share of the whole length, and the end.
    ends: Vec<f64>,
}

impl Arms {
    /// Between stations, each a corner on the right of the strip and the one across.
    pub(crate) fn between(stations: &[[DVec2; 2]]) -> Self {
        let arm = |pair: &[[DVec2; 2]]| {
            let [[a, d], [b, c]] = [pair[0], pair[1]];
            Quadrilateral([a, b, c, d])
        };
        let arms: Vec<Quadrilateral> = stations.windows(2).map(arm).collect();
        let mut ends = vec![0.0];
        for arm in &arms {
            ends.push(ends[ends.len() - 1] + arm.lengths().0);
        }
        let length = ends[arms.len()];
        Self { arms, ends: ends.iter().map(|end| end / length).collect() }
    }

    /// The strip with these corners, counter-clockwise from the first on its right side.
    pub(super) fn within(outline: &[DVec2]) -> Self {
        let (half, last) = (outline.len() / 2, outline.len() - 1);
        let stations: Vec<[DVec2; 2]> =
            (0..half).map(|i| [outline[i], outline[last - i]]).collect();
        Self::between(&stations)
    }

    /// The corners, counter-clockwise from the first on the right side.
    pub(super) fn outline(&self) -> Vec<DVec2> {
        let first = self.arms.iter().take(1).map(|arm| arm.0[0]);
        let right = first.chain(self.arms.iter().map(|arm| arm.0[1]));
        let left = self.arms.iter().rev().map(|arm| arm.0[2]);
        right.chain(left).chain(self.arms.iter().take(1).map(|arm| arm.0[3])).collect()
    }

    pub(crate) fn arms(&self) -> &[Quadrilateral] {
        &self.arms
    }

    pub(crate) fn area(&self) -> f64 {
        self.arms.iter().map(Quadrilateral::area).sum()
    }

    /// How many times longer it is than wide.
    pub(crate) fn aspect(&self) -> f64 {
        let sizes = self.arms.iter().map(Quadrilateral::lengths);
        let (along, across) = sizes.fold((0.0, 0.0), |sum, size| (sum.0 + size.0, sum.1 + size.1));
        along * self.arms.len() as f64 / across
    }

    /// Where along u it bends.
    pub(crate) fn bends(&self) -> &[f64] {
        &self.ends[1..self.arms.len()]
    }

    /// The parameters of a place, beyond the unit square if it lies beside the strip.
    pub(crate) fn parameters(&self, place: DVec2) -> DVec2 {
        let inside = self.arms.iter().map(|arm| arm.inverse(place)).enumerate();
        let beyond = |uv: DVec2| (uv - 0.5).abs().max_element();
        let nearest = inside.min_by(|(_, a), (_, b)| beyond(*a).total_cmp(&beyond(*b)));
        let (arm, uv) = nearest.unwrap_or((0, DVec2::ZERO));
        DVec2::new(self.ends[arm] + uv.x * (self.ends[arm + 1] - self.ends[arm]), uv.y)
    }

    /// The place with parameters in the unit square.
    pub(super) fn place(&self, uv: DVec2) -> DVec2 {
        let arm = self.bends().partition_point(|&bend| bend < uv.x);
        let (start, end) = (self.ends[arm], self.ends[arm + 1]);
        self.arms[arm].place(DVec2::new((uv.x - start) / (end - start), uv.y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_and_places_are_inverse() {
        let at = |x: f64, y: f64| DVec2::new(x, y);
        let strip = Arms::between(&[
            [at(0.0, 3.0), at(1.0, 3.0)],
            [at(0.0, 0.0), at(1.0, 1.2)],
            [at(2.0, 0.0), at(2.0, 1.0)],
        ]);
        assert!(strip.area() > 0.0, "{}", strip.area());
        assert_eq!(Arms::within(&strip.outline()).outline(), strip.outline());
        for i in 0..=20 {
            for j in 0..=20 {
                let uv = DVec2::new(f64::from(i), f64::from(j)) / 20.0;
                assert!(strip.parameters(strip.place(uv)).distance(uv) < 1e-12, "{uv}");
            }
        }
        let bend = strip.place(at(strip.bends()[0], 0.0));
        assert!(strip.outline().contains(&bend), "{bend}");
    }
}
