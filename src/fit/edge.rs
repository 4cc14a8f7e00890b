//! The smooth curve at which points end, most likely.

use super::dense::Dense;
use crate::error::Result;
use crate::nurbs::{Basis, KnotVector, gauss};

const DEGREE: usize = 3;

/// How far an edge follows the places.
struct Flexibility {
    control_points: usize,
    /// What bending costs beside the area that the edge leaves outside: at 10 a second difference of
    /// 0.1 between control points counts as much as a twentieth of the unit square.
    stiffness: f64,
    /// It does not go deeper.
    deepest: f64,
    /// Places deeper than this cannot touch it.
    near: f64,
    /// Depth of the ground whose places say how dense they are there; without, they are as dense
    /// everywhere.
    ground: Option<f64>,
}

/// Rounded corners are covered by the surface's corners rather than followed into them.
const FIRM: Flexibility =
    Flexibility { control_points: 8, stiffness: 10.0, deepest: 0.1, near: 0.4, ground: Some(0.15) };

/// Notches are followed, if not into their corners, whose parameters would crowd.
const SUPPLE: Flexibility =
    Flexibility { control_points: 10, stiffness: 1.0, deepest: 0.3, near: 0.7, ground: None };

/// Least density of places on the ground, as a share of the mean: it keeps an edge in bounds. That of
/// so many control points at either end is higher: drawn in hardly at all, an edge would leave much of
/// a rounded corner to the surface; drawn in fully, it would bend and cut off places beside the corner.
const SPARSEST: f64 = 0.02;
const SPARSEST_AT_CORNERS: f64 = 0.85;
const CORNER: usize = 2;

/// How far a surface goes beyond an edge: so many spacings of the points, and standard deviations of
/// where the edge lies, for each spacing of border that is asked for. With half a spacing of border
/// the surface seldom ends before the points' ground does, and goes 0.4 to 0.5 spacings beyond on
/// average.
const BEYOND: (f64, f64) = (0.5, 4.0);

/// Share of the mean density below which places are those of a rounded corner.
const SPARSE: f64 = 0.3;

/// Strips of the square in which the ground under the lowest place is looked at, but those at either
/// end, where corners are rounded; and its mean height, beyond what chance leaves, from which on the
/// edge has a notch. Without any it is at most half of that, and two to seven times at the reentrant
/// corner of an L.
const STRIPS: usize = 24;
const ENDS: usize = 4;
const NOTCHED: f64 = 0.03;

/// An edge does not go farther out than this.
const OUTERMOST: f64 = -0.5;

/// Scale of the blur that the search begins with, and what is left of it each time.
const FIRST_SCALE: f64 = 0.05;
const LEFT_OF_SCALE: f64 = 0.4;

/// Places that a blurred edge is looked for with at most: it only leads towards the last one.
const BLURRED: usize = 500;

/// Standard deviation of the normal distribution to the scale of the logistic one with the same:
/// √3 / π.
const LOGISTIC: f64 = 0.551_328_895_421_792;

/// Scales behind an edge at which a place no longer touches it.
const UNTOUCHED: f64 = 30.0;

/// Newton's steps for each scale at most, the share of a scale that the last of them moves, and the
/// times that a step which leads down is shortened.
const STEPS: usize = 6;
const SETTLED: f64 = 0.1;
const SHORTENINGS: usize = 8;
const SHORTENING: f64 = 0.4;

/// Share of the mean diagonal that holds control points which no place touches.
const RIDGE: f64 = 1e-6;

/// A smooth curve, y over x in [0, 1].
pub(super) struct Edge {
    knots: KnotVector,
    heights: Vec<f64>,
    deepest: f64,
    /// Standard deviations of the heights there, and spacings of the places as multiples of the mean.
    doubts: Vec<(f64, f64)>,
}

/// A place by the basis functions at its x, and its y.
struct Place {
    basis: Basis<4>,
    y: f64,
}

impl Edge {
    /// The height, which rounding does not take beyond the bounds either.
    pub(super) fn at(&self, x: f64) -> f64 {
        height(&self.heights, &Basis::at(&self.knots, x)).clamp(OUTERMOST, self.deepest)
    }

