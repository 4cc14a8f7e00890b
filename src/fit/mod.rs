//! Least squares: NURBS surfaces fitted to points.
//!
//! Input are points with parameters, known or rough; output is a surface. The fit minimizes the
//! weighted sum of squared distances from the points to the surface, plus the fairness energy (G.
//! Greiner, *Surface construction based on variational principles*, 1994). The normal equations
//! (`normal_equations`) are sparse and positive definite. Their size depends on the control points,
//! not on the points.

mod adaptive_refinement;
mod alternating_fit;
mod anisotropy;
mod approximate;
mod band_matrix;
mod band_solve;
mod base_domain;
mod biweight;
mod boundary;
mod coarse_fit;
mod cross_validation;
mod dense_matrix;
mod fairness;
mod fit_result;
mod folds;
mod height_cv;
mod height_field;
mod height_fit;
mod isocurve_length;
mod k_fold;
mod knot_insertion;
mod least_squares;
mod normal_equations;
mod options;
mod patches;
mod plane_trend;
mod projection;
mod rational;
mod recover;
mod residual_correlation;
mod settings;
mod sizes;
mod spline_space;
mod warm_start;

pub(crate) use self::adaptive_refinement::{Accept, EXACT_ERROR, diameter};
pub use self::approximate::approximate;
pub(crate) use self::approximate::{FittedSurface, continued};
pub(crate) use self::base_domain::BasePlane;
pub use self::base_domain::height_axes;
pub use self::biweight::biweights;
pub(crate) use self::biweight::{MAD_TO_DEVIATION, biweight, cutoff_distance};
pub use self::boundary::bounded;
pub use self::coarse_fit::{CoarseFit, CoarseProblem, coarse, quick_error};
pub use self::fit_result::{Approximation, EndedBy, HeightFit};
pub use self::folds::Folds;
pub use self::height_fit::fit_heights;
pub(crate) use self::height_fit::grow_heights;
pub(crate) use self::isocurve_length::isocurve_lengths;
pub use self::least_squares::{PartialSums, fit};
pub use self::options::{ApproximateOptions, FitOptions, Growth, HeightOptions};
pub use self::projection::project;
pub use self::rational::fit_weights;
pub use self::recover::recover_net;
pub use self::settings::CoarseSettings;
