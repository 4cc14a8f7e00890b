"""Sheets that are wound up or folded: the way along them is not the way through the air."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs

Points = NDArray[np.float64]


def roll(rng: np.random.Generator, count: int, turns: float) -> Points:
    """Scatter points over a roll of height 21 whose windings are 2 π² apart."""
    t = rng.uniform(1.5 * np.pi, (1.5 + 2 * turns) * np.pi, count)
    return np.column_stack([t * np.cos(t), 21 * rng.random(count), t * np.sin(t)])


def hairpin(rng: np.random.Generator, count: int, gap: float) -> Points:
    """Scatter points over a strip that turns back on itself at half its length."""
    radius = gap / 2
    s = (4 + np.pi * radius) * rng.random(count)
    angle = np.clip((s - 2) / radius, 0, np.pi)
    straight = np.where(s < 2, s, np.minimum(2, 4 + np.pi * radius - s))
    x, z = straight + radius * np.sin(angle), radius * (1 - np.cos(angle))
    return np.column_stack([x, 1.5 * rng.random(count), z])


def helicoid(rng: np.random.Generator, count: int, turns: int, core: float) -> Points:
    """Scatter points over winding stairs, from a core of this radius to 1."""
    # More points farther out, where turns are longer.
    r = np.sqrt(core**2 + (1 - core**2) * rng.random(count))
    t = 2 * np.pi * turns * rng.random(count)
    return np.column_stack([r * np.cos(t), r * np.sin(t), t / 10])


def double_spiral(rng: np.random.Generator, count: int) -> Points:
    """Scatter points over a strip that is wound up from its middle, both arms side by side."""
    s = rng.uniform(-1, 1, count)
    t = 3 * np.pi * np.sqrt(np.abs(s))
    r = np.sign(s) * t
    return np.column_stack([r * np.cos(t), r * np.sin(t), 10 * rng.random(count)])


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    "cloud",
    [
        lambda rng: roll(rng, 1500, 1.5),
        lambda rng: roll(rng, 8000, 1.5),
        lambda rng: roll(rng, 8000, 3),
        lambda rng: hairpin(rng, 4000, 0.2),
        lambda rng: hairpin(rng, 4000, 0.1),
        lambda rng: helicoid(rng, 3000, 2, 0.2),
        lambda rng: helicoid(rng, 8000, 3, 0.1),
        lambda rng: double_spiral(rng, 4000),
    ],
    ids=[
        *["sparse roll", "roll", "three turns", "hairpin", "tight hairpin"],
        *["helicoid", "helicoid of three turns", "double spiral"],
    ],
)
def test_windings_are_told_apart(cloud: Callable[[np.random.Generator], Points], seed: int) -> None:
    points = cloud(np.random.default_rng(seed))
    result = neurbs.reconstruct(points)
    assert not result.report.warnings
    assert result.report.topology == "sheet"
    assert result.report.rms < 2e-4 * result.report.diagonal
    assert result.report.max < 2e-3 * result.report.diagonal


@pytest.mark.parametrize("seed", range(2))
def test_a_strip_that_lies_close_above_itself_is_no_height_field(seed: int) -> None:
    # Three spacings of these points, but one of as few as slopes are told from.
    points = hairpin(np.random.default_rng(seed), 20_000, 0.05)
    assert neurbs.detect_topology(points).kind == "sheet"


@pytest.mark.parametrize("seed", range(3))
def test_few_points_keep_the_order_of_a_fold(seed: int) -> None:
    rng = np.random.default_rng(seed)
    t, y = 3 * np.pi * (rng.random(240) - 0.5), 2 * rng.random(240)
    points = np.column_stack([np.sin(t), y, np.sign(t) * (np.cos(t) - 1)])
    result = neurbs.reconstruct(points)
    assert not result.report.warnings
    x, _, z = result.surface.tessellate(shape=(60, 60)).vertices.T
    off = np.abs(np.hypot(x, z - np.copysign(1, z)) - 1)
    assert np.quantile(off, 0.9) < 0.02
