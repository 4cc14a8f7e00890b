//! Observations of a cloud: local planes, noise, graphs, border. Graphs and border are computed on
//! first use and kept. No decision is made here.

mod border;
mod local_planes;
mod observations;
mod settings;
mod surface_graph;

pub use self::local_planes::LocalPlanes;
pub use self::observations::Observations;
pub use self::settings::ObserveSettings;
