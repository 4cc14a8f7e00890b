"""The NURBS kernel beside its peers, on the same work, in one run.

    python benches/nurbs_peers.py                      # all cases, 20 × 20 net
    python benches/nurbs_peers.py --case a b --net 100
    python benches/nurbs_peers.py --peer neurbs scipy

The surface is bicubic and rational, over a net of 20 × 20 with weights from 0.5 to 2.

 a  points on a 1000 × 1000 grid           b  points and unit normals, 500 × 500
 c  points at 1,000,000 random (u, v)      d  triangles within 1e-3 of the size
 e  interpolation of a 100 × 100 grid      f  closest points of 10,000 points at up to 1 % of the
                                              size from the surface

Each figure is the best of several runs, alternating between peers, so that what else the machine
does hits all alike; preparations that a user makes once for a surface are not counted. Every result
is compared with plain NumPy's before it is timed: the largest error as a share of the size, in case
d the largest distance between triangles and surface as a share of the tolerance. A peer that is not
installed, or has not got what a case needs, is left out and named. What would take a peer longer
than `--budget` seconds is done on a part of the work, and its time multiplied (marked ~).

The extra `test` installs SciPy, geomdl, Splipy and OpenCASCADE; splinepy is timed where it is
installed.
"""

import argparse
import functools
import math
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from nurbs_peers_libraries import (
    PEERS,
    Cases,
    Surface,
    deviation,
    numpy_peer,
    scipy_peer,
)

TITLES = {
    "a": "points, 1000 × 1000 grid",
    "b": "points and normals, 500 × 500 grid",
    "c": "points, 1,000,000 random (u, v)",
    "d": "triangles within 1e-3 of the size",
    "e": "interpolation, 100 × 100 points",
    "f": "closest points of 10,000 points",
}


def work(case: str, surface: Surface) -> tuple[Any, ...]:
    """Make the arguments of a case."""
    rng = np.random.default_rng(3)
    if case in "ab":
        t = np.linspace(0, 1, 1000 if case == "a" else 500)
        return t, t
    if case == "c":
        return (rng.random((1_000_000, 2)),)
    if case == "d":
        return (1e-3 * surface.size,)
    if case == "e":
        s = np.linspace(0, 10, 100)
        x, y = np.meshgrid(s, s, indexing="ij")
        z = np.sin(1.3 * x) * np.cos(1.1 * y)
        return (np.stack([x + 0.1 * np.sin(y), y + 0.1 * np.cos(x), z], axis=-1),)
    uv = rng.uniform(0.03, 0.97, (10_000, 2))
    d = surface.derivatives(uv, 1)
    normals = np.cross(d[1, 0], d[0, 1])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return (d[0, 0] + rng.uniform(-0.01, 0.01, (10_000, 1)) * surface.size * normals,)


