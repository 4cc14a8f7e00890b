"""Closest points, tangents, curvature and boxes of curves; single parameters; knots and degrees."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import neurbs
from neurbs import NeurbsError, NurbsCurve, NurbsSurface

CIRCLE = NurbsCurve.arc([1, 2, 3], [4, 0, 0], [0, 4, 0])


def wild(rng: np.random.Generator) -> NurbsCurve:
    return NurbsCurve(rng.random((9, 3)), weights=rng.uniform(0.5, 3, 9), degree=3)


def test_closest_points_are_closer_than_samples(rng: np.random.Generator) -> None:
    curve, points = wild(rng), 2 * rng.random((200, 3)) - 0.5
    found = curve.closest_points(points)
    assert repr(found) == "CurvePoints(200 points)"
    np.testing.assert_allclose(curve.evaluate(found.u), found.points, atol=1e-13)
    np.testing.assert_allclose(np.linalg.norm(points - found.points, axis=1), found.distances)
    samples = curve.evaluate(np.linspace(0, 1, 3001))
    nearest = np.linalg.norm(points[:, None] - samples, axis=2).min(axis=1)
    assert (found.distances <= nearest + 1e-13).all()
    assert (nearest < found.distances + 1e-2).all()
    with pytest.raises(NeurbsError, match="points must"):
        curve.closest_points([[np.nan, 0, 0]])


def test_a_circle_has_its_tangents_curvature_and_box() -> None:
    u = np.linspace(0, 1, 50)
    out = (CIRCLE(u) - [1, 2, 3]) / 4
    tangents = CIRCLE.tangents(u)
    np.testing.assert_allclose(np.linalg.norm(tangents, axis=1), 1)
    np.testing.assert_allclose(
        tangents, np.column_stack([-out[:, 1], out[:, 0], 0 * u]), atol=1e-13
    )
    np.testing.assert_allclose(CIRCLE.curvatures(u), 0.25, rtol=1e-12)
    low, high = CIRCLE.bounding_box()
    np.testing.assert_allclose([low, high], [[-3, -2, 3], [5, 6, 3]], atol=1e-8)


def test_tangents_and_curvature_follow_from_derivatives(rng: np.random.Generator) -> None:
    curve, u = wild(rng), rng.random(100)
    _, first, second = curve.derivatives(u, 2).transpose(1, 0, 2)
    speed = np.linalg.norm(first, axis=1)
    np.testing.assert_allclose(curve.tangents(u), first / speed[:, None], atol=1e-13)
    expected = np.linalg.norm(np.cross(first, second), axis=1) / speed**3
    np.testing.assert_allclose(curve.curvatures(u), expected, rtol=1e-10)
    buffer = np.empty((100, 3))
    assert curve.tangents(u, out=buffer) is buffer


def test_a_curve_without_length_has_neither_tangent_nor_curvature() -> None:
    point = NurbsCurve(np.ones((4, 3)))
    np.testing.assert_array_equal(point.tangents([0.5]), [[0, 0, 0]])
    assert np.isnan(point.curvatures([0.5])).all()


def test_boxes_of_wild_curves_contain_and_touch_them(rng: np.random.Generator) -> None:
    for _ in range(20):
        curve = wild(rng)
        samples = curve.evaluate(np.linspace(0, 1, 4001))
        low, high = curve.bounding_box()
        assert (low <= samples.min(axis=0) + 1e-9).all()
        assert (high >= samples.max(axis=0) - 1e-9).all()
        np.testing.assert_allclose(
            [low, high], [samples.min(axis=0), samples.max(axis=0)], atol=1e-4
        )
        outer_low, outer_high = curve.bounding_box(tight=False)
        assert (outer_low <= low).all()
        assert (outer_high >= high).all()


def test_single_parameters_give_single_points(rng: np.random.Generator) -> None:
    curve, surface = wild(rng), NurbsSurface(rng.random((5, 6, 3)))
    assert surface.evaluate([0.5, 0.5]).shape == (3,)
    assert surface.normals([0.5, 0.5]).shape == (3,)
    assert surface.derivatives([0.5, 0.5], 2).shape == (3, 3, 3)
    np.testing.assert_array_equal(surface(0.5, 0.25), surface.evaluate([[0.5, 0.25]])[0])
    u, v = rng.random((4, 1)), rng.random(3)
    points = surface(u, v)
    assert points.shape == (4, 3, 3)
    np.testing.assert_allclose(points, surface.evaluate_grid(u[:, 0], v), atol=1e-15)
    with pytest.raises(NeurbsError, match="inside the domain"):
        surface(0.5, 2)
    with pytest.raises(NeurbsError, match="u and v must have shapes that broadcast"):
        surface([0, 1], [0, 0.5, 1])
    assert curve.evaluate(0.5).shape == curve(0.5).shape == curve.tangents(0.5).shape == (3,)
    assert curve(rng.random((2, 5))).shape == (2, 5, 3)
    assert curve.derivatives(0.5).shape == (2, 3)
    assert curve.curvatures(0.5).shape == ()
    out = np.empty(3)
    assert surface.evaluate([0.5, 0.5], out=out) is out


def largest_distance(a: NurbsCurve, b: NurbsCurve) -> float:
    """Return the largest distance at the same parameters, from samples and a search."""

    def distance(u: float) -> float:
        return float(np.linalg.norm(a(np.clip(u, 0, 1)) - b(np.clip(u, 0, 1))))

    u = np.linspace(0, 1, 2001)
    start = u[np.argmax(np.linalg.norm(a(u) - b(u), axis=1))]
    around = (start - 1e-3, start + 1e-3)
    best = minimize_scalar(lambda u: -distance(u), bounds=around, method="bounded")
    return -float(best.fun)


def test_a_degree_is_reduced_by_the_measured_deviation() -> None:
    curve = NurbsCurve([[0, 0], [1, 2], [3, 3], [5, 2], [6, 0], [8, 1]], degree=5)
    reduced = curve.reduce_degree(1, tolerance=0.05)
    assert reduced.degree == 4
    true = largest_distance(curve, reduced)
    assert 0.012 < true < 0.014
    curve.reduce_degree(1, tolerance=1.002 * true)
    with pytest.raises(NeurbsError, match="tolerance must be at least") as refused:
        curve.reduce_degree(1, tolerance=0.99 * true)
    needed = float(str(refused.value).split("at least ")[1].split()[0])
    assert true <= needed * (1 + 1e-9)
    assert needed <= 1.0011 * true
    # What the message says is possible.
    curve.reduce_degree(1, tolerance=needed)


def test_a_surface_s_degree_is_reduced_by_the_measured_deviation(rng: np.random.Generator) -> None:
    net = rng.random((7, 6, 3))
    for weights in (None, rng.uniform(0.8, 1.25, (7, 6))):
        surface = NurbsSurface(net, weights, degree=(4, 3))
        with pytest.raises(NeurbsError, match="tolerance must be at least") as refused:
            surface.reduce_degree(u=1, v=1, tolerance=1e-9)
        needed = float(str(refused.value).split("at least ")[1].split()[0])
        reduced = surface.reduce_degree(u=1, v=1, tolerance=needed)
        t = np.linspace(0, 1, 400)
        off = np.linalg.norm(surface.evaluate_grid(t, t) - reduced.evaluate_grid(t, t), axis=2)
        assert 0.995 * needed < off.max() <= needed


def test_knots_are_inserted_at_the_ends_of_an_unclamped_domain(rng: np.random.Generator) -> None:
    curve = NurbsCurve(rng.random((8, 3)), degree=3, knots=np.arange(12.0))
    assert curve.domain == (3, 8)
    refined = curve.insert_knots([3, 3, 8, 5.5])
    assert refined.domain == curve.domain
    assert list(refined.knots).count(3) == 3
    u = np.linspace(3, 8, 200)
    np.testing.assert_allclose(refined(u), curve(u), atol=1e-14)
    with pytest.raises(NeurbsError, match="3 would have multiplicity 4"):
        curve.insert_knots([3, 3, 3])
    with pytest.raises(NeurbsError, match=r"knots must be in the domain \[3, 8\], got 2"):
        curve.insert_knots([2])
    with pytest.raises(NeurbsError, match="0 would have multiplicity 5"):
        NurbsCurve(rng.random((8, 3))).insert_knots([0])
    ring = NurbsSurface(rng.random((6, 7, 3)), closed=(True, False))
    start, end = ring.domain[0]
    t = np.linspace(0, 1, 30)
    finer = ring.insert_knots(u=[start, end])
    np.testing.assert_allclose(finer.evaluate_grid(t, t), ring.evaluate_grid(t, t), atol=1e-14)


def test_a_ring_that_repeats_its_first_point_is_refused() -> None:
    angle = np.linspace(0, 2 * np.pi, 13)
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    for parametrization in ("chord", "uniform", "centripetal"):
        with pytest.raises(NeurbsError, match="the first one again at the end: leave it out"):
            NurbsCurve.interpolate(ring, closed=True, parametrization=parametrization)
    assert NurbsCurve.interpolate(ring[:-1], closed=True).closed
    tube = np.stack([np.column_stack([ring, np.full(13, z)]) for z in (0.0, 1.0, 2.0, 3.0)], axis=1)
    for method in (NurbsSurface.interpolate, NurbsSurface.grid_parameters):
        with pytest.raises(NeurbsError, match="the first one again at the end: leave it out"):
            method(tube, closed=(True, False))
    assert NurbsSurface.interpolate(tube[:-1], closed=(True, False)).closed == (True, False)


def test_heights_on_short_nets_have_lower_degrees(rng: np.random.Generator) -> None:
    x, y = rng.random((2, 500))
    points = np.column_stack([x, y, x - 2 * y])
    fit = neurbs.fit_heights(points, (2, 3))
    assert fit.surface.degree == (1, 2)
    assert np.abs(fit.residuals).max() < 1e-12