    /// How far beyond the edge a surface should go on at each x, for a border of this many spacings.
    pub(super) fn margin(&self, border: f64, spacing: f64) -> impl Fn(f64) -> f64 {
        let (plain, doubtful) = BEYOND;
        let beyond = |&(deviation, spread): &(f64, f64)| {
            border * spread * (plain * spacing + doubtful * deviation)
        };
        let margins: Vec<f64> = self.doubts.iter().map(beyond).collect();
        move |x| height(&margins, &Basis::at(&self.knots, x))
    }

    /// The curve that most likely bounds places (x, y) of the unit square from below, if their y
    /// are blurred by noise of this size. A closed edge comes round in x.
    ///
    /// Places are a Poisson process whose density rises from 0 to n across the edge as the logistic
    /// function does. The logarithm of its likelihood, the sum of ln logistic((y - edge) / scale)
    /// plus n times the area under the edge, is concave, and so is what bending costs.
    pub(super) fn under(places: &[(f64, f64)], noise: f64, closed: bool) -> Result<Self> {
        let firm = Self::likeliest(places, noise, closed, &FIRM)?;
        if firm.empty_ground(places) < NOTCHED {
            return Ok(firm);
        }
        Self::likeliest(places, noise, closed, &SUPPLE)
    }

    /// Whether it follows a notch.
    pub(super) fn is_notched(&self) -> bool {
        self.deepest > FIRM.deepest
    }

    /// Mean height between the edge and the lowest place in each strip, beyond what chance leaves.
    fn empty_ground(&self, places: &[(f64, f64)]) -> f64 {
        let count = places.len();
        let places = lowest(places.iter().copied(), STRIPS);
        let inner = places[ENDS..STRIPS - ENDS].iter().flatten();
        let above = inner.clone().map(|&(x, y)| (y - self.at(x)).max(0.0));
        above.sum::<f64>() / inner.count().max(1) as f64 - STRIPS as f64 / count as f64
    }

    fn likeliest(
        places: &[(f64, f64)],
        noise: f64,
        closed: bool,
        flexibility: &'static Flexibility,
    ) -> Result<Self> {
        let &Flexibility { control_points, deepest, near, .. } = flexibility;
        let knots = if closed {
            KnotVector::periodic_uniform(DEGREE, control_points)?
        } else {
            KnotVector::clamped_uniform(DEGREE, control_points)?
        };
        let count = places.len() as f64;
        let near = places.iter().filter(|place| place.1 < near);
        let mut near: Vec<Place> =
            near.map(|&(x, y)| Place { basis: Basis::at(&knots, x), y }).collect();
        near.sort_by(|a, b| a.y.total_cmp(&b.y));
        let lowest = places.iter().map(|place| place.1).fold(f64::INFINITY, f64::min);
        let areas = areas(&knots, control_points);
        let even: Vec<f64> = areas.iter().map(|area| count * area).collect();
        let slopes = match flexibility.ground {
            Some(depth) => {
                let low = near.iter().take_while(|place| place.y < depth);
                // Where places are even, half of the ground lies below their mean.
                let mean = low.clone().map(|place| place.y).sum::<f64>()
                    / low.clone().count().max(1) as f64;
                let ground = depth - (2.0 * mean - depth).clamp(0.0, deepest);
                let least = |i: usize| {
                    let corner = !closed && (i < CORNER || i + CORNER >= control_points);
                    even[i] * if corner { SPARSEST_AT_CORNERS } else { SPARSEST }
                };
                let found =
                    sums(low.map(|place| &place.basis), control_points).into_iter().enumerate();
                found.map(|(i, sum)| (sum / ground).max(least(i))).collect()
            }
            None => even.clone(),
        };
        let mut search = Search { near, stride: 1, slopes, count, closed, flexibility };
        let mut heights = vec![lowest.clamp(OUTERMOST, deepest); control_points];
        // Places touch a curve with so many degrees of freedom at this distance on average.
        let apart = control_points as f64 / count;
        let last = (noise * LOGISTIC).max(0.5 * apart);
        let mut scale = FIRST_SCALE.max(last);
        loop {
            let most = if scale > last { BLURRED } else { search.near.len() };
            search.stride = (search.near.len() / most.max(1)).max(1);
            search.climb(&mut heights, scale);
            if scale <= last {
                break;
            }
            scale = (LEFT_OF_SCALE * scale).max(last);
        }
        let deviations = search.deviations(&knots, &heights, last);
        let spreads = search.slopes.iter().zip(&even);
        let spreads = spreads.map(|(here, even)| spread(here / even));
        let mut doubts: Vec<(f64, f64)> = deviations.into_iter().zip(spreads).collect();
        let repeated = if closed { DEGREE } else { 0 };
        heights.extend_from_within(..repeated);
        doubts.extend_from_within(..repeated);
        Ok(Self { knots, heights, deepest, doubts })
    }
}

