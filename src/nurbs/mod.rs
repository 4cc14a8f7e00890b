//! NURBS surfaces: knots, basis functions, the surface and its evaluation.
//!
//! u runs along the rows of a control net, v along its columns; arrays over a net are row-major,
//! v fastest.

mod algebra;
mod banded;
mod basis;
mod bezier;
mod closest_point;
mod construct;
mod curvature;
mod curve;
mod derivatives;
mod elevate;
mod evaluate;
mod frame;
pub(crate) mod gauss;
mod grid;
mod interpolate;
mod knot_vector;
mod measure;
mod ordered;
mod remove;
mod strip;
mod surface;

pub(crate) use self::basis::{Basis, BasisDerivatives, MAX_ORDER, padded};
pub(crate) use self::knot_vector::check_degree;

pub use self::algebra::Direction;
pub use self::closest_point::{ClosestPoint, ClosestPointSearch, ClosestPointSlices};
pub use self::curvature::{Curvature, CurvatureSlices, Form, FundamentalForms};
pub use self::curve::NurbsCurve;
pub use self::derivatives::MAX_DERIVATIVE;
pub use self::evaluate::Outside;
pub use self::interpolate::{GridOptions, Parametrization};
pub use self::knot_vector::{KnotVector, MAX_DEGREE};
pub use self::ordered::OrderedSurface;
pub use self::surface::NurbsSurface;
