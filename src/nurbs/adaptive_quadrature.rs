//! Integrals over regions that are quartered where their estimates disagree.

use rayon::prelude::*;

use super::work_blocks::for_row_blocks;
use crate::error::Result;
use crate::progress::Observer;
use crate::worker_pool;

/// Quadrature nodes along each side of a region: of the estimate, then of the two coarser rules
/// that bound its error. Near a singular point one coarser rule may agree by accident; two rarely
/// do.
pub(crate) const NODE_COUNTS: [usize; 3] = [12, 9, 8];

/// Maximal number of times that regions are quartered. Near a singular point the remaining regions
/// are negligible by then.
const MAX_ROUNDS: usize = 24;

/// Cost of measuring a region, in point evaluations; progress reports use it.
const REGION_COST: usize = 1 << 9;

/// A region of integration.
pub(crate) trait Region: Clone + Send + Sync {
    /// The rules with [`NODE_COUNTS`] nodes, prepared for all regions.
    type Rules: Sync;

    /// Estimates the integral by each rule.
    fn estimates(&self, rules: &Self::Rules) -> Estimates;

    /// The quarters, which together have the same integral.
    fn quarters(&self) -> [Self; 4];
}

/// The estimates of an integral.
pub(crate) struct Estimates {
    /// By the rules with [`NODE_COUNTS`] nodes.
    pub values: [f64; 3],
    /// Estimates that differ by at most this agree up to rounding.
    pub rounding: f64,
}

/// A region with its integral.
struct Part<R> {
    region: R,
    value: f64,
    /// Error estimate of the value.
    error: f64,
}

impl<R: Region> Part<R> {
    fn new(region: R, rules: &R::Rules) -> Self {
        let Estimates { values: [value, coarse @ ..], rounding } = region.estimates(rules);
        let difference = coarse.iter().map(|coarse| (value - coarse).abs()).fold(0.0, f64::max);
        let error = if difference <= rounding { 0.0 } else { difference };
        Self { region, value, error }
    }
}

/// Returns the integral over the regions that `begin` returns for `starts`, with relative error at
/// most `accuracy`.
///
/// The error estimate of a region is the larger difference from two coarser rules. While the total
/// error estimate exceeds `accuracy`, the regions with the largest errors are quartered.
pub(crate) fn integral<S: Sync, R: Region>(
    starts: &[S],
    begin: impl Fn(&S) -> R + Sync,
    rules: &R::Rules,
    accuracy: f64,
    observer: &mut dyn Observer,
) -> Result<f64> {
    let mut parts = measured(starts, begin, rules, observer)?;
    for _ in 0..MAX_ROUNDS {
        let allowed = accuracy * parts.iter().map(|part| part.value).sum::<f64>().abs();
        if parts.iter().map(|part| part.error).sum::<f64>() <= allowed {
            break;
        }
        parts.sort_by(|a, b| a.error.total_cmp(&b.error));
        let mut error = 0.0;
        let negligible = |part: &&Part<R>| {
            error += part.error;
            error <= allowed / 2.0
        };
        let refined = parts.split_off(parts.iter().take_while(negligible).count());
        let quarters: Vec<R> = refined.iter().flat_map(|part| part.region.quarters()).collect();
        parts.extend(measured(&quarters, R::clone, rules, observer)?);
    }
    Ok(parts.iter().map(|part| part.value).sum())
}

/// Measures the regions that `begin` returns for `starts`.
fn measured<S: Sync, R: Region>(
    starts: &[S],
    begin: impl Fn(&S) -> R + Sync,
    rules: &R::Rules,
    observer: &mut dyn Observer,
) -> Result<Vec<Part<R>>> {
    let mut parts = Vec::with_capacity(starts.len());
    for_row_blocks(starts.len(), REGION_COST, observer, |from, to| {
        let tasks = starts[from..to].par_iter().map(|start| Part::new(begin(start), rules));
        worker_pool::install(|| parts.par_extend(tasks));
    })?;
    Ok(parts)
}
