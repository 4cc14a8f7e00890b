//! Compatible curves: the same degree and the same knots.

use super::curve_family::Strip;
use super::knot_multiset::{difference, intersection};
use crate::error::{Error, Result};
use crate::progress::Listen;

/// Raises strips to the highest degree among them, clamped.
pub(super) fn unify_degrees(strips: &mut [Strip], listen: &mut Listen<'_>) -> Result<()> {
    let degree = strips.iter().map(|strip| strip.knots.degree()).max().unwrap_or(0);
    strips.iter_mut().try_for_each(|strip| {
        *strip = strip.elevated(degree - strip.knots.degree(), listen)?;
        Ok(())
    })
}

/// Gives strips of the same domain the same degree and the same knots: those of all of them.
///
/// # Errors
///
/// [`Error::Parameter`] if the domains differ.
pub(super) fn unify(strips: &mut [Strip], listen: &mut Listen<'_>) -> Result<()> {
    unify_degrees(strips, listen)?;
    let domain = strips[0].knots.domain();
    if let Some(other) = strips.iter().map(|strip| strip.knots.domain()).find(|d| *d != domain) {
        return Err(Error::parameter("domain", format!("{domain:?} of all"), format!("{other:?}")));
    }
    let mut all: Vec<f64> = Vec::new();
    for strip in &*strips {
        listen()?;
        let new = difference(strip.knots.inner(), &intersection(strip.knots.inner(), &all));
        all.extend(new);
        all.sort_by(f64::total_cmp);
    }
    strips.iter_mut().try_for_each(|strip| {
        *strip = strip.refined(&difference(&all, strip.knots.inner()), listen)?;
        Ok(())
    })
}
