"""Clouds that earlier versions fitted wrongly, with a property that each result must have."""

import itertools
import os
from collections.abc import Callable
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import cKDTree

import neurbs

Array = NDArray[np.float64]

HULL = Path(os.environ.get("NEURBS_DATA", ""), "npy", "yacht_hull.npy")

pytestmark = pytest.mark.filterwarnings("ignore::neurbs.NeurbsWarning")


FEW = pytest.mark.xfail(reason="a sheet through 300 points follows noise of this size")


SPARSE = pytest.mark.xfail(reason="two of its thirty sparse points are taken for outliers")


def seeds(own: int) -> list[int]:
    """Return the seed of the reported fault, and five others."""
    return [own, *(seed for seed in range(20, 25))]


def samples(surface: neurbs.NurbsSurface, side: int = 300) -> Array:
    """Return points of a surface on a grid of parameters, of shape (side, side, 3)."""
    u, v = (np.linspace(*ends, side) for ends in surface.domain)
    return surface.evaluate_grid(u, v)


def normals(surface: neurbs.NurbsSurface, side: int = 60) -> Array:
    """Return unit normals inside a surface, of shape (side, side, 3)."""
    inside = np.linspace(0.003, 0.997, side)
    u, v = (low + (high - low) * inside for low, high in surface.domain)
    return surface.normals_grid(u, v)[1]


def facets(surface: neurbs.NurbsSurface) -> tuple[Array, Array]:
    """Return the centers and areas of the cells of a grid of samples."""
    grid = samples(surface)
    a, b, c, d = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    areas = np.linalg.norm(np.cross(c - a, d - b), axis=2) / 2
    return ((a + b + c + d) / 4).reshape(-1, 3), areas.ravel()


def area(surface: neurbs.NurbsSurface) -> float:
    """Return the area of a surface, on a grid."""
    return float(facets(surface)[1].sum())


def mean_spacing(points: Array) -> float:
    """Return the mean spacing: the side of the square for one point, from 4 neighbors."""
    return float(np.median(cKDTree(points).query(points, k=5)[0][:, 4]) / 1.13)


def covered_share(mesh: neurbs.TriangleMesh, points: Array, spacings: float) -> float:
    """Return the share of a mesh's area within some mean spacings of a point."""
    corners = mesh.vertices[mesh.triangles]
    areas = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    near = cKDTree(points).query(corners.mean(axis=1))[0] <= spacings * mean_spacing(points)
    return float(areas[near].sum() / areas.sum())


def distances(surface: neurbs.NurbsSurface, truth: Array) -> Array:
    """Return the distances of a grid of the true surface to a surface."""
    return np.asarray(surface.closest_points(truth.reshape(-1, 3)).distances)


def error(surface: neurbs.NurbsSurface, truth: Array) -> float:
    """Return the rms distance to the true surface, without the largest 0.5 %."""
    all_ = np.sort(distances(surface, truth))
    return float(np.sqrt(np.mean(all_[: int(0.995 * len(all_))] ** 2)))


def turned_share(surface: neurbs.NurbsSurface) -> float:
    """Return the share of neighboring samples whose normals turn over."""
    unit = normals(surface)
    cosines = [np.sum(unit[1:] * unit[:-1], 2), np.sum(unit[:, 1:] * unit[:, :-1], 2)]
    return float(np.mean([np.mean(cosine < 0) for cosine in cosines]))


def assert_kept(result: neurbs.Reconstruction, tolerance: float) -> None:
    assert result.deviations.max() <= tolerance
    assert result.report.converged


def noisy_waves(number: int, sigma: float, seed: int) -> tuple[Array, Array]:
    """Return points of waves with noise in z, and a grid of the waves without noise."""
    rng = np.random.default_rng(seed)
    x, y = rng.random((2, number))
    points = np.column_stack(
        [x, y, 0.2 * np.sin(3 * x) * np.cos(2 * y) + rng.normal(0, sigma, number)]
    )
    x, y = np.meshgrid(np.linspace(0, 1, 60), np.linspace(0, 1, 60), indexing="ij")
    return points, np.stack([x, y, 0.2 * np.sin(3 * x) * np.cos(2 * y)], -1)


