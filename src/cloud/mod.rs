//! Preparation of a cloud: checks, duplicates, outliers, components, local frame, neighbors,
//! samples.

mod bounds;
mod checks;
mod clean;
mod components;
mod convex_hull;
mod even_sample;
mod frame;
mod kd_tree;
mod neighbor_graph;
mod no_data;
mod normalization;
mod plane;
mod prepared_cloud;
mod sampling;
mod set_links;
mod settings;
#[cfg(test)]
mod test_points;

pub use self::bounds::{Bounds, centroid};
pub(crate) use self::bounds::{batches, interruptible_centroid};
pub use self::checks::{check, check_finite};
pub(crate) use self::checks::{checked_bounds, checked_extent, finite_bounds};
pub use self::clean::{Cleaning, Fate, clean};
pub use self::components::{Components, components};
pub(crate) use self::convex_hull::{
    convex_hull, in_axes, is_in_hull, min_area_rectangle, polygon_area,
};
pub use self::even_sample::EvenSample;
pub use self::frame::{Frame, LocalObserver};
pub use self::kd_tree::{KdTree, Neighbor};
pub use self::neighbor_graph::{Edge, NeighborGraph};
pub use self::no_data::{NoData, no_data};
pub use self::normalization::Normalization;
pub use self::plane::Plane;
pub use self::prepared_cloud::{PrepareOptions, PreparedCloud};
pub(crate) use self::sampling::items_at;
pub use self::sampling::{even_sample, random_sample};
