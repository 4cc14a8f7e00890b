//! Compatible curves: the same degree and the same knots (The NURBS Book, section 10.3).

use super::curve_family::CurveFamily;
use super::knot_multiset::{difference, intersection};
use crate::error::{Error, Result};
use crate::progress::InterruptCheck;

/// Elevates all families to the highest degree among them, clamped.
pub(super) fn unify_degrees(
    families: &mut [CurveFamily],
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<()> {
    let degree = families.iter().map(|family| family.knots.degree()).max().unwrap_or(0);
    families.iter_mut().try_for_each(|family| {
        *family = family.elevated(degree - family.knots.degree(), check_interrupt)?;
        Ok(())
    })
}

/// Makes families on the same domain compatible: the highest degree and the union of all knots.
///
/// # Errors
///
/// [`Error::Parameter`] if the domains differ.
pub(super) fn unify(
    families: &mut [CurveFamily],
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<()> {
    unify_degrees(families, check_interrupt)?;
    let domain = families[0].knots.domain();
    if let Some(other) = families.iter().map(|family| family.knots.domain()).find(|d| *d != domain)
    {
        return Err(Error::parameter(
            "domain",
            format!("{domain:?}, as that of the first"),
            format!("{other:?}"),
        ));
    }
    let mut all: Vec<f64> = Vec::new();
    for family in &*families {
        check_interrupt()?;
        let new = difference(family.knots.inner(), &intersection(family.knots.inner(), &all));
        all.extend(new);
        all.sort_by(f64::total_cmp);
    }
    families.iter_mut().try_for_each(|family| {
        *family = family.refined(&difference(&all, family.knots.inner()), check_interrupt)?;
        Ok(())
    })
}
