//! The kinds of surface.

/// What kind of surface points lie on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Heights along a direction: no two points lie above one another.
    Height,
    /// A sheet with four sides.
    Sheet,
    /// Closed along u, with two rims.
    Tube,
    /// Closed along u and v.
    Torus,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Height, Self::Sheet, Self::Tube, Self::Torus];

    /// The name, as Python and the command line spell it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Height => "height",
            Self::Sheet => "sheet",
            Self::Tube => "tube",
            Self::Torus => "torus",
        }
    }

    /// Which directions of the surface close, u and v.
    #[must_use]
    pub fn closed(self) -> [bool; 2] {
        [matches!(self, Self::Tube | Self::Torus), self == Self::Torus]
    }
}
