//! Sizes that several files share: memory limits, tasks, batches and the cubic degree.

/// Control points of a net, at most, so that the equations fit into memory.
pub(super) const MAX_CONTROL_POINTS: usize = 1 << 20;

/// Points between two calls of the observer, a few milliseconds of work.
pub(super) const POINTS_PER_CALL: usize = 1 << 16;

/// Points in a task of a thread. A task needs enough points for a block of sums, and crowded cells
/// must be split.
pub(super) const POINTS_PER_TASK: usize = 2048;

/// Degree of the surfaces that have specialized code, and their basis functions in a span.
pub(super) const CUBIC: usize = 3;
pub(super) const CUBIC_ORDER: usize = CUBIC + 1;

/// Points in one SIMD batch.
pub(super) const BATCH: usize = 32;
