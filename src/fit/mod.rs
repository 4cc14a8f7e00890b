//! Least squares: NURBS surfaces fitted to points.
//!
//! The input is points with parameters, known or rough; output is a surface. The fit minimizes the
//! weighted sum of squared distances from the points to the surface, plus the fairness energy (G.
//! Greiner, *Surface construction based on variational principles*, 1994). The normal equations
//! (`normal_equations`) are sparse and positive definite. Their size depends on the control points,
//! not on the points.

mod adaptive_refinement;
mod alternating_fit;
mod anisotropy;
mod approximate_scattered;
mod band_matrix;
mod band_solve;
mod base_domain;
mod biweight;
mod coarse_fit;
mod dense_matrix;
mod fairness_choice;
mod fairness_energy;
mod fit_result;
mod height_cv;
mod height_field;
mod height_fit;
mod held_out_groups;
mod isocurve_length;
mod least_squares;
mod normal_equations;
mod options;
mod partial_sums;
mod patches;
mod plane_trend;
mod projection;
mod rational;
mod recover;
mod residual_correlation;
mod settings;
mod sizes;
mod span_division;
mod spline_space;
mod straight_sides;
mod validation_groups;
mod warm_start;

pub(crate) use self::adaptive_refinement::{Accept, EXACT_ERROR, diameter};
pub use self::approximate_scattered::approximate;
pub(crate) use self::approximate_scattered::{FittedSurface, continued};
pub(crate) use self::base_domain::BasePlane;
pub use self::base_domain::height_axes;
pub(crate) use self::biweight::{MAD_TO_DEVIATION, biweight, cutoff_distance};
pub use self::biweight::{biweights, robust_weights};
pub use self::coarse_fit::{CoarseFit, CoarseProblem, coarse, quick_error};
pub use self::fit_result::{Approximation, EndedBy, HeightFit};
pub use self::height_fit::fit_heights;
pub(crate) use self::height_fit::grow_heights;
pub use self::isocurve_length::isocurve_lengths;
pub use self::least_squares::fit;
pub use self::options::{ApproximateOptions, FitOptions, Growth, HeightOptions};
pub(crate) use self::options::{check_fairness, check_weights};
pub use self::partial_sums::PartialSums;
pub use self::projection::project;
pub use self::rational::fit_weights;
pub use self::recover::recover_net;
pub use self::settings::CoarseSettings;
pub use self::span_division::refined_knots;
pub use self::straight_sides::bounded;
pub use self::validation_groups::ValidationGroups;
