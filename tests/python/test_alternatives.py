"""Clouds through which the first surface folds over, runs away or has nothing of their shape."""

from collections.abc import Callable, Iterable
from typing import Literal

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


def doughnut(rng: np.random.Generator, count: int, ring: float, section: float) -> Array:
    turn, about = rng.uniform(0, 2 * np.pi, (2, count))
    radius, height = ring + section * np.cos(about), section * np.sin(about)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])


def torus(rng: np.random.Generator, count: int) -> Array:
    return doughnut(rng, count, 2, 0.7)


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


def thick(rng: np.random.Generator, count: int) -> Array:
    """Scatter points over a torus whose hole is about as wide as its section."""
    return doughnut(rng, count, 1, 0.45)


def cone(rng: np.random.Generator, count: int) -> Array:
    along, turn = rng.random((2, count)) * [[1], [2 * np.pi]]
    return np.column_stack([along * np.cos(turn), along * np.sin(turn), 2 * along])


def bottle(rng: np.random.Generator, count: int) -> Array:
    """Scatter points over a bottle of Klein, which goes through itself."""
    turn, about = 2 * np.pi * rng.random((2, count))
    half = turn / 2
    radius = 2 + np.cos(half) * np.sin(about) - np.sin(half) * np.sin(2 * about)
    height = np.sin(half) * np.sin(about) + np.cos(half) * np.sin(2 * about)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])


def holed_pipe(rng: np.random.Generator, count: int) -> Array:
    turn, along = rng.random((2, count))
    pipe = np.column_stack([np.cos(2 * np.pi * turn), np.sin(2 * np.pi * turn), 2 * along])
    hole: Array = pipe[(abs(turn - 0.5) > 0.15) | (abs(along - 0.5) > 0.2)]
    return hole


def scattered(rng: np.random.Generator, count: int) -> Array:
    return rng.random((count, 3))


def curve(rng: np.random.Generator, count: int) -> Array:
    turn = 6 * rng.random(count)
    return np.column_stack([np.cos(turn), np.sin(turn), 2 * np.sin(1.5 * turn)])


def octant(rng: np.random.Generator, count: int) -> Array:
    places = rng.normal(size=(count, 3))
    octants: Array = abs(places) / np.linalg.norm(places, axis=1)[:, None]
    return octants


def star(rng: np.random.Generator, count: int) -> Array:
    out, turn = rng.random((2, count)) * [[1], [2 * np.pi]]
    radius = (1 + 0.5 * np.cos(5 * turn)) * out
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), 0.3 * out**2])


def slab(rng: np.random.Generator, count: int) -> Array:
    """Scatter points over a step so steep that they are in pieces."""
    x, y = 2 * rng.random((2, count)) - 1
    return np.column_stack([x, y, 2 * np.tanh(8 * (x + 0.3 * np.sin(3 * y)))])


def folds(result: neurbs.Reconstruction, points: Array) -> int:
    """Count samples whose normal points away from that of the next, where points lie flat."""
    surface, sides = result.surface, []
    for knots, (start, end) in zip(surface.knots, surface.domain, strict=True):
        spans = len(np.unique(knots[(knots >= start) & (knots < end)]))
        sides.append(np.linspace(start, end, 4 * spans + 1))
    uv = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1)
    normals = surface.normals(uv.reshape(-1, 2)).reshape(*uv.shape[:2], 3)
    flips = [
        uv[:-1][np.einsum("ijk,ijk->ij", normals[1:], normals[:-1]) < 0],
        uv[:, :-1][np.einsum("ijk,ijk->ij", normals[:, 1:], normals[:, :-1]) < 0],
    ]
    places = surface.evaluate(np.concatenate(flips))
    flat = np.ones(len(places), dtype=bool)
    # Some of the points may not have counted.
    for some in (points, points[result.inliers]):
        _, near = cKDTree(some).query(places, np.clip(len(some) // 16, 8, 16))
        around = some[near] - some[near].mean(axis=1, keepdims=True)
        _, second, third = np.linalg.svd(around, compute_uv=False).T
        flat &= third < 0.28 * second
    return int(flat.sum())


def outside(result: neurbs.Reconstruction, points: Array) -> float:
    """Return how far the surface lies outside of their hull, as a share of their longest chord."""
    faces = ConvexHull(points).equations
    places = result.surface.tessellate(shape=(80, 80)).vertices
    return float((places @ faces[:, :3].T + faces[:, 3]).max() / pdist(points).max())


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
        # The stated bound is 0.3 at four places to a span; between these it is a little more.
        assert outside(result, points) < 0.33, seed


@pytest.mark.filterwarnings("ignore::neurbs.ConvergenceWarning")
@pytest.mark.parametrize(
    ("kind", "shape", "count", "noise", "seeds"),
    [
        ("sheet", thick, 60, 0.0, range(6)),
        ("sheet", thick, 60, 0.03, range(3)),
        ("sheet", cone, 52, 0.06, range(10)),
        ("sheet", scattered, 52, 0.0, range(11)),
        ("sheet", bottle, 52, 0.05, range(11)),
        ("sheet", holed_pipe, 200, 0.03, range(6)),
        ("tube", curve, 60, 0.02, range(6)),
        ("tube", octant, 120, 0.0, range(3)),
        ("tube", star, 60, 0.0, range(6)),
        ("tube", stair, 120, 0.0, range(3)),
        ("tube", slab, 80, 0.0, range(6)),
        ("torus", holed_pipe, 100, 0.0, range(3)),
        ("torus", slab, 60, 0.06, range(6)),
        ("torus", curve, 60, 0.0, range(6)),
    ],
)
def test_nothing_is_wild_whatever_is_asked_for(
    kind: Literal["sheet", "tube", "torus"],
    shape: Shape,
    count: int,
    noise: float,
    seeds: Iterable[int],
) -> None:
    for seed in seeds:
        rng = np.random.default_rng(seed)
        points = shape(rng, count)
        points = points + noise * rng.normal(size=points.shape)
        result = neurbs.reconstruct(points, topology=kind)
        assert result.report.topology in (kind, "height"), seed
        assert not any("folds over" in warning for warning in result.report.warnings), seed
        if result.report.topology == "height":
            assert result.report.rms < 0.25 * result.report.diagonal, seed
            continue
        assert folds(result, points) == 0, seed
        assert outside(result, points[result.inliers]) < 0.33, seed


@pytest.mark.filterwarnings("ignore::neurbs.ConvergenceWarning")
@pytest.mark.parametrize("degrees", [180, 240, 300])
@pytest.mark.parametrize("count", [120, 600])
def test_a_tube_that_is_asked_for_goes_on_around_part_of_a_pipe(degrees: int, count: int) -> None:
    for seed in range(3):
        rng = np.random.default_rng(seed)
        turn, along = rng.random((2, count)) * [[np.radians(degrees)], [3]]
        points = np.column_stack([np.cos(turn), np.sin(turn), along])
        points += 0.02 * rng.normal(size=points.shape)
        result = neurbs.reconstruct(points, topology="tube")
        assert result.surface.closed == (True, False)
        assert result.report.rms < 0.025, seed
        assert folds(result, points) == 0, seed
        # It closes around the pipe's axis, and does not go there and back along the part.
        vertices = result.surface.tessellate(shape=(80, 80)).vertices
        turns = np.histogram(np.arctan2(*vertices[:, 1::-1].T), 12, (-np.pi, np.pi))[0]
        assert (turns > 0).all(), seed


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
