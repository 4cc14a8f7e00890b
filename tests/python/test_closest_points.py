"""Closest points of surfaces with many valleys, beside dense sampling."""

import numpy as np
import pytest

import neurbs


# With 107 and 122 the two sides of a corner hold a valley each.
@pytest.mark.parametrize("seed", [107, 122, 140])
def test_no_sample_of_a_rough_surface_is_closer(seed: int) -> None:
    from scipy.spatial import cKDTree

    rng = np.random.default_rng(seed)
    rng.integers(1, 6, 2)
    net = rng.uniform(-1, 1, (*rng.integers(4, 9, 2), 3))
    surface = neurbs.NurbsSurface(net)
    points = rng.uniform(-1.5, 1.5, (1500, 3))
    feet = surface.closest_points(points)
    t = np.linspace(0, 1, 400)
    sampled = cKDTree(surface.evaluate_grid(t, t).reshape(-1, 3)).query(points)[0]
    assert (feet.distances <= sampled + 1e-12).all()
    assert feet.converged.all()
