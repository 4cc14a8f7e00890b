"""Surfaces of other libraries, round trips, and surfaces as dicts."""

import copy
import json
import pickle
import subprocess
import sys
from collections.abc import Callable

import numpy as np
import pytest

import neurbs

Maker = Callable[[np.random.Generator], neurbs.NurbsSurface]


def rational(rng: np.random.Generator) -> neurbs.NurbsSurface:
    knots = ([0, 0, 0, 0.4, 0.4, 1, 1, 1], [-1, -1, -1, -1, 0.5, 2, 2, 2, 2])
    net, weights = rng.normal(size=(5, 5, 3)), rng.uniform(0.1, 10, (5, 5))
    return neurbs.NurbsSurface(net, weights, (2, 3), knots)


def polynomial(rng: np.random.Generator) -> neurbs.NurbsSurface:
    return neurbs.NurbsSurface(rng.normal(size=(4, 6, 3)), degree=(1, 3))


def torus(rng: np.random.Generator) -> neurbs.NurbsSurface:
    return neurbs.NurbsSurface.torus(rng.random(3), 3, 1)


def tube(rng: np.random.Generator) -> neurbs.NurbsSurface:
    """Make a surface that is smoothly closed in u, with periodic knots."""
    net, weights = rng.normal(size=(7, 4, 3)), rng.uniform(0.1, 10, (7, 4))
    return neurbs.NurbsSurface(net, weights, (3, 2), closed=(True, False))


MAKERS = [rational, polynomial, torus, tube]
LIBRARIES = ["geomdl", "splipy", "opencascade"]


@pytest.mark.parametrize("library", LIBRARIES)
@pytest.mark.parametrize("make", MAKERS)
def test_surfaces_are_equal_after_a_round_trip(library: str, make: Maker) -> None:
    surface = make(np.random.default_rng(0))
    other = getattr(neurbs, f"to_{library}")(surface)
    again = getattr(neurbs, f"from_{library}")(other)
    # Splipy and OpenCASCADE need clamped knots.
    kept = surface if library == "geomdl" else surface.clamped()
    assert again.degree == surface.degree
    assert again.closed == surface.closed
    np.testing.assert_allclose(again.control_points, kept.control_points, atol=1e-14)
    assert (again.weights is None) == (surface.weights is None)
    for a, b in zip(again.knots, kept.knots, strict=True):
        np.testing.assert_array_equal(a, b)
    for u, v in [(0.0, 0.0), (0.3, 0.7), (1.0, 0.4), (0.5, 1.0)]:
        point = {
            "geomdl": lambda u=u, v=v: other.evaluate_single((u, v)),
            "splipy": lambda u=u, v=v: other(u, v),
            "opencascade": lambda u=u, v=v: other.Value(u, v).Coord(),
        }[library]()
        np.testing.assert_allclose(point, surface.evaluate([[u, v]])[0], atol=1e-13)


@pytest.mark.parametrize("kind", ["cylinder", "torus", "sphere", "disc"])
def test_periodic_surfaces_of_splipy_are_taken(kind: str) -> None:
    factory = pytest.importorskip("splipy.surface_factory")
    other = getattr(factory, kind)()
    surface = neurbs.from_splipy(other)
    assert surface.closed == tuple(other.periodic(axis) for axis in range(2))
    assert surface.domain == tuple(zip(other.start(), other.end(), strict=True))
    inside = [np.linspace(*domain, 20)[1:-1] for domain in surface.domain]
    expected = other(*inside)
    if other.dimension == 2:
        expected = np.pad(expected, [(0, 0), (0, 0), (0, 1)])
    np.testing.assert_allclose(surface.evaluate_grid(*inside), expected, atol=1e-14)


def test_smoothly_periodic_surfaces_of_splipy_are_taken(rng: np.random.Generator) -> None:
    splipy = pytest.importorskip("splipy")
    knots = neurbs.NurbsSurface(rng.random((7, 4, 3)), degree=(3, 1), closed=(True, False)).knots
    bases = [splipy.BSplineBasis(4, knots[0], periodic=2), splipy.BSplineBasis(2, knots[1])]
    other = splipy.Surface(*bases, rng.random((7, 4, 3)), raw=True)
    surface = neurbs.from_splipy(other)
    t = np.linspace(0, 0.99, 12)
    np.testing.assert_allclose(surface.evaluate_grid(t, t), other(t, t), atol=1e-14)
    start, end = surface.derivatives([[0, 0.3], [1, 0.3]], 2)
    np.testing.assert_allclose(start, end, atol=1e-11)


