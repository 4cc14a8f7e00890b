//! What kinds of grids there are.

/// Which directions of a grid are closed to a ring.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Topology {
    /// None.
    #[default]
    Sheet,
    /// u: the last row is joined to the first.
    Tube,
    /// u and v: the last row is joined to the first, and the last column too.
    Torus,
}

impl Topology {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Sheet, Self::Tube, Self::Torus];

    /// The topology's name, as Python spells it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Sheet => "sheet",
            Self::Tube => "tube",
            Self::Torus => "torus",
        }
    }

    /// Whether u (rows) and v (columns) are closed.
    ///
    /// ```
    /// use neurbs::som::Topology;
    /// assert_eq!(Topology::Tube.closed(), (true, false));
    /// ```
    #[must_use]
    pub fn closed(self) -> (bool, bool) {
        (self != Self::Sheet, self == Self::Torus)
    }
}

/// How the nodes of a grid are joined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cells {
    /// Along rows and columns: an inner node has four neighbours.
    #[default]
    Quad,
    /// Along one diagonal of each cell too: an inner node has six neighbours.
    Triangular,
}

impl Cells {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Quad, Self::Triangular];

    /// The kind's name, as Python spells it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Quad => "quad",
            Self::Triangular => "triangular",
        }
    }
}
