"""Surfaces from data: against SciPy, dense least squares and closed forms."""

import os
import subprocess
import sys

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_interp_spline, make_lsq_spline

import neurbs

Array = NDArray[np.float64]


def test_interpolation_is_that_of_scipy(rng: np.random.Generator) -> None:
    grid = (
        rng.random((20, 30, 3))
        + np.mgrid[0:20, 0:30, 0:1].transpose(1, 2, 3, 0)[:, :, 0][..., [0, 1, 2]]
    )
    surface = neurbs.NurbsSurface.interpolate(grid)
    u, v = neurbs.NurbsSurface.grid_parameters(grid)
    rows = make_interp_spline(u, grid, 3, t=surface.knots[0]).c
    net = make_interp_spline(v, rows.transpose(1, 0, 2), 3, t=surface.knots[1]).c.transpose(1, 0, 2)
    np.testing.assert_allclose(surface.control_points, net, rtol=0, atol=1e-10)
    np.testing.assert_allclose(surface.evaluate_grid(u, v), grid, rtol=0, atol=1e-12 * 40)


def test_approximation_is_that_of_scipy(rng: np.random.Generator) -> None:
    x, y = np.mgrid[0:40, 0:50]
    grid = np.stack([x, y, rng.random((40, 50))], axis=-1)
    surface = neurbs.NurbsSurface.approximate(grid, (9, 11))
    u, v = neurbs.NurbsSurface.grid_parameters(grid)
    rows = make_lsq_spline(u, grid, surface.knots[0], 3).c
    net = make_lsq_spline(v, rows.transpose(1, 0, 2), surface.knots[1], 3).c.transpose(1, 0, 2)
    np.testing.assert_allclose(surface.control_points, net, rtol=0, atol=1e-10)


def test_a_fit_is_that_of_dense_least_squares(rng: np.random.Generator) -> None:
    uv, points = rng.random((800, 2)), rng.random((800, 3))
    weights = rng.uniform(0.1, 2, 800)
    surface = neurbs.NurbsSurface.fit(points, uv, net=(6, 7), weights=weights, fairness=0)
    rows = BSpline.design_matrix(uv[:, 0], surface.knots[0], 3).toarray()
    columns = BSpline.design_matrix(uv[:, 1], surface.knots[1], 3).toarray()
    matrix = np.einsum("ni,nj->nij", rows, columns).reshape(800, -1)
    root = np.sqrt(weights)[:, None]
    net = np.linalg.lstsq(matrix * root, points * root, rcond=None)[0].reshape(6, 7, 3)
    np.testing.assert_allclose(surface.control_points, net, rtol=0, atol=1e-9)


@pytest.mark.parametrize("degree", [1, 3, 5])
def test_closed_interpolation_is_that_of_scipy(degree: int, rng: np.random.Generator) -> None:
    turns = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    ring = np.column_stack([np.cos(turns), np.sin(turns), rng.normal(size=12)])
    curve = neurbs.NurbsCurve.interpolate(ring, degree, parametrization="uniform", closed=True)
    t = np.linspace(0, 1, 13)
    periodic = make_interp_spline(t, np.vstack([ring, ring[:1]]), degree, bc_type="periodic")
    if degree == 1:
        periodic = make_interp_spline(t, np.vstack([ring, ring[:1]]), 1)
    u = np.linspace(0, 1, 101)
    np.testing.assert_allclose(curve.evaluate(u), periodic(u), rtol=0, atol=1e-12)
    assert curve.closed


