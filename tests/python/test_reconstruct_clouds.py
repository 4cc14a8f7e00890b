"""Clouds as they come: outliers, duplicates, weights, closed bodies, heights."""

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

import neurbs
from neurbs import ConvergenceWarning

Points = NDArray[np.float64]


def fold(rng: np.random.Generator, count: int, noise: float = 0.0) -> Points:
    """Scatter points over an S-shaped fold, which no direction is up for."""
    t, y = 3 * np.pi * (rng.random(count) - 0.5), 2 * rng.random(count)
    points = np.column_stack([np.sin(t), y, np.sign(t) * (np.cos(t) - 1)])
    return points + noise * rng.standard_normal(points.shape)


def off_fold(points: Points) -> Points:
    """Return the distances from two half cylinders, which the fold is made of."""
    x, _, z = points.T
    distances: Points = np.abs(np.hypot(x, z - np.copysign(1, z)) - 1)
    return distances


def wave(rng: np.random.Generator, count: int) -> Points:
    x, y = rng.random((2, count))
    return np.column_stack([x, y, 0.3 * np.sin(4 * x) * np.cos(3 * y)])


def test_round_sheets_end_at_their_outline(rng: np.random.Generator) -> None:
    height, angle = rng.uniform(0.1, 1, 2000), rng.uniform(0, 2 * np.pi, 2000)
    radius = np.sqrt(1 - height**2)
    cap = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])
    result = neurbs.reconstruct(cap, grid=(12, 12), topology="sheet")
    assert not result.report.warnings
    side, end = np.linspace(0, 1, 101), np.ones(101)
    border = [(side, 0 * end), (side, end), (0 * end, side), (end, side)]
    low = result.surface.evaluate(np.concatenate([np.column_stack(uv) for uv in border]))[:, 2]
    spacing = np.sqrt(2 * np.pi * 0.9 / 2000)
    assert np.abs(low - 0.1).max() < 0.5 * spacing
    assert abs(result.surface.area() / (2 * np.pi * 0.9) - 1) < 0.02


@pytest.mark.parametrize("count", [300, 1000, 3000])
def test_cones_with_an_apex_end_at_their_rim(count: int) -> None:
    areas = []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        radius, angle = np.sqrt(rng.random(count)), 2 * np.pi * rng.random(count)
        cone = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 1.5 * radius])
        result = neurbs.reconstruct(cone)
        assert not result.report.warnings
        assert result.report.rms < 1e-4 * result.report.diagonal
        areas.append(result.surface.area() / (np.pi * np.hypot(1, 1.5)))
    # Empty corners of a square around a round outline would have 0.27.
    assert np.abs(np.array(areas) - 1).max() < 0.08, areas


def test_what_was_flattened_ends_where_the_points_do() -> None:
    def capsule(at: Points, angle: Points) -> Points:
        """Return points of a cylinder of length 3 with round ends, the lower end at -1."""
        beyond = at - np.clip(at, 0, 3)
        radius = np.sqrt(np.maximum(1 - beyond**2, 0))
        return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), at])

    for seed in [8, 11, 13]:
        rng = np.random.default_rng(seed)
        at, angle = rng.uniform(-1, 4, 500), rng.uniform(0, 2 * np.pi, 500)
        body = capsule(at, angle) + rng.normal(0, 0.015, (500, 3))
        with warnings.catch_warnings(record=True):
            result = neurbs.reconstruct(body, topology="sheet")
        assert not any("runs" in warning for warning in result.report.warnings)
        # Noise alone leaves 23e-4 or more; these were 41 and 52.
        assert result.report.rms < 35e-4 * result.report.diagonal
        assert abs(result.surface.area() / (2 * np.pi * 5) - 1) < 0.05


def test_noisy_sheets_reach_their_ends() -> None:
    def place(u: Points, v: Points) -> Points:
        """Return points of an S with waves, in the unit square of its parameters."""
        t = 3 * np.pi * (u - 0.5)
        height = 0.12 * np.sin(np.pi * v) * np.sin(2 * t) + 0.1 * (v - 0.5) ** 2
        x, z = np.sin(t), np.sign(t) * (np.cos(t) - 1)
        return np.column_stack([x * (1 + np.sign(t) * height), 2 * v, z + np.cos(t) * height])

    side = np.array([0.4, 0.5, 0.6])
    beyond = []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        points = place(*rng.random((2, 2000))) + rng.normal(0, 0.025, (2000, 3))
        surface = neurbs.reconstruct(points, grid=(12, 12), topology="sheet").surface
        found = surface.tessellate(shape=(300, 100)).vertices
        for end, inside in [(0.0, 1e-4), (1.0, -1e-4)]:
            there = place(np.full(3, end), side)
            outwards = there - place(np.full(3, end + inside), side)
            outwards /= np.linalg.norm(outwards, axis=1)[:, None]
            for middle, direction in zip(there, outwards, strict=True):
                near = np.linalg.norm(found - middle, axis=1) < 0.5
                near &= np.abs(found[:, 1] - middle[1]) < 0.05
                beyond.append(((found[near] - middle) @ direction).max())
    # Points are 0.1 apart. Fairness had drawn the middles of the ends in, by 0.02.
    assert 0 < np.mean(beyond) < 0.05
    assert np.min(beyond) > -0.05


def places_in_an_l(rng: np.random.Generator) -> np.ndarray:
    places = rng.uniform(0, 2, (3000, 2))
    return places[(places < 1).any(axis=1)]


def corners_at_crease(surface: neurbs.NurbsSurface) -> np.ndarray:
    """Evaluate the ends of the one crease, and the corners of the surface."""
    inner, times = np.unique(surface.knots[0][4:-4], return_counts=True)
    (crease,) = inner[times == 3]
    uv = np.column_stack([np.repeat([0, crease, 1], 2), [0, 1, 0, 1, 0, 1]])
    return surface.evaluate(uv)


def apart_from_corners_of_the_l(corners: np.ndarray) -> tuple[np.ndarray, list[int]]:
    """Measure how far corners are from the nearest of the L, and which are the nearest to any."""
    wanted = np.array([(0, 0), (1, 1), (2, 0), (2, 1), (0, 2), (1, 2)])
    apart: np.ndarray = np.linalg.norm(corners[:, None] - wanted, axis=-1)
    nearest: np.ndarray = apart.min(axis=1)
    return nearest, sorted(apart.argmin(axis=1))


