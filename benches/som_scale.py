"""The cost of an epoch of batch training by points and by nodes, and its memory.

    python benches/som_scale.py [--lattice triangular] [--neighborhood] [--memory]

Prints the tables of docs/benchmarks.md: seconds of the quicker of the last two of three epochs,
in which the radius falls from a quarter of the side to 0.7, on a lattice that starts on the
principal plane. With ``--neighborhood``, what of an epoch is left when all winners are known, at a
radius of a quarter of the side. With ``--memory``, the peak of the process for ten million points
and 50 x 50 nodes, beside what the points themselves take.
"""

import argparse
import resource
import time

import numpy as np
from numpy.typing import NDArray

import neurbs

POINTS = (10**5, 10**6, 10**7)
SIDES = (10, 32, 100, 316)


def sheet(count: int) -> NDArray[np.float64]:
    """Return points of a wavy sheet, made without temporary arrays as large as they are."""
    points = np.random.default_rng(0).random((count, 3))
    for chunk in np.array_split(points, max(count // 100_000, 1)):
        chunk[:, 2] = 0.2 * np.sin(4 * chunk[:, 0]) * np.cos(3 * chunk[:, 1])
    return points


def epoch(points: NDArray[np.float64], side: int, lattice: str) -> float:
    """Return the seconds of the quicker of the last two of three epochs."""
    seconds: list[float] = []
    last = time.perf_counter()

    def note(_: neurbs.Epoch) -> None:
        nonlocal last
        now = time.perf_counter()
        seconds.append(now - last)
        last = now

    som = neurbs.SelfOrganizingMap(
        side, side, lattice=lattice, kernel="mean", epochs=3, min_change=1e-300
    )
    som.fit(points, observer=note)
    # The first includes the start and the order of the points.
    return min(seconds[1:])


def neighborhood(points: NDArray[np.float64], side: int, lattice: str, kernel: str) -> float:
    """Return the seconds that nodes take to learn from winners at the widest radius, best of 3."""
    som = neurbs.SelfOrganizingMap(side, side, lattice=lattice, kernel=kernel, radius=side / 4)
    seconds: list[float] = []
    for _ in range(3):
        som.partial_fit(points, end_epoch=False)
        begin = time.perf_counter()
        som.end_epoch()
        seconds.append(time.perf_counter() - begin)
    return min(seconds)


def memory() -> None:
    """Print the peak of the process, and what it was when the points were there."""
    points = sheet(10**7)
    made = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    neurbs.SelfOrganizingMap(50, 50, epochs=3, min_change=1e-300).fit(points)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    size = points.nbytes / 2**20
    print(f"points {size:.0f} MiB, peak before training {made:.0f} MiB, after {peak:.0f} MiB")
    print(f"{peak / size:.2f} times the points")


def main() -> None:
    """Print the table, or the memory."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--memory", action="store_true")
    parser.add_argument("--neighborhood", action="store_true")
    parser.add_argument("--lattice", choices=("quad", "triangular"), default="quad")
    arguments = parser.parse_args()
    if arguments.memory:
        memory()
        return
    first = "lattice, kernel" if arguments.neighborhood else "points"
    print(f"| {first} | " + " | ".join(f"{side}² nodes" for side in SIDES) + " |")
    print("| --- |" + " ---: |" * len(SIDES))
    if arguments.neighborhood:
        points = sheet(POINTS[0])
        for lattice, kernel in (("quad", "mean"), ("quad", "linear"), ("triangular", "mean")):
            row = (f"{neighborhood(points, side, lattice, kernel):.4f}" for side in SIDES)
            print(f"| {lattice}, {kernel} | " + " | ".join(row) + " |", flush=True)
        return
    for count in POINTS:
        points = sheet(count)
        row = (f"{epoch(points, side, arguments.lattice):.3f}" for side in SIDES)
        print(f"| {count:,} | " + " | ".join(row) + " |", flush=True)


if __name__ == "__main__":
    main()
