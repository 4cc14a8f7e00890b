//! Settings of the stages of a fit: every threshold, with its unit and its source.
//!
//! The scoreboard that calibrated them is `benches/scoreboard.py`; see the [crate](crate).

/// Least squares: rounding, sample sizes and the distances that are minimized.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LeastSquaresSettings {
    /// Relative size below which a determinant or a cross product is zero. Unit: ratio. Source:
    /// rounding.
    pub(super) zero_ratio: f64,
    /// Share of the mean diagonal entry added for unknowns that no sample touches. Unit: share.
    /// Source: rounding.
    pub(super) ridge: f64,
    /// Share of the mean diagonal entry added against negative pivots. Unit: share. Source:
    /// rounding.
    pub(super) rounding_ridge: f64,
    /// Distance of a control point from the origin above which the net is undetermined. Unit:
    /// extents of the points. Source: rounding.
    pub(super) max_control_point_distance: f64,
    /// Weight of distances in the tangent plane, beside 1 along the normal. Less lets the net
    /// slide away, more converges slowly. Unit: ratio. Source: calibrated on the scoreboard.
    pub(super) tangential_weight: f64,
    /// Samples that a statistic is taken of, at most. Unit: samples. Source: cost: statistics
    /// take less time than the fit.
    pub(super) max_samples: usize,
    /// Points that suffice for the shape and the error of a surface. Unit: points. Source: cost:
    /// more points change neither.
    pub(super) enough_points: usize,
}

impl LeastSquaresSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self {
        zero_ratio: 1e-12,
        ridge: 1e-10,
        rounding_ridge: 1e-14,
        max_control_point_distance: 1e6,
        tangential_weight: 0.01,
        max_samples: 20_000,
        enough_points: 2000,
    };
}

/// Alternating fit: solutions for the net in turn with parameter correction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AlternatingFitSettings {
    /// Points used for each control point until the last solutions. Unit: points. Source: cost:
    /// more points change the noise in the surface, not its shape.
    pub(super) points_per_control_point: usize,
    /// Relative decrease of the error below which iterations end. Unit: share. Source: calibrated
    /// on the scoreboard.
    pub(super) min_decrease: f64,
    /// Relative decrease of the error with which iterations continue beyond their limit. Unit:
    /// share. Source: calibrated on the scoreboard.
    pub(super) min_extended_decrease: f64,
    /// Multiple of the iteration limit that fast convergence may use. Unit: ratio. Source:
    /// calibrated on the scoreboard.
    pub(super) extension: usize,
    /// Control points of the coarsest net, at most, unless the first net has more. Unit: points.
    /// Source: calibrated on the scoreboard.
    pub(super) max_coarse_control_points: usize,
    /// Samples in each direction by which isocurve lengths are measured. Unit: points. Source:
    /// cost: more change the lengths little.
    pub(super) length_samples: usize,
}

impl AlternatingFitSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self {
        points_per_control_point: 16,
        min_decrease: 0.06,
        min_extended_decrease: 0.5,
        extension: 4,
        max_coarse_control_points: 300,
        length_samples: 24,
    };
}