def test_heights_over_a_strip_end_at_its_straight_sides(rng: np.random.Generator) -> None:
    x, y = places_in_an_l(rng).T
    bent = np.column_stack([x, y, 0.3 * (x - 1) * (y - 1)])
    result = neurbs.reconstruct(bent, grid=(12, 12))
    assert result.report.topology == "height"
    assert not result.report.warnings
    spacing = np.sqrt(3 / len(bent))
    corners = corners_at_crease(result.surface)
    apart, ours = apart_from_corners_of_the_l(corners[:, :2])
    assert ours == list(range(6))
    assert apart.max() < 0.7 * spacing
    assert np.abs(corners[:, 2] - 0.3 * np.prod(corners[:, :2] - 1, axis=1)).max() < 1e-3
    assert result.report.max < 1e-3
    x, y = np.moveaxis((np.indices((400, 400)) + 0.5) / 200, 0, -1).reshape(-1, 2).T
    slopes = np.hypot(1, 0.3 * np.hypot(x - 1, y - 1))
    area = np.sum(slopes[(x < 1) | (y < 1)]) / 200**2
    assert 1 < result.surface.area() / area < 1.01


def test_heights_over_a_u_leave_its_bay_open(rng: np.random.Generator) -> None:
    places = rng.uniform(0, 3, (4000, 2))
    places = places[(np.abs(places[:, 0] - 1.5) > 0.5) | (places[:, 1] < 1)]
    heights = 0.1 * np.sin(2 * places[:, 0]) * places[:, 1]
    result = neurbs.reconstruct(np.column_stack([places, heights]), grid=(16, 16))
    assert result.report.topology == "height"
    x, y = result.surface.tessellate(shape=(200, 40)).vertices[:, :2].T
    assert not np.any((np.abs(x - 1.5) < 0.45) & (y > 1.05))
    assert 6.9 < result.surface.area() < 7.3


def test_heights_over_a_strip_with_a_bent_side_are_a_sheet(rng: np.random.Generator) -> None:
    x, y = places_in_an_l(rng).T
    x, y = np.compress(y > 0.1 * np.sin(np.pi * x / 2), [x, y], axis=1)
    bent = np.column_stack([x, y, 0.3 * (x - 1) * (y - 1)])
    result = neurbs.reconstruct(bent, grid=(12, 12))
    assert result.report.topology == "sheet"


def test_rolled_strips_have_creases_from_corner_to_corner() -> None:
    apart, areas = [], []
    for seed in range(36):
        x, y = places_in_an_l(np.random.default_rng(seed)).T
        rolled = np.column_stack([0.5 * np.sin(2 * x), y, 0.5 * np.cos(2 * x)])
        result = neurbs.reconstruct(rolled, grid=(12, 12))
        assert result.report.topology == "sheet"
        assert not result.report.warnings
        x, y, z = corners_at_crease(result.surface).T
        flat = np.column_stack([0.5 * (np.arctan2(x, z) % (2 * np.pi)), y])
        # What goes on beyond the start comes round.
        flat[flat[:, 0] > 2.5, 0] -= np.pi
        nearest, ours = apart_from_corners_of_the_l(flat)
        off = nearest.max() / np.sqrt(3 / len(rolled))
        apart.append(off if ours == list(range(6)) else np.inf)
        areas.append(result.surface.area() / 3)
    # One of 60 has its crease elsewhere; the worst corner of all six is off by 7 spacings on
    # average.
    assert np.isinf(apart).sum() <= 1
    assert np.median(apart) < 8
    assert 1 < np.median(areas) < 1.08


def test_gross_outliers_cost_next_to_nothing(rng: np.random.Generator) -> None:
    points = wave(rng, 3000)
    strays = rng.uniform([0, 0, -1], [1, 1, 1], (600, 3))
    spoiled = np.vstack([points, strays])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        clean = neurbs.reconstruct(points, grid=(12, 12))
        result = neurbs.reconstruct(spoiled, grid=(12, 12))
    far = result.surface.closest_points(points).distances
    assert np.sqrt(np.mean(far**2)) < 1.5 * clean.report.rms + 2e-4
    assert result.inliers[:3000].mean() > 0.98
    assert not result.inliers[3000:][np.abs(result.distances[3000:]) > 0.05].any()
    assert result.report.outliers == (~result.inliers).sum()
    assert result.report.max == result.distances[result.inliers].max()


def test_slight_outliers_cost_a_few_solutions(rng: np.random.Generator) -> None:
    points = fold(rng, 2000)
    _, y, z = points[700]
    centre = np.array([0, y, np.copysign(1, z)])
    points[700] = centre + 1.01 * (points[700] - centre)
    all_count = neurbs.reconstruct(points, grid=(12, 12), robust=False)
    result = neurbs.reconstruct(points, grid=(12, 12))
    assert np.flatnonzero(~result.inliers) == [700]
    assert abs(result.distances[700] - 0.01) < 5e-4
    # The fit goes on from where it was instead of beginning anew.
    more = result.report.iterations - all_count.report.iterations
    assert 1 <= more <= 8
    assert np.sqrt(np.mean(off_fold(result.surface.evaluate(rng.random((2000, 2)))) ** 2)) < 5e-4


def test_hardly_a_point_without_noise_is_an_outlier() -> None:
    left_out = 0
    for seed in range(10):
        u, v = np.random.default_rng(seed).random((2, 200))
        points = np.column_stack([np.sin(4 * u - 2), 2 * v, 0.4 * np.sin(8 * u - 4) + 1.2 * u])
        left_out += int(np.count_nonzero(~neurbs.reconstruct(points, clean=False).inliers))
    # Some lie a little beyond the border, or far off an earlier fit only: 37 were left out.
    assert left_out < 5


def test_a_net_grows_up_to_what_it_may_have() -> None:
    for seed in range(2):
        u, v = np.random.default_rng(seed).random((2, 3000))
        bent = np.cos(3 * u) + 0.1 * np.cos(25 * np.hypot(u - 0.5, v - 0.5))
        points = np.column_stack([np.sin(3 * u), 2 * v, bent])
        report = neurbs.reconstruct(points, topology="sheet", max_control_points=300).report
        # The next step of all spans would be too large from some 210 on.
        assert report.ended_by == "max_control_points"
        assert 270 <= np.prod(report.grid) <= 300, report.grid


def test_without_robustness_outliers_count(rng: np.random.Generator) -> None:
    points = np.vstack([wave(rng, 800), [[0.5, 0.5, 2.0]]])
    result = neurbs.reconstruct(points, grid=(8, 8), clean=False, robust=False)
    assert result.inliers.all()
    assert result.report.max > 1


