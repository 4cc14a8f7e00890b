"""Axes in different units: points are fitted as in one, and the surface is in their own."""

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

import neurbs
from neurbs import ConvergenceWarning

Points = NDArray[np.float64]

FACTORS = [
    (1, 1, 1000),
    (1, 1, 30),
    (1000, 1, 1),
    (1, 0.001, 1),
    (1000, 1, 0.001),
]


def height(x: Points, y: Points) -> Points:
    found: Points = 0.1 * np.sin(3 * x + y) + 0.1 * np.cos(4 * y - x)
    return found


def ground(rng: np.random.Generator, count: int) -> Points:
    x, y = 2 * rng.random((2, count))
    return np.column_stack([x, y, height(x, y)])


def contours(rng: np.random.Generator) -> Points:
    """Return points on ten levels of a ground, within a ten-thousandth of them."""
    points = ground(rng, 150_000)
    levels = points[:, 2] / 0.04
    near = np.abs(levels - np.round(levels)) < 0.0025
    points = points[near][:4000]
    points[:, 2] = 0.04 * np.round(points[:, 2] / 0.04)
    return points


def wall(rng: np.random.Generator) -> Points:
    x, z = rng.random((2, 2000))
    return np.column_stack([2 * x, 0.1 * np.sin(5 * x) * np.cos(3 * z), 6 * z])


def swath(rng: np.random.Generator) -> Points:
    x, y = np.meshgrid(np.arange(600.0), np.arange(5.0))
    points = np.column_stack([x.ravel(), y.ravel(), 2 * np.sin(x.ravel() / 15)])
    return points + 0.05 * rng.standard_normal(points.shape)


def reconstructed(points: Points, **options: Any) -> neurbs.Reconstruction:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        found: neurbs.Reconstruction = neurbs.reconstruct(points, **options)
    return found


def told(result: neurbs.Reconstruction) -> list[str]:
    return [text for text in result.report.warnings if "different units: the fit counts" in text]


def error(result: neurbs.Reconstruction, factors: Points) -> float:
    """Return how far the surface's middle lies from the ground, in its own unit."""
    places = np.random.default_rng(1).uniform(0.05, 0.95, (2000, 2))
    x, y, z = (result.surface.evaluate(places) / factors).T
    return float(np.sqrt(np.mean((z - height(x, y)) ** 2)))


@pytest.mark.parametrize("factors", FACTORS)
@pytest.mark.parametrize("count", [150, 3000])
def test_grounds_are_found_in_any_units(
    rng: np.random.Generator, count: int, factors: tuple[float, float, float]
) -> None:
    points = ground(rng, count)
    result = reconstructed(points * factors)
    assert result.report.topology == "height"
    assert len(told(result)) == 1
    assert result.inliers.all()
    assert error(result, np.array(factors)) < (3e-3 if count == 150 else 1e-4)


def test_contour_lines_are_found_in_other_units(rng: np.random.Generator) -> None:
    result = reconstructed(contours(rng) * (1, 1, 1000))
    assert told(result)
    assert error(result, np.array((1, 1, 1000))) < 3e-3


