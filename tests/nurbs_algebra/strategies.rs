//! Random curves and surfaces, and comparisons of them.

use neurbs::nurbs::{KnotVector, NurbsCurve, NurbsSurface};
use neurbs::{DAffine3, DVec2, DVec3};
use proptest::prelude::*;

/// Maximal distance between equal shapes, as a fraction of their size.
pub(crate) const EXACT: f64 = 1e-13;

/// A knot vector of this degree with some inner knots, simple or repeated, clamped or not.
pub(crate) fn knots(degree: usize) -> impl Strategy<Value = KnotVector> {
    let inner = prop::collection::vec((1_u8..40, 1..=degree), 0..5);
    (inner, any::<bool>()).prop_map(move |(mut inner, clamped)| {
        inner.sort_unstable();
        inner.dedup_by_key(|(place, _)| *place);
        let repeat = |(place, times)| std::iter::repeat_n(f64::from(place) / 40.0, times);
        let inner = inner.into_iter().flat_map(repeat);
        let before = (0..=degree).map(|i| if clamped { 0.0 } else { -0.1 * (degree - i) as f64 });
        let after = (0..=degree).map(|i| if clamped { 1.0 } else { 1.0 + 0.15 * i as f64 });
        KnotVector::new(degree, before.chain(inner).chain(after).collect()).unwrap()
    })
}

/// A random net of control points, with weights or without.
fn net(count: usize) -> impl Strategy<Value = (Vec<DVec3>, Option<Vec<f64>>)> {
    let points = prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), count);
    let weights = prop::option::of(prop::collection::vec(0.1..10.0_f64, count));
    let points = points.prop_map(|points| points.into_iter().map(DVec3::from).collect());
    (points, weights)
}

/// A surface of degrees up to 5 with a random net, and weights from 0.1 to 10 or none.
pub(crate) fn surface() -> impl Strategy<Value = NurbsSurface> {
    let knots = (1_usize..=5, 1_usize..=5).prop_flat_map(|(p, q)| (knots(p), knots(q)));
    let parts = knots
        .prop_flat_map(|(u, v)| (net(u.control_points() * v.control_points()), Just(u), Just(v)));
    parts.prop_map(|((net, weights), u, v)| NurbsSurface::new(net, weights, u, v).unwrap())
}

/// A surface of degrees up to 5 that is closed in one or both directions.
pub(crate) fn closed_surface() -> impl Strategy<Value = NurbsSurface> {
    let degrees = (1_usize..=5, 1_usize..=5, prop::bool::ANY);
    let parts = degrees.prop_flat_map(|(p, q, both)| {
        let (rows, cols) = (p + 3, q + 2);
        (net(rows * cols), Just(((rows, cols), (p, q), (true, both))))
    });
    parts.prop_map(|((net, weights), (shape, degrees, closed))| {
        NurbsSurface::periodic(&net, weights.as_deref(), shape, degrees, closed).unwrap()
    })
}

/// A curve of degree up to 5.
pub(crate) fn curve() -> impl Strategy<Value = NurbsCurve> {
    let parts = (1_usize..=5)
        .prop_flat_map(knots)
        .prop_flat_map(|knots| (net(knots.control_points()), Just(knots)));
    parts.prop_map(|((points, weights), knots)| NurbsCurve::new(points, weights, knots).unwrap())
}

/// An affine map with entries of similar size.
pub(crate) fn affine() -> impl Strategy<Value = DAffine3> {
    prop::array::uniform12(-2.0..2.0_f64).prop_map(|numbers| DAffine3::from_cols_array(&numbers))
}

/// Fractions of a domain at which shapes are compared.
pub(crate) const STEPS: [f64; 10] = [0.0, 0.013, 0.1, 0.25, 0.43, 0.5, 0.77, 0.9, 0.999, 1.0];

/// The parameter at a fraction of a domain.
pub(crate) fn place((from, to): (f64, f64), share: f64) -> f64 {
    if share == 1.0 { to } else { from + share * (to - from) }
}

/// The parameters at [`STEPS`] of two domains.
pub(crate) fn samples(u: (f64, f64), v: (f64, f64)) -> impl Iterator<Item = DVec2> {
    STEPS.into_iter().flat_map(move |s| STEPS.map(|t| DVec2::new(place(u, s), place(v, t))))
}

/// Estimates how far a point moves when its parameter is rounded.
pub(crate) fn rounding(point: impl Fn(f64) -> DVec3, at: f64, (start, end): (f64, f64)) -> f64 {
    let step = 1e-6 * (end - start);
    let beside = if at + step <= end { at + step } else { at - step };
    let speed = point(beside).distance(point(at)) / step;
    4.0 * f64::EPSILON * start.abs().max(end.abs()) * speed
}

/// Asserts that `b` at each parameter is `a` at the parameter `of_a` of it.
pub(crate) fn assert_same_at(a: &NurbsSurface, b: &NurbsSurface, of_a: impl Fn(DVec2) -> DVec2) {
    let (u, v) = (b.knots_u().domain(), b.knots_v().domain());
    for at in samples(u, v) {
        let place = of_a(at);
        let moved = a.point(place.x, place.y).distance(b.point(at.x, at.y));
        let rounded =
            rounding(|u| b.point(u, at.y), at.x, u) + rounding(|v| b.point(at.x, v), at.y, v);
        assert!(moved <= EXACT * a.size() + rounded, "{moved:e} at {at}");
    }
}

/// Asserts that two surfaces have the same domain and the same points.
pub(crate) fn assert_same(a: &NurbsSurface, b: &NurbsSurface) {
    assert_eq!(
        (a.knots_u().domain(), a.knots_v().domain()),
        (b.knots_u().domain(), b.knots_v().domain())
    );
    assert_same_at(a, b, |at| at);
}

/// Returns the knots among `wanted` that can be inserted without exceeding the degree.
pub(crate) fn insertable(knots: &KnotVector, wanted: &[f64]) -> Vec<f64> {
    let mut chosen: Vec<f64> = Vec::new();
    for value in wanted {
        let times = chosen.iter().filter(|other| *other == value).count();
        if knots.multiplicity(*value) + times < knots.degree() {
            chosen.push(*value);
        }
    }
    chosen
}
