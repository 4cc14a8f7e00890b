"""The pictures of the stages: `pictures.py` makes them."""

import warnings
from collections.abc import Iterable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

import neurbs

Array = NDArray[np.float64]

TERRAIN = Path(__file__).parents[1] / "examples" / "jacksboro.xyz"
INK, BLUE, ORANGE, GRAY, PALE = "#22323a", "#1d5b86", "#c8602b", "#9aa5ab", "#e8eef2"
TERMS = ("#1d5b86", "#c8602b", "#3c7f7a", "#b08d2f", "#7b5ea7", "#9aa5ab", "#a83f55", "#22323a")
GRAY_TO_ORANGE = mpl.colors.LinearSegmentedColormap.from_list("", ["#c9d1d5", ORANGE, "#7a2408"])
GROUPS = 5


def flow(path: Path) -> None:
    """Draw how a surface is chosen."""
    stages = [
        ("1 prepare", "leave out outliers,\nmerge duplicates"),
        ("2 observe", "local planes, noise,\nneighbors, border"),
        ("3 propose", "each chart gives the\npoints parameters"),
        ("4 coarse fit", "a small net for each\nhypothesis, held-out error"),
        ("5 select", "one score,\nthe lowest wins"),
        ("6 refine", "all points: sides,\ngrowth, outliers, tolerance"),
        ("7 validate, repair", "defects? more fairness,\nelse the next in rank"),
        ("8 measure", "project all points,\ndiagnostics, report"),
    ]
    figure = Figure(figsize=(9.6, 3.4))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(0, 9.6), ylim=(0, 3.4))
    axes.axis("off")
    width, height = 1.95, 0.86
    boxes = [(1.2 + 2.4 * (at if at < 4 else 7 - at), 2.5 if at < 4 else 1.1) for at in range(8)]
    for (name, text), (x, y) in zip(stages, boxes, strict=True):
        low = (x - 0.5 * width, y - 0.5 * height)
        axes.add_patch(Rectangle(low, width, height, facecolor=PALE, edgecolor=BLUE))
        center: dict[str, Any] = {"ha": "center", "va": "center"}
        axes.text(x, y + 0.25, name, size=10, weight="bold", color=BLUE, **center)
        axes.text(x, y - 0.12, text, size=8, color=INK, **center)
    arrow: dict[str, Any] = {"arrowstyle": "-|>", "color": INK, "shrinkA": 0, "shrinkB": 0}
    for (x, y), (to, below) in pairwise(boxes):
        side = np.sign(to - x)
        start, end = (x + 0.5 * width * side, y), (to - 0.5 * width * side, below)
        if side == 0:
            start, end = (x, y - 0.5 * height), (to, below + 0.5 * height)
        axes.annotate("", end, start, arrowprops=arrow)
    (refine, y), (validate, _), (last, _) = boxes[5:]
    back = {**arrow, "color": ORANGE, "connectionstyle": "bar,fraction=0.13", "linestyle": "--"}
    foot = y - 0.5 * height
    axes.annotate("", (refine, foot), (validate, foot), arrowprops=back)
    label: dict[str, Any] = {"ha": "center", "va": "center", "size": 9}
    axes.text(0.5 * (refine + validate), 0.2, "next in rank", color=ORANGE, **label)
    axes.annotate(
        "points", (boxes[0][0], 2.5 + 0.5 * height), (boxes[0][0], 3.25), arrowprops=arrow, **label
    )
    axes.annotate("", (last, 0.35), (last, foot), arrowprops=arrow)
    axes.text(last, 0.2, "surface", **label)
    with mpl.rc_context({"svg.hashsalt": "neurbs"}):
        figure.savefig(path, metadata={"Date": None})


