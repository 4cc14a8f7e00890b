//! Thresholds of faces and shells, with units and sources.

/// Thresholds of faces and shells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BrepSettings {
    /// Distance within which edges of different faces are the same. Unit: diagonal of all control
    /// points. Source: the uncertainty that CAD files declare.
    pub matching: f64,
    /// Largest distance between an edge's curve and the surface. Unit: the matching tolerance.
    /// Source: closed form: two curves that differ by it each must still match.
    pub edge_curve: f64,
    /// Largest gap between consecutive curves of a loop, and largest distance of a curve outside
    /// the surface's rectangle. Unit: sides of the rectangle. Source: digits that remain when files
    /// write parameters in single precision.
    pub loop_gap: f64,
}

impl BrepSettings {
    /// The thresholds.
    pub(crate) const STANDARD: Self = Self { matching: 1e-6, edge_curve: 0.25, loop_gap: 1e-6 };
}