/// The lowest of places (x, y) in each of the strips that x is cut into; the last has its end.
pub(super) fn lowest(
    places: impl Iterator<Item = (f64, f64)> + Clone,
    strips: usize,
) -> Vec<Option<(f64, f64)>> {
    let (start, end) = extremes(places.clone().map(|place| place.0));
    let scale = strips as f64 / (end - start).max(f64::MIN_POSITIVE);
    let mut found: Vec<Option<(f64, f64)>> = vec![None; strips + 1];
    for place in places {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let strip = &mut found[(((place.0 - start) * scale) as usize).min(strips)];
        if strip.is_none_or(|lowest| place.1 < lowest.1) {
            *strip = Some(place);
        }
    }
    found
}

pub(super) fn extremes(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

/// The curve's height where these basis functions are; closed curves repeat their heights.
fn height(heights: &[f64], basis: &Basis<4>) -> f64 {
    let terms = basis.values.iter().enumerate();
    let at = |i: usize| if i < heights.len() { i } else { i - heights.len() };
    terms.map(|(i, value)| value * heights[at(basis.first + i)]).sum()
}

/// Basis functions of some places added up; closed curves repeat them.
fn sums<'a>(bases: impl IntoIterator<Item = &'a Basis<4>>, control_points: usize) -> Vec<f64> {
    let mut sums = vec![0.0; control_points];
    for basis in bases {
        for (i, value) in basis.values.iter().enumerate() {
            sums[(basis.first + i) % control_points] += value;
        }
    }
    sums
}

/// By how much farther than usual a surface goes on where the density of places is this share of the
/// mean: as far as their spacing is larger, but not where there is hardly any, at a rounded corner.
fn spread(density: f64) -> f64 {
    let sparse = density.min(SPARSE) / SPARSE;
    sparse / density.clamp(SPARSE, 1.0).sqrt()
}

/// The area under each basis function; closed curves repeat them.
fn areas(knots: &KnotVector, control_points: usize) -> Vec<f64> {
    let mut areas = vec![0.0; control_points];
    for span in knots.breaks().windows(2) {
        let length = span[1] - span[0];
        for (place, weight) in gauss::rule(DEGREE) {
            let basis = Basis::<4>::at(knots, span[0] + place * length);
            for (i, value) in basis.values.iter().enumerate() {
                areas[(basis.first + i) % control_points] += weight * length * value;
            }
        }
    }
    areas
}

/// The likelihood of edges.
struct Search {
    /// Lowest first.
    near: Vec<Place>,
    /// Only each so manieth of them is looked at, and counts for as many.
    stride: usize,
    /// What raising each control point gains by area.
    slopes: Vec<f64>,
    count: f64,
    closed: bool,
    flexibility: &'static Flexibility,
}

impl Search {
    /// The control points whose second differences bending is measured by, in threes.
    fn bends(&self) -> impl Iterator<Item = [usize; 3]> + use<> {
        let (count, closed) = (self.slopes.len(), self.closed);
        let middles = if closed { 0..count } else { 1..count - 1 };
        middles.map(move |i| [(i + count - 1) % count, i, (i + 1) % count])
    }

    /// The places that may touch an edge, which lies below its highest control point.
    fn touching(&self, heights: &[f64], scale: f64) -> impl Iterator<Item = &Place> {
        let highest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let behind = |place: &Place| place.y <= highest + UNTOUCHED * scale;
        self.near[..self.near.partition_point(behind)].iter().step_by(self.stride)
    }

