//! A pipe, in order along its axis and around it.
//!
//! Loops around few points hide among accidental ones; but where a pipe is longer than wide, ways along the surface
//! from one end tell roughly where on its axis each point is, the mean of those in a section roughly where the axis
//! is, and the middle of the circle nearest to them exactly so, if the pipe is round.

use std::f64::consts::TAU;

use glam::{DMat2, DVec2, DVec3};

use super::start::Chart;
use crate::cloud::NeighborGraph;

/// Points in a section at least, the mean of which is on the axis; and sections at least.
const SECTION: usize = 24;
const FEWEST: usize = 4;

/// Times that the axis is found: ways from one end lead askew at first, in a coil most.
const ROUNDS: usize = 5;

/// Between the nearest and the farthest tenth of normally scattered numbers are so many deviations.
const TENTHS: f64 = 2.563;

/// The product of a section's principal moments as a share of the square of their sum below which it is a line.
const LINE: f64 = 1e-2;

/// Rounds in which places on the axis are smoothed, so that cubic curves stay as they are: a mean of those beside
/// them would draw a coil in.
const SMOOTHING: usize = 3;

/// Pieces of the axis before and after that of a point's own rank among which it may be.
const NEAR: usize = 6;

/// How many times longer than around a pipe is at least, one that is round, and one whose loops hide among accidental
/// ones; and how much of that shows itself at first.
const LONG: f64 = 2.0;
pub(super) const LONG_IF_ROUND: f64 = 0.6;
pub(super) const WITHOUT_LOOPS: f64 = 1.25;
const AT_FIRST: f64 = 0.7;

/// Distance from the axis of the nearest tenth of the points, as a share of that of the farthest: points in a strip
/// or a body come near its middle.
const HOLLOW: f64 = 0.6;

/// And of points on a round pipe, if they scatter by a twelfth of its radius at most.
const ROUND: f64 = 0.8;

/// Distance from the axis of the nearest fiftieth of the points, as a share of that of the farthest tenth, where a body
/// has a point at most: those over a disc have 0.15.
const POINTED: f64 = 0.2;

/// The widest gap around the axis of a pipe, in turns: a groove has one. The widest between n points that lie there by
/// chance is seldom wider than (ln n + 2.5) / n. Between columns of points are several, which are not so many times
/// wider than one another.
const OPEN: f64 = 0.04;
const BY_CHANCE: f64 = 2.5;
const COLUMNS: usize = 6;
const WIDER: f64 = 1.5;

/// Points around a long axis.
pub(crate) struct Pipe {
    /// Their places along it and around it.
    pub(crate) chart: Chart,
    /// Whether they lie all as far from it as others there, so that nothing but a pipe goes through them, or a body
    /// with a point.
    pub(crate) round: bool,
    /// How far off circles around it they are, by root mean square, if they scatter normally.
    pub(crate) scatter: f64,
    /// Whether hardly any lie so near to it as some do where a body has a point.
    pub(crate) open: bool,
}

impl Pipe {
    /// One around which points with these places may lie, or something that is none.
    pub(super) fn perhaps(chart: Chart) -> Self {
        Self { chart, round: false, scatter: 0.0, open: true }
    }
}

/// The pipe on which points lie, at least so many times longer than around; `None` if they do not lie around an axis.
pub(super) fn around_axis(points: &[DVec3], graph: &NeighborGraph, least: f64) -> Option<Pipe> {
    if points.is_empty() {
        return None;
    }
    let ways = |from: u32| graph.distances_from(&[from]);
    let first = (0_u32..).zip(ways(0)).max_by(|a, b| a.1.total_cmp(&b.1))?.0;
    let mut order = ranked(&ways(first));
    let mean = |some: &[usize]| some.iter().map(|&i| points[i]).sum::<DVec3>() / some.len() as f64;
    let mut axis = Axis::through(sections(&order, SECTION).map(mean).collect(), SECTION)?;
    let mut round = 1;
    let (places, girth) = loop {
        let places = axis.places(points, &order);
        order = ranked(&places.iter().map(|place| place.0).collect::<Vec<f64>>());
        let girth = Girth::of(&places, &order);
        if round == ROUNDS {
            break (places, girth);
        }
        if girth.slenderness() < AT_FIRST * least {
            return None;
        }
        let section = girth.section(points.len()).max(SECTION);
        axis = Axis::through(axis.middles(&places, &order, section), section)?;
        round += 1;
    };
    let uv = |&(along, across): &(f64, DVec2)| {
        let turns = (across.to_angle() / TAU).rem_euclid(1.0);
        DVec2::new(turns, (along - girth.ends.0) / girth.length())
    };
    let uv: Vec<DVec2> = places.iter().map(uv).collect();
    let (round, open) = (girth.hollow > ROUND, girth.narrowest > POINTED * girth.widest);
    let long = girth.slenderness() > if round { least } else { LONG };
    let whole = girth.hollow > HOLLOW && long && is_closed(&uv);
    let lengths = (girth.around(), girth.length());
    let chart = Chart { points: points.to_vec(), uv, lengths, closed_v: false };
    whole.then_some(Pipe { chart, round, scatter: girth.scatter, open })
}