@pytest.mark.parametrize("seed", seeds(7))
def test_noise_beyond_the_spacing_leaves_the_surface_smooth(seed: int) -> None:
    points, truth = noisy_waves(3000, 0.04, seed)
    result = neurbs.reconstruct(points)
    assert result.report.valid
    assert turned_share(result.surface) == 0
    # The waves without noise have 1.057.
    assert area(result.surface) == pytest.approx(1.057, rel=0.05)
    asked = neurbs.reconstruct(points, kind="height")
    assert error(result.surface, truth) <= 1.3 * error(asked.surface, truth)


@pytest.mark.parametrize(
    ("sigma", "number"),
    [
        pytest.param(*case, marks=FEW) if case == (0.08, 300) else case
        for case in itertools.product([0.02, 0.04, 0.08, 0.15], [300, 3000, 30_000])
    ],
)
def test_noise_of_any_size_costs_little_against_a_height_field(sigma: float, number: int) -> None:
    points, truth = noisy_waves(number, sigma, 7)
    result = neurbs.reconstruct(points)
    asked = neurbs.reconstruct(points, kind="height")
    assert result.report.valid
    assert asked.report.valid
    assert error(result.surface, truth) <= 1.3 * error(asked.surface, truth)


@pytest.mark.parametrize(
    "seed",
    [seed if seed != 20 else pytest.param(seed, marks=SPARSE) for seed in seeds(0)],
)
def test_sparse_regions_are_kept(seed: int) -> None:
    rng = np.random.default_rng(seed)
    dense, sparse = rng.random((1500, 2)) * [0.3, 1], rng.random((30, 2)) * [0.7, 1] + [0.3, 0]
    xy = np.vstack([dense, sparse])
    points = np.column_stack([xy, 0.3 * np.sin(3 * xy[:, 0]) * np.cos(2 * xy[:, 1])])
    result = neurbs.reconstruct(points)
    assert result.inliers.all()
    # The last of 30 random points is slightly before x = 1.
    assert samples(result.surface)[..., 0].max() >= points[:, 0].max() - 0.01


@pytest.mark.xfail(reason="the surface through six points overshoots")
def test_six_exact_points_keep_a_tolerance() -> None:
    points = np.array(
        [
            (0.7, 0.9, 3),
            (5.3, 0.6, 4),
            (3.3, 3.1, 7),
            (7.8, 2.1, 12),
            (2.2, 4.8, 18),
            (7.3, 4.2, 9),
        ]
    )
    assert_kept(neurbs.reconstruct(points, tolerance=0.01), 0.01)


@pytest.mark.parametrize("seed", seeds(1))
def test_a_tolerance_above_the_largest_deviation_is_kept(seed: int) -> None:
    x, y = np.random.default_rng(seed).random((2, 20))
    points = np.column_stack([x, y, np.sin(3 * x) * np.cos(2 * y) + 0.3 * x])
    tolerance = 1.5 * neurbs.reconstruct(points).deviations.max()
    assert_kept(neurbs.reconstruct(points, tolerance=tolerance), tolerance)


@pytest.mark.parametrize("seed", seeds(1))
def test_normals_of_a_tube_point_outward(seed: int) -> None:
    angle, height = np.random.default_rng(seed).random((2, 1200)) * [[2 * np.pi], [4]]
    radius = 1 + 0.3 * np.sin(height)
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])
    surface = neurbs.reconstruct(points).surface
    inside = np.linspace(0.003, 0.997, 60)
    u, v = (low + (high - low) * inside for low, high in surface.domain)
    radial = surface.evaluate_grid(u, v)[..., :2]
    outward = np.sum(normals(surface)[..., :2] * radial, axis=2)
    assert (outward > 0).all()


