//! Spline space: the unknown control points of a net, and the order in which they are solved for.

use super::band_matrix::BandMatrix;
use super::options::FitOptions;
use crate::error::{Error, Result};
use crate::memory;
use crate::nurbs::{KnotVector, NurbsSurface};

use glam::DVec3;

/// Splines over two knot vectors. Rows and columns that a closed direction repeats are unknown only
/// once.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SplineSpace {
    pub(super) knots: [KnotVector; 2],
    pub(super) closed: [bool; 2],
    /// The outer direction in the order of solution: the one that gives the matrix the narrower
    /// band.
    outer: usize,
}

impl SplineSpace {
    /// # Errors
    ///
    /// [`Error::Parameter`] if knots are not periodic in a closed direction.
    pub(super) fn new(knots: [KnotVector; 2], closed: [bool; 2]) -> Result<Self> {
        for (knots, closed) in knots.iter().zip(closed) {
            if closed && !knots.is_periodic() {
                let got = format!("{:?}", knots.as_slice());
                return Err(Error::parameter("knots", "periodic in a closed direction", got));
            }
        }
        let mut space = Self { knots, closed, outer: 0 };
        let width = |outer| Self { outer, ..space.clone() }.width();
        space.outer = usize::from(width(1) < width(0));
        Ok(space)
    }

    /// The space of a fit.
    ///
    /// # Errors
    ///
    /// As [`Self::new`].
    pub(super) fn of(options: &FitOptions) -> Result<Self> {
        Self::new([options.knots_u.clone(), options.knots_v.clone()], options.closed.into())
    }

    /// Rows and columns of unknown control points.
    pub(super) fn shape(&self) -> [usize; 2] {
        [0, 1].map(|d| {
            let knots = &self.knots[d];
            knots.control_points() - if self.closed[d] { knots.degree() } else { 0 }
        })
    }

    pub(super) fn unknowns(&self) -> usize {
        let [rows, cols] = self.shape();
        rows * cols
    }

    /// The half bandwidth: the largest distance, in the order of solution, of two control points
    /// that a point touches.
    fn width(&self) -> usize {
        let (shape, inner) = (self.shape(), 1 - self.outer);
        let reach = |d: usize| {
            let turns = if self.closed[d] { 2 } else { 1 };
            (turns * self.knots[d].degree()).min(shape[d] - 1)
        };
        let across = if self.closed[inner] { shape[inner] - 1 } else { reach(inner) };
        reach(self.outer) * shape[inner] + across
    }

    /// Checks that there is memory for so many matrices.
    ///
    /// # Errors
    ///
    /// [`Error::Memory`].
    pub(super) fn check_memory(&self, components: usize, matrices: usize) -> Result<()> {
        let (size, width) = (self.unknowns() * components, (self.width() + 1) * components);
        let bytes = (matrices * size_of::<f64>()) as u128 * size as u128 * width as u128;
        memory::check(bytes, || {
            let [rows, cols] = self.shape();
            format!("the fit of {rows} × {cols} control points")
        })
    }

    /// A zero matrix over the unknowns, with `components` for each control point.
    pub(super) fn matrix(&self, components: usize) -> BandMatrix {
        self.matrix_instead(components, None)
    }

    /// The same, in the memory of `spare`, if there is one.
    pub(super) fn matrix_instead(
        &self,
        components: usize,
        spare: Option<BandMatrix>,
    ) -> BandMatrix {
        let (size, width) = (self.unknowns(), self.width());
        BandMatrix::new(size * components, width * components + components - 1, spare)
    }

    /// The place of a control point in the order of solution. A closed outer direction is folded:
    /// rows from both sides of the seam alternate, so that neighbors stay near each other.
    #[inline]
    pub(super) fn place(&self, row: usize, col: usize) -> usize {
        let shape = self.shape();
        let at = [row % shape[0], col % shape[1]];
        let (outer, inner) = (self.outer, 1 - self.outer);
        let turn = at[outer];
        let turn = match self.closed[outer] {
            true if 2 * turn < shape[outer] => 2 * turn,
            true => 2 * (shape[outer] - 1 - turn) + 1,
            false => turn,
        };
        turn * shape[inner] + at[inner]
    }

    /// Pairs of unknowns, in the order of solution, that a point may touch together. Each pair comes
    /// once, in a fixed order.
    pub(super) fn each_pair(&self, mut call: impl FnMut([usize; 2])) {
        let [rows, cols] = self.shape();
        let by_col: Vec<Vec<usize>> = (0..cols).map(|col| self.reached(1, col)).collect();
        for row in 0..rows {
            let by_row = self.reached(0, row);
            for (col, others) in by_col.iter().enumerate() {
                for &other_row in &by_row {
                    for &other_col in others {
                        if other_row * cols + other_col >= row * cols + col {
                            call([self.place(row, col), self.place(other_row, other_col)]);
                        }
                    }
                }
            }
        }
    }

    /// The rows (direction 0) or columns (1) whose functions overlap those of one.
    fn reached(&self, direction: usize, index: usize) -> Vec<usize> {
        let (count, degree) = (self.shape()[direction], self.knots[direction].degree());
        if !self.closed[direction] {
            return (index.saturating_sub(degree)..count.min(index + degree + 1)).collect();
        }
        if 2 * degree + 1 >= count {
            return (0..count).collect();
        }
        (index + count - degree..=index + count + degree).map(|other| other % count).collect()
    }

    /// The places of all control points of the net, including repeated ones, row by row.
    pub(super) fn places(&self) -> Vec<usize> {
        let [rows, cols] = [0, 1].map(|d| self.knots[d].control_points());
        (0..rows * cols).map(|at| self.place(at / cols, at % cols)).collect()
    }

    /// The control points of a surface of this space, in the order of solution.
    pub(super) fn unknown_points(&self, surface: &NurbsSurface) -> Vec<DVec3> {
        let mut points = vec![DVec3::ZERO; self.unknowns()];
        for (place, point) in self.places().into_iter().zip(surface.control_points()) {
            points[place] = *point;
        }
        points
    }

    /// The surface with these control points, in the order of solution.
    pub(super) fn surface(&self, solution: &[DVec3]) -> Result<NurbsSurface> {
        let net = self.places().into_iter().map(|place| solution[place]).collect();
        let [u, v] = self.knots.clone();
        NurbsSurface::new(net, None, u, v)
    }
}