/// How points lie around an axis.
struct Girth {
    /// Their distance from it, at the median, and of the nearest fiftieth and all but the farthest tenth.
    usual: f64,
    narrowest: f64,
    widest: f64,
    /// That of the nearest tenth as a share of that of the farthest, both as compared with others at the same place
    /// along it.
    hollow: f64,
    /// How far they are from that of others, by root mean square, if they scatter normally.
    scatter: f64,
    /// Where along it the first and the last are.
    ends: (f64, f64),
}

impl Girth {
    /// Of points with these places, in this order along the axis.
    fn of(places: &[(f64, DVec2)], order: &[usize]) -> Self {
        let mut radii: Vec<f64> = order.iter().map(|&index| places[index].1.length()).collect();
        let shares = |some: &[usize]| {
            let some: Vec<DVec2> =
                some.iter().map(|&i| DVec2::new(places[i].0, places[i].1.length())).collect();
            let trend = trend(&some);
            some.into_iter().map(move |place| place.y / trend(place.x)).collect::<Vec<f64>>()
        };
        let mut shares: Vec<f64> = order.chunks(SECTION).flat_map(shares).collect();
        let ends = (places[order[0]].0, places[order[order.len() - 1]].0);
        radii.sort_by(f64::total_cmp);
        shares.sort_by(f64::total_cmp);
        let [near, far] = [1, 9].map(|tenth| shares[shares.len() * tenth / 10]);
        let [narrowest, usual, widest] =
            [1, 25, 45].map(|fiftieth| radii[radii.len() * fiftieth / 50]);
        let scatter = usual * (far - near) / TENTHS;
        Self { usual, narrowest, widest, hollow: near / far, scatter, ends }
    }

    fn length(&self) -> f64 {
        self.ends.1 - self.ends.0
    }

    fn around(&self) -> f64 {
        TAU * self.usual
    }

    /// How many times longer than around it is.
    fn slenderness(&self) -> f64 {
        self.length() / self.around()
    }

