//! Faces, edges, loops and shells: the boundary representation of CAD files.
//!
//! A [`Face`] is a surface with one outer [`Loop`] and any number of inner ones. A loop is a closed
//! chain of curves in (u, v), with the face on their left. A [`Shell`] joins faces along common
//! [`Edge`]s. Each edge is used by one loop (a border) or by two in opposite directions.

mod affine;
mod border_curve;
mod bounding_box;
mod contains;
mod crease;
mod edge;
mod edge_curve;
mod edge_matching;
mod face;
mod face_search;
mod face_strips;
mod length_unit;
mod loop_check;
mod loop_tree;
mod loops;
mod measure;
mod pcurve;
mod piecewise_cubic;
mod plane_curves;
mod section;
mod settings;
mod shell;
mod shell_builder;
mod sides;
mod strip;
#[cfg(test)]
mod test_faces;

pub(crate) use self::plane_curves::crossings_with_line;

pub use self::edge::{Edge, EdgeUse};
pub use self::face::Face;
pub use self::face_search::{FacePoint, FaceSearch};
pub use self::length_unit::LengthUnit;
pub use self::loops::{Coedge, Loop};
pub use self::shell::Shell;
