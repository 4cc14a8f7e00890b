"""Maps and surfaces of one cloud in different parts, by two workers of Dask and by one process.

    python benches/dask_parts.py --points 3000000 --parts 1 7 60

Printed are, for each number of parts and scheduler: whether the map has the bits of the map of the
whole array, whether the even sample is the same, and the largest distance of control points from
those of one part, in diagonals of the cloud. It fails if one of them differs by more than 1e-9.
"""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from typing import Any

import dask.array as da
import numpy as np
from distributed import Client, LocalCluster

import neurbs
from neurbs import distributed

MAX_DISTANCE = 1e-9
"""Largest distance of control points, in diagonals."""


def hills(count: int) -> Any:
    """Return points of rough hills far from the origin, with noise and a few outliers."""
    rng = np.random.default_rng(0)
    x, y = rng.random((2, count))
    z = 0.1 * np.sin(9 * x) * np.cos(7 * y) + 0.02 * np.sin(31 * x + 23 * y)
    z += 0.001 * rng.standard_normal(count)
    z[:: count // 20] += 0.3
    return np.column_stack([500 * x + 4e5, 500 * y + 5e6, 500 * z])


def main() -> int:
    """Run the comparison and return the exit code."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--points", type=int, default=300_000)
    parser.add_argument("--parts", type=int, nargs="*", default=[1, 7, 60])
    parser.add_argument("--grid", type=int, nargs=2, default=(20, 20))
    parser.add_argument("--max-sample", type=int, default=1 << 16)
    given = parser.parse_args()
    warnings.simplefilter("ignore", neurbs.NeurbsWarning)
    warnings.filterwarnings("ignore", "Sending large graph")
    points = hills(given.points)
    start = time.perf_counter()
    whole = new_map().fit(points)._map.to_bytes()
    print(f"map of the whole array: {time.perf_counter() - start:.1f} s", flush=True)
    cluster = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0")
    first, failed = None, False
    with cluster, Client(cluster, set_as_default=False) as client:
        for count in given.parts:
            array = da.from_array(points, chunks=(-(-len(points) // count), 3))
            for name, scheduler in (("synchronous", "synchronous"), ("two workers", client)):
                start = time.perf_counter()
                som = distributed.fit_map(new_map(), array, scheduler=scheduler)
                found = distributed.reconstruct(
                    array, grid=tuple(given.grid), max_sample=given.max_sample, scheduler=scheduler
                )
                first = first or found
                same_map = som._map.to_bytes() == whole
                same_sample = np.array_equal(found.sample.points, first.sample.points)
                apart = found.surface.control_points - first.surface.control_points
                far = np.linalg.norm(apart, axis=-1).max() / found.report.diagonal
                failed |= not (same_map and same_sample and far <= MAX_DISTANCE)
                print(
                    f"{count:3} parts, {name:12} map {'the same' if same_map else 'DIFFERS'}  "
                    f"sample {'the same' if same_sample else 'DIFFERS'}  control points within "
                    f"{far:.1e}  rounds {len(found.report.rounds)}  "
                    f"{time.perf_counter() - start:.0f} s",
                    flush=True,
                )
    return int(failed)


def new_map() -> neurbs.SelfOrganizingMap:
    """Return a map before its training."""
    return neurbs.SelfOrganizingMap(12, 15, epochs=6)


if __name__ == "__main__":
    sys.exit(main())
