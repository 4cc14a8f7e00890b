//! What a cloud shows: each thing computed once, when it is asked for first, and kept. Nothing is
//! decided here.

mod border;
mod links;
mod local_planes;
mod observations;
mod settings;

pub use self::local_planes::LocalPlanes;
pub use self::observations::Observations;
pub use self::settings::ObserveSettings;
