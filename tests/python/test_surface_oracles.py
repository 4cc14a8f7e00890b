"""Random surfaces, compared with SciPy, geomdl, OpenCASCADE and exact arithmetic."""

from collections.abc import Callable
from fractions import Fraction
from math import comb

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_interp_spline

import neurbs

Array = NDArray[np.float64]
Maker = Callable[[tuple[int, int], int], neurbs.NurbsSurface]
Table = dict[tuple[int, int], Array]

# Largest difference of two evaluations, relative to the size.
EXACT = 1e-12

LOW_DEGREES = [(p, q) for p in range(1, 6) for q in range(1, 6)]
HIGH_DEGREES = [(10, 10), (25, 3), (2, 17), (25, 25)]

every_degree = pytest.mark.parametrize("degree", LOW_DEGREES + HIGH_DEGREES, ids=str)


def size(surface: neurbs.NurbsSurface) -> float:
    return float(np.linalg.norm(np.ptp(surface.control_points.reshape(-1, 3), axis=0)))


def homogeneous(surface: neurbs.NurbsSurface) -> Array:
    assert surface.weights is not None
    weights = surface.weights[..., None]
    return np.concatenate([surface.control_points * weights, weights], axis=-1)


def quotients(table: Table) -> Table:
    """Return derivatives of the surface from those of its homogeneous form."""
    result: Table = {}
    for (k, m), value in sorted(table.items()):
        sums = value[..., :3]
        for i in range(k + 1):
            for j in range(m + 1):
                if i or j:
                    factor = comb(k, i) * comb(m, j) * table[i, j][..., 3:]
                    sums = sums - factor * result[k - i, m - j]
        result[k, m] = sums / table[0, 0][..., 3:]
    return result


def unit_normals(by_u: Array, by_v: Array) -> tuple[Array, Array]:
    """Return the cross product of the tangents, and the error of its direction."""
    cross = np.cross(by_u, by_v)
    length = np.linalg.norm(cross, axis=-1, keepdims=True)
    lengths = np.linalg.norm(by_u, axis=-1) * np.linalg.norm(by_v, axis=-1)
    return cross / length, lengths / length[..., 0]


def scipy_derivatives(surface: neurbs.NurbsSurface, u: Array, v: Array, order: int) -> Table:
    (p, q), (knots_u, knots_v) = surface.degree, surface.knots

    def value(du: int, dv: int) -> Array:
        rows = BSpline(knots_u, homogeneous(surface), p)(u, du)
        columns = BSpline(knots_v, rows.transpose(1, 0, 2), q)(v, dv)
        return np.asarray(columns.transpose(1, 0, 2))

    orders = [(i, j) for i in range(order + 1) for j in range(order + 1)]
    return quotients({(i, j): value(i, j) for i, j in orders})


@every_degree
def test_points_derivatives_and_normals_are_those_of_scipy(
    degree: tuple[int, int], random_surface: Maker
) -> None:
    surface = random_surface(degree, 1)
    t = np.linspace(0, 1, 41)
    uv = np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1).reshape(-1, 2)
    exact = scipy_derivatives(surface, t, t, 3)
    for ours in (surface.evaluate_grid(t, t), surface.evaluate(uv).reshape(41, 41, 3)):
        np.testing.assert_allclose(ours, exact[0, 0], rtol=0, atol=EXACT * size(surface))
    derivatives = surface.derivatives(uv, 3).reshape(41, 41, 4, 4, 3)
    for order, expected in exact.items():
        scale = np.abs(expected).max() + size(surface)
        ours = derivatives[(slice(None), slice(None), *order)]
        np.testing.assert_allclose(ours, expected, rtol=0, atol=EXACT * scale, err_msg=str(order))
    normals, doubt = unit_normals(exact[1, 0], exact[0, 1])
    on_grid, scattered = surface.normals_grid(t, t)[1], surface.normals(uv).reshape(41, 41, 3)
    for ours in (on_grid, scattered, surface.curvatures_grid(t, t).normals):
        assert (np.linalg.norm(ours - normals, axis=-1) <= EXACT * doubt).all()


@every_degree
def test_points_and_derivatives_are_those_of_geomdl(
    degree: tuple[int, int], random_surface: Maker
) -> None:
    pytest.importorskip("geomdl")
    surface = random_surface(degree, 2)
    other = neurbs.to_geomdl(surface)
    uv = np.random.default_rng(0).random((20, 2))
    ours = surface.derivatives(uv, 2)
    theirs = np.array([other.derivatives(u, v, 2) for u, v in uv.tolist()], dtype=object)
    for i, j in [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (0, 2)]:
        expected = np.array(theirs[:, i, j].tolist())
        scale = np.abs(expected).max() + size(surface)
        np.testing.assert_allclose(
            ours[:, i, j], expected, rtol=0, atol=EXACT * scale, err_msg=f"{i} {j}"
        )


