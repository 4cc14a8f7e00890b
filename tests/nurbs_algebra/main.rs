//! Knot algebra leaves the shape where it was, to 1e-13 of its size.

mod closed;
mod curves;
mod strategies;
mod surfaces;
