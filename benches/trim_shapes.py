"""How well ``neurbs.trim`` finds the outlines of shapes from points in them.

    python benches/trim_shapes.py [--points 3000] [--seeds 3] [--noise 0] [--squares 1000] [--large]
                                  [--clouds FOLDER]

Prints a table: seven shapes with each sampling. Lengths are in spacings, the side of a square with
one point each.

right
    Clouds with the right number of holes and one face, of all. Loops are proved to be simple.
bias
    Median of the face's area over the true one, less 1.
error
    Median and largest area of the symmetric difference over perimeter and spacing.
distance
    Median and largest Hausdorff distance of all loops.
corners
    Corners of the shapes with a corner of the face within 3.5 spacings, of all.
false
    Corners of the face, of more than 20 degrees, without a corner of the shape.
seconds
    Mean time of a call.

Then it counts random squares of 1,000 points that get a hole, and squares with a disc of radius 3
cut out whose hole is missed, or that get another one. ``--large`` adds times of large clouds.
``--clouds`` adds the real clouds in a folder: ``*.npy``, each reconstructed, then trimmed.

outside
    Points more than 0.75 local spacings outside of the faces, of all.
far
    Area of the faces farther than 1.5 local spacings from every point, of all.
beyond
    Area of the surface outside of the faces, over that of the faces.
"""

import argparse
import time
import warnings
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay, cKDTree

import neurbs

Array = NDArray[np.float64]
Rings = list[Array]

NEAR = 3.5
BEND = np.radians(20)
ROWS = 2000
CELLS = 400
SAMPLINGS = ("random", "grid", "falling", "lines")


def around(radius: Array, start: float = 0.0, middle: tuple[float, float] = (0.5, 0.5)) -> Array:
    """Return the polygon with these radii at even angles around a point."""
    angle = start + np.arange(len(radius)) / len(radius) * 2 * np.pi
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], 1) + middle


def shapes() -> dict[str, tuple[Rings, Array]]:
    """Return the shapes: polygons, the outline first, and corners."""
    disc, none = around(np.full(512, 0.5)), np.empty((0, 2))
    angle = np.arange(800) / 800 * 2 * np.pi
    blob = around(0.36 + 0.08 * np.cos(3 * angle) + 0.05 * np.sin(5 * angle))
    star = around(np.where(np.arange(10) % 2 == 0, 0.5, 0.23), np.pi / 2)
    rectangle = np.array([(0, 0), (1, 0), (1, 0.7), (0, 0.7)], float)
    window = np.array([(0.2, 0.2), (0.45, 0.2), (0.45, 0.5), (0.2, 0.5)])
    corner = np.array([(0, 0), (1, 0), (1, 0.4), (0.4, 0.4), (0.4, 1), (0, 1)], float)
    holes = [around(np.full(512, 0.11), 0, (0.32, 0.5)), around(np.full(512, 0.14), 0, (0.68, 0.6))]
    bore = around(np.full(512, 0.13), 0, (0.72, 0.35))
    return {
        "disc with two holes": ([disc, *holes], none),
        "L": ([corner], corner),
        "annulus": ([disc, around(np.full(512, 0.25))], none),
        "star": ([star], star),
        "rectangle": ([rectangle], rectangle),
        "plate": ([rectangle, window, bore], np.concatenate([rectangle, window])),
        "blob": ([blob], none),
    }


def sides(rings: Rings) -> tuple[Array, Array]:
    """Return the ends of all sides."""
    return np.concatenate(rings), np.concatenate([np.roll(ring, -1, 0) for ring in rings])


def crossings(rings: Rings, y: float) -> Array:
    """Return where a line of constant y crosses rings."""
    a, b = sides(rings)
    crossed = (a[:, 1] > y) != (b[:, 1] > y)
    a, b = a[crossed], b[crossed]
    return a[:, 0] + (y - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])