def prepare(path: Path) -> None:
    """Draw the outliers that cleaning finds in a cloud, and those that its surface shows."""
    rng = np.random.default_rng(0)
    angle, y = rng.random((2, 900)) * [[np.pi], [2.0]]
    arch = np.column_stack([np.cos(angle), y, np.sin(angle)]) + rng.normal(0, 0.01, (900, 3))
    strays = rng.uniform([-1.5, 0, -0.2], [1.5, 2, 1.6], (25, 3))
    points = np.vstack([arch, strays, arch[:40]])
    kept = np.zeros(len(points), dtype=bool)
    kept[neurbs.clean(points).kept] = True
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", neurbs.LeftOutWarning)
        used = neurbs.reconstruct(points).inliers
    late = np.flatnonzero(kept & ~used)
    early = np.setdiff1d(np.arange(len(arch) + len(strays)), np.flatnonzero(kept))
    figure, (before, after) = row(2, (7.2, 2.9))
    before.scatter(points[:, 0], points[:, 2], s=3, color=INK)
    before.set_title("given", size=10)
    after.scatter(points[used, 0], points[used, 2], s=3, color=BLUE)
    after.scatter(points[early, 0], points[early, 2], s=12, color=ORANGE, marker="x")
    after.scatter(points[late, 0], points[late, 2], s=20, facecolors="none", edgecolors=ORANGE)
    after.set_title("crosses: left out here; circles: in refine", size=10)
    finish(path, figure, (before, after))


def observe(path: Path) -> None:
    """Draw the links of a rolled sheet across it, and the border points of a sheet with a hole."""
    figure, (graph, border) = row(2, (7.2, 3.2))
    rng = np.random.default_rng(1)
    # Layers 3.4 spacings apart: planes of six neighbors see one layer, eight neighbors see two.
    along = 0.04 * (np.arange(280) + 0.3 * rng.random(280))
    radius = np.sqrt(0.25 + 0.0216 * 2 * along)
    turn = (radius - 0.5) / 0.0216
    roll = np.column_stack([radius * np.cos(turn), radius * np.sin(turn)])
    near = nearest(roll, 9)
    normals = np.array([np.linalg.svd(c - c.mean(0))[2][-1] for c in roll[near[:, :7]]])
    pairs = np.array([(at, to) for at in range(len(roll)) for to in near[at, 1:]])
    ways = roll[pairs[:, 1]] - roll[pairs[:, 0]]
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    sines = [np.abs((ways * normals[pairs[:, end]]).sum(1)) for end in (0, 1)]
    dropped = np.maximum(*sines) > 0.6
    for chosen, color in ((~dropped, BLUE), (dropped, ORANGE)):
        graph.add_collection(LineCollection(list(roll[pairs[chosen]]), colors=color, lw=0.8))
    graph.scatter(roll[:, 0], roll[:, 1], s=4, color=INK, zorder=3)
    graph.set_title("links across a roll: kept (blue), dropped (orange)", size=10)
    flat = rng.random((1600, 2))
    flat = flat[np.hypot(*(flat - 0.5).T) > 0.2]
    ways = flat[nearest(flat, 17)[:, 1:]] - flat[:, None]
    angles = np.sort(np.arctan2(ways[..., 1], ways[..., 0]), axis=1)
    gaps = np.diff(np.column_stack([angles, angles[:, 0] + 2 * np.pi]), axis=1).max(1)
    open_ = gaps > 2.8
    border.scatter(flat[~open_, 0], flat[~open_, 1], s=3, color=GRAY)
    border.scatter(flat[open_, 0], flat[open_, 1], s=8, color=ORANGE)
    border.set_title("border points (orange) of a sheet with a hole", size=10)
    finish(path, figure, (graph, border))


def propose(path: Path) -> None:
    """Draw clouds with the parameters that the winning chart gives them."""
    figure = Figure(figsize=(9, 6))
    for at, points in enumerate(shapes()):
        result = neurbs.reconstruct(points)
        axes = figure.add_subplot(2, 3, at + 1, projection="3d")
        draw_checkered(axes, result.surface)
        chart = next(one for one in result.report.candidates if one.outcome.startswith("chosen"))
        axes.set_title(f"{chart.chart}: {chart.kind}", size=10, y=1.04)
    figure.subplots_adjust(0, 0, 1, 0.93, 0, 0.16)
    figure.savefig(path, dpi=80)


