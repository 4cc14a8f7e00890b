"""Time and memory of ``neurbs.reconstruct`` by the number of points.

    python benches/reconstruct_scale.py [--largest 10000000] [--grid 20]

Prints a table of docs/benchmarks.md. The points are scattered over a wavy sheet with normal noise
of 0.003; the net has the same budget for all. Each run is a process of its own: its seconds are
those of the call alone, its memory the peak of the process less what it had taken when the points
were there, as a multiple of the points themselves (24 bytes each). What is returned (parameters,
distances and inliers) takes 1.04 of these.
"""

import argparse
import resource
import subprocess
import sys
import time

import numpy as np
from numpy.typing import NDArray

import neurbs

COUNTS = tuple(base * 10**power for power in range(4, 8) for base in (1, 3))


def sheet(count: int) -> NDArray[np.float64]:
    """Return noisy points of a wavy sheet, made without temporary arrays as large as they are."""
    rng = np.random.default_rng(0)
    points = rng.random((count, 3))
    for chunk in np.array_split(points, max(count // 100_000, 1)):
        chunk[:, 2] = np.sin(3 * chunk[:, 0]) * np.cos(2 * chunk[:, 1])
        chunk[:, 2] += rng.normal(0, 0.003, len(chunk))
    return points


def peak() -> int:
    """Return the most memory that this process has had, in bytes."""
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def run(count: int, side: int) -> None:
    """Print seconds and memory of one reconstruction."""
    neurbs.reconstruct(sheet(500), grid=(6, 6))
    points = sheet(count)
    before, start = peak(), time.perf_counter()
    result = neurbs.reconstruct(points, grid=(side, side))
    seconds = time.perf_counter() - start
    print(seconds, (peak() - before) / points.nbytes, result.report.rms)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--largest", type=int, default=COUNTS[-2])
    parser.add_argument("--grid", type=int, default=20)
    parser.add_argument("--count", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.count:
        run(options.count, options.grid)
        return
    print("| points | seconds | µs a point | times the line before | memory | rms |")
    print("|---|---|---|---|---|---|")
    last = None
    for count in (count for count in COUNTS if count <= options.largest):
        command = [sys.executable, __file__, "--grid", str(options.grid), "--count", str(count)]
        answer = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        seconds, memory, rms = map(float, answer.split())
        ratio = f"{seconds / last:.1f}" if last else ""
        print(
            f"| {count:,} | {seconds:.2f} | {1e6 * seconds / count:.1f} | {ratio} "
            f"| {memory:.1f} | {rms:.5f} |",
            flush=True,
        )
        last = seconds


if __name__ == "__main__":
    main()
