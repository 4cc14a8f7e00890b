//! Closed forms along a surface: turns along edges, of which each loop collects a whole number.

use rayon::prelude::*;

use super::cohomology::Edge;
use super::laplacian::Laplacian;

/// Sums are made of so many forms at most: those of a tube with three holes. More of them are accidental, as from
/// short cuts between windings, and some sum of many is always even.
const MOST_SUMMED: usize = 4;

pub(super) fn weight(edge: &Edge) -> f64 {
    (edge.length * edge.length).recip()
}

/// Turns along each edge, and the angle of each landmark.
#[derive(Clone)]
pub(super) struct Form {
    turns: Vec<f64>,
    pub(super) angles: Vec<f64>,
}

impl Form {
    /// The evenest form in the class of a cocycle: least squares over the edges, each weighted by
    /// the inverse square of its length.
    pub(super) fn harmonic(
        laplacian: &Laplacian,
        edges: &[Edge],
        values: &[i32],
        vertices: usize,
    ) -> Self {
        let mut right = vec![0.0; vertices];
        for (edge, &value) in edges.iter().zip(values) {
            right[edge.to as usize] += weight(edge) * f64::from(value);
            right[edge.from as usize] -= weight(edge) * f64::from(value);
        }
        let angles = laplacian.solve(&right);
        let left = |(edge, &value): (&Edge, &i32)| {
            f64::from(value) - (angles[edge.to as usize] - angles[edge.from as usize])
        };
        let turns = edges.iter().zip(values).map(left).collect();
        // Along an edge the angle grows by the whole turns less what the form leaves.
        Self { turns, angles: angles.iter().map(|angle| -angle).collect() }
    }

    fn dot(&self, other: &Self, edges: &[Edge]) -> f64 {
        let pairs = self.turns.iter().zip(&other.turns).zip(edges);
        pairs.map(|((a, b), edge)| a * b / (edge.length * edge.length)).sum()
    }

    fn subtract(&mut self, other: &Self, times: f64) {
        for (own, other) in self.turns.iter_mut().zip(&other.turns) {
            *own -= times * other;
        }
        for (own, other) in self.angles.iter_mut().zip(&other.angles) {
            *own -= times * other;
        }
    }

    /// What the loops are like that go along it.
    pub(super) fn course(&self, edges: &[Edge]) -> Course {
        Course::of(self.lengths(edges))
    }

    /// How long a loop would be that were everywhere as it is at each landmark; infinite where the form
    /// does not turn.
    fn lengths(&self, edges: &[Edge]) -> Vec<f64> {
        let mut slopes = vec![(0.0, 0.0); self.angles.len()];
        for (edge, turns) in edges.iter().zip(&self.turns) {
            // An edge in a random direction sees half of the squared slope.
            let squared = 2.0 * (turns / edge.length).powi(2);
            for end in [edge.from, edge.to] {
                slopes[end as usize].0 += squared;
                slopes[end as usize].1 += 1.0;
            }
        }
        slopes.iter().map(|(sum, count)| (sum / count).sqrt().recip()).collect()
    }
}

/// What the loops along a form are like.
pub(super) struct Course {
    /// Length of the loop in the middle of the surface, in the points' unit.
    pub(super) length: f64,
    /// How much longer loops are where they are long (upper decile) than where they are short.
    pub(super) spread: f64,
}

impl Course {
    /// Of loops that would be so long if they were everywhere as they are somewhere; infinite where they do not go on.
    pub(super) fn of(mut lengths: Vec<f64>) -> Self {
        lengths.retain(|length| length.is_finite());
        lengths.sort_by(f64::total_cmp);
        let quantile = |share: usize| lengths.get(lengths.len() * share / 10).copied();
        let [low, length, high] = [1, 5, 9].map(|share| quantile(share).unwrap_or(f64::INFINITY));
        Self { length, spread: high / low }
    }
}

/// The sum or difference of some of these forms whose loops have the least spread, if it is none of them:
/// around a tube with holes there are loops on both sides of each hole, and the angle that they share is the
/// tube's. Adds to each form, one after the other, what helps most.
pub(super) fn evenest(forms: &[Form], edges: &[Edge]) -> Option<Form> {
    if !(2..=MOST_SUMMED).contains(&forms.len()) {
        return None;
    }
    let from = |first: usize| {
        let (mut sum, mut least) = (forms[first].clone(), forms[first].course(edges).spread);
        let mut left: Vec<usize> = (0..forms.len()).filter(|&other| other != first).collect();
        let mut summed = false;
        loop {
            let terms = left.iter().flat_map(|&other| [(other, 1.0), (other, -1.0)]);
            let tried = terms.map(|(other, times)| {
                let mut tried = sum.clone();
                tried.subtract(&forms[other], times);
                (tried.course(edges).spread, other, tried)
            });
            let best = tried.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|best| best.0 < least);
            let Some((spread, other, better)) = best else { break };
            left.retain(|&left| left != other);
            (sum, least, summed) = (better, spread, true);
        }
        summed.then_some((least, sum))
    };
    let found: Vec<_> = (0..forms.len()).into_par_iter().filter_map(from).collect();
    found.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, sum)| sum)
}

/// Replaces loops by sums of them until none gets shorter (Gauss's reduction, pair by pair), longest
/// loops first.
pub(super) fn shorten(forms: &mut [Form], edges: &[Edge]) {
    let mut changed = true;
    while changed {
        changed = false;
        for a in 0..forms.len() {
            for b in 0..forms.len() {
                if a == b {
                    continue;
                }
                let times = forms[a].dot(&forms[b], edges) / forms[b].dot(&forms[b], edges);
                // Just over a half, so that rounding does not turn it back and forth.
                if times.abs() > 0.501 {
                    let (low, high) = forms.split_at_mut(a.max(b));
                    let (own, other) =
                        if a < b { (&mut low[a], &high[0]) } else { (&mut high[0], &low[b]) };
                    own.subtract(other, times.round());
                    changed = true;
                }
            }
        }
    }
    // The longer the loop, the smaller its slope.
    let energy = |form: &Form| form.dot(form, edges);
    forms.sort_by(|a, b| energy(a).total_cmp(&energy(b)));
}
