//! First and second fundamental forms of a surface.

use glam::DVec2;

use super::curvature::{CURVATURE_COST, CURVATURES_PER_TASK};
use super::parameter_checks::{Outside, check_length};
use super::surface::NurbsSurface;
use super::work_blocks::for_row_blocks;
use crate::error::Result;
use crate::progress::Observer;
use crate::worker_pool;

/// A fundamental form: a symmetric matrix in (du, dv).
pub type Form = [[f64; 2]; 2];

/// The first and second fundamental forms at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FundamentalForms {
    /// [[E, F], [F, G]]: dot products of the tangents.
    pub first: Form,
    /// [[L, M], [M, N]]: dot products of the second derivatives with the unit normal.
    pub second: Form,
}

impl NurbsSurface {
    /// Returns the fundamental forms at (u, v); see [`NurbsSurface::normal`] for the normal of the
    /// second.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let plane = NurbsSurface::plane(DVec3::ZERO, 3.0 * DVec3::X, DVec3::Y)?;
    /// let forms = plane.fundamental_forms(0.3, 0.4);
    /// assert_eq!((forms.first, forms.second), ([[9.0, 0.0], [0.0, 1.0]], [[0.0; 2]; 2]));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn fundamental_forms(&self, u: f64, v: f64) -> FundamentalForms {
        let partials = self.partials(u, v);
        let normal = self.normal(u, v);
        let mixed = (partials.u.dot(partials.v), partials.uv.dot(normal));
        FundamentalForms {
            first: [[partials.u.length_squared(), mixed.0], [mixed.0, partials.v.length_squared()]],
            second: [[partials.uu.dot(normal), mixed.1], [mixed.1, partials.vv.dot(normal)]],
        }
    }

    /// Computes the fundamental forms at scattered parameters.
    ///
    /// ```
    /// use neurbs::{DVec2, DVec3, nurbs::{NurbsSurface, Outside}, progress::Silent};
    /// let plane = NurbsSurface::plane(DVec3::ZERO, DVec3::X, 2.0 * DVec3::Y)?;
    /// let (mut first, mut second) = ([[[0.0; 2]; 2]], [[[0.0; 2]; 2]]);
    /// let uv = [DVec2::new(0.5, 0.5)];
    /// let refuse = Outside::Refuse;
    /// plane.fundamental_form_arrays(&uv, &mut first, &mut second, refuse, &mut Silent)?;
    /// assert_eq!(first[0], [[1.0, 0.0], [0.0, 4.0]]);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Those of [`NurbsSurface::evaluate`](NurbsSurface::evaluate).
    pub fn fundamental_form_arrays(
        &self,
        uv: &[DVec2],
        first: &mut [Form],
        second: &mut [Form],
        outside: Outside,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        check_length(first.len(), uv.len())?;
        self.check_scattered(uv, second.len(), outside)?;
        for_row_blocks(uv.len(), CURVATURE_COST, observer, |from, to| {
            let out = first[from..to].iter_mut().zip(&mut second[from..to]);
            let tasks = uv[from..to].iter().zip(out);
            worker_pool::for_each_task(
                tasks,
                CURVATURES_PER_TASK,
                |(): &mut (), (at, (first, second))| {
                    let forms = self.fundamental_forms(at.x, at.y);
                    (*first, *second) = (forms.first, forms.second);
                },
            );
        })
    }
}