    /// Of so many points, those in a section that is as long as wide.
    fn section(&self, points: usize) -> usize {
        let share = (2.0 * self.usual / self.length()).min(1.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share")]
        let section = (share * points as f64) as usize;
        section
    }
}

/// Whether points lie all around the axis.
pub(super) fn is_closed(uv: &[DVec2]) -> bool {
    let gaps = gaps(uv);
    let count = uv.len() as f64;
    let open = OPEN.max((count.ln() + BY_CHANCE) / count);
    gaps[0] < open || gaps.get(COLUMNS - 1).is_some_and(|gap| gaps[0] < WIDER * gap)
}

/// Those between points around the axis, in turns, the widest first.
pub(super) fn gaps(uv: &[DVec2]) -> Vec<f64> {
    let mut turns: Vec<f64> = uv.iter().map(|uv| uv.x).collect();
    turns.sort_by(f64::total_cmp);
    let around = turns[0] + 1.0 - turns[turns.len() - 1];
    let mut gaps: Vec<f64> = turns.windows(2).map(|pair| pair[1] - pair[0]).collect();
    gaps.push(around);
    gaps.sort_by(|a, b| b.total_cmp(a));
    gaps
}

/// The line nearest to places over their first coordinate.
fn trend(places: &[DVec2]) -> impl Fn(f64) -> f64 + use<> {
    let mean = places.iter().sum::<DVec2>() / places.len() as f64;
    let apart = places.iter().map(|&place| place - mean);
    let moments = apart.fold(DVec2::ZERO, |sum, apart| sum + apart * apart.x);
    let slope = if moments.x > 0.0 { moments.y / moments.x } else { 0.0 };
    move |at| mean.y + slope * (at - mean.x)
}

/// So many points that follow one another, every half as many.
fn sections(order: &[usize], section: usize) -> impl Iterator<Item = &[usize]> {
    order.windows(section).step_by(section / 2)
}

/// The middle of the circle nearest to places, of least squares in the squared radius (I. Kasa, *A circle fitting
/// procedure and its error analysis*, 1976); their mean, if they lie in a line.
fn middle(places: impl Iterator<Item = DVec2> + Clone) -> DVec2 {
    let mean = places.clone().sum::<DVec2>() / places.clone().count() as f64;
    let (mut moments, mut right) = (DMat2::ZERO, DVec2::ZERO);
    for apart in places.map(|place| place - mean) {
        moments += DMat2::from_cols(apart * apart.x, apart * apart.y);
        right += 0.5 * apart.length_squared() * apart;
    }
    let spread = moments.col(0).x + moments.col(1).y;
    if moments.determinant() > LINE * spread * spread {
        mean + moments.inverse() * right
    } else {
        mean
    }
}

/// The points in the order of their places along something.
pub(super) fn ranked(along: &[f64]) -> Vec<usize> {
    let mut ranked: Vec<usize> = (0..along.len()).collect();
    ranked.sort_by(|&a, &b| along[a].total_cmp(&along[b]));
    ranked
}

/// A line in space, with two directions across it that turn no more than they must.
struct Axis {
    nodes: Vec<DVec3>,
    /// The length of the line up to each.
    lengths: Vec<f64>,
    /// For each piece its direction and one across.
    frames: Vec<[DVec3; 2]>,
    /// Ranks of points from one node to the next.
    step: usize,
}

impl Axis {
    /// Through these nodes, of sections of so many points; `None` if there are few.
    fn through(mut nodes: Vec<DVec3>, section: usize) -> Option<Self> {
        if nodes.len() < FEWEST {
            return None;
        }
        for _ in 0..SMOOTHING {
            let beside = |at: usize| {
                let reach = at.min(nodes.len() - 1 - at).min(2);
                let mean = |apart: usize| 0.5 * (nodes[at - apart] + nodes[at + apart]);
                match reach {
                    0 => nodes[at],
                    1 => 0.5 * (nodes[at] + mean(1)),
                    _ => 0.625 * nodes[at] + 0.5 * mean(1) - 0.125 * mean(2),
                }
            };
            nodes = (0..nodes.len()).map(beside).collect();
        }
        let steps: Vec<DVec3> = nodes.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let mut lengths = vec![0.0];
        lengths.extend(steps.iter().scan(0.0, |sum, step| {
            *sum += step.length();
            Some(*sum)
        }));
        let mut across = steps[0].normalize_or(DVec3::Z).any_orthonormal_vector();
        let frame = |step: &DVec3| {
            let way = step.normalize_or(DVec3::Z);
            across = across.reject_from(way).normalize_or(way.any_orthonormal_vector());
            [way, across]
        };
        Some(Self { frames: steps.iter().map(frame).collect(), lengths, nodes, step: section / 2 })
    }

    /// The middles of the circles nearest to sections of so many points with these places, in this order.
    fn middles(&self, places: &[(f64, DVec2)], order: &[usize], section: usize) -> Vec<DVec3> {
        let middle = |some: &[usize]| {
            let along = some.iter().map(|&i| places[i].0).sum::<f64>() / some.len() as f64;
            let piece = self.lengths.partition_point(|&length| length < along);
            let piece = piece.saturating_sub(1).min(self.frames.len() - 1);
            let [way, first] = self.frames[piece];
            let across = middle(some.iter().map(|&i| places[i].1));
            self.nodes[piece]
                + (along - self.lengths[piece]) * way
                + across.x * first
                + across.y * way.cross(first)
        };
        sections(order, section).map(middle).collect()
    }

    /// Where points are along the axis and across, near the sections of their ranks.
    fn places(&self, points: &[DVec3], order: &[usize]) -> Vec<(f64, DVec2)> {
        let mut places = vec![(0.0, DVec2::ZERO); points.len()];
        for (rank, &index) in order.iter().enumerate() {
            places[index] = self.place(points[index], rank / self.step);
        }
        places
    }