@pytest.mark.parametrize("seed", seeds(2))
def test_the_surface_of_three_faces_of_a_cube_stays_near_the_points(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = rng.random((2, 3000)) * 50
    face, zero = rng.integers(0, 3, 3000)[:, None], 0 * a
    faces = [np.column_stack(columns) for columns in ([a, b, zero], [a, zero, b], [zero, a, b])]
    points = np.where(face == 0, faces[0], np.where(face == 1, faces[1], faces[2]))
    result = neurbs.reconstruct(points)
    assert covered_share(result.mesh, points, 2) >= 0.99


def test_a_half_pipe_without_a_border_ends_at_its_points() -> None:
    angle, along = np.meshgrid(np.linspace(0, np.pi, 32), np.linspace(0, 4, 41), indexing="ij")
    grid = np.stack([np.cos(angle), np.sin(angle), along], -1)
    points = grid.reshape(-1, 3)
    surface = neurbs.reconstruct(points, border=0).surface
    places = samples(surface).reshape(-1, 3)
    slack = 0.1 * mean_spacing(points)
    assert (places >= points.min(axis=0) - slack).all()
    assert (places <= points.max(axis=0) + slack).all()
    assert distances(surface, grid).max() <= slack


def sweeps(seed: int) -> Array:
    """Return points of five narrow sweeps across x, far from each other."""
    rng = np.random.default_rng(seed)
    x = np.repeat([100, 300, 500, 700, 900.0], 100) + rng.normal(0, 3, 500)
    y = rng.uniform(-10, 10, 500)
    return np.column_stack([x, y, x / 20 * np.sin(y / 3)])


@pytest.mark.parametrize("tolerance", [None, 1.0])
@pytest.mark.parametrize("seed", seeds(0))
def test_between_sweeps_the_surface_stays_at_the_truth(seed: int, tolerance: float | None) -> None:
    points = sweeps(seed)
    surface = neurbs.reconstruct(points, tolerance).surface
    low, high = points.min(axis=0), points.max(axis=0)
    x, y = np.meshgrid(np.linspace(100, 900, 81), np.linspace(low[1], high[1], 81), indexing="ij")
    truth = np.stack([x, y, x / 20 * np.sin(y / 3)], -1)
    assert distances(surface, truth).max() <= 1
    # The distance to the true surface, to first order.
    places = samples(surface).reshape(-1, 3)
    x, y, z = places[((places >= low) & (places <= high))[:, :2].all(axis=1)].T
    slope = np.hypot(np.sin(y / 3) / 20, x / 60 * np.cos(y / 3))
    assert (abs(z - x / 20 * np.sin(y / 3)) / np.hypot(1, slope)).max() <= 1


@pytest.mark.parametrize("seed", seeds(0))
def test_kind_height_has_one_height_at_each_place(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(0, 0.25, 22), rng.uniform(0, 0.9, 22)
    z = np.where(rng.random(22) < 0.25, rng.uniform(0.3, 1, 22), 0.0)
    result = neurbs.reconstruct(np.column_stack([x, y, z]), kind="height")
    assert result.report.kind == "height"
    # One z for each (x, y): no normal is horizontal.
    assert (normals(result.surface)[..., 2] > 0).all()
    extent = np.ptp(samples(result.surface).reshape(-1, 3), axis=0)
    assert (extent[:2] >= 0.9 * np.ptp([x, y], axis=1)).all()


@pytest.mark.parametrize(
    "tolerance",
    [
        None,
        pytest.param(
            1e-6,
            marks=pytest.mark.xfail(
                reason="points are 3.6e-5 away: four points do not tell the fairness of heights"
            ),
        ),
    ],
)
def test_four_points_make_a_surface(tolerance: float | None) -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 2.0]])
    result = neurbs.reconstruct(points, tolerance)
    assert np.isfinite(result.surface.control_points).all()
    if tolerance:
        assert_kept(result, tolerance)


