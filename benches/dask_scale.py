"""Sums of a round over LAZ tiles: one process, one worker and two workers of Dask.

    python benches/dask_scale.py --points 10000000 --files 50 --grid 150 150

It writes tiles of rough terrain to a temporary folder, fits a sample, and times one round over
all points, reading included: projection, robust weights, normal equations, deviations. Processor
time and peak memory are those of all processes; the share of the machine that other programs
took in the meantime tells whether a wall time means something. With --whole it times a whole
reconstruction.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import laspy
import numpy as np
import psutil
from distributed import Client, LocalCluster

import neurbs
from neurbs import distributed
from neurbs.distributed import rounds
from neurbs.distributed.engine import Engine
from neurbs.distributed.parts import parts_of
from neurbs.distributed.residuals import Residuals, breaks_of

WAVES = 40
"""Waves of the terrain, whose heights fall with their frequency."""


def heights(x: Any, y: Any) -> Any:
    """Return rough terrain, in meters, over a square of 1000 m."""
    rng = np.random.default_rng(7)
    total = np.zeros_like(x)
    for _ in range(WAVES):
        frequency, angle, phase = rng.uniform(1, 60), rng.uniform(0, np.pi), rng.uniform(0, 7)
        along = (x * np.cos(angle) + y * np.sin(angle)) / 1000
        total += 30 / frequency**1.2 * np.sin(2 * np.pi * frequency * along + phase)
    return total


def write_tiles(folder: Path, points: int, files: int) -> list[Path]:
    """Write strips of the terrain."""
    paths = []
    for number in range(files):
        rng = np.random.default_rng(number)
        size = points // files
        x = 1000 * (number + rng.random(size)) / files
        y = 1000 * rng.random(size)
        z = heights(x, y) + 0.05 * rng.standard_normal(size)
        header = laspy.LasHeader(point_format=6, version="1.4")
        header.scales, header.offsets = np.full(3, 0.001), np.zeros(3)
        tile = laspy.LasData(header)
        tile.x, tile.y, tile.z = x, y, z
        paths.append(folder / f"tile{number:04}.laz")
        tile.write(paths[-1])
    return paths


class Watch:
    """Processor time and peak memory of this process and its descendants, from now on."""

    def __init__(self, root: psutil.Process) -> None:
        """Start to watch; a process that ends in between is not counted further."""
        self._root, self._stop = root, threading.Event()
        self._start, self._busy = time.perf_counter(), busy_seconds()
        self.cpu: dict[int, tuple[float, float]] = {}
        self.peak: dict[int, int] = {}
        self._look()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _look(self) -> None:
        for process in [self._root, *self._root.children(recursive=True)]:
            try:
                times, memory = process.cpu_times(), process.memory_info().rss
            except psutil.Error:
                continue
            spent = times.user + times.system
            first = self.cpu.get(process.pid, (spent, spent))[0]
            self.cpu[process.pid] = (first, spent)
            self.peak[process.pid] = max(self.peak.get(process.pid, 0), memory)

    def _run(self) -> None:
        while not self._stop.wait(0.2):
            self._look()

    def stop(self) -> str:
        """Return wall and processor time, the share of others, and the peaks of processes."""
        wall, busy = time.perf_counter() - self._start, busy_seconds() - self._busy
        self._stop.set()
        self._thread.join()
        self._look()
        spent = sum(b - a for a, b in self.cpu.values())
        others = max(busy - spent, 0) / wall / (os.cpu_count() or 1)
        here = self.peak.pop(self._root.pid)
        return (
            f"wall {wall:7.1f} s  processor {spent:7.1f} s  others {100 * others:3.0f} %  "
            f"peak here {here / 1e6:5.0f} MB, of a child {max(self.peak.values()) / 1e6:5.0f} MB"
        )


def busy_seconds() -> float:
    """Return the seconds that all processors of the machine have worked."""
    times = psutil.cpu_times()
    return float(times.user + times.nice + times.system + times.irq + times.softirq)


@contextmanager
def workers(count: int) -> Iterator[Any]:
    """Yield the scheduler for a number of workers with a thread each; 0 is this process."""
    if count == 0:
        yield "synchronous"
        return
    with (
        LocalCluster(
            n_workers=count, threads_per_worker=1, memory_limit="1.5GB", dashboard_address=":0"
        ) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        yield client


def main() -> None:
    """Run the benchmark and print a table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("--files", type=int, default=20)
    parser.add_argument("--grid", type=int, nargs=2, default=(60, 60))
    parser.add_argument("--workers", type=int, nargs="*", default=[0, 1, 2])
    parser.add_argument("--max-sample", type=int, default=1 << 18)
    parser.add_argument("--whole", action="store_true")
    given = parser.parse_args()
    grid = tuple(given.grid)
    neurbs.set_num_threads(2)
    with tempfile.TemporaryDirectory(prefix="neurbs-bench-") as folder:
        start = time.perf_counter()
        files = write_tiles(Path(folder), given.points, given.files)
        size = sum(file.stat().st_size for file in files) / 1e6
        print(
            f"{given.points:,} points in {len(files)} files of {size:,.0f} MB in all, "
            f"written in {time.perf_counter() - start:.0f} s",
            flush=True,
        )
        step = given.points // given.max_sample + 1
        # Copies, since views would keep all points.
        sample = np.concatenate([neurbs.read_points(file)[::step].copy() for file in files])
        fitted = neurbs.NurbsSurface.fit(sample, sample[:, :2] / 1000, net=grid)
        work = round_of(fitted, sample)
        for count in given.workers:
            with workers(count) as scheduler:
                if count and not given.whole:
                    # Workers import what they need before the time is taken.
                    few = parts_of(files[: 2 * count])
                    Engine(scheduler).summed(few, rounds.step, work, stage="fitting")
                watch = Watch(psutil.Process(os.getpid()))
                if given.whole:
                    found = distributed.reconstruct(
                        files,
                        kind="height",
                        grid=grid,
                        aspect="fixed",
                        max_sample=given.max_sample,
                        scheduler=scheduler,
                    ).report
                    said = f"rms {found.rms:.6f}, {len(found.rounds)} rounds, {found.seconds}"
                else:
                    parts = parts_of(files)
                    outcome = Engine(scheduler).summed(parts, rounds.step, work, stage="fitting")
                    said = (
                        f"rms {outcome.value.residuals.rms:.9f}, "
                        f"{outcome.bytes / 1e6:,.0f} MB of results, tasks read "
                        f"{outcome.reading:.1f} s and computed {outcome.computing:.1f} s"
                    )
                name = f"{count} workers" if count else "one process, 2 threads"
                print(f"{name:24} {watch.stop()}  {said}", flush=True)


def round_of(surface: neurbs.NurbsSurface, sample: Any) -> rounds.Round:
    """Return a round over a height field."""
    origin = np.array([500.0, 500.0, 0.0])
    local = rounds.moved(surface, -origin)
    found = local.closest_points(sample - origin)
    breaks = breaks_of(local)
    weights = np.ones(len(sample))
    usual = Residuals.of(found.distances, found.uv, weights, breaks, None).usual(breaks)
    base = rounds.BasePlane.of(local, (0.0, 0.0, 1.0))
    return rounds.Round(
        local, local.knots, usual, (False, False), tuple(origin.tolist()), base, True, None
    )


if __name__ == "__main__":
    main()
