//! Plain-text export: STEP, IGES and OBJ for shells, OBJ for meshes.
//!
//! A surface is written as the shell of one face. Numbers have as many digits as are needed to read
//! back the same bits. Readers may still change the surface. OpenCASCADE, for example, makes a
//! closed net periodic and drops equal weights.

mod bodies;
mod boundary;
mod common;
mod iges;
mod obj;
mod obj_shell;
mod orientation;
mod step;

pub use self::iges::write_iges;
pub use self::obj::write_obj;
pub use self::obj_shell::write_obj_shells;
pub use self::step::{StepOptions, write_step};
