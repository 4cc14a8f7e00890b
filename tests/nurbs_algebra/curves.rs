//! Curves, clamped and unclamped.

use neurbs::nurbs::{KnotVector, NurbsCurve};
use neurbs::progress::Silent;
use proptest::prelude::*;

use crate::strategies::{EXACT, STEPS, affine, curve, insertable, place, rounding};

fn size(curve: &NurbsCurve) -> f64 {
    let first = curve.control_points()[0];
    curve.control_points().iter().map(|p| p.distance(first)).fold(0.0, f64::max)
}

fn assert_same_at(a: &NurbsCurve, b: &NurbsCurve, of_a: impl Fn(f64) -> f64) {
    let domain = b.knots().domain();
    for share in STEPS {
        let at = place(domain, share);
        let moved = a.point(of_a(at)).distance(b.point(at));
        let rounded = rounding(|u| b.point(u), at, domain);
        assert!(moved <= EXACT * size(a) + rounded, "{moved:e} at {at}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, ..ProptestConfig::default() })]

    #[test]
    fn algebra_keeps_the_shape(curve in curve(), new in prop::collection::vec(1_u8..80, 1..9), times in 1_usize..4) {
        let new: Vec<f64> = new.into_iter().map(|place| f64::from(place) / 80.0).collect();
        let new = insertable(curve.knots(), &new);
        let refined = curve.insert_knots(&new, &mut Silent).unwrap();
        prop_assert_eq!(refined.control_points().len(), curve.control_points().len() + new.len());
        assert_same_at(&curve, &refined, |u| u);
        assert_same_at(&curve, &curve.clamp(&mut Silent).unwrap(), |u| u);
        let raised = curve.elevate_degree(times, &mut Silent).unwrap();
        prop_assert_eq!(raised.knots().degree(), curve.knots().degree() + times);
        assert_same_at(&curve, &raised, |u| u);
        assert_same_at(&curve, &curve.reversed(&mut Silent).unwrap(), |u| 1.0 - u);
        assert_same_at(&curve, &curve.with_domain(-2.0, 3.0).unwrap(), |u| ((u + 2.0) / 5.0).clamp(0.0, 1.0));
    }

    #[test]
    fn removal_and_reduction_undo_insertion_and_elevation(curve in curve(), times in 1_usize..4) {
        let (tolerance, clamped) = (1e-9 * size(&curve), curve.clamp(&mut Silent).unwrap());
        let new = insertable(clamped.knots(), &[0.3125]);
        let refined = clamped.insert_knots(&new, &mut Silent).unwrap();
        let back = refined.remove_knots(Some(&new), tolerance, &mut Silent).unwrap();
        prop_assert_eq!(back.control_points().len(), clamped.control_points().len());
        let lowered = curve.elevate_degree(times, &mut Silent).unwrap().reduce_degree(times, tolerance, &mut Silent).unwrap();
        for u in STEPS {
            prop_assert!(back.point(u).distance(curve.point(u)) <= tolerance);
            prop_assert!(lowered.point(u).distance(curve.point(u)) <= tolerance);
        }
    }

    #[test]
    fn parts_match_the_curve(curve in curve(), at in 0.01..0.99_f64) {
        let (before, after) = curve.split(at, &mut Silent).unwrap();
        assert_same_at(&curve, &before, |u| u);
        assert_same_at(&curve, &after, |u| u);
        assert_same_at(&curve, &curve.sub_curve(0.5 * at, at, &mut Silent).unwrap(), |u| u);
        assert_same_at(&curve, &before.joined(&after, 1e-12 * size(&curve), &mut Silent).unwrap(), |u| u);
        let higher = after.elevate_degree(1, &mut Silent).unwrap();
        let whole = before.joined(&higher, 1e-12 * size(&curve), &mut Silent).unwrap();
        assert_same_at(&curve, &whole, |u| u);
        let length = |curve: &NurbsCurve| curve.length(1e-6, &mut Silent).unwrap();
        prop_assert!(((length(&before) + length(&after)) / length(&curve) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn affine_maps_commute_with_evaluation(curve in curve(), map in affine()) {
        let moved = curve.transformed(&map).unwrap();
        for u in STEPS {
            let expected = map.transform_point3(curve.point(u));
            prop_assert!(moved.point(u).distance(expected) <= EXACT * (size(&curve) + size(&moved)));
        }
    }
}

#[test]
fn accidental_agreement_does_not_end_refinement() {
    let points = [
        [0.224_601_604_416_680_95, 0.830_813_959_498_280_2, -0.361_261_729_518_910_83],
        [-0.944_579_115_979_678, -0.944_301_705_030_958_2, -0.113_636_970_194_129_73],
        [-0.752_563_149_042_843_3, -0.421_643_486_904_881_24, -0.378_465_335_308_948_55],
        [0.136_219_853_682_401_14, 0.528_816_527_493_498, 0.715_961_708_925_106_8],
        [0.0, 0.458_904_032_839_761_94, 0.0],
    ];
    let weights = [
        0.226_496_731_807_403_3,
        5.527_581_152_160_875,
        4.483_335_261_758_421,
        8.153_304_396_725_561,
    ];
    let weights = weights.into_iter().chain([8.819_543_587_928_4]).collect();
    let knots = vec![-0.4, -0.3, -0.2, -0.1, 0.0, 1.0, 1.15, 1.3, 1.45, 1.6];
    let knots = KnotVector::new(4, knots).unwrap();
    let curve = NurbsCurve::new(points.map(Into::into).to_vec(), Some(weights), knots).unwrap();
    let [rough, fine] = [1e-6, 1e-10].map(|share| curve.length(share, &mut Silent).unwrap());
    assert!((rough / fine - 1.0).abs() < 1e-6, "{rough} {fine}");
}

#[test]
fn invalid_arguments_are_refused() {
    let points = (0..4).map(|i| neurbs::DVec3::splat(f64::from(i * i))).collect();
    let curve = NurbsCurve::clamped(points, 3).unwrap();
    let message = |result: neurbs::Result<NurbsCurve>| result.unwrap_err().to_string();
    assert!(
        message(curve.elevate_degree(usize::MAX, &mut Silent))
            .contains("at most 25 after elevation")
    );
    assert!(
        message(curve.reduce_degree(3, 1.0, &mut Silent))
            .contains("less than the degree, 3, got 3")
    );
    assert!(message(curve.sub_curve(0.5, 0.5, &mut Silent)).contains("got (0.5, 0.5)"));
    assert!(message(curve.with_domain(1.0, 1.0)).contains("a nonempty domain"));
    assert!(
        message(curve.joined(&curve, 1.0, &mut Silent)).contains("the distance between the edges")
    );
    assert!(curve.length(0.0, &mut Silent).is_err());
}
