//! Plain-text files: STEP, IGES and OBJ for surfaces, OBJ for meshes.
//!
//! Numbers are written with as many digits as it takes to read the same bits back. What a reader
//! makes of them is its own affair: OpenCASCADE, for one, turns a net that is closed into a periodic
//! one, and drops weights that are all the same.

mod iges;
mod obj;
mod obj_surface;
mod step;
mod unit;

pub use self::iges::{write_iges, write_iges_in};
pub use self::obj::write_obj;
pub use self::obj_surface::write_obj_surface;
pub use self::step::{write_step, write_step_in};
pub use self::unit::LengthUnit;
