//! Points in lines: scan lines, which lie farther apart than the points along them.

use glam::DVec3;
use rayon::prelude::*;

use super::even_sample::EvenSample;
use super::kd_tree::KdTree;
use super::plane::Plane;

/// Neighbours by which a point is seen to lie in a line.
const NEIGHBORS: usize = 8;

/// Share of the points in lines from which on the cloud is one of lines, and below which it is none.
const MOSTLY: f64 = 0.5;
const HARDLY: f64 = 0.1;

/// Fewer points show no surface, and whether points lie in lines so many of them tell.
const FEWEST: usize = 100;
const TELLING: usize = 500;

/// Some of the points, evenly over space, that lie about as far apart along lines as the lines do, if they lie
/// in lines. These show at a scale between that of the noise and their own distance; seen closer they are
/// ropes, and seen from farther away a surface.
pub(crate) fn across_lines(points: &[DVec3]) -> Option<Vec<DVec3>> {
    let (mut few, mut in_lines) = (points.to_vec(), false);
    while few.len() >= FEWEST {
        let share = share_in_lines(&few);
        if in_lines && share < HARDLY {
            return Some(few);
        }
        in_lines |= share > MOSTLY;
        let mut sample = EvenSample::new(few.len() / 2);
        sample.extend(&few);
        few = sample.points();
    }
    None
}

/// How many of the points have their neighbours in a line with them.
fn share_in_lines(points: &[DVec3]) -> f64 {
    let tree = KdTree::new(points);
    let is_in_line = |index: u32| {
        let mut near = Vec::new();
        tree.nearest_to(index, NEIGHBORS, &mut near);
        let all = near.iter().map(|near| near.index).chain([index]);
        Plane::of(all.map(|at| points[at as usize])).is_line()
    };
    let step = points.len().div_ceil(TELLING);
    let telling: Vec<u32> = (0..).zip(points).step_by(step).map(|(index, _)| index).collect();
    let count = telling.par_iter().filter(|index| is_in_line(**index)).count();
    count as f64 / telling.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let few = across_lines(&sheet(true)).unwrap();
        assert!((FEWEST..1500).contains(&few.len()), "{}", few.len());
        assert!(share_in_lines(&sheet(true)) > MOSTLY && share_in_lines(&few) < HARDLY);
    }

    #[test]
    fn scattered_points_and_one_line_are_no_lines_beside_one_another() {
        assert!(across_lines(&sheet(false)).is_none());
        let line: Vec<DVec3> = (0..1000).map(|i| DVec3::X * f64::from(i)).collect();
        assert!(across_lines(&line).is_none());
    }
}
