"""One table of how good and how fast the default call is, on clouds of every kind.

    python benches/scoreboard.py [--seeds 3] [--only NAME,...] [--real] [--synthetic] [--jobs 1]
                                 [--save FILE] [--against FILE] [--limit 600]

Each cloud runs in a process of its own: ``neurbs.reconstruct(points)`` with no option. Real clouds
are read from the folder NEURBS_DATA/npy. Seconds are only right with one job at a time.

Columns, lengths in 1e-4 of the diagonal of the points:

kind
    The kind that was found.
net
    Control points, or the number of faces of a body.
rms
    Root mean square distance of all points to the surface; of a real cloud without the largest
    0.5 %.
truth
    The same of dense samples of the true surface, without the largest 0.5 %. Real clouds: of each
    tenth point, left out of the fit.
height
    Truth of the same points where a height field is asked for, for families of heights along z.
beyond
    95th percentile of the distance from samples of the surface to the nearest point, in mean
    spacings.
folds
    Share of neighboring samples of the surface whose normals turn over against the local planes
    of the points, in percent, less what the true surface shows by this measure.
cpu
    CPU seconds of the call.
units
    The same over the CPU seconds of a k-d tree of 20,000 points (SciPy, 16 neighbors each), times
    20,000 / max(points, 2000).
warn
    Number of warnings.

A truth under 0.2 counts as 0.2. A surface is folded over 1 %. A cloud without a result counts as a
wrong kind.
"""

import argparse
import json
import subprocess
import sys
import time
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import scoreboard_clouds as clouds
from scipy.spatial import cKDTree
from scoreboard_clouds import SIDE, Array

import neurbs

Row = dict[str, Any]
T = TypeVar("T")

LEAST_TRUTH = 0.2
MOST_FOLDS = 1.0
MOST_OVER_HEIGHT = 1.25
KEPT = 0.995
"""Share of the distances that count where a few wild points may be among them."""
TREE_POINTS = 20_000
LEAST_POINTS = 2000
"""Points that a cloud counts as at least, where its seconds are divided by its size."""


def timed(work: Callable[[], T]) -> tuple[T, float]:
    """Return the result of some work and its CPU seconds."""
    start = time.process_time()
    result = work()
    return result, time.process_time() - start


def tree_seconds() -> float:
    """Return the CPU seconds of one k-d tree: the measure of this machine."""
    points = np.random.default_rng(0).random((TREE_POINTS, 3))
    return min(timed(lambda: cKDTree(points).query(points, k=16))[1] for _ in range(3))


def folds(places: Array, normals: Array, points: Array, tree: cKDTree) -> float:
    """Return the share of neighboring samples whose normals turn over, in percent.

    The sign of the local plane's normal is carried along from a sample to its neighbor, and must
    not flip against the normal of the surface.
    """
    distances, nearest = tree.query(places, k=12)
    around = points[nearest]
    around = around - around.mean(1, keepdims=True)
    spread, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", around, around))
    plane = axes[..., 0]
    flat = spread[:, 0] < 0.02 * spread[:, 1]
    near = distances[:, 0] < 2 * np.median(distances[:, 3])
    usable = (flat & near).reshape(SIDE, SIDE)
    sign = np.sign(np.einsum("ni,ni->n", normals, plane)).reshape(SIDE, SIDE)
    plane = plane.reshape(SIDE, SIDE, 3)
    turned = counted = 0
    for axis in (0, 1):
        first, second = np.arange(SIDE - 1), np.arange(1, SIDE)
        a, b = (np.take(plane, side, axis) for side in (first, second))
        both = np.take(usable, first, axis) & np.take(usable, second, axis)
        cosine = np.einsum("abi,abi->ab", a, b)
        both &= np.abs(cosine) > 0.7
        signs = np.take(sign, first, axis) * np.take(sign, second, axis)
        turned += (both & (signs * np.sign(cosine) < 0)).sum()
        counted += both.sum()
    return float(100 * turned / max(counted, 1))


def kind_of(result: neurbs.Reconstruction) -> str:
    return str(result.report.kind)


def distances_to(result: neurbs.Reconstruction, points: Array) -> Array:
    """Return the distances of points to a surface or shell, the least first."""
    target = result.shell if kind_of(result) == "body" else result.surface
    return np.sort(target.closest_points(points).distances)


def most(distances: Array) -> Array:
    return distances[: max(1, int(KEPT * len(distances)))]


def root_mean_square(distances: Array, diagonal: float) -> float:
    """Return a root mean square in 1e-4 of the diagonal."""
    return float(1e4 * np.sqrt((distances * distances).mean()) / diagonal)


def truth_error(result: neurbs.Reconstruction, truth: Array, diagonal: float) -> float:
    return root_mean_square(most(distances_to(result, truth)), diagonal)