def test_a_height_field_leaves_out_the_same_outliers_as_the_default() -> None:
    i, j = np.mgrid[0:9, 0:9]
    outlier = abs(i - 4) + abs(j - 4) >= 7
    z = np.where(outlier, 130 + 0.1 * ((i + 2 * j) % 5), 0.05 * i * j / 8)
    points = np.column_stack([10.0 * i.ravel(), 10.0 * j.ravel(), z.ravel()])
    kinds: tuple[Literal["auto", "height"], ...] = ("auto", "height")
    default, asked = (neurbs.reconstruct(points, kind=kind) for kind in kinds)
    good = ~outlier.ravel()
    np.testing.assert_array_equal(default.inliers, good)
    np.testing.assert_array_equal(asked.inliers, good)
    assert asked.deviations[good].max() <= max(1.3 * default.deviations[good].max(), 0.01)


def test_duplicates_are_merged_and_count_as_often() -> None:
    x, y = np.random.default_rng(3).random((2, 400))
    rng = np.random.default_rng(4)
    points = np.column_stack([x, y, np.sin(3 * x) * np.cos(2 * y) + rng.normal(0, 0.05, 400)])
    often = np.where(x < 0.3, 4, 1)
    repeated = np.concatenate([points, *([points[x < 0.3]] * 3)])
    result = neurbs.reconstruct(repeated)
    merged = np.concatenate([result.inliers[:400], *([result.inliers[:400][x < 0.3]] * 3)])
    np.testing.assert_array_equal(result.inliers, merged)
    assert result.inliers.mean() > 0.98
    weighted = neurbs.reconstruct(points, weights=often)
    np.testing.assert_allclose(
        result.surface.control_points, weighted.surface.control_points, atol=1e-9
    )


def in_cube(rng: np.random.Generator) -> Array:
    return rng.random((2000, 3))


def in_ball(rng: np.random.Generator) -> Array:
    points: Array = rng.uniform(-1, 1, (4000, 3))
    inside: Array = points[np.linalg.norm(points, axis=1) < 1]
    return inside


def in_slab(rng: np.random.Generator) -> Array:
    return rng.random((2000, 3)) * [1, 1, 0.7]


@pytest.mark.parametrize("volume", [in_cube, in_ball, in_slab])
def test_points_that_fill_a_volume_have_no_valid_surface(
    volume: Callable[[np.random.Generator], Array], rng: np.random.Generator
) -> None:
    report = neurbs.reconstruct(volume(rng)).report
    assert not report.valid
    assert report.diagnostics


@pytest.mark.skipif(not HULL.exists(), reason="NEURBS_DATA names no folder with yacht_hull.npy")
def test_a_tolerance_does_not_take_the_surface_away_from_a_hull() -> None:
    points = np.load(HULL)
    without, with_ = neurbs.reconstruct(points), neurbs.reconstruct(points, tolerance=0.1)
    for size in (np.max, lambda deviations: np.sqrt(np.mean(deviations**2))):
        assert size(with_.deviations) <= 1.01 * size(without.deviations)


def test_a_wound_ribbon_keeps_its_area_or_is_reported() -> None:
    rng = np.random.default_rng(0)
    t = rng.uniform(0, 30, 3000)
    points = np.column_stack([np.cos(t), np.sin(t), 0.3 * t + rng.random(3000)])
    result = neurbs.reconstruct(points)
    assert area(result.surface) == pytest.approx(30, rel=0.1) or result.report.diagnostics


def test_squares_that_cross_are_reported(rng: np.random.Generator) -> None:
    a, b = rng.uniform(-1, 1, (2, 3000))
    flat, upright = np.column_stack([a, b, 0 * a]), np.column_stack([a, 0 * a, b])
    points = np.where(rng.random(3000)[:, None] < 0.5, flat, upright)
    assert neurbs.reconstruct(points).report.diagnostics


def test_kind_torus_for_a_flat_sheet_is_reported(rng: np.random.Generator) -> None:
    x, y = rng.random((2, 1000))
    points = np.column_stack([x, y, 0.1 * np.sin(3 * x)])
    report = neurbs.reconstruct(points, kind="torus").report
    assert report.kind == "torus"
    assert report.diagnostics
