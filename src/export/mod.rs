//! Plain-text files: STEP and IGES for surfaces, OBJ for meshes.
//!
//! Numbers are written with as many digits as it takes to read the same bits back. What a reader
//! makes of them is its own affair: OpenCASCADE, for one, turns a net that is closed into a periodic
//! one, and drops weights that are all the same.

mod iges;
mod obj;
mod step;

pub use self::iges::write_iges;
pub use self::obj::write_obj;
pub use self::step::write_step;