    fn worth(&self, heights: &[f64], scale: f64) -> f64 {
        let area: f64 = self.slopes.iter().zip(heights).map(|(slope, height)| slope * height).sum();
        let likely = |place: &Place| {
            let z = (place.y - height(heights, &place.basis)) / scale;
            if z > UNTOUCHED {
                0.0
            } else if z > 0.0 {
                -(-z).exp().ln_1p()
            } else {
                z - z.exp().ln_1p()
            }
        };
        let bent: f64 = self.bends().map(|three| bend(heights, three).powi(2)).sum();
        let likely: f64 = self.touching(heights, scale).map(likely).sum();
        area + self.stride as f64 * likely - 0.5 * self.flexibility.stiffness * self.count * bent
    }

    /// Newton's steps to the likeliest edge with a blur of this scale.
    fn climb(&self, heights: &mut Vec<f64>, scale: f64) {
        let mut worth = self.worth(heights, scale);
        for _ in 0..STEPS {
            let Some(step) = self.step(heights, scale) else { return };
            let mut share = 1.0;
            let mut moved = 0.0;
            for _ in 0..SHORTENINGS {
                let steps = heights.iter().zip(&step);
                let next: Vec<f64> = steps
                    .map(|(h, s)| (h + share * s).clamp(OUTERMOST, self.flexibility.deepest))
                    .collect();
                let there = self.worth(&next, scale);
                if there >= worth {
                    let moves = next.iter().zip(heights.iter()).map(|(a, b)| (a - b).abs());
                    moved = moves.fold(0.0, f64::max);
                    (*heights, worth) = (next, there);
                    break;
                }
                share *= SHORTENING;
            }
            if moved < SETTLED * scale {
                return;
            }
        }
    }

    fn step(&self, heights: &[f64], scale: f64) -> Option<Vec<f64>> {
        let (matrix, slopes) = self.equations(heights, scale);
        matrix.cholesky().map(|factor| factor.solve(&slopes))
    }

    /// Standard deviations of the height where each control point has most to say, by Laplace's
    /// approximation of the likelihood: its second derivatives are the inverse of the variances.
    fn deviations(&self, knots: &KnotVector, heights: &[f64], scale: f64) -> Vec<f64> {
        let size = self.slopes.len();
        let Some(factor) = self.equations(heights, scale).0.cholesky() else {
            return vec![0.0; size];
        };
        let deviation = |x: f64| {
            let values = sums([&Basis::at(knots, x.clamp(0.0, 1.0))], size);
            let variance: f64 = factor.solve(&values).iter().zip(&values).map(|(a, b)| a * b).sum();
            variance.sqrt()
        };
        knots.greville().into_iter().take(size).map(deviation).collect()
    }

    /// Newton's equations for the next step.
    fn equations(&self, heights: &[f64], scale: f64) -> (Dense, Vec<f64>) {
        let size = self.slopes.len();
        let mut matrix = Dense::new(size);
        let mut slopes = self.slopes.clone();
        for Place { basis, y } in self.touching(heights, scale) {
            let z = (y - height(heights, basis)) / scale;
            if z > UNTOUCHED {
                continue;
            }
            let share = 1.0 / (1.0 + z.exp());
            let falls = self.stride as f64 * share;
            let bends = falls * (1.0 - share) / (scale * scale);
            for (i, a) in basis.values.iter().enumerate() {
                let row = (basis.first + i) % size;
                slopes[row] -= falls / scale * a;
                for (j, b) in basis.values.iter().enumerate() {
                    matrix.values[row * size + (basis.first + j) % size] += bends * a * b;
                }
            }
        }
        let stiff = self.flexibility.stiffness * self.count;
        for three in self.bends() {
            let bent = bend(heights, three);
            for (&row, a) in three.iter().zip(SECOND_DIFFERENCE) {
                slopes[row] -= stiff * bent * a;
                for (&col, b) in three.iter().zip(SECOND_DIFFERENCE) {
                    matrix.values[row * size + col] += stiff * a * b;
                }
            }
        }
        matrix.add_ridge(RIDGE);
        (matrix, slopes)
    }
}

