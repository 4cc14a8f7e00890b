//! Where a surface folds over though its points do not.

use std::fmt;

use glam::DVec3;

use super::samples::{Flaw, Samples};
use crate::cloud::{KdTree, Neighbor, Plane};
use crate::error::Result;
use crate::nurbs::NurbsSurface;
use crate::progress::Observer;

/// Points around a fold that show whether they are folded themselves: a sixteenth of them, since more of few reach around
/// what they lie on, but eight at least and sixteen at most.
const SHARE: usize = 16;
const AROUND: (usize, usize) = (8, 16);

/// How far a fold is from the middle of these at most that they are around, as a multiple of their deviation along their
/// plane: of a disc full of points the rim is at two.
const BESIDE: f64 = 3.0;

/// Deviation of these from their plane, as a share of that along it, from which on they are: a
/// crease of ninety degrees has 0.5.
const CREASED: f64 = 0.3;

/// Places where neighbouring normals of a surface point to opposite sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoldOver {
    /// How many pairs of neighbouring samples do.
    pub count: usize,
    /// Where the first of them lies.
    pub place: DVec3,
}

impl fmt::Display for FoldOver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let DVec3 { x, y, z } = self.place;
        write!(
            f,
            "the surface folds over in {} places, though the points do not: see ({x:.6}, {y:.6}, \
             {z:.6}); use a smaller net or more fairness",
            self.count
        )
    }
}

/// Looks for places where the surface's normal flips between neighbouring samples, four to a span,
/// and the points around are not creased, or none are around.
///
/// ```
/// use neurbs::{DVec3, NurbsSurface, validate::fold_over, progress::Silent};
/// let grid = |i: u32| DVec3::new(f64::from(i % 10), f64::from(i / 10), 0.0);
/// let points: Vec<DVec3> = (0..100).map(grid).collect();
/// let flat = |x: [f64; 4]| {
///     let net = x.iter().flat_map(|&x| [DVec3::new(x, 0.0, 0.0), DVec3::new(x, 9.0, 0.0)]);
///     NurbsSurface::clamped(net.collect(), (4, 2), 3)
/// };
/// assert!(fold_over(&flat([0.0, 3.0, 6.0, 9.0])?, &points, &mut Silent)?.is_none());
/// assert!(fold_over(&flat([0.0, 20.0, -11.0, 9.0])?, &points, &mut Silent)?.is_some());
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`crate::Error::Interrupted`] if the observer stops it.
pub fn fold_over(
    surface: &NurbsSurface,
    points: &[DVec3],
    observer: &mut dyn Observer,
) -> Result<Option<FoldOver>> {
    Ok(FoldOver::of(&folds(&Samples::of(surface, observer)?, points)))
}

impl FoldOver {
    pub(crate) fn of(folds: &[Flaw]) -> Option<Self> {
        folds.first().map(|first| Self { count: folds.len(), place: first.place })
    }
}

/// The first of each pair of neighbouring samples that [`fold_over`] counts.
pub(crate) fn folds(samples: &Samples, points: &[DVec3]) -> Vec<Flaw> {
    let (rows, cols) = (samples.rows, samples.cols);
    let right = (0..rows * cols).filter(|at| at % cols + 1 < cols).map(|at| (at, at + 1));
    let below = (0..(rows - 1) * cols).map(|at| (at, at + cols));
    let flips = |&(a, b): &(usize, usize)| samples.normals[a].dot(samples.normals[b]) < 0.0;
    let folded: Vec<usize> = right.chain(below).filter(flips).map(|(a, _)| a).collect();
    if folded.is_empty() {
        return Vec::new();
    }
    let tree = KdTree::new(points);
    let around = (points.len() / SHARE).clamp(AROUND.0, AROUND.1);
    let smooth = |at: &usize| {
        let near = tree.nearest(samples.places[*at], around);
        let around = near.iter().map(|n: &Neighbor| points[n.index as usize]);
        let Plane { centre, deviations: [first, second, third], .. } = Plane::of(around);
        let among = centre.distance(samples.places[*at]) <= BESIDE * first;
        third < CREASED * second || !among
    };
    folded.into_iter().filter(smooth).map(|at| samples.flaw(at)).collect()
}
