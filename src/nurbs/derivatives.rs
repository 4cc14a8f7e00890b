//! Partial derivatives of any order.

use glam::{DVec2, DVec3, DVec4};
use rayon::prelude::*;

use super::basis::{MAX_ORDER, Row, derivatives};
use super::parameter_checks::{Outside, check_length};
use super::surface::NurbsSurface;
use super::work_blocks::{POINTS_PER_TASK, in_rows};
use crate::error::{Error, Result};
use crate::progress::Observer;

/// Highest order of differentiation that is served; factorials beyond are no use in f64.
pub const MAX_DERIVATIVE: usize = 18;

impl NurbsSurface {
    /// All partial derivatives up to `order` in each direction, at scattered parameters: for each
    /// of them `(order + 1)²` vectors in `out`, at `i * (order + 1) + j` the i-th in u and j-th in
    /// v (The NURBS Book, A4.4: the rational quotient rule). At a knot they are those from the
    /// right, at the domain's end those from the left.
    ///
    /// ```
    /// use neurbs::{DVec2, DVec3, nurbs::{NurbsSurface, Outside}, progress::Silent};
    /// let net = vec![DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::ONE];
    /// let surface = NurbsSurface::clamped(net, (2, 2), 1)?;
    /// let (uv, mut out) = ([DVec2::new(0.5, 0.5)], [DVec3::ZERO; 4]);
    /// surface.derivatives(&uv, 1, &mut out, Outside::Refuse, &mut Silent)?;
    /// assert_eq!(out[2], DVec3::new(1.0, 0.0, 0.5)); // by u
    /// assert_eq!(out[3], DVec3::new(0.0, 0.0, 1.0)); // by u and v
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the order is beyond [`MAX_DERIVATIVE`], a parameter lies outside
    /// the domain (and that is refused), or `out` has not the right length;
    /// [`Error::Interrupted`] if the observer stops it.
    pub fn derivatives(
        &self,
        uv: &[DVec2],
        order: usize,
        out: &mut [DVec3],
        outside: Outside,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        check_order(order)?;
        let side = order + 1;
        check_length(out.len(), uv.len() * side * side)?;
        self.check_scattered(uv, uv.len(), outside)?;
        // The quotient rule mixes each derivative with all lower ones.
        let cost = side.pow(4).div_ceil(4);
        in_rows(uv.len(), cost, observer, |from, to| {
            let tasks = uv[from..to].par_iter();
            let tasks = tasks.zip(out[from * side * side..].par_chunks_mut(side * side));
            let tasks = tasks.with_min_len(POINTS_PER_TASK / (side * side));
            let buffers = || (vec![[0.0; MAX_ORDER]; 2 * side], vec![DVec4::ZERO; side * side]);
            tasks.for_each_init(buffers, |(rows, table), (at, out)| {
                let (rows_u, rows_v) = rows.split_at_mut(side);
                self.homogeneous_derivatives(*at, rows_u, rows_v, table);
                project(table, side, out);
            });
        })
    }

    fn homogeneous_derivatives(
        &self,
        at: DVec2,
        rows: &mut [Row],
        columns: &mut [Row],
        table: &mut [DVec4],
    ) {
        let first_u = derivatives(self.knots_u(), at.x, rows);
        let first_v = derivatives(self.knots_v(), at.y, columns);
        for (i, row) in rows.iter().enumerate() {
            for (j, column) in columns.iter().enumerate() {
                table[i * columns.len() + j] = self.contract((first_u, first_v), row, column);
            }
        }
    }
}

pub(super) fn check_order(order: usize) -> Result<()> {
    if order <= MAX_DERIVATIVE {
        return Ok(());
    }
    Err(Error::parameter("order", format!("at most {MAX_DERIVATIVE}"), order))
}

/// From derivatives of the homogeneous surface to those of the surface, in a table of this many
/// columns (The NURBS Book, equation 4.20).
pub(super) fn project(table: &[DVec4], columns: usize, out: &mut [DVec3]) {
    let scale = table[0].w.recip();
    for (at, value) in table.iter().enumerate() {
        let (k, l) = (at / columns, at % columns);
        let mut sum = value.truncate();
        for i in 0..=k {
            for j in usize::from(i == 0)..=l {
                let weight = table[i * columns + j].w;
                if weight != 0.0 {
                    sum -=
                        binomial(k, i) * binomial(l, j) * weight * out[(k - i) * columns + l - j];
                }
            }
        }
        out[at] = sum * scale;
    }
}

/// n over k, exact for the orders that are served.
fn binomial(n: usize, k: usize) -> f64 {
    (1..=k).fold(1.0, |value, i| value * (n + 1 - i) as f64 / i as f64)
}
