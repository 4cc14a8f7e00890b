//! Groups of samples for cross-validation: blocks in space, and samples taken in turn.
//!
//! In tracks and clumps, samples left out in turn have near neighbors that predict them, so their
//! errors do not measure gaps. Blocks leave gaps.

use std::collections::{BTreeSet, HashMap};
use std::f64::consts::SQRT_2;

use glam::{DVec2, DVec3};

use rayon::prelude::*;

use super::settings::{FairnessSettings, LeastSquaresSettings};
use crate::numeric::mix;

const SETTINGS: FairnessSettings = FairnessSettings::STANDARD;
const LEAST_SQUARES: LeastSquaresSettings = LeastSquaresSettings::STANDARD;

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

/// Indices of points to leave out together, group by group, in turn. Groups that contain `enough`
/// points together suffice.
pub(super) fn points_in_turn(count: usize, enough: usize) -> Vec<Vec<usize>> {
    let step = count.div_ceil(LEAST_SQUARES.max_samples).max(1);
    let mut groups = vec![Vec::new(); SETTINGS.groups];
    for (i, group) in in_turn(count / step).into_iter().enumerate() {
        groups[group].push(step * i);
    }
    sufficient(groups, enough)
}

/// Places in the plane by the square cells of a grid, which are as wide as the gaps between rows,
/// tracks and clumps of places.
///
/// The grid is the finest of which the places occupy most cells, with at most as many cells as
/// places.
pub(super) struct GapCells {
    /// The cells with their places, cell by cell.
    order: Vec<([u32; 2], usize)>,
    /// Whether places lie in rows, tracks or clumps with gaps between.
    pub(super) has_gaps: bool,
}

impl GapCells {
    /// The cells of places from 0 to `size`.
    pub(super) fn of(places: &[DVec2], size: DVec2) -> Self {
        let finest = (size.x * size.y / places.len() as f64).sqrt();
        let mut width = finest;
        loop {
            let order = in_cells(places, width);
            let cells = (size / width).max(DVec2::ONE).element_product();
            if occupied(&order) >= SETTINGS.min_occupied * cells || cells <= SETTINGS.groups as f64
            {
                return Self { order, has_gaps: width > finest };
            }
            width *= SQRT_2;
        }
    }

    /// Indices of places to leave out together, group by group. Groups that contain `enough` places
    /// together suffice.
    ///
    /// Cells are in the order of a hash: a regular pattern could leave out whole rows. Cells that
    /// end a row and a column of cells behind a gap always stay, since nothing predicts them.
    pub(super) fn groups(&self, enough: usize) -> Vec<Vec<usize>> {
        // Of many places, smaller groups suffice.
        let parts = SETTINGS.groups * self.order.len().div_ceil(LEAST_SQUARES.max_samples).max(1);
        let lines = [0, 1].map(|axis| self.lines(axis));
        let predicted = |cell: [u32; 2]| {
            let mut axes = lines.iter().zip(cell).zip([cell[1], cell[0]]);
            axes.any(|((lines, along), across)| {
                let before = lines[&across].range(..along).next_back();
                let after = lines[&across].range(along + 1..).next();
                let adjacent = [before.map(|at| along - at), after.map(|at| at - along)];
                adjacent.contains(&Some(1)) || (before.is_some() && after.is_some())
            })
        };
        let cells = self.order.chunk_by(|(a, _), (b, _)| a == b);
        let mut cells: Vec<_> = cells.filter(|cell| predicted(cell[0].0)).collect();
        cells.sort_by_cached_key(|cell| mix(mix(cell[0].0[0].into()) ^ u64::from(cell[0].0[1])));
        let mut groups = vec![Vec::new(); SETTINGS.groups];
        for (rank, cell) in cells.into_iter().enumerate() {
            if let Some(members) = groups.get_mut(rank % parts) {
                members.extend(cell.iter().map(|(_, index)| *index));
            }
        }
        sufficient(groups, enough)
    }

    /// The places of occupied cells along an axis, by their place across it.
    fn lines(&self, axis: usize) -> HashMap<u32, BTreeSet<u32>> {
        let mut lines: HashMap<u32, BTreeSet<u32>> = HashMap::new();
        for cell in self.order.chunk_by(|(a, _), (b, _)| a == b).map(|cell| cell[0].0) {
            lines.entry(cell[1 - axis]).or_default().insert(cell[axis]);
        }
        lines
    }
}

/// The first groups that contain `enough` members together, without empty ones.
fn sufficient(mut groups: Vec<Vec<usize>>, enough: usize) -> Vec<Vec<usize>> {
    let mut count = 0;
    groups.retain(|group| {
        let more = count < enough && !group.is_empty();
        count += group.len();
        more
    });
    groups
}

