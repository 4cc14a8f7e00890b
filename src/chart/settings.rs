//! Thresholds of the charts, one struct for each.
//!
//! The scoreboard that calibrated them is `benches/scoreboard.py`; see the [crate](crate).

/// Plane chart: when a height field is proposed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PlaneChartSettings {
    /// Cosine of the steepest slope of a height field (78 degrees). Unit: none. Source: calibrated
    /// on the scoreboard.
    pub(super) min_cosine: f64,
    /// Smallest share of the local normals within that slope. Unit: share. Source: calibrated on
    /// the scoreboard.
    pub(super) min_share: f64,
    /// Share of its rectangle by which the footprint along z may be emptier than the one along the
    /// normals. A footprint along z of a leaning surface is emptier. Unit: share. Source:
    /// calibrated on the scoreboard.
    pub(super) max_emptier: f64,
}

impl PlaneChartSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self { min_cosine: 0.2, min_share: 0.8, max_emptier: 0.02 };
}

/// Bounding rectangle: when it is turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RectangleSettings {
    /// Share of a rectangle that the least rectangle around n points in it leaves out by chance,
    /// times n: two gaps along each direction. Unit: none. Source: closed form: the expected gap at
    /// either end of n points is 1 / n.
    pub(super) chance_gaps: f64,
}

impl RectangleSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self { chance_gaps: 4.0 };
}

/// Angles about a center: when a section is closed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AngleSettings {
    /// Widest gap between points around a closed section (75 degrees). Unit: radians. Source:
    /// calibrated on the scoreboard.
    pub(super) max_closed_gap: f64,
}

impl AngleSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self { max_closed_gap: 1.3 };
}

/// Revolved chart: center line, cut and torus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RevolvedSettings {
    /// Slices along an axis whose circles give the center line. Unit: slices. Source: calibrated
    /// on the scoreboard.
    pub(super) slices: usize,
    /// Fewest points in a slice that give a circle. Unit: points. Source: calibrated on the
    /// scoreboard.
    pub(super) min_slice_points: usize,
    /// Length along the axis over the radius, above which the center line may bend. Unit: ratio.
    /// Source: calibrated on the scoreboard.
    pub(super) min_bent_length: f64,
    /// Narrowest gap at which a surface is cut open (7 degrees). Unit: radians. Source: calibrated
    /// on the scoreboard.
    pub(super) min_cut_gap: f64,
    /// Points of a torus's section, the nearest to its center, that must not fill it. Unit: share.
    /// Source: calibrated on the scoreboard.
    pub(super) hollow_share: f64,
    /// Radius of that share over the median radius, above which the section is hollow.
    /// Unit: ratio. Source: calibrated on the scoreboard.
    pub(super) min_hollow_radius: f64,
}

impl RevolvedSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self {
        slices: 7,
        min_slice_points: 6,
        min_bent_length: 1.2,
        min_cut_gap: 0.12,
        hollow_share: 0.05,
        min_hollow_radius: 0.15,
    };
}

/// Landmark Isomap: distances along the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct IsomapSettings {
    /// Landmarks from which distances along the surface are found. Unit: points. Source: cost:
    /// milliseconds of a call.
    pub(super) landmarks: usize,
}

impl IsomapSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self { landmarks: 40 };
}

/// Polar chart: the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PolarSettings {
    /// Points nearest to the center whose plane gives the axis. Unit: share. Source: calibrated on
    /// the scoreboard.
    pub(super) cap_share: f64,
    /// Cosine between that axis and the direction from the center to the points' mean, from which
    /// that direction is the axis. Unit: none. Source: calibrated on the scoreboard.
    pub(super) min_inward_cosine: f64,
}

impl PolarSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self { cap_share: 0.1, min_inward_cosine: 0.3 };
}

/// Center-line chart: the polygon through the middle of a bent tube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CenterLineSettings {
    /// Fewest nodes of the line. Unit: nodes. Source: calibrated on the scoreboard.
    pub(super) min_nodes: f64,
    /// Most nodes of the line. Unit: nodes. Source: calibrated on the scoreboard.
    pub(super) max_nodes: f64,
    /// Distance between nodes over the median distance of points from the line in the flat map.
    /// Unit: ratio. Source: calibrated on the scoreboard.
    pub(super) node_distance: f64,
    /// Iterations in which points are ordered by their projections onto the line. Unit:
    /// iterations. Source: calibrated on the scoreboard.
    pub(super) iterations: usize,
}

impl CenterLineSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self =
        Self { min_nodes: 5.0, max_nodes: 24.0, node_distance: 2.5, iterations: 3 };
}
