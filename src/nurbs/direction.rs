//! The two directions of a surface, and its net as curves that run in one of them.

use glam::DVec4;

use super::basis::padded;
use super::curve_family::Strip;
use super::knot_vector::KnotVector;
use super::surface::NurbsSurface;
use super::work_blocks::in_steps;
use crate::error::Result;
use crate::progress::Listen;

/// A direction of a surface's parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Along the rows of the net, its axis 0.
    U,
    /// Along the columns of the net, its axis 1.
    V,
}

impl Direction {
    pub(super) fn other(self) -> Self {
        match self {
            Self::U => Self::V,
            Self::V => Self::U,
        }
    }
}

impl NurbsSurface {
    /// The knots in a direction.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{Direction, NurbsSurface}};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// assert_eq!(sphere.knots(Direction::V).degree(), 2);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn knots(&self, direction: Direction) -> &KnotVector {
        match direction {
            Direction::U => self.knots_u(),
            Direction::V => self.knots_v(),
        }
    }

    /// The control points of the isocurve at a parameter of the domain.
    pub(super) fn row(&self, direction: Direction, at: f64) -> Vec<DVec4> {
        let (rows, cols) = self.shape();
        let (count, along, across) = match direction {
            Direction::U => (cols, cols, 1),
            Direction::V => (rows, 1, cols),
        };
        let basis = padded(self.knots(direction), at);
        let point = |k: usize, i: usize| self.homogeneous()[k * along + i * across];
        let functions = 0..=self.knots(direction).degree();
        let sum = |i| functions.clone().map(|k| basis.values[k] * point(basis.first + k, i)).sum();
        (0..count).map(sum).collect()
    }

    /// The net as a strip of curves that run in a direction.
    pub(super) fn strip(&self, direction: Direction, listen: &mut Listen<'_>) -> Result<Strip> {
        let ((rows, cols), net) = (self.shape(), self.homogeneous());
        let (points, width) = match direction {
            Direction::U => {
                (in_steps((net.len(), 1), listen, |part| net[part].iter().copied())?, cols)
            }
            Direction::V => (transpose(net, cols, listen)?, rows),
        };
        Ok(Strip { knots: self.knots(direction).clone(), points, width })
    }

    pub(super) fn along<'l>(
        &self,
        direction: Direction,
        listen: &mut Listen<'l>,
        f: impl FnOnce(&Strip, &mut Listen<'l>) -> Result<Strip>,
    ) -> Result<Self> {
        let strip = f(&self.strip(direction, listen)?, listen)?;
        self.rebuilt(direction, strip, listen)
    }

    pub(super) fn rebuilt(
        &self,
        direction: Direction,
        strip: Strip,
        listen: &mut Listen<'_>,
    ) -> Result<Self> {
        self.rebuilt_as(direction, strip, self.weights().is_some(), listen)
    }

    /// The surface with this strip in place of its own in that direction.
    pub(super) fn rebuilt_as(
        &self,
        direction: Direction,
        strip: Strip,
        rational: bool,
        listen: &mut Listen<'_>,
    ) -> Result<Self> {
        let knots = strip.knots.clone();
        match direction {
            Direction::U => {
                let knots = [knots, self.knots_v().clone()];
                Self::from_homogeneous(strip.points, rational, knots, listen)
            }
            Direction::V => {
                let knots = [self.knots_u().clone(), knots];
                Self::from_homogeneous(turned(strip, listen)?, rational, knots, listen)
            }
        }
    }
}

/// The points of a strip, column by column.
pub(super) fn turned(strip: Strip, listen: &mut Listen<'_>) -> Result<Vec<DVec4>> {
    let Strip { points, width, .. } = strip;
    transpose(&points, width, listen)
}

/// The columns of a net of this many columns, one after the other.
pub(super) fn transpose(net: &[DVec4], cols: usize, listen: &mut Listen<'_>) -> Result<Vec<DVec4>> {
    in_steps((cols, net.len() / cols), listen, |columns| {
        columns.flat_map(|j| net.iter().skip(j).step_by(cols).copied())
    })
}
