//! The kind of a surface.

use std::fmt;

/// The kind of a surface.
///
/// ```
/// use neurbs::chart::Kind;
/// assert_eq!(Kind::Tube.name(), "tube");
/// assert_eq!(Kind::Torus.closed(), (true, true));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A height field: heights over a plane.
    Height,
    /// Open in both directions.
    Sheet,
    /// Closed in u.
    Tube,
    /// Closed in both directions.
    Torus,
    /// A closed body of several faces; not supported yet.
    Body,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 5] = [Self::Height, Self::Sheet, Self::Tube, Self::Torus, Self::Body];

    /// The name, as Python and the command line spell it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Height => "height",
            Self::Sheet => "sheet",
            Self::Tube => "tube",
            Self::Torus => "torus",
            Self::Body => "body",
        }
    }

    /// Whether the surface closes in u and in v.
    #[must_use]
    pub fn closed(self) -> (bool, bool) {
        (matches!(self, Self::Tube | Self::Torus), self == Self::Torus)
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
