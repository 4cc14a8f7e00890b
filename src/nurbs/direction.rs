//! The two parameter directions of a surface, and its net as a family of curves along one of them.

use glam::DVec4;

use super::basis::{MAX_ORDER, padded};
use super::control_net::transpose;
use super::curve_family::CurveFamily;
use super::knot_vector::KnotVector;
use super::surface::NurbsSurface;
use super::work_blocks::collect_in_steps;
use crate::error::Result;
use crate::progress::InterruptCheck;

/// A parameter direction of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Along axis 0 of the net, across its rows.
    U,
    /// Along axis 1 of the net, across its columns.
    V,
}

impl Direction {
    /// The other direction.
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

    /// Returns the homogeneous control points of the isocurve at a parameter of the domain.
    pub(super) fn isocurve_net(&self, direction: Direction, at: f64) -> Vec<DVec4> {
        let (rows, cols) = self.shape();
        let (count, along, across) = match direction {
            Direction::U => (cols, cols, 1),
            Direction::V => (rows, 1, cols),
        };
        let basis = padded::<MAX_ORDER>(self.knots(direction), at);
        let point = |k: usize, i: usize| self.homogeneous()[k * along + i * across];
        let functions = 0..=self.knots(direction).degree();
        let sum = |i| functions.clone().map(|k| basis.values[k] * point(basis.first + k, i)).sum();
        (0..count).map(sum).collect()
    }

    /// Returns the net as a family of curves along a direction.
    pub(super) fn family(
        &self,
        direction: Direction,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<CurveFamily> {
        let ((rows, cols), net) = (self.shape(), self.homogeneous());
        let (points, width) = match direction {
            Direction::U => (
                collect_in_steps((net.len(), 1), check_interrupt, |part| {
                    net[part].iter().copied()
                })?,
                cols,
            ),
            Direction::V => (transpose(net, cols, check_interrupt)?, rows),
        };
        Ok(CurveFamily { knots: self.knots(direction).clone(), points, width })
    }

    /// Applies `f` to the net as a family of curves along a direction.
    pub(super) fn map_family<'l>(
        &self,
        direction: Direction,
        check_interrupt: &mut InterruptCheck<'l>,
        f: impl FnOnce(&CurveFamily, &mut InterruptCheck<'l>) -> Result<CurveFamily>,
    ) -> Result<Self> {
        let family = f(&self.family(direction, check_interrupt)?, check_interrupt)?;
        self.with_family(direction, family, check_interrupt)
    }

    /// Returns the surface with `family` as its net along a direction; rational if this surface is.
    pub(super) fn with_family(
        &self,
        direction: Direction,
        family: CurveFamily,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        self.replace_family(direction, family, self.weights().is_some(), check_interrupt)
    }

    /// Returns the surface with `family` as its net along a direction.
    pub(super) fn replace_family(
        &self,
        direction: Direction,
        family: CurveFamily,
        rational: bool,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        let knots = family.knots.clone();
        match direction {
            Direction::U => {
                let knots = [knots, self.knots_v().clone()];
                Self::from_homogeneous(family.points, rational, knots, check_interrupt)
            }
            Direction::V => {
                let knots = [self.knots_u().clone(), knots];
                Self::from_homogeneous(
                    transposed_rows(family, check_interrupt)?,
                    rational,
                    knots,
                    check_interrupt,
                )
            }
        }
    }
}

/// Returns the points of a family, column by column.
pub(super) fn transposed_rows(
    family: CurveFamily,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<Vec<DVec4>> {
    let CurveFamily { points, width, .. } = family;
    transpose(&points, width, check_interrupt)
}
