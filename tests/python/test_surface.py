"""The surface, against SciPy and geomdl."""

import geomdl.NURBS
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from neurbs import NeurbsError, NurbsSurface

Array = NDArray[np.float64]


def knots(rng: np.random.Generator, degree: int, count: int) -> Array:
    """Make clamped knots on [-1, 2], some with the largest multiplicity."""
    inner = rng.choice(np.linspace(-0.9, 1.9, count), count - degree - 1)
    values, times = np.unique(inner, return_counts=True)
    inner = np.repeat(values, np.minimum(times, degree))
    free = np.setdiff1d(np.linspace(-0.95, 1.95, 2 * count), inner)
    missing = count - degree - 1 - len(inner)
    inner = np.sort(np.r_[inner, rng.choice(free, missing, replace=False)])
    return np.concatenate([np.full(degree + 1, -1.0), inner, np.full(degree + 1, 2.0)])


def random_surface(rng: np.random.Generator, degree: tuple[int, int]) -> NurbsSurface:
    shape = (degree[0] + 6, degree[1] + 4)
    net = rng.normal(size=(*shape, 3))
    vectors = (knots(rng, degree[0], shape[0]), knots(rng, degree[1], shape[1]))
    return NurbsSurface(net, rng.uniform(0.1, 10, shape), degree, vectors)


def homogeneous(s: NurbsSurface, uv: Array, order: tuple[int, int]) -> Array:
    """Differentiate the homogeneous surface at scattered parameters, with SciPy."""
    assert s.weights is not None
    net = np.concatenate([s.control_points * s.weights[..., None], s.weights[..., None]], axis=2)
    rows = [
        BSpline(k, np.eye(n), p)(t, nu=nu)
        for k, n, p, t, nu in zip(s.knots, net.shape[:2], s.degree, uv.T, order, strict=True)
    ]
    return np.asarray(np.einsum("ni,nj,ijc->nc", *rows, net))


@pytest.mark.parametrize(
    "degree", [(1, 1), (1, 4), (2, 3), (3, 3), (5, 2), (9, 6), (25, 11)], ids=str
)
def test_points_and_normals_agree_with_scipy(degree: tuple[int, int]) -> None:
    rng = np.random.default_rng(sum(degree))
    s = random_surface(rng, degree)
    uv = rng.uniform(-1, 2, (500, 2))
    value = homogeneous(s, uv, (0, 0))
    points = value[:, :3] / value[:, 3:]
    np.testing.assert_allclose(s.evaluate(uv), points, rtol=0, atol=1e-12)
    du, dv = (
        d[:, :3] - d[:, 3:] * points
        for d in (homogeneous(s, uv, (1, 0)), homogeneous(s, uv, (0, 1)))
    )
    normals = np.cross(du, dv)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    np.testing.assert_allclose(s.normals(uv), normals, rtol=0, atol=1e-8)
    grid = s.evaluate_grid(uv[:20, 0], uv[:30, 1])
    pairs = np.stack(np.meshgrid(uv[:20, 0], uv[:30, 1], indexing="ij"), axis=-1)
    scattered = s.evaluate(pairs.reshape(-1, 2)).reshape(20, 30, 3)
    np.testing.assert_allclose(grid, scattered, rtol=0, atol=1e-12)


def test_points_agree_with_geomdl() -> None:
    rng = np.random.default_rng(0)
    net, weights = rng.normal(size=(6, 5, 3)), rng.uniform(0.1, 10, (6, 5))
    ours = NurbsSurface(net, weights, (3, 2))
    theirs = geomdl.NURBS.Surface(normalize_kv=False)
    theirs.degree_u, theirs.degree_v = ours.degree
    weighted = np.concatenate([net * weights[..., None], weights[..., None]], axis=2)
    theirs.set_ctrlpts(weighted.reshape(-1, 4).tolist(), 6, 5)
    theirs.knotvector_u, theirs.knotvector_v = (k.tolist() for k in ours.knots)
    uv = rng.random((100, 2))
    expected = np.array(theirs.evaluate_list(uv.tolist()))
    np.testing.assert_allclose(ours.evaluate(uv), expected, rtol=0, atol=1e-12)


