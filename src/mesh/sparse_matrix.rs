//! Linear maps with few terms: what turns control points into others.

#![expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]

use std::collections::BTreeMap;

use pulp::Simd;

use super::cost::{Eight, OCTET};

/// Weighted means of homogeneous points, eight at a time.
#[derive(Clone, Debug, Default)]
pub(super) struct Means {
    /// The points that eight means take something of.
    points: Vec<u32>,
    /// How much each of them takes of it.
    weights: Vec<Eight>,
    /// The end of the points of each eight.
    ends: Vec<usize>,
}

impl Means {
    /// From the terms of each mean: indices and weights, those of the same point added up. The last
    /// one stands in for those that are missing to eight.
    pub(super) fn new(means: &[Vec<(usize, f64)>]) -> Self {
        let mut this = Self::default();
        for octet in means.chunks(OCTET) {
            let mut points: BTreeMap<usize, Eight> = BTreeMap::new();
            for lane in 0..OCTET {
                let terms = octet[lane.min(octet.len() - 1)].iter();
                for &(point, weight) in terms.filter(|(_, weight)| *weight != 0.0) {
                    points.entry(point).or_default().0[lane] += weight;
                }
            }
            this.points
                .extend(points.keys().map(|&point| u32::try_from(point).unwrap_or(u32::MAX)));
            this.weights.extend(points.into_values());
            this.ends.push(this.points.len());
        }
        this
    }

    /// How many times eight they are.
    pub(super) fn octets(&self) -> usize {
        self.ends.len()
    }

    /// Writes the first coordinates of the means of the points that `point` tells.
    #[inline(always)]
    pub(super) fn of<S: Simd, const N: usize>(
        &self,
        simd: S,
        point: impl Fn(usize) -> [f64; 4],
        out: &mut [[Eight; N]],
    ) {
        let mut from = 0;
        for (out, &end) in out.iter_mut().zip(&self.ends) {
            let terms = (&self.points[from..end], &self.weights[from..end]);
            if S::F64_LANES == OCTET {
                add_up::<S, N, 1>(simd, terms, &point, (out, 0));
            } else {
                for first in (0..OCTET / S::F64_LANES).step_by(2) {
                    add_up::<S, N, 2>(simd, terms, &point, (out, first));
                }
            }
            from = end;
        }
    }
}

/// Writes what `K` registers from this one on hold of eight means: each point is looked up once for all
/// of them.
#[inline(always)]
fn add_up<S: Simd, const N: usize, const K: usize>(
    simd: S,
    (points, weights): (&[u32], &[Eight]),
    point: &impl Fn(usize) -> [f64; 4],
    (out, first): (&mut [Eight; N], usize),
) {
    let mut sums = [[simd.splat_f64s(0.0); N]; K];
    for (&at, weights) in points.iter().zip(weights) {
        let (point, weights) = (point(at as usize), S::as_simd_f64s(&weights.0).0);
        for axis in 0..N {
            let coordinate = simd.splat_f64s(point[axis]);
            for (sums, weights) in sums.iter_mut().zip(&weights[first..first + K]) {
                sums[axis] = simd.mul_add_e_f64s(*weights, coordinate, sums[axis]);
            }
        }
    }
    for (k, sums) in sums.iter().enumerate() {
        for (out, sum) in out.iter_mut().zip(sums) {
            S::as_mut_simd_f64s(&mut out.0).0[first + k] = *sum;
        }
    }
}