def test_duplicates_count_together(rng: np.random.Generator) -> None:
    points = wave(rng, 600)
    repeated = rng.permutation(np.repeat(points, 3, axis=0))
    result = neurbs.reconstruct(repeated, grid=(8, 8))
    assert result.report.duplicates == 1200
    assert len(result.distances) == 1800
    once = neurbs.reconstruct(points, grid=(8, 8))
    difference = result.surface.control_points - once.surface.control_points
    assert np.abs(difference).max() < 1e-6


def test_points_without_weight_are_left_out_but_measured(rng: np.random.Generator) -> None:
    points = wave(rng, 1000)
    shifted = points.copy()
    shifted[:100, 2] += 0.2
    weights = np.ones(1000)
    weights[:100] = 0
    result = neurbs.reconstruct(shifted, grid=(10, 10), weights=weights)
    assert not result.inliers[:100].any()
    assert result.inliers[100:].all()
    assert result.distances[:100].min() > 0.05
    assert result.report.max < 0.01
    for wrong in (weights[:-1], -weights, np.full(1000, np.nan), np.zeros(1000)):
        with pytest.raises(neurbs.NeurbsError):
            neurbs.reconstruct(points, weights=wrong)


def test_a_sheet_around_a_body_does_not_fold() -> None:
    i = np.arange(2000) + 0.5
    z, angle = 1 - i / 1000, 2.4 * i
    ball = np.column_stack([np.cos(angle), np.sin(angle), z])
    ball[:, :2] *= np.sqrt(1 - z**2)[:, None]
    with pytest.warns(ConvergenceWarning, match="closed") as caught:
        result = neurbs.reconstruct(ball[z < 0.95], topology="sheet")
    assert not any("folds over" in str(warning.message) for warning in caught)
    assert result.som.fold_overs() == 0
    assert result.report.rms < 1e-3


def test_what_closes_is_found_out(rng: np.random.Generator) -> None:
    u, v = rng.random((2, 2000))
    a, b = 2 * np.pi * u, 2 * np.pi * v
    r = 1 + 0.3 * np.cos(b)
    clouds = {
        "height": wave(rng, 2000),
        "sheet": fold(rng, 2000),
        "tube": np.column_stack([np.cos(a), np.sin(a), 3 * v]),
        "torus": np.column_stack([r * np.cos(a), r * np.sin(a), 0.3 * np.sin(b)]),
    }
    for kind, points in clouds.items():
        result = neurbs.reconstruct(points, grid=(12, 12))
        assert result.report.topology == kind
        assert result.report.topology_reason
        assert result.surface.closed == (kind in ("tube", "torus"), kind == "torus")
        assert result.report.rms < 2e-3 * result.report.diagonal


@pytest.mark.parametrize("count", [100, 200, 500])
def test_loops_of_few_points_are_found(count: int) -> None:
    for seed in range(6):
        u, v = np.random.default_rng(seed).random((2, count))
        x, y = np.cos(2 * np.pi * u), np.sin(2 * np.pi * u)
        turn = Rotation.random(random_state=seed).as_matrix()
        assert neurbs.detect_topology(np.column_stack([x, y, 3 * v]) @ turn).kind == "tube", seed
        # Half of it is a sheet, also where it has few points.
        half = np.column_stack([np.cos(np.pi * u), np.sin(np.pi * u), 1.5 * v])
        assert neurbs.detect_topology(half @ turn).kind in ("sheet", "height"), seed


@pytest.mark.parametrize(("inner", "count"), [(0.2, 300), (0.5, 2000)])
def test_a_flat_ring_is_fitted_as_the_tube_that_it_was_called(
    inner: float, count: int, rng: np.random.Generator
) -> None:
    around, radius = 2 * np.pi * rng.random(count), np.sqrt(rng.uniform(inner**2, 1, count))
    x, y, z = radius * np.cos(around), radius * np.sin(around), 0.1 * np.sin(3 * around)
    result = neurbs.reconstruct(np.column_stack([x, y, z]), grid=(12, 12), topology="tube")
    assert result.surface.closed == (True, False)
    assert "closes around one way" in (result.report.topology_reason or "")
    assert result.report.rms < 2e-5 * result.report.diagonal
    assert not result.report.warnings


def test_a_closed_body_is_fitted_as_asked_with_a_warning(rng: np.random.Generator) -> None:
    points = rng.standard_normal((2000, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    with pytest.warns(ConvergenceWarning, match="closed"):
        result = neurbs.reconstruct(points, grid=(12, 12), topology="sheet")
    assert result.surface.closed == (False, False)


@pytest.mark.parametrize("half_turns", [1, 2, 3])
def test_a_strip_with_one_side_is_told(half_turns: int, rng: np.random.Generator) -> None:
    t, s = 2 * np.pi * rng.random(2000), 0.8 * (rng.random(2000) - 0.5)
    r, z = 1 + s * np.cos(half_turns * t / 2), s * np.sin(half_turns * t / 2)
    result = neurbs.reconstruct(np.column_stack([r * np.cos(t), r * np.sin(t), z]))
    told = any("one side only" in warning for warning in result.report.warnings)
    assert told == (half_turns % 2 == 1)


def test_heights_are_as_accurate_as_least_squares_of_a_function(rng: np.random.Generator) -> None:
    interpolate = pytest.importorskip("scipy.interpolate")
    points = wave(rng, 2000)
    result = neurbs.reconstruct(points, grid=(12, 12), topology="height")
    inner = np.linspace(0, 1, 10)[1:-1]
    spline = interpolate.LSQBivariateSpline(*points.T, inner, inner)
    truth = wave(np.random.default_rng(5), 4000)
    truth = truth[np.abs(truth[:, :2] - 0.5).max(axis=1) < 0.49]
    theirs = np.abs(spline.ev(truth[:, 0], truth[:, 1]) - truth[:, 2])
    ours = result.surface.closest_points(truth).distances
    assert np.sqrt(np.mean(ours**2)) < 1.2 * np.sqrt(np.mean(theirs**2))


def test_heights_span_missing_areas(rng: np.random.Generator) -> None:
    points = wave(rng, 3000)
    points = points[np.hypot(points[:, 0] - 0.5, points[:, 1] - 0.5) > 0.2]
    result = neurbs.reconstruct(points, grid=(14, 14), topology="height")
    middle = result.surface.closest_points([[0.5, 0.5, 0.3 * np.sin(2) * np.cos(1.5)]])
    assert middle.distances[0] < 0.02


def torn(rng: np.random.Generator) -> Points:
    """Scatter points over a rolled sheet of a random shape with a hole and a ragged outline."""
    u, v = rng.random((2, 3000))
    hole, bay = rng.uniform(0.3, 0.7, (2, 2))
    place, width = np.column_stack([u, v]), rng.uniform(0.1, 0.2, 2)
    kept = np.linalg.norm(place - hole, axis=1) > width[0]
    kept &= np.linalg.norm(place - [0, bay[1]], axis=1) > width[1]
    kept &= rng.random(3000) < 0.1 + 0.9 * u  # density varies tenfold
    u, v = place[kept].T
    radius = 1 + 0.1 * np.sin(rng.uniform(3, 6) * v + rng.uniform(0, 6))
    angle = rng.uniform(1, 4) * u
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 2 * v])
    return points + rng.uniform(0, 0.01) * rng.standard_normal(points.shape)


