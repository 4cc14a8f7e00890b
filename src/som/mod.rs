//! The self-organizing map (Kohonen network): a lattice of nodes trained on scattered points.
//!
//! The nodes form a [`Lattice`]; the three weights of a node are its position in space. A point
//! moves its nearest node, the *winner*, and the winner's neighbors on the lattice, which keeps the
//! nodes in order. The neighborhood shrinks during training. [`Training::Online`] is the paper's
//! algorithm, one point at a time ([`SomOptions::paper`]). [`Training::Batch`] is Kohonen's batch
//! map, which costs O(n log m + m (rows + cols)) per epoch for n points and m nodes.
//!
//! ```
//! use neurbs::{DVec3, progress::Silent};
//! use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
//!
//! let points: Vec<DVec3> = (0..2000)
//!     .map(|i| {
//!         let (x, y) = (f64::from(i % 50) / 49.0, f64::from(i / 50) / 39.0);
//!         DVec3::new(x, y, 0.2 * (3.0 * x).sin() * y)
//!     })
//!     .collect();
//! let options = SomOptions::default();
//! let som = SelfOrganizingMap::fit(&points, Lattice::quad(12, 10)?, &options, &mut Silent)?;
//! assert!(som.quantization_error(&points, &mut Silent)? < 0.05);
//! let uv = som.parametrize(&points, 0.75, &mut Silent)?;
//! assert!(uv.iter().all(|uv| uv.min_element() >= 0.0 && uv.max_element() <= 1.0));
//! # Ok::<(), neurbs::Error>(())
//! ```
//!
//! [`SelfOrganizingMap::new`] creates an untrained map and [`SelfOrganizingMap::train`] continues
//! from its current state. A map can be queried and saved ([`SelfOrganizingMap::to_bytes`]) at any
//! step, also after an interruption. Continued training gives the same result as without the
//! interruption.

mod batch;
mod batch_sums;
mod eigen;
mod frame;
mod frame_bytes;
mod gaussian;
mod gaussian_sums;
mod geodesic;
mod graph;
mod grid;
mod initialize;
mod landmark_isomap;
mod lattice;
mod map;
mod nearest_lists;
mod node_sums;
mod octree;
mod online;
mod online_state;
mod options;
mod ordered_start;
mod parametrize;
mod parts;
mod presentation_order;
mod quality;
mod random;
mod report;
mod sampling;
mod schedule;
mod search;
mod serialization;
mod simd_nodes;
mod smoothing;
mod stop_criterion;
mod streaming;
mod topology;
mod training;
mod triangular;

pub use self::batch_sums::BatchSums;
pub use self::geodesic::unroll;
pub use self::landmark_isomap::LandmarkMap;
pub use self::lattice::{Lattice, MAX_NODES};
pub use self::map::SelfOrganizingMap;
pub use self::options::{Init, Kernel, Neighborhood, Presentation, SomOptions, Training};
pub use self::ordered_start::spread_out;
pub use self::schedule::Schedule;
pub use self::stop_criterion::StoppedBy;
pub use self::streaming::Sampler;
pub use self::topology::{Cells, Topology};