def test_periodic_surfaces_of_opencascade_are_taken(rng: np.random.Generator) -> None:
    pytest.importorskip("OCP.collections", reason="OpenCASCADE 8 needs Python 3.11")
    surface = torus(rng)
    other = neurbs.to_opencascade(surface)
    other.SetUPeriodic()
    other.SetVPeriodic()
    again = neurbs.from_opencascade(other)
    assert again.closed == (True, True)
    t = np.linspace(0, 1, 9)
    np.testing.assert_allclose(again.evaluate_grid(t, t), surface.evaluate_grid(t, t), atol=1e-13)


def test_other_libraries_are_imported_when_used() -> None:
    code = "import sys, neurbs; print([m for m in ('geomdl', 'splipy', 'OCP') if m in sys.modules])"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
    assert loaded.stdout.strip() == b"[]"


def test_plain_data_pickle_and_copies_are_equal(rng: np.random.Generator) -> None:
    for make in MAKERS:
        surface = make(rng)
        through_json = json.loads(json.dumps(surface.to_dict()))
        assert neurbs.NurbsSurface.from_dict(through_json) == surface
        for again in [
            pickle.loads(pickle.dumps(surface)),
            copy.copy(surface),
            copy.deepcopy(surface),
        ]:
            assert again == surface
            assert (again != surface) is False
        assert surface != surface.transposed()
        assert surface != "surface"
        curve = surface.isocurve(u=0.25)
        assert neurbs.NurbsCurve.from_dict(json.loads(json.dumps(curve.to_dict()))) == curve
        assert pickle.loads(pickle.dumps(curve)) == curve
    with pytest.raises(neurbs.NeurbsError, match="control_points"):
        neurbs.NurbsSurface.from_dict({})


def test_out_takes_results_and_refuses_what_does_not_fit(rng: np.random.Generator) -> None:
    surface = rational(rng)
    t = np.linspace(0, 1, 7)
    points, normals = np.empty((7, 7, 3)), np.empty((7, 7, 3))
    got = surface.normals_grid(t, t, out=(points, normals))
    assert got[0] is points
    assert got[1] is normals
    uv = rng.random((5, 2))
    bends = surface.curvatures(uv)
    assert surface.curvatures(uv[::-1], out=bends) is bends
    np.testing.assert_allclose(bends.gaussian, surface.curvatures(uv[::-1]).gaussian)
    projections = surface.closest_points(rng.random((4, 3)))
    assert surface.closest_points(rng.random((4, 3)), out=projections) is projections
    first, second = np.empty((5, 2, 2)), np.empty((5, 2, 2))
    forms = surface.fundamental_forms(uv, out=(first, second))
    assert forms[0] is first
    assert forms[1] is second
    low, high = np.empty(3), np.empty(3)
    assert surface.bounding_box(out=(low, high))[1] is high
    np.testing.assert_array_equal(low, surface.bounding_box()[0])
    grid = np.stack(np.meshgrid(np.arange(5.0), np.arange(6.0), [0.0], indexing="ij"), axis=-1)
    u, v = np.empty(5), np.empty(6)
    got = neurbs.NurbsSurface.grid_parameters(grid[:, :, 0], out=(u, v))
    assert got[0] is u
    assert got[1] is v
    np.testing.assert_allclose(u, np.linspace(0, 1, 5), rtol=0, atol=1e-15)
    with pytest.raises(neurbs.NeurbsError, match="out must be"):
        neurbs.NurbsSurface.grid_parameters(grid[:, :, 0], out=(v, u))
    with pytest.raises(neurbs.NeurbsError, match="out must be"):
        surface.curvatures(uv[:3], out=bends)
    with pytest.raises(neurbs.NeurbsError, match="out must be"):
        surface.closest_points(rng.random((9, 3)), out=projections)


def test_outside_the_domain_raises_without_extrapolate() -> None:
    plane = neurbs.NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0])
    with pytest.raises(neurbs.NeurbsError, match=r"u must be inside the domain \[0, 1\], got 2"):
        plane.evaluate([[2, 0.5]])
    np.testing.assert_array_equal(plane.evaluate([[2, 0.5]], extrapolate=True), [[2, 0.5, 0]])
    with pytest.raises(neurbs.NeurbsError, match="finite"):
        plane.evaluate([[np.nan, 0.5]], extrapolate=True)
