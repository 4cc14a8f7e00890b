//! Knot algebra leaves the shape where it was, to 1e-13 of its size.

use neurbs::nurbs::{Direction, KnotVector, NurbsSurface};
use neurbs::{DVec2, DVec3};
use proptest::prelude::*;

/// Share of the size by which no point may move.
const EXACT: f64 = 1e-13;

/// A knot vector of this degree with some inner knots, repeated or not, clamped or not.
fn knots(degree: usize) -> impl Strategy<Value = KnotVector> {
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

/// A surface of any degrees up to 5, of random net and weights from 0.1 to 10 or none.
fn surface() -> impl Strategy<Value = NurbsSurface> {
    let knots = (1_usize..=5, 1_usize..=5).prop_flat_map(|(p, q)| (knots(p), knots(q)));
    let parts = knots.prop_flat_map(|(u, v)| {
        let count = u.control_points() * v.control_points();
        let net = prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), count);
        let weights = prop::option::of(prop::collection::vec(0.1..10.0_f64, count));
        (net, weights, Just(u), Just(v))
    });
    parts.prop_map(|(net, weights, u, v)| {
        let net = net.into_iter().map(DVec3::from).collect();
        NurbsSurface::new(net, weights, u, v).unwrap()
    })
}

fn samples(u: (f64, f64), v: (f64, f64)) -> impl Iterator<Item = DVec2> {
    let steps = [0.0, 0.013, 0.1, 0.25, 0.43, 0.5, 0.77, 0.9, 0.999, 1.0];
    let place = |(from, to): (f64, f64), t: f64| if t == 1.0 { to } else { from + t * (to - from) };
    let both = move |s| steps.map(|t| DVec2::new(place(u, s), place(v, t)));
    steps.into_iter().flat_map(both)
}

fn same_where(a: &NurbsSurface, b: &NurbsSurface, of_a: impl Fn(DVec2) -> DVec2) {
    for at in samples(b.knots_u().domain(), b.knots_v().domain()) {
        let place = of_a(at);
        let moved = a.point(place.x, place.y).distance(b.point(at.x, at.y));
        assert!(moved <= EXACT * a.size(), "{moved:e} at {at}");
    }
}

fn same(a: &NurbsSurface, b: &NurbsSurface) {
    assert_eq!(
        (a.knots_u().domain(), a.knots_v().domain()),
        (b.knots_u().domain(), b.knots_v().domain())
    );
    same_where(a, b, |at| at);
}

