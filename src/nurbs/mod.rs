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
mod bending;
mod bezier;
mod closest_point;
mod columns;
mod construct;
mod curvature;
mod curve;
mod curve_algebra;
mod derivatives;
mod direction;
mod elevate;
mod evaluate;
mod frame;
mod fundamental_forms;
pub(crate) mod gauss;
mod grid;
mod interpolate;
mod isocurve;
mod knot_families;
mod knot_vector;
mod measure;
mod net;
mod ordered;
mod parametrization;
mod parts;
mod patch_nets;
mod piece_tree;
mod primitives;
mod remove;
mod scattered;
mod span_table;
mod strip;
mod surface;
mod swept;
mod vertices;

pub(crate) use self::basis::{Basis, BasisDerivatives, MAX_ORDER, Row, padded, values_at, window};
pub(crate) use self::batch::share;
pub(crate) use self::bending::{Bending, in_space};
pub(crate) use self::bezier::halve;
pub(crate) use self::knot_vector::check_degree;
pub(crate) use self::patch_nets::PatchNets;

pub use self::batch::Outside;
pub use self::closest_point::{ClosestPoint, ClosestPointSearch, ClosestPointSlices};
pub use self::curvature::{Curvature, CurvatureSlices};
pub use self::curve::NurbsCurve;
pub use self::derivatives::MAX_DERIVATIVE;
pub use self::direction::Direction;
pub use self::fundamental_forms::{Form, FundamentalForms};
pub use self::knot_vector::{KnotVector, MAX_DEGREE};
pub use self::ordered::OrderedSurface;
pub use self::parametrization::{GridOptions, Parametrization};
pub use self::surface::NurbsSurface;