    /// Where a point is along the axis and across, near one of its pieces.
    fn place(&self, point: DVec3, near: usize) -> (f64, DVec2) {
        let last = self.frames.len() - 1;
        let pieces = near.saturating_sub(NEAR).min(last)..=(near + NEAR).min(last);
        let place = |piece: usize| {
            let (from, [way, first]) = (self.nodes[piece], self.frames[piece]);
            let apart = point - from;
            let length = self.lengths[piece + 1] - self.lengths[piece];
            // The axis goes on at its ends.
            let low = if piece == 0 { f64::NEG_INFINITY } else { 0.0 };
            let high = if piece == last { f64::INFINITY } else { length };
            let step = way.dot(apart).clamp(low, high);
            let across = DVec2::new(first.dot(apart), way.cross(first).dot(apart));
            ((apart - step * way).length(), (self.lengths[piece] + step, across))
        };
        let nearest = pieces.map(place).min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.map_or((0.0, DVec2::ZERO), |(_, place)| place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    /// The chart of points on a pipe of radius 1, 40 long, bent by an angle, that goes so far around; and where
    /// the points are along it.
    fn chart(bend: f64, around: f64) -> (Option<Chart>, Vec<f64>) {
        let part = |i: u32, step: f64| (0.5 + step * f64::from(i)).fract();
        let flat =
            (0..600).map(|i| (part(i, 0.754_877_666_246_693), part(i, 0.569_840_290_998_053)));
        let (along, points): (Vec<f64>, Vec<DVec3>) = flat
            .map(|(t, s)| {
                let (radius, across) = (40.0 / bend, DVec2::from_angle(around * TAU * s));
                let ring = (radius + across.x) * DVec2::from_angle(bend * t);
                (t, ring.extend(across.y))
            })
            .unzip();
        let graph = NeighborGraph::of(&points, 8, &mut Silent).unwrap();
        (around_axis(&points, &graph, LONG_IF_ROUND).map(|pipe| pipe.chart), along)
    }

    #[test]
    fn bent_pipes_of_few_points_have_a_chart() {
        for bend in [0.01, 1.5, 4.0] {
            let (chart, along) = chart(bend, 1.0);
            let Chart { uv, lengths, .. } = chart.unwrap();
            let off = |up: bool| {
                let apart = |(uv, along): (&DVec2, &f64)| {
                    (if up { uv.y } else { 1.0 - uv.y } - along).abs()
                };
                uv.iter().zip(&along).map(apart).fold(0.0, f64::max)
            };
            assert!(off(true).min(off(false)) < 0.03);
            assert!((lengths.0 / TAU - 1.0).abs() < 0.05 && (lengths.1 - 40.0).abs() < 2.0);
        }
    }

    /// Places in so many columns around an axis, of which some are missing.
    fn columns(count: usize, missing: usize) -> Vec<DVec2> {
        let place = |i: usize| (i % count, i / count);
        let all = (0..50 * count).map(place).filter(|(column, _)| *column >= missing);
        all.map(|(column, row)| DVec2::new(column as f64 / count as f64, row as f64)).collect()
    }

    #[test]
    fn a_missing_column_is_a_slit() {
        assert!(is_closed(&columns(12, 0)) && is_closed(&columns(24, 0)));
        assert!(!is_closed(&columns(12, 1)) && !is_closed(&columns(24, 1)));
        assert!(is_closed(&columns(60, 1)));
    }

    #[test]
    fn grooves_strips_and_short_pipes_have_none() {
        assert!(chart(1.5, 0.8).0.is_none());
        assert!(chart(1.5, 0.3).0.is_none());
        let ring: Vec<DVec3> =
            (0..600).map(f64::from).map(|i| DVec2::from_angle(2.4 * i).extend(i / 200.0)).collect();
        let graph = NeighborGraph::of(&ring, 8, &mut Silent).unwrap();
        assert!(around_axis(&ring, &graph, LONG_IF_ROUND).is_none());
        let none = NeighborGraph::of(&[], 8, &mut Silent).unwrap();
        assert!(around_axis(&[], &none, LONG_IF_ROUND).is_none());
    }
}