@pytest.mark.parametrize("degree", range(1, 6))
@pytest.mark.parametrize("parametrization", ["chord", "uniform", "centripetal"])
def test_interpolation_of_any_degree_meets_its_points(
    degree: int, parametrization: str, rng: np.random.Generator
) -> None:
    x, y = np.mgrid[0:9, 0:8]
    grid = np.stack([x, y, rng.random((9, 8))], axis=-1) + rng.uniform(-0.2, 0.2, (9, 8, 3))
    arguments = {"degree": (degree, 6 - degree), "parametrization": parametrization}
    surface = neurbs.NurbsSurface.interpolate(grid, **arguments)  # type: ignore[arg-type]
    u, v = neurbs.NurbsSurface.grid_parameters(grid, **arguments)  # type: ignore[arg-type]
    np.testing.assert_allclose(surface.evaluate_grid(u, v), grid, rtol=0, atol=1e-12 * 12)


def scattered(rng: np.random.Generator, count: int) -> tuple[Array, Array]:
    """Make points over 3 × 1, and their parameters."""
    uv = rng.random((count, 2))
    heights = np.sin(4 * uv[:, 0]) * np.cos(3 * uv[:, 1])
    return uv, np.column_stack([3 * uv[:, 0], uv[:, 1], heights])


@pytest.mark.parametrize("shape", [(4, 4), (6, 9), (12, 12)])
def test_a_surface_of_the_same_net_is_recovered(
    shape: tuple[int, int], rng: np.random.Generator
) -> None:
    truth = neurbs.NurbsSurface(rng.standard_normal((*shape, 3)))
    uv, others = rng.random((2, 3000, 2))
    found = neurbs.NurbsSurface.fit(truth.evaluate(uv), uv, net=shape, fairness=0)
    points = truth.evaluate(others)
    assert np.abs(found.evaluate(others) - points).max() < 1e-9 * np.linalg.norm(
        np.ptp(points, axis=0)
    )


def test_a_weight_counts_as_so_many_points(rng: np.random.Generator) -> None:
    uv, points = scattered(rng, 300)
    times = rng.integers(0, 4, 300)
    weighted = neurbs.NurbsSurface.fit(
        points, uv, net=(6, 5), weights=times.astype(float), fairness=0
    )
    repeated = neurbs.NurbsSurface.fit(
        np.repeat(points, times, axis=0), np.repeat(uv, times, axis=0), net=(6, 5), fairness=0
    )
    np.testing.assert_allclose(weighted.control_points, repeated.control_points, atol=1e-11)


def test_large_fairness_gives_a_surface_without_bending(rng: np.random.Generator) -> None:
    # A surface without thin-plate energy is linear in u and v; the limit is its least-squares fit.
    uv, points = scattered(rng, 400)
    weights = rng.uniform(0.1, 2, 400)
    surface = neurbs.NurbsSurface.fit(points, uv, net=(8, 7), weights=weights, fairness=1e8)
    linear = np.column_stack([np.ones(400), uv])
    root = np.sqrt(weights)[:, None]
    plane = np.linalg.lstsq(linear * root, points * root, rcond=None)[0]
    np.testing.assert_allclose(surface.evaluate(uv), linear @ plane, rtol=0, atol=1e-5)


def test_fairness_trades_distance_for_bending(rng: np.random.Generator) -> None:
    uv, points = scattered(rng, 600)
    points[:, 2] += rng.normal(0, 0.05, 600)
    t = np.linspace(0, 1, 60)
    grid = np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1).reshape(-1, 2)
    distances, bends = [], []
    for fairness in [0, 1e-6, 1e-4, 1e-2, 1]:
        surface = neurbs.NurbsSurface.fit(points, uv, net=(12, 12), fairness=fairness)
        distances.append(np.linalg.norm(surface.evaluate(uv) - points))
        second = surface.derivatives(grid, 2)
        # The domain is three times as long in u as in v.
        by_uu, by_uv, by_vv = second[:, 2, 0] / 9, second[:, 1, 1] / 3, second[:, 0, 2]
        bends.append(float((by_uu**2 + 2 * by_uv**2 + by_vv**2).mean()))
    assert (np.diff(distances) > 0).all()
    assert (np.diff(bends) < 0).all()


