//! Border points: those with a gap between the directions of their neighbors.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::settings::ObserveSettings;
use crate::cloud::{KdTree, Neighbor};

/// Whether each point has a wide gap between the directions of its neighbors in its tangent plane.
pub(super) fn border(
    tree: &KdTree<'_>,
    normals: &[DVec3],
    settings: &ObserveSettings,
) -> Vec<bool> {
    let points = tree.points();
    let open = |(found, angles): &mut (Vec<Neighbor>, Vec<f64>), at: u32| {
        let (a, b) = normals[at as usize].any_orthonormal_pair();
        tree.nearest_to(at, settings.border_neighbors, found);
        let way = |near: &Neighbor| {
            let way = points[near.index as usize] - points[at as usize];
            DVec2::new(way.dot(a), way.dot(b)).to_angle()
        };
        angles.clear();
        angles.extend(found.iter().map(way));
        widest_gap(angles) > settings.min_border_gap
    };
    let all: Vec<u32> = (0..).take(points.len()).collect();
    all.par_iter().map_init(Default::default, |scratch, &at| open(scratch, at)).collect()
}

/// The widest gap between angles. Sorts them.
fn widest_gap(angles: &mut [f64]) -> f64 {
    angles.sort_by(f64::total_cmp);
    let gaps = angles.windows(2).map(|pair| pair[1] - pair[0]);
    let around = angles.first().zip(angles.last()).map_or(TAU, |(low, high)| low + TAU - high);
    gaps.fold(around, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observe::Observations;

    #[test]
    fn a_square_has_border_points_and_a_ball_has_none() {
        let square: Vec<DVec3> =
            (0..400_u32).map(|i| DVec3::new(f64::from(i / 20), f64::from(i % 20), 0.0)).collect();
        let observations = Observations::of(&square, ObserveSettings::default());
        assert_eq!(observations.border().iter().filter(|open| **open).count(), 76);
        let ball: Vec<DVec3> = (0..1000)
            .map(|i| {
                let z = 1.0 - (f64::from(i) + 0.5) / 500.0;
                let turn = f64::from(i) * 2.399_963_229_728_653;
                DVec3::new(turn.cos(), turn.sin(), 0.0) * (1.0 - z * z).sqrt() + DVec3::Z * z
            })
            .collect();
        let observations = Observations::of(&ball, ObserveSettings::default());
        assert!(observations.border_share() * 1000.0_f64.sqrt() < 0.12);
    }
}
