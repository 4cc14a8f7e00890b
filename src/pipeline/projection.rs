//! Projection of all points onto a surface, from known parameters of some of them.
//!
//! The search is local; it starts from the parameters of the nearest known point.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::ranking::Model;
use crate::cloud::{KdTree, Neighbor};
use crate::error::Result;
use crate::fit::project;
use crate::nurbs::{NurbsSurface, Outside};
use crate::progress::{self, Observer, Progress, Stage};

/// Points that are projected between two reports.
const POINTS_PER_REPORT: usize = 1 << 15;

/// Parameters of points on a surface, and their distances from it.
pub(super) struct Projection {
    pub(super) uv: Vec<DVec2>,
    pub(super) distances: Vec<f64>,
}

impl Projection {
    /// Projects all points onto the coarse surface of a model.
    ///
    /// A height field takes the points' places in its plane. Other surfaces start from the
    /// parameters of the nearest point of the sample that the model was fitted to.
    pub(super) fn onto_model(
        points: &[DVec3],
        sample: &[DVec3],
        model: &Model,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let surface = &model.fit.surface;
        let Some([along, across, up]) = model.hypothesis.heights else {
            let closed = model.hypothesis.kind.closed();
            return Self::from_nearest(points, surface, closed, sample, &model.fit.uv, observer);
        };
        let size = DVec2::from_array(model.hypothesis.lengths);
        let place = |point: &DVec3| DVec2::new(along.dot(*point), across.dot(*point));
        let low = place(&sample[0]) - model.fit.uv[0] * size;
        let uv: Vec<DVec2> = points
            .par_iter()
            .map(|point| ((place(point) - low) / size).clamp(DVec2::ZERO, DVec2::ONE))
            .collect();
        let (mut below, mut normals) = (vec![DVec3::ZERO; uv.len()], vec![DVec3::ZERO; uv.len()]);
        surface.evaluate(&uv, &mut below, Outside::Refuse, observer)?;
        surface.normals(&uv, &mut normals, Outside::Refuse, observer)?;
        // Noise has no direction, so the distance is measured along the normal, not along `up`.
        let distances = points
            .iter()
            .zip(below)
            .zip(normals)
            .map(|((point, below), normal)| ((*point - below).dot(up) * normal.dot(up)).abs());
        let distances = distances.collect();
        Ok(Self { uv, distances })
    }

    /// Projects points by iteration from the parameters of the nearest known point.
    pub(super) fn from_nearest(
        points: &[DVec3],
        surface: &NurbsSurface,
        closed: (bool, bool),
        known: &[DVec3],
        known_uv: &[DVec2],
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let tree = KdTree::over(known, observer)?;
        let start = |found: &mut Vec<Neighbor>, point: &DVec3| {
            tree.nearest_where(*point, 1, f64::INFINITY, found, |_| true);
            found.first().map_or(DVec2::ZERO, |near| known_uv[near.index as usize])
        };
        let count = points.len();
        let mut all = Self { uv: Vec::with_capacity(count), distances: Vec::with_capacity(count) };
        for batch in points.chunks(POINTS_PER_REPORT) {
            let step = all.uv.len() as u64;
            let progress = Progress::of_stage(Stage::Measuring, step, count as u64, count);
            progress::report(observer, &progress)?;
            let starts: Vec<DVec2> = batch.par_iter().map_init(Vec::new, start).collect();
            let (uv, distances) = project(surface, closed, batch, &starts);
            all.uv.extend(uv);
            all.distances.extend(distances);
        }
        Ok(all)
    }
}
