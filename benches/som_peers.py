"""Training beside other trainers: how long it takes, and how well it fits.

    pip install minisom xpysom numbasom python-som scipy   # those that are missing are left out
    python benches/som_peers.py [--repeat N] [--only ours exact]

Points lie on z = sin 3x cos 2y with noise of 0.02. All start from the same nodes on the principal
plane, with a Gaussian neighborhood whose radius falls linearly from a quarter of the side to 1,
and make the same number of steps; numbasom has a start and schedules of its own. Each runs several
times, one that takes long once; the best counts, so that what is compiled at the first call is not
counted. QE is the mean distance from a point to its nearest node,
computed by the same code for all. ``exact`` is no trainer but the reference: SciPy's k-d tree,
sums by ``bincount`` and the separable Gaussian.
"""

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

import neurbs

Array = NDArray[np.float64]


@dataclass
class Job:
    """One case: points, nodes, and how long to train."""

    name: str
    count: int
    side: int
    epochs: int
    online: bool

    def __post_init__(self) -> None:
        """Make the points and the start."""
        rng = np.random.default_rng(0)
        x, y = rng.uniform(-1, 1, (2, self.count))
        z = np.sin(3 * x) * np.cos(2 * y) + rng.normal(0, 0.02, self.count)
        self.points: Array = np.column_stack([x, y, z])
        values, axes = np.linalg.eigh(np.cov(self.points, rowvar=False))
        span = np.linspace(-1.5, 1.5, self.side)
        u = span[:, None, None] * np.sqrt(values[2]) * axes[:, 2]
        v = span[None, :, None] * np.sqrt(values[1]) * axes[:, 1]
        self.start: Array = np.ascontiguousarray(self.points.mean(0) + u + v)
        self.radius = (self.side / 4, 1.0)


def ours(job: Job) -> Any:
    """Train our own, without a stop before the last step."""
    never = {"reach": 1e-12, "min_change": 1e-300, "radius": ("linear", *job.radius)}
    how: dict[str, Any] = {"kernel": "mean", "epochs": job.epochs}
    if job.online:
        steps = job.count * job.epochs
        how = {"training": "online", "gain": ("linear", 0.5, 0.0), "max_steps": steps, "seed": 1}
    som = neurbs.SelfOrganizingMap(job.side, job.side, init=job.start, **how, **never)
    return som.fit(job.points).codebook_


def exact(job: Job) -> Any:
    """Train the batch map in plain NumPy and SciPy."""
    nodes, places = job.start.reshape(-1, 3), np.arange(job.side)
    for radius in np.linspace(*job.radius, job.epochs):
        winners = cKDTree(nodes).query(job.points, workers=-1)[1]
        channels = [*job.points.T, np.ones(job.count)]
        sums = np.stack([np.bincount(winners, c, len(nodes)) for c in channels], axis=-1)
        weights = np.exp(-((places[:, None] - places) ** 2) / (2 * radius**2))
        grid = sums.reshape(job.side, job.side, 4)
        spread = np.einsum("ai,bj,ijk->abk", weights, weights, grid, optimize=True)
        nodes = (spread[..., :3] / spread[..., 3:]).reshape(-1, 3)
    return nodes


def minisom(job: Job) -> Any:
    """Train MiniSom, online."""
    from minisom import MiniSom

    som = MiniSom(
        job.side,
        job.side,
        3,
        sigma=job.radius[0],
        learning_rate=0.5,
        decay_function="linear_decay_to_zero",
        sigma_decay_function="linear_decay_to_one",
        random_seed=1,
    )
    som._weights = job.start.copy()
    som.train(job.points, job.count * job.epochs, random_order=True)
    return som._weights


def xpysom(job: Job) -> Any:
    """Train XPySom, batch."""
    from xpysom import XPySom

    som = XPySom(
        job.side,
        job.side,
        3,
        sigma=job.radius[0],
        sigmaN=job.radius[1],
        decay_function="linear",
        learning_rate=1.0,
        learning_rateN=1.0,
        std_coeff=1.0,
        xp=np,
    )
    som._weights = job.start.copy()
    som.train(job.points.astype(np.float32), job.epochs)
    return som.get_weights()


def numbasom(job: Job) -> Any:
    """Train numbasom, online."""
    from numbasom import SOM

    return SOM((job.side, job.side)).train(job.points, job.count * job.epochs)


def python_som(job: Job) -> Any:
    """Train python-som, batch: its loop alone, without the errors that it measures besides."""
    from python_som import SOM

    def radius(start: float, step: int, _: int) -> float:
        return start + (job.radius[1] - start) * step / (job.epochs - 1)

    som = SOM(
        job.side,
        job.side,
        3,
        neighborhood_radius=job.radius[0],
        neighborhood_radius_decay=radius,
        random_seed=1,
    )
    som._weights = job.start.copy()
    som._train_batch(job.points, job.epochs, verbose=False)
    return som.get_weights()


LONG = 5.0
"""Seconds after which a trainer runs no second time."""

SHORT = 1.5
"""Seconds that a trainer runs at least, all its runs together."""

JOBS: dict[Callable[[], Job], tuple[Callable[[Job], Any], ...]] = {
    lambda: Job("online", 10_000, 20, 10, online=True): (ours, numbasom, minisom),
    lambda: Job("batch", 100_000, 30, 10, online=False): (ours, exact, python_som, xpysom),
    lambda: Job("batch", 1_000_000, 50, 3, online=False): (ours, exact, python_som),
}


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--only", nargs="+", help="names of trainers")
    options = parser.parse_args()
    repeat: int = options.repeat
    print("| job | trainer | seconds | QE |\n| --- | --- | ---: | ---: |")
    for make, trainers in JOBS.items():
        job = make()
        what = f"{job.name}, {job.count:,} points, {job.side}², {job.epochs} epochs"
        for trainer in trainers:
            if options.only and trainer.__name__ not in options.only:
                continue
            best, runs, begun = np.inf, 0, time.perf_counter()
            try:
                while runs < repeat or time.perf_counter() - begun < SHORT:
                    begin = time.perf_counter()
                    nodes = np.asarray(trainer(job), dtype=float).reshape(-1, 3)
                    best = min(best, time.perf_counter() - begin)
                    runs += 1
                    if best > LONG:
                        break
            except ImportError:
                continue
            error = cKDTree(nodes).query(job.points)[0].mean()
            print(f"| {what} | {trainer.__name__} | {best:.3f} | {error:.6f} |", flush=True)


if __name__ == "__main__":
    main()
