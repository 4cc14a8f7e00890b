//! Points in lines: scan lines, which lie farther apart than the points along them.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::even_sample::even_sample;
use super::kd_tree::{KdTree, Neighbor};
use super::neighborhoods::{NEIGHBORS, Neighborhoods};
use super::plane::Plane;

/// Share of the points in lines from which on the cloud is one of lines, and below which it is none.
const MOSTLY: f64 = 0.5;
const HARDLY: f64 = 0.1;

/// Fewer points show no surface, and whether points lie in lines so many of them tell.
const FEWEST: usize = 100;
const TELLING: usize = 500;

/// Mean distance of points to their neighbours, in that between ropes, from which on they lie as far apart along
/// these.
const AS_FAR: f64 = 0.8;

/// Points by which a rope is seen to be one, if it bends or if it is thick, and as how many ropes a surface is
/// known at least.
const OF_ROPE: [usize; 2] = [64, 32];
const ROPES: usize = 5;

/// Some of the points, evenly over space, that lie about as far apart along lines as the lines do, if they lie
/// in lines. These show at a scale between that of the noise and their own distance; seen closer they are
/// ropes, and seen from farther away a surface. What is near each of them may be known; how far ropes are
/// `apart` is for others to say.
pub(crate) fn across_lines(
    points: &[DVec3],
    mut known: Option<&Neighborhoods>,
    apart: Option<f64>,
) -> Option<Vec<DVec3>> {
    let (mut few, mut in_lines) = (points.to_vec(), apart.is_some());
    while few.len() >= FEWEST {
        let seen = Seen::of(&few, known.take());
        let far = apart.is_none_or(|apart| seen.spacing >= AS_FAR * apart);
        if in_lines && far && seen.in_lines < HARDLY {
            return Some(few);
        }
        in_lines |= seen.in_lines > MOSTLY;
        few = even_sample(&few, few.len() / 2);
    }
    None
}

/// Whether points are those of a surface in ropes, as most of these groups are: lines, if seen alone and from
/// some way off. Numbers of groups are below that of the points.
pub(super) fn are_ropes(points: &[DVec3], groups: &[u32]) -> bool {
    let mut members: Vec<Vec<DVec3>> = vec![Vec::new(); points.len()];
    groups.iter().zip(points).for_each(|(group, point)| members[*group as usize].push(*point));
    let is_line = |members: &[DVec3], seen: usize| {
        Seen::of(&even_sample(members, seen), None).in_lines > MOSTLY
    };
    members.retain(|members| members.len() > NEIGHBORS);
    // Of most clouds there is one group, which need not be looked at.
    if members.len() < ROPES {
        return false;
    }
    members.retain(|members| OF_ROPE.iter().any(|&seen| is_line(members, seen)));
    let count: usize = members.iter().map(Vec::len).sum();
    members.len() >= ROPES && count as f64 > MOSTLY * points.len() as f64
}

/// How points lie beside one another.
struct Seen {
    /// How many have their neighbours in a line with them.
    in_lines: f64,
    /// Mean distance to these.
    spacing: f64,
}

impl Seen {
    /// Of points around which may be known what is near.
    fn of(points: &[DVec3], known: Option<&Neighborhoods>) -> Self {
        let step = points.len().div_ceil(TELLING);
        let telling: Vec<u32> = (0..).zip(points).step_by(step).map(|(index, _)| index).collect();
        let seen: Vec<DVec2> = if let Some(Neighborhoods { near, planes }) = known {
            let look = |index: u32| beside(&planes[index as usize], &near[index as usize]);
            telling.into_iter().map(look).collect()
        } else {
            let tree = KdTree::new(points);
            let look = |near: &mut Vec<Neighbor>, index: u32| {
                tree.nearest_to(index, NEIGHBORS, near);
                let all = near.iter().map(|near| near.index).chain([index]);
                beside(&Plane::of(all.map(|at| points[at as usize])), near)
            };
            telling.into_par_iter().map_init(Vec::new, look).collect()
        };
        let DVec2 { x: in_lines, y: spacing } = seen.iter().sum::<DVec2>() / seen.len() as f64;
        Self { in_lines, spacing }
    }
}

