//! Isocurves of a surface: the net contracted once for a whole row of a grid.

use glam::DVec4;

use super::basis::{BasisDerivatives, MAX_ORDER};
use super::control_net::HomogeneousPoint;
use super::partials::Partials;
use super::surface::NurbsSurface;

/// The control points of an isocurve in v, and their first and second derivatives by u.
#[derive(Default)]
pub(super) struct Isocurve {
    pub values: Vec<HomogeneousPoint>,
    pub slopes: Vec<HomogeneousPoint>,
    second: Vec<HomogeneousPoint>,
}

impl Isocurve {
    /// Computes the isocurve at `u` with `ROWS - 1` derivatives.
    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    pub(super) fn contract<const ROWS: usize>(&mut self, surface: &NurbsSurface, u: f64) {
        let basis = BasisDerivatives::<ROWS, MAX_ORDER>::at(surface.knots_u(), u);
        let cols = surface.shape().1;
        let net: &[HomogeneousPoint] = bytemuck::cast_slice(surface.homogeneous());
        let (first, others) = net[basis.first * cols..].split_at(cols);
        let others = &others[..surface.knots_u().degree() * cols];
        let targets = [&mut self.values, &mut self.slopes, &mut self.second];
        for (target, factors) in targets.into_iter().zip(&basis.rows) {
            target.clear();
            target.extend(first.iter().map(|control| control.map(|c| factors[0] * c)));
            for (row, factor) in others.chunks_exact(cols).zip(&factors[1..]) {
                let (target, row) = (target.as_flattened_mut(), row.as_flattened());
                for (sum, control) in target.iter_mut().zip(row) {
                    *sum += factor * control;
                }
            }
        }
    }
}

/// Evaluates points with first and second derivatives along a row, and calls `take` with the column
/// index and each of them.
pub(super) fn partials_along(
    surface: &NurbsSurface,
    u: f64,
    columns: &[BasisDerivatives<3>],
    net: &mut Isocurve,
    mut take: impl FnMut(usize, &Partials),
) {
    net.contract::<3>(surface, u);
    let order = surface.knots_v().degree() + 1;
    for (column, basis) in columns.iter().enumerate() {
        let sum = |points: &[HomogeneousPoint], derivative: usize| {
            let points = points[basis.first..][..order].iter().zip(&basis.rows[derivative]);
            points.map(|(point, factor)| *factor * DVec4::from(*point)).sum::<DVec4>()
        };
        let partials = Partials::new([
            sum(&net.values, 0),
            sum(&net.slopes, 0),
            sum(&net.values, 1),
            sum(&net.second, 0),
            sum(&net.slopes, 1),
            sum(&net.values, 2),
        ]);
        take(column, &partials);
    }
}
