//! Thresholds of the preparation of a cloud, one struct for each stage.
//!
//! The scoreboard that calibrated them is `benches/scoreboard.py`; see the [crate](crate).

/// Checks: which points can be a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CheckSettings {
    /// Fewest distinct points. Unit: points. Source: closed form: a bilinear patch has four
    /// corners.
    pub(super) min_distinct: usize,
    /// Smallest extent for which squared areas, as normals need them, do not vanish. Unit: the
    /// points' unit. Source: rounding.
    pub(super) min_extent: f64,
    /// Largest extent for which squared areas do not overflow. Unit: the points' unit. Source:
    /// rounding.
    pub(super) max_extent: f64,
    /// Distance from a line over the extent, up to which points are collinear. Unit: share.
    /// Source: rounding: single precision, in which points often have been stored.
    pub(super) max_line_width: f64,
    /// The same for coordinates far from the origin, in rounding errors of the largest coordinate.
    /// Unit: rounding errors. Source: rounding.
    pub(super) line_rounding: f64,
}

impl CheckSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self {
        min_distinct: 4,
        min_extent: 1e-70,
        max_extent: 1e70,
        max_line_width: 4.0 * f32::EPSILON as f64,
        line_rounding: 8.0,
    };
}

/// No-data values: coordinates that stand for a missing measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NoDataSettings {
    /// Distance of a no-data value from all others over the extent of these. Unit: ratio. Source:
    /// calibrated on the scoreboard.
    pub(super) min_distance_ratio: f64,
    /// Largest share of the points that have the value. Unit: share. Source: closed form: most
    /// points are data.
    pub(super) max_share: f64,
}

impl NoDataSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self { min_distance_ratio: 10.0, max_share: 0.5 };
}

/// Cleaning: duplicates and gross outliers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CleanSettings {
    /// Distance up to which points are duplicates: one point measured twice, or rounded in two
    /// ways by a file format. Unit: typical spacings. Source: calibrated on the scoreboard.
    pub(super) max_duplicate_distance: f64,
    /// Rank of the neighbor whose distance is the spacing at a point. Unit: points. Source:
    /// calibrated on the scoreboard.
    pub(super) spacing_rank: usize,
    /// Neighbors that are the surroundings of a point: enough to include few outliers.
    /// Unit: points. Source: calibrated on the scoreboard.
    pub(super) k_neighbors: usize,
    /// Nearest neighbors with which a point may fill a volume. Unit: points. Source: calibrated on
    /// the scoreboard.
    pub(super) k_volume_neighbors: usize,
    /// Spacing at a point over the typical one, above which the point may be an outlier.
    /// Unit: ratio. Source: calibrated on the scoreboard.
    pub(super) min_suspect_spacing: f64,
    /// Spacing at a point over that of its surroundings, above which it may be an outlier.
    /// Unit: ratio. Source: calibrated on the scoreboard.
    pub(super) min_local_spacing: f64,
    /// Height of a point above the plane of its surroundings over its spacing, above which it may
    /// be an outlier. Sparse parts of a surface are not as steep (30 degrees). Unit: ratio.
    /// Source: calibrated on the scoreboard.
    pub(super) min_slope: f64,
    /// Height of a point above that plane over the deviation of its surroundings, above which it
    /// may be an outlier. Unit: ratio. Source: calibrated on the scoreboard.
    pub(super) min_height: f64,
    /// Spacing at a point over the typical one, above which it is an outlier if it fills a volume
    /// with its neighbors. Unit: ratio. Source: calibrated on the scoreboard.
    pub(super) min_sparse_spacing: f64,
    /// Largest number of rounds: outliers hide others, and after these rounds few are left.
    /// Unit: rounds. Source: calibrated on the scoreboard.
    pub(super) max_rounds: usize,
    /// Spacing at a point over the radius of the cloud, above which it is an outlier in any case.
    /// Unit: ratio. Source: calibrated on the scoreboard.
    pub(super) max_isolation: f64,
    /// Points within the radius of the cloud. Unit: share. Source: calibrated on the scoreboard.
    pub(super) radius_share: f64,
}

