"""Closest points, compared with dense samples and closed forms."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial import cKDTree

import neurbs


def folded() -> neurbs.NurbsSurface:
    """Make a sheet that folds over and comes near itself."""
    s = np.linspace(0, 1, 12)
    turn = 4.5 * s
    x, z = (1 + 0.3 * s) * np.cos(turn), (1 + 0.3 * s) * np.sin(turn)
    y = np.linspace(0, 2, 6)
    net = np.stack(
        [
            np.repeat(x[:, None], 6, 1),
            np.repeat(y[None], 12, 0),
            np.repeat(z[:, None], 6, 1) + 0.1 * np.sin(3 * y),
        ],
        axis=-1,
    )
    return neurbs.NurbsSurface(net, np.random.default_rng(5).uniform(0.5, 2, (12, 6)))


@pytest.mark.parametrize(
    "surface",
    [
        folded(),
        neurbs.NurbsSurface.torus([0, 0, 0], 1, 0.4),
        neurbs.NurbsSurface.sphere([0.1, 0, 0], 1),
        neurbs.NurbsSurface.cone([0, 0, -1], [0, 0, 2], 1),
        (3, 2),
        (1, 1),
    ],
    ids=["folded", "torus", "sphere", "cone", "rough", "facets"],
)
def test_no_sample_is_closer_than_the_closest_point(
    surface: neurbs.NurbsSurface | tuple[int, int],
    random_surface: Callable[[tuple[int, int], int], neurbs.NurbsSurface],
) -> None:
    if isinstance(surface, tuple):
        surface = random_surface(surface, 4)
    points = np.random.default_rng(1).uniform(-1.7, 1.7, (400, 3))
    projections = surface.closest_points(points)
    # Newton's method does not always converge within its steps, but the distances, which are
    # compared above, are right.
    assert projections.converged.mean() > 0.99
    np.testing.assert_allclose(
        surface.evaluate(projections.uv), projections.points, rtol=0, atol=1e-13
    )
    distances = np.linalg.norm(projections.points - points, axis=1)
    np.testing.assert_allclose(projections.distances, distances, rtol=0, atol=1e-14)
    t = np.linspace(0, 1, 500)
    samples = surface.evaluate_grid(t, t).reshape(-1, 3)
    sampled = cKDTree(samples).query(points)[0]
    assert (projections.distances <= sampled + 1e-12).all()


def test_closest_points_of_a_torus_are_exact() -> None:
    torus = neurbs.NurbsSurface.torus([0, 0, 0], 3, 1)
    points = np.random.default_rng(2).uniform(-5, 5, (2000, 3))
    ring = np.hypot(points[:, 0], points[:, 1])
    exact = np.abs(np.hypot(ring - 3, points[:, 2]) - 1)
    projections = torus.closest_points(points)
    np.testing.assert_allclose(projections.distances, exact, rtol=0, atol=1e-12)
    # The surface continues across its seams.
    beside = torus.closest_points([[4.5, 1e-9, 0.3], [4.5, -1e-9, 0.3]])
    np.testing.assert_allclose(beside.distances[0], beside.distances[1], rtol=0, atol=1e-9)
