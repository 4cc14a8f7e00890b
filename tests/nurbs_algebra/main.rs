//! Knot algebra does not change the shape, to 1e-13 of its size.

mod closed;
mod curves;
mod strategies;
mod surfaces;