def test_fairness_fills_holes(rng: np.random.Generator) -> None:
    uv, points = scattered(rng, 4000)
    hole = (np.abs(uv - [0.6, 0.5]) < 0.15).all(axis=1)
    with pytest.raises(neurbs.NeurbsError, match="raise fairness"):
        neurbs.NurbsSurface.fit(points[~hole], uv[~hole], net=(30, 30), fairness=0)
    surface = neurbs.NurbsSurface.fit(points[~hole], uv[~hole], net=(30, 30))
    assert np.abs(surface.evaluate(uv[~hole]) - points[~hole]).max() < 1e-3
    # Inside the hole the surface is flat, within the heights of the border.
    assert np.abs(surface.evaluate(uv[hole]) - points[hole]).max() < 0.1
    flat = points * [1, 1, 0] + uv[:, :1] * [0, 0, 2]
    plane = neurbs.NurbsSurface.fit(flat[~hole], uv[~hole], net=(30, 30))
    np.testing.assert_allclose(plane.evaluate(uv), flat, rtol=0, atol=1e-9)


def test_a_closed_fit_has_no_seam(rng: np.random.Generator) -> None:
    uv = rng.random((3000, 2))
    turn = 2 * np.pi * uv[:, 0]
    points = np.column_stack([np.cos(turn), np.sin(turn), uv[:, 1]])
    tube = neurbs.NurbsSurface.fit(points, uv, net=(9, 5), closed=(True, False))
    assert tube.closed == (True, False)
    v = np.linspace(0, 1, 20)
    start, end = (tube.derivatives(np.column_stack([np.full(20, u), v]), 2) for u in tube.domain[0])
    # Of degree 3, the surface has two continuous derivatives.
    np.testing.assert_allclose(start, end, rtol=0, atol=1e-10 * np.abs(start).max())
    assert np.abs(np.hypot(*tube.evaluate(uv)[:, :2].T) - 1).max() < 1e-2


def run(code: str, **environment: str) -> bytes:
    command = [sys.executable, "-c", code]
    return subprocess.run(
        command, env={**os.environ, **environment}, check=True, capture_output=True
    ).stdout


def test_threads_do_not_change_a_bit() -> None:
    code = """if True:
        import sys, numpy as np, neurbs
        rng = np.random.default_rng(0)
        uv, points = rng.random((20000, 2)), rng.random((20000, 3))
        grid = rng.random((60, 50, 3)) + np.mgrid[0:60, 0:50, 0:1].transpose(1, 2, 0, 3)[..., 0, :]
        fitted = neurbs.NurbsSurface.fit(points, uv, net=(15, 14), weights=rng.random(20000))
        closed = neurbs.NurbsSurface.fit(points, uv, net=(15, 14), closed=True)
        met = neurbs.NurbsSurface.interpolate(grid)
        area = np.array([met.area(accuracy=1e-3)])
        projections = fitted.closest_points(points[:2000])
        for array in [*(s.control_points for s in (fitted, closed, met)), area, projections.uv]:
            sys.stdout.buffer.write(array.tobytes())
    """
    one, two, seven = (run(code, RAYON_NUM_THREADS=threads) for threads in "127")
    assert len(one) > 50_000
    assert one == two == seven


@pytest.mark.skipif(
    sys.platform == "win32", reason="peak memory is measured with the module resource"
)
def test_memory_of_a_fit_grows_little_with_the_points() -> None:
    code = """if True:
        import resource, numpy as np, neurbs
        n = 2_000_000
        rng = np.random.default_rng(0)
        uv, points = rng.random((n, 2)), rng.random((n, 3))
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        neurbs.NurbsSurface.fit(points, uv, net=(20, 20))
        print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
    """
    unit = 1 if sys.platform == "darwin" else 1024
    grown = int(run(code)) * unit
    # A dense row of 400 numbers for each point would take 3,200 bytes.
    assert grown < 200 * 2_000_000