impl CleanSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self {
        max_duplicate_distance: 1e-4,
        spacing_rank: 3,
        k_neighbors: 32,
        k_volume_neighbors: 8,
        min_suspect_spacing: 2.0,
        min_local_spacing: 2.0,
        min_slope: 0.5,
        min_height: 2.0,
        min_sparse_spacing: 2.5,
        max_rounds: 3,
        max_isolation: 4.0,
        radius_share: 0.75,
    };
}

/// Components: neighborhoods and the smallest component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ComponentSettings {
    /// Largest number of points that are joined; other points take the label of the nearest.
    /// Unit: points. Source: cost: seconds of a call.
    pub(super) max_sample: usize,
    /// Neighbors in a neighborhood. Unit: points. Source: calibrated on the scoreboard.
    pub(super) k_neighbors: usize,
    /// Nearest neighbors that each point is joined to at the start: these are rarely in another
    /// layer. Unit: points. Source: calibrated on the scoreboard.
    pub(super) k_nearest: usize,
    /// Fewest points of a component. Unit: points. Source: closed form: a bilinear patch has four
    /// corners.
    pub(super) min_points: usize,
    /// Fewest points of a component over all points. Unit: share. Source: calibrated on the
    /// scoreboard.
    pub(super) min_share: f64,
}

impl ComponentSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self =
        Self { max_sample: 20_000, k_neighbors: 8, k_nearest: 2, min_points: 4, min_share: 0.001 };
}

/// Sampling: the sizes of voxels that are tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SampleSettings {
    /// Doublings from the smallest voxel to one that contains all points. Unit: doublings. Source:
    /// rounding: coordinates have 53 bits.
    pub(super) doublings: i32,
    /// Sizes of voxels that an even sample tries for each doubling. On a surface, neighboring sizes
    /// give sample sizes whose ratio is at least 0.7. Unit: sizes. Source: closed form.
    pub(super) sizes_per_doubling: i32,
}

impl SampleSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self { doublings: 54, sizes_per_doubling: 4 };
}

/// Local frame: rounding and symmetric clouds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FrameSettings {
    /// Steps of local coordinates in half the median distance from the center: far finer than any
    /// measurement, far coarser than rounding. Unit: steps. Source: rounding.
    pub(super) steps: f64,
    /// Distance over the largest, from which both are equal. Unit: ratio. Source: rounding.
    pub(super) min_equal_ratio: f64,
    /// Largest number of equally far points that may define an axis. Unit: points. Source: cost:
    /// milliseconds of a call.
    pub(super) max_axes: usize,
}

impl FrameSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self =
        Self { steps: (1_u64 << 31) as f64, min_equal_ratio: 1.0 - 1e-9, max_axes: 4 };
}

/// Local planes: when points are a line or fill a volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PlaneSettings {
    /// Sweeps of Jacobi's method; three axes need five or six. Unit: sweeps. Source: Golub and Van
    /// Loan, Matrix Computations, section 8.5.
    pub(super) max_sweeps: usize,
    /// Second deviation over the first, below which points are a line. Random points in a disc have
    /// a ratio of 1. Unit: ratio. Source: calibrated on the scoreboard.
    pub(super) max_line_ratio: f64,
    /// Third deviation over the second, below which points are flat. Unit: ratio. Source:
    /// calibrated on the scoreboard.
    pub(super) max_flat_ratio: f64,
    /// Third deviation over the first, above which points fill a volume. Random points in a ball
    /// have a ratio of 1. Unit: ratio. Source: calibrated on the scoreboard.
    pub(super) min_thick_ratio: f64,
}

impl PlaneSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self =
        Self { max_sweeps: 12, max_line_ratio: 0.25, max_flat_ratio: 0.25, min_thick_ratio: 0.25 };
}

/// Preparation: how many points are fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PrepareSettings {
    /// Largest number of points that are fitted: enough for the largest net of the default
    /// options. Unit: points. Source: cost: seconds of a call.
    pub(super) max_points: usize,
}

impl PrepareSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self { max_points: 1 << 20 };
}