/// Places by the cells of a grid of this width, cell by cell.
fn in_cells(places: &[DVec2], width: f64) -> Vec<([u32; 2], usize)> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "of a small grid")]
    let cell = |place: &DVec2| (*place / width).to_array().map(|at| at as u32);
    let mut order: Vec<([u32; 2], usize)> =
        places.par_iter().enumerate().map(|(i, place)| (cell(place), i)).collect();
    order.par_sort_unstable();
    order
}

/// The number of different cells.
fn occupied(order: &[([u32; 2], usize)]) -> f64 {
    order.chunk_by(|(a, _), (b, _)| a == b).count() as f64
}

/// Whether samples with parameters in the unit square lie in clumps, rows or tracks with empty
/// areas between.
pub(super) fn in_clumps(uv: &[DVec2]) -> bool {
    let count = uv.len() as f64;
    occupied(&in_cells(uv, count.sqrt().recip())) < SETTINGS.min_occupied * count
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scattered(count: u32) -> Vec<DVec2> {
        let place = |i: u32| {
            let at = f64::from(i);
            DVec2::new((at * 0.754_877_666_246).fract(), (at * at * 0.569_840_290_998).fract())
        };
        (0..count).map(place).collect()
    }

    #[test]
    fn blocks_contain_neighbors_and_every_group_has_samples() {
        let points: Vec<DVec3> = scattered(2000).iter().map(|uv| uv.extend(0.0)).collect();
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
        assert!(!in_clumps(&scattered(500)));
        assert!(in_clumps(&tracks(5, 500)));
    }

    /// Places along tracks at equal distances.
    fn tracks(count: u32, places: u32) -> Vec<DVec2> {
        let gaps = f64::from(count - 1);
        let track =
            |uv: &DVec2| DVec2::new(((gaps * uv.x).round() + 0.02 * uv.x) / (gaps + 0.1), uv.y);
        scattered(places).iter().map(track).collect()
    }

    #[test]
    fn cells_of_scattered_places_are_as_small_as_their_spacing() {
        let cells = GapCells::of(&scattered(3000), DVec2::ONE);
        assert!(!cells.has_gaps);
        let groups = cells.groups(usize::MAX);
        assert_eq!(groups.len(), SETTINGS.groups);
        let mut all = groups.concat();
        all.sort_unstable();
        all.dedup();
        // Few are alone at the border.
        assert!(all.len() > 2950 && all.len() == groups.concat().len(), "{}", all.len());
        let few = cells.groups(1000).concat().len();
        assert!((1000..1800).contains(&few), "{few}");
    }

    #[test]
    fn cells_of_tracks_are_as_wide_as_the_gaps_between_them() {
        // The tracks are long, or their distances are.
        for (size, count) in [(DVec2::ONE, 15), (DVec2::new(40.0, 1.0), 15)] {
            let places: Vec<DVec2> = tracks(count, 6000).iter().map(|uv| *uv * size).collect();
            let cells = GapCells::of(&places, size);
            assert!(cells.has_gaps);
            let all = cells.order.chunk_by(|(a, _), (b, _)| a == b);
            let length = |cell: &[([u32; 2], usize)]| {
                let along = cell.iter().map(|(_, i)| places[*i].y);
                along.clone().fold(0.0, f64::max) - along.fold(f64::INFINITY, f64::min)
            };
            let longest = all.map(length).fold(0.0, f64::max);
            let gap = size.x / f64::from(count - 1);
            assert!(longest > 0.5 * gap.min(size.y) && longest < 1.5 * gap, "{longest} {gap}");
        }
    }

    #[test]
    fn sweeps_at_the_ends_stay() {
        // Five sweeps across a long strip: the first and the last cannot be predicted.
        let sweep = |i: u32| DVec2::new(f64::from(i % 5) * 200.0, 0.2 * f64::from(i / 5));
        let places: Vec<DVec2> = (0..500).map(sweep).collect();
        let cells = GapCells::of(&places, DVec2::new(801.0, 20.0));
        let mut found: Vec<usize> = cells.groups(usize::MAX).concat();
        found.sort_unstable();
        let inside = (0..500).filter(|i| !matches!(i % 5, 0 | 4));
        assert_eq!(found, inside.collect::<Vec<_>>());
    }

    #[test]
    fn points_in_turn_are_enough() {
        assert_eq!(points_in_turn(20, usize::MAX).concat().len(), 20);
        assert_eq!(points_in_turn(20_000, 2000).concat().len(), 4000);
        assert_eq!(points_in_turn(200_000, 2000).concat().len(), 4000);
    }
}
