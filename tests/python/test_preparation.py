"""The preparation of points: cleaning, components, even samples."""

import os
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs

Points = NDArray[np.float64]

FOLDER = os.environ.get("NEURBS_DATA")

needs_data = pytest.mark.skipif(not FOLDER, reason="NEURBS_DATA names no folder of point clouds")


def real(name: str) -> Points:
    """Read one of the clouds that are not part of this repository."""
    assert FOLDER is not None
    points: Points = np.load(Path(FOLDER, "npy", f"{name}.npy"))
    return points


def wave(rng: np.random.Generator, count: int, noise: float = 0.0) -> Points:
    """Scatter points over a wavy sheet, with noise as a share of its diagonal."""
    x, y = rng.random((2, count))
    points = np.column_stack([x, y, np.sin(3 * x) * np.cos(2 * y)])
    return points + noise * 1.9 * rng.standard_normal(points.shape)


def rolled(rng: np.random.Generator, count: int, share: float, noise: float = 0.0) -> Points:
    """Scatter points over a share of a cylinder of radius 1 and height 2."""
    turn, z = rng.random((2, count))
    angle = 2 * np.pi * share * turn
    points = np.column_stack([np.cos(angle), np.sin(angle), 2 * z])
    return points + noise * 3.5 * rng.standard_normal(points.shape)


def with_outliers(rng: np.random.Generator, points: Points, share: float) -> Points:
    """Replace a share of the points, the first ones, by uniform scatter in a larger box."""
    low, size = points.min(axis=0), np.ptp(points, axis=0)
    points = points.copy()
    count = int(share * len(points))
    points[:count] = low - 0.1 * size + 1.2 * size * rng.random((count, 3))
    return points


def test_most_gross_outliers_go_and_the_surface_stays(rng: np.random.Generator) -> None:
    points = with_outliers(rng, wave(rng, 20_000, 0.005), 0.2)
    outliers = neurbs.clean(points).outliers
    assert (outliers < 4000).sum() > 0.85 * 4000
    assert (outliers >= 4000).sum() <= 0.002 * 16_000


def test_duplicates_become_weights(rng: np.random.Generator) -> None:
    points = wave(rng, 500)
    shuffled = rng.permutation(np.repeat(points, 7, axis=0))
    cleaning = neurbs.clean(shuffled)
    assert len(cleaning.kept) == 500
    assert len(cleaning.duplicates) == 3000
    np.testing.assert_array_equal(cleaning.weights, 7)
    np.testing.assert_allclose(cleaning.spacing, neurbs.clean(points).spacing)


def test_a_cleaned_cloud_does_not_depend_on_the_order(rng: np.random.Generator) -> None:
    points = with_outliers(rng, rolled(rng, 3000, 0.7, 0.002), 0.1)
    order = rng.permutation(len(points))
    kept = neurbs.clean(points).kept
    again = np.sort(order[neurbs.clean(points[order]).kept])
    np.testing.assert_array_equal(kept, again)


@needs_data
def test_nothing_is_dropped_from_real_clouds_but_strays() -> None:
    for name, most in [
        ("jacksboro_dem", 0),
        ("claudius_h330", 0),
        ("mediapipe_face", 0),
        ("yacht_hull", 0),
        ("milk_carton", 5),
        ("soybean_leaf", 15),
    ]:
        assert len(neurbs.clean(real(name)).outliers) <= most, name
    assert neurbs.components(real("soybean_leaf")).sizes[0] > 5900
    assert neurbs.components(real("yacht_hull")).sizes == [1282]


def test_an_even_sample_depends_on_the_points_alone(rng: np.random.Generator) -> None:
    points = rng.standard_normal((50_000, 3))
    whole, chunks = neurbs.EvenSample(1000), neurbs.EvenSample(1000)
    whole.extend(points)
    for chunk in np.array_split(points, 17):
        chunks.extend(chunk)
    np.testing.assert_array_equal(whole.points, chunks.points)
    np.testing.assert_array_equal(points[whole.indices], whole.points)
    assert 250 <= len(whole.points) <= 1000


@pytest.mark.parametrize("stage", [neurbs.clean, neurbs.components, neurbs.candidates])
def test_bad_points_are_refused(stage: object) -> None:
    assert callable(stage)
    with pytest.raises(neurbs.NeurbsError, match="must be finite"):
        stage([[0, 0, 0], [1, 0, 0], [0, 1, np.nan], [1, 1, 0]])
    with pytest.raises(neurbs.NeurbsError, match="distinct"):
        stage([[0, 0, 0], [1, 0, 0]])


def test_progress_can_stop_it(rng: np.random.Generator) -> None:
    def stop(progress: neurbs.Progress) -> None:
        raise RuntimeError(progress.stage)

    with pytest.raises(RuntimeError, match="checking"):
        neurbs.clean(wave(rng, 50_000), progress=stop)
