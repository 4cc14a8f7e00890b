"""Lattices, surfaces and points in 3D axes of Matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neurbs.plot.axes_box import INK, AxesBox, sample, view
from neurbs.plot.coloring import Coloring, coloring

if TYPE_CHECKING:
    from neurbs import NurbsSurface
    from neurbs.deviation import Deviation

NET, POINT = "#1d5b86", "#e2572b"
"""Colors of lattices and nets, and of points."""

_MAX_POINTS = 5_000
"""Most points drawn with a lattice; more would cover it."""

_MAX_SURFACE_POINTS = 300
"""Most points drawn with a surface; more would cover it."""

_FACETS = 140
"""Facets along each side of a surface, of a few pixels each."""

_FINE_FACETS = 320
"""Facets along each side for zebra stripes, which need finer ones."""

_LIGHT = np.array([-0.62, -0.18, 0.76])
"""Direction toward the light: left of the viewer and above."""


def draw_points(axes: Any, points: NDArray[np.float64]) -> None:
    """Draw points, or a sample of many."""
    shown = points[sample(len(points), _MAX_POINTS)]
    size = np.clip(6_000 / len(shown), 2, 24)
    axes.scatter(*shown.T, s=size, c=POINT, linewidths=0, depthshade=False, zorder=1)


def draw_net(axes: Any, net: NDArray[np.float64], color: str = NET) -> None:
    """Draw the lines along the rows and columns of a net of shape (rows, cols, 3)."""
    width = np.clip(24 / max(net.shape[:2]), 0.3, 1.1)
    for lines in (net, net.swapaxes(0, 1)):
        draw_lines(axes, lines, width, color)


def draw_lines(
    axes: Any, lines: Sequence[Any] | NDArray[np.float64], width: float, color: Any = NET
) -> Any:
    """Draw polylines over the points, and return them as one collection."""
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    return axes.add_collection3d(Line3DCollection(lines, colors=color, linewidths=width, zorder=2))


def draw_surface(
    axes: Any,
    box: AxesBox,
    surface: NurbsSurface,
    color: str,
    *,
    points: NDArray[np.float64] | None = None,
    deviation: Deviation | None = None,
    tolerance: float | None = None,
    unit: str = "",
    isolines: int = 20,
) -> Coloring:
    """Draw a surface with isoparametric lines and points as one collection of quadrilaterals.

    Matplotlib sorts the members of one collection by depth, but not across collections. So a fold
    in front hides the parts behind it.
    """
    from matplotlib.colors import to_rgba
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    count = _FINE_FACETS if color == "zebra" else _FACETS
    u, v = (np.linspace(*ends, count + 1) for ends in surface.domain)
    grid = surface.evaluate_grid(u, v)
    corners = (grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:])
    facets = np.stack(corners, axis=2).reshape(-1, 4, 3)
    centers = ((u[1:] + u[:-1]) / 2, (v[1:] + v[:-1]) / 2)
    scale = coloring(surface, *centers, color, deviation=deviation, tolerance=tolerance, unit=unit)
    colors = scale.rgba().reshape(-1, 4)
    if color != "zebra":
        colors[:, :3] *= brightness(facets * box.factor, legend=bool(scale.label))[:, None]
    # Lines and points are moved by a facet's width toward the viewer, in front of the surface.
    width = np.median(np.ptp(facets * box.factor, axis=1), axis=0).max()
    toward = width * view()[2] / box.factor
    lines = _isolines(surface, grid, box, isolines)
    dots = diamonds(points, box)
    counts = (len(lines), len(dots))
    fills = np.repeat([to_rgba(INK, 0.0), to_rgba(POINT)], counts, axis=0)
    strokes = np.repeat([to_rgba(INK, 0.3), to_rgba(POINT)], counts, axis=0)
    axes.add_collection3d(
        Poly3DCollection(
            np.concatenate([facets, lines + toward, dots + 2 * toward]),
            facecolors=np.concatenate([np.clip(colors, 0, 1), fills]),
            # Edges in the color of the facet close the gaps between facets.
            edgecolors=np.concatenate([np.clip(colors, 0, 1), strokes]),
            linewidths=0.6,
        )
    )
    return scale


def _isolines(
    surface: NurbsSurface, grid: NDArray[np.float64], box: AxesBox, count: int
) -> NDArray[np.float64]:
    """Return segments of isoparametric lines with similar distances in u and v."""
    if count == 0:
        return np.empty((0, 4, 3))
    steps = [np.diff(grid, axis=axis) * box.factor for axis in (0, 1)]
    lengths = [np.linalg.norm(s, axis=2).sum(axis=axis).mean() for axis, s in enumerate(steps)]
    share = np.array(lengths) / max(lengths)
    u, v = (np.linspace(*ends, len(grid)) for ends in surface.domain)
    lines_u, lines_v = (
        np.linspace(*ends, max(2, round(count * s)))
        for ends, s in zip(surface.domain, share, strict=True)
    )
    bundles = (surface.evaluate_grid(lines_u, v), surface.evaluate_grid(u, lines_v).swapaxes(0, 1))
    segments = [np.stack([b[:, :-1], b[:, 1:]], axis=2).reshape(-1, 2, 3) for b in bundles]
    return np.concatenate(segments)[:, [0, 1, 1, 0]]


def diamonds(points: NDArray[np.float64] | None, box: AxesBox) -> NDArray[np.float64]:
    """Return small squares that face the viewer, at a sample of the points."""
    if points is None:
        return np.empty((0, 4, 3))
    shown = points[sample(len(points), _MAX_SURFACE_POINTS)]
    right, up, _ = view() * 0.0025 * np.linalg.norm(box.drawn) / box.factor
    corners: NDArray[np.float64] = np.stack([right, up, -right, -up])
    return shown[:, None] + corners


def brightness(facets: NDArray[np.float64], *, legend: bool = False) -> NDArray[np.float64]:
    """Return the brightness of facets; the contrast is low if the colors have a legend."""
    normals = np.cross(facets[:, 2] - facets[:, 0], facets[:, 3] - facets[:, 1])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
    # Use the normal on the side of the viewer.
    normals *= np.where(normals @ view()[2] < 0, -1.0, 1.0)[:, None]
    ambient, direct = (0.72, 0.32) if legend else (0.5, 0.6)
    light: NDArray[np.float64] = ambient + direct * np.clip(normals @ _LIGHT, 0, None)
    return light
