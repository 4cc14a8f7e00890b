"""Surfaces in a PyVista window."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neurbs.extras import require
from neurbs.plot.axes_box import INK, sample
from neurbs.plot.coloring import NO_DATA, coloring
from neurbs.plot.matplotlib_scene import NET, POINT

if TYPE_CHECKING:
    from neurbs import NurbsSurface
    from neurbs.deviation import Deviation

_FACETS = 240
"""Facets along each side of a surface."""

_MAX_POINTS = 200_000
"""Most points that are drawn."""


def surface_plotter(
    surface: NurbsSurface,
    color: str,
    *,
    points: NDArray[np.float64] | None = None,
    deviation: Deviation | None = None,
    tolerance: float | None = None,
    unit: str = "",
    isolines: int = 20,
    control_net: bool = False,
) -> Any:
    """Make a plotter with a surface; its method `show` opens the window.

    The parameters are those of `neurbs.plot.plot_surface`.

    Returns
    -------
    pyvista.Plotter

    Raises
    ------
    NeurbsError
        If an argument is wrong, or PyVista is not installed.
    """
    pyvista: Any = require("pyvista", "windows")
    u, v = (np.linspace(*ends, _FACETS + 1) for ends in surface.domain)
    scale = coloring(surface, u, v, color, deviation=deviation, tolerance=tolerance, unit=unit)
    plotter = pyvista.Plotter()
    plotter.set_background("white")
    grid = surface.evaluate_grid(u, v)
    mesh = pyvista.StructuredGrid(*np.moveaxis(grid, 2, 0).copy())
    # The label is too long for one line in the window.
    name = scale.label.replace(", ", "\n").replace(" (", "\n(") or color
    mesh[name] = scale.values.ravel(order="F")
    plotter.add_mesh(
        mesh,
        cmap=scale.colormap,
        clim=(scale.low, scale.high),
        nan_color=NO_DATA,
        smooth_shading=True,
        show_scalar_bar=bool(scale.label),
        scalar_bar_args={"color": INK, "vertical": True, "position_x": 0.87, "position_y": 0.25},
        lighting=color != "zebra",
    )
    if isolines:
        for line in _isolines(surface, isolines):
            plotter.add_mesh(pyvista.lines_from_points(line), color=INK, opacity=0.35)
    if points is not None:
        _add_points(plotter, points)
    if control_net:
        net = pyvista.StructuredGrid(*np.moveaxis(surface.control_points, 2, 0).copy())
        plotter.add_mesh(net, style="wireframe", color=NET)
    plotter.view_isometric()
    return plotter


def points_plotter(points: NDArray[np.float64]) -> Any:
    """Make a plotter with points."""
    pyvista: Any = require("pyvista", "windows")
    plotter = pyvista.Plotter()
    plotter.set_background("white")
    _add_points(plotter, points)
    plotter.view_isometric()
    return plotter


def _add_points(plotter: Any, points: NDArray[np.float64]) -> None:
    shown = points[sample(len(points), _MAX_POINTS)]
    plotter.add_points(shown, color=POINT, point_size=3)


def _isolines(surface: NurbsSurface, count: int) -> list[NDArray[np.float64]]:
    u, v = (np.linspace(*ends, _FACETS + 1) for ends in surface.domain)
    lines_u, lines_v = (np.linspace(*ends, max(2, count)) for ends in surface.domain)
    return [*surface.evaluate_grid(lines_u, v), *surface.evaluate_grid(u, lines_v).swapaxes(0, 1)]
