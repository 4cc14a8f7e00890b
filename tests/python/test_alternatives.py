"""Clouds through which the first surface folds over, runs away or has nothing of their shape."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, cKDTree
from scipy.spatial.distance import pdist

import neurbs

Array = NDArray[np.float64]
Shape = Callable[[np.random.Generator, int], Array]


def band(rng: np.random.Generator, count: int) -> Array:
    """Scatter points over a band with one side."""
    turn, across = rng.uniform(0, 2 * np.pi, count), rng.uniform(-0.4, 0.4, count)
    radius = 1 + across * np.cos(turn / 2)
    return np.column_stack(
        [radius * np.cos(turn), radius * np.sin(turn), across * np.sin(turn / 2)]
    )


def stair(rng: np.random.Generator, count: int) -> Array:
    """Scatter points over a winding stair."""
    turn, radius = rng.uniform(0, 4 * np.pi, count), rng.uniform(-1, 1, count)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), turn / 3])


def torus(rng: np.random.Generator, count: int) -> Array:
    turn, about = rng.uniform(0, 2 * np.pi, (2, count))
    radius = 2 + 0.7 * np.cos(about)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), 0.7 * np.sin(about)])


def ball(rng: np.random.Generator, count: int) -> Array:
    places = rng.normal(size=(count, 3))
    balls: Array = places / np.linalg.norm(places, axis=1)[:, None] * [1, 1.5, 3]
    return balls


def cube(rng: np.random.Generator, count: int) -> Array:
    places: Array = rng.uniform(-1, 1, (count, 3))
    faces = rng.integers(0, 3, count)
    places[np.arange(count), faces] = rng.choice([-1.0, 1.0], count)
    return places


def cross(rng: np.random.Generator, count: int) -> Array:
    """Scatter points over two squares that cross one another."""
    places: Array = rng.uniform(-1, 1, (count, 3))
    places[: count // 2, 0] = 0
    places[count // 2 :, 1] = 0
    return places


def corner(rng: np.random.Generator, count: int) -> Array:
    """Scatter points over the three sides of a box that meet in a corner."""
    places: Array = rng.uniform(0, 1, (count, 3))
    places[np.arange(count), rng.integers(0, 3, count)] = 0
    return places


def farthest(result: neurbs.Reconstruction, points: Array) -> float:
    """Return how far the surface goes from all points, as a share of their diagonal."""
    away, _ = cKDTree(points).query(result.surface.tessellate(shape=(80, 80)).vertices)
    return float(away.max() / result.report.diagonal)


@pytest.mark.filterwarnings("ignore::neurbs.ConvergenceWarning")
@pytest.mark.parametrize(("count", "noise"), [(100, 0.01), (150, 0.02)])
def test_corners_of_a_sheet_do_not_stick_out(count: int, noise: float) -> None:
    far = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        points = corner(rng, count) + rng.normal(0, noise, (count, 3))
        result = neurbs.reconstruct(points, topology="sheet")
        assert result.report.rms < noise * result.report.diagonal, seed
        far.append(farthest(result, points))
    # Three of those of 100 points were 0.32 to 0.39 away.
    assert max(far) < 0.3, far
    assert np.quantile(far, 0.9) < 0.25, far


@pytest.mark.filterwarnings("ignore::neurbs.ConvergenceWarning")
@pytest.mark.parametrize(
    ("shape", "count", "noise", "seeds"),
    [
        (band, 500, 0.01, [0, 500]),
        (band, 500, 0.0, [0, 500]),
        (stair, 60, 0.01, [*range(12), 60]),
        (torus, 150, 0.01, [*range(6), 250]),
        (torus, 1500, 0.0, [1500]),
        (torus, 1500, 0.01, [1600]),
        (ball, 150, 0.0, [*range(6), 150]),
        (cube, 1500, 0.0, [1500]),
        (cross, 60, 0.01, [*range(12), 60]),
        (cross, 500, 0.01, [0, 1, 500]),
    ],
)
def test_sheets_neither_fold_over_nor_run_away(
    shape: Shape, count: int, noise: float, seeds: list[int]
) -> None:
    for seed in seeds:
        rng = np.random.default_rng(seed)
        points = shape(rng, count)
        points = points + noise * rng.normal(size=points.shape)
        result = neurbs.reconstruct(points, topology="sheet")
        bad = [w for w in result.report.warnings if "folds" in w or "runs" in w or "no order" in w]
        assert not bad, seed
        assert result.report.rms < 0.08 * result.report.diagonal, seed
        # What goes on beyond their hull, and what a sheet makes of an opening or a slit.
        assert farthest(result, points) < 0.3, seed
        faces = ConvexHull(points).equations
        places = result.surface.tessellate(shape=(80, 80)).vertices
        outside = (places @ faces[:, :3].T + faces[:, 3]).max()
        # The stated bound is 0.3 at four places to a span; between these it is a little more.
        assert outside < 0.33 * pdist(points).max(), seed


@pytest.mark.filterwarnings("ignore::neurbs.ConvergenceWarning")
def test_a_band_with_one_side_is_no_tube_that_folds_over() -> None:
    rng = np.random.default_rng(1500)
    result = neurbs.reconstruct(band(rng, 1500) + 0.01 * rng.normal(size=(1500, 3)))
    assert result.report.topology == "sheet"
    assert result.report.topology_reason is not None
    assert "neither folds over" in result.report.topology_reason
    assert not any("folds" in warning for warning in result.report.warnings)
    assert result.report.rms < 0.01 * result.report.diagonal


def test_what_was_asked_for_is_kept() -> None:
    rng = np.random.default_rng(1500)
    points = torus(rng, 1500)
    with pytest.warns(neurbs.ConvergenceWarning):
        result = neurbs.reconstruct(points, topology="sheet", fairness=1e-8)
    assert result.report.fairness == 1e-8


def test_a_tolerance_that_no_sound_surface_keeps_is_told_of() -> None:
    rng = np.random.default_rng(500)
    points = cross(rng, 500) + 0.01 * rng.normal(size=(500, 3))
    with pytest.warns(neurbs.ConvergenceWarning, match="farther than the tolerance"):
        result = neurbs.reconstruct(points, 0.005, topology="sheet")
    assert result.report.ended_by != "grid"
    assert not any("folds" in warning for warning in result.report.warnings)
