//! Thresholds of the pipeline, one struct for each stage.
//!
//! The scoreboard that calibrated them is `benches/scoreboard.py`; see the [crate](crate).

use crate::fit::CoarseSettings;
use crate::validate::TermSettings;

/// Mixed units: axes whose extents differ too much for one unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AxisScaleSettings {
    /// Largest over smallest extent above which axes may have different units. Unit: ratio.
    /// Source: calibrated on the scoreboard.
    pub(super) max_extent_ratio: f64,
    /// Points at either end of an axis that its extent leaves out. Unit: share. Source: calibrated
    /// on the scoreboard.
    pub(super) tail_share: f64,
}

impl AxisScaleSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self { max_extent_ratio: 30.0, tail_share: 0.01 };
}

/// Ranking: how hypotheses are fitted, scored and dropped, and when the search for them ends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RankingSettings {
    /// The coarse fits. Unit: none. Source: see [`CoarseSettings`].
    pub coarse: CoarseSettings,
    /// The error terms of a coarse fit. Unit: none. Source: see [`TermSettings`].
    pub terms: TermSettings,
    /// Weights and scales of the score. Unit: none. Source: see [`ScoreSettings`].
    pub score: ScoreSettings,
    /// Limits for dropping a hypothesis and for ending the search. Unit: none. Source: see
    /// [`SearchSettings`].
    pub search: SearchSettings,
}

/// Ranking: limits for dropping a hypothesis before it is scored, and for ending the search at a
/// height field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchSettings {
    /// Largest number of hypotheses that are scored. Height fields come on top where the local
    /// planes are unreliable. Unit: hypotheses. Source: cost: seconds of a call.
    pub max_hypotheses: usize,
    /// Quick error over that of the best hypothesis, above which a hypothesis is dropped.
    /// Unit: ratio. Source: calibrated on the scoreboard.
    pub max_error_ratio: f64,
    /// Quick error over the noise of the points, up to which no hypothesis is dropped.
    /// Unit: ratio. Source: calibrated on the scoreboard.
    pub max_noise_ratio: f64,
    /// Smallest number of points with which a height field may end the search. Unit: points.
    /// Source: calibrated on the scoreboard.
    pub end_search_min_points: usize,
    /// Error of held-out points over the noise and curvature around each, up to which a height
    /// field ends the search. Unit: ratio. Source: calibrated on the scoreboard.
    pub end_search_max_error: f64,
    /// Cosine of the steepest slope (53 degrees) with which a height field ends the search. Noise
    /// along the plane makes steeper height fields worse than sheets. Unit: none. Source:
    /// calibrated on the scoreboard.
    pub end_search_min_cosine: f64,
    /// The same limit for height fields in scaled units (78 degrees). Unit: none. Source:
    /// calibrated on the scoreboard.
    pub end_search_scaled_min_cosine: f64,
    /// Smallest share of the local normals within that slope. Unit: share. Source: calibrated on
    /// the scoreboard.
    pub end_search_min_share: f64,
}

impl SearchSettings {
    /// The values that are used.
    pub const STANDARD: Self = Self {
        max_hypotheses: 8,
        max_error_ratio: 5.0,
        max_noise_ratio: 2.0,
        end_search_min_points: 100,
        end_search_max_error: 1.5,
        end_search_min_cosine: 0.6,
        end_search_scaled_min_cosine: 0.2,
        end_search_min_share: 0.95,
    };
}

impl Default for SearchSettings {
    fn default() -> Self {
        Self::STANDARD
    }
}

/// Score: weights and scales of the terms. With all weights 1, nearly as many clouds of the
/// scoreboard come out right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScoreSettings {
    /// Weight of the error of held-out points. Unit: none. Source: calibrated on the scoreboard.
    pub held_out_weight: f64,
    /// Weight of torn links. Unit: none. Source: calibrated on the scoreboard.
    pub torn_weight: f64,
    /// Share of torn links, times the root of the number of points, that adds ln 2 before the
    /// weight. Unit: none. Source: calibrated on the scoreboard.
    pub torn_scale: f64,
    /// Share of the area without points that adds ln 2 on a closed surface. Unit: share. Source:
    /// calibrated on the scoreboard.
    pub uncovered_scale: f64,
    /// Share of the area with misaligned normals that adds ln 2. Unit: share. Source: calibrated
    /// on the scoreboard.
    pub misaligned_scale: f64,
    /// Share of neighboring cells whose normals turn over that adds ln 2. Unit: share. Source:
    /// calibrated on the scoreboard.
    pub folded_scale: f64,
    /// Share of a height field's rectangle without points that adds ln 2. Sheets end where the
    /// points end. Unit: share. Source: calibrated on the scoreboard.
    pub unfilled_scale: f64,
    /// Weight of pinched ends of a tube. Unit: none. Source: calibrated on the scoreboard.
    pub pinched_weight: f64,
    /// Cost of a closed direction. Unit: none. Source: calibrated on the scoreboard.
    pub closed_cost: f64,
    /// Cost of parameters that follow the surface, times the root of the number of points. By this
    /// much another hypothesis may be better than a height field by chance. Unit: none. Source:
    /// calibrated on the scoreboard.
    pub free_cost: f64,
}

