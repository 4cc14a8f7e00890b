//! Thresholds of validation: error terms and defects.
//!
//! The scoreboard that calibrated them is `benches/scoreboard.py`; see the [crate](crate).

/// Error terms: the comparison of a surface with its points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TermSettings {
    /// Cells along a side of the grid on the surface. Unit: cells. Source: cost: milliseconds of a
    /// call.
    pub cells: usize,
    /// Length of a link on the surface over its length in space, above which it is torn.
    /// Unit: ratio. Source: calibrated on the scoreboard.
    pub max_stretch: f64,
    /// Shortest length in space that a torn link is compared with, in the spacing of the points.
    /// Unit: mean spacings. Source: calibrated on the scoreboard.
    pub min_link: f64,
    /// Parts in which the length of a link on the surface is measured. Unit: parts. Source: cost:
    /// milliseconds of a call.
    pub link_parts: usize,
    /// Distance from the points above which a cell is uncovered, in the spacing at the nearest
    /// point. Unit: local spacings. Source: calibrated on the scoreboard.
    pub max_local_gap: f64,
    /// The same in the mean spacing of as many points over the surface's area; the larger limit
    /// holds. Unit: mean spacings. Source: calibrated on the scoreboard.
    pub max_mean_gap: f64,
    /// Cosine between a cell's normal and the nearest local plane's, below which it is misaligned.
    /// Unit: none. Source: calibrated on the scoreboard.
    pub min_alignment: f64,
    /// Thickness over width of a local plane, below which its normal is compared. Unit: ratio.
    /// Source: calibrated on the scoreboard.
    pub max_flatness: f64,
    /// Cosine between the normals of neighboring cells, below which the surface turns over.
    /// Unit: none. Source: calibrated on the scoreboard.
    pub max_turned_cosine: f64,
}

impl TermSettings {
    /// The values that are used.
    pub const STANDARD: Self = Self {
        cells: 32,
        max_stretch: 3.0,
        min_link: 0.5,
        link_parts: 4,
        max_local_gap: 1.5,
        max_mean_gap: 1.5,
        min_alignment: 0.5,
        max_flatness: 0.35,
        max_turned_cosine: -0.2,
    };
}

impl Default for TermSettings {
    fn default() -> Self {
        Self::STANDARD
    }
}

/// Defects: limits above which a surface is not valid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DefectSettings {
    /// Neighboring cells whose normals turn over against the local planes. Unit: share. Source:
    /// calibrated on the scoreboard.
    pub max_folded: f64,
    /// Distance of the surface outside the cylinder around the box along the points' principal
    /// axes, over the diagonal of their bounding box. Unit: share. Source: calibrated on the
    /// scoreboard.
    pub max_overshoot: f64,
    /// Area of a closed surface without points near. Unit: share. Source: calibrated on the
    /// scoreboard.
    pub max_uncovered: f64,
    /// Links between neighbors that are torn. Unit: share. Source: calibrated on the scoreboard.
    pub max_torn: f64,
    /// Root mean square distance of the points over the diagonal of their box. Unit: share.
    /// Source: calibrated on the scoreboard.
    pub max_thickness: f64,
    /// Largest number of points by which folds are distinguished from bends. Unit: points. Source:
    /// cost: seconds of a call.
    pub max_points: usize,
    /// Cells along a side of the grid on which folds are searched. Unit: cells. Source: calibrated
    /// on the scoreboard.
    pub cells: usize,
    /// Points in a local plane. Unit: points. Source: calibrated on the scoreboard.
    pub k_neighbors: usize,
    /// Nearest points whose farthest gives the spacing at a cell. Unit: points. Source: calibrated
    /// on the scoreboard.
    pub spacing_rank: usize,
    /// Distance of a cell from the points, up to which their local plane counts. Unit: mean
    /// spacings. Source: calibrated on the scoreboard.
    pub max_gap: f64,
    /// Thickness over width up to which a local plane has two sides. Unit: ratio. Source:
    /// calibrated on the scoreboard.
    pub max_flatness: f64,
    /// Cosine between neighboring local planes, above which their sides are compared. Unit: none.
    /// Source: calibrated on the scoreboard.
    pub min_plane_cosine: f64,
}

impl DefectSettings {
    /// The values that are used.
    pub const STANDARD: Self = Self {
        max_folded: 0.01,
        max_overshoot: 0.1,
        max_uncovered: 0.1,
        max_torn: 0.05,
        max_thickness: 0.11,
        max_points: 50_000,
        cells: 70,
        k_neighbors: 12,
        spacing_rank: 4,
        max_gap: 2.0,
        max_flatness: 0.14,
        min_plane_cosine: 0.7,
    };
}

impl Default for DefectSettings {
    fn default() -> Self {
        Self::STANDARD
    }
}
