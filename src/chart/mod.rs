//! Charts: ways to put points on a parameter domain. Each is a file with one [`Chart`] and one
//! entry of [`CHARTS`].

mod angles;
mod bounding_rectangle;
mod center_line;
mod hypothesis;
mod input;
mod isomap;
mod kind;
mod plane;
mod polar;
mod revolved;
mod settings;
mod traits;

pub use self::hypothesis::Hypothesis;
pub use self::input::ChartInput;
pub use self::kind::Kind;
pub use self::traits::Chart;

/// All charts, cheapest first.
pub const CHARTS: [&dyn Chart; 5] =
    [&plane::Plane, &revolved::Revolved, &isomap::Isomap, &polar::Polar, &center_line::CenterLine];
