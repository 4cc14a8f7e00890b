//! NURBS surfaces: knots, basis functions, the surface and its evaluation.
//!
//! u runs along the rows of a control net, v along its columns; arrays over a net are row-major,
//! v fastest.

mod basis;
mod evaluate;
mod knot_vector;
mod surface;

pub(crate) use self::knot_vector::check_degree;
pub use self::knot_vector::{KnotVector, MAX_DEGREE};
pub use self::surface::NurbsSurface;
