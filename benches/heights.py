"""Time of heights at a million places, as processor time on two cores, beside SciPy's splines.

    python benches/heights.py

The processor time of the process, divided by two, does not depend on other work on the machine.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from scipy.interpolate import LinearNDInterpolator, SmoothBivariateSpline

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


def main() -> None:
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


if __name__ == "__main__":
    main()