/// Knots that may still be inserted.
fn room(knots: &KnotVector, wanted: &[f64]) -> Vec<f64> {
    let mut chosen: Vec<f64> = Vec::new();
    for value in wanted {
        let times = chosen.iter().filter(|other| *other == value).count();
        if knots.multiplicity(*value) + times < knots.degree() {
            chosen.push(*value);
        }
    }
    chosen
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    #[test]
    fn insertion(surface in surface(), new in prop::collection::vec(1_u8..80, 1..12)) {
        let new: Vec<f64> = new.into_iter().map(|place| f64::from(place) / 80.0).collect();
        let u = room(surface.knots_u(), &new);
        let v = room(surface.knots_v(), &new);
        let refined = surface.insert_knots(Direction::U, &u).unwrap();
        let refined = refined.insert_knots(Direction::V, &v).unwrap();
        prop_assert_eq!(refined.shape(), (surface.shape().0 + u.len(), surface.shape().1 + v.len()));
        same(&surface, &refined);
    }

    #[test]
    fn removal_takes_back_what_insertion_gave(surface in surface(), new in 1_u8..80) {
        let surface = surface.clamp().unwrap();
        let new = room(surface.knots_u(), &[f64::from(new) / 80.0]);
        let refined = surface.insert_knots(Direction::U, &new).unwrap();
        let tolerance = 1e-12 * surface.size();
        let back = refined.remove_knots(Direction::U, Some(&new), tolerance).unwrap();
        prop_assert_eq!(back.shape(), surface.shape());
        for at in samples((0.0, 1.0), (0.0, 1.0)) {
            prop_assert!(surface.point(at.x, at.y).distance(back.point(at.x, at.y)) <= tolerance);
        }
    }

    #[test]
    fn removal_holds_its_tolerance(surface in surface(), tolerance in 0.001..1.0_f64) {
        let less = surface.remove_knots(Direction::V, None, tolerance).unwrap();
        for at in samples((0.0, 1.0), (0.0, 1.0)) {
            let moved = surface.point(at.x, at.y).distance(less.point(at.x, at.y));
            prop_assert!(moved <= tolerance, "{} > {}", moved, tolerance);
        }
    }

    #[test]
    fn elevation_and_reduction(surface in surface(), u in 0_usize..3, v in 0_usize..3) {
        let raised = surface.elevate_degree(u, v).unwrap();
        prop_assert_eq!(raised.knots_u().degree(), surface.knots_u().degree() + u);
        same(&surface, &raised);
        let tolerance = 1e-9 * surface.size();
        let lowered = raised.reduce_degree(u, v, tolerance).unwrap();
        for at in samples((0.0, 1.0), (0.0, 1.0)) {
            prop_assert!(surface.point(at.x, at.y).distance(lowered.point(at.x, at.y)) <= tolerance);
        }
    }

    #[test]
    fn parts(surface in surface(), at in 0.01..0.99_f64) {
        same(&surface, &surface.clamp().unwrap());
        for direction in [Direction::U, Direction::V] {
            let (before, after) = surface.split(direction, at).unwrap();
            same_where(&surface, &before, |at| at);
            same_where(&surface, &after, |at| at);
            let whole = before.joined(direction, &after, 1e-12 * surface.size()).unwrap();
            same(&surface, &whole);
        }
        let part = surface.sub_surface((0.5 * at, at), (at, 1.0)).unwrap();
        prop_assert_eq!(part.knots_u().domain(), (0.5 * at, at));
        same_where(&surface, &part, |at| at);
        for patch in surface.bezier_patches().unwrap().iter().flatten() {
            prop_assert_eq!(patch.knots_u().spans() * patch.knots_v().spans(), 1);
            same_where(&surface, patch, |at| at);
        }
    }

    #[test]
    fn directions(surface in surface(), at in 0.0..1.0_f64) {
        same_where(&surface, &surface.transposed().unwrap(), |at| DVec2::new(at.y, at.x));
        same_where(&surface, &surface.reversed(Direction::U).unwrap(), |at| DVec2::new(1.0 - at.x, at.y));
        same_where(&surface, &surface.reversed(Direction::V).unwrap(), |at| DVec2::new(at.x, 1.0 - at.y));
        let moved = surface.with_domain((-2.0, 1.0), (5.0, 5.5)).unwrap();
        same_where(&surface, &moved, |at| {
            DVec2::new((at.x + 2.0) / 3.0, (at.y - 5.0) * 2.0).clamp(DVec2::ZERO, DVec2::ONE)
        });
        let (across, along) = (surface.isocurve(Direction::U, at).unwrap(), surface.isocurve(Direction::V, at).unwrap());
        for t in [0.0, 0.3, 0.8, 1.0] {
            prop_assert!(across.point(t).distance(surface.point(at, t)) <= EXACT * surface.size());
            prop_assert!(along.point(t).distance(surface.point(t, at)) <= EXACT * surface.size());
        }
    }
}

#[test]
fn refusals() {
    let net = (0..16).map(|i| DVec3::new(f64::from(i / 4), f64::from(i % 4), 0.0)).collect();
    let surface = NurbsSurface::clamped(net, (4, 4), 3).unwrap();
    let message = |result: neurbs::Result<NurbsSurface>| result.unwrap_err().to_string();
    assert_eq!(
        message(surface.insert_knots(Direction::U, &[0.5, 1.0])),
        "knots must be strictly inside the domain (0, 1), got 1"
    );
    assert!(message(surface.insert_knots(Direction::U, &[0.5; 4])).contains("0.5 stands 4 times"));
    assert!(message(surface.elevate_degree(7, 0)).contains("at most 9 after elevation, got 10"));
    assert!(message(surface.reduce_degree(3, 0, 1.0)).contains("less than the degree, 3, got 3"));
    assert!(message(surface.remove_knots(Direction::U, None, f64::NAN)).contains("got NaN"));
    assert!(message(surface.split(Direction::V, 0.0).map(|parts| parts.0)).contains("got 0"));
    assert!(message(surface.sub_surface((0.5, 0.5), (0.0, 1.0))).contains("got (0.5, 0.5)"));
    let apart = surface.map_control_points(|p| p + DVec3::new(4.0, 0.0, 0.0)).unwrap();
    assert!(message(surface.joined(Direction::U, &apart, 0.1)).contains("how far the edges are"));
    assert!(surface.isocurve(Direction::U, 1.5).is_err());
}