impl ScoreSettings {
    /// The values that are used.
    pub const STANDARD: Self = Self {
        held_out_weight: 3.0,
        torn_weight: 3.0,
        torn_scale: 0.3,
        uncovered_scale: 0.02,
        misaligned_scale: 0.05,
        folded_scale: 0.01,
        unfilled_scale: 0.2,
        pinched_weight: 1.5,
        closed_cost: 1.5,
        free_cost: 4.0,
    };
}

impl Default for ScoreSettings {
    fn default() -> Self {
        Self::STANDARD
    }
}

/// Selection: which ranked hypotheses are refined, and when a refined surface is better.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SelectionSettings {
    /// Largest number of hypotheses that are refined. Unit: hypotheses. Source: cost: seconds of a
    /// call.
    pub(super) max_refined: usize,
    /// Score above the best, up to which hypotheses are refined. A surface far from the points is
    /// no better than one with defects. Unit: none. Source: calibrated on the scoreboard.
    pub(super) score_margin: f64,
    /// Score above the best, up to which first fits decide the order. Unit: none. Source:
    /// calibrated on the scoreboard.
    pub(super) similar_score: f64,
    /// Distance of the points from one surface over that from another, above which it is worse.
    /// Unit: ratio. Source: calibrated on the scoreboard.
    pub(super) max_error_ratio: f64,
    /// Folds that finer and repaired surfaces may have, in the share that makes a surface invalid.
    /// Unit: share. Source: calibrated on the scoreboard.
    pub(super) residual_fold_share: f64,
}

impl SelectionSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self {
        max_refined: 5,
        score_margin: 3.0,
        similar_score: 1.0,
        max_error_ratio: 1.2,
        residual_fold_share: 0.25,
    };
}

/// Initial net: rows and columns of control points before the net grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct InitialNetSettings {
    /// Fewest control points along a side. Unit: control points. Source: closed form: a cubic has
    /// four.
    pub(super) min_side: usize,
    /// Most control points along a side of the square net that growth begins with. Unit: control
    /// points. Source: calibrated on the scoreboard.
    pub(super) max_side: usize,
    /// Fewest control points around a tube: with ten, a circle deviates by 1e-4 of its radius.
    /// Unit: control points. Source: closed form: the deviation of a uniform cubic from a circle.
    pub(super) min_around: f64,
}

impl InitialNetSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self { min_side: 4, max_side: 12, min_around: 10.0 };
}

/// Self-organizing map of a reconstruction: its lattice and its training.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MapSettings {
    /// Largest number of points that the map is trained on. Unit: points. Source: cost: seconds of
    /// a call.
    pub(super) max_points: usize,
    /// Fewest points for each node: with fewer, the map follows single points. Unit: points.
    /// Source: calibrated on the scoreboard.
    pub(super) points_per_node: usize,
    /// Fewest nodes along an open side. Unit: nodes. Source: closed form: both ends and a middle.
    pub(super) min_side: usize,
    /// Fewest nodes around a closed direction: fewer may shrink to a point. Unit: nodes. Source:
    /// calibrated on the scoreboard.
    pub(super) min_around: usize,
    /// Epochs of training. Unit: epochs. Source: calibrated on the scoreboard.
    pub(super) epochs: u64,
    /// Radius of the neighborhood in the first epoch. Unit: cells. Source: calibrated on the
    /// scoreboard.
    pub(super) start_radius: f64,
    /// Radius of the neighborhood in the last epoch. Unit: cells. Source: calibrated on the
    /// scoreboard.
    pub(super) end_radius: f64,
}

