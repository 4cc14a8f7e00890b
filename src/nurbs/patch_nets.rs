//! The Bézier nets of a surface over a grid of its parameters, side by side in one array.

use glam::DVec4;

use super::basis::Row;
use super::direction::{Direction, transpose};
use super::strip::Strip;
use super::surface::NurbsSurface;
use crate::error::Result;
use crate::progress::Listen;

/// A surface cut along its knots, and wherever else it was asked for, into Bézier patches.
#[derive(Clone, Debug)]
pub(crate) struct PatchNets {
    /// The parameters of the cuts in u, ends included.
    pub u: Vec<f64>,
    /// The parameters of the cuts in v, ends included.
    pub v: Vec<f64>,
    /// Degrees in u and v.
    pub degrees: (usize, usize),
    /// Homogeneous control points, column by column; neighbours share their border.
    points: Vec<DVec4>,
    rows: usize,
}

impl PatchNets {
    /// Cuts a surface at its knots and at these sorted parameters inside its domain.
    pub(crate) fn new(surface: &NurbsSurface, more_u: &[f64], more_v: &[f64]) -> Result<Self> {
        let listen = &mut || Ok(());
        let along_u = cut(surface.strip(Direction::U, listen)?, more_u, listen)?;
        let (knots, rows) = (surface.knots_v().clone(), along_u.rows());
        let points = transpose(&along_u.points, along_u.width, listen)?;
        let along_v = cut(Strip { knots, points, width: rows }, more_v, listen)?;
        Ok(Self {
            u: along_u.knots.breaks(),
            v: along_v.knots.breaks(),
            degrees: (along_u.knots.degree(), along_v.knots.degree()),
            points: along_v.points,
            rows,
        })
    }

    /// The homogeneous point of a patch where its Bernstein polynomials in u and v have these values.
    pub(crate) fn point(&self, (row, col): (usize, usize), (u, v): (&Row, &Row)) -> DVec4 {
        let (p, q) = self.degrees;
        let mut point = DVec4::ZERO;
        for (j, share) in v[..=q].iter().enumerate() {
            // Of what lies on a border, one column is enough.
            if *share == 0.0 {
                continue;
            }
            let column = &self.points[(col * q + j) * self.rows + row * p..][..=p];
            let mut inner = DVec4::ZERO;
            for (h, share) in column.iter().zip(u) {
                inner += *share * *h;
            }
            point += *share * inner;
        }
        point
    }

    /// Appends the homogeneous control points of the patch in this row and column, row by row.
    pub(crate) fn append(&self, (row, col): (usize, usize), net: &mut Vec<DVec4>) {
        let (p, q) = self.degrees;
        for i in row * p..=(row + 1) * p {
            net.extend((col * q..=(col + 1) * q).map(|j| self.points[j * self.rows + i]));
        }
    }
}

/// Bézier curves, cut at their knots and at these parameters.
fn cut(strip: Strip, more: &[f64], listen: &mut Listen<'_>) -> Result<Strip> {
    let strip = if more.is_empty() { strip } else { strip.refined(more, listen)? };
    strip.bezier(listen)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn patches_begin_and_end_on_the_surface() {
        let torus = NurbsSurface::torus(DVec3::ZERO, 3.0, 1.0).unwrap();
        let nets = PatchNets::new(&torus, &[0.1], &[0.6, 0.7]).unwrap();
        assert_eq!((nets.u.len(), nets.v.len(), nets.degrees), (6, 7, (2, 2)));
        for (i, ends_u) in nets.u.windows(2).enumerate() {
            for (j, ends_v) in nets.v.windows(2).enumerate() {
                let mut net = vec![];
                nets.append((i, j), &mut net);
                let corners = [(0, 0, 0), (2, 0, 1), (6, 1, 0), (8, 1, 1)];
                for (k, at_u, at_v) in corners {
                    let point = torus.point(ends_u[at_u], ends_v[at_v]);
                    assert!(point.distance(net[k].truncate() / net[k].w) < 1e-14);
                }
            }
        }
    }
}
