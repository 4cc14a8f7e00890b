//! NURBS curves and surfaces: knots, basis functions, evaluation, algebra, closest points.
//!
//! u runs along axis 0 of a control net (its rows), v along axis 1 (its columns). Arrays over a net
//! are row-major, v fastest.

mod adaptive_quadrature;
mod approximate;
mod arc_length;
mod area;
mod banded;
mod basis;
mod basis_block;
mod bending;
mod bezier_curve;
mod bezier_patch;
mod bounding_box;
mod box_tree;
mod closest_point;
mod compatible;
mod control_net;
mod curvature;
mod curve;
mod curve_algebra;
mod curve_closest_point;
mod curve_family;
mod curve_geometry;
mod degree;
mod derivatives;
mod direction;
mod evaluate;
mod evaluate_grid;
mod evaluate_scattered;
mod fundamental_forms;
pub(crate) mod gauss;
mod height_search;
mod interpolate;
mod isocurve;
mod knot_constructors;
mod knot_insertion;
mod knot_multiset;
mod knot_removal;
mod knot_vector;
mod ordered_surface;
mod parameter_checks;
mod parameter_region;
mod parametrization;
mod partials;
mod patch_distance;
mod patch_nets;
mod plane_map;
mod plane_tree;
mod primitives;
mod span_table;
mod split_join;
mod surface;
mod surface_algebra;
mod surface_constructors;
mod swept;
mod work_blocks;

pub(crate) use self::adaptive_quadrature::{Estimates, NODE_COUNTS, Region, integral};
pub(crate) use self::basis::{
    BasisDerivatives, MAX_COMPILED_ORDER, MAX_ORDER, Row, padded, values_at, window,
};
pub(crate) use self::bending::{Bending, in_space};
pub(crate) use self::bezier_curve::BezierCurve;
pub(crate) use self::bezier_patch::{BezierPatch, bernstein, halve};
pub(crate) use self::bounding_box::SurfacePart;
pub(crate) use self::knot_vector::check_degree;
pub(crate) use self::parameter_region::{Cover, ParameterRegion};
pub(crate) use self::patch_nets::PatchNets;
pub(crate) use self::work_blocks::{interrupt_check, map_in_blocks};

pub use self::closest_point::{ClosestPoint, ClosestPointSearch, ClosestPointSlices};
pub use self::curvature::{Curvature, CurvatureSlices};
pub use self::curve::NurbsCurve;
pub use self::curve_closest_point::{CurvePoint, CurveSearch};
pub use self::derivatives::MAX_DERIVATIVE;
pub use self::direction::Direction;
pub use self::fundamental_forms::{Form, FundamentalForms};
pub use self::height_search::HeightSearch;
pub use self::knot_vector::{KnotVector, MAX_DEGREE};
pub use self::ordered_surface::OrderedSurface;
pub use self::parameter_checks::Outside;
pub use self::parametrization::{GridOptions, Parametrization};
pub use self::surface::NurbsSurface;
