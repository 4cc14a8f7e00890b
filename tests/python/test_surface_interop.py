"""Surfaces of other libraries, there and back; and surfaces as plain data."""

import copy
import json
import pickle

import numpy as np
import pytest

import neurbs


def rational(rng: np.random.Generator) -> neurbs.NurbsSurface:
    knots = ([0, 0, 0, 0.4, 0.4, 1, 1, 1], [-1, -1, -1, -1, 0.5, 2, 2, 2, 2])
    net, weights = rng.normal(size=(5, 5, 3)), rng.uniform(0.1, 10, (5, 5))
    return neurbs.NurbsSurface(net, weights, (2, 3), knots)


def polynomial(rng: np.random.Generator) -> neurbs.NurbsSurface:
    return neurbs.NurbsSurface(rng.normal(size=(4, 6, 3)), degree=(1, 3))


@pytest.mark.parametrize("library", ["geomdl", "splipy", "opencascade"])
@pytest.mark.parametrize("make", [rational, polynomial])
def test_surfaces_come_back_as_they_went(library: str, make, rng: np.random.Generator) -> None:  # type: ignore[no-untyped-def]
    surface = make(rng)
    other = getattr(neurbs, f"to_{library}")(surface)
    again = getattr(neurbs, f"from_{library}")(other)
    assert again.degree == surface.degree
    np.testing.assert_allclose(again.control_points, surface.control_points, atol=1e-14)
    assert (again.weights is None) == (surface.weights is None)
    for a, b in zip(again.knots, surface.knots, strict=True):
        np.testing.assert_array_equal(a, b)
    u, v = 0.3, 0.7
    point = {
        "geomdl": lambda: other.evaluate_single((u, v)),
        "splipy": lambda: other(u, v),
        "opencascade": lambda: other.Value(u, v).Coord(),
    }[library]()
    np.testing.assert_allclose(point, surface.evaluate([[u, v]])[0], atol=1e-13)


def test_plain_data_pickle_and_copies_are_equal(rng: np.random.Generator) -> None:
    for surface in [rational(rng), polynomial(rng)]:
        through_json = json.loads(json.dumps(surface.to_dict()))
        assert neurbs.NurbsSurface.from_dict(through_json) == surface
        for again in [
            pickle.loads(pickle.dumps(surface)),
            copy.copy(surface),
            copy.deepcopy(surface),
        ]:
            assert again == surface
        assert surface != surface.reversed(u=True)
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
    feet = surface.closest_points(rng.random((4, 3)))
    assert surface.closest_points(rng.random((4, 3)), out=feet) is feet
    with pytest.raises(neurbs.NeurbsError, match="out must be"):
        surface.curvatures(uv[:3], out=bends)
    with pytest.raises(neurbs.NeurbsError, match="out must be"):
        surface.closest_points(rng.random((9, 3)), out=feet)


def test_outside_the_domain_raises_unless_asked_for() -> None:
    plane = neurbs.NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0])
    with pytest.raises(neurbs.NeurbsError, match=r"u must be inside the domain \[0, 1\], got 2"):
        plane.evaluate([[2, 0.5]])
    np.testing.assert_array_equal(plane.evaluate([[2, 0.5]], extrapolate=True), [[2, 0.5, 0]])
    with pytest.raises(neurbs.NeurbsError, match="finite"):
        plane.evaluate([[np.nan, 0.5]], extrapolate=True)
