//! A grid of points on a surface.

use glam::{DVec2, DVec3};

use crate::error::Result;
use crate::nurbs::{KnotVector, NurbsSurface, Outside};
use crate::progress::Observer;

/// Samples in each span: folds and bulges are hardly smaller than a span.
const PER_SPAN: usize = 4;

/// Samples along a direction at most.
const MOST: usize = 400;

/// Places and normals on a grid over the domain, row by row.
pub(crate) struct Samples {
    pub(super) rows: usize,
    pub(super) cols: usize,
    pub(super) uv: Vec<DVec2>,
    pub(super) places: Vec<DVec3>,
    pub(super) normals: Vec<DVec3>,
}

/// A place on a surface where something is wrong.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flaw {
    pub(crate) uv: DVec2,
    pub(crate) place: DVec3,
}

impl Samples {
    pub(crate) fn of(surface: &NurbsSurface, observer: &mut dyn Observer) -> Result<Self> {
        let (u, v) = (parameters(surface.knots_u()), parameters(surface.knots_v()));
        let uv: Vec<DVec2> =
            u.iter().flat_map(|&u| v.iter().map(move |&v| DVec2::new(u, v))).collect();
        let mut places = vec![DVec3::ZERO; uv.len()];
        let mut normals = places.clone();
        surface.evaluate(&uv, &mut places, Outside::Refuse, observer)?;
        surface.normals(&uv, &mut normals, Outside::Refuse, observer)?;
        Ok(Self { rows: u.len(), cols: v.len(), uv, places, normals })
    }

    /// Where the domain begins, and its size.
    pub(super) fn domain(&self) -> (DVec2, DVec2) {
        let low = self.uv[0];
        (low, self.uv[self.uv.len() - 1] - low)
    }

    pub(super) fn flaw(&self, sample: usize) -> Flaw {
        Flaw { uv: self.uv[sample], place: self.places[sample] }
    }

    /// Area of the surface around each sample, roughly: half of the four triangles that have a
    /// corner there.
    pub(super) fn area(&self, sample: usize) -> f64 {
        let (i, j) = (sample / self.cols, sample % self.cols);
        let at = |i: usize, j: usize| self.places[i * self.cols + j];
        let (i0, i1) = (i.saturating_sub(1), (i + 1).min(self.rows - 1));
        let (j0, j1) = (j.saturating_sub(1), (j + 1).min(self.cols - 1));
        0.25 * (at(i1, j) - at(i0, j)).cross(at(i, j1) - at(i, j0)).length()
    }
}

fn parameters(knots: &KnotVector) -> Vec<f64> {
    let (start, end) = knots.domain();
    let count = (PER_SPAN * (knots.breaks().len() - 1)).min(MOST);
    (0..=count)
        .map(|i| i as f64 / count as f64)
        .map(|share| (start + share * (end - start)).clamp(start, end))
        .collect()
}
