//! Topologies and cells of grids.

/// The closed directions of a grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Topology {
    /// Open in both directions.
    #[default]
    Sheet,
    /// Closed in u: the last row is joined to the first.
    Tube,
    /// Closed in u and v: the last row is joined to the first, and the last column to the first.
    Torus,
}

impl Topology {
    /// All variants.
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

/// The connections of a grid's nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cells {
    /// Along rows and columns: an inner node has four neighbors.
    #[default]
    Quad,
    /// Along one diagonal of each cell too: an inner node has six neighbors.
    Triangular,
}

impl Cells {
    /// All variants.
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
