"""What several tests start from."""

import signal
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs

# A shell that starts the tests in the background has them ignore Ctrl-C, and so all processes that
# they start and interrupt.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(0)


@pytest.fixture
def terrain_points() -> NDArray[np.float64]:
    """Scatter 400 points over a hilly square kilometre, in metres."""
    x, y = np.random.default_rng(1).uniform(0, 1000, (2, 400))
    z = 200 + 60 * np.sin(x / 170) * np.cos(y / 230) + 0.05 * x
    return np.column_stack([x, y, z])


@pytest.fixture(scope="session")
def result() -> neurbs.Reconstruction:
    """Reconstruct a small surface; coordinates are large, as a survey's are."""
    x, y = np.random.default_rng(2).uniform(0, 100, (2, 400))
    points = np.column_stack([x + 5e6, y + 7.5e6, 120 + 10 * np.sin(x / 17) * np.cos(y / 23)])
    return neurbs.reconstruct(points, grid=(9, 7))


@pytest.fixture
def points_file(tmp_path: Path, terrain_points: NDArray[np.float64]) -> Path:
    """Write `terrain_points` to a text file."""
    path = tmp_path / "points.xyz"
    np.savetxt(path, terrain_points, fmt="%.17g")
    return path
