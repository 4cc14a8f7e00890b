//! Shapes in the plane.

use std::f64::consts::{FRAC_PI_2, TAU};

use neurbs::DVec2;

/// A shape as polygons: the outline, then holes.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    pub(crate) name: &'static str,
    pub(crate) rings: Vec<Vec<DVec2>>,
    pub(crate) corners: Vec<DVec2>,
}

impl Shape {
    /// A shape whose first rings have corners at their points, and others are smooth.
    fn new(name: &'static str, cornered: Vec<Vec<DVec2>>, smooth: Vec<Vec<DVec2>>) -> Self {
        let corners = cornered.iter().flatten().copied().collect();
        Self { name, corners, rings: cornered.into_iter().chain(smooth).collect() }
    }

    pub(crate) fn area(&self) -> f64 {
        super::measures::area(&self.rings)
    }

    /// The side of a square with one of `count` points.
    pub(crate) fn spacing(&self, count: usize) -> f64 {
        (self.area() / count as f64).sqrt()
    }
}

/// The seven shapes.
pub(crate) fn all() -> Vec<Shape> {
    let rectangle = || polygon(&[(0.0, 0.0), (1.0, 0.0), (1.0, 0.7), (0.0, 0.7)]);
    let window = polygon(&[(0.2, 0.2), (0.45, 0.2), (0.45, 0.5), (0.2, 0.5)]);
    let l = polygon(&[(0.0, 0.0), (1.0, 0.0), (1.0, 0.4), (0.4, 0.4), (0.4, 1.0), (0.0, 1.0)]);
    let star = round(10, |k| if k % 2 == 0 { 0.5 } else { 0.23 }, FRAC_PI_2);
    let blob = |k: usize| {
        let angle = k as f64 / 800.0 * TAU;
        0.36 + 0.08 * (3.0 * angle).cos() + 0.05 * (5.0 * angle).sin()
    };
    let disc = || circle(0.5, 0.5, 0.5);
    let holes = vec![disc(), circle(0.32, 0.5, 0.11), circle(0.68, 0.6, 0.14)];
    vec![
        Shape::new("disc with two holes", vec![], holes),
        Shape::new("L", vec![l], vec![]),
        Shape::new("annulus", vec![], vec![disc(), circle(0.5, 0.5, 0.25)]),
        Shape::new("star", vec![star], vec![]),
        Shape::new("rectangle", vec![rectangle()], vec![]),
        Shape::new("plate", vec![rectangle(), window], vec![circle(0.72, 0.35, 0.13)]),
        Shape::new("blob", vec![], vec![round(800, blob, 0.0)]),
    ]
}

fn polygon(points: &[(f64, f64)]) -> Vec<DVec2> {
    points.iter().map(|(x, y)| DVec2::new(*x, *y)).collect()
}

fn circle(x: f64, y: f64, radius: f64) -> Vec<DVec2> {
    let middle = DVec2::new(x, y) - 0.5;
    round(400, |_| radius, 0.0).into_iter().map(|at| at + middle).collect()
}

/// A polygon with these radii around (0.5, 0.5).
fn round(count: usize, radius: impl Fn(usize) -> f64, start: f64) -> Vec<DVec2> {
    let angle = |k: usize| start + k as f64 / count as f64 * TAU;
    (0..count).map(|k| 0.5 + radius(k) * DVec2::from_angle(angle(k))).collect()
}

/// Whether a point is inside, by even and odd crossings.
pub(crate) fn inside(rings: &[Vec<DVec2>], at: DVec2) -> bool {
    let left = super::measures::crossings(rings, at.y);
    left.iter().filter(|x| **x < at.x).count() % 2 == 1
}