# OpenCASCADE evaluates powers of the parameter, which lose digits at high degrees.
@pytest.mark.parametrize("degree", LOW_DEGREES, ids=str)
def test_points_normals_and_curvatures_are_those_of_opencascade(
    degree: tuple[int, int], random_surface: Maker
) -> None:
    pytest.importorskip("OCP.collections", reason="OpenCASCADE 8 needs Python 3.11")
    from OCP.GeomLProp import GeomLProp_SLProps

    surface = random_surface(degree, 3)
    other = neurbs.to_opencascade(surface)
    uv = np.random.default_rng(0).random((20, 2))
    derivatives, ours = surface.derivatives(uv, 2), surface.curvatures(uv)
    doubt = unit_normals(derivatives[:, 1, 0], derivatives[:, 0, 1])[1]
    for at, (u, v) in enumerate(uv.tolist()):
        theirs = GeomLProp_SLProps(other, u, v, 2, 1e-9)
        assert theirs.IsNormalDefined()
        assert theirs.IsCurvatureDefined()
        point, normal = theirs.Value().Coord(), theirs.Normal().Coord()
        np.testing.assert_allclose(ours.points[at], point, rtol=0, atol=EXACT * size(surface))
        for i, j in [(1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]:
            expected, scale = np.array(other.DN(u, v, i, j).Coord()), np.abs(derivatives[:, i, j])
            error = np.abs(derivatives[at, i, j] - expected).max()
            assert error <= EXACT * (scale.max() + size(surface)), (i, j)
        np.testing.assert_allclose(ours.normals[at], normal, rtol=0, atol=EXACT * doubt[at])
        # Errors are relative to the largest curvature of a point.
        bend = np.abs(ours.principal[at]).max()
        expected = np.array([theirs.MaxCurvature(), theirs.MinCurvature()])
        for got, wanted, scale in [
            (ours.gaussian[at], theirs.GaussianCurvature(), bend**2),
            (ours.mean[at], theirs.MeanCurvature(), bend),
            (np.sort(ours.principal[at]), np.sort(expected), bend),
        ]:
            np.testing.assert_allclose(got, wanted, rtol=0, atol=EXACT * doubt[at] ** 2 * scale)


def exact_basis(knots: Array, degree: int, u: float, order: int) -> list[list[Fraction]]:
    """Evaluate all basis functions and derivatives by definition, in exact arithmetic."""
    t, at = [Fraction(knot) for knot in knots.tolist()], Fraction(u)
    span = max(i for i in range(degree, len(t) - degree - 1) if t[i] <= at)

    def over(value: Fraction, low: int, high: int) -> Fraction:
        return value / (t[high] - t[low]) if t[high] > t[low] else Fraction(0)

    def step(row: list[Fraction], k: int, derivative: bool) -> list[Fraction]:
        rise = [k if derivative else at - t[i] for i in range(len(row) - 1)]
        fall = [-k if derivative else t[i + k + 1] - at for i in range(len(row) - 1)]
        return [
            over(rise[i] * row[i], i, i + k) + over(fall[i] * row[i + 1], i + 1, i + k + 1)
            for i in range(len(row) - 1)
        ]

    rows = []
    for derivative in range(order + 1):
        row = [Fraction(i == span) for i in range(len(t) - 1)]
        for k in range(1, degree + 1):
            row = step(row, k, k > degree - derivative)
        rows.append(row if derivative <= degree else [Fraction(0)] * len(row))
    return rows


def exact_derivatives(surface: neurbs.NurbsSurface, u: float, v: float) -> Table:
    """Return derivatives to the second order in exact fractions."""
    rows = exact_basis(surface.knots[0], surface.degree[0], u, 2)
    columns = exact_basis(surface.knots[1], surface.degree[1], v, 2)
    assert surface.weights is not None
    exactly = np.vectorize(Fraction, otypes=[object])
    weights = exactly(surface.weights)[..., None]
    net = np.concatenate([exactly(surface.control_points) * weights, weights], axis=-1)
    table = {}
    for i in range(3):
        for j in range(3 - i):
            row, column = np.array(rows[i], object), np.array(columns[j], object)
            table[i, j] = np.tensordot(column, np.tensordot(row, net, (0, 0)), (0, 0))
    return quotients(table)


@every_degree
def test_derivatives_and_curvatures_are_those_of_exact_arithmetic(
    degree: tuple[int, int], random_surface: Maker
) -> None:
    surface = random_surface(degree, 4)
    uv = np.random.default_rng(1).random((3, 2))
    ours, bends = surface.derivatives(uv, 2), surface.curvatures(uv)
    for at, (u, v) in enumerate(uv.tolist()):
        exact = exact_derivatives(surface, u, v)
        for order, value in exact.items():
            expected = value.astype(float)
            scale = np.linalg.norm(expected) + size(surface)
            assert np.linalg.norm(ours[(at, *order)] - expected) <= 1e-13 * scale, order
        by_u, by_v, cross = exact[1, 0], exact[0, 1], np.cross(exact[1, 0], exact[0, 1])
        e, f, g = by_u @ by_u, by_u @ by_v, by_v @ by_v
        second = (exact[2, 0] @ cross, exact[1, 1] @ cross, exact[0, 2] @ cross)
        det = e * g - f * f
        gaussian = float((second[0] * second[2] - second[1] ** 2) / det**2)
        mean = float(e * second[2] - 2 * f * second[1] + g * second[0]) / (2 * float(det) ** 1.5)
        bend = abs(mean) + abs(mean * mean - gaussian) ** 0.5
        doubt = float(e * g / det)
        assert abs(bends.gaussian[at] - gaussian) <= 1e-13 * doubt * bend**2
        assert abs(bends.mean[at] - mean) <= 1e-13 * doubt * bend


@pytest.mark.parametrize("degree", HIGH_DEGREES, ids=str)
def test_algebra_of_high_degrees_keeps_the_points_of_scipy(
    degree: tuple[int, int], random_surface: Maker
) -> None:
    surface = random_surface(degree, 6)
    t = np.linspace(0, 1, 31)
    raised = surface.elevate_degree(*(min(2, 25 - p) for p in degree))
    refined = surface.insert_knots(u=[0.123, 0.9], v=[0.777])
    for same in (raised, refined, refined.remove_knots([0.123], tolerance=1e-9)):
        np.testing.assert_allclose(
            same.evaluate_grid(t, t),
            scipy_derivatives(surface, t, t, 0)[0, 0],
            rtol=0,
            atol=EXACT * size(surface),
        )
    for patch in [patch for row in surface.bezier_patches() for patch in row]:
        u, v = (np.linspace(*domain, 7) for domain in patch.domain)
        # At a break SciPy evaluates the next patch, which meets this one.
        np.testing.assert_allclose(
            patch.evaluate_grid(u, v),
            scipy_derivatives(surface, u, v, 0)[0, 0],
            rtol=0,
            atol=EXACT * size(surface),
        )


@pytest.mark.parametrize("degree", [(10, 3), (17, 12), (25, 25)], ids=str)
def test_interpolation_of_high_degrees_is_that_of_scipy(degree: tuple[int, int]) -> None:
    x, y = np.meshgrid(np.linspace(0, 1, 40), np.linspace(0, 1, 30), indexing="ij")
    grid = np.stack([x, y, np.sin(5 * x) * np.cos(4 * y)], axis=-1)
    ours = neurbs.NurbsSurface.interpolate(grid, degree, parametrization="uniform")
    rows = make_interp_spline(x[:, 0], grid, degree[0], ours.knots[0])
    both = make_interp_spline(y[0], rows.c.transpose(1, 0, 2), degree[1], ours.knots[1])
    theirs = neurbs.NurbsSurface(both.c.transpose(1, 0, 2), None, degree, ours.knots)
    at_points = ours.evaluate_grid(x[:, 0], y[0]) - grid
    np.testing.assert_allclose(at_points, 0, rtol=0, atol=1e-11)
    # x = u and y = v: between the points, the condition of the system loses digits for both.
    t = np.linspace(0, 1, 101)
    uv = np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1)
    lost, also_lost = (np.abs(s.evaluate_grid(t, t)[..., :2] - uv).max() for s in (ours, theirs))
    assert lost <= 4 * also_lost
    assert also_lost < 1e-3


@pytest.mark.parametrize("degree", [(1, 1), (1, 4), (2, 3), (5, 2), (9, 6), (12, 25)], ids=str)
def test_unclamped_surfaces_are_those_of_scipy(degree: tuple[int, int]) -> None:
    rng = np.random.default_rng(5)
    vectors = [np.cumsum(rng.uniform(0.1, 1, 3 * p + 8)) - 2 for p in degree]
    shape = tuple(len(k) - p - 1 for k, p in zip(vectors, degree, strict=True))
    net, weights = rng.normal(size=(*shape, 3)), 10 ** rng.uniform(-1, 1, shape)
    surface = neurbs.NurbsSurface(net, weights, degree, (vectors[0], vectors[1]))
    u, v = (np.linspace(*domain, 30) for domain in surface.domain)
    expected = scipy_derivatives(surface, u, v, 0)[0, 0]
    for same in (surface, surface.clamped()):
        np.testing.assert_allclose(
            same.evaluate_grid(u, v), expected, rtol=0, atol=EXACT * size(surface)
        )