def coarse_fit(path: Path) -> None:
    """Draw the two ways in which points are left out of a coarse fit."""
    points = neurbs.read_points(TERRAIN)[:2000, :2]
    figure, panels = row(2, (7.2, 3.6))
    at = np.arange(len(points))
    titles = ("random", "blocks in space")
    for axes, title, groups in zip(
        panels, titles, ((at * 7 + at // GROUPS) % GROUPS, blocks(points)), strict=True
    ):
        out = groups == 0
        axes.scatter(points[~out, 0], points[~out, 1], s=3, color=GRAY)
        axes.scatter(points[out, 0], points[out, 1], s=5, color=ORANGE)
        axes.set_title(f"{title}: one group of {GROUPS} left out", size=10)
    finish(path, figure, panels)


def select(path: Path) -> None:
    """Draw the scores of the candidates of a noisy pipe, term by term."""
    pipe = shapes()[1]
    points = pipe + np.random.default_rng(0).normal(0, 0.05, pipe.shape)
    ranked = [one for one in neurbs.candidates(points) if one.score is not None]
    names = [name for name in ranked[0].terms if any(one.terms[name] > 0.05 for one in ranked)]
    figure = Figure(figsize=(7.2, 2.9), layout="constrained")
    axes = figure.add_subplot()
    left = np.zeros(len(ranked))
    for name, color in zip(names, TERMS, strict=False):
        widths = np.array([one.terms[name] for one in ranked])
        axes.barh(range(len(ranked)), widths, left=left, color=color, label=name, height=0.6)
        left += widths
    axes.set_yticks(range(len(ranked)), [f"{one.rank}  {one.chart}, {one.kind}" for one in ranked])
    axes.invert_yaxis()
    axes.set_xlabel("score")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1, 0.5))
    figure.savefig(path, dpi=100)


def refine(path: Path) -> None:
    """Draw growth, the sides of a round outline, and outliers."""
    rng = np.random.default_rng(0)
    figure, panels = row(4, (10.5, 3.6))
    x, y = rng.random((2, 4000))
    ripples = 0.03 * np.sin(40 * x) / (1 + np.exp(40 * (0.6 - x)))
    points = np.column_stack([x, y, ripples + rng.normal(0, 0.001, len(x))])
    for axes, grid, title in zip(
        panels, ((12, 12), None), ("first net", "grown net"), strict=False
    ):
        result = neurbs.reconstruct(points, kind="sheet", grid=grid)
        axes.scatter(x, y, s=2, c=result.deviations, cmap=GRAY_TO_ORANGE, vmin=0, vmax=0.02)
        draw_knot_lines(axes, result.surface)
        axes.set_title(f"{title}, {' × '.join(map(str, result.report.grid))}", size=10)
    angle, radius = rng.random((2, 1500)) * [[2 * np.pi], [1.0]]
    radius = np.sqrt(radius)
    x, y = radius * np.cos(angle), 0.7 * radius * np.sin(angle)
    cap = np.column_stack([x, y, 1.2 * np.sqrt(1.3 - x**2 - y**2)])
    surface = neurbs.reconstruct(cap, kind="sheet").surface
    panels[2].scatter(x, y, s=2, color=GRAY)
    draw_knot_lines(panels[2], surface)
    panels[2].set_title("a round outline has four sides", size=10)
    x, y = rng.random((2, 3000))
    z = 0.2 * np.sin(6 * x) + rng.normal(0, 0.01, len(x))
    z[::25] += rng.uniform(-0.15, 0.15, len(z[::25]))
    result = neurbs.reconstruct(np.column_stack([x, y, z]), kind="height", clean=False)
    out = ~result.inliers
    panels[3].scatter(x[~out], z[~out], s=2, color=BLUE)
    panels[3].scatter(x[out], z[out], s=12, color=ORANGE, marker="x")
    panels[3].set_title("outliers lose their weight", size=10)
    finish(path, figure, panels)


