//! Groups of samples for cross-validation: blocks in space, and samples taken in turn.
//!
//! In tracks and clumps, samples left out in turn have near neighbors that predict them, so their
//! errors do not measure gaps. Blocks leave gaps.

use glam::{DVec2, DVec3};

use super::settings::FairnessSettings;

const SETTINGS: FairnessSettings = FairnessSettings::STANDARD;

/// The group of each point, by two rules. Groups of blocks leave gaps as wide as those between
/// tracks, sweeps and clumps of points; groups in turn do not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ValidationGroups {
    /// Groups of points taken in turn.
    pub in_turn: Vec<usize>,
    /// Groups of blocks in space.
    pub blocks: Vec<usize>,
}

impl ValidationGroups {
    /// The groups of points in an order that follows no direction.
    #[must_use]
    pub fn of(points: &[DVec3]) -> Self {
        Self { in_turn: in_turn(points.len()), blocks: blocks(points) }
    }
}

/// The group of each sample, by blocks. Farthest-point sampling selects seeds; the samples nearest
/// to each seed are a block, and blocks are assigned to the groups in turn. O(samples · seeds).
pub(super) fn blocks(points: &[DVec3]) -> Vec<usize> {
    let seeds = (points.len() / SETTINGS.blocks_per_group)
        .clamp(3 * SETTINGS.groups, SETTINGS.blocks_per_group * SETTINGS.groups);
    let center = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let mut squares: Vec<f64> = points.iter().map(|point| point.distance_squared(center)).collect();
    let mut groups = vec![0; points.len()];
    for seed in 0..seeds.min(points.len()) {
        let farthest = (0..points.len()).max_by(|&a, &b| squares[a].total_cmp(&squares[b]));
        let Some(place) = farthest.map(|at| points[at]) else { break };
        if seed == 0 {
            squares.fill(f64::INFINITY);
        }
        for ((point, square), group) in points.iter().zip(&mut squares).zip(&mut groups) {
            let apart = point.distance_squared(place);
            if apart < *square {
                (*square, *group) = (apart, seed % SETTINGS.groups);
            }
        }
    }
    groups
}

/// The group of each of `count` samples in turn, by a stride that is coprime to usual row lengths
/// of grids.
pub(super) fn in_turn(count: usize) -> Vec<usize> {
    (0..count).map(|i| (i * 7 + i / SETTINGS.groups) % SETTINGS.groups).collect()
}

/// Whether samples with parameters in the unit square lie in clumps, rows or tracks with empty
/// areas between.
pub(super) fn in_clumps(uv: impl ExactSizeIterator<Item = DVec2>) -> bool {
    let count = uv.len() as f64;
    let side = count.sqrt();
    #[expect(clippy::cast_possible_truncation, reason = "a share of a small number")]
    let cell = |uv: DVec2| (uv * side).to_array().map(|at| at as i64);
    let mut cells: Vec<[i64; 2]> = uv.map(cell).collect();
    cells.sort_unstable();
    cells.dedup();
    (cells.len() as f64) < SETTINGS.min_occupied * count
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scattered(count: u32) -> impl ExactSizeIterator<Item = DVec2> {
        let place = |i: u32| {
            let at = f64::from(i);
            DVec2::new((at * 0.754_877_666_246).fract(), (at * at * 0.569_840_290_998).fract())
        };
        (0..count).map(place)
    }

    #[test]
    fn blocks_contain_neighbors_and_every_group_has_samples() {
        let points: Vec<DVec3> = scattered(2000).map(|uv| uv.extend(0.0)).collect();
        let groups = blocks(&points);
        for group in 0..SETTINGS.groups {
            let count = groups.iter().filter(|found| **found == group).count();
            assert!((200..700).contains(&count), "{group} {count}");
        }
        let nearest = |i: usize| {
            let others = (0..2000).filter(|j| *j != i);
            let apart = |j: &usize| points[i].distance_squared(points[*j]);
            others.min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap()
        };
        let alike = (0..200).filter(|&i| groups[i] == groups[nearest(i)]).count();
        assert!(alike > 160, "{alike}");
    }

    #[test]
    fn tracks_are_clumps_and_scattered_samples_are_not() {
        assert!(!in_clumps(scattered(500)));
        let track = |uv: DVec2| DVec2::new(((4.0 * uv.x).round() + 0.02 * uv.x) / 4.1, uv.y);
        assert!(in_clumps(scattered(500).map(track)));
    }
}
