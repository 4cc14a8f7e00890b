//! Plain-text export: STEP, IGES and OBJ for surfaces, OBJ for meshes.
//!
//! Numbers have as many digits as are needed to read back the same bits. Readers may still change
//! the surface. OpenCASCADE, for example, makes a closed net periodic and drops equal weights.

mod iges;
mod obj;
mod obj_surface;
mod step;

pub use self::iges::{write_iges, write_iges_in};
pub use self::obj::write_obj;
pub use self::obj_surface::write_obj_surface;
pub use self::step::{write_step, write_step_in};
