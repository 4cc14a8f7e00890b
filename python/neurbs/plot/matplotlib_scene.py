"""Lattices, surfaces and points in 3D axes of Matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neurbs.plot.axes_box import INK, AxesBox, sample
from neurbs.plot.coloring import Coloring
from neurbs.plot.drawn_shell import DrawnShell
from neurbs.plot.standard_view import View

NET, POINT = "#1d5b86", "#e2572b"
"""Colors of lattices and nets, and of points."""

_MAX_POINTS = 5_000
"""Most points drawn with a lattice; more would cover it."""

_MAX_SURFACE_POINTS = 300
"""Most points drawn with a surface; more would cover it."""

FACETS, FINE_FACETS = 80, 200
"""Triangles along the longest side of a panel, of a few pixels each; zebra stripes need finer ones.
"""

FILL = (0.55, 0.68, 0.76)
"""Color of faces that have none."""


def draw_points(axes: Any, points: NDArray[np.float64], scale: float = 1.0) -> None:
    """Draw points, or a sample of many, in a panel of a scale."""
    shown = points[sample(len(points), _MAX_POINTS)]
    size = np.clip(6_000 / len(shown), 2, 24) * scale**2
    axes.scatter(*shown.T, s=size, c=POINT, linewidths=0, depthshade=False, zorder=1)


def draw_net(axes: Any, net: NDArray[np.float64], color: str = NET, scale: float = 1.0) -> None:
    """Draw the lines along the rows and columns of a net of shape (rows, cols, 3).

    Parts outside the box of the axes would cover title and labels; they are left out.
    """
    width = float(np.clip(24 / max(net.shape[:2]), 0.3, 1.1)) * scale
    low, high = np.transpose([axes.get_xlim(), axes.get_ylim(), axes.get_zlim()])
    inside = ((low <= net) & (net <= high)).all()
    for lines in (net, net.swapaxes(0, 1)):
        draw_lines(axes, lines if inside else _clipped(lines, low, high), width, color)


def _clipped(
    lines: NDArray[np.float64], low: NDArray[np.float64], high: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the parts in a box of the segments of polylines of shape (m, n, 3), (k, 2, 3).

    By the parameters at which each segment crosses the planes of the box (Liang and Barsky, 1984).
    """
    start, step = lines[:, :-1].reshape(-1, 3), np.diff(lines, axis=1).reshape(-1, 3)
    # A segment along a plane crosses it nowhere: its parameters are infinite or, on it, NaN.
    with np.errstate(divide="ignore", invalid="ignore"):
        crossings = np.stack([(low - start) / step, (high - start) / step])
    first = np.fmax.reduce(np.fmin(*crossings), axis=1).clip(0)[:, None]
    last = np.fmin.reduce(np.fmax(*crossings), axis=1).clip(max=1)[:, None]
    ends = np.stack([start + first * step, start + last * step], axis=1)
    inside: NDArray[np.float64] = ends[(first < last)[:, 0]]
    return inside


def draw_lines(
    axes: Any, lines: Sequence[Any] | NDArray[np.float64], width: float, color: Any = NET
) -> Any:
    """Draw polylines over the points, and return them as one collection."""
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    return axes.add_collection3d(Line3DCollection(lines, colors=color, linewidths=width, zorder=2))


def draw_shell(
    axes: Any,
    box: AxesBox,
    drawn: DrawnShell,
    colors: Coloring | None,
    *,
    points: NDArray[np.float64] | None = None,
    border: str = INK,
    scale: float = 1.0,
) -> None:
    """Draw a shell with edges, isoparametric lines and points as one collection of polygons.

    Matplotlib sorts the members of one collection by depth, but not across collections. So a fold
    in front hides the parts behind it.

    Parameters
    ----------
    axes : Axes3D
        Axes for the box.
    box : AxesBox
        The box.
    drawn : DrawnShell
        The shell.
    colors : Coloring or None
        The colors of its vertices; None for the colors of the faces.
    points : ndarray of shape (n, 3), optional
        Points, of which a sample is drawn.
    border : str
        The color of border edges.
    scale : float
        The scale of the panel, for the widths of lines.
    """
    from matplotlib.colors import to_rgba
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    facets = drawn.vertices[drawn.triangles][:, [0, 1, 2, 2]]
    if colors is None:
        fills = np.ones((len(facets), 4))
        fills[:, :3] = drawn.face_colors(FILL)[drawn.triangles[:, 0]]
    else:
        fills = colors.rgba(drawn.triangles)
    if colors is None or colors.is_lit:
        legend = colors is not None and bool(colors.label)
        fills[:, :3] *= brightness(facets * box.factor, box.view, legend=legend)[:, None]
    # Lines and points are moved by a facet's width toward the viewer, in front of the surface.
    width = np.median(np.ptp(facets * box.factor, axis=1), axis=0).max()
    step = width * box.toward / box.drawn.max()
    layers = [(facets, np.clip(fills, 0, 1))]
    for lines, ink, alpha in (
        ([line[:, :3] for line in drawn.isolines], INK, 0.25),
        ([line for line, is_border in drawn.edges if not is_border], INK, 1.0),
        ([line for line, is_border in drawn.edges if is_border], border, 1.0),
    ):
        segments = _segments(lines) + step
        layers.append((segments, np.tile(to_rgba(ink, alpha), (len(segments), 1))))
    dots = diamonds(points, box) + 2 * step
    layers.append((dots, np.tile(to_rgba(POINT), (len(dots), 1))))
    polygons, colored = zip(*layers, strict=True)
    # Edges in the color of the facet close the gaps between facets.
    collection = Poly3DCollection(
        np.concatenate(polygons),
        facecolors=np.concatenate(colored),
        edgecolors=np.concatenate(colored),
        linewidths=0.8 * scale,
    )
    # Tens of thousands of polygons are an image in files of vectors.
    collection.set_rasterized(True)
    axes.add_collection3d(collection)


def _segments(lines: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return the segments of polylines as polygons of four corners, there and back."""
    segments = [np.stack([line[:-1], line[1:]], axis=1)[:, [0, 1, 1, 0]] for line in lines]
    return np.concatenate([np.empty((0, 4, 3)), *segments])


def diamonds(points: NDArray[np.float64] | None, box: AxesBox) -> NDArray[np.float64]:
    """Return small squares that face the viewer, at a sample of the points."""
    if points is None:
        return np.empty((0, 4, 3))
    shown = points[sample(len(points), _MAX_SURFACE_POINTS)]
    right, up, _ = box.view.axes * 0.0025 * np.linalg.norm(box.drawn) / box.factor
    corners: NDArray[np.float64] = np.stack([right, up, -right, -up])
    return shown[:, None] + corners


def brightness(
    facets: NDArray[np.float64], view: View, *, legend: bool = False
) -> NDArray[np.float64]:
    """Return the brightness of facets; the contrast is low if the colors have a legend."""
    return lit(
        np.cross(facets[:, 2] - facets[:, 0], facets[:, 3] - facets[:, 1]), view, legend=legend
    )


def lit(normals: NDArray[np.float64], view: View, *, legend: bool) -> NDArray[np.float64]:
    """Return the brightness of places with normals of any length."""
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
    # Use the normal on the side of the viewer.
    normals *= np.where(normals @ view.axes[2] < 0, -1.0, 1.0)[:, None]
    ambient, direct = (0.72, 0.32) if legend else (0.5, 0.6)
    light: NDArray[np.float64] = ambient + direct * np.clip(
        normals @ (np.array(view.light) @ view.axes), 0, None
    )
    return light
