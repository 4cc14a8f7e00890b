//! Knot insertion: the spans with the largest error are divided.

use super::projection::Projection;
use super::settings::RefinementSettings;
use super::spline_space::SplineSpace;
use crate::error::Result;
use crate::nurbs::KnotVector;

const SETTINGS: RefinementSettings = RefinementSettings::STANDARD;

/// The space with those spans divided that together have this share of the error. `None` if no span
/// can be divided.
///
/// `error` is the squared error at a projection, 0 if it does not matter. `lengths` are those of
/// the surface along u and v. Directions whose spans are much shorter than those of the other
/// direction stay as they are.
pub(super) fn refined(
    space: &SplineSpace,
    projections: &[Projection],
    error: impl Fn(&Projection) -> f64,
    lengths: (f64, f64),
    share: f64,
) -> Result<Option<SplineSpace>> {
    let lengths = [lengths.0, lengths.1];
    let mean = [0, 1].map(|d| lengths[d] / space.knots[d].spans() as f64);
    let mut knots = space.knots.clone();
    for d in 0..2 {
        if mean[d] * SETTINGS.max_aspect < mean[1 - d] {
            continue;
        }
        let breaks = knots[d].breaks();
        let mut errors = vec![0.0; breaks.len() - 1];
        for projection in projections {
            let at = breaks[1..breaks.len() - 1].partition_point(|&knot| knot <= projection.uv[d]);
            errors[at] += error(projection);
        }
        knots[d] = with_breaks(&knots[d], space.closed[d], &divided(&breaks, &errors, share))?;
    }
    if knots == space.knots { Ok(None) } else { SplineSpace::new(knots, space.closed).map(Some) }
}

/// The breaks, and the midpoints of the worst spans that together have this share of the error.
fn divided(breaks: &[f64], errors: &[f64], share: f64) -> Vec<f64> {
    let total: f64 = errors.iter().sum();
    let mut order: Vec<usize> = (0..errors.len()).filter(|&i| errors[i] > 0.0).collect();
    order.sort_by(|&a, &b| errors[b].total_cmp(&errors[a]).then(a.cmp(&b)));
    let mut covered = 0.0;
    let mut breaks = breaks.to_vec();
    for i in order {
        if covered >= share * total {
            break;
        }
        covered += errors[i];
        breaks.push(0.5 * (breaks[i] + breaks[i + 1]));
    }
    breaks.sort_by(f64::total_cmp);
    breaks
}

/// Simple knots at these breaks.
fn with_breaks(knots: &KnotVector, closed: bool, breaks: &[f64]) -> Result<KnotVector> {
    if closed {
        return KnotVector::periodic(knots.degree(), breaks);
    }
    KnotVector::clamped(knots.degree(), knots.domain(), breaks[1..breaks.len() - 1].iter().copied())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_spans_are_divided() {
        let breaks = [0.0, 0.25, 0.5, 0.75, 1.0];
        assert_eq!(
            divided(&breaks, &[1.0, 0.0, 8.0, 1.0], 0.7),
            [0.0, 0.25, 0.5, 0.625, 0.75, 1.0]
        );
        assert_eq!(divided(&breaks, &[0.0; 4], 0.7), breaks);
    }
}
