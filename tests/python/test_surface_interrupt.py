"""Ctrl-C ends the long jobs of the kernel."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs

Array = NDArray[np.float64]
Answers = Callable[..., bool]

# Sides of nets and grids, with tens of thousands and with millions of control points.
SIDE = 300
LARGE = 1500


@pytest.fixture(scope="module")
def noisy() -> neurbs.NurbsSurface:
    rng = np.random.default_rng(1)
    u, v = np.meshgrid(np.linspace(0, 1, SIDE), np.linspace(0, 1, SIDE), indexing="ij")
    net = np.stack([u, v, 0.1 * rng.random((SIDE, SIDE))], axis=-1)
    return neurbs.NurbsSurface(net, rng.uniform(0.5, 2, (SIDE, SIDE)))


SPHERE = neurbs.NurbsSurface.sphere([0, 0, 0], 1)

JOBS: dict[str, Callable[[neurbs.NurbsSurface], object]] = {
    "insert_knots": lambda s: s.insert_knots(u=np.linspace(0.001, 0.999, 20_000)),
    "remove_knots": lambda s: s.remove_knots(tolerance=10.0),
    "elevate_degree": lambda s: s.elevate_degree(4, 4),
    "reduce_degree": lambda s: s.reduce_degree(2, 2, tolerance=1e3),
    "bounding_box": lambda s: s.bounding_box(),
    "area": lambda s: s.area(),
    "bezier_patches": lambda s: s.bezier_patches(),
    "closest_points": lambda s: s.closest_points(np.full((100_000, 3), 0.5)),
    "closest points near a focus": lambda s: SPHERE.closest_points(np.full((10_000, 3), 0.01)),
    "derivatives": lambda s: s.derivatives(np.full((20_000, 2), 0.5), order=12),
    "curvatures": lambda s: s.curvatures(np.full((1_000_000, 2), 0.5)),
    "curve": lambda s: s.isocurve(u=0.5).evaluate(np.full(2_000_000, 0.5)),
    "length": lambda s: s.isocurve(u=0.5).length(accuracy=1e-14),
    "curve knots": lambda s: s.isocurve(u=0.5).remove_knots(tolerance=10.0),
}


@pytest.mark.parametrize("name", JOBS)
def test_ctrl_c_ends_long_jobs(
    noisy: neurbs.NurbsSurface, name: str, answers_ctrl_c: Answers
) -> None:
    assert answers_ctrl_c(lambda: JOBS[name](noisy), 0.1)


@pytest.fixture(scope="module")
def grid() -> Array:
    x, y = np.mgrid[0:LARGE, 0:LARGE]
    return np.stack([x, y, np.random.default_rng(2).random((LARGE, LARGE))], axis=-1).astype(float)


@pytest.fixture(scope="module")
def large(grid: Array) -> neurbs.NurbsSurface:
    return neurbs.NurbsSurface(grid)


@pytest.fixture(scope="module")
def curves(grid: Array) -> list[neurbs.NurbsCurve]:
    return [neurbs.NurbsCurve(row) for row in grid[:300].reshape(3, -1, 3)]


MOMENTS = [0.05, 0.3, 0.8]

SURFACES = neurbs.NurbsSurface

FROM_GRIDS: dict[str, Callable[[Array], object]] = {
    "interpolate": SURFACES.interpolate,
    "interpolate, closed": lambda grid: SURFACES.interpolate(grid, 2, closed=True),
    "grid_parameters": SURFACES.grid_parameters,
    "approximate": lambda grid: SURFACES.approximate(grid, (300, 300)),
    "approximate, closed": lambda grid: SURFACES.approximate(grid, (300, 300), closed=True),
    "fit": lambda grid: SURFACES.fit(
        grid.reshape(-1, 3), grid.reshape(-1, 3)[:, :2] / (LARGE - 1), net=(40, 40)
    ),
}

OF_LARGE: dict[str, Callable[[neurbs.NurbsSurface], object]] = {
    "split": lambda s: s.split(u=0.3),
    "split across": lambda s: s.split(v=0.3),
    "sub_surface": lambda s: s.sub_surface(u=(0.1, 0.8), v=(0.3, 0.9)),
    "joined": lambda s: s.joined(s.reversed(u=True), tolerance=1.0),
    "transposed": lambda s: s.transposed(),
    "insert_knots": lambda s: s.insert_knots(u=[0.12345]),
    "elevate_degree": lambda s: s.elevate_degree(1),
    "closest_points": lambda s: s.transposed().closest_points([[0, 0, 0]]),
}

FROM_CURVES: dict[str, Callable[[list[neurbs.NurbsCurve]], object]] = {
    "ruled": lambda curves: SURFACES.ruled(curves[0], curves[1]),
    "lofted": SURFACES.lofted,
    "revolved": lambda curves: SURFACES.revolved(curves[0], [0, 0, 0], [0, 0, 1]),
    "interpolated curve": lambda curves: neurbs.NurbsCurve.interpolate(curves[0].control_points),
    "split curve": lambda curves: curves[0].split(0.5),
    "joined curves": lambda curves: curves[0].joined(curves[0].reversed(), tolerance=1.0),
}


@pytest.mark.parametrize("moment", MOMENTS)
@pytest.mark.parametrize("name", FROM_GRIDS)
def test_ctrl_c_ends_what_starts_from_many_points(
    grid: Array, name: str, moment: float, answers_ctrl_c: Answers
) -> None:
    assert answers_ctrl_c(lambda: FROM_GRIDS[name](grid), moment)


@pytest.mark.parametrize("moment", MOMENTS)
@pytest.mark.parametrize("name", OF_LARGE)
def test_ctrl_c_ends_the_algebra_of_large_nets(
    large: neurbs.NurbsSurface, name: str, moment: float, answers_ctrl_c: Answers
) -> None:
    assert answers_ctrl_c(lambda: OF_LARGE[name](large), moment)


@pytest.mark.parametrize("moment", MOMENTS)
@pytest.mark.parametrize("name", FROM_CURVES)
def test_ctrl_c_ends_what_starts_from_long_curves(
    curves: list[neurbs.NurbsCurve], name: str, moment: float, answers_ctrl_c: Answers
) -> None:
    assert answers_ctrl_c(lambda: FROM_CURVES[name](curves), moment)
