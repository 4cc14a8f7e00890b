//! Least squares: the surface closest to points whose parameters are known.
//!
//! Minimized is the weighted sum of squared distances from each point to the surface at its
//! parameters, plus fairness times the thin-plate energy (G. Greiner, *Surface construction based
//! on variational principles*, 1994). The normal equations (`normal_equations`) are sparse and
//! positive definite; no matrix has a side as long as there are points.

mod anisotropy;
mod approximate;
mod band;
mod blocks;
mod border;
mod coarse;
mod correct;
mod cross_validation;
mod dense;
mod edge;
mod fairness;
mod fitting;
mod folds;
mod ground;
mod growth;
mod height;
mod height_cv;
mod height_field;
mod held_out;
mod least_squares;
mod lengths;
mod likelihood;
mod limits;
mod normal_equations;
mod options;
mod outcome;
mod outline;
mod patches;
mod rational;
mod recover;
mod refine;
mod residuals;
mod rim;
mod robust;
mod space;
mod substitution;
mod trend;
mod view;
mod warm_start;

pub use self::approximate::approximate;
pub(crate) use self::approximate::{FittedSurface, continued};
pub use self::border::bounded;
pub use self::coarse::{CoarseFit, CoarseProblem, CoarseSettings, coarse, quick_error};
pub use self::correct::project;
pub use self::folds::Folds;
pub(crate) use self::ground::Base;
pub use self::ground::height_axes;
pub(crate) use self::growth::{Accept, EXACT, diameter};
pub use self::height::fit_heights;
pub(crate) use self::height::grow_heights;
pub use self::least_squares::{PartialSums, fit};
pub(crate) use self::lengths::lengths;
pub use self::options::{ApproximateOptions, FitOptions, Growth, HeightOptions};
pub use self::outcome::{Approximation, EndedBy, HeightFit};
pub use self::rational::fit_weights;
pub use self::recover::recover_net;
pub use self::robust::biweights;
pub(crate) use self::robust::{NORMAL, biweight, reach};
