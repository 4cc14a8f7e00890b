//! Knot insertion: the spans with the largest error are divided.

use super::isocurve_length::isocurve_lengths;
use super::projection::Projection;
use super::settings::RefinementSettings;
use super::spline_space::SplineSpace;
use crate::error::{Error, Result};
use crate::nurbs::{KnotVector, NurbsSurface};

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
    let errors = [0, 1].map(|d| {
        let breaks = space.knots[d].breaks();
        let mut errors = vec![0.0; breaks.len() - 1];
        for projection in projections {
            let at = breaks[1..breaks.len() - 1].partition_point(|&knot| knot <= projection.uv[d]);
            errors[at] += error(projection);
        }
        errors
    });
    with_divided_spans(space, &errors, lengths, share)
}

/// The space with those spans divided that together have this share of these errors of spans.
fn with_divided_spans(
    space: &SplineSpace,
    errors: &[Vec<f64>; 2],
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
        let breaks = divided(&knots[d].breaks(), &errors[d], share);
        knots[d] = with_breaks(&knots[d], space.closed[d], &breaks)?;
    }
    if knots == space.knots { Ok(None) } else { SplineSpace::new(knots, space.closed).map(Some) }
}

/// The refinement of a space that divides spans with the largest share of the error that keeps
/// within a number of unknowns, and that share. `None` if no span can be divided.
pub(super) fn refined_within(
    limit: usize,
    refined: impl Fn(f64) -> Result<Option<SplineSpace>>,
) -> Result<(Option<SplineSpace>, f64)> {
    let mut share = SETTINGS.divided_error;
    let mut finer = refined(share)?;
    while finer.as_ref().is_some_and(|finer| finer.unknowns() > limit) {
        share *= SETTINGS.divided_error;
        finer = if share < SETTINGS.min_divided_error { None } else { refined(share)? };
    }
    Ok((finer, share))
}

/// Finer knots for a surface whose spans in u and v have these sums of squared errors, for at most
/// so many control points. `None` if no span can be divided.
///
/// ```
/// use neurbs::{DVec3, NurbsSurface, fit::refined_knots};
/// let plane = NurbsSurface::plane(DVec3::ZERO, DVec3::X, DVec3::Y)?;
/// let errors = [vec![1.0], vec![0.0]];
/// let (u, v) = refined_knots(&plane, (false, false), &errors, 100)?.unwrap();
/// assert_eq!((u.breaks(), v.breaks()), (vec![0.0, 0.5, 1.0], vec![0.0, 1.0]));
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::Parameter`] if there is not one error for each span, or knots are not periodic in a
/// closed direction.
pub fn refined_knots(
    surface: &NurbsSurface,
    closed: (bool, bool),
    errors: &[Vec<f64>; 2],
    most: usize,
) -> Result<Option<(KnotVector, KnotVector)>> {
    let knots = [surface.knots_u().clone(), surface.knots_v().clone()];
    for (knots, errors) in knots.iter().zip(errors) {
        let spans = knots.breaks().len() - 1;
        if errors.len() != spans || !errors.iter().all(|error| *error >= 0.0) {
            let must = format!("{spans} numbers from 0, one for each span");
            return Err(Error::parameter("errors", must, errors.len()));
        }
    }
    let space = SplineSpace::new(knots, closed.into())?;
    let lengths = isocurve_lengths(surface);
    let refined = |share| with_divided_spans(&space, errors, lengths, share);
    let (finer, _) = refined_within(most, refined)?;
    Ok(finer.map(|finer| finer.knots.into()))
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
