"""The equivalents that docs/migrating.md lists give what the other libraries give."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import RBFInterpolator, RectBivariateSpline, splev, splprep

import neurbs
from neurbs import NurbsCurve, NurbsSurface

PAGE = (Path(__file__).parents[2] / "docs" / "migrating.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("example", re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL))
def test_each_example_runs_alone(example: str) -> None:
    for library in ("geomdl", "scipy"):
        if library in example:
            pytest.importorskip(library)
    exec(example, {})


def section(title: str) -> str:
    return PAGE.split(f"## From {title}\n")[1].split("\n## ")[0]


def names(text: str, column: int) -> set[str]:
    """Return the names of methods in a column of the tables."""
    rows = [line.split(" | ") for line in text.splitlines() if line.startswith("| `")]
    calls = [call for row in rows for call in re.findall(r"`([^`]+)`", row[column])]
    return {name for call in calls for name in re.findall(r"\.(\w+)\(", call)}


def test_the_methods_of_neurbs_exist() -> None:
    owners = (
        neurbs,
        NurbsSurface,
        NurbsCurve,
        neurbs.TriangleMesh,
        neurbs.Shell,
        neurbs.Reconstruction,
        np,
    )
    found = names(PAGE, 1)
    assert {"z", "tangents", "reduce_degree", "tessellate"} <= found
    assert not {name for name in found if not any(hasattr(owner, name) for owner in owners)}


def test_the_methods_of_splipy_exist() -> None:
    splipy, files = pytest.importorskip("splipy"), pytest.importorskip("splipy.io")
    from splipy import curve_factory, surface_factory

    modules = (splipy, files, curve_factory, surface_factory)
    owners = (*modules, splipy.Surface, splipy.Curve, files.STL)
    found = names(section("Splipy"), 0)
    assert {"tangent", "curvature", "raise_order"} <= found
    assert not {name for name in found if not any(hasattr(owner, name) for owner in owners)}


def test_evaluation_is_that_of_splipy(rng: np.random.Generator) -> None:
    pytest.importorskip("splipy")
    surface = NurbsSurface(rng.random((6, 5, 3)), rng.uniform(0.5, 2, (6, 5)))
    other = neurbs.to_splipy(surface)
    u, v = rng.random(4), rng.random(7)
    np.testing.assert_allclose(surface.evaluate_grid(u, v), other(u, v), atol=1e-13)
    np.testing.assert_allclose(surface(u, v[:4]), other(u, v[:4], tensor=False), atol=1e-13)
    derivative = surface.derivatives(np.column_stack([u, v[:4]]), 1)[:, 1, 0]
    theirs = other.derivative(u, v[:4], d=(1, 0), tensor=False)
    np.testing.assert_allclose(derivative, theirs, atol=1e-11)
    edge, curve = other.const_par_curve(0.3, "u"), surface.isocurve(u=0.3)
    np.testing.assert_allclose(curve(v), edge(v), atol=1e-13)
    np.testing.assert_allclose(curve.tangents(v), edge.tangent(v), atol=1e-12)
    np.testing.assert_allclose(curve.curvatures(v), edge.curvature(v), rtol=1e-8)
    # Splipy takes the box of the points multiplied by their weights: here without weights.
    plain = NurbsSurface(surface.control_points)
    low, high = plain.bounding_box(tight=False)
    theirs = neurbs.to_splipy(plain).bounding_box()
    np.testing.assert_allclose(np.transpose([low, high]), theirs, atol=1e-13)


def test_evaluation_is_that_of_geomdl(rng: np.random.Generator) -> None:
    operations = pytest.importorskip("geomdl.operations")
    surface = NurbsSurface(rng.random((6, 5, 3)), rng.uniform(0.5, 2, (6, 5)))
    other = neurbs.to_geomdl(surface)
    np.testing.assert_allclose(surface(0.3, 0.6), other.evaluate_single((0.3, 0.6)), atol=1e-13)
    np.testing.assert_allclose(surface.bounding_box(tight=False), other.bbox, atol=1e-13)
    _, normal = operations.normal(other, (0.3, 0.6))
    np.testing.assert_allclose(surface.normals([0.3, 0.6]), normal, atol=1e-12)


def test_curves_and_heights_are_those_of_scipy(rng: np.random.Generator) -> None:
    points = rng.random((9, 3))
    tck, _ = splprep(points.T, s=0)
    curve = NurbsCurve.interpolate(points)
    t = np.linspace(0, 1, 50)
    # SciPy leaves out the second and the last but one knot, neurbs averages: near each other.
    np.testing.assert_allclose(curve(t), np.transpose(splev(t, tck)), atol=0.2)
    np.testing.assert_allclose(curve([0, 1]), points[[0, -1]], atol=1e-12)

    x, y = np.linspace(0, 2, 12), np.linspace(0, 1, 9)
    z = np.sin(x[:, None]) * np.cos(3 * y)
    spline = RectBivariateSpline(x, y, z)
    grid = np.dstack([*np.meshgrid(x, y, indexing="ij"), z])
    surface = NurbsSurface.interpolate(grid, parametrization="uniform")
    places = rng.random((2, 200)) * [[2], [1]]
    np.testing.assert_allclose(surface.z(*places), spline.ev(*places), atol=5e-3)

    xy = rng.random((60, 2))
    height = np.sin(3 * xy[:, 0]) * np.cos(2 * xy[:, 1])
    fit = neurbs.fit_heights(np.column_stack([xy, height]), (20, 20), fairness=1e-9)
    np.testing.assert_allclose(fit.surface.z(*xy.T), height, atol=1e-8)
    inside = 0.15 + 0.7 * rng.random((200, 2))
    theirs = RBFInterpolator(xy, height)(inside)
    np.testing.assert_allclose(fit.surface.z(*inside.T), theirs, atol=0.05)
