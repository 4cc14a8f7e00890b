"""Shapes with known points, normals, curvatures, areas and seams."""

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs

Array = NDArray[np.float64]

T = np.linspace(0, 1, 61)


@pytest.mark.parametrize("scale", [1e-70, 1e-6, 1, 1e6, 1e70])
def test_a_sphere_is_a_sphere(scale: float) -> None:
    radius = 3 * scale
    sphere = neurbs.NurbsSurface.sphere([0, 0, 0], radius)
    points, normals = sphere.normals_grid(T, T)
    np.testing.assert_allclose(np.linalg.norm(points / radius, axis=-1), 1, rtol=0, atol=1e-14)
    np.testing.assert_allclose(normals, points / radius, rtol=0, atol=1e-14)
    bends = sphere.curvatures_grid(T, T[1:-1])
    # Second derivatives are the radius times the square of the domain's length.
    np.testing.assert_allclose(bends.gaussian * radius**2, 1, rtol=0, atol=2e-13)
    np.testing.assert_allclose(bends.mean * radius, -1, rtol=0, atol=1e-13)
    assert sphere.area(accuracy=1e-12) == pytest.approx(4 * np.pi * radius**2, rel=1e-12)
    low, high = sphere.bounding_box()
    np.testing.assert_allclose(np.r_[low, high] / radius, [-1] * 3 + [1] * 3, rtol=0, atol=1e-10)
    points = np.random.default_rng(0).normal(size=(200, 3)) * scale
    projections = sphere.closest_points(points)
    distances = np.abs(np.linalg.norm(points / scale, axis=1) - 3)
    np.testing.assert_allclose(projections.distances / scale, distances, rtol=0, atol=1e-13)


def test_a_torus_is_a_torus() -> None:
    torus = neurbs.NurbsSurface.torus([0, 0, 0], 3, 1)
    bends = torus.curvatures_grid(T, T)
    ring = np.hypot(bends.points[..., 0], bends.points[..., 1])
    np.testing.assert_allclose(np.hypot(ring - 3, bends.points[..., 2]), 1, rtol=0, atol=1e-14 * 8)
    weak = (ring - 3) / ring
    # Both principal curvatures bend away from the outward normal.
    np.testing.assert_allclose(bends.gaussian, weak, rtol=0, atol=1e-13)
    np.testing.assert_allclose(bends.mean, -(1 + weak) / 2, rtol=0, atol=1e-13)
    np.testing.assert_allclose(bends.principal[..., 0], -weak, rtol=0, atol=1e-13)
    np.testing.assert_allclose(bends.principal[..., 1], -1, rtol=0, atol=1e-13)
    round_axis = np.cross([0, 0, 1], bends.points) / ring[..., None]
    along = np.abs((bends.directions[..., 0, :] * round_axis).sum(-1))
    np.testing.assert_allclose(along, 1, rtol=0, atol=1e-13)
    assert torus.area(accuracy=1e-12) == pytest.approx(12 * np.pi**2, rel=1e-12)


@pytest.mark.parametrize("degree", [(2, 2), (3, 4), (5, 3)])
def test_a_saddle_has_the_curvatures_of_its_height_field(degree: tuple[int, int]) -> None:
    saddle = neurbs.NurbsSurface.bezier(
        [[[x, y, x * y] for y in (-1, 1)] for x in (-1, 1)]
    ).elevate_degree(degree[0] - 1, degree[1] - 1)
    saddle = saddle.insert_knots(u=[0.3, 0.3, 0.8], v=[0.5])
    bends = saddle.curvatures_grid(T, T)
    x, y = bends.points[..., 0], bends.points[..., 1]
    g = 1 + x**2 + y**2
    np.testing.assert_allclose(bends.points[..., 2], x * y, rtol=0, atol=1e-14)
    np.testing.assert_allclose(bends.gaussian, -1 / g**2, rtol=0, atol=1e-13)
    np.testing.assert_allclose(bends.mean, -x * y / g**1.5, rtol=0, atol=1e-13)
    uv = np.stack(np.meshgrid(T, T, indexing="ij"), axis=-1).reshape(-1, 2)
    first, second = saddle.fundamental_forms(uv)
    det = np.linalg.det
    np.testing.assert_allclose(det(second) / det(first), bends.gaussian.ravel(), rtol=0, atol=1e-13)


@pytest.mark.parametrize("degree", [*range(1, 10), 12, 25])
@pytest.mark.parametrize("rational", [False, True])
def test_closed_directions_have_no_seam(degree: int, rational: bool) -> None:
    rng = np.random.default_rng(degree)
    shape = (degree + 4, degree + 2)
    turns = [np.linspace(0, 2 * np.pi, n, endpoint=False) for n in shape]
    a, b = np.meshgrid(*turns, indexing="ij")
    tube = 3 + np.cos(b)
    net = np.stack([tube * np.cos(a), tube * np.sin(a), np.sin(b)], axis=-1)
    net += rng.uniform(-0.1, 0.1, net.shape)
    weights = rng.uniform(0.1, 10, shape) if rational else None
    surface = neurbs.NurbsSurface(net, weights, degree, closed=True)
    assert surface.closed == (True, True)
    order = min(degree - 1, 18)
    for swap in (False, True):
        sides = [np.column_stack([np.full(40, end), T[:40]]) for end in (0.0, 1.0)]
        start, end = (side[:, ::-1] if swap else side for side in sides)
        np.testing.assert_allclose(
            surface.evaluate(start), surface.evaluate(end), rtol=0, atol=1e-14 * 12
        )
        if degree == 1:
            continue
        np.testing.assert_allclose(surface.normals(start), surface.normals(end), atol=1e-12)
        one, other = surface.derivatives(start, order), surface.derivatives(end, order)
        scale = np.abs(one).max(axis=(0, 3)) + 8
        assert (np.abs(one - other).max(axis=(0, 3)) <= 1e-12 * scale).all()
        if degree > 2:
            bends = surface.curvatures(start), surface.curvatures(end)
            scale = np.abs(bends[0].principal).max()
            np.testing.assert_allclose(bends[0].mean, bends[1].mean, rtol=0, atol=1e-11 * scale)


def test_closest_points_cross_a_smooth_seam() -> None:
    turns = np.linspace(0, 2 * np.pi, 8, endpoint=False)
    net = [[[np.cos(t), np.sin(t), z] for z in (0, 1)] for t in turns]
    tube = neurbs.NurbsSurface(net, degree=(3, 1), closed=(True, False))
    at = [[0, 0.5]]
    seam, out, along = tube.evaluate(at), tube.normals(at), tube.derivatives(at, 1)[:, 1, 0]
    beside = np.vstack([seam + 0.4 * out + 1e-7 * side * along for side in (1, -1)])
    projections = tube.closest_points(beside)
    assert projections.converged.all()
    np.testing.assert_allclose(projections.distances, 0.4, rtol=0, atol=1e-12)
    assert set(np.round(projections.uv[:, 0])) == {0.0, 1.0}
