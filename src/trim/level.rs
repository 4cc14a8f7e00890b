//! Levels: how closely the curves of a border follow its places.

/// How closely a curve follows places.
#[derive(Clone, Copy, Debug)]
pub(super) struct Closeness {
    /// Number of control points allowed, over the standard one.
    pub knots: f64,
    /// Farthest that a place may be from the curve, in spacings, if enough control points are
    /// allowed.
    pub band: f64,
}

/// How the curves of a border are made.
#[derive(Clone, Copy, Debug)]
pub(super) struct Level {
    pub closeness: Closeness,
    /// Offset outward, over the expected depth of the places.
    pub offset: f64,
    /// Cost of a corner, over the standard one; `None` for no corners.
    pub corner_cost: Option<f64>,
}
