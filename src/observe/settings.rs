//! Thresholds of the observations.
//!
//! The scoreboard that calibrated them is `benches/scoreboard.py`; see the [crate](crate).

/// Observations: sample size, local planes, graphs and border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObserveSettings {
    /// Largest number of points that are observed. Unit: points. Source: cost: seconds of a call.
    pub max_sample: usize,
    /// Neighbors of a point in the graph. Unit: points. Source: calibrated on the scoreboard.
    pub k_neighbors: usize,
    /// Neighbors whose distance is the spacing at a point: this rank. Unit: points. Source:
    /// calibrated on the scoreboard.
    pub spacing_rank: usize,
    /// Neighbors in the smallest local plane; each next size is half as large again. Unit: points.
    /// Source: calibrated on the scoreboard.
    pub min_plane: usize,
    /// Neighbors in the largest local plane. Unit: points. Source: calibrated on the scoreboard.
    pub max_plane: usize,
    /// Points on which the sizes of local planes are compared. Unit: points. Source: cost:
    /// milliseconds of a call.
    pub compared_planes: usize,
    /// Flatness of a larger plane over that of a smaller one, below which the larger is taken.
    /// Unit: ratio. Source: calibrated on the scoreboard.
    pub flatter_ratio: f64,
    /// Flatness over that of the best size so far, above which no larger planes are tried: they
    /// bridge the surface's bends. Unit: ratio. Source: calibrated on the scoreboard.
    pub worse_ratio: f64,
    /// Flatness over that of points that fill a volume, below which planes are reliable.
    /// Unit: ratio. Source: calibrated on the scoreboard: waves with noise of 0.08 to 0.15 of
    /// their extent.
    pub max_thickness: f64,
    /// Fewest points with which planes can be unreliable: of fewer, curvature looks like thickness.
    /// Unit: points. Source: calibrated on the scoreboard.
    pub min_points: usize,
    /// Sine of the angle between a link and a local plane, from which the link is dropped.
    /// Unit: none. Source: calibrated on the scoreboard.
    pub max_link_sine: f64,
    /// Links that each point keeps at any angle. Unit: links. Source: calibrated on the
    /// scoreboard.
    pub min_links: usize,
    /// Neighbors of a point in the tight graph. Unit: points. Source: calibrated on the
    /// scoreboard.
    pub tight_neighbors: usize,
    /// Length of a link of the tight graph over the mean distance of its ends to their neighbors,
    /// up to which it is kept. Unit: ratio. Source: calibrated on the scoreboard.
    pub max_tight_length: f64,
    /// Neighbors among which a border point has a gap. Unit: points. Source: calibrated on the
    /// scoreboard.
    pub border_neighbors: usize,
    /// Angle of that gap. Unit: radians. Source: calibrated on the scoreboard.
    pub min_border_gap: f64,
}

impl ObserveSettings {
    /// The values that are used.
    pub const STANDARD: Self = Self {
        max_sample: 2000,
        k_neighbors: 8,
        spacing_rank: 6,
        min_plane: 6,
        max_plane: 160,
        compared_planes: 500,
        flatter_ratio: 0.93,
        worse_ratio: 2.0,
        max_thickness: 0.75,
        min_points: 100,
        max_link_sine: 0.6,
        min_links: 2,
        tight_neighbors: 4,
        max_tight_length: 1.8,
        border_neighbors: 16,
        min_border_gap: 2.8,
    };
}

impl Default for ObserveSettings {
    fn default() -> Self {
        Self::STANDARD
    }
}