def overshoot(points: Points, result: neurbs.Reconstruction) -> float:
    """Return how far places are from the points, beyond twice the way to a foot, in diagonals."""
    spatial = pytest.importorskip("scipy.spatial")
    u, v = (np.linspace(*domain, 200) for domain in result.surface.domain)
    net = result.surface.evaluate_grid(u, v)
    lengths = [
        np.linalg.norm(np.diff(net, axis=axis), axis=2).sum(axis=axis).mean() for axis in (0, 1)
    ]
    scale = np.array(lengths) / np.ptp(result.surface.domain, axis=1)
    uv = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2)
    counts = result.inliers
    gaps, _ = spatial.cKDTree(result.uv[counts] * scale).query(uv * scale)
    distances, _ = spatial.cKDTree(points[counts]).query(net.reshape(-1, 3))
    return float((distances - 2 * gaps).max() / np.linalg.norm(np.ptp(points, axis=0)))


@pytest.mark.parametrize("seed", range(8))
def test_no_surface_runs_away_over_holes_or_beyond_the_border(seed: int) -> None:
    points = torn(np.random.default_rng(seed))
    result = neurbs.reconstruct(points, topology="sheet")
    assert overshoot(points, result) < 0.05
    assert not any("runs" in words for words in result.report.warnings)


@pytest.mark.parametrize("count", [52, 80])
def test_no_surface_of_few_points_goes_far_outside_of_them_untold(count: int) -> None:
    for seed in range(6):
        rng = np.random.default_rng(seed)
        along, angle = rng.random(count), 2 * np.pi * rng.random(count)
        radius = np.sqrt(1 - (1 - 1.6 * along) ** 2)
        cap = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 1.6 * along])
        tube = np.column_stack([np.cos(angle), np.sin(angle), 3 * along])
        for points in (cap, tube):
            with warnings.catch_warnings(record=True) as told:
                result = neurbs.reconstruct(points, topology="sheet")
            hull = ConvexHull(points).equations
            found = result.surface.tessellate(shape=(60, 60)).vertices
            outside = (found @ hull[:, :3].T + hull[:, 3]).max() / result.report.diagonal
            # A quarter, as seen from the nearest point, where that is not told; it was up to 0.7.
            assert told or outside < 0.4, (seed, outside)


def test_a_surface_that_runs_away_is_told(rng: np.random.Generator) -> None:
    points = fold(rng, 1500, noise=0.03)
    points = points[np.hypot(points[:, 1] - 1, points[:, 2]) > 0.7]
    with pytest.warns(ConvergenceWarning, match="runs .* away from the points"):
        result = neurbs.reconstruct(points, grid=(20, 20), topology="sheet", fairness=1e-9)
    assert overshoot(points, result) > 0.05
    fair = neurbs.reconstruct(points, grid=(20, 20), topology="sheet")
    assert overshoot(points, fair) < 0.05


def test_only_what_would_fold_stays_stiff() -> None:
    x, y = np.random.default_rng(1).random((2, 2500))
    radius = 0.5 + 0.06 * np.sin(16 * np.pi * x)
    points = np.column_stack([1.5 * x, radius * np.cos(3 * y), radius * np.sin(3 * y)])
    with pytest.warns(ConvergenceWarning, match="folds over"):
        neurbs.reconstruct(points, grid=(14, 14), topology="sheet", fairness=1e-4)
    result = neurbs.reconstruct(points, grid=(14, 14), topology="sheet")
    assert not result.report.warnings
    stiff = neurbs.reconstruct(points, grid=(14, 14), topology="sheet", fairness=1.0)
    assert result.report.rms < 0.8 * stiff.report.rms


def test_free_weights_meet_a_cylinder_with_few_control_points(rng: np.random.Generator) -> None:
    angle, z = 2.5 * rng.random(1500), 2 * rng.random(1500)
    points = np.column_stack([np.cos(angle), np.sin(angle), z])
    plain = neurbs.reconstruct(points, grid=(4, 4), aspect="fixed")
    freed = neurbs.reconstruct(points, grid=(4, 4), aspect="fixed", rational=True)
    assert freed.surface.weights is not None
    assert freed.report.rms < 0.6 * plain.report.rms
    assert freed.report.rms < 1e-4 * freed.report.diagonal
    assert plain.surface.weights is None


def test_the_order_of_points_changes_nothing(rng: np.random.Generator) -> None:
    points = fold(rng, 1500, 0.01)
    order = rng.permutation(len(points))
    first = neurbs.reconstruct(points, grid=(16, 6))
    second = neurbs.reconstruct(points[order], grid=(16, 6))
    size = first.report.diagonal
    difference = first.surface.control_points - second.surface.control_points
    assert np.abs(difference).max() < 1e-9 * size
    np.testing.assert_allclose(second.distances, first.distances[order], atol=1e-9 * size)


def test_mirrored_points_move_and_shuffle_as_others_do(rng: np.random.Generator) -> None:
    half = fold(rng, 400, 0.01) - [0, 1, 0]
    points = np.vstack([half, half * [1, -1, 1]])
    turn = Rotation.random(random_state=1).as_matrix()
    order = rng.permutation(len(points))
    first, second = (
        neurbs.reconstruct(points, topology="sheet"),
        neurbs.reconstruct(points[order] @ turn.T, topology="sheet"),
    )
    difference = second.surface.control_points - first.surface.control_points @ turn.T
    assert np.abs(difference).max() < 1e-9 * first.report.diagonal


def petal(rng: np.random.Generator, count: int, noise: float = 0.0) -> Points:
    """Scatter points over a bent ellipse, denser at one end."""
    x, y = rng.uniform(-1, 1, (2, 8 * count))
    inside = (x**2 + y**2 < 1) & (rng.random(len(x)) < np.exp(-x - 1))
    x, y = x[inside][:count], 0.6 * y[inside][:count]
    points = np.column_stack([x, y, 0.5 * x**2 - y**2 + 0.1 * np.sin(4 * x)])
    return points + noise * rng.standard_normal(points.shape)


