//! NURBS surfaces: knots, basis functions, the surface and its evaluation.
//!
//! u runs along the rows of a control net, v along its columns; arrays over a net are row-major,
//! v fastest.

mod algebra;
mod approximate;
mod area;
mod banded;
mod basis;
mod batch;
mod bezier;
mod closest_point;
mod columns;
mod construct;
mod curvature;
mod curve;
mod curve_algebra;
mod derivatives;
mod elevate;
mod evaluate;
mod frame;
pub(crate) mod gauss;
mod grid;
mod interpolate;
mod isocurve;
mod knot_vector;
mod measure;
mod net;
mod ordered;
mod parts;
mod patch_nets;
mod piece_tree;
mod remove;
mod scattered;
mod span_table;
mod strip;
mod surface;
mod vertex;

pub(crate) use self::basis::{Basis, BasisDerivatives, MAX_ORDER, padded, window};
pub(crate) use self::bezier::halve;
pub(crate) use self::knot_vector::check_degree;
pub(crate) use self::patch_nets::PatchNets;

pub use self::algebra::Direction;
pub use self::batch::Outside;
pub use self::closest_point::{ClosestPoint, ClosestPointSearch, ClosestPointSlices};
pub use self::curvature::{Curvature, CurvatureSlices, Form, FundamentalForms};
pub use self::curve::NurbsCurve;
pub use self::derivatives::MAX_DERIVATIVE;
pub use self::interpolate::{GridOptions, Parametrization};
pub use self::knot_vector::{KnotVector, MAX_DEGREE};
pub use self::ordered::OrderedSurface;
pub use self::surface::NurbsSurface;