/// Fairness: its weight and anisotropy by cross-validation and marginal likelihood.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FairnessSettings {
    /// Weight at the first solution, whose parameters are rough. Unit: none. Source: calibrated on
    /// the scoreboard.
    pub(super) first_weight: f64,
    /// Least weight: it determines control points that no point touches. Unit: none. Source:
    /// calibrated on the scoreboard.
    pub(super) min_weight: f64,
    /// Share of the weight that remains after each solution with a coarse net. More flattens
    /// folded sheets, less follows noise. Unit: share. Source: calibrated on the scoreboard.
    pub(super) decay: f64,
    /// The same with the finest net. Unit: share. Source: calibrated on the scoreboard.
    pub(super) final_decay: f64,
    /// Weight above which points are noisy, and cross-validation is repeated early. Unit: none.
    /// Source: calibrated on the scoreboard.
    pub(super) noisy_weight: f64,
    /// Decimal logarithms of the least and largest weight that cross-validation tries. A lower
    /// weight has no effect; a higher one leaves little more than a quadratic surface. Unit:
    /// decades. Source: calibrated on the scoreboard.
    pub(super) exponents: (f64, f64),
    /// First step of the search for the weight. Unit: decades. Source: calibrated on the
    /// scoreboard.
    pub(super) first_exponent_step: f64,
    /// Steps of the search are longer than this. Unit: decades. Source: calibrated on the
    /// scoreboard.
    pub(super) min_exponent_step: f64,
    /// Degrees of freedom of net and parameters together, for each of the net. Unit: ratio.
    /// Source: calibrated on the scoreboard.
    pub(super) freedom_factor: f64,
    /// Degrees of freedom of a surface over the points, at most. Unit: share. Source:
    /// calibrated on the scoreboard.
    pub(super) max_freedom_share: f64,
    /// Groups of cross-validation. Unit: groups. Source: calibrated on the scoreboard.
    pub(super) groups: usize,
    /// Blocks in a group, at most, and mean samples in a block where samples are few. Unit: blocks.
    /// Source: calibrated on the scoreboard.
    pub(super) blocks_per_group: usize,
    /// Occupied cells of a grid with as many cells as samples, below which samples lie in clumps.
    /// Unit: share. Source: closed form: random samples occupy 0.63 of a square, 0.50 of one
    /// around a disc.
    pub(super) min_occupied: f64,
    /// Anisotropy, at most; its inverse is the least. Beyond, one direction is undetermined where
    /// no points are. Unit: ratio. Source: calibrated on the scoreboard.
    pub(super) max_anisotropy: f64,
    /// Share of the unknowns whose freedom the energy must remove before the anisotropy is
    /// estimated. Unit: share. Source: calibrated on the scoreboard.
    pub(super) min_freedom_removed: f64,
    /// Share of the mean diagonal entry added to the energy before it is inverted. Unit: share.
    /// Source: rounding.
    pub(super) anisotropy_ridge: f64,
    /// Step to which the anisotropy's natural logarithm is rounded. Unit: none. Source: rounding.
    pub(super) anisotropy_step: f64,
}

impl FairnessSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self {
        first_weight: 1.0,
        min_weight: 1e-4,
        decay: 0.5,
        final_decay: 0.25,
        noisy_weight: 0.1,
        exponents: (-4.0, 3.0),
        first_exponent_step: 0.5,
        min_exponent_step: 0.2,
        freedom_factor: 1.2,
        max_freedom_share: 0.9,
        groups: 5,
        blocks_per_group: 12,
        min_occupied: 0.45,
        max_anisotropy: 10.0,
        min_freedom_removed: 0.1,
        anisotropy_ridge: 1e-6,
        anisotropy_step: 0.01,
    };
}

/// Projection: foot points by Gauss-Newton steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ProjectionSettings {
    /// Longest step of a parameter. Unit: shares of the domain. Source: calibrated on the
    /// scoreboard.
    pub(super) max_step: f64,
    /// Step below which the iteration ends. Unit: shares of the domain. Source: rounding.
    pub(super) converged_step: f64,
    /// Ratio of squared distances below which a step does not increase the distance. Unit: ratio.
    /// Source: rounding.
    pub(super) max_increase: f64,
    /// Halvings of a step that increases the distance, at most. Unit: halvings. Source: calibrated
    /// on the scoreboard.
    pub(super) max_halvings: usize,
    /// Steps from parameters that may be far from the foot point. Unit: steps. Source: calibrated
    /// on the scoreboard.
    pub(super) first_steps: usize,
    /// Steps from the parameters of the solution before. Unit: steps. Source: calibrated on the
    /// scoreboard.
    pub(super) steps: usize,
}

impl ProjectionSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self {
        max_step: 0.2,
        converged_step: 1e-9,
        max_increase: 1.0 + 1e-12,
        max_halvings: 4,
        first_steps: 4,
        steps: 2,
    };
}

/// Robust weights: Tukey's biweight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BiweightSettings {
    /// Distance from which on the weight is 0. Less removes details while the surface is coarse.
    /// Unit: standard deviations. Source: P. Huber, *Robust Statistics*, 1981.
    pub(super) cutoff: f64,
}

impl BiweightSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self { cutoff: 4.7 };
}