def bent_pipe(rng: np.random.Generator, count: int, noise: float = 0.0) -> Points:
    along, angle = 2 * rng.random(count), 2 * np.pi * rng.random(count)
    radius = 2 + 0.5 * np.cos(angle)
    points = np.column_stack([radius * np.cos(along), radius * np.sin(along), 0.5 * np.sin(angle)])
    return points + noise * rng.standard_normal(points.shape)


def leaning(rng: np.random.Generator, count: int, noise: float = 0.0) -> Points:
    """Scatter points over heights in a general position."""
    points = wave(rng, count) + noise * rng.standard_normal((count, 3))
    found: Points = points @ Rotation.random(random_state=2).as_matrix().T
    return found


@pytest.mark.parametrize(
    ("shape", "count", "noise"),
    [
        (fold, 3500, 0.0),
        (fold, 3500, 0.01),
        (fold, 25_000, 0.01),
        (petal, 3500, 0.0),
        (petal, 700, 0.01),
        (petal, 3500, 0.01),
        (bent_pipe, 3500, 0.0),
        (bent_pipe, 3500, 0.01),
        (bent_pipe, 25_000, 0.01),
        (leaning, 3500, 0.0),
        (leaning, 3500, 0.01),
    ],
)
def test_rigid_motion_and_scale_carry_over(
    shape: Callable[[np.random.Generator, int, float], Points],
    count: int,
    noise: float,
    rng: np.random.Generator,
) -> None:
    points = shape(rng, count, noise)
    turn = Rotation.random(random_state=1).as_matrix()

    def moved(points: Points) -> Points:
        found: Points = 1.7 * points @ turn.T + [300, -100, 20]
        return found

    first, second = neurbs.reconstruct(points), neurbs.reconstruct(moved(points))
    assert first.report.grid == second.report.grid
    places = moved(first.surface.evaluate(rng.random((500, 2))))
    off = second.surface.closest_points(places).distances
    assert off.max() < 1e-9 * second.report.diagonal


@pytest.mark.parametrize("init", ["auto", "geodesic"])
def test_starts_along_the_surface_unfold_it(init: str, rng: np.random.Generator) -> None:
    points = fold(rng, 2000)
    result = neurbs.reconstruct(points, grid=(24, 6), init=init)
    assert result.report.rms < 1e-3 * result.report.diagonal
    assert off_fold(result.surface.evaluate(rng.random((500, 2)))).max() < 0.05


def test_a_given_start_is_used(rng: np.random.Generator) -> None:
    points = wave(rng, 800)
    x, y = np.meshgrid(np.linspace(0, 1, 8), np.linspace(0, 1, 7), indexing="ij")
    nodes = np.dstack([x, y, np.zeros_like(x)])
    result = neurbs.reconstruct(points, grid=(8, 7), init=nodes, topology="tube")
    assert result.som.codebook_.shape == (8, 7, 3)
    for wrong in (nodes[0], "random"):
        with pytest.raises(neurbs.NeurbsError, match="init"):
            neurbs.reconstruct(points, init=wrong)


def test_chunks_give_the_same_as_one_piece(rng: np.random.Generator) -> None:
    points = wave(rng, 5000) + np.array([5e6, 7e6, 0])
    whole = neurbs.reconstruct(points, 0.01)
    chunked = neurbs.reconstruct(iter(np.array_split(points, 7)), 0.01)
    np.testing.assert_array_equal(chunked.points, points)
    difference = chunked.surface.control_points - whole.surface.control_points
    assert np.abs(difference).max() < 1e-9 * whole.report.diagonal
    np.testing.assert_allclose(chunked.distances, whole.distances, atol=1e-9)
    np.testing.assert_array_equal(chunked.inliers, whole.inliers)
    ours, theirs = chunked.report, whole.report
    assert (ours.points, ours.within) == (theirs.points, theirs.within)
    for name in ("rms", "max", "diagonal"):
        np.testing.assert_allclose(getattr(ours, name), getattr(theirs, name), rtol=1e-9)
    assert ours.percentiles.keys() == theirs.percentiles.keys()
    np.testing.assert_allclose([*ours.percentiles.values()], [*theirs.percentiles.values()])


def test_more_points_than_are_fitted_are_measured(tmp_path: Path, rng: np.random.Generator) -> None:
    count = (1 << 20) + 50_000
    path = tmp_path / "points.npy"
    np.save(path, wave(rng, count))
    mapped = np.load(path, mmap_mode="r")
    chunked = neurbs.reconstruct(mapped, grid=(8, 8))
    assert isinstance(chunked.distances, np.memmap)
    whole = neurbs.reconstruct(np.load(path), grid=(8, 8))
    np.testing.assert_allclose(chunked.distances, whole.distances, atol=1e-9)
    assert chunked.report.points == count
    assert whole.inliers.mean() > 0.999
    np.testing.assert_allclose(chunked.report.rms, whole.report.rms, rtol=1e-9)


def test_bad_chunks_are_refused() -> None:
    with pytest.raises(neurbs.NeurbsError, match="at least"):
        neurbs.reconstruct(iter([]))
    with pytest.raises(neurbs.NeurbsError, match="finite"):
        neurbs.reconstruct(iter([[[0.0, 0, 0], [1, np.nan, 0]]]))
    with pytest.raises(neurbs.NeurbsError, match="weights must be left out"):
        neurbs.reconstruct(iter([[[0.0, 0, 0]]]), weights=[1.0])


def farthest(surface: neurbs.NurbsSurface, truth: Points) -> float:
    """Return how far a surface leaves a densely sampled truth, as a share of its diagonal."""
    found = surface.tessellate(shape=(40, 40)).vertices
    apart = [np.linalg.norm(truth - place, axis=1).min() for place in found]
    return float(max(apart) / np.linalg.norm(np.ptp(truth, axis=0)))