def test_properties_give_back_what_was_given() -> None:
    s = random_surface(np.random.default_rng(3), (2, 4))
    assert s.degree == (2, 4)
    assert s.domain == ((-1, 2), (-1, 2))
    again = NurbsSurface(s.control_points, s.weights, s.degree, s.knots)
    np.testing.assert_array_equal(again.control_points, s.control_points)
    for a, b in zip(again.knots, s.knots, strict=True):
        np.testing.assert_array_equal(a, b)
    assert repr(s) == (
        "NurbsSurface(net 8 × 8, degree (2, 4), domain [-1, 2] × [-1, 2], rational, open)"
    )
    assert again == s


NET = np.random.default_rng(0).random((4, 5, 3))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"control_points": NET[0]}, "control_points must be real numbers of shape"),
        ({"control_points": NET * np.nan}, "control point .0, 0. is"),
        ({"weights": np.ones((5, 4))}, r"weights must be .*shape \(4, 5\).*got shape \(5, 4\)"),
        ({"weights": np.zeros((4, 5))}, "positive"),
        ({"degree": 0}, "degree must be between 1 and 25, got 0"),
        ({"degree": (3, 26)}, "degree must be between 1 and 25, got 26"),
        ({"degree": (4, 3)}, "number of control points must be more than the degree, 4, got 4"),
        ({"degree": "cubic"}, "degree must be an integer from 0 or two of them, got 'cubic'"),
        ({"degree": -3}, "degree must be an integer"),
        ({"knots": [0, 1]}, "knots in u must be real numbers of shape .n,., got shape"),
        ({"knots": 7}, "knots must be two sequences, for u and v, got 7"),
        ({"knots": (range(8), range(8))}, "20 control points were given with knots for 4 × 4"),
        ({"knots": (range(8)[::-1], range(9))}, "not decrease, but knot 1 is 6 after 7"),
    ],
    ids=str,
)
def test_wrong_parts_are_refused(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(NeurbsError, match=message):
        NurbsSurface(**({"control_points": NET} | arguments))  # type: ignore[arg-type]


def test_parameters_outside_the_domain_are_refused() -> None:
    s = NurbsSurface(NET)
    with pytest.raises(NeurbsError, match=r"u must be inside the domain \[0, 1\], got 1.5 at ind"):
        s.evaluate([[0.0, 0.0], [1.5, 0.0]])
    with pytest.raises(NeurbsError, match=r"v must be inside the domain .* got NaN at index 0"):
        s.evaluate_grid([0.5], [np.nan])


def test_meshes_are_made_to_measure() -> None:
    mesh = NurbsSurface(NET).tessellate(shape=(4, 6))
    assert mesh.shape == (4, 6)
    assert mesh.vertices.shape == mesh.normals.shape == (24, 3)
    assert mesh.uv.shape == (24, 2)
    assert mesh.triangles.shape == (30, 3)
    assert mesh.triangles.dtype == np.uint32
    np.testing.assert_allclose(mesh.vertices, NurbsSurface(NET).evaluate(mesh.uv), atol=1e-15)
    a, b, c = (mesh.vertices[corner] for corner in mesh.triangles.T)
    assert len(np.unique(np.sort(mesh.triangles, axis=1), axis=0)) == 30
    assert (np.linalg.norm(np.cross(b - a, c - a), axis=1) > 0).all()


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        ((1, 5), r"shape must be .n_u, n_v. of at least 2 each"),
        ((10**5, 10**5), "at most 100000000 triangles"),
        ((-1, 5), "shape must be two integers from 0"),
        (5, "shape must be two integers from 0, got 5"),
        ((2.5, 3), "shape must be two integers from 0"),
    ],
    ids=str,
)
def test_impossible_meshes_are_refused(shape: object, message: str) -> None:
    with pytest.raises(NeurbsError, match=message):
        NurbsSurface(NET).tessellate(shape=shape)  # type: ignore[arg-type]
