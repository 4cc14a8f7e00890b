//! What could be wrong with points or with a surface through them, in numbers and in words.

mod body;
mod defects;
mod excursion;
mod fold_over;
mod layers;
mod overshoot;
mod samples;
mod units;

pub(crate) use self::body::Body;
pub(crate) use self::defects::defects;
pub use self::defects::validate;
pub use self::excursion::{Excursion, excursion};
pub(crate) use self::fold_over::folds;
pub use self::fold_over::{FoldOver, fold_over};
pub(crate) use self::layers::not_followed;
pub use self::layers::{DoubleLayer, double_layer};
pub(crate) use self::overshoot::{OUTSIDE, run_out, runaways};
pub use self::overshoot::{Overshoot, overshoot};
pub(crate) use self::samples::{Flaw, Samples};
pub(crate) use self::units::UNEVEN;
pub use self::units::{UnevenExtents, uneven_extents};
