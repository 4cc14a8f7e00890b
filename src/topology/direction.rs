//! The direction that heights have, of points that lie in no known position.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::cloud::{area, hull, least_rectangle, turned, upward};

/// Fewer points fill any rectangle by chance, and have hardly a slope.
pub(super) const FEWEST: usize = 300;

/// Points by which outlines are compared at most.
const MOST: usize = 2000;

/// Points to a cell along the sides of a rectangle, and cells at most.
const POINTS_PER_CELL: usize = 5;
const MOST_CELLS: usize = 32;

/// In how many n-ths one rectangle is filled better than another for that to be no chance.
const BY_CHANCE: f64 = 4.0;

/// The widest and narrowest step towards a better direction, as tangents of angles.
const WIDEST: f64 = 0.4;
const NARROWEST: f64 = 0.003;

/// The direction near this one across which points fill a rectangle: heights over one do so across no
/// other. This one, if none is clearly better.
pub(super) fn across_rectangle(points: &[DVec3], from: DVec3) -> DVec3 {
    if points.len() < FEWEST {
        return from;
    }
    let some = outlining(points);
    // Turned about one side of it, the rectangle of the heights stays four-sided.
    let cost = |up| {
        let (filled, sides) = filled(&some, up);
        (-filled, sides)
    };
    let best = least(from, cost);
    if filled(&some, best).0 > filled(&some, from).0 + by_chance(&some) {
        upward(best)
    } else {
        from
    }
}

/// Whether points fill the rectangle across a direction no worse than those across others.
pub(super) fn fills_as_well(points: &[DVec3], up: DVec3, others: [DVec3; 2]) -> bool {
    let some = outlining(points);
    let own = filled(&some, up).0 + by_chance(&some);
    others.iter().all(|&other| filled(&some, other).0 <= own)
}

/// The points by which outlines are compared.
fn outlining(points: &[DVec3]) -> Vec<DVec3> {
    points.iter().step_by(points.len().div_ceil(MOST).max(1)).copied().collect()
}

/// By how much one rectangle is filled better than another by chance.
fn by_chance(points: &[DVec3]) -> f64 {
    BY_CHANCE / points.len() as f64
}

/// How well the points' places across a direction fill the rectangle around them: the share that is in
/// their convex hull, and how near to its sides they reach all along them. And the directions of these sides.
fn filled(points: &[DVec3], up: DVec3) -> (f64, [DVec3; 2]) {
    let (first, second) = up.any_orthonormal_pair();
    let places: Vec<DVec2> =
        points.iter().map(|&point| DVec2::new(first.dot(point), second.dot(point))).collect();
    let hull = hull(&places);
    let (along, size) = least_rectangle(&hull);
    let low = hull.iter().map(|&place| turned(place, along)).fold(DVec2::INFINITY, DVec2::min);
    let cells = (places.len() / POINTS_PER_CELL).isqrt().clamp(1, MOST_CELLS);
    let mut gaps = vec![[1.0_f64; 4]; cells];
    for place in places {
        let at = (turned(place, along) - low) / size;
        let [x, y] = at.to_array().map(|at| cell(at, cells));
        for (cell, side, gap) in
            [(x, 0, at.y), (x, 1, 1.0 - at.y), (y, 2, at.x), (y, 3, 1.0 - at.x)]
        {
            gaps[cell][side] = gaps[cell][side].min(gap);
        }
    }
    let gaps = gaps.as_flattened();
    let gap = gaps.iter().sum::<f64>() / gaps.len() as f64;
    let side = |along: DVec2| along.x * first + along.y * second;
    (area(&hull) / size.element_product() - gap, [along, along.perp()].map(side))
}

/// In which of so many cells a place between 0 and 1 lies.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
fn cell(at: f64, cells: usize) -> usize {
    ((at * cells as f64) as usize).min(cells - 1)
}

/// The direction near this one with the least of a cost, which comes with two directions across it: by steps
/// both ways along these that become shorter where none of them helps (R. Hooke, T. A. Jeeves, *"Direct
/// search" solution of numerical and statistical
/// problems*, 1961).
pub(super) fn least(from: DVec3, cost: impl Fn(DVec3) -> (f64, [DVec3; 2]) + Sync) -> DVec3 {
    let (mut best, mut step) = (from, WIDEST);
    let (mut least, mut ways) = cost(from);
    while step >= NARROWEST {
        let [first, second] = ways;
        let around = [first, second, -first, -second].map(|way| (best + step * way).normalize());
        let costs: Vec<_> = around.par_iter().map(|&up| (cost(up), up)).collect();
        match costs.into_iter().min_by(|a, b| a.0.0.total_cmp(&b.0.0)) {
            Some(((less, across), up)) if less < least => {
                (least, ways, best) = (less, across, up);
            }
            _ => step *= 0.5,
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, EulerRot};

    use super::*;

    /// Steep heights over places that are scattered evenly over what `inside` leaves of a square.
    fn heights(inside: impl Fn(f64, f64) -> bool) -> Vec<DVec3> {
        let places = (0..1500)
            .map(f64::from)
            .map(|i| ((i * 0.754_877_666).fract(), (i * 0.569_840_291).fract()));
        let height = |x: f64, y: f64| 0.8 * y + 0.2 * (5.0 * x).sin() * (4.0 * y).cos();
        places.filter(|&(x, y)| inside(x, y)).map(|(x, y)| DVec3::new(x, y, height(x, y))).collect()
    }

    #[test]
    fn heights_over_a_rectangle_have_one_direction() {
        let turn = DQuat::from_euler(EulerRot::XYZ, 0.4, -0.9, 1.1);
        let points: Vec<DVec3> = heights(|_, _| true).iter().map(|&p| turn * p).collect();
        let up = upward(turn * DVec3::Z);
        for askew in [DVec3::new(0.2, 0.1, 1.0), DVec3::new(-0.1, -0.25, 1.0)] {
            let found = across_rectangle(&points, turn * askew.normalize());
            let apart = found.angle_between(up).to_degrees();
            assert!(apart < 1.5, "{apart}");
        }
    }

    #[test]
    fn few_points_tell_none_and_a_disc_fills_no_rectangle() {
        let from = DVec3::new(0.2, 0.1, 1.0).normalize();
        let few = heights(|x, _| x < 0.1);
        assert!(few.len() < FEWEST);
        assert_eq!(across_rectangle(&few, from), from);
        let disc = heights(|x, y| (x - 0.5).hypot(y - 0.5) < 0.5);
        let found = across_rectangle(&disc, from);
        assert!(filled(&disc, found).0 < 0.85);
    }
}