def sea(rng: np.random.Generator, tracks: int) -> Points:
    """Return depths in metres of a rough ground along tracks, over degrees."""
    wave = np.exp(rng.uniform(np.log(4), np.log(1000), 200))
    way, phase = 2 * np.pi * rng.random((2, 200))
    start, end, swing = rng.random((3, tracks, 2))
    along = np.sort(rng.random((tracks, 10_000 // tracks, 1)), axis=1)
    places = start[:, None] + (end - start)[:, None] * along
    places += 0.02 * (swing[:, None] - 0.5) * np.sin(np.pi * along)
    x, y = places.reshape(-1, 2).T
    waves = np.sin(wave * (np.outer(x, np.cos(way)) + np.outer(y, np.sin(way))) + phase)
    depths = 1000 * waves @ wave**-0.4 + 10 * rng.standard_normal(len(x))
    return np.column_stack([245 + 10 * x, 20 + 10 * y, depths - 4000])


@pytest.mark.parametrize("tracks", [30, 60])
def test_a_rough_sea_along_tracks_is_heights(rng: np.random.Generator, tracks: int) -> None:
    result = reconstructed(sea(rng, tracks))
    assert result.report.topology == "height"
    assert told(result)


def test_what_is_returned_is_in_the_points_own_units(rng: np.random.Generator) -> None:
    points = ground(rng, 1000) * (1000, 1, 1)
    with pytest.warns(ConvergenceWarning, match="the fit counts 1/1024 of x, as do lengths"):
        result = neurbs.reconstruct(points, tolerance=1e-3)
    feet = result.surface.evaluate(result.uv)
    distances = np.linalg.norm(points - feet, axis=1)
    np.testing.assert_allclose(result.distances, distances, atol=1e-9)
    assert result.report.within == 1.0
    assert result.report.ended_by == "tolerance"
    assert result.report.max <= 1e-3
    nodes = result.som.codebook_.reshape(-1, 3)
    assert np.all(nodes.min(axis=0) >= points.min(axis=0) - 1)
    assert np.ptp(nodes[:, 0]) > 1500


def pipe(u: Points, v: Points) -> Points:
    return np.column_stack([np.cos(2 * np.pi * u), np.sin(2 * np.pi * u), 3 * v])


def torus(u: Points, v: Points) -> Points:
    r = 1 + 0.4 * np.cos(2 * np.pi * v)
    a = 2 * np.pi * u
    return np.column_stack([r * np.cos(a), r * np.sin(a), 0.4 * np.sin(2 * np.pi * v)])


def fold(u: Points, v: Points) -> Points:
    t = 3 * np.pi * (u - 0.5)
    return np.column_stack([np.sin(t), 2 * v, np.sign(t) * (np.cos(t) - 1)])


BODIES: list[tuple[Callable[[Points, Points], Points], str]] = [
    (pipe, "tube"),
    (torus, "torus"),
    (fold, "sheet"),
]


@pytest.mark.parametrize("factor", [1000.0, 0.001])
@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize(("body", "kind"), BODIES)
def test_bodies_are_found_in_other_units(
    rng: np.random.Generator,
    body: Callable[[Points, Points], Points],
    kind: str,
    axis: int,
    factor: float,
) -> None:
    factors = np.ones(3)
    factors[axis] = factor
    points = body(*rng.random((2, 2000)))
    truth = cKDTree(body(*np.random.default_rng(1).random((2, 100_000))))

    def farthest(result: neurbs.Reconstruction, factors: Points) -> float:
        places = result.surface.tessellate(shape=(80, 80)).vertices / factors
        return float(truth.query(places)[0].max())

    result = reconstructed(points * factors)
    assert result.report.topology == kind
    assert len(told(result)) == 1
    assert farthest(result, factors) < 2 * farthest(reconstructed(points), np.ones(3))
    feet, _ = truth.query(result.surface.evaluate(result.uv) / factors)
    assert feet.max() < 0.04


def test_a_tube_in_another_unit_keeps_its_radius(rng: np.random.Generator) -> None:
    result = reconstructed(pipe(*rng.random((2, 2000))) * (1, 1, 1000))
    assert result.report.topology == "tube"
    assert len(told(result)) == 1
    ends = result.surface.evaluate(result.uv)
    assert np.abs(np.hypot(ends[:, 0], ends[:, 1]) - 1).max() < 0.01


@pytest.mark.parametrize("factors", [(1, 1, 0.001), (0.001, 1, 1), (1000, 1, 1)])
def test_a_tolerance_holds_of_bodies_in_other_units(
    rng: np.random.Generator, factors: tuple[float, float, float]
) -> None:
    angle, along = rng.random((2, 6000)) * [[2 * np.pi], [3.0]]
    radius = 1 + 0.1 * np.sin(6 * angle) * np.sin(5 * along)
    bumpy = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), along])
    result = reconstructed(bumpy * factors, tolerance=0.005 * max(factors))
    assert result.report.ended_by == "tolerance"
    assert result.report.within == 1.0
    assert result.distances.max() <= 0.005 * max(factors)


def plain(rng: np.random.Generator) -> Points:
    """Return points of a ground much wider than high, in one unit."""
    x, y = rng.random((2, 3000))
    return np.column_stack([x, y, 0.002 * np.sin(7 * x) * np.cos(5 * y)])


def noisy_plate(rng: np.random.Generator) -> Points:
    return np.column_stack([rng.random((3000, 2)), 0.003 * rng.standard_normal(3000)])


def close_layers(rng: np.random.Generator) -> Points:
    points = plain(rng)
    points[::2, 2] += 0.003
    return points