def error(case: str, surface: Surface, result: Any, arguments: tuple[Any, ...]) -> float:
    """Measure the largest difference from plain NumPy's answer, as a share of the size."""
    if case in "abc":
        points = np.asarray(result[0] if case == "b" else result).reshape(-1, 3)
        chosen = np.random.default_rng(0).integers(0, len(points), 2000)
        if case == "c":
            uv = arguments[0][chosen]
        else:
            u, v = arguments
            uv = np.column_stack([u[chosen // len(v)], v[chosen % len(v)]])
        exact = surface.derivatives(uv, 1)
        wrong = np.abs(points[chosen] - exact[0, 0]).max() / surface.size
        if case == "b":
            normals = np.cross(exact[1, 0], exact[0, 1])
            normals /= np.linalg.norm(normals, axis=1)[:, None]
            wrong = max(wrong, np.abs(np.asarray(result[1]).reshape(-1, 3)[chosen] - normals).max())
        return float(wrong)
    if case == "d":
        return deviation(surface, result) / float(arguments[0])
    if case == "e":
        if result is None:
            return math.nan
        return float(np.abs(result - scipy_peer(surface)["e"](*arguments)).max() / 10)
    projections = surface.derivatives(np.asarray(result), 0)[0, 0]
    distances = np.linalg.norm(projections - arguments[0], axis=1)
    start = numpy_peer(surface)["f"](*arguments)
    best = np.linalg.norm(surface.derivatives(start, 0)[0, 0] - arguments[0], axis=1)
    return float((distances - best).max() / surface.size)


def smaller(case: str, arguments: tuple[Any, ...]) -> tuple[tuple[Any, ...], float]:
    """Take a hundredth of a case's work, and say how many times smaller it is."""
    if case in "ab":
        u, v = (np.linspace(t[0], t[-1], len(t) // 10) for t in arguments)
        return (u, v), arguments[0].size * arguments[1].size / (u.size * v.size)
    if case in "cf":
        return (arguments[0][::100],), 100.0
    return arguments, 1.0


def clock(f: Callable[..., Any], arguments: tuple[Any, ...]) -> float:
    start = time.perf_counter()
    f(*arguments)
    return time.perf_counter() - start


def floor(shape: tuple[int, ...]) -> float:
    """Time the filling of an array on two threads: what to write a result takes at least."""
    halves = np.array_split(np.empty(shape).reshape(-1), 2)
    with ThreadPoolExecutor(2) as pool:
        fill = functools.partial(pool.map, lambda half: half.fill(1.0), halves)
        return min(clock(lambda: list(fill()), ()) for _ in range(100))


def run(case: str, surface: Surface, peers: dict[str, Cases], repeat: int, budget: float) -> None:
    """Time a case and print its table."""
    whole = work(case, surface)
    part, times = smaller(case, whole)
    chosen, errors, notes = {}, {}, {}
    for name, cases in peers.items():
        if case not in cases:
            continue
        try:
            f = cases[case]
            # The first call also loads and prepares.
            slow = min(clock(f, part), clock(f, part)) * times > budget
            chosen[name] = (f, part if slow else whole, times if slow else 1.0)
            result = f(*chosen[name][1])
        except TypeError as missing:
            print(f"{name} is left out of {case}: {missing}")
            chosen.pop(name, None)
            continue
        errors[name] = error(case, surface, result, chosen[name][1])
        notes[name] = f"{len(result[1]):,} triangles" if case == "d" else ""
    best = dict.fromkeys(chosen, math.inf)
    for _ in range(repeat):
        for name, (f, arguments, factor) in chosen.items():
            best[name] = min(best[name], factor * clock(f, arguments))
    own = best.get("neurbs", math.nan)
    net = len(surface.points)
    print(f"\n{case}: {TITLES[case]}, net {net} × {net}\n")
    print("| peer | ms | times neurbs | largest error | |\n|---|---:|---:|---:|---|")
    for name in sorted(best, key=best.__getitem__):
        about = "~" if chosen[name][2] > 1 else ""
        row = f"{about}{best[name] * 1e3:.3g} | {best[name] / own:.1f} | {errors[name]:.1e}"
        print(f"| {name} | {row} | {notes[name]} |")
    if case == "a":
        shape = (len(whole[0]), len(whole[1]), 3)
        print(f"\nfilling {np.prod(shape) * 8 / 1e6:.0f} MB: {floor(shape) * 1e3:.2f} ms")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--case", nargs="*", default=list(TITLES), choices=list(TITLES))
    parser.add_argument("--peer", nargs="*", default=list(PEERS))
    parser.add_argument("--net", type=int, default=20)
    parser.add_argument("--repeat", type=int, default=9)
    parser.add_argument("--budget", type=float, default=3.0, help="seconds, else a part is timed")
    options = parser.parse_args()
    surface = Surface(options.net)
    peers: dict[str, Cases] = {}
    for name in options.peer:
        try:
            peers[name] = PEERS[name](surface)
        except ImportError as missing:
            print(f"{name} is left out: {missing}")
    for case in options.case:
        run(case, surface, peers, options.repeat, options.budget)


if __name__ == "__main__":
    main()
