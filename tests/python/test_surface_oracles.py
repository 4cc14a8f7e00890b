"""The kernel beside SciPy, geomdl and OpenCASCADE, on random surfaces."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_interp_spline, make_lsq_spline

import neurbs

Array = NDArray[np.float64]

# Share of the size by which two exact evaluations may differ.
EXACT = 1e-12


def random_surface(degree: tuple[int, int], seed: int) -> neurbs.NurbsSurface:
    """Make a surface with repeated inner knots and weights from 0.1 to 10."""
    rng = np.random.default_rng(seed)

    def knots(degree: int) -> Array:
        inner = np.repeat([0.2, 0.5, 0.65], [1, degree, max(1, degree - 1)])
        return np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])

    u, v = knots(degree[0]), knots(degree[1])
    shape = (len(u) - degree[0] - 1, len(v) - degree[1] - 1)
    net = rng.uniform(-1, 1, (*shape, 3))
    return neurbs.NurbsSurface(net, 10 ** rng.uniform(-1, 1, shape), degree, (u, v))


DEGREES = [(p, q) for p in range(1, 6) for q in range(1, 6)]


def scipy_homogeneous(surface: neurbs.NurbsSurface, u: Array, v: Array, du: int, dv: int) -> Array:
    assert surface.weights is not None
    lifted = [surface.control_points * surface.weights[..., None], surface.weights[..., None]]
    (p, q), (knots_u, knots_v) = surface.degree, surface.knots
    rows = BSpline(knots_u, np.concatenate(lifted, axis=-1), p)(u, du)
    return np.asarray(BSpline(knots_v, rows.transpose(1, 0, 2), q)(v, dv).transpose(1, 0, 2))


@pytest.mark.parametrize("degree", DEGREES)
def test_points_and_tangents_are_those_of_scipy(degree: tuple[int, int]) -> None:
    surface = random_surface(degree, 1)
    t = np.linspace(0, 1, 41)
    size = float(np.linalg.norm(np.ptp(surface.control_points.reshape(-1, 3), axis=0)))
    h = scipy_homogeneous(surface, t, t, 0, 0)
    points = h[..., :3] / h[..., 3:]
    uv = np.column_stack([x.ravel() for x in np.meshgrid(t, t, indexing="ij")])
    np.testing.assert_allclose(surface.evaluate_grid(t, t), points, rtol=0, atol=EXACT * size)
    np.testing.assert_allclose(
        surface.evaluate(uv), points.reshape(-1, 3), rtol=0, atol=EXACT * size
    )
    derivatives = surface.derivatives(uv, 1).reshape(41, 41, 2, 2, 3)
    for du, dv in [(1, 0), (0, 1)]:
        d = scipy_homogeneous(surface, t, t, du, dv)
        exact = (d[..., :3] - points * d[..., 3:]) / h[..., 3:]
        scale = np.abs(exact).max()
        np.testing.assert_allclose(derivatives[..., du, dv, :], exact, rtol=0, atol=EXACT * scale)


@pytest.mark.parametrize("degree", [(1, 3), (2, 2), (3, 3), (5, 4)])
def test_derivatives_of_second_order_are_those_of_geomdl(degree: tuple[int, int]) -> None:
    nurbs = pytest.importorskip("geomdl.NURBS")
    surface = random_surface(degree, 2)
    assert surface.weights is not None
    other = nurbs.Surface()
    other.degree_u, other.degree_v = degree
    lifted = np.dstack([surface.control_points * surface.weights[..., None], surface.weights])
    other.set_ctrlpts(lifted.reshape(-1, 4).tolist(), *lifted.shape[:2])
    other.knotvector_u, other.knotvector_v = (knots.tolist() for knots in surface.knots)
    for u, v in np.random.default_rng(0).random((10, 2)):
        ours, theirs = surface.derivatives([[u, v]], 2)[0], other.derivatives(u, v, 2)
        for i, j in [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (0, 2)]:
            scale = max(1.0, np.abs(theirs[i][j]).max())
            np.testing.assert_allclose(ours[i, j], theirs[i][j], rtol=0, atol=EXACT * scale)


@pytest.mark.parametrize("degree", [(2, 3), (3, 3), (4, 5)])
def test_curvatures_are_those_of_opencascade(degree: tuple[int, int]) -> None:
    pytest.importorskip("OCP")
    from OCP.GeomLProp import GeomLProp_SLProps

    surface = random_surface(degree, 3)
    other = neurbs.to_opencascade(surface)
    uv = np.random.default_rng(0).random((50, 2))
    ours = surface.curvatures(uv)
    size = float(np.linalg.norm(np.ptp(surface.control_points.reshape(-1, 3), axis=0)))
    for i, (u, v) in enumerate(uv):
        theirs = GeomLProp_SLProps(other, u, v, 2, 1e-9)
        assert theirs.IsNormalDefined()
        assert theirs.IsCurvatureDefined()
        point, normal = theirs.Value(), theirs.Normal()
        np.testing.assert_allclose(ours.points[i], point.Coord(), rtol=0, atol=EXACT * size)
        np.testing.assert_allclose(ours.normals[i], normal.Coord(), rtol=0, atol=1e-10)
        np.testing.assert_allclose(ours.gaussian[i], theirs.GaussianCurvature(), rtol=1e-8)
        np.testing.assert_allclose(
            sorted(ours.principal[i]),
            sorted([theirs.MinCurvature(), theirs.MaxCurvature()]),
            rtol=1e-8,
            atol=1e-8 * np.abs(ours.principal[i]).max(),
        )


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
    np.testing.assert_allclose(surface.evaluate_grid(u, v), grid, rtol=0, atol=EXACT * 40)


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


def folded() -> neurbs.NurbsSurface:
    """Make a sheet that folds over and comes near itself."""
    s = np.linspace(0, 1, 12)
    turn = 4.5 * s
    x, z = (1 + 0.3 * s) * np.cos(turn), (1 + 0.3 * s) * np.sin(turn)
    y = np.linspace(0, 2, 6)
    net = np.stack(
        [
            np.repeat(x[:, None], 6, 1),
            np.repeat(y[None], 12, 0),
            np.repeat(z[:, None], 6, 1) + 0.1 * np.sin(3 * y),
        ],
        axis=-1,
    )
    return neurbs.NurbsSurface(net, np.random.default_rng(5).uniform(0.5, 2, (12, 6)))


@pytest.mark.parametrize(
    "surface",
    [
        folded(),
        neurbs.NurbsSurface.torus([0, 0, 0], 1, 0.4),
        neurbs.NurbsSurface.sphere([0.1, 0, 0], 1),
        neurbs.NurbsSurface.cone([0, 0, -1], [0, 0, 2], 1),
        random_surface((3, 2), 4),
        random_surface((1, 1), 5),
    ],
    ids=["folded", "torus", "sphere", "cone", "rough", "facets"],
)
def test_no_sample_is_closer_than_the_closest_point(surface: neurbs.NurbsSurface) -> None:
    points = np.random.default_rng(1).uniform(-1.7, 1.7, (400, 3))
    feet = surface.closest_points(points)
    # Newton's method does not always come to its end in its number of steps; the distances, which
    # are compared above, are right all the same.
    assert feet.converged.mean() > 0.99
    np.testing.assert_allclose(surface.evaluate(feet.uv), feet.points, rtol=0, atol=1e-13)
    distances = np.linalg.norm(feet.points - points, axis=1)
    np.testing.assert_allclose(feet.distances, distances, rtol=0, atol=1e-14)
    t = np.linspace(0, 1, 500)
    samples = surface.evaluate_grid(t, t).reshape(-1, 3)
    from scipy.spatial import cKDTree

    sampled = cKDTree(samples).query(points)[0]
    assert (feet.distances <= sampled + 1e-12).all()


def test_closest_points_of_a_torus_are_exact() -> None:
    torus = neurbs.NurbsSurface.torus([0, 0, 0], 3, 1)
    points = np.random.default_rng(2).uniform(-5, 5, (2000, 3))
    ring = np.hypot(points[:, 0], points[:, 1])
    exact = np.abs(np.hypot(ring - 3, points[:, 2]) - 1)
    feet = torus.closest_points(points)
    np.testing.assert_allclose(feet.distances, exact, rtol=0, atol=1e-12)
    # The seams are no borders.
    beside = torus.closest_points([[4.5, 1e-9, 0.3], [4.5, -1e-9, 0.3]])
    np.testing.assert_allclose(beside.distances[0], beside.distances[1], rtol=0, atol=1e-9)
