//! Options of trimming.

use crate::error::{Error, Result};

/// Options of [`trim`](super::trim()).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrimOptions {
    /// Whether holes are left open; otherwise only the outer border is trimmed.
    pub holes: bool,
    /// How far the border lies outside of the outermost points, over the expected distance. `None`
    /// is 1; 0 leads the border through the points.
    pub border: Option<f64>,
}

impl Default for TrimOptions {
    fn default() -> Self {
        Self { holes: true, border: None }
    }
}

impl TrimOptions {
    /// The factor of the offset.
    pub(super) fn offset(&self) -> Result<f64> {
        match self.border {
            None => Ok(1.0),
            Some(border) if (0.0..=MAX_BORDER).contains(&border) => Ok(border),
            Some(border) => {
                let must = format!("between 0 and {MAX_BORDER}");
                Err(Error::parameter("border", must, border))
            }
        }
    }
}

/// Largest factor of the offset: beyond it, loops meet.
const MAX_BORDER: f64 = 4.0;