def samples(result: neurbs.Reconstruction) -> Array:
    """Return places spread over a surface or shell."""
    if kind_of(result) == "body":
        return result.shell.tessellate().vertices
    at = np.linspace(0, 1, 120)
    u, v = (a + (b - a) * at for a, b in result.surface.domain)
    return result.surface.evaluate_grid(u, v).reshape(-1, 3)


def folds_of(result: neurbs.Reconstruction, cloud: clouds.Cloud, tree: cKDTree) -> float:
    """Return the folds of a surface, less those that the truth shows by the same measure."""
    surface = result.surface
    uv = clouds.grid_parameters(*zip(*surface.domain, strict=True))
    own = folds(surface.evaluate(uv), surface.normals(uv), cloud.points, tree)
    return max(0.0, own - (folds(*cloud.grid, cloud.points, tree) if cloud.grid else 0))


def measure(name: str) -> Row:
    """Return the row of one cloud."""
    cloud = clouds.cloud(name)
    points, diagonal = cloud.points, clouds.diagonal(cloud.points)
    warnings.simplefilter("ignore")
    # The first call of a process starts its threads.
    neurbs.reconstruct(np.random.default_rng(0).random((30, 3)))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        start = time.perf_counter()
        result, seconds = timed(lambda: neurbs.reconstruct(points))
        wall = time.perf_counter() - start
    kind, number = kind_of(result), len(points)
    net = (len(result.shell.faces), 1) if kind == "body" else result.surface.control_points.shape
    tree = cKDTree(points)
    near = tree.query(points, k=min(16, number))[0]
    spacing = np.median(near[:, 4]) / 1.13 if number > 16 else diagonal / 5
    distances = distances_to(result, points)
    row = {
        "name": name,
        "n": number,
        "kind": kind,
        "net": list(net[:2]),
        "cpu": seconds,
        "wall": wall,
        "units": seconds / (tree_seconds() * max(number, LEAST_POINTS) / TREE_POINTS),
        "warn": len(caught),
        "rms": root_mean_square(most(distances) if cloud.truth is None else distances, diagonal),
        "folds": 0.0 if kind == "body" else folds_of(result, cloud, tree),
        "beyond": float(np.quantile(tree.query(samples(result))[0], 0.95) / spacing),
    }
    if cloud.truth is None:
        left_out = np.random.default_rng(1).permutation(number) % 10 == 3
        fitted = neurbs.reconstruct(points[~left_out])
        return row | {"truth": truth_error(fitted, points[left_out], diagonal)}
    row |= {
        "truth": truth_error(result, cloud.truth, diagonal),
        "right": clouds.is_right(name, kind),
    }
    if name.split("/")[0] in clouds.HEIGHTS:
        asked = result if kind == "height" else neurbs.reconstruct(points, kind="height")
        row["height"] = truth_error(asked, cloud.truth, diagonal)
    return row


