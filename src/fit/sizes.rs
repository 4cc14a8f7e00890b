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