@pytest.mark.parametrize("count", [8, 15, 40])
def test_surfaces_of_few_points_stay_near_them(count: int) -> None:
    def bump(u: Points, v: Points) -> Points:
        away = (u - 0.5) ** 2 + (v - 0.5) ** 2
        return np.column_stack([u, v, 0.25 * np.exp(-away / 0.08)])

    def saddle(u: Points, v: Points) -> Points:
        return np.column_stack([u, v, 0.5 * u**2 - 0.5 * v**2])

    def round_sheet(u: Points, v: Points) -> Points:
        angle = 4 * np.pi / 3 * u
        return np.column_stack([np.cos(angle), np.sin(angle), 3 * v])

    for place in [bump, saddle, round_sheet]:
        truth = place(*np.random.default_rng(9).random((2, 4000)))
        for seed in range(4):
            points = place(*np.random.default_rng(seed).random((2, count)))
            surface = neurbs.reconstruct(points).surface
            # Surfaces ran away by up to two diagonals, without a word.
            limit = 0.6 if count < 10 else 0.4
            assert farthest(surface, truth) < limit, (place.__name__, seed)


@pytest.mark.parametrize(("count", "limit"), [(200, 0.12), (400, 0.09)])
def test_sheets_of_few_points_end_near_them(count: int, limit: float) -> None:
    dense = np.random.default_rng(9).random((2, 20_000))
    for seed in range(5):
        u, v = np.hstack([np.random.default_rng(seed).random((2, count)), dense])
        angle = 3.6 * u
        sheet = np.column_stack([np.cos(angle), np.sin(angle), 2 * v + 0.1 * np.sin(4 * angle)])
        surface = neurbs.reconstruct(sheet[:count], topology="sheet").surface
        # Doubt where they end took corners of 400 points 0.18 beyond, and of 200 points 0.2.
        assert farthest(surface, sheet[count:]) < limit, seed


@pytest.mark.parametrize(
    ("count", "usual", "most"), [(100, 0.12, 0.4), (200, 0.07, 0.4), (400, 0.05, 0.15)]
)
def test_round_sheets_of_few_noisy_points_have_no_peaks(
    count: int, usual: float, most: float
) -> None:
    def dome(share: Points, way: Points) -> Points:
        steep, angle = 1.2 * np.sqrt(share), 2 * np.pi * way
        radius = np.sin(steep)
        return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.cos(steep)])

    truth = dome(*np.random.default_rng(9).random((2, 20_000)))
    far = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        points = dome(*rng.random((2, count))) + 0.01 * rng.standard_normal((count, 3))
        far.append(farthest(neurbs.reconstruct(points).surface, truth))
    # Corners of the surface were up to 0.7 away.
    assert max(far) < most, far
    assert np.median(far) < usual, far


def test_tubes_of_few_points_stay_near_them() -> None:
    for seed in range(8):
        u, v = np.random.default_rng(seed).random((2, 40))
        tube = np.column_stack([np.cos(2 * np.pi * u), np.sin(2 * np.pi * u), 3 * v])
        surface = neurbs.reconstruct(tube, topology="tube").surface
        found = surface.tessellate(shape=(40, 40)).vertices
        off = np.abs(np.hypot(found[:, 0], found[:, 1]) - 1)
        # One ran away by thousands of radii.
        assert np.sqrt(np.mean(off**2)) < 0.5


@pytest.mark.parametrize("share", [0.01, 0.1])
def test_values_for_no_data_are_left_out(rng: np.random.Generator, share: float) -> None:
    points = wave(rng, 2000)
    gone = rng.random(2000) < share
    points[gone, 2] = -9999
    with pytest.warns(ConvergenceWarning, match=f"{gone.sum()} points have z = -9999"):
        result = neurbs.reconstruct(points)
    np.testing.assert_array_equal(result.inliers, ~gone)
    assert result.report.outliers == gone.sum()
    assert result.distances[~gone].max() < 1e-3
    assert len(result.report.warnings) == 1


def scan_lines(count: int, each: int, rng: np.random.Generator) -> tuple[Points, Points]:
    """Return where points of so many lines lie: across them, and along them."""
    across = np.repeat((np.arange(count) + 0.5) / count, each)
    return across, rng.random(count * each)


@pytest.mark.parametrize("noise", [0.001, 0.003])
@pytest.mark.parametrize("shape", ["tube", "arch"])
def test_scan_lines_with_noise_are_one_surface(shape: str, noise: float) -> None:
    rng = np.random.default_rng(1)
    across, along = scan_lines(20, 200, rng)
    angle = (2 * np.pi if shape == "tube" else 2.5) * across
    points = np.column_stack([np.cos(angle), np.sin(angle), 3 * along])
    diagonal = np.linalg.norm(np.ptp(points, axis=0))
    points += noise * diagonal * rng.standard_normal(points.shape)
    result = neurbs.reconstruct(points)
    assert (result.report.topology == "tube") == (shape == "tube")
    turn = np.linspace(0.05, 0.95, 50) * (2 * np.pi if shape == "tube" else 2.5)
    angle, height = (x.ravel() for x in np.meshgrid(turn, np.linspace(0.1, 2.9, 30)))
    truth = np.column_stack([np.cos(angle), np.sin(angle), height])
    assert result.surface.closest_points(truth).distances.max() < 0.01 * diagonal


@pytest.mark.parametrize("shape", ["ground", "tube"])
def test_scan_lines_in_ropes_are_one_surface(shape: str) -> None:
    """Lines are ten times as far apart as their noise is wide, fifty times as points along them."""
    rng = np.random.default_rng(0)
    across, along = scan_lines(20, 1000, rng)

    def surface(across: Points, along: Points) -> Points:
        if shape == "ground":
            return np.column_stack([across, along, 0.1 * np.sin(5 * across) * np.cos(4 * along)])
        angle = 2 * np.pi * along
        return np.column_stack([np.cos(angle), np.sin(angle), 4 * across])

    points = surface(across, along)
    diagonal = np.linalg.norm(np.ptp(points, axis=0))
    points += 0.003 * diagonal * rng.standard_normal(points.shape)
    assert neurbs.pieces(points).sizes[0] > 0.99 * len(points)
    result = neurbs.reconstruct(points)
    assert not any("pieces" in warning for warning in result.report.warnings)
    across, along = (x.ravel() for x in np.meshgrid(*[np.linspace(0.05, 0.95, 40)] * 2))
    off = result.surface.closest_points(surface(across, along)).distances
    assert np.sqrt(np.mean(off**2)) < 0.003 * diagonal


def test_lines_far_apart_hold_a_smaller_net(rng: np.random.Generator) -> None:
    across, along = scan_lines(20, 1000, rng)
    points = np.column_stack([along, across, 0.15 * np.tanh(6 * along - 3 + np.sin(4 * across))])
    result = neurbs.reconstruct(points)
    assert result.report.rms < 1e-3 * result.report.diagonal


