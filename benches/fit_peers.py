"""How near reconstructed surfaces come to shapes that are known exactly.

    python benches/fit_peers.py [--seeds 5] [--cases T1,T2_n] [--scipy | --auto] [--fresh]

Points are scattered over each shape evenly by area, without noise or (``_n``) with Gaussian noise
of 0.005 D in all directions, D being the diagonal of the shape's bounding box. Printed are, in
1e-4 D:

rms2
    root mean square of the distances from shape to surface and from surface to shape, from 20,000
    samples each. Left out are samples of the surface farther from all points than R, three times
    the 95 % quantile of the distance to the fourth nearest point (`far`), and those beyond the
    shape's border by more than 0.002 D (`over`): their areas are given in percent of the shape's.
core
    from the shape to the surface, farther than 1.5 mean spacings from the border
border
    the same on the rest

and the mean of the seconds that the calls took, each of them the first one of a process with
``--fresh``. What kind of surface the points lie on is given, unless it is found out (``--auto``).
"""

from __future__ import annotations

import argparse
import dataclasses
import itertools
import multiprocessing
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import LSQBivariateSpline
from scipy.spatial import cKDTree

import neurbs

Array = NDArray[np.float64]
Map = Callable[[Array, Array], Array]

NOISE = 0.005
SAMPLES = 20_000
#: Control points of a side of the budget, by the number of points.
SIDES = {200: 7, 2000: 12, 20_000: 20}
NAMES = ["T1", "T2", "T3", "T4", "T4L", "T5", "T5c", "T6"]
CASES = [f"{name}{noise}" for name in NAMES for noise in ("", "_n")] + ["T1_20000_n"]


