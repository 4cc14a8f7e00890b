//! Levels: how closely the curves of a border follow its places.

/// How closely the curves of a border follow its places.
#[derive(Clone, Copy, Debug)]
pub(super) struct Level {
    /// Number of control points allowed, over the standard one.
    pub knots: f64,
    /// Offset outward, over the expected depth of the places.
    pub offset: f64,
    /// Whether to look for corners.
    pub corners: bool,
}