def inside(rings: Rings, points: Array) -> NDArray[np.bool_]:
    """Return which points are inside, by even and odd crossings."""
    count = np.zeros(len(points), int)
    for a, b in zip(*sides(rings), strict=True):
        if a[1] == b[1]:
            continue
        crossed = (a[1] > points[:, 1]) != (b[1] > points[:, 1])
        at = a[0] + (points[:, 1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        count += crossed & (points[:, 0] < at)
    return count % 2 == 1


def difference(a: Rings, b: Rings) -> float:
    """Return the area that is inside of one shape and outside of the other."""
    y = np.concatenate(a + b)[:, 1]
    step = np.ptp(y) / ROWS
    area = 0.0
    for k in range(ROWS):
        height = y.min() + (k + 0.5) * step
        at = np.sort(np.concatenate([crossings(rings, height) for rings in (a, b) if rings]))
        area += (at[1::2] - at[::2]).sum() * step
    return float(area)


def scattered(rings: Rings, count: int, rng: np.random.Generator, fall: float) -> Array:
    """Return random points; their density falls along x."""
    points = np.empty((0, 2))
    while len(points) < count:
        more = rng.random((4 * count, 2))
        more = more[rng.random(len(more)) < fall ** more[:, 0]]
        points = np.concatenate([points, more[inside(rings, more)]])
    return points[:count]


def sample(rings: Rings, count: int, how: str, rng: np.random.Generator) -> Array:
    """Return about so many points of a shape."""
    if how in ("random", "falling"):
        return scattered(rings, count, rng, 1.0 if how == "random" else 0.1)
    step = np.full(2, np.sqrt(difference(rings, []) / count))
    angle = 0.3
    if how == "lines":
        step *= (1 / np.sqrt(6), np.sqrt(6))
        angle = 0.0
    reach = int(np.ceil(2 / step.min()))
    grid = np.stack(np.meshgrid(*[np.arange(-reach, reach)] * 2), -1).reshape(-1, 2) * step
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    points = grid @ turn + rng.random(2) * step + 0.5
    points = points[((points >= 0) & (points <= 1)).all(1)]
    return points[inside(rings, points)]


def sheet(low: Array, high: Array) -> neurbs.NurbsSurface:
    """Return a wavy height field whose parameters are x and y."""
    knots = np.concatenate([np.zeros(3), np.linspace(0, 1, 12), np.ones(3)])
    places = np.array([knots[k + 1 : k + 4].mean() for k in range(14)])
    x, y = np.meshgrid(*(low + (high - low) * places[:, None]).T, indexing="ij")
    net = np.stack([x, y, 0.08 * np.sin(3 * x) * np.cos(2 * y)], -1)
    knots_u, knots_v = (low + (high - low) * knots[:, None]).T
    return neurbs.NurbsSurface(net, knots=(knots_u, knots_v))


def polygon(loop: list[neurbs.NurbsCurve]) -> Array:
    """Return a loop of curves as a polygon."""
    parts = []
    for curve in loop:
        count = 8 * len(curve.control_points)
        parts.append(curve.evaluate(np.linspace(*curve.domain, count, endpoint=False))[:, :2])
    return np.concatenate(parts)


def joints(loop: list[neurbs.NurbsCurve]) -> list[Array]:
    """Return the places where curves of a loop meet at an angle."""
    found = []
    for curve, after in zip(loop, [*loop[1:], loop[0]], strict=True):
        along = np.diff(curve.control_points[-2:, :2], axis=0)[0]
        ahead = np.diff(after.control_points[:2, :2], axis=0)[0]
        cosine = along @ ahead / np.linalg.norm(along) / np.linalg.norm(ahead)
        if np.arccos(np.clip(cosine, -1, 1)) > BEND:
            found.append(after.control_points[0, :2])
    return found


def dense(rings: Rings, step: float) -> Array:
    """Return points along rings."""
    parts = []
    for a, b in zip(*sides(rings), strict=True):
        count = int(np.ceil(np.linalg.norm(b - a) / step)) + 1
        parts.append(a + np.linspace(0, 1, count, endpoint=False)[:, None] * (b - a))
    return np.concatenate(parts)


def hausdorff(a: Rings, b: Rings, spacing: float) -> float:
    """Return the Hausdorff distance of the loops, in spacings."""
    p, q = dense(a, 0.3 * spacing), dense(b, 0.3 * spacing)
    return float(max(cKDTree(p).query(q)[0].max(), cKDTree(q).query(p)[0].max()) / spacing)


def within(a: Array, b: list[Array] | Array, distance: float) -> int:
    """Return how many places of `a` have one of `b` near."""
    if len(a) == 0 or len(b) == 0:
        return 0
    return int((cKDTree(np.asarray(b)).query(a)[0] < distance).sum())


def table(options: argparse.Namespace) -> None:
    """Print a row for each sampling."""
    print("| sampling | right | bias | error | distance | corners | false | seconds |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for how in SAMPLINGS:
        rows = []
        for number, (rings, corners) in enumerate(shapes().values()):
            for seed in range(options.seeds):
                rng = np.random.default_rng([seed, number])
                points = sample(rings, options.points, how, rng)
                points += options.noise * rng.standard_normal(points.shape)
                area, length = (
                    difference(rings, []),
                    sum(np.linalg.norm(b - a) for a, b in zip(*sides(rings), strict=True)),
                )
                spacing = np.sqrt(area / len(points))
                box = points.min(0) - 0.4 * spacing, points.max(0) + 0.4 * spacing
                surface = sheet(*box)
                start = time.perf_counter()
                faces = neurbs.trim(surface, points).faces
                seconds = time.perf_counter() - start
                loops = [loop for face in faces for loop in face.loops]
                found = [polygon(loop) for loop in loops]
                bends = [joint for loop in loops for joint in joints(loop)]
                near = NEAR * spacing
                rows.append(
                    (
                        len(faces) == 1 and len(loops) == len(rings),
                        difference(found, []) / area - 1,
                        difference(found, rings) / (length * spacing),
                        hausdorff(found, rings, spacing),
                        within(corners, bends, near),
                        len(corners),
                        len(bends) - within(np.array(bends), corners, near),
                        seconds,
                    )
                )
        right, bias, error, distance, hits, all_corners, wrong, seconds = np.array(rows).T
        print(
            f"| {how} | {right.sum():.0f} of {len(rows)} "
            f"| {100 * np.median(bias):+.1f} % | {np.median(error):.2f}, {error.max():.2f} "
            f"| {np.median(distance):.2f}, {distance.max():.2f} "
            f"| {hits.sum():.0f} of {all_corners.sum():.0f} | {wrong.sum():.0f} "
            f"| {seconds.mean():.3f} |",
            flush=True,
        )


def squares(count: int) -> None:
    """Print how many random squares have false or missed holes."""
    size, surface = 1000, sheet(np.zeros(2), np.ones(2))
    radius = 3 / np.sqrt(size)
    wrong = missed = second = 0
    for seed in range(count):
        rng = np.random.default_rng(seed)
        wrong += len(neurbs.trim(surface, rng.random((size, 2))).faces[0].inner) > 0
        middle = rng.uniform(0.2, 0.8, 2)
        points = rng.random((2 * size, 2))
        points = points[np.linalg.norm(points - middle, axis=1) > radius][:size]
        face = neurbs.trim(surface, points).faces[0]
        missed += bool(inside([polygon(loop) for loop in face.loops], middle[None])[0])
        second += len(face.inner) > 1
    print(
        f"\n{count} squares: {wrong} with a hole; "
        f"with a disc cut out: {missed} missed, {second} with two."
    )


def large() -> None:
    """Print the times of large clouds."""
    rings, _ = shapes()["disc with two holes"]
    surface = sheet(np.zeros(2), np.ones(2))
    for count in (10_000, 100_000, 1_000_000):
        points = scattered(rings, count, np.random.default_rng(0), 1.0)
        wall, work = time.perf_counter(), time.process_time()
        neurbs.trim(surface, points)
        wall, work = time.perf_counter() - wall, time.process_time() - work
        print(f"{count} points: {wall:.2f} s, {work:.2f} s of all cores", flush=True)


def local_spacing(surface: neurbs.NurbsSurface, uv: Array) -> Array:
    """Return the spacing at each point: medians of circumradii in space over 40 neighbors."""
    points = surface.evaluate(uv)
    lengths = np.linalg.norm(surface.derivatives(uv, 1)[:, [1, 0], [0, 1]], axis=-1).mean(0)
    triangles = Delaunay(uv * lengths).simplices
    a, b, c = (points[triangles[:, k]] for k in range(3))
    product = np.prod([np.linalg.norm(p - q, axis=1) for p, q in ((a, b), (b, c), (c, a))], axis=0)
    radii = product / np.maximum(2 * np.linalg.norm(np.cross(b - a, c - a), axis=1), 1e-300)
    near = cKDTree((a + b + c) / 3).query(points, 40)[1]
    return np.asarray(np.median(radii[near], axis=1) / 0.7309)


def cloud_row(points: Array) -> str:
    """Return the measures of a cloud as a row of a table."""
    start = time.perf_counter()
    result = neurbs.reconstruct(points)
    fitted = time.perf_counter()
    surface, uv = result.surface, np.unique(result.uv[result.inliers], axis=0)
    shell = neurbs.trim(surface, uv)
    trimmed = time.perf_counter()
    spacing = local_spacing(surface, uv)
    feet = surface.evaluate(uv)
    away = np.min([face.closest_points(feet).distances for face in shell.faces], axis=0)
    (u0, u1), (v0, v1) = surface.domain
    u, v = ((np.arange(CELLS) + 0.5) / CELLS * (b - a) + a for a, b in ((u0, u1), (v0, v1)))
    cells = np.stack(np.meshgrid(u, v, indexing="ij"), -1).reshape(-1, 2)
    cells = cells[np.any([face.contains(cells) for face in shell.faces], axis=0)]
    by_v, by_u = surface.derivatives(cells, 1)[:, [0, 1], [1, 0]].swapaxes(0, 1)
    area = np.linalg.norm(np.cross(by_u, by_v), axis=1)
    distance, nearest = cKDTree(feet).query(surface.evaluate(cells))
    far = area[distance > 1.5 * spacing[nearest]].sum() / area.sum()
    loops = [len(face.loops) for face in shell.faces]
    return (
        f"| {len(loops)} | {sum(loops) - len(loops)} | {np.mean(away > 0.75 * spacing):.2%} "
        f"| {far:.2%} | {surface.area() / shell.area() - 1:.1%} "
        f"| {fitted - start:.2f} | {trimmed - fitted:.2f} "
        f"| {max(len(loop) for face in shell.faces for loop in face.loops)} |"
    )


def clouds(folder: Path) -> None:
    """Print a row for each cloud in a folder."""
    print("\n| cloud | faces | holes | outside | far | beyond | fit | trim | curves |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    warnings.simplefilter("ignore")
    for path in sorted(folder.glob("*.npy")):
        print(f"| {path.stem} {cloud_row(np.load(path))}", flush=True)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--points", type=int, default=3000)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--noise", type=float, default=0.0, help="sideways, in the shapes' unit")
    parser.add_argument("--squares", type=int, default=1000)
    parser.add_argument("--large", action="store_true")
    parser.add_argument("--clouds", type=Path)
    options = parser.parse_args()
    table(options)
    if options.squares:
        squares(options.squares)
    if options.large:
        large()
    if options.clouds:
        clouds(options.clouds)


if __name__ == "__main__":
    main()