@dataclasses.dataclass(frozen=True)
class Shape:
    """A surface known exactly: where points come from, a dense mesh, samples of its border."""

    scatter: Callable[[int, np.random.Generator], Array]
    vertices: Array
    triangles: NDArray[np.int64]
    border: Array
    kind: str = "sheet"

    @property
    def diagonal(self) -> float:
        """Length of the bounding box's diagonal."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))


def wave(u: Array, v: Array) -> Array:
    """T1: a height field over a square."""
    return np.column_stack([u, v, np.sin(3 * u) * np.cos(2 * v)])


def roll(u: Array, v: Array) -> Array:
    """T2: two thirds of a cylinder, with a bump."""
    angle, z = u * 4 * np.pi / 3, 2 * v
    r = 1 + 0.25 * np.exp(-((angle - 2) ** 2 + (z - 1.1) ** 2) / 0.15)
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), z])


def fold(u: Array, v: Array) -> Array:
    """T3: an S-shaped fold, its middle bulging."""
    t = 3 * np.pi * (u - 0.5)
    d = 0.12 * np.sin(np.pi * v) * np.sin(2 * t) + 0.1 * (v - 0.5) ** 2
    x, z = np.sin(t), np.sign(t) * (np.cos(t) - 1)
    tx, tz = np.cos(t), -np.sign(t) * np.sin(t)
    return np.column_stack([x - tz * d, 2 * v, z + tx * d])


def saddle(x: Array, y: Array) -> Array:
    """T4: a saddle over an ellipse."""
    return np.column_stack([x, y, 0.5 * (x**2 - 2 * y**2) + 0.12 * np.sin(4 * x)])


def ellipse(u: Array, v: Array) -> Array:
    r, angle = np.sqrt(u), 2 * np.pi * v
    return saddle(r * np.cos(angle), 0.6 * r * np.sin(angle))


def bent(x: Array, y: Array) -> Array:
    """T4L: a saddle over an L."""
    return np.column_stack([x, y, 0.35 * (x - 1) * (y - 1) + 0.15 * np.sin(2.5 * x)])


def ring(u: Array, v: Array) -> Array:
    """T5: a torus."""
    a, b = 2 * np.pi * u, 2 * np.pi * v
    r = 1 + 0.4 * np.cos(b)
    return np.column_stack([r * np.cos(a), r * np.sin(a), 0.4 * np.sin(b)])


def pipe(u: Array, v: Array) -> Array:
    """T5c: a tube whose section changes along it."""
    a = 2 * np.pi * u
    r = 0.5 * (1 + 0.25 * np.sin(2 * np.pi * v) * np.cos(a) + 0.15 * np.cos(3 * a) * v)
    return np.column_stack([r * np.cos(a), r * np.sin(a), 2 * v])


def dome(u: Array, v: Array) -> Array:
    """T6: a hemisphere."""
    polar, a = 0.5 * np.pi * u, 2 * np.pi * v
    return np.column_stack([np.sin(polar) * np.cos(a), np.sin(polar) * np.sin(a), np.cos(polar)])


def grid_triangles(rows: int, cols: int, closed_u: bool, closed_v: bool) -> NDArray[np.int64]:
    i, j = np.meshgrid(
        np.arange(rows if closed_u else rows - 1),
        np.arange(cols if closed_v else cols - 1),
        indexing="ij",
    )
    a, b = (i * cols + j).ravel(), (((i + 1) % rows) * cols + j).ravel()
    c, d = (((i + 1) % rows) * cols + (j + 1) % cols).ravel(), (i * cols + (j + 1) % cols).ravel()
    return np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])


def by_area(
    shape: Map, density: Callable[[Array, Array], Array] | None = None
) -> Callable[..., Array]:
    """Scatter points evenly over the image of the unit square (times a density)."""

    def area(u: Array, v: Array) -> Array:
        h = 1e-5
        normal = np.cross(shape(u + h, v) - shape(u - h, v), shape(u, v + h) - shape(u, v - h))
        length: Array = np.linalg.norm(normal, axis=1)
        return length if density is None else length * density(u, v)

    most = 1.2 * area(*np.random.default_rng(1).random((2, 4000))).max()

    def scatter(count: int, rng: np.random.Generator) -> Array:
        found = np.empty((0, 3))
        while len(found) < count:
            u, v = rng.random((2, 4 * count))
            kept = rng.random(4 * count) * most < area(u, v)
            found = np.vstack([found, shape(u[kept], v[kept])])
        return found[:count]

    return scatter


def of_map(shape: Map, closed: tuple[bool, bool] = (False, False), kind: str = "sheet") -> Shape:
    count = 401
    u, v = (np.arange(count) / (count if c else count - 1) for c in closed)
    grid = [axis.ravel() for axis in np.meshgrid(u, v, indexing="ij")]
    along, ends = np.linspace(0, 1, 800), (0.0, 1.0)
    border = [np.empty((0, 3))]
    if not closed[0]:
        border += [shape(np.full(800, end), along) for end in ends]
    if not closed[1]:
        border += [shape(along, np.full(800, end)) for end in ends]
    triangles = grid_triangles(count, count, *closed)
    return Shape(by_area(shape), shape(*grid), triangles, np.vstack(border), kind)


def over_ellipse() -> Shape:
    """Points are eight times denser at one end than at the other."""

    def scatter(count: int, rng: np.random.Generator) -> Array:
        x, y = rng.uniform(-1, 1, (2, 12 * count))
        y *= 0.6
        dense = rng.random(len(x)) < np.exp(-1.04 * (x + 1))
        kept = (x**2 + (y / 0.6) ** 2 < 1) & dense
        return saddle(x[kept][:count], y[kept][:count])

    polar = of_map(lambda u, v: ellipse(u**2, v), (False, True))
    border = ellipse(np.ones(1600), np.linspace(0, 1, 1600))
    return Shape(scatter, polar.vertices, polar.triangles, border)


def over_l() -> Shape:
    def scatter(count: int, rng: np.random.Generator) -> Array:
        x, y = rng.uniform(0, 2, (2, 4 * count))
        kept = ~((x > 1) & (y > 1))
        return bent(x[kept][:count], y[kept][:count])

    square = of_map(lambda u, v: bent(2 * u, 2 * v))
    middle = square.vertices[square.triangles].mean(axis=1)
    triangles = square.triangles[~((middle[:, 0] > 1) & (middle[:, 1] > 1))]
    corners = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2], [0, 0]], float)
    sides = [np.linspace(a, b, 400) for a, b in itertools.pairwise(corners)]
    outline = np.vstack(sides)
    return Shape(scatter, square.vertices, triangles, bent(outline[:, 0], outline[:, 1]))


def shapes() -> dict[str, Shape]:
    rim = of_map(dome, (False, True))
    return {
        "T1": of_map(wave),
        "T2": of_map(roll),
        "T3": of_map(fold),
        "T4": over_ellipse(),
        "T4L": over_l(),
        "T5": of_map(ring, (True, True), "torus"),
        "T5c": of_map(pipe, (True, False), "tube"),
        "T6": dataclasses.replace(rim, border=dome(np.ones(1600), np.linspace(0, 1, 1600))),
    }


def areas(vertices: Array, triangles: NDArray[np.int64]) -> Array:
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    lengths: Array = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return 0.5 * lengths


def samples(vertices: Array, triangles: NDArray[np.int64], rng: np.random.Generator) -> Array:
    area = areas(vertices, triangles)
    chosen = triangles[rng.choice(len(triangles), SAMPLES, p=area / area.sum())]
    s, t = rng.random((2, SAMPLES, 1))
    flip = s + t > 1
    s, t = np.where(flip, 1 - s, s), np.where(flip, 1 - t, t)
    a, b, c = vertices[chosen].transpose(1, 0, 2)
    points: Array = a + s * (b - a) + t * (c - a)
    return points


class Distance:
    """Distances to a dense mesh: the exact one among the triangles whose middles are nearest."""

    def __init__(self, vertices: Array, triangles: NDArray[np.int64]) -> None:
        self.corners = vertices[triangles]
        self.middles = self.corners.mean(axis=1)
        self.tree = cKDTree(self.middles)

    def __call__(self, points: Array) -> tuple[Array, Array]:
        """Return the distances, and the middles of the triangles nearest to the points."""
        _, near = self.tree.query(points, k=12)
        distances = np.stack([to_triangle(points, self.corners[n]) for n in near.T])
        best = distances.argmin(axis=0)
        rows = np.arange(len(points))
        return distances[best, rows], self.middles[near[rows, best]]


def to_triangle(points: Array, corners: Array) -> Array:
    """Distances from points to triangles, one by one: to the plane's foot, or to the edges."""
    a, b, c = corners.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    height = np.einsum("ij,ij->i", points - a, normal)
    inside = np.ones(len(points), bool)
    nearest = np.full(len(points), np.inf)
    for p, q in ((a, b), (b, c), (c, a)):
        edge, rest = q - p, points - p
        inside &= np.einsum("ij,ij->i", np.cross(edge, rest), normal) >= 0
        square = np.maximum(np.einsum("ij,ij->i", edge, edge), 1e-300)
        share = np.clip(np.einsum("ij,ij->i", rest, edge) / square, 0, 1)[:, None]
        nearest = np.minimum(nearest, np.linalg.norm(rest - share * edge, axis=1))
    return np.where(inside, np.abs(height), nearest)


