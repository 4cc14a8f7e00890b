"""Shells and points in a PyVista window."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neurbs.extras import require
from neurbs.plot.axes_box import INK, AxesBox, sample
from neurbs.plot.coloring import NO_DATA, Coloring
from neurbs.plot.drawn_shell import DrawnShell
from neurbs.plot.matplotlib_scene import FILL, NET, POINT

if TYPE_CHECKING:
    from neurbs.plot.picture import Picture

FACETS = 240
"""Triangles along the longest side of a window."""

_MAX_POINTS = 200_000
"""Most points that are drawn."""


def shell_plotter(
    box: AxesBox,
    drawn: DrawnShell,
    colors: Coloring | None,
    picture: Picture,
    *,
    points: NDArray[np.float64] | None = None,
    net: NDArray[np.float64] | None = None,
    border: str = INK,
) -> Any:
    """Make a plotter with a shell; its method `show` opens the window.

    Parameters
    ----------
    box, drawn, colors, points, border
        As for `neurbs.plot.matplotlib_scene.draw_shell`.
    picture : Picture
        Size of the window.
    net : ndarray of shape (rows, cols, 3), optional
        A control net.

    Returns
    -------
    pyvista.Plotter

    Raises
    ------
    NeurbsError
        If PyVista is not installed.
    """
    pyvista: Any = require("pyvista", "windows")
    plotter = _plotter(box, picture)
    mesh = pyvista.PolyData.from_regular_faces(drawn.vertices, drawn.triangles)
    if colors is None:
        mesh["color"] = drawn.face_colors(FILL)
        plotter.add_mesh(mesh, scalars="color", rgb=True)
    else:
        # The label is too long for one line in the window.
        name = colors.label.replace(", ", "\n").replace(" (", "\n(") or "value"
        mesh[name] = colors.values
        plotter.add_mesh(
            mesh,
            cmap=colors.colormap,
            clim=(colors.low, colors.high),
            nan_color=NO_DATA,
            smooth_shading=True,
            show_scalar_bar=bool(colors.label),
            scalar_bar_args={
                "color": INK,
                "vertical": True,
                "position_x": 0.87,
                "position_y": 0.25,
            },
            lighting=colors.is_lit,
        )
    for line in drawn.isolines:
        plotter.add_mesh(pyvista.lines_from_points(line[:, :3]), color=INK, opacity=0.35)
    for line, is_border in drawn.edges:
        color = border if is_border else INK
        plotter.add_mesh(pyvista.lines_from_points(line), color=color, line_width=2)
    if points is not None:
        _add_points(plotter, points)
    if net is not None:
        lattice = pyvista.StructuredGrid(*np.moveaxis(net, 2, 0).copy())
        plotter.add_mesh(lattice, style="wireframe", color=NET)
    _look(plotter, box)
    return plotter


def points_plotter(box: AxesBox, points: NDArray[np.float64], picture: Picture) -> Any:
    """Make a plotter with points."""
    plotter = _plotter(box, picture)
    _add_points(plotter, points)
    _look(plotter, box)
    return plotter


def _plotter(box: AxesBox, picture: Picture) -> Any:
    require("pyvista", "windows")
    from neurbs.plot.shown_plotter import ShownPlotter

    size = picture.size and [round(side * picture.dpi) for side in picture.size]
    plotter = ShownPlotter(window_size=size)
    plotter.set_background("white")
    longer = [box.label(axis) for axis in range(3) if box.factor[axis] != 1]
    if longer:
        plotter.add_text("   ".join(longer), position="lower_left", font_size=9, color=INK)
    return plotter


def _look(plotter: Any, box: AxesBox) -> None:
    """Draw axes longer, and turn to the view."""
    plotter.set_scale(*box.factor, reset_camera=False)
    _, up, toward = box.view.axes
    plotter.view_vector(toward, viewup=up)


def _add_points(plotter: Any, points: NDArray[np.float64]) -> None:
    shown = points[sample(len(points), _MAX_POINTS)]
    plotter.add_points(shown, color=POINT, point_size=3)
