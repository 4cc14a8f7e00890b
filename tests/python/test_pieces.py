"""Clouds in pieces: one surface for all where one can be, the largest alone where none can."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs
from neurbs import ConvergenceWarning

Points = NDArray[np.float64]


def wave(rng: np.random.Generator, count: int) -> Points:
    x, y = rng.random((2, count))
    return np.column_stack([x, y, 0.3 * np.sin(4 * x) * np.cos(3 * y)])


def plates(rng: np.random.Generator) -> Points:
    """Scatter points over two standing plates, the first a third larger."""
    along, y = 2 * rng.random(2800), 2 * rng.random(2800)
    side = np.repeat([0.3, -0.3], [1600, 1200])
    return np.column_stack([side + 0.03 * np.sin(3 * y), y, along])


def roll_and_stray(rng: np.random.Generator) -> Points:
    """Scatter points over a roll of one and a half turns and, far from it, a few about a point."""
    t, y = rng.uniform(1.5 * np.pi, 4.5 * np.pi, 3000), 21 * rng.random(3000)
    stray = np.array([30, 10, 0]) + rng.normal(0, 0.3, (20, 3))
    return np.vstack([np.column_stack([t * np.cos(t), y, t * np.sin(t)]), stray])


def layers(rng: np.random.Generator) -> Points:
    """Scatter points over five waves above each other, each less even than the one below."""
    found = []
    for layer in range(5):
        points = wave(rng, 1200 - 100 * layer)
        points[:, 2] += 0.3 * layer + 0.02 * layer * np.sin(5 * points[:, 0])
        found.append(points)
    return np.vstack(found)


def test_pieces_are_chosen_or_fitted_each(rng: np.random.Generator) -> None:
    large, small = wave(rng, 900), wave(rng, 300) + np.array([0, 3, 0])
    points = np.vstack([small, large])
    with pytest.warns(ConvergenceWarning, match="2 pieces"):
        together = neurbs.reconstruct(points, grid=(8, 8))
    assert together.inliers.sum() > 1000
    first = neurbs.reconstruct(points, grid=(8, 8), pieces=0)
    np.testing.assert_array_equal(np.flatnonzero(first.inliers), np.arange(300, 1200))
    assert first.report.max < 0.01
    each = neurbs.reconstruct(points, grid=(8, 8), pieces="each")
    assert [result.inliers.sum() for result in each] == [900, 300]
    assert [result.report.inliers for result in each] == [900, 300]
    assert "1,200, 300 of them count" in str(each[1].report)
    wrong: int | str
    for wrong in (2, -1, "all"):
        with pytest.raises(neurbs.NeurbsError, match="pieces"):
            neurbs.reconstruct(points, pieces=wrong)


def test_layers_are_told_though_few_points_show_none(rng: np.random.Generator) -> None:
    x, y = rng.random((2, 6000))
    height = 0.1 * np.sin(3 * x) * np.cos(2 * y) + np.repeat([0, 4 / np.sqrt(3000)], 3000)
    with pytest.warns(ConvergenceWarning, match="2 pieces"):
        neurbs.reconstruct(np.column_stack([x, y, height]), grid=(8, 8))


def two_waves(rng: np.random.Generator, spacings: float) -> Points:
    """Scatter points over a wave and, so many spacings above, another."""
    points, above = wave(rng, 3000), rng.random(3000) < 0.5
    points[above, 2] += spacings / np.sqrt(1500)
    return points


def test_one_of_two_near_layers_is_better_than_the_middle(rng: np.random.Generator) -> None:
    with pytest.warns(ConvergenceWarning, match="largest alone"):
        found = neurbs.reconstruct(two_waves(rng, 4))
    assert 1400 < found.inliers.sum() < 1600
    assert found.report.max < 0.01


def test_layers_that_cannot_be_told_apart_are_told_of(rng: np.random.Generator) -> None:
    for spacings, told in ((1, "closer than the spacing"), (3, "the surface passes near")):
        with pytest.warns(ConvergenceWarning, match=told):
            neurbs.reconstruct(two_waves(rng, spacings))


@pytest.mark.parametrize(
    ("cloud", "largest"), [(plates, 1600), (roll_and_stray, 3000), (layers, 1200)]
)
def test_what_no_surface_spans_gives_the_largest_piece(
    cloud: Callable[[np.random.Generator], Points], largest: int
) -> None:
    points = cloud(np.random.default_rng(0))
    with pytest.warns(ConvergenceWarning, match="one of the largest alone") as caught:
        result = neurbs.reconstruct(points)
    assert len(caught) == 1
    near = np.flatnonzero(result.inliers)
    assert len(near) > 0.99 * largest
    assert near.max() < largest
    assert result.report.rms < 1e-3 * result.report.diagonal
    assert result.report.max < 0.01 * result.report.diagonal


@pytest.mark.parametrize("seed", range(3))
def test_stray_points_are_no_pieces(seed: int) -> None:
    rng = np.random.default_rng(seed)
    u, v = rng.random((2, 3000))
    ground = np.column_stack([2 * u, 1.5 * v, 0.3 * np.sin(5 * u) * np.cos(4 * v)])
    stray = rng.uniform([-0.2, -0.5, -1.2], [2.2, 2, 1.2], (300, 3))
    points = np.concatenate([ground, stray])
    # Cleaning leaves some of them, each by itself.
    kept = points[neurbs.clean(points).kept]
    assert len(neurbs.pieces(kept).sizes) > 1
    result = neurbs.reconstruct(points)
    assert not result.report.warnings
    assert result.report.rms < 1e-4 * result.report.diagonal


def test_a_few_strays_beside_many_points_are_no_piece(rng: np.random.Generator) -> None:
    stray = np.array([3, 0.5, 0.5]) + rng.normal(0, 0.01, (8, 3))
    points = np.vstack([wave(rng, 10_000), stray])
    kept = points[neurbs.clean(points).kept]
    assert min(neurbs.pieces(kept).sizes) > 3
    result = neurbs.reconstruct(points, grid=(8, 8))
    assert not result.report.warnings
