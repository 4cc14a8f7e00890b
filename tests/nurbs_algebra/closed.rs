//! Closed surfaces: they stay closed and smooth at the seam under knot algebra.

use neurbs::nurbs::{Direction, NurbsSurface, Outside};
use neurbs::progress::Silent;
use neurbs::{DVec2, DVec3};
use proptest::prelude::*;

use crate::strategies::{assert_same, assert_same_at, closed_surface};

/// Returns all derivatives below the degree of the closed direction, on both sides of the seam.
fn seam_derivatives(surface: &NurbsSurface, t: f64, direction: Direction) -> [Vec<DVec3>; 2] {
    let order = surface.knots(direction).degree() - 1;
    let (start, end) = surface.knots(direction).domain();
    [start, end].map(|at| {
        let at = if direction == Direction::U { DVec2::new(at, t) } else { DVec2::new(t, at) };
        let mut out = vec![DVec3::ZERO; (order + 1) * (order + 1)];
        surface.derivatives(&[at], order, &mut out, Outside::Refuse, &mut Silent).unwrap();
        out
    })
}

/// Bounds the derivatives of these orders relative to the size of the surface. Each differentiation
/// multiplies by the degree and divides by the length of a span.
fn derivative_bound(surface: &NurbsSurface, orders: (usize, usize)) -> f64 {
    let one = |direction| {
        let knots = surface.knots(direction);
        (2 * knots.degree() * knots.spans()) as f64
    };
    let power = |base: f64, order: usize| (0..order).map(|_| base).product::<f64>();
    power(one(Direction::U), orders.0) * power(one(Direction::V), orders.1)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    #[test]
    fn derivatives_below_the_degree_agree_across_the_seam(surface in closed_surface(), t in 0.01..0.99_f64) {
        let closed = surface.closed();
        for (direction, closed) in [(Direction::U, closed.0), (Direction::V, closed.1)] {
            if !closed {
                continue;
            }
            let [before, after] = seam_derivatives(&surface, t, direction);
            let order = surface.knots(direction).degree();
            for (k, (a, b)) in before.iter().zip(&after).enumerate() {
                let scale = surface.size() * derivative_bound(&surface, (k / order, k % order));
                prop_assert!(a.distance(*b) <= 1e-14 * scale, "{} {} {:e}", a, b, scale);
            }
        }
    }

    #[test]
    fn algebra_keeps_the_shape(surface in closed_surface(), at in 0.1..0.9_f64) {
        assert_same(&surface, &surface.clamp(&mut Silent).unwrap());
        assert_same(&surface, &surface.elevate_degree(1, 2, &mut Silent).unwrap());
        assert_same(&surface, &surface.insert_knots(Direction::U, &[at], &mut Silent).unwrap());
        assert_same_at(&surface, &surface.transposed(&mut Silent).unwrap(), |at| DVec2::new(at.y, at.x));
        assert_same_at(&surface, &surface.reversed(Direction::U, &mut Silent).unwrap(), |at| DVec2::new(1.0 - at.x, at.y));
        for patch in surface.bezier_patches(&mut Silent).unwrap().iter().flatten() {
            assert_same_at(&surface, patch, |at| at);
        }
        for moved in [surface.clamp(&mut Silent), surface.elevate_degree(1, 1, &mut Silent), surface.reversed(Direction::U, &mut Silent)] {
            prop_assert_eq!(moved.unwrap().closed(), surface.closed());
        }
        let far = surface.map_control_points(|p| p + DVec3::new(5e6, 7.5e6, 300.0)).unwrap();
        prop_assert_eq!(far.closed(), surface.closed());
    }

    #[test]
    fn a_tube_cut_open_is_joined_at_another_place(surface in closed_surface(), at in 0.1..0.9_f64) {
        let (before, after) = surface.split(Direction::U, at, &mut Silent).unwrap();
        let turned = after.joined(Direction::U, &before, 1e-12 * surface.size(), &mut Silent).unwrap();
        prop_assert!(turned.closed().0);
        prop_assert_eq!(turned.closed().1, surface.closed().1);
    }
}

#[test]
fn a_distant_closed_surface_with_uneven_weights_is_closed() {
    let net: Vec<DVec3> =
        (0..30).map(|i| DVec3::splat(f64::from(i * i % 7)) * DVec3::new(0.1, 0.3, 0.2)).collect();
    let weights: Vec<f64> = (0..30).map(|i| if i % 4 == 0 { 0.1 } else { 9.7 }).collect();
    let tube = NurbsSurface::periodic(&net, Some(&weights), (6, 5), (3, 3), (true, false)).unwrap();
    let far = tube.map_control_points(|p| p + DVec3::new(5e6, 7.5e6, 300.0)).unwrap();
    assert_eq!(far.closed(), (true, false));
}
