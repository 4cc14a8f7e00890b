"""Clouds with outliers, duplicates, weights or closed shapes; height fields; chunks."""

import warnings
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs

Points = NDArray[np.float64]


def fold(rng: np.random.Generator, count: int, noise: float = 0.0) -> Points:
    """Scatter points over an S-shaped fold, which is no height field along any direction."""
    t, y = 3 * np.pi * (rng.random(count) - 0.5), 2 * rng.random(count)
    points = np.column_stack([np.sin(t), y, np.sign(t) * (np.cos(t) - 1)])
    return points + noise * rng.standard_normal(points.shape)


def wave(rng: np.random.Generator, count: int) -> Points:
    x, y = rng.random((2, count))
    return np.column_stack([x, y, 0.3 * np.sin(4 * x) * np.cos(3 * y)])


def test_gross_outliers_cost_next_to_nothing(rng: np.random.Generator) -> None:
    points = wave(rng, 3000)
    strays = rng.uniform([0, 0, -1], [1, 1, 1], (600, 3))
    spoiled = np.vstack([points, strays])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", neurbs.NeurbsWarning)
        clean = neurbs.reconstruct(points, grid=(12, 12))
        result = neurbs.reconstruct(spoiled, grid=(12, 12))
    far = result.surface.closest_points(points).distances
    assert np.sqrt(np.mean(far**2)) < 1.5 * clean.report.rms + 2e-4
    assert result.inliers[:3000].mean() > 0.98
    assert not result.inliers[3000:][np.abs(result.deviations[3000:]) > 0.05].any()
    assert result.report.outliers == (~result.inliers).sum()
    assert result.report.max == result.deviations[result.inliers].max()


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
    assert len(result.deviations) == 1800
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
    assert result.deviations[:100].min() > 0.05
    assert result.report.max < 0.01
    for wrong in (weights[:-1], -weights, np.full(1000, np.nan), np.zeros(1000)):
        with pytest.raises(neurbs.NeurbsError):
            neurbs.reconstruct(points, weights=wrong)


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
        assert result.report.kind == kind
        assert result.surface.closed == (kind in ("tube", "torus"), kind == "torus")
        assert result.report.rms < 2e-3 * result.report.diagonal


def test_fitted_weights_fit_a_cylinder_with_few_control_points(rng: np.random.Generator) -> None:
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
    np.testing.assert_allclose(second.deviations, first.deviations[order], atol=1e-9 * size)


def test_a_given_start_is_used(rng: np.random.Generator) -> None:
    points = wave(rng, 800)
    x, y = np.meshgrid(np.linspace(0, 1, 8), np.linspace(0, 1, 7), indexing="ij")
    nodes = np.dstack([x, y, np.zeros_like(x)])
    result = neurbs.reconstruct(points, grid=(8, 7), init=nodes, kind="tube")
    assert result.som.codebook_.shape == (8, 7, 3)
    for wrong in (nodes[0], "random"):
        with pytest.raises(neurbs.NeurbsError, match="init"):
            neurbs.reconstruct(points, init=wrong)  # type: ignore[arg-type]


def test_chunks_give_the_same_as_one_piece(rng: np.random.Generator) -> None:
    points = wave(rng, 5000) + np.array([5e6, 7e6, 0])
    whole = neurbs.reconstruct(points, 0.01)
    chunked = neurbs.reconstruct(iter(np.array_split(points, 7)), 0.01)
    np.testing.assert_array_equal(chunked.points, points)
    difference = chunked.surface.control_points - whole.surface.control_points
    assert np.abs(difference).max() < 1e-9 * whole.report.diagonal
    np.testing.assert_allclose(chunked.deviations, whole.deviations, atol=1e-9)
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
    assert isinstance(chunked.deviations, np.memmap)
    whole = neurbs.reconstruct(np.load(path), grid=(8, 8))
    np.testing.assert_allclose(chunked.deviations, whole.deviations, atol=1e-9)
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


@pytest.mark.parametrize("share", [0.01, 0.1])
def test_values_for_no_data_are_left_out(rng: np.random.Generator, share: float) -> None:
    points = wave(rng, 2000)
    gone = rng.random(2000) < share
    points[gone, 2] = -9999
    with pytest.warns(neurbs.NoDataWarning, match=f"{gone.sum()} points with .* value -9999"):
        result = neurbs.reconstruct(points)
    np.testing.assert_array_equal(result.inliers, ~gone)
    assert result.report.outliers == gone.sum()
    assert result.deviations[~gone].max() < 1e-3
    assert [found.code for found in result.report.diagnostics] == ["no-data"]
