//! Boundary: where the points end on a surface, in its parameters.
//!
//! Points are a Poisson process that ends at smooth curves; the likeliest curves bound the domain.

mod closed;
mod constraint;
mod curve;
mod four_sided;
mod likelihood;
mod polar_projection;
mod settings;
mod straight;
mod strips;

pub(super) use self::closed::ClosedBoundary;
pub(super) use self::constraint::BoundaryConstraint;
pub(super) use self::curve::Depth;
pub(super) use self::four_sided::bounded_by_curves;
#[cfg(test)]
pub(super) use self::likelihood::tests::even;
pub use self::straight::bounded;
pub(super) use self::strips::min_max;
