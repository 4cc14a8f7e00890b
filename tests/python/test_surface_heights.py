"""The heights of a surface over x and y: closed forms, folds, borders, threads, terrain."""

import os
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import LinearNDInterpolator

import neurbs
from neurbs import NeurbsError, NurbsSurface

JACKSBORO = Path(__file__).parents[2] / "examples" / "jacksboro.xyz"


def hills(rng: np.random.Generator, origin: tuple[float, float, float] = (0, 0, 0)) -> NurbsSurface:
    """Make a height field over the unit square, moved to an origin."""
    x, y = rng.random((2, 4000))
    points = np.column_stack([x, y, np.sin(9 * x) * np.cos(7 * y)]) + origin
    return neurbs.fit_heights(points, (30, 25)).surface


def dome() -> NurbsSurface:
    return NurbsSurface.sphere([0, 0, 0], 2).sub_surface(v=(0.5, 1))


def test_heights_of_a_height_field_are_its_points(rng: np.random.Generator) -> None:
    surface = hills(rng)
    points = surface.evaluate(rng.random((20_000, 2)))
    x, y, z = points.T
    np.testing.assert_allclose(surface.z(x, y), z, atol=1e-13)


def test_rational_and_twisted_surfaces_have_exact_heights(rng: np.random.Generator) -> None:
    net = np.array(hills(rng).control_points)
    turned = net.copy()
    # A turn that grows with the radius bends the lines of constant u and v in the plane.
    angle = 0.8 * np.hypot(*(net[..., :2] - 0.5).T).T
    rows, cols = (net[..., :2] - 0.5).transpose(2, 0, 1)
    turned[..., 0] = np.cos(angle) * rows - np.sin(angle) * cols
    turned[..., 1] = np.sin(angle) * rows + np.cos(angle) * cols
    for control_points in (net, turned):
        surface = NurbsSurface(control_points, weights=rng.uniform(0.5, 2, net.shape[:2]))
        x, y, z = surface.evaluate(rng.random((20_000, 2))).T
        np.testing.assert_allclose(surface.z(x, y), z, atol=1e-12)


def test_a_dome_has_closed_heights_and_nan_outside(rng: np.random.Generator) -> None:
    x, y = rng.uniform(-2.1, 2.1, (2, 50_000))
    with np.errstate(invalid="ignore"):
        expected = np.sqrt(4 - x**2 - y**2)
    np.testing.assert_allclose(dome().z(x, y), expected, atol=1e-9)


def test_borders_belong_to_the_surface(rng: np.random.Generator) -> None:
    t = np.linspace(0, 1, 301)
    sides = [(0 * t, t), (0 * t + 1, t), (t, 0 * t), (t, 0 * t + 1)]
    for surface in (hills(rng), hills(rng, (500_000, 5_000_000, 100))):
        for u, v in sides:
            x, y, z = surface(u, v).T
            np.testing.assert_allclose(surface.z(x, y), z, atol=1e-8)
    # The border of a dome is vertical.
    angle = 2 * np.pi * t
    rim = dome().z(2 * np.cos(angle), 2 * np.sin(angle))
    np.testing.assert_allclose(rim, 0, atol=1e-6)
    assert dome().z(0, 0) == pytest.approx(2, abs=1e-14)


def test_large_coordinates_keep_the_precision(rng: np.random.Generator) -> None:
    origin = (500_000, 5_000_000, 100)
    near = hills(np.random.default_rng(1))
    moved = near.transformed(np.vstack([np.column_stack([np.eye(3), origin]), [0, 0, 0, 1]]))
    # Multiples of 1/1024 are exact in both places.
    x, y = rng.integers(0, 1025, (2, 10_000)) / 1024
    far = moved.z(x + origin[0], y + origin[1])
    # Slopes are at most 10; coordinates of the control points are rounded to 1e-9.
    np.testing.assert_allclose(far - origin[2], near.z(x, y), atol=1e-8)


@pytest.mark.parametrize(
    ("make", "places"),
    [
        (lambda: NurbsSurface.sphere([0, 0, 0], 2), [(0, 0), (1, 1), (3, 0)]),
        (lambda: NurbsSurface.torus([0, 0, 0], 3, 1), [(3, 0), (0, 0), (2.5, 1)]),
        (lambda: NurbsSurface.cylinder([0, 0, 0], [0, 0, 1], 1), [(1, 0), (0.6, 0.8), (0, 0)]),
    ],
    ids=["sphere", "torus", "wall"],
)
def test_several_heights_are_nan(
    make: Callable[[], NurbsSurface], places: list[tuple[float, float]]
) -> None:
    x, y = np.transpose(places)
    assert np.isnan(make().z(x, y)).all()


def test_a_fold_is_nan_and_the_rest_is_not() -> None:
    # In x it goes to 1, back to 0.5 and on; z rises.
    x, z = np.array([0, 1.6, -0.2, 1.5]), np.array([0, 1, 2, 3])
    net = np.stack([[[x[i], y, z[i]] for y in (0, 1)] for i in range(4)])
    surface = NurbsSurface(net, degree=(3, 1))
    t = np.linspace(0, 1, 2001)
    along = surface(t, 0.5)
    places = np.linspace(0.01, 1.49, 400)
    crossings = np.sum(np.diff(np.sign(along[:, 0, None] - places), axis=0) != 0, axis=0)
    found = surface.z(places, 0.5)
    assert set(crossings) == {1, 3}
    np.testing.assert_array_equal(np.isnan(found), crossings > 1)
    only = crossings == 1
    expected = [along[np.argmin(abs(along[:, 0] - x)), 2] for x in places[only]]
    np.testing.assert_allclose(found[only], expected, atol=0.01)