impl MapSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self {
        max_points: 20_000,
        points_per_node: 3,
        min_side: 3,
        min_around: 12,
        epochs: 10,
        start_radius: 1.0,
        end_radius: 0.7,
    };
}

/// Fit of all points: border, robust weights and tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FitProblemSettings {
    /// Distance to which outer cells of the map extend for points beyond them. Unit: cells.
    /// Source: calibrated on the scoreboard.
    pub(super) extrapolation: f64,
    /// Distance to which the surface extends beyond the points by default. Unit: mean spacings.
    /// Source: closed form: a point stands for half a spacing on either side.
    pub(super) border: f64,
    /// Fairness of a surface that must reach a tolerance: it only fills regions without points.
    /// Unit: none. Source: rounding.
    pub(super) min_fairness: f64,
    /// Largest number of fits with new robust weights after the first. Unit: fits. Source: cost:
    /// seconds of a call.
    pub(super) max_reweightings: usize,
}

impl FitProblemSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self =
        Self { extrapolation: 0.75, border: 0.5, min_fairness: 1e-9, max_reweightings: 2 };
}

/// Trimming of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TrimmedSettings {
    /// Relative error of the areas. Unit: ratio. Source: closed form: below what a report shows.
    pub(super) accuracy: f64,
}

impl TrimmedSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self { accuracy: 1e-6 };
}

/// Repair: fairness is raised step by step until a surface neither folds nor overshoots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RepairSettings {
    /// Factor between neighboring steps of fairness. Unit: ratio. Source: calibrated on the
    /// scoreboard.
    pub(super) fairness_factor: f64,
    /// Number of steps. Unit: steps. Source: calibrated on the scoreboard.
    pub(super) steps: i32,
}

impl RepairSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self { fairness_factor: 8.0, steps: 7 };
}

/// Robust weights: which points are outliers of the fitted surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SurfaceOutlierSettings {
    /// Neighbors whose distances from the surface give the usual distance at a point. Where the
    /// surface cannot follow a feature, all are far from it and none is an outlier. Unit: points.
    /// Source: calibrated on the scoreboard.
    pub(super) k_neighbors: usize,
    /// Distance from the surface over that to the farthest neighbor, up to which a point is no
    /// outlier: it cannot have changed the surface's shape. Unit: ratio. Source: calibrated on the
    /// scoreboard.
    pub(super) max_slight_ratio: f64,
}

impl SurfaceOutlierSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self { k_neighbors: 16, max_slight_ratio: 0.1 };
}

/// Orientation: the side to which normals point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OrientationSettings {
    /// Cells along a side of the grid on which normals are summed. Unit: cells. Source: cost:
    /// milliseconds of a call.
    pub(super) cells: usize,
    /// Component of the mean normal along an axis, in its length, below which it is perpendicular
    /// to that axis. Unit: share. Source: rounding.
    pub(super) min_component: f64,
}

impl OrientationSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self { cells: 32, min_component: 1e-6 };
}

/// Diagnosis: limits from which a finding is reported.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DiagnoseSettings {
    /// Share of border points, times the root of the number of points, below which a cloud is
    /// closed. Unit: none. Source: calibrated on the scoreboard.
    pub(super) max_closed_border: f64,
    /// Share of the points in the second component, above which components are reported.
    /// Unit: share. Source: calibrated on the scoreboard.
    pub(super) min_component_share: f64,
    /// Share of points left out, above which they are reported. Unit: share. Source: calibrated
    /// on the scoreboard.
    pub(super) max_left_out_share: f64,
    /// Fewest points left out that are reported because they lie together. A pair may lie together
    /// by chance. Unit: points. Source: calibrated on the scoreboard.
    pub(super) min_group: usize,
    /// Distance of the points from the surface over their noise, up to which it follows them.
    /// Unit: ratio. Source: calibrated on the scoreboard.
    pub(super) max_noise_ratio: f64,
    /// Distance of the points from the surface over their diagonal, up to which it follows them.
    /// Unit: share. Source: calibrated on the scoreboard.
    pub(super) max_diagonal_share: f64,
}

impl DiagnoseSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self {
        max_closed_border: 0.12,
        min_component_share: 0.1,
        max_left_out_share: 0.01,
        min_group: 3,
        max_noise_ratio: 3.0,
        max_diagonal_share: 0.02,
    };
}
