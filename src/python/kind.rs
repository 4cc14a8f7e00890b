//! The argument `kind`: a kind of surface by its name.

use pyo3::prelude::*;

use super::arguments;
use crate::chart::Kind;

/// The kinds by name; `None` selects the kind of the best candidate.
const KINDS: [Option<Kind>; 5] =
    [None, Some(Kind::Sheet), Some(Kind::Height), Some(Kind::Tube), Some(Kind::Torus)];

pub(super) fn kind_name(kind: Option<Kind>) -> &'static str {
    kind.map_or("auto", Kind::name)
}

/// A kind by its name, or `None` for "auto".
pub(super) fn named_kind(name: &Bound<'_, PyAny>) -> PyResult<Option<Kind>> {
    // A body is no wrong name: the check of the options refuses it and gives the reason.
    if name.extract::<&str>().is_ok_and(|name| name == Kind::Body.name()) {
        return Ok(Some(Kind::Body));
    }
    arguments::choice("kind", &KINDS, kind_name, name)
}
