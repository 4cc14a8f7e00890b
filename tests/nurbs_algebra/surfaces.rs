//! Open surfaces, clamped and unclamped.

use neurbs::nurbs::{Direction, NurbsSurface};
use neurbs::progress::Silent;
use neurbs::{DVec2, DVec3};
use proptest::prelude::*;

use crate::strategies::{EXACT, affine, assert_same, assert_same_at, insertable, samples, surface};

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    #[test]
    fn insertion_keeps_the_shape(surface in surface(), new in prop::collection::vec(1_u8..80, 1..12)) {
        let new: Vec<f64> = new.into_iter().map(|place| f64::from(place) / 80.0).collect();
        let u = insertable(surface.knots_u(), &new);
        let v = insertable(surface.knots_v(), &new);
        let refined = surface.insert_knots(Direction::U, &u, &mut Silent).unwrap();
        let refined = refined.insert_knots(Direction::V, &v, &mut Silent).unwrap();
        prop_assert_eq!(refined.shape(), (surface.shape().0 + u.len(), surface.shape().1 + v.len()));
        assert_same(&surface, &refined);
    }

    #[test]
    fn removal_undoes_insertion(surface in surface(), new in 1_u8..80) {
        let surface = surface.clamp(&mut Silent).unwrap();
        let new = insertable(surface.knots_u(), &[f64::from(new) / 80.0]);
        let refined = surface.insert_knots(Direction::U, &new, &mut Silent).unwrap();
        let tolerance = 1e-12 * surface.size();
        let back = refined.remove_knots(Direction::U, Some(&new), tolerance, &mut Silent).unwrap();
        prop_assert_eq!(back.shape(), surface.shape());
        for at in samples((0.0, 1.0), (0.0, 1.0)) {
            prop_assert!(surface.point(at.x, at.y).distance(back.point(at.x, at.y)) <= tolerance);
        }
    }

    #[test]
    fn removal_stays_within_tolerance(surface in surface(), tolerance in 0.001..1.0_f64) {
        let less = surface.remove_knots(Direction::V, None, tolerance, &mut Silent).unwrap();
        for at in samples((0.0, 1.0), (0.0, 1.0)) {
            let moved = surface.point(at.x, at.y).distance(less.point(at.x, at.y));
            prop_assert!(moved <= tolerance, "{} > {}", moved, tolerance);
        }
    }

    #[test]
    fn reduction_undoes_elevation(surface in surface(), u in 0_usize..3, v in 0_usize..3) {
        let raised = surface.elevate_degree(u, v, &mut Silent).unwrap();
        prop_assert_eq!(raised.knots_u().degree(), surface.knots_u().degree() + u);
        assert_same(&surface, &raised);
        let tolerance = 1e-9 * surface.size();
        let lowered = raised.reduce_degree(u, v, tolerance, &mut Silent).unwrap();
        for at in samples((0.0, 1.0), (0.0, 1.0)) {
            prop_assert!(surface.point(at.x, at.y).distance(lowered.point(at.x, at.y)) <= tolerance);
        }
    }

    #[test]
    fn parts_match_the_surface(surface in surface(), at in 0.01..0.99_f64) {
        assert_same(&surface, &surface.clamp(&mut Silent).unwrap());
        for direction in [Direction::U, Direction::V] {
            let (before, after) = surface.split(direction, at, &mut Silent).unwrap();
            assert_same_at(&surface, &before, |at| at);
            assert_same_at(&surface, &after, |at| at);
            let whole = before.joined(direction, &after, 1e-12 * surface.size(), &mut Silent).unwrap();
            assert_same(&surface, &whole);
        }
        let part = surface.sub_surface((0.5 * at, at), (at, 1.0), &mut Silent).unwrap();
        prop_assert_eq!(part.knots_u().domain(), (0.5 * at, at));
        assert_same_at(&surface, &part, |at| at);
        for patch in surface.bezier_patches(&mut Silent).unwrap().iter().flatten() {
            prop_assert_eq!(patch.knots_u().spans() * patch.knots_v().spans(), 1);
            assert_same_at(&surface, patch, |at| at);
        }
    }

    #[test]
    fn affine_maps_commute_with_evaluation(surface in surface(), map in affine()) {
        let moved = surface.transformed(&map).unwrap();
        let size = surface.size() + moved.size();
        for at in samples((0.0, 1.0), (0.0, 1.0)) {
            let expected = map.transform_point3(surface.point(at.x, at.y));
            prop_assert!(moved.point(at.x, at.y).distance(expected) <= EXACT * size);
        }
    }

    #[test]
    fn surfaces_of_other_degrees_are_joined(surface in surface(), at in 0.1..0.9_f64, u in 0_usize..3, v in 0_usize..3) {
        let (before, after) = surface.split(Direction::V, at, &mut Silent).unwrap();
        let raised = after.elevate_degree(u, v, &mut Silent).unwrap().insert_knots(Direction::V, &[f64::midpoint(at, 1.0)], &mut Silent);
        let raised = raised.unwrap().with_domain((0.0, 1.0), (7.0, 8.0 - at)).unwrap();
        let whole = before.joined(Direction::V, &raised, 1e-12 * surface.size(), &mut Silent).unwrap();
        prop_assert_eq!(whole.knots_v().degree(), surface.knots_v().degree() + v);
        let apart = whole.knots_v().domain().1 - 1.0;
        prop_assert!(apart.abs() < 1e-14);
        for at in samples((0.0, 1.0), (0.0, 1.0)) {
            let moved = whole.point(at.x, at.y).distance(surface.point(at.x, at.y));
            prop_assert!(moved <= 1e-12 * surface.size(), "{:e} at {}", moved, at);
        }
    }

    #[test]
    fn transposed_reversed_and_isocurves_match_the_surface(surface in surface(), at in 0.0..1.0_f64) {
        assert_same_at(&surface, &surface.transposed(&mut Silent).unwrap(), |at| DVec2::new(at.y, at.x));
        assert_same_at(&surface, &surface.reversed(Direction::U, &mut Silent).unwrap(), |at| DVec2::new(1.0 - at.x, at.y));
        assert_same_at(&surface, &surface.reversed(Direction::V, &mut Silent).unwrap(), |at| DVec2::new(at.x, 1.0 - at.y));
        let moved = surface.with_domain((-2.0, 1.0), (5.0, 5.5)).unwrap();
        assert_same_at(&surface, &moved, |at| {
            DVec2::new((at.x + 2.0) / 3.0, (at.y - 5.0) * 2.0).clamp(DVec2::ZERO, DVec2::ONE)
        });
        let (across, along) = (surface.isocurve(Direction::U, at).unwrap(), surface.isocurve(Direction::V, at).unwrap());
        for t in [0.0, 0.3, 0.8, 1.0] {
            prop_assert!(across.point(t).distance(surface.point(at, t)) <= EXACT * surface.size());
            prop_assert!(along.point(t).distance(surface.point(t, at)) <= EXACT * surface.size());
        }
    }
}

