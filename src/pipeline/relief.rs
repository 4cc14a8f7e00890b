//! What heights over a plane are like around points of them.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::cloud::{self, KdTree, Neighbor, Plane};
use crate::topology::WALL_DEGREES;

/// Neighbours of a point across the heights that tell what it is like there.
const NEIGHBORS: usize = 8;

/// The power of the area of a surface with which the number of points on it grows from which on it is
/// the surface that was sampled evenly, and not the plane below, and what chance adds to it, times the root of
/// the number of points. Of planes some tenth is found, and of surfaces a third at least: how steep they are is
/// known but roughly.
const ON_SURFACE: f64 = 0.25;
const BY_CHANCE: f64 = 1.2;

/// Share of its length below which what is around a point is a line.
const LINE: f64 = 0.3;

/// Standard deviation of the logarithm of areas without which they tell nothing.
const TELLING: f64 = 0.2;

/// Heights around points.
pub(super) struct Relief<'a> {
    points: &'a [DVec3],
    /// For each point the plane nearest to it and its neighbours.
    planes: Vec<Plane>,
    up: DVec3,
    /// How far the heights of all points scatter.
    deviation: f64,
}

impl<'a> Relief<'a> {
    /// Of heights in a direction.
    pub(super) fn of(points: &'a [DVec3], up: DVec3) -> Self {
        let flat: Vec<DVec3> =
            points.iter().map(|&point| point.reject_from_normalized(up)).collect();
        let planes = planes(points, &KdTree::new(&flat));
        let mean = cloud::centroid(points).dot(up);
        let squares: f64 = points.iter().map(|point| (point.dot(up) - mean).powi(2)).sum();
        let deviation = (squares / points.len() as f64).sqrt();
        Self { points, planes, up, deviation }
    }

    /// How many times more area the surface over z = 0 has than the ground below, around each point, by
    /// coordinates before they counted so much: normals are stretched where points are shrunk.
    fn areas(&self, by: DVec3) -> impl Iterator<Item = f64> {
        self.planes.iter().map(move |plane| {
            let normal = by * plane.normal();
            normal.length() / normal.z.abs()
        })
    }

    /// Share of the surface that was wall by coordinates before they counted so much.
    pub(super) fn walls(&self, by: DVec3) -> f64 {
        let wall = WALL_DEGREES.to_radians().cos().recip();
        self.areas(by).filter(|area| *area > wall).count() as f64 / self.planes.len() as f64
    }

    /// How much more of these points lie where the surface is steep by coordinates before they counted so much:
    /// 1 and more if it was sampled evenly, and not the plane below; `None` if it is equally steep all over.
    /// (Where points lie close, noise is steep; so those of the relief should lie evenly over the plane.)
    pub(super) fn sampled(&self, by: DVec3, points: &[DVec3]) -> Option<f64> {
        let flat: Vec<DVec3> = points.iter().map(|point| point.with_z(0.0)).collect();
        let tree = KdTree::new(&flat);
        let density = |found: &mut Vec<Neighbor>, point: &DVec3| {
            tree.nearest_where(point.with_z(0.0), NEIGHBORS, f64::INFINITY, found, |_| true);
            -2.0 * found.last().map_or(0.0, Neighbor::distance).ln()
        };
        let densities: Vec<f64> = self.points.par_iter().map_init(Vec::new, density).collect();
        let logs = self.areas(by).map(f64::ln).zip(densities).map(DVec2::from);
        let logs: Vec<DVec2> = logs.filter(|place| place.is_finite()).collect();
        let count = logs.len() as f64;
        let mean = logs.iter().sum::<DVec2>() / count;
        let (mut square, mut product) = (0.0, 0.0);
        for away in logs.iter().map(|&place| place - mean) {
            square += away.x * away.x;
            product += away.x * away.y;
        }
        let on_surface = ON_SURFACE + BY_CHANCE / count.sqrt();
        (square > TELLING * TELLING * count).then_some(product / (on_surface * square))
    }

    /// Share of the heights that planes leave unexplained.
    pub(super) fn unexplained(&self) -> f64 {
        let along = |plane: &Plane| plane.deviations[2] / plane.normal().dot(self.up).abs();
        let mut left: Vec<f64> = self.planes.iter().map(along).collect();
        left.sort_by(f64::total_cmp);
        left[left.len() / 2] / self.deviation
    }
}

/// How thick what lies around points is beside how wide, smallest first; only of places whose neighbours do
/// not lie in a line, and none if those are not most.
pub(super) fn thicknesses(points: &[DVec3]) -> Vec<f64> {
    let thickness = |plane: Plane| {
        let [long, wide, thick] = plane.deviations;
        (wide > LINE * long).then(|| thick / wide)
    };
    let planes = planes(points, &KdTree::new(points));
    let mut found: Vec<f64> = planes.into_iter().filter_map(thickness).collect();
    found.sort_by(f64::total_cmp);
    if 2 * found.len() > points.len() { found } else { Vec::new() }
}

/// For each point the plane nearest to it and its neighbours in a tree of their places.
fn planes(points: &[DVec3], tree: &KdTree<'_>) -> Vec<Plane> {
    let around = |found: &mut Vec<Neighbor>, (index, &point): (u32, &DVec3)| {
        tree.nearest_to(index, NEIGHBORS, found);
        let neighbors = found.iter().map(|near| points[near.index as usize]);
        Plane::of(std::iter::once(point).chain(neighbors))
    };
    let numbered: Vec<(u32, &DVec3)> = (0..).zip(points).collect();
    numbered.into_par_iter().map_init(Vec::new, around).collect()
}