@pytest.mark.parametrize(("length", "count"), [(20, 600), (40, 1000), (60, 1500)])
@pytest.mark.parametrize("bend", [0.0, 1.5])
def test_long_pipes_of_few_points_are_tubes(length: float, count: int, bend: float) -> None:
    rng = np.random.default_rng(count)
    along, angle = length * rng.random(count), 2.0 * np.pi * rng.random(count)
    points = np.column_stack([np.cos(angle), np.sin(angle), along])
    radius = length / bend if bend else 0.0
    if bend:
        out, turn = radius + np.cos(angle), along / radius
        points = np.column_stack([out * np.cos(turn), out * np.sin(turn), np.sin(angle)])
    result = neurbs.reconstruct(points)
    assert result.report.topology == "tube"
    places = result.surface.evaluate(rng.random((2000, 2)))
    across = np.hypot(places[:, 0], places[:, 1]) - radius
    height = places[:, 2] if bend else 0.0
    off = np.abs(np.hypot(across, height) - 1.0)
    assert np.sqrt(np.mean(off**2)) < 0.01


@pytest.mark.parametrize("length", [2.0, 6.0, 20.0])
@pytest.mark.parametrize("narrower", [0.2, 0.5, 0.75])
def test_cups_that_stand_are_tubes_in_their_own_units(length: float, narrower: float) -> None:
    rng = np.random.default_rng(7)
    along, angle = rng.random(2000), 2.0 * np.pi * rng.random(2000)
    radius = 1.0 - narrower * along
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), length * along])
    result = neurbs.reconstruct(points)
    assert result.report.topology == "tube"
    assert not any("units" in warning for warning in result.report.warnings)
    assert result.report.rms < 1e-3


@pytest.mark.parametrize(
    ("count", "narrower", "noise"), [(600, 0.0, 0.0), (1500, 0.6, 0.0), (1500, 0.0, 0.05)]
)
def test_coils_are_tubes(count: int, narrower: float, noise: float) -> None:
    rng = np.random.default_rng(5)

    def coil(turn: Points, angle: Points) -> Points:
        # A pipe of radius 1 about one of 4, whose windings are 7 apart.
        radius = 1.0 - narrower * turn / (4.0 * np.pi)
        out, up = 4.0 + radius * np.cos(angle), radius * np.sin(angle) + 7.0 * turn / (2.0 * np.pi)
        return np.column_stack([out * np.cos(turn), out * np.sin(turn), up])

    points = coil(4.0 * np.pi * rng.random(count), 2.0 * np.pi * rng.random(count))
    points += noise * rng.standard_normal(points.shape)
    result = neurbs.reconstruct(points)
    assert result.report.topology == "tube"
    assert not result.report.warnings
    places = coil(rng.uniform(0.3, 4.0 * np.pi - 0.3, 2000), 2.0 * np.pi * rng.random(2000))
    off = result.surface.closest_points(places).distances
    assert np.sqrt(np.mean(off**2)) < max(0.01, 0.5 * noise)


def test_a_waist_of_few_points_is_a_tube() -> None:
    for seed in range(4):
        along, angle = np.random.default_rng(seed).random((2, 200))
        radius = np.cosh(2.0 * along - 1.0)
        angle *= 2.0 * np.pi
        points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 6.0 * along])
        result = neurbs.reconstruct(points)
        assert result.report.topology == "tube", seed
        assert result.report.rms < 1e-4 * result.report.diagonal, seed


def torus(rng: np.random.Generator, count: int, ratio: float) -> Points:
    """Scatter points evenly by area over a torus whose section has radius 1."""
    ring, section, chance = rng.random((3, 3000))
    kept = chance * (ratio + 1.0) < ratio + np.cos(2.0 * np.pi * section)
    ring, section = 2.0 * np.pi * ring[kept][:count], 2.0 * np.pi * section[kept][:count]
    out = ratio + np.cos(section)
    return np.column_stack([out * np.cos(ring), out * np.sin(ring), np.sin(section)])


@pytest.mark.parametrize("ratio", [3.0, 5.0])
@pytest.mark.parametrize("noise", [0.0, 0.005])
def test_tori_of_few_points_are_found(ratio: float, noise: float) -> None:
    for seed in range(3):
        rng = np.random.default_rng(seed)
        points = torus(rng, 700, ratio)
        points += noise * ratio * rng.standard_normal(points.shape)
        assert neurbs.detect_topology(points).kind == "torus", seed


@pytest.mark.parametrize(("count", "ratio"), [(300, 4.0), (400, 4.0), (400, 6.0)])
def test_tubes_whose_ends_meet_are_tori(count: int, ratio: float) -> None:
    found = []
    for seed in range(8):
        report = neurbs.reconstruct(torus(np.random.default_rng(seed), count, ratio)).report
        found.append(report.topology == "torus" and report.rms < 3e-3 * report.diagonal)
    # They were tubes around the ring, open along it.
    assert sum(found) >= 5, found


@pytest.mark.parametrize(("count", "ratio"), [(80, 2.0), (200, 1.5), (300, 2.0), (800, 1.3)])
@pytest.mark.parametrize("noise", [0.0, 0.003])
def test_thick_tori_of_few_points_are_tori(count: int, ratio: float, noise: float) -> None:
    found = []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        points = torus(rng, count, ratio)
        points += noise * 2.0 * (ratio + 1.0) * rng.standard_normal(points.shape)
        report = neurbs.reconstruct(points).report
        found.append(report.topology == "torus" and report.warnings == ())
    # They were sheets and tubes, many of them without a warning.
    assert sum(found) >= 5, found


@pytest.mark.parametrize("ratio", [2.0, 4.0])
def test_tori_that_are_asked_for_follow_few_points(ratio: float) -> None:
    for seed in range(3):
        points = torus(np.random.default_rng(seed), 120, ratio)
        surface = neurbs.reconstruct(points, topology="torus").surface
        places = surface.evaluate(np.random.default_rng(0).random((4000, 2)))
        from_ring = np.hypot(np.hypot(places[:, 0], places[:, 1]) - ratio, places[:, 2])
        # They passed through the middle of the section.
        assert np.abs(from_ring - 1.0).max() < 0.4, seed


@pytest.mark.parametrize("noise", [0.0, 0.005])
def test_other_closed_bodies_are_no_tori(noise: float) -> None:
    for seed, count in ((0, 80), (1, 150), (2, 300), (3, 600)):
        rng = np.random.default_rng(seed)
        sphere = rng.standard_normal((count, 3))
        sphere /= np.linalg.norm(sphere, axis=1)[:, None]
        cube = sphere / np.abs(sphere).max(axis=1)[:, None]
        for points in (sphere, cube, sphere * [1.0, 1.0, 3.0], sphere * [1.0, 1.0, 6.0]):
            size = np.linalg.norm(np.ptp(points, axis=0))
            noisy = points + noise * size * rng.standard_normal(points.shape)
            assert neurbs.reconstruct(noisy).report.topology != "torus", seed


