"""How near surfaces come to real point clouds, whose true shape nobody knows.

    NEURBS_DATA=FOLDER python benches/real_peers.py [--clouds owl,leaf] [--pictures FOLDER]
    NEURBS_DATA=FOLDER python benches/real_peers.py --left-out 10 [--clouds leaflet,face]

Reads FOLDER/npy/*.npy, arrays of points. Each is fitted as it is, by default settings, then with as
many poles as that chose, but 144 at most, and so by those peers that are installed:

freecad
    `ReverseEngineering.approxSurface`: least squares over the principal plane with parameter
    correction, by the system's Python, which FreeCAD's packages serve. It may take 5 minutes.
opencascade
    `GeomPlate_BuildPlateSurface` through 400 of the points, approximated by a B-spline surface.
pcl
    `pcl::on_nurbs::FittingSurface` over the principal plane, by a program of your own that the
    environment variable PCL_FIT names: packages of PCL come without that module. Its arguments are
    a file of points, one for the result, "pdm", the order, how many times the net is refined, the
    iterations, the smoothness and the side of a grid. It writes "# ROWS COLUMNS SECONDS" and then
    the places of the grid, a line each.

Printed are the root mean square, the 99th percentile and the largest of the distances from all
points to the surface, in 1e-4 of the diagonal of their bounding box, by one code for all: the exact
distance to 400 × 400 facets. Outliers count like all others.

With `--left-out` each tenth, say, of the points is left out in turn, and only the distances of the
points left out are counted: a surface that follows the noise of the points it saw comes off badly.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import tempfile
import time
import warnings
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from fit_peers import Array, Distance, grid_triangles

import neurbs

SIDE = 400
MOST_POLES = 144
PLATE_POINTS = 400
SECONDS = 300

FREECAD = """
import sys, time
sys.path += ["/usr/lib/freecad-python3/lib", "/usr/lib/freecad/lib"]
import FreeCAD, ReverseEngineering
import numpy as np
points = [tuple(map(float, p)) for p in np.load(sys.argv[1])]
poles, side = int(sys.argv[3]), int(sys.argv[4])
start = time.time()
surface = ReverseEngineering.approxSurface(
    Points=points, UDegree=3, VDegree=3, NbUPoles=poles, NbVPoles=poles, Smooth=True,
    Weight=0.01, Grad=0.2, Bend=0.8, Iterations=10, Correction=True, PatchFactor=1.0)
