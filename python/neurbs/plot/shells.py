"""Pictures of shells: faces in their colors, with their edges."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs import _core
from neurbs.choices import Backend
from neurbs.extras import require
from neurbs.plot.axes_box import INK, AxesBox, add_panel, new_figure, sample, view
from neurbs.plot.figures import is_pyvista
from neurbs.plot.matplotlib_scene import POINT, brightness, diamonds

if TYPE_CHECKING:
    from neurbs import Face, Shell

_PANEL, _DPI = 8.8, 100.0
"""Width of the picture in inches, and dots per inch."""

_FILL = (0.55, 0.68, 0.76)
"""Color of faces that have none."""

_BORDER = "#b3261e"
"""Color of border edges."""

_SAMPLES = 64
"""Segments of an edge."""

_MAX_EDGE = 0.02
"""Longest side of a triangle that is drawn, as a share of the diagonal: longer ones sort badly."""

_MAX_POINTS = 200_000
"""Most points in a window."""


def plot_shell(
    shell: Shell | Face,
    points: ArrayLike | None = None,
    *,
    backend: Backend = "matplotlib",
) -> Any:
    """Draw the faces of a shell, with edges in black and the border in red.

    Parameters
    ----------
    shell : Shell or Face
        The shell.
    points : array_like of shape (n, 3), optional
        Points to draw with it.
    backend : {"matplotlib", "pyvista"}, default "matplotlib"
        The library that draws.

    Returns
    -------
    matplotlib.figure.Figure or pyvista.Plotter

    Raises
    ------
    NeurbsError
        If an argument is wrong.

    Examples
    --------
    >>> import neurbs
    >>> from neurbs.plot import plot_shell
    >>> tube = neurbs.Shell(neurbs.NurbsSurface.cylinder([0, 0, 0], [0, 0, 2], 1))
    >>> plot_shell(tube).texts[0].get_text()
    '1 face, 3 edges, area 12.57'
    """
    in_window = is_pyvista(backend)
    if isinstance(shell, _core.Face):
        shell = _core.Shell(shell)
    cloud = None if points is None else _core.as_points(points)
    low, high = shell.bounding_box()
    # Finer than a picture shows, and short enough to sort by depth.
    size = float(np.linalg.norm(high - low))
    mesh = shell.tessellate(max_edge=_MAX_EDGE * size)
    colors = np.array([face.color or _FILL for face in shell.faces])[mesh.face_index]
    if in_window:
        return _plotter(shell, mesh, colors, cloud)
    return _figure(shell, mesh, colors, cloud)


def _figure(
    shell: Shell,
    mesh: _core.TriangleMesh,
    colors: NDArray[np.float64],
    points: NDArray[np.float64] | None,
) -> Any:
    from matplotlib.colors import to_rgba
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    box = AxesBox.around(mesh.vertices, *([] if points is None else [points]))
    figure = new_figure(_PANEL, box.height * _PANEL, _DPI)
    axes = add_panel(figure, box, _title(shell))
    corners = mesh.vertices[mesh.triangles]
    facets = corners[:, [0, 1, 2, 2]]
    fills = np.clip(colors * brightness(facets * box.factor)[:, None], 0, 1)
    fills = np.column_stack([fills, np.ones(len(fills))])
    toward = 0.5 * _MAX_EDGE * np.linalg.norm(box.drawn) * view()[2] / box.factor
    lines = [_polyline(edge.curve) for edge in shell.edges]
    segments = [np.stack([line[:-1], line[1:]], axis=1)[:, [0, 1, 1, 0]] for line in lines]
    inks = [to_rgba(_BORDER if edge.is_border else INK) for edge in shell.edges]
    dots = diamonds(points, box)
    strokes = np.repeat(inks, [len(part) for part in segments], axis=0).reshape(-1, 4)
    dot_fills = np.tile(to_rgba(POINT), (len(dots), 1))
    axes.add_collection3d(
        Poly3DCollection(
            np.concatenate([facets, *(part + toward for part in segments), dots + 2 * toward]),
            facecolors=np.concatenate([fills, strokes, dot_fills]),
            # Edges in the color of the facet close the gaps between facets.
            edgecolors=np.concatenate([fills, strokes, dot_fills]),
            linewidths=np.repeat([0.5, 1.2, 0.5], [len(fills), len(strokes), len(dots)]),
        )
    )
    return figure


def _plotter(
    shell: Shell,
    mesh: _core.TriangleMesh,
    colors: NDArray[np.float64],
    points: NDArray[np.float64] | None,
) -> Any:
    pyvista: Any = require("pyvista", "windows")
    plotter = pyvista.Plotter()
    plotter.set_background("white")
    triangles = pyvista.PolyData.from_regular_faces(mesh.vertices, mesh.triangles)
    triangles["color"] = colors
    plotter.add_mesh(triangles, scalars="color", rgb=True)
    for edge in shell.edges:
        line = pyvista.lines_from_points(_polyline(edge.curve))
        plotter.add_mesh(line, color=_BORDER if edge.is_border else INK, line_width=2)
    if points is not None:
        shown = points[sample(len(points), _MAX_POINTS)]
        plotter.add_points(shown, color=POINT, point_size=3)
    plotter.view_isometric()
    return plotter


def _polyline(curve: _core.NurbsCurve) -> NDArray[np.float64]:
    """Return places along a curve."""
    places: NDArray[np.float64] = curve.evaluate(np.linspace(*curve.domain, _SAMPLES + 1))
    return places


def _title(shell: Shell) -> str:
    faces, edges = len(shell.faces), len(shell.edges)
    counts = [f"{faces:,} face{'s' * (faces != 1)}", f"{edges:,} edge{'s' * (edges != 1)}"]
    if shell.is_closed:
        return ", ".join([*counts, f"closed, volume {shell.volume(accuracy=1e-6):.4g}"])
    return ", ".join([*counts, f"area {shell.area(accuracy=1e-6):.4g}"])
