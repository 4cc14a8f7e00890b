//! Blocks: rectangles of Bézier patches, with integer coordinates inside.

/// How often a patch can be halved in each direction.
const MAX_HALVINGS: u32 = 22;

/// Steps of the integer coordinates along one patch.
pub(super) const PATCH_STEPS: u32 = 1 << MAX_HALVINGS;

/// Patches along one direction of a block at most: more would overflow 32-bit coordinates.
pub(super) const MAX_PATCHES: usize = 1 << (31 - MAX_HALVINGS);

/// Integer coordinates (u, v) in a block, in steps from its first corner.
pub(super) type GridPoint = (u32, u32);

/// A rectangle of patches: ranges of rows and columns of the surface's patches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    /// First row and end.
    pub rows: (usize, usize),
    /// First column and end.
    pub cols: (usize, usize),
}

/// The fraction of a range that lies before `x`.
pub(super) fn fraction(x: u32, (from, to): (u32, u32)) -> f64 {
    f64::from(x - from) / f64::from(to - from)
}

/// The surface parameter of an integer coordinate in a block.
///
/// `breaks` are the parameters between patches; `first` is the first patch of the block.
pub(super) fn parameter(breaks: &[f64], first: usize, step: u32) -> f64 {
    let patch = first + (step / PATCH_STEPS) as usize;
    let rest = step % PATCH_STEPS;
    if rest == 0 {
        return breaks[patch];
    }
    let share = f64::from(rest) / f64::from(PATCH_STEPS);
    breaks[patch] + share * (breaks[patch + 1] - breaks[patch])
}
