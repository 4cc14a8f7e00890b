//! Memory limits: what a call needs is checked before it starts.
//!
//! An allocation that fails ends the process. So a call computes its peak and tries to reserve it.

use std::hint::black_box;

use crate::error::{Error, Result};

/// Bytes below which nothing is checked: the check itself takes microseconds.
const NEGLIGIBLE: u128 = 1 << 24;

/// Checks that so many bytes are available for `what`, described as "a net of 3 × 4 control points".
///
/// # Errors
///
/// [`Error::Memory`].
pub(crate) fn check(bytes: u128, what: impl FnOnce() -> String) -> Result<()> {
    if bytes < NEGLIGIBLE {
        return Ok(());
    }
    let mut room = Vec::<u8>::new();
    let reserved = usize::try_from(bytes).is_ok_and(|bytes| room.try_reserve_exact(bytes).is_ok());
    // Keeps the compiler from removing the allocation.
    black_box(&room);
    if reserved { Ok(()) } else { Err(Error::Memory { what: what(), bytes }) }
}

/// Checks that there is memory for computing with a net of control points.
///
/// # Errors
///
/// [`Error::Memory`].
pub(crate) fn check_net(rows: usize, cols: usize) -> Result<()> {
    /// Bytes for each control point: three copies in homogeneous coordinates, one of its place.
    const BYTES: u128 = 120;
    let bytes = BYTES.saturating_mul(rows as u128).saturating_mul(cols as u128);
    check(bytes, || format!("a net of {rows} × {cols} control points"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absurd_sizes_are_refused_with_their_size() {
        assert!(check_net(1000, 1000).is_ok());
        let error = check_net(usize::MAX, usize::MAX).unwrap_err().to_string();
        assert!(error.contains("GB of memory"), "{error}");
        assert!(check(1 << 62, || "this".to_string()).is_err());
    }
}
