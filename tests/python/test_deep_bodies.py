"""Bodies that are longer than wide, with one opening or two."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

import neurbs

Array = NDArray[np.float64]
Profile = Callable[[Array], tuple[Any, Any]]


def thimble(share: Array) -> tuple[Array, Array]:
    way = (np.pi / 2 + 2) * share
    angle = np.minimum(way, np.pi / 2)
    return np.sin(angle), np.maximum(way - np.pi / 2, 0) - np.cos(angle)


def funnel(narrow: float, height: float) -> Profile:
    return lambda share: (narrow + (1.2 - narrow) * share, height * share)


BODIES: dict[str, Profile] = {
    "cone": lambda share: (share, 4 * share),
    "paraboloid": lambda share: (share, 3 * share**2),
    "thimble": thimble,
}


def scattered(profile: Profile, count: int, rng: np.random.Generator) -> Array:
    """Return points evenly on the surface that a profile (radius, height) goes round."""
    share = rng.random(20 * count)
    radius, height = profile(share)
    ahead = profile(share + 1e-6)
    area = radius * np.hypot(ahead[0] - radius, ahead[1] - height)
    share = rng.choice(share, count, replace=False, p=area / area.sum())
    radius, height = profile(share)
    angle = 2 * np.pi * rng.random(count)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])


def apart(a: Array, b: Array) -> float:
    """Return how far the farthest of some points is from others, as a share of their diagonal."""
    return float(cKDTree(b).query(a)[0].max() / np.linalg.norm(np.ptp(b, axis=0)))


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("noise", [0, 0.004])
def test_bodies_with_an_opening_end_at_its_rim(name: str, noise: float) -> None:
    truth = scattered(BODIES[name], 20_000, np.random.default_rng(9))
    for seed in range(3):
        rng = np.random.default_rng(seed)
        points = scattered(BODIES[name], 2000, rng) + noise * rng.standard_normal((2000, 3))
        turn = Rotation.random(random_state=seed).as_matrix()
        result = neurbs.reconstruct(points @ turn)
        surface = result.surface.tessellate(shape=(80, 80)).vertices @ turn.T
        # Points of the truth are 0.01 apart; corners of the surface were up to 0.3 away.
        assert apart(surface, truth) < 0.03, seed
        assert apart(points, surface) < 0.03, seed
        assert result.report.rms < (0.001 + noise) * result.report.diagonal
        assert not any("folds over" in warning for warning in result.report.warnings), seed


@pytest.mark.parametrize(("narrow", "height"), [(0.8, 0.8), (0.6, 1.6), (0.4, 1.6)])
def test_funnels_are_tubes(narrow: float, height: float) -> None:
    truth = scattered(funnel(narrow, height), 20_000, np.random.default_rng(9))
    turn = Rotation.random(random_state=3).as_matrix()
    for noise in (0, 0.003):
        rng = np.random.default_rng(3)
        points = scattered(funnel(narrow, height), 2000, rng)
        points += noise * rng.standard_normal(points.shape)
        result = neurbs.reconstruct(points @ turn)
        assert result.report.topology == "tube"
        surface = result.surface.tessellate(shape=(80, 80)).vertices @ turn.T
        # Heights over a ring filled what it leaves open, up to 0.34 away.
        assert apart(surface, truth) < 0.03


@pytest.mark.parametrize("noise", [0, 0.004])
def test_long_bent_pipes_are_tubes(noise: float) -> None:
    for seed in range(4):
        rng = np.random.default_rng(100 * seed + 1000)
        around, along = 2 * np.pi * rng.random(1000), 3 * rng.random(1000)
        radius = 5 + np.cos(around)
        pipe = np.column_stack([radius * np.cos(along), radius * np.sin(along), np.sin(around)])
        pipe += noise * np.linalg.norm(np.ptp(pipe, axis=0)) * rng.standard_normal(pipe.shape)
        turn = Rotation.random(random_state=seed).as_matrix()
        assert neurbs.detect_topology(pipe @ turn).kind == "tube", seed


@pytest.mark.parametrize(("radii", "count"), [(20, 1000), (30, 1500), (40, 2500)])
@pytest.mark.parametrize("bend", [0, 1.5])
@pytest.mark.filterwarnings("ignore::neurbs.ConvergenceWarning")
def test_pipes_with_hardly_any_border_are_tubes(radii: float, count: int, bend: float) -> None:
    met = 0
    for seed in range(8):
        rng = np.random.default_rng(seed)
        around, along = 2 * np.pi * rng.random(count), radii * rng.random(count)
        x, y, z = np.cos(around), np.sin(around), along
        if bend:
            # Bent to an arc of so many radians.
            middle = radii / bend
            x, z = (middle + x) * np.cos(along / middle), (middle + x) * np.sin(along / middle)
        report = neurbs.reconstruct(np.column_stack([x, y, z])).report
        met += report.topology == "tube" and report.rms < 1e-3
    # All were sheets around the pipe, 1e-3 to 1e-1 from their points.
    assert met >= 5


def test_tips_of_eggs_and_capsules_open_or_closed_are_no_ends_of_pipes() -> None:
    for seed in range(4):
        rng = np.random.default_rng(seed)
        ball = rng.standard_normal((4000, 3))
        ball /= np.linalg.norm(ball, axis=1)[:, None]
        egg = (ball * [1, 1, 1.4])[ball[:, 2] < 0.9][:2000]
        capsule = ball[:1500] + np.where(ball[:1500, 2:] > 0, [0, 0, 4], 0)
        around, along = 2 * np.pi * rng.random(1500), 4 * rng.random(1500)
        middle = np.column_stack([np.cos(around), np.sin(around), along])
        for body in (egg, np.concatenate([capsule, middle])):
            assert neurbs.detect_topology(body).kind == "sheet", seed


def test_steep_grounds_and_slopes_with_holes_are_no_tubes() -> None:
    rng = np.random.default_rng(5)
    x, y = rng.uniform(-1, 1, (2, 4000))
    around_a_hole = np.hypot(x, y) > 0.35
    for z in (
        0.35 * np.sin(5 * x) * np.cos(4 * y),
        1.8 * x,
        1.2 * x + 1.3 * y + 0.1 * np.sin(9 * x),
    ):
        ground = np.column_stack([x, y, z])[around_a_hole]
        assert neurbs.detect_topology(ground).kind == "height"
