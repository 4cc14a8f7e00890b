//! A cloud made ready: checks, duplicates, outliers, components, frame, neighbours, even samples.

mod bounds;
mod checks;
mod clean;
mod components;
mod even_sample;
mod frame;
mod hull;
mod kd_tree;
mod neighbor_graph;
mod no_data;
mod normalization;
mod partition;
mod plane;
mod prepared_cloud;
#[cfg(test)]
mod test_points;

pub use self::bounds::{Bounds, centroid};
pub(crate) use self::bounds::{listened_centroid, portions};
pub use self::checks::{check, check_finite};
pub(crate) use self::checks::{checked_bounds, finite_bounds};
pub use self::clean::{Cleaning, Fate, clean};
pub use self::components::{Components, components};
pub(crate) use self::even_sample::items_at;
pub use self::even_sample::{EvenSample, even_sample, random_sample};
pub use self::frame::{Frame, LocalObserver};
pub(crate) use self::hull::{area, hull, least_rectangle, turned};
pub use self::kd_tree::{KdTree, Neighbor};
pub use self::neighbor_graph::{Edge, NeighborGraph};
pub use self::no_data::{NoData, no_data};
pub use self::normalization::Normalization;
pub use self::plane::Plane;
pub use self::prepared_cloud::{PrepareOptions, PreparedCloud};