/// Coarse fit: a small net by which hypotheses are compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoarseSettings {
    /// Points for each control point. Unit: points. Source: calibrated on the scoreboard.
    pub points_per_control_point: usize,
    /// Least and largest number of control points. Unit: points. Source: calibrated on the
    /// scoreboard.
    pub control_points: (usize, usize),
    /// Control points of the quick fits by which poor hypotheses are dropped, at most. Unit:
    /// points. Source: calibrated on the scoreboard.
    pub quick_control_points: usize,
    /// Control points along a side, at most. Unit: points. Source: calibrated on the scoreboard.
    pub max_side: usize,
    /// Control points along an open and along a closed side, at least. Unit: points. Source:
    /// calibrated on the scoreboard.
    pub min_side: (usize, usize),
    /// Ratio of length to width, at most, by which the net is shaped. Unit: ratio. Source:
    /// calibrated on the scoreboard.
    pub aspect: f64,
    /// Solutions; a parameter correction follows each but the last. Unit: solutions. Source:
    /// calibrated on the scoreboard.
    pub rounds: usize,
    /// Weight of the fairness against the points, at least, in the first round. Unit: none.
    /// Source: calibrated on the scoreboard.
    pub first_fairness: f64,
    /// Decimal logarithms of the least and largest weight of the fairness. Unit: decades. Source:
    /// calibrated on the scoreboard.
    pub fairness_exponents: (i32, i32),
    /// Decimal logarithm of the weight that the search begins with. Unit: decades. Source:
    /// calibrated on the scoreboard.
    pub first_exponent: i32,
    /// Projection steps for points that were left out. Unit: steps. Source: calibrated on the
    /// scoreboard.
    pub held_out_steps: usize,
}

impl CoarseSettings {
    /// The values that are used.
    pub const STANDARD: Self = Self {
        points_per_control_point: 5,
        control_points: (20, 144),
        quick_control_points: 80,
        max_side: 36,
        min_side: (4, 6),
        aspect: 12.0,
        rounds: 5,
        first_fairness: 0.02,
        fairness_exponents: (-6, 3),
        first_exponent: -2,
        held_out_steps: 2,
    };
}

impl Default for CoarseSettings {
    fn default() -> Self {
        Self::STANDARD
    }
}

/// Adaptive refinement: knots inserted until a tolerance holds or the error stops falling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RefinementSettings {
    /// Share of the squared error in the spans that are divided. Unit: share. Source: calibrated
    /// on the scoreboard.
    pub(super) divided_error: f64,
    /// The same, at least, where the number of control points is limited. Unit: share. Source:
    /// calibrated on the scoreboard.
    pub(super) min_divided_error: f64,
    /// Ratio of expected errors after and before a refinement, at most, for it to continue. Unit:
    /// ratio. Source: calibrated on the scoreboard.
    pub(super) max_error_ratio: f64,
    /// Points for each control point, at least. Unit: points. Source: calibrated on the
    /// scoreboard.
    pub(super) points_per_control_point: usize,
    /// Points up to which one point for each control point suffices. Unit: points. Source:
    /// calibrated on the scoreboard.
    pub(super) few_points: usize,
    /// Rms error below which the fit is exact. Unit: diameters of the cloud. Source: calibrated on
    /// the scoreboard.
    pub(super) exact_error: f64,
    /// Ratio of the mean span lengths of both directions, at most. Unit: ratio. Source: calibrated
    /// on the scoreboard.
    pub(super) max_aspect: f64,
    /// Correlation of neighboring residuals up to which they are noise. Unit: standard deviations
    /// of the correlation of noise. Source: closed form: 95 % of normal deviates.
    pub(super) noise_deviations: f64,
}

impl RefinementSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self {
        divided_error: 0.85,
        min_divided_error: 0.01,
        max_error_ratio: 0.95,
        points_per_control_point: 3,
        few_points: 256,
        exact_error: 1e-5,
        max_aspect: 4.0,
        noise_deviations: 2.0,
    };
}