def score(
    shape: Shape, points: Array, vertices: Array, triangles: NDArray[np.int64]
) -> dict[str, float]:
    rng = np.random.default_rng(7)
    diagonal, area = shape.diagonal, areas(shape.vertices, shape.triangles).sum()
    fitted_area = areas(vertices, triangles).sum()
    reach = 3 * np.quantile(cKDTree(points).query(points, k=5)[0][:, -1], 0.95)
    on_shape = samples(shape.vertices, shape.triangles, rng)
    on_surface = samples(vertices, triangles, rng)
    to_surface, _ = Distance(vertices, triangles)(on_shape)
    to_shape, foot = Distance(shape.vertices, shape.triangles)(on_surface)
    outside, strip = np.zeros((2, SAMPLES), bool)
    if len(shape.border):
        border = cKDTree(shape.border)
        outside = (border.query(foot)[0] < 0.004 * diagonal) & (to_shape > 0.002 * diagonal)
        strip = border.query(on_shape)[0] < 1.5 * np.sqrt(area / len(points))
    far = ~outside & (cKDTree(points).query(on_surface)[0] >= reach)
    kept = to_shape[~outside & ~far]

    def rms(distances: Array) -> float:
        if len(distances) == 0:
            return float("nan")
        return 1e4 * float(np.sqrt(np.mean(distances**2))) / diagonal

    return {
        "rms2": float(np.sqrt((rms(to_surface) ** 2 + rms(kept) ** 2) / 2)),
        "core": rms(to_surface[~strip]),
        "border": rms(to_surface[strip]),
        "over": 100 * float(outside.mean()) * fitted_area / area,
        "far": 100 * float(far.mean()) * fitted_area / area,
    }