def measure_apart(name: str, limit: float) -> Row:
    """Return the row of one cloud, measured in a process of its own."""
    command = [sys.executable, __file__, "--one", name]
    try:
        run = subprocess.run(command, capture_output=True, text=True, timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        return {"name": name, "failed": f"no result in {limit:.0f} s"}
    if run.returncode:
        last = run.stderr.strip().splitlines()[-1:] or [f"exit code {run.returncode}"]
        return {"name": name, "failed": last[0]}
    row: Row = json.loads(run.stdout.splitlines()[-1])
    return row


def ratio(row: Row, base: Row) -> float:
    """Return how many times as far from the truth a cloud is as in the baseline."""
    return float(max(row["truth"], LEAST_TRUTH) / max(base["truth"], LEAST_TRUTH))


def line(row: Row, base: Row) -> str:
    """Return a row of the table, with what changed against the baseline."""
    if "failed" in row:
        return f"{row['name']:26s} failed: {row['failed'][:90]}"
    text = (
        f"{row['name']:26s} {row['n']:7d} {row['kind']:7s} {row['net'][0]:4d}x{row['net'][1]:<4d} "
        f"{row['rms']:8.2f} {row['truth']:8.2f} {row.get('height', float('nan')):8.2f} "
        f"{row['beyond']:6.2f} {row['folds']:6.2f} {row['cpu']:7.2f} {row['units']:6.1f} "
        f"{row['warn']}"
    )
    right = row.get("right", True)
    text += "" if right else " wrong kind"
    if "truth" in base:
        text += f"  truth x {ratio(row, base):.2f}  cpu x {row['units'] / base['units']:.2f}"
        text += "" if base.get("right", True) == right else f"  (kind was {base['kind']})"
    return text


def is_synthetic(row: Row) -> bool:
    return "/" in row["name"]


def is_sound(row: Row) -> bool:
    """Return whether a cloud has a surface of a right kind without folds."""
    return "truth" in row and row.get("right", True) and row["folds"] <= MOST_FOLDS


def trees(rows: list[Row]) -> float:
    """Return the CPU seconds of all rows, in k-d trees."""
    return float(sum(row["units"] * max(row["n"], LEAST_POINTS) / TREE_POINTS for row in rows))


def print_summary(rows: list[Row], good: list[Row]) -> None:
    """Print how many clouds came out, and what they cost."""
    few = [row for row in rows if row["name"].split("/")[1:2] == ["40"]]
    many = [row for row in rows if is_synthetic(row) and row not in few]
    real = [row for row in good if not is_synthetic(row)]
    unsound = {"few": sum(not is_sound(r) for r in few), "many": sum(not is_sound(r) for r in many)}
    cost = [row["units"] for row in good]
    print(
        f"{len(good)} of {len(rows)} have a result; wrong kind or folded: {unsound['many']} of "
        f"{len(many)}, with 40 points {unsound['few']} of {len(few)}, real clouds folded "
        f"{sum(not is_sound(row) for row in real)}; units: median {np.median(cost):.1f}, worst "
        f"{max(cost):.0f}, sum {trees(good):.0f} k-d trees"
    )
    over = [
        (row["truth"] / max(row["height"], LEAST_TRUTH), row["name"])
        for row in good
        if "height" in row and row["truth"] > LEAST_TRUTH
    ]
    if over:
        worst, name = max(over)
        print(
            f"heights: {sum(times > MOST_OVER_HEIGHT for times, _ in over)} of {len(over)} more "
            f"than {MOST_OVER_HEIGHT} times as far from the truth as the height field asked for, "
            f"worst {name} {worst:.1f} times"
        )


def print_comparison(good: list[Row], base: dict[str, Row]) -> None:
    """Print the means against the baseline, and what became worse."""
    pairs = [(row, base[row["name"]]) for row in good if "truth" in base.get(row["name"], {})]
    if not pairs:
        return
    logs: dict[str, list[float]] = {}
    for row, before in pairs:
        if is_sound(before):
            logs.setdefault(row["name"].split("/")[0], []).append(np.log(ratio(row, before)))
    means = sorted(((np.exp(np.mean(some)), key) for key, some in logs.items()), reverse=True)
    worse = ", ".join(f"{key} x {mean:.2f}" for mean, key in means if mean > 1.05) or "none"
    truth = np.exp(np.mean(np.log([ratio(row, before) for row, before in pairs])))
    cost = trees([row for row, _ in pairs]) / trees([before for _, before in pairs])
    print(
        f"against the baseline: truth geometric mean x {truth:.2f}; k-d trees x {cost:.2f}; "
        f"families and real clouds (right and unfolded in the baseline) that became worse: {worse}"
    )


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=1, help="seeds of each synthetic cloud")
    parser.add_argument("--only", help="names of clouds, separated by commas")
    parser.add_argument("--real", action="store_true", help="only real clouds")
    parser.add_argument("--synthetic", action="store_true", help="only synthetic clouds")
    parser.add_argument("--save", type=Path, help="write all rows to this JSON file")
    parser.add_argument("--against", type=Path, help="compare with rows that were saved before")
    parser.add_argument("--limit", type=float, default=600, help="seconds of a cloud at most")
    parser.add_argument("--jobs", type=int, default=1, help="clouds at a time")
    parser.add_argument("--one", help=argparse.SUPPRESS)
    return parser.parse_args()


def chosen(options: argparse.Namespace) -> list[str]:
    """Return the names of the clouds that the options ask for."""
    if options.only:
        return str(options.only).split(",")
    real = [] if options.synthetic else clouds.real_names()
    if not real and not options.synthetic:
        sys.exit(f"No .npy file in {clouds.folder()}. Set NEURBS_DATA, or use --synthetic.")
    return real + ([] if options.real else clouds.synthetic_names(options.seeds))


def main() -> None:
    """Print the table and its summary."""
    options = arguments()
    if options.one:
        print(json.dumps(measure(options.one)))
        return
    names = chosen(options)
    base = {}
    if options.against:
        base = {row["name"]: row for row in json.loads(options.against.read_text())}
    print(
        f"{'cloud':26s} {'n':>7s} {'kind':7s} {'net':>9s} {'rms':>8s} {'truth':>8s} "
        f"{'height':>8s} {'beyond':>6s} {'folds':>6s} {'cpu':>7s} {'units':>6s} warn"
    )
    rows = []
    with ThreadPoolExecutor(options.jobs) as pool:
        for row in pool.map(lambda name: measure_apart(name, options.limit), names):
            rows.append(row)
            print(line(row, base.get(row["name"], {})), flush=True)
    if options.save:
        options.save.write_text(json.dumps(rows, indent=0))
    good = [row for row in rows if "truth" in row]
    if not good:
        sys.exit("No cloud has a result.")
    print_summary(rows, good)
    print_comparison(good, base)


if __name__ == "__main__":
    main()
