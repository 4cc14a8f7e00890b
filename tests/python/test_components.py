"""Clouds of several components."""

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs

Points = NDArray[np.float64]


def wave(rng: np.random.Generator, count: int) -> Points:
    x, y = rng.random((2, count))
    return np.column_stack([x, y, 0.3 * np.sin(4 * x) * np.cos(3 * y)])


def test_components_are_chosen_or_fitted_each(rng: np.random.Generator) -> None:
    large, small = wave(rng, 900), wave(rng, 300) + np.array([0, 3, 0])
    points = np.vstack([small, large])
    with pytest.warns(neurbs.ComponentsWarning, match="2 components of 900, 300 points"):
        together = neurbs.reconstruct(points, grid=(8, 8))
    assert together.inliers.sum() > 1000
    (found,) = (f for f in together.report.diagnostics if f.code == "components")
    assert found.data == {"sizes": [900, 300]}
    first = neurbs.reconstruct(points, grid=(8, 8), component=0)
    np.testing.assert_array_equal(np.flatnonzero(first.inliers), np.arange(300, 1200))
    assert first.report.max < 0.01
    each = neurbs.reconstruct(points, grid=(8, 8), component="each")
    assert [result.inliers.sum() for result in each] == [900, 300]
    assert [result.report.inliers for result in each] == [900, 300]
    assert "1,200, 300 of them used" in str(each[1].report)
    wrong: int | str
    for wrong in (2, -1, "all"):
        with pytest.raises(neurbs.NeurbsError, match="component"):
            neurbs.reconstruct(points, component=wrong)  # type: ignore[arg-type]
