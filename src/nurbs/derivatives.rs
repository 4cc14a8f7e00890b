//! Partial derivatives of any order of a surface (The NURBS Book, section 4.5).

use glam::{DVec2, DVec3, DVec4};

use super::basis::{MAX_ORDER, Row, derivatives};
use super::parameter_checks::{Outside, check_length};
use super::surface::NurbsSurface;
use super::work_blocks::{POINTS_PER_TASK, for_row_blocks};
use crate::error::{Error, Result};
use crate::progress::Observer;
use crate::worker_pool;

/// Highest order of differentiation. Beyond it, factorials lose accuracy in f64.
pub const MAX_DERIVATIVE: usize = 18;

impl NurbsSurface {
    /// Computes all partial derivatives up to `order` in each direction, at scattered parameters.
    ///
    /// For each parameter, `out` receives `(order + 1)²` vectors. The one at `i * (order + 1) + j`
    /// is the i-th derivative in u and the j-th in v (The NURBS Book, A4.4). At a knot they are
    /// right derivatives, at the end of the domain left derivatives.
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
    /// - [`Error::Parameter`] if the order exceeds [`MAX_DERIVATIVE`], a parameter is outside the
    ///   domain and `outside` refuses that, or `out` has the wrong length.
    /// - [`Error::Interrupted`] if the observer stops it.
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
        // The quotient rule combines each derivative with all lower ones.
        let cost = side.pow(4).div_ceil(4);
        for_row_blocks(uv.len(), cost, observer, |from, to| {
            let tasks = uv[from..to].iter().zip(out[from * side * side..].chunks_mut(side * side));
            let batch_size = POINTS_PER_TASK / (side * side);
            worker_pool::for_each_task(
                tasks,
                batch_size,
                |(rows, table): &mut (Vec<_>, Vec<_>), (at, out)| {
                    rows.resize(2 * side, [0.0; MAX_ORDER]);
                    table.resize(side * side, DVec4::ZERO);
                    let (rows_u, rows_v) = rows.split_at_mut(side);
                    self.homogeneous_derivatives(*at, rows_u, rows_v, table);
                    rational_derivatives(table, side, out);
                },
            );
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

/// Checks that an order is at most [`MAX_DERIVATIVE`].
pub(super) fn check_order(order: usize) -> Result<()> {
    if order <= MAX_DERIVATIVE {
        return Ok(());
    }
    Err(Error::parameter("order", format!("at most {MAX_DERIVATIVE}"), order))
}

/// Turns derivatives of the homogeneous surface into those of the rational surface, in a table with
/// this many columns (The NURBS Book, equation 4.20).
pub(super) fn rational_derivatives(table: &[DVec4], columns: usize, out: &mut [DVec3]) {
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

/// The binomial coefficient n over k, exact up to [`MAX_DERIVATIVE`].
fn binomial(n: usize, k: usize) -> f64 {
    (1..=k).fold(1.0, |value, i| value * (n + 1 - i) as f64 / i as f64)
}