def validate(path: Path) -> None:
    """Draw three surfaces beside the same points, with their defects."""
    u = np.linspace(0, 3, 9)
    x, y = np.meshgrid(u, u, indexing="ij")
    net = np.stack([x, y, 0.3 * np.sin(2 * x) * np.cos(y)], axis=-1)
    good = neurbs.NurbsSurface.interpolate(net)
    points = good.evaluate(np.random.default_rng(0).random((1500, 2)))
    folded, bulging = good.control_points.copy(), good.control_points.copy()
    folded[2:6, :, 0] = folded[[5, 5, 2, 2], :, 0] + [[0.5], [0.5], [-0.5], [-0.5]]
    bulging[4, 4, 2] += 4
    figure = Figure(figsize=(9, 3.0))
    for at, own in enumerate((good.control_points, folded, bulging)):
        surface = neurbs.NurbsSurface(own, degree=good.degree, knots=good.knots)
        codes = [defect.code for defect in neurbs.validate(surface, points)]
        axes = figure.add_subplot(1, 3, at + 1, projection="3d")
        axes.computed_zorder = False
        draw_checkered(axes, surface)
        axes.scatter(*points[::5].T, s=3, color=ORANGE, depthshade=False, zorder=3)
        axes.set_title(", ".join(codes) or "valid", size=10, y=0.97)
    figure.subplots_adjust(0, 0, 1, 0.97, 0, 0)
    figure.savefig(path, dpi=80)


def measure(path: Path) -> None:
    """Draw points with their projections, and the histogram of the deviations."""
    rng = np.random.default_rng(3)
    x, y = rng.random((2, 3000))
    points = np.column_stack([x, y, 0.25 * np.sin(5 * x)]) + rng.normal(0, 0.02, (3000, 3))
    result = neurbs.reconstruct(points)
    some = np.flatnonzero(np.abs(y - 0.5) < 0.02)
    projections = result.surface.closest_points(points[some]).points
    figure = Figure(figsize=(7.2, 2.9), layout="constrained")
    section, histogram = figure.subplots(1, 2)
    pairs = np.stack([points[some], projections], axis=1)[..., [0, 2]]
    section.add_collection(LineCollection(list(pairs), colors=GRAY, lw=1))
    section.scatter(points[some, 0], points[some, 2], s=8, color=INK, zorder=3)
    order = np.argsort(projections[:, 0])
    section.plot(*projections[order][:, [0, 2]].T, color=BLUE)
    section.set_title("points, their projections and deviations", size=10)
    section.set_aspect("equal")
    section.axis("off")
    histogram.hist(result.deviations, bins=40, color=BLUE)
    histogram.axvline(result.report.rms, color=ORANGE)
    histogram.set(xlabel="deviation (orange: rms)", ylabel="points")
    histogram.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=100)


def shapes() -> list[Array]:
    """Return six clouds, each of which another chart orders best."""
    rng = np.random.default_rng(0)
    angle, height = rng.random((2, 2000)) * [[2 * np.pi], [3.0]]
    pipe = np.column_stack([np.cos(angle), np.sin(angle), height])
    a, b = rng.random((2, 2000)) * 2 * np.pi
    torus = np.column_stack([(3 + np.cos(b)) * np.cos(a), (3 + np.cos(b)) * np.sin(a), np.sin(b)])
    angle, height = rng.random((2, 2000)) * [[3.5 * np.pi], [3.0]]
    radius = 1 + 0.12 * angle
    roll = np.column_stack([radius * np.cos(angle), height, radius * np.sin(angle)])
    along, around = rng.random((2, 2500)) * [[12.0], [2 * np.pi]]
    line = np.column_stack([along, 1.8 * np.sin(0.9 * along), 0.6 * np.cos(0.7 * along)])
    tangent = np.column_stack(
        [np.ones_like(along), 1.62 * np.cos(0.9 * along), -0.42 * np.sin(0.7 * along)]
    )
    normal = unit(np.cross(tangent, [0, 0, 1]))
    across = np.cos(around)[:, None] * normal
    across += np.sin(around)[:, None] * np.cross(unit(tangent), normal)
    return [neurbs.read_points(TERRAIN), pipe, torus, roll, bulb(), line + 0.5 * across]