def levelled(rng: np.random.Generator) -> Points:
    points = noisy_plate(rng)
    points[:, 2] = 0.003 * np.round(points[:, 2] / 0.003)
    return points


@pytest.mark.parametrize("cloud", [plain, noisy_plate, close_layers, levelled])
def test_plates_keep_their_units(
    rng: np.random.Generator, cloud: Callable[[np.random.Generator], Points]
) -> None:
    result = reconstructed(cloud(rng))
    assert not told(result)
    assert result.report.topology == "height"


def test_lines_along_a_tube_keep_its_units(rng: np.random.Generator) -> None:
    """Seen from the side, those behind lie between those before."""
    angle = np.repeat(2 * np.pi * (np.arange(20) + 0.5) / 20, 200)
    pipe = np.column_stack([np.cos(angle), np.sin(angle), 4 * rng.random(len(angle))])
    axis = np.array([-0.89, 0.05, -0.45])
    turn = 2 * np.outer(axis, axis) / (axis @ axis) - np.eye(3)
    result = reconstructed(pipe @ turn)
    assert not told(result)
    assert result.report.topology == "tube"


@pytest.mark.parametrize("cloud", [wall, swath])
def test_steep_and_narrow_surfaces_keep_their_units(
    cloud: Callable[[np.random.Generator], Points], rng: np.random.Generator
) -> None:
    assert not told(reconstructed(cloud(rng)))


def test_an_outlier_gives_no_axis_another_unit(rng: np.random.Generator) -> None:
    points = np.vstack([ground(rng, 1000), [(5000, 1, 0.1)]])
    result = reconstructed(points)
    assert not told(result)
    assert not result.inliers[-1]


def test_points_in_order_keep_their_units(rng: np.random.Generator) -> None:
    points = ground(rng, 400) * (1, 1000, 1)
    given = reconstructed(points, method="paper", grid=(6, 6), seed=1)
    assert not told(given)


@pytest.mark.parametrize("noise", [0.0, 0.01])
@pytest.mark.parametrize("seed", range(4))
def test_a_fold_that_leans_keeps_its_units(seed: int, noise: float) -> None:
    """Nearly along its rims, the layers of a fold lie beside one another, as steep heights do."""
    rng = np.random.default_rng(seed)
    t, y = 3 * np.pi * (rng.random(700) - 0.5), 2 * rng.random(700)
    points = np.column_stack([np.sin(t), y, np.sign(t) * (np.cos(t) - 1)])
    points += noise * rng.standard_normal(points.shape)
    for turn in (1, 3):
        result = reconstructed(points @ Rotation.random(random_state=turn).as_matrix().T)
        assert result.report.topology == "sheet"
        assert not told(result)


@pytest.mark.parametrize("seed", [2, 3, 5])
def test_a_noisy_fold_that_passes_for_heights_keeps_its_units(seed: int) -> None:
    """Heights through the middle of its layers leave two fifths of their spread."""
    rng = np.random.default_rng(seed)
    u, v = rng.random((2, 1000))
    points = np.column_stack([0.6 * np.sin(5 * u - 2.5), v, 1.6 * u])
    points += 0.01 * rng.standard_normal(points.shape)
    result = reconstructed(points @ Rotation.random(random_state=seed).as_matrix().T)
    assert not told(result)
    assert result.report.rms < 0.012
    assert "other units" in result.report.seconds


@pytest.mark.parametrize("count", [200, 400])
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_cylinders_of_few_points_keep_their_units(count: int, noise: float) -> None:
    """Seen from the side, points of two layers are few enough to lie between one another."""
    for seed in range(8):
        rng = np.random.default_rng(seed)
        angle = 1.5 * np.pi * rng.random(count)
        points = np.column_stack([np.cos(angle), np.sin(angle), 1.5 * rng.random(count)])
        points += noise * rng.standard_normal(points.shape)
        turned = points @ Rotation.random(random_state=seed).as_matrix().T
        assert not told(reconstructed(turned)), seed


@pytest.mark.parametrize("by", [20, 1000])
def test_few_heights_are_found_in_another_unit(by: float) -> None:
    for seed in range(6):
        x, y = np.random.default_rng(seed).random((2, 60))
        z = 0.1 * np.sin(5 * x + 2 * y) + 0.08 * np.cos(7 * y - 3 * x)
        result = reconstructed(np.column_stack([x, y, by * z]))
        assert told(result), seed
        assert result.report.topology == "height", seed