/// Whether those near a point lie in a line with it, and their mean distance.
fn beside(plane: &Plane, near: &[Neighbor]) -> DVec2 {
    let spacing = near.iter().map(Neighbor::distance).sum::<f64>() / near.len() as f64;
    DVec2::new(f64::from(plane.is_line()), spacing)
}

#[cfg(test)]
mod tests {
    use super::super::pieces_across;
    use super::*;
    use crate::progress::Silent;

    /// A bent sheet of 20 by 200 places, with rows that lie ten times farther apart than the points in them, or
    /// of as many that are scattered.
    fn sheet(lines: bool) -> Vec<DVec3> {
        let place = |i: u32| {
            let scattered = (f64::from(i) * 0.754_877_666).fract();
            let row = (f64::from(i / 200) + 0.5) / 20.0;
            let along = (f64::from(i) * 0.569_840_291).fract();
            (if lines { row } else { scattered }, along)
        };
        let noise = |i: u32| 0.002 * ((f64::from(i) * 0.618_034).fract() - 0.5);
        let point = |i| {
            let (x, y) = place(i);
            DVec3::new(x, y + noise(3 * i), 0.3 * (3.0 * x).sin() + noise(i))
        };
        (0..4000).map(point).collect()
    }

    #[test]
    fn of_scan_lines_points_are_left_that_show_a_surface() {
        let few = across_lines(&sheet(true), None, None).unwrap();
        assert!((FEWEST..1500).contains(&few.len()), "{}", few.len());
        assert!(
            Seen::of(&sheet(true), None).in_lines > MOSTLY
                && Seen::of(&few, None).in_lines < HARDLY
        );
    }

    /// Rows of points, so noisy that no neighbours lie in a line.
    fn ropes() -> Vec<DVec3> {
        let point = |i: u32| {
            let noise = |k: u32| 0.01 * (f64::from((3 * i + k) * 7919 % 10_007)).sin();
            let (row, along) = (f64::from(i / 1000) / 12.0, f64::from(i % 1000) / 1000.0);
            DVec3::new(row + noise(0), along, 0.3 * (3.0 * row).sin() + noise(1))
        };
        (0..12_000).map(point).collect()
    }

    #[test]
    fn ropes_are_pieces_of_a_surface_only_if_it_is_apart() {
        let one = ropes();
        assert!(Seen::of(&one, None).in_lines < HARDLY);
        let (found, few) = pieces_across(&one, &mut Silent).unwrap();
        assert_eq!(found.sizes, [12_000]);
        assert!((FEWEST..1500).contains(&few.unwrap().len()));
        let two: Vec<DVec3> = one.iter().flat_map(|&p| [p, p + 2.0 * DVec3::X]).collect();
        let (found, few) = pieces_across(&two, &mut Silent).unwrap();
        assert_eq!(found.sizes, [12_000; 2]);
        assert!(few.is_some());
        // From the last row to the first of the other.
        assert!((found.gap - (2.0 - 11.0 / 12.0)).abs() < 0.02, "{}", found.gap);
    }

    #[test]
    fn a_few_ropes_are_pieces() {
        let few: Vec<DVec3> = ropes().into_iter().filter(|point| point.x < 0.3).collect();
        let (found, _) = pieces_across(&few, &mut Silent).unwrap();
        assert_eq!(found.sizes, [1000; 4]);
    }

    #[test]
    fn scattered_points_and_one_line_are_no_lines_beside_one_another() {
        assert!(across_lines(&sheet(false), None, None).is_none());
        let line: Vec<DVec3> = (0..1000).map(|i| DVec3::X * f64::from(i)).collect();
        assert!(across_lines(&line, None, None).is_none());
    }
}
