"""Closest points of rough surfaces, compared with dense sampling."""

import numpy as np
import pytest

import neurbs


# For 107 and 122 there is a local minimum on both sides of a corner.
@pytest.mark.parametrize("seed", [107, 122, 140])
def test_no_sample_of_a_rough_surface_is_closer(seed: int) -> None:
    from scipy.spatial import cKDTree

    rng = np.random.default_rng(seed)
    rng.integers(1, 6, 2)
    net = rng.uniform(-1, 1, (*rng.integers(4, 9, 2), 3))
    surface = neurbs.NurbsSurface(net)
    points = rng.uniform(-1.5, 1.5, (1500, 3))
    projections = surface.closest_points(points)
    t = np.linspace(0, 1, 400)
    sampled = cKDTree(surface.evaluate_grid(t, t).reshape(-1, 3)).query(points)[0]
    assert (projections.distances <= sampled + 1e-12).all()
    assert projections.converged.all()
