//! Trimming: the faces of a surface that end where the points end.
//!
//! Points' parameters are triangulated in the lengths of the surface. Triangles with large
//! circumcircles are bays and holes (H. Edelsbrunner, D. Kirkpatrick and R. Seidel 1983). The
//! borders of the rest become smooth curves with corners, moved out by the depth of the border
//! points. Loops are proved to be simple and disjoint.

mod adjacency;
mod arc;
mod arc_length;
mod border;
mod clip;
mod closed_polygon;
mod corner_check;
mod corners;
mod coverage;
mod level;
mod loop_curves;
mod normal_matrix;
mod offset;
mod options;
mod outcome;
mod outline;
mod outside;
mod pinches;
mod places;
mod polygon;
mod ragged;
mod rectangle_distance;
mod region;
mod seam;
mod settings;
mod spacing;
mod spline_fit;
mod stretch;
mod thresholds;
mod triangulation;
mod trimming;

pub use self::options::TrimOptions;
pub use self::outcome::{Doubt, LoopOutcome, Trim};
pub use self::outline::LoopForm;
pub use self::trimming::trim;
