"""Which nets ``neurbs.recover_net`` gives back from points of their surfaces.

    python benches/recovery.py [--seeds 3]

Prints a table of docs/benchmarks.md. The nets are random in the ways that the functions below say;
of each, points are scattered evenly, by parameters and by area in turn. A net has come back where
400 other points of its surface are within 1e-6 of the points' diagonal of what was found, at
parameters between the least and the greatest of the points: any part of one polynomial, which a net
of 4 x 4 is, has such a net. The largest of the other distances is that of those that have not.
"""

import argparse
import time
import warnings
from collections.abc import Callable
from itertools import product

import numpy as np
from numpy.typing import NDArray

import neurbs

Array = NDArray[np.float64]
Net = tuple[int, int]

SHEETS: tuple[Net, ...] = ((4, 4), (5, 6), (6, 6), (8, 7), (7, 10), (9, 9), (12, 8), (12, 12))
COUNTS = (1000, 2000, 5000, 1500)
RECOVERED = 1e-6


def flat(u: Array, v: Array, rng: np.random.Generator, step: float) -> Array:
    """Return control points at even places of a rectangle, with random heights."""
    height = rng.uniform(0.3, 1) * step * rng.standard_normal(u.shape)
    return np.stack([rng.uniform(1, 2) * u, v, height], -1)


def bent(u: Array, v: Array, rng: np.random.Generator, step: float) -> Array:
    """Return control points scattered about an arc of 1 to 3.5 radians."""
    angle = rng.uniform(1, 3.5) * u
    net = np.stack([np.cos(angle), rng.uniform(1, 2) * v, np.sin(angle)], -1)
    return net + 0.3 * step * rng.standard_normal(net.shape)


def rolled(u: Array, v: Array, rng: np.random.Generator, step: float) -> Array:
    """Return control points scattered about a spiral of 4 to 6 radians."""
    angle = rng.uniform(4, 6) * u
    radius = 0.3 + 0.05 * angle
    net = np.stack([radius * np.cos(angle), rng.uniform(1, 2) * v, radius * np.sin(angle)], -1)
    return net + 0.05 * step * rng.standard_normal(net.shape)


def waves(u: Array, v: Array, rng: np.random.Generator, step: float, height: float) -> Array:
    """Return control points at places of a rectangle, about waves of this height."""
    along, across = np.sin(rng.uniform(4, 7) * u), np.cos(rng.uniform(4, 7) * v + rng.uniform(0, 6))
    net = np.stack([rng.uniform(1, 2) * u, v, height * along * across], -1)
    return net + 0.02 * step * rng.standard_normal(net.shape)


def wavy(u: Array, v: Array, rng: np.random.Generator, step: float) -> Array:
    """Return low waves."""
    return waves(u, v, rng, step, 0.15)


def steep(u: Array, v: Array, rng: np.random.Generator, step: float) -> Array:
    """Return high waves."""
    return waves(u, v, rng, step, 0.35)


def uneven(u: Array, v: Array, rng: np.random.Generator, step: float) -> Array:
    """Return waves over a grid whose lines are shifted by up to a third of their spacing."""
    spacing = 1 / (np.array(u.shape) - 1)
    shifts = 0.35 * spacing[:, None, None] * rng.uniform(-1, 1, (2, *u.shape))
    return waves(u + shifts[0], v + shifts[1], rng, step, 0.2)


def graded(u: Array, v: Array, rng: np.random.Generator, step: float) -> Array:
    """Return waves over a grid that gets finer from one end to the other, along u and along v."""
    powers = rng.uniform(0.6, 1.8, 2)
    return waves(u ** powers[0], v ** powers[1], rng, step, 0.2)


Shape = Callable[[Array, Array, np.random.Generator, float], Array]
SHAPES: tuple[Shape, ...] = (flat, bent, rolled, wavy, steep, uneven, graded)


def surface(shape: Shape, net: Net, rng: np.random.Generator) -> neurbs.NurbsSurface:
    """Return a cubic surface with a net of a shape."""
    u, v = np.meshgrid(*(np.linspace(0, 1, n) for n in net), indexing="ij")
    return neurbs.NurbsSurface(shape(u, v, rng, 1 / min(max(net) - 1, 8)))


def scattered(truth: neurbs.NurbsSurface, number: int, rng: np.random.Generator) -> Array:
    """Return parameters of points of a surface, evenly by its area."""
    uv = rng.random((20 * number, 2))
    derivatives = truth.derivatives(uv, 1)
    area = np.linalg.norm(np.cross(derivatives[:, 1, 0], derivatives[:, 0, 1]), axis=1)
    chosen: Array = uv[rng.choice(len(uv), number, replace=False, p=area / area.sum())]
    return chosen


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3)
    seeds = parser.parse_args().seeds
    warnings.simplefilter("ignore", neurbs.NeurbsWarning)
    print("| nets | tried | came back | s each | others, s each | largest distance, 1e-4 D |")
    print("|---|---|---|---|---|---|")
    for shape in SHAPES:
        seconds: dict[bool, list[float]] = {True: [], False: []}
        largest = 0.0
        for number, (net, seed) in enumerate(product(SHEETS, range(seeds))):
            rng = np.random.default_rng([seed, *net])
            truth, several = surface(shape, net, rng), COUNTS[number % len(COUNTS)]
            by_area = (number // len(COUNTS) + seed) % 2
            uv = scattered(truth, several, rng) if by_area else rng.random((several, 2))
            points = truth.evaluate(uv)
            start = time.perf_counter()
            try:
                found = neurbs.recover_net(points, net)
            except neurbs.NeurbsError:
                found = None
            elapsed = time.perf_counter() - start
            others = truth.evaluate(rng.uniform(uv.min(axis=0), uv.max(axis=0), (400, 2)))
            far = np.inf
            if found is not None:
                far = found.closest_points(others).distances.max()
                far /= np.linalg.norm(np.ptp(points, axis=0))
            seconds[bool(far < RECOVERED)].append(elapsed)
            largest = max(largest, far) if far >= RECOVERED else largest
        mean = {way: f"{np.mean(times):.2f}" if times else "" for way, times in seconds.items()}
        tried = sum(len(times) for times in seconds.values())
        print(
            f"| {shape.__name__} | {tried} | {len(seconds[True])} | {mean[True]} "
            f"| {mean[False]} | {1e4 * largest:.0f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