seconds = time.time() - start
u0, u1, v0, v1 = surface.bounds()
u, v = np.linspace(u0, u1, side), np.linspace(v0, v1, side)
grid = [list(surface.value(a, b)) for a in u for b in v]
np.savez(sys.argv[2], grid=np.array(grid), seconds=seconds)
"""


def of_freecad(points: Array, poles: int) -> tuple[Array, str, float]:
    with tempfile.TemporaryDirectory() as folder:
        source, target = f"{folder}/points.npy", f"{folder}/grid.npz"
        np.save(source, points)
        words = ["/usr/bin/python3", "-c", FREECAD, source, target, str(poles), str(SIDE)]
        plain = {name: os.environ[name] for name in ("PATH", "HOME") if name in os.environ}
        subprocess.run(words, check=True, capture_output=True, timeout=SECONDS, env=plain)
        found = np.load(target)
        return found["grid"], f"{poles} × {poles}", float(found["seconds"])


def of_neurbs(points: Array, poles: int) -> tuple[Array, str, float]:
    start = time.perf_counter()
    result = neurbs.reconstruct(points, grid=(poles, poles))
    return sampled(result, time.perf_counter() - start)


def sampled(result: neurbs.Reconstruction, seconds: float) -> tuple[Array, str, float]:
    u, v = (np.linspace(*ends, SIDE) for ends in result.surface.domain)
    rows, cols = result.report.grid
    grid = result.surface.evaluate_grid(u, v).reshape(-1, 3)
    return grid, f"{rows} × {cols}", seconds


def of_opencascade(points: Array, poles: int) -> tuple[Array, str, float]:
    # In a process of its own: points that coincide crash it.
    with ProcessPoolExecutor(1) as pool:
        return pool.submit(plate, points, poles).result(SECONDS)


def plate(points: Array, _: int) -> tuple[Array, str, float]:
    from OCP.GeomPlate import (
        GeomPlate_BuildPlateSurface,
        GeomPlate_MakeApprox,
        GeomPlate_PointConstraint,
    )
    from OCP.gp import gp_Pnt

    tolerance = 1e-4 * float(np.linalg.norm(np.ptp(points, axis=0)))
    chosen = np.random.default_rng(0).permutation(len(points))[:PLATE_POINTS]
    start = time.perf_counter()
    builder = GeomPlate_BuildPlateSurface(3, 10, 2, 1e-5, tolerance, 0.01, 0.1, False)
    for point in points[chosen]:
        builder.Add(GeomPlate_PointConstraint(gp_Pnt(*map(float, point)), 0, tolerance))
    builder.Perform()
    error = max(1e-4, 10 * builder.G0Error())
    surface = GeomPlate_MakeApprox(builder.Surface(), tolerance, 16, 8, error, 0).Surface()
    seconds = time.perf_counter() - start
    u0, u1, v0, v1 = surface.Bounds()
    grid = [
        (point.X(), point.Y(), point.Z())
        for u in np.linspace(u0, u1, SIDE)
        for v in np.linspace(v0, v1, SIDE)
        for point in [surface.Value(u, v)]
    ]
    return np.array(grid), f"{surface.NbUPoles()} × {surface.NbVPoles()}", seconds


def of_pcl(points: Array, poles: int) -> tuple[Array, str, float]:
    # Each refinement halves the spans, of which there is one at first.
    refinements = max(1, int(np.log2(max(poles - 3, 2))))
    with tempfile.TemporaryDirectory() as folder:
        source, target = f"{folder}/points.xyz", f"{folder}/grid.txt"
        np.savetxt(source, points)
        words = [os.environ["PCL_FIT"], source, target, "pdm", "4", str(refinements), "10", "0.01"]
        words.append(str(SIDE))
        subprocess.run(words, check=True, capture_output=True, timeout=SECONDS)
        _, rows, cols, seconds = Path(target).read_text().split("\n", 1)[0].split()
        return np.loadtxt(target, skiprows=1), f"{rows} × {cols}", float(seconds)


def by_default(points: Array, _: int) -> tuple[Array, str, float]:
    start = time.perf_counter()
    result = neurbs.reconstruct(points)
    return sampled(result, time.perf_counter() - start)


PEERS: dict[str, Callable[[Array, int], tuple[Array, str, float]]] = {
    "neurbs, as many": of_neurbs,
    "freecad": of_freecad,
    "opencascade": of_opencascade,
} | ({"pcl": of_pcl} if "PCL_FIT" in os.environ else {})
FAILURES = (ImportError, RuntimeError, OSError, subprocess.SubprocessError)


def distances(points: Array, grid: Array) -> Array:
    return Distance(grid, grid_triangles(SIDE, SIDE, False, False))(points)[0]


def figures(points: Array, found: Array) -> str:
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    rms = float(np.sqrt(np.mean(found**2)))
    wanted = [rms, float(np.quantile(found, 0.99)), float(found.max())]
    return " | ".join(f"{1e4 * figure / diagonal:.2f}" for figure in wanted)


def line(name: str, peer: str, points: Array, found: tuple[Array, str, float]) -> str:
    grid, net, seconds = found
    shown = figures(points, distances(points, grid))
    return f"| {name} | {len(points):,} | {peer} | {net} | {shown} | {seconds:.2f} |"


def left_out(name: str, peer: str, points: Array, poles: int, folds: int) -> str:
    """Give a line of the distances of points that the surfaces did not see."""
    fold = np.random.default_rng(0).permutation(len(points)) % folds
    found: list[Array] = []
    fit = PEERS.get(peer, by_default)
    for k in range(folds):
        try:
            grid, _, _ = fit(points[fold != k], poles)
        except FAILURES:
            continue
        found.append(distances(points[fold == k], grid))
    shown = figures(points, np.concatenate(found)) if found else ""
    return f"| {name} | {peer} | {len(found)} of {folds} | {shown} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--clouds", help="parts of the names of those that are wanted")
    parser.add_argument("--pictures", type=Path, help="folder for a picture of each result")
    parser.add_argument("--left-out", type=int, metavar="FOLDS", help="measure points left out")
    parser.add_argument("--peers", default=";".join(PEERS))
    options = parser.parse_args()
    folder = os.environ.get("NEURBS_DATA")
    if folder is None:
        parser.exit(1, "NEURBS_DATA must be the folder of the clouds, but it is not set\n")
    if options.left_out:
        print("| cloud | by | folds | rms | 99 % | max |\n|---|---|---:|---:|---:|---:|")
    else:
        print("| cloud | points | by | net | rms | 99 % | max | seconds |")
        print("|---|---:|---|---|---:|---:|---:|---:|")
    # What a fit warns of belongs beside its picture, not into the table.
    warnings.simplefilter("ignore")
    for file in sorted(Path(folder, "npy").glob("*.npy")):
        if options.clouds and not any(part in file.stem for part in options.clouds.split(",")):
            continue
        points = np.load(file).astype(float)
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            start = time.perf_counter()
            result = neurbs.reconstruct(points)
            seconds = time.perf_counter() - start
        rows, cols = result.report.grid
        poles = round(min(rows * cols, MOST_POLES) ** 0.5)
        peers = list(filter(None, options.peers.split(";")))
        if options.left_out:
            for name in ["neurbs", *peers]:
                print(left_out(file.stem, name, points, poles, options.left_out), flush=True)
            continue
        print(line(file.stem, "neurbs", points, sampled(result, seconds)), flush=True)
        for name in peers:
            try:
                found = PEERS[name](points, poles)
            except FAILURES as error:
                print(f"| {file.stem} | | {name} | failed: {type(error).__name__} |", flush=True)
            else:
                print(line(file.stem, name, points, found), flush=True)
        if options.pictures:
            options.pictures.mkdir(exist_ok=True)
            Path(options.pictures, f"{file.stem}.txt").write_text(
                "\n".join([str(result.report), *(str(warning.message) for warning in said)])
            )
            figure = result.plot(color="deviation", backend="matplotlib")
            figure.savefig(Path(options.pictures, f"{file.stem}.png"), dpi=80)
            plt.close(figure)


if __name__ == "__main__":
    main()