def test_tori_of_few_points_are_the_same_in_another_frame() -> None:
    points = torus(np.random.default_rng(5), 150, 2.0)
    turn = Rotation.from_euler("xyz", [0.4, -1.1, 2.0]).as_matrix()
    first = neurbs.reconstruct(points)
    moved = neurbs.reconstruct(3.7 * points @ turn.T + [5.0, -3.0, 2.0])
    assert first.report.topology == moved.report.topology == "torus"
    places = np.random.default_rng(0).random((2000, 2))
    back = (moved.surface.evaluate(places) - [5.0, -3.0, 2.0]) @ turn / 3.7
    assert np.abs(back - first.surface.evaluate(places)).max() < 1e-9 * first.report.diagonal
    # Axes of different units are told of, and the kind is the same.
    points = torus(np.random.default_rng(0), 300, 2.0) * [1.0, 1.0, 1000.0]
    assert neurbs.reconstruct(points).report.topology == "torus"


@pytest.mark.parametrize(("columns", "rings"), [(8, 15), (12, 40), (24, 50)])
def test_pipes_measured_ring_by_ring_are_tubes(columns: int, rings: int) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, columns, endpoint=False)
    angle, along = (x.ravel() for x in np.meshgrid(angle, np.linspace(0.0, 20.0, rings)))
    points = np.column_stack([np.cos(angle), np.sin(angle), along])
    result = neurbs.reconstruct(points)
    assert result.report.topology == "tube"
    assert result.report.rms < 2e-4


@pytest.mark.parametrize(("columns", "rings", "bend"), [(24, 3, 0.0), (24, 5, 1.0), (40, 4, 0.0)])
@pytest.mark.parametrize("topology", ["auto", "tube"])
def test_a_few_rings_of_points_far_apart_are_a_tube(
    columns: int, rings: int, bend: float, topology: str
) -> None:
    rng = np.random.default_rng(0)
    ring = np.arange(rings).repeat(columns)
    angle = 2 * np.pi * (np.tile(np.arange(columns) / columns, rings) + rng.random(rings)[ring])
    radius, along = (6 / bend if bend else 0.0), 6.0 * ring / (rings - 1)
    out = radius + np.cos(angle)
    turn = along / radius if bend else np.zeros(len(ring))
    far = out * np.sin(turn) if bend else along
    points = np.column_stack([out * np.cos(turn), np.sin(angle), far])
    points += 0.003 * rng.standard_normal(points.shape)
    result = neurbs.reconstruct(points, topology=topology)
    assert result.report.topology == "tube"
    places = result.surface.evaluate(rng.random((2000, 2)))
    from_ring = np.hypot(places[:, 0], places[:, 2]) - radius if bend else places[:, 0]
    off = np.hypot(from_ring, places[:, 1]) - 1
    assert np.abs(off).max() < 0.1
    turned = Rotation.from_euler("xyz", [0.4, -1.1, 2.0]).as_matrix()
    moved = neurbs.reconstruct((3.7 * points @ turned.T + 2.0)[rng.permutation(len(points))])
    assert moved.report.topology == "tube"
    # At a corner of the domain, where the seam lies, as well as elsewhere.
    uv = np.array([[0.0, 0.0], [0.0, 1.0], [0.3, 0.6], [0.9, 0.1]])
    back = (moved.surface.evaluate(uv) - 2.0) @ turned / 3.7
    assert np.abs(back - result.surface.evaluate(uv)).max() < 1e-9 * result.report.diagonal


@pytest.mark.parametrize("length", [1.5, 4.0])
@pytest.mark.parametrize("seed", range(3))
def test_tubes_of_fifty_points_are_round(length: float, seed: int) -> None:
    rng = np.random.default_rng([50, seed])
    angle, along = 2 * np.pi * rng.random(50), length * rng.random(50)
    points = np.column_stack([np.cos(angle), np.sin(angle), along])
    for topology in ("auto", "tube"):
        result = neurbs.reconstruct(points, topology=topology)
        assert result.report.topology == "tube"
        places = result.surface.evaluate(rng.random((2000, 2)))
        off = np.hypot(places[:, 0], places[:, 1]) - 1
        # Before rings of the map had twelve nodes, the surface passed through the middle: 0.2.
        assert np.sqrt((off**2).mean()) < 0.03


def test_long_pipes_are_the_same_however_they_are_turned() -> None:
    rng = np.random.default_rng(11)
    along, angle = 1.5 * rng.random(600), 2.0 * np.pi * rng.random(600)
    out = 27.0 + np.cos(angle)
    points = np.column_stack([out * np.cos(along), out * np.sin(along), np.sin(angle)])
    turn = Rotation.from_euler("xyz", [0.4, -1.1, 2.0]).as_matrix()
    first = neurbs.reconstruct(points)
    moved = neurbs.reconstruct((3.7 * points @ turn.T + [5.0, -3.0, 2.0])[rng.permutation(600)])
    assert first.report.topology == moved.report.topology == "tube"
    places = rng.random((2000, 2))
    back = (moved.surface.evaluate(places) - [5.0, -3.0, 2.0]) @ turn / 3.7
    assert np.abs(back - first.surface.evaluate(places)).max() < 1e-9 * first.report.diagonal


@pytest.mark.parametrize("ratio", [2.0, 3.0, 4.0])
@pytest.mark.parametrize("side", [6, 8])
def test_tori_are_whole_on_small_nets(rng: np.random.Generator, ratio: float, side: int) -> None:
    along, around = 2 * np.pi * rng.random((2, 800))
    radius = ratio + np.cos(around)
    points = np.column_stack([radius * np.cos(along), radius * np.sin(along), np.sin(around)])
    found = neurbs.reconstruct(points, topology="torus", grid=(side, side)).report
    assert found.warnings == ()
    # A circle of which half a dozen control points make a curve is off by half a percent.
    assert found.rms < 2e-3 * found.diagonal


def test_a_surface_with_nothing_of_the_shape_of_its_points_is_told_of(
    rng: np.random.Generator,
) -> None:
    points = rng.standard_normal((400, 3))
    with pytest.warns(neurbs.ConvergenceWarning, match="no order was found"):
        neurbs.reconstruct(points, topology="height", robust=False, clean=False)
