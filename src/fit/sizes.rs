//! Sizes and shares that several files of the fit have in common.

/// Control points of a net at most: the equations of more would not fit into memory.
pub(super) const MAX_CONTROL_POINTS: usize = 1 << 20;

/// Points between two calls of the observer: a few milliseconds.
pub(super) const POINTS_PER_CALL: usize = 1 << 16;

/// Points per task of a thread: enough to be worth a block of sums, few enough to share a crowded cell.
pub(super) const POINTS_PER_TASK: usize = 2048;

/// Degree of the surfaces for which there is code of its own, and their basis functions in a span.
pub(super) const CUBIC: usize = 3;
pub(super) const CUBIC_ORDER: usize = CUBIC + 1;

/// Points in one SIMD batch.
pub(super) const BATCH: usize = 32;

/// Samples that are enough for a statistic of all.
pub(super) const ENOUGH_SAMPLES: usize = 20_000;

/// Points that are enough, where they are spread over a surface, for its shape and for its error.
pub(super) const ENOUGH_POINTS: usize = 2000;

/// Weight of distances across the normal. Less lets the net slide away, more is plain distance,
/// which converges slowly.
pub(super) const TANGENTIAL: f64 = 0.01;

/// Share of the mean squared error, or of the error itself, below which two values count as equal.
pub(super) const NEGLIGIBLE: f64 = 0.01;

/// Relative size below which a determinant or a cross product is rounding.
pub(super) const DEGENERATE: f64 = 1e-12;

/// Share of the mean diagonal entry that holds unknowns which no sample touches.
pub(super) const RIDGE: f64 = 1e-10;