const SECOND_DIFFERENCE: [f64; 3] = [1.0, -2.0, 1.0];

fn bend(heights: &[f64], three: [usize; 3]) -> f64 {
    three.iter().zip(SECOND_DIFFERENCE).map(|(&i, share)| share * heights[i]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places evenly over the unit square above a curve.
    fn above(edge: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        let spread = |i: usize| {
            let at = |share: f64| (0.5 + share * i as f64).fract();
            (at(0.754_877_666_246_693), at(0.569_840_290_998_053))
        };
        (0..3000).map(spread).filter(|&(x, y)| y > edge(x)).collect()
    }

    #[test]
    fn edges_follow_what_bends_gently() {
        let bent = |x: f64| 0.08 * x * (1.0 - x);
        let found = Edge::under(&above(bent), 0.0, false).unwrap();
        for i in 0..=20 {
            let x = f64::from(i) / 20.0;
            assert!((found.at(x) - bent(x)).abs() < 0.006, "{x} {} {}", found.at(x), bent(x));
        }
    }

    #[test]
    fn notches_are_followed_and_rounded_corners_are_not() {
        let notch = |x: f64| 0.2 * (std::f64::consts::PI * x).sin().powi(2);
        let round = |x: f64| 0.5 - (0.25 - (x - 0.5).powi(2)).max(0.0).powf(0.25) / 2.0_f64.sqrt();
        let edges = [
            Edge::under(&above(notch), 0.0, false).unwrap(),
            Edge::under(&above(round), 0.0, false).unwrap(),
        ];
        assert_eq!(edges.each_ref().map(Edge::is_notched), [true, false]);
        assert!((0.08..0.2).contains(&edges[0].at(0.5)), "{}", edges[0].at(0.5));
        assert!(edges[1].at(0.02) < 0.5 * round(0.02), "{}", edges[1].at(0.02));
    }

    #[test]
    fn noise_does_not_push_edges_out() {
        let wave = |i: usize| 0.02 * 2.0_f64.sqrt() * (1.7 * (i * i % 9973) as f64).sin();
        let noisy: Vec<(f64, f64)> =
            above(|_| 0.05).into_iter().enumerate().map(|(i, (x, y))| (x, y + wave(i))).collect();
        for closed in [false, true] {
            let found = Edge::under(&noisy, 0.02, closed).unwrap();
            for i in 0..=20 {
                let y = found.at(f64::from(i) / 20.0);
                assert!((y - 0.05).abs() < 0.012, "{y}");
            }
        }
    }

    #[test]
    fn surfaces_go_on_farther_where_edges_are_doubtful() {
        let level = above(|_| 0.05);
        let (count, spacing) = (level.len() as f64, (level.len() as f64).powf(-0.5));
        let sure = Edge::under(&level, 0.0, false).unwrap();
        let margin = |edge: &Edge, x: f64| edge.margin(0.5, spacing)(x) / spacing;
        assert!((0.2..0.5).contains(&margin(&sure, 0.5)), "{}", margin(&sure, 0.5));
        assert!(margin(&sure, 0.0) > 1.2 * margin(&sure, 0.5));
        assert_eq!(sure.margin(0.0, spacing)(0.5), 0.0);
        // One place of four on the right half, so that spacings there are longer.
        let thinned = level.into_iter().enumerate().filter(|(i, (x, _))| *x < 0.5 || i % 4 == 0);
        let thinned: Vec<(f64, f64)> = thinned.map(|(_, place)| place).collect();
        assert!((thinned.len() as f64) < 0.7 * count);
        let thinned = Edge::under(&thinned, 0.0, false).unwrap();
        assert!(margin(&thinned, 0.8) > 1.5 * margin(&thinned, 0.2));
    }

    #[test]
    fn few_places_bound_as_well() {
        for count in 1..6 {
            let places: Vec<(f64, f64)> = (0..count).map(|i| (f64::from(i) / 5.0, 0.3)).collect();
            let found = Edge::under(&places, 0.0, false).unwrap();
            assert!(
                (0..=10)
                    .all(|i| (OUTERMOST..=FIRM.deepest).contains(&found.at(f64::from(i) / 10.0)))
            );
        }
    }
}