proptest! {
    // The area of such an irregular surface is slow to compute.
    #![proptest_config(ProptestConfig { cases: 6, ..ProptestConfig::default() })]

    #[test]
    fn areas_and_boxes_do_not_change(surface in surface(), at in 0.1..0.9_f64) {
        let area = |surface: &NurbsSurface| surface.area(1e-5, &mut Silent).unwrap();
        let whole = area(&surface);
        let raised = area(&surface.elevate_degree(1, 1, &mut Silent).unwrap());
        prop_assert!((raised / whole - 1.0).abs() < 1e-4);
        let (before, after) = surface.split(Direction::U, at, &mut Silent).unwrap();
        prop_assert!(((area(&before) + area(&after)) / whole - 1.0).abs() < 1e-4);
        let (low, high) = surface.bounding_box(&mut Silent).unwrap();
        let (below, above) = surface.transposed(&mut Silent).unwrap().bounding_box(&mut Silent).unwrap();
        prop_assert!(low.distance(below) <= 1e-9 && high.distance(above) <= 1e-9);
        for at in samples((0.0, 1.0), (0.0, 1.0)) {
            let p = surface.point(at.x, at.y);
            let outside = (low - p).max(p - high).max_element();
            prop_assert!(outside <= EXACT * surface.size());
        }
    }
}

#[test]
fn invalid_arguments_are_refused() {
    let net = (0..16).map(|i| DVec3::new(f64::from(i / 4), f64::from(i % 4), 0.0)).collect();
    let surface = NurbsSurface::clamped(net, (4, 4), 3).unwrap();
    let message = |result: neurbs::Result<NurbsSurface>| result.unwrap_err().to_string();
    assert_eq!(
        message(surface.insert_knots(Direction::U, &[0.5, 1.0], &mut Silent)),
        "a knot vector of degree 3 must repeat no knot more than degree times, but 1 would have \
         multiplicity 5"
    );
    assert!(
        message(surface.insert_knots(Direction::U, &[0.5; 4], &mut Silent))
            .contains("0.5 has multiplicity 4")
    );
    assert!(
        message(surface.elevate_degree(23, 0, &mut Silent))
            .contains("at most 25 after elevation, got 26")
    );
    assert!(
        message(surface.reduce_degree(3, 0, 1.0, &mut Silent))
            .contains("less than the degree, 3, got 3")
    );
    assert!(
        message(surface.remove_knots(Direction::U, None, f64::NAN, &mut Silent))
            .contains("got NaN")
    );
    assert!(
        message(surface.split(Direction::V, 0.0, &mut Silent).map(|parts| parts.0))
            .contains("got 0")
    );
    assert!(
        message(surface.sub_surface((0.5, 0.5), (0.0, 1.0), &mut Silent))
            .contains("got (0.5, 0.5)")
    );
    let apart = surface.map_control_points(|p| p + DVec3::new(4.0, 0.0, 0.0)).unwrap();
    assert!(
        message(surface.joined(Direction::U, &apart, 0.1, &mut Silent))
            .contains("the distance between the edges")
    );
    assert!(surface.isocurve(Direction::U, 1.5).is_err());
}