def bulb() -> Array:
    """Return points of an egg that is open below."""
    rng = np.random.default_rng(0)
    polar, angle = np.arccos(1 - 1.75 * rng.random(2000)), 2 * np.pi * rng.random(2000)
    ring = np.sin(polar)
    return np.column_stack([ring * np.cos(angle), ring * np.sin(angle), 1.3 * np.cos(polar)])


def unit(vectors: Array) -> Array:
    """Return vectors of length 1."""
    lengths: Array = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / lengths


def blocks(points: Array) -> NDArray[np.intp]:
    """Return the left-out group of each point: seeds far apart gather the points near them."""
    seeds = [int(np.argmax(np.linalg.norm(points - points.mean(0), axis=1)))]
    distances = np.linalg.norm(points - points[seeds[0]], axis=1)
    groups = np.zeros(len(points), dtype=np.intp)
    while len(seeds) < 12 * GROUPS:
        seeds.append(int(np.argmax(distances)))
        own = np.linalg.norm(points - points[seeds[-1]], axis=1)
        groups[own < distances] = (len(seeds) - 1) % GROUPS
        distances = np.minimum(distances, own)
    return groups


def nearest(points: Array, count: int) -> NDArray[np.intp]:
    """Return the nearest of each point, itself first."""
    apart = np.linalg.norm(points[:, None] - points, axis=-1)
    return np.argsort(apart, axis=1)[:, :count]


def row(count: int, size: tuple[float, float]) -> tuple[Figure, Sequence[Axes]]:
    """Return a figure with panels side by side."""
    figure = Figure(figsize=size, layout="constrained")
    return figure, [figure.add_subplot(1, count, at + 1) for at in range(count)]


def finish(path: Path, figure: Figure, panels: Iterable[Axes]) -> None:
    """Save panels of true proportions without axes."""
    for axes in panels:
        axes.set_aspect("equal")
        axes.axis("off")
    figure.savefig(path, dpi=100)


def draw_knot_lines(axes: Axes, surface: neurbs.NurbsSurface) -> None:
    """Draw the isocurves at the knots, seen from above."""
    for direction in (0, 1):
        for knot in np.unique(surface.knots[direction]):
            other = np.linspace(0, 1, 60)
            low, high = surface.knots[1 - direction][[0, -1]]
            uv = np.full((60, 2), knot)
            uv[:, 1 - direction] = low + (high - low) * other
            axes.plot(*surface.evaluate(uv)[:, :2].T, color=BLUE, lw=0.6)


def draw_checkered(axes: Any, surface: neurbs.NurbsSurface) -> None:
    """Draw a surface with a checkerboard of its parameters in axes of three dimensions."""
    count = 48
    u, v = (
        np.linspace(knots[degree], knots[-degree - 1], count + 1)
        for knots, degree in zip(surface.knots, surface.degree, strict=True)
    )
    grid = surface.evaluate_grid(u, v)
    cells = np.arange(count) // 6
    dark = (cells[:, None] + cells) % 2 == 0
    colors = np.where(dark[..., None], mpl.colors.to_rgb(BLUE), mpl.colors.to_rgb("#b9d0e0"))
    axes.plot_surface(
        *np.moveaxis(grid, -1, 0),
        facecolors=colors,
        rstride=1,
        cstride=1,
        linewidth=0,
        antialiased=False,
    )
    size = np.ptp(grid.reshape(-1, 3), axis=0)
    axes.set_box_aspect(np.maximum(size, 0.25 * size.max()), zoom=1.05)
    axes.set_axis_off()