def case_points(name: str, shape: Shape, seed: int) -> tuple[Array, int]:
    """Scatter the points of a case; with them comes the side of the budget."""
    parts = name.split("_")
    count = next((int(part) for part in parts if part.isdigit()), 2000)
    key = sum(map(ord, parts[0]))
    rng = np.random.default_rng([20240607, key, count, seed])
    points = shape.scatter(count, rng)
    if parts[-1] == "n":
        points = points + NOISE * shape.diagonal * rng.standard_normal(points.shape)
    return points, SIDES[count]


def run_neurbs(
    shape: Shape, points: Array, side: int, kind: str | None = None
) -> tuple[Array, NDArray[np.int64], float]:
    start = time.perf_counter()
    result = neurbs.reconstruct(points, grid=(side, side), kind=kind or shape.kind)
    seconds = time.perf_counter() - start
    # The faces: beyond the points they are trimmed.
    mesh = result.shell.tessellate(max_edge=result.report.diagonal / 150)
    return mesh.vertices, mesh.triangles.astype(np.int64), seconds


def run_auto(shape: Shape, points: Array, side: int) -> tuple[Array, NDArray[np.int64], float]:
    return run_neurbs(shape, points, side, "auto")


def run_fresh(
    run: Callable[[Shape, Array, int], tuple[Array, NDArray[np.int64], float]],
    name: str,
    seed: int,
) -> tuple[Array, NDArray[np.int64], float]:
    """Make a cloud and reconstruct it, in a process that has done nothing else."""
    shape = shapes()[name.split("_")[0]]
    return run(shape, *case_points(name, shape, seed))


def run_scipy(shape: Shape, points: Array, side: int) -> tuple[Array, NDArray[np.int64], float]:
    """SciPy's least squares over x and y, for those shapes whose z is a function of them."""
    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    start = time.perf_counter()
    knots = [np.linspace(a, b, side - 2)[1:-1] for a, b in zip(low, high, strict=True)]
    spline = LSQBivariateSpline(*points.T, *knots)
    seconds = time.perf_counter() - start
    axes = [np.linspace(a, b, 250) for a, b in zip(low, high, strict=True)]
    x, y = (axis.ravel() for axis in np.meshgrid(*axes, indexing="ij"))
    vertices = np.column_stack([x, y, spline.ev(x, y)])
    return vertices, grid_triangles(250, 250, False, False), seconds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--cases", default=",".join(CASES))
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--scipy", action="store_true", help="run SciPy's spline instead")
    parser.add_argument("--auto", action="store_true", help="find out what kind of surface it is")
    parser.add_argument("--fresh", action="store_true", help="in a process of its own each")
    options = parser.parse_args()
    run = run_scipy if options.scipy else run_auto if options.auto else run_neurbs
    known = shapes()
    if options.fresh:
        processes = multiprocessing.get_context("spawn").Pool(1, maxtasksperchild=1)
    print("| case | rms2 | worst seed | core | border | over % | far % | seconds |")
    print("|---|---|---|---|---|---|---|---|")
    for name in options.cases.split(","):
        shape = known[name.split("_")[0]]
        scores, seconds = [], []
        for seed in range(options.seeds):
            points, side = case_points(name, shape, seed)
            if options.fresh:
                vertices, triangles, taken = processes.apply(run_fresh, (run, name, seed))
            else:
                vertices, triangles, taken = run(shape, points, side)
            scores.append(score(shape, points, vertices, triangles))
            seconds.append(taken)
        mean = {key: np.mean([found[key] for found in scores]) for key in scores[0]}
        worst = max(found["rms2"] for found in scores)
        print(
            f"| {name} | {mean['rms2']:.2f} | {worst:.2f} | {mean['core']:.2f} "
            f"| {mean['border']:.2f} | {mean['over']:.1f} | {mean['far']:.1f} "
            f"| {np.mean(seconds):.3f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