def test_arguments_broadcast_and_numbers_give_floats(rng: np.random.Generator) -> None:
    surface = hills(rng)
    x, y = np.linspace(0.1, 0.9, 7), np.linspace(0.2, 0.8, 5)
    grid = surface.z(x[:, None], y)
    assert grid.shape == (7, 5)
    assert type(surface.z(0.1, 0.2)) is float
    assert surface.z(x[0], y[0]) == grid[0, 0]
    assert surface.z([0.1], 0.2).shape == (1,)
    assert surface.z([], []).shape == (0,)
    out = np.empty((7, 5))
    assert surface.z(x[:, None], y, out=out) is out
    np.testing.assert_array_equal(out, grid)
    single = np.empty(())
    assert surface.z(0.1, 0.2, out=single) is single
    np.testing.assert_array_equal(
        surface.z(np.array([0.5], np.float32), [1]), surface.z([0.5], [1.0])
    )
    assert np.isnan(surface.z([np.nan, np.inf, 0.5], [0.5, 0.5, -np.inf])).all()


def test_wrong_arguments_are_refused(rng: np.random.Generator) -> None:
    surface = hills(rng)
    with pytest.raises(NeurbsError, match=r"x and y must have shapes that broadcast, got \(3,\)"):
        surface.z([1, 2, 3], [1, 2])
    with pytest.raises(NeurbsError, match="x must be real numbers, got dtype complex"):
        surface.z([1j], [1])
    with pytest.raises(NeurbsError, match="y must be real numbers, got a masked array"):
        surface.z([1], np.ma.masked_array([1], [True]))
    with pytest.raises(NeurbsError, match=r"out must be .* of shape \[2\]"):
        surface.z([0, 1], 0, out=np.empty(3))


def test_results_have_the_same_bits_on_any_number_of_threads(rng: np.random.Generator) -> None:
    surface, (x, y) = dome(), rng.uniform(-2, 2, (2, 30_000))
    before, found = neurbs.num_threads(), []
    for threads in (1, 2, 7):
        neurbs.set_num_threads(threads)
        found.append(surface.z(x, y).tobytes())
    neurbs.set_num_threads(before)
    assert found[0] == found[1] == found[2]


def test_ctrl_c_stops_it(answers_ctrl_c: Callable[..., bool], rng: np.random.Generator) -> None:
    surface, (x, y) = dome(), rng.uniform(-2, 2, (2, 2_000_000))
    assert answers_ctrl_c(lambda: surface.z(x, y))


def test_a_million_heights_take_half_a_second_of_two_processors(
    rng: np.random.Generator,
) -> None:
    surface = hills(rng)
    x, y = rng.random((2, 1_000_000))
    surface.z(x[:1000], y[:1000])
    # Other work on the machine makes caches cold: the best of three.
    seconds = []
    for _ in range(3):
        start = time.process_time()
        surface.z(x, y)
        seconds.append(time.process_time() - start)
    assert min(seconds) / 2 < 0.5


def test_a_result_has_the_heights_of_its_surface() -> None:
    points = neurbs.read_points(JACKSBORO)
    result = neurbs.reconstruct(points, kind="height", grid=(30, 30))
    x, y, z = points.T
    np.testing.assert_array_equal(result.z(x, y), result.surface.z(x, y))
    off = result.z(x, y) - z
    # The distance to a surface is at most the vertical one.
    assert (result.deviations <= abs(off) + 1e-6).all()


def held_out_rms(points: NDArray[np.float64], seed: int) -> tuple[float, float]:
    """Leave a quarter of the points out; return our rms there and that of SciPy's triangles."""
    out = np.random.default_rng(seed).random(len(points)) < 0.25
    x, y, z = points[out].T
    used = points[~out]
    linear = LinearNDInterpolator(used[:, :2], used[:, 2])(x, y)
    ours = neurbs.reconstruct(used, kind="height").z(x, y)
    assert not np.isnan(ours).any()
    inside = np.isfinite(linear)
    rms = [float(np.sqrt(np.mean((found - z)[inside] ** 2))) for found in (ours, linear)]
    return rms[0], rms[1]


@pytest.mark.skipif("NEURBS_DATA" not in os.environ, reason="NEURBS_DATA is not set")
@pytest.mark.parametrize(("rows", "share"), [(3, 0.2), (3, 0.5), (3, 1), (5, 0.5), (5, 1), (10, 1)])
def test_terrain_along_tracks_is_predicted_as_well_as_by_scipy(rows: int, share: float) -> None:
    points = np.load(Path(os.environ["NEURBS_DATA"]) / "npy" / "jacksboro_dem.npy")
    row = np.unique(points[:, 1], return_inverse=True)[1]
    # Tracks along some rows, and some of the points along them.
    tracks = points[(row % rows == 0) & (np.random.default_rng(1).random(len(points)) < share)]
    ours, scipy = held_out_rms(tracks, seed=0)
    assert ours <= scipy


def test_type_checkers_know_scalars_and_arrays(
    revealed: Callable[[Path], str], tmp_path: Path
) -> None:
    (tmp_path / "program.py").write_text(
        "import neurbs, numpy as np\n"
        "surface = neurbs.NurbsSurface.sphere([0, 0, 0], 1)\n"
        "reveal_type(surface.z(0.0, 0.5))\n"
        "reveal_type(surface.z(np.zeros(3), 0.5))\n"
    )
    answer = revealed(tmp_path / "program.py")
    floats, arrays = [line for line in answer.splitlines() if "Revealed" in line]
    assert '"float"' in floats.replace("builtins.", "")
    assert "ndarray" in arrays