/// Height fields: fairness, base rectangle and overshoot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HeightSettings {
    /// Decimal logarithms of the least and largest weight of the fairness. Unit: decades. Source:
    /// calibrated on the scoreboard.
    pub(super) exponents: (i32, i32),
    /// Ratio of the error to the least error, at most, for a larger fairness to be preferred.
    /// Unit: ratio. Source: calibrated on the scoreboard.
    pub(super) max_error_ratio: f64,
    /// Ratio of the error to that of a simpler fit, below which the difference is no chance. Unit:
    /// ratio. Source: closed form: one minus the standard error of the rms of 2000 held-out points,
    /// 1.6 %.
    pub(super) significant_error_ratio: f64,
    /// Control points for each point, at most. Unit: ratio. Source: calibrated on terrain along
    /// tracks: finer nets are no nearer.
    pub(super) max_control_points_per_point: usize,
    /// Factors by which the anisotropy changes while that improves the prediction, where points lie
    /// in rows, tracks or clumps. Unit: ratio. Source: calibrated on the scoreboard.
    pub(super) anisotropy_steps: [f64; 2],
    /// Points below which the energy is of second order, since a quadratic overshoots in the
    /// corners. Unit: points. Source: calibrated on the scoreboard.
    pub(super) min_points_for_third_order: usize,
    /// Share of a quadratic term that the other terms do not explain, below which all places lie
    /// on one conic. Unit: share. Source: rounding.
    pub(super) min_conic_share: f64,
    /// Distance beyond the range of the heights, at most. Unit: ranges of the heights. Source:
    /// calibrated on the scoreboard.
    pub(super) max_overshoot: f64,
    /// Factor by which the reach of slopes shrinks while the surface overshoots. Unit: ratio.
    /// Source: calibrated on the scoreboard.
    pub(super) reach_factor: f64,
    /// Shortest reach of slopes. Unit: shares of the base's side. Source: calibrated on the
    /// scoreboard.
    pub(super) min_reach: f64,
    /// Distance from a side up to which a point lies on it. Unit: shares of the base's side.
    /// Source: rounding.
    pub(super) side_tolerance: f64,
    /// Extension of the base beyond the outermost points, at most. Unit: shares of the base's
    /// side. Source: calibrated on the scoreboard.
    pub(super) max_extension: f64,
}

impl HeightSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self {
        exponents: (-12, 2),
        max_error_ratio: 1.01,
        significant_error_ratio: 0.98,
        max_control_points_per_point: 2,
        anisotropy_steps: [0.1, 10.0],
        min_points_for_third_order: 30,
        min_conic_share: 1e-4,
        max_overshoot: 0.5,
        reach_factor: 0.25,
        min_reach: 1.0 / 64.0,
        side_tolerance: 1e-9,
        max_extension: 0.02,
    };

    /// The same ratio of squared errors.
    pub(super) fn significant_ratio(&self) -> f64 {
        self.significant_error_ratio.powi(2)
    }
}

/// Rational fit: control points and weights together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RationalSettings {
    /// Different control points, at most: the equations are dense. Unit: points. Source: cost:
    /// a step takes time by the cube of their number.
    pub(super) max_control_points: usize,
    /// Least and largest weight. Unit: mean weights. Source: calibrated on the scoreboard.
    pub(super) weights: (f64, f64),
    /// Gauss-Newton steps, at most. Unit: steps. Source: calibrated on the scoreboard.
    pub(super) max_steps: usize,
    /// Halvings of a step that increases the error, at most. Unit: halvings. Source: calibrated on
    /// the scoreboard.
    pub(super) max_halvings: i32,
    /// Relative decrease of the mean squared distance below which the steps end. Unit: share.
    /// Source: calibrated on the scoreboard.
    pub(super) min_step_decrease: f64,
    /// Relative decrease of the mean squared distance that justifies a rational surface. Unit:
    /// share. Source: calibrated on the scoreboard.
    pub(super) min_decrease: f64,
}

impl RationalSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self = Self {
        max_control_points: 256,
        weights: (0.1, 10.0),
        max_steps: 30,
        max_halvings: 5,
        min_step_decrease: 0.01,
        min_decrease: 0.05,
    };
}

/// Straight sides of the domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SideSettings {
    /// Width of the domain at either end between straight sides, at least. Unit: mean widths.
    /// Source: calibrated on the scoreboard.
    pub(super) min_width: f64,
    /// Strips by which the points next to a straight side are found. Unit: strips. Source: cost:
    /// more change nothing visible.
    pub(super) hull_strips: usize,
    /// Margin of the surface beyond the points, at most. Unit: spacings of the control points.
    /// Source: calibrated on the scoreboard.
    pub(super) max_margin: f64,
}

impl SideSettings {
    /// The values that are used.
    pub(super) const STANDARD: Self =
        Self { min_width: 0.6, hull_strips: 1 << 12, max_margin: 0.5 };
}
