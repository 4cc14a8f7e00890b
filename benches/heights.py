"""Heights beside SciPy's: time at a million places, and the error between tracks of terrain.

    python benches/heights.py
    python benches/heights.py --tracks jacksboro_dem.npy

The first prints the processor time of the process on two cores, divided by two. It does not depend
on other work on the machine. The second thins a grid to tracks, leaves a quarter of the points out,
and prints the rms of the heights there.
"""

from __future__ import annotations

import argparse
import time
import warnings
from collections.abc import Callable

import numpy as np
from scipy.interpolate import (
    CloughTocher2DInterpolator,
    LinearNDInterpolator,
    SmoothBivariateSpline,
)

import neurbs

PLACES = 1_000_000


def seconds(call: Callable[[], object]) -> float:
    """Return half of the least processor time of three calls."""
    times = []
    for _ in range(3):
        start = time.process_time()
        call()
        times.append(time.process_time() - start)
    return min(times) / 2


def print_times() -> None:
    rng = np.random.default_rng(0)
    x, y = rng.random((2, 20_000))
    z = np.sin(9 * x) * np.cos(7 * y)
    hills = neurbs.fit_heights(np.column_stack([x, y, z]), (60, 60)).surface
    rational = neurbs.NurbsSurface(hills.control_points, rng.uniform(0.5, 2, (60, 60)))
    dome = neurbs.NurbsSurface.sphere([0.5, 0.5, 0], 0.5).sub_surface(v=(0.5, 1))
    spline, triangles = SmoothBivariateSpline(x, y, z, s=1e-3), LinearNDInterpolator((x, y), z)
    at = rng.random((2, PLACES))
    calls: dict[str, Callable[[], object]] = {
        "height field, 60 × 60": lambda: hills.z(*at),
        "rational, 60 × 60": lambda: rational.z(*at),
        "dome": lambda: dome.z(*at),
        "SciPy SmoothBivariateSpline.ev": lambda: spline.ev(*at),
        "SciPy LinearNDInterpolator": lambda: triangles(*at),
    }
    for name, call in calls.items():
        print(f"{name:<32}{seconds(call):8.3f} s")


def print_errors(path: str) -> None:
    points = np.load(path)
    x, y = (np.unique(points[:, axis], return_inverse=True)[1] for axis in (0, 1))
    print("tracks            points   neurbs   linear   Clough-Tocher   net")
    for name, lines in (("rows", y), ("columns", x)):
        for step in (3, 5, 10):
            for share in (0.1, 0.2, 0.5, 1.0):
                chosen = np.random.default_rng(1).random(len(points)) < share
                tracks = points[(lines % step == 0) & chosen]
                out = np.random.default_rng(0).random(len(tracks)) < 0.25
                used, left_out = tracks[~out], tracks[out]
                result = neurbs.reconstruct(used, kind="height")
                found = [result.z(*left_out[:, :2].T)]
                for method in (LinearNDInterpolator, CloughTocher2DInterpolator):
                    found.append(method(used[:, :2], used[:, 2])(*left_out[:, :2].T))
                inside = np.isfinite(found).all(axis=0)
                rms = [np.sqrt(np.mean((z - left_out[:, 2])[inside] ** 2)) for z in found]
                rows, cols = result.report.grid
                print(
                    f"{name:<8}{step:>3}{share:>6}{len(used):>8}{rms[0]:>9.1f}{rms[1]:>9.1f}"
                    f"{rms[2]:>12.1f}      {rows} × {cols}"
                )


def main() -> None:
    parser = argparse.ArgumentParser(description="Compare heights with SciPy's.")
    parser.add_argument("--tracks", metavar="FILE", help="grid of terrain, as an array of points")
    tracks = parser.parse_args().tracks
    if tracks is None:
        print_times()
    else:
        warnings.simplefilter("ignore", neurbs.NeurbsWarning)
        print_errors(tracks)


if __name__ == "__main__":
    main()
