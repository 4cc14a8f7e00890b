"""Figures of a reconstruction, a surface, a map and points."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs import _core
from neurbs.choices import Backend, SurfaceColor
from neurbs.deviation import Deviation
from neurbs.errors import argument_error
from neurbs.io.atomic_write import atomic_write
from neurbs.plot.axes_box import AxesBox, add_panel, new_figure
from neurbs.plot.coloring import Coloring
from neurbs.plot.matplotlib_scene import POINT, draw_lines, draw_net, draw_points, draw_surface

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from neurbs import NurbsSurface, Reconstruction, SelfOrganizingMap

_PANEL, _LEGEND, _DPI = 8.0, 1.2, 100.0
"""Widths of a panel and of a legend in inches, and dots per inch."""

_NODE_COLORS = ("u-matrix", "hits")
"""Quantities that the colors of a map's cells show."""

_CELLS = ("#f4f3ee", "#c9d8d2", "#7fae9f", "#3c7f7a", "#174d57", "#0c2a36")
"""Palette of the cells of a map."""


def plot_reconstruction(
    result: Reconstruction,
    *,
    color: SurfaceColor = "height",
    tolerance: float | None = None,
    unit: str = "",
    isolines: int = 20,
    backend: Backend = "matplotlib",
) -> Any:
    """Draw the points with the trained lattice, and the surface beside them.

    An axis shorter than a quarter of the longest, such as the height of terrain, is drawn with the
    length of that quarter, and its label gives the factor. All other proportions are true.

    Parameters
    ----------
    result : Reconstruction
        The result of `neurbs.reconstruct`.
    color : {"height", "deviation", "mean", "gaussian", "zebra"}, default "height"
        The quantity that the surface's colors show: height; the local mean of the signed distances
        from points to surface, positive on the side of the normal; mean or Gaussian curvature; or
        zebra stripes, which have a kink where the tangent plane has one.
    tolerance : float, optional
        The deviation at the ends of the color scale, in the points' unit; by default the 99th
        percentile of the shown values.
    unit : str, default ""
        Name of the points' unit, for the legend; by default that of the result.
    isolines : int, default 20
        Isoparametric lines across the longer direction; 0 for none.
    backend : {"matplotlib", "pyvista"}, default "matplotlib"
        The library that draws. PyVista shows surface and points in a window that is turned with
        the mouse.

    Returns
    -------
    matplotlib.figure.Figure or pyvista.Plotter
        The figure does not use pyplot: it needs no display and no call to close it.

    Raises
    ------
    NeurbsError
        If an argument is wrong.

    Examples
    --------
    >>> import numpy as np
    >>> import neurbs
    >>> x, y = np.random.default_rng(0).random((2, 200))
    >>> result = neurbs.reconstruct(np.column_stack([x, y, x * y]), grid=(6, 6))
    >>> [panel.get_zlabel() for panel in result.plot().axes]
    ['z', 'z']
    """
    unit = unit or result.unit or ""
    deviation = Deviation.of_result(result) if color == "deviation" else None
    if is_pyvista(backend):
        from neurbs.plot.pyvista_scene import surface_plotter

        return surface_plotter(
            result.surface,
            color,
            points=result.points,
            deviation=deviation,
            tolerance=tolerance,
            unit=unit,
            isolines=isolines,
        )
    box = AxesBox.around(result.points, result.mesh.vertices)
    figure = new_figure(2 * _PANEL + _legend_width(color), box.height * _PANEL, _DPI)
    lattice = result.som.codebook_
    share = _PANEL / figure.get_figwidth()
    title = f"{len(result.points):,} points, {_size(lattice)} lattice"
    left = add_panel(figure, box, title, 0.0, share)
    draw_points(left, result.points)
    draw_net(left, lattice)
    surface = result.surface
    right = add_panel(figure, box, _surface_title(surface), share, share)
    scale = draw_surface(
        right,
        box,
        surface,
        color,
        points=result.points if color == "height" else None,
        deviation=deviation,
        tolerance=tolerance,
        unit=unit,
        isolines=isolines,
    )
    scale.add_legend(figure, 2 * share)
    return figure


def plot_surface(
    surface: NurbsSurface,
    points: ArrayLike | None = None,
    *,
    color: SurfaceColor | None = None,
    tolerance: float | None = None,
    unit: str = "",
    isolines: int = 20,
    control_net: bool = False,
    backend: Backend = "matplotlib",
) -> Any:
    """Draw a surface; `NurbsSurface.plot` is this function.

    Parameters
    ----------
    surface : NurbsSurface
        The surface.
    points : array_like of shape (n, 3), optional
        Points to draw, and to measure the deviation from the surface.
    color : {"height", "deviation", "mean", "gaussian", "zebra"}, optional
        The quantity that colors show, as in `plot_reconstruction`; by default the deviation if
        there are points, else the height.
    tolerance : float, optional
        The deviation at the ends of the color scale, in the points' unit.
    unit : str, default ""
        Name of the points' unit, for the legend.
    isolines : int, default 20
        Isoparametric lines across the longer direction; 0 for none.
    control_net : bool, default False
        Whether to draw the control net.
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
    >>> sphere = neurbs.NurbsSurface.sphere([0, 0, 0], 1)
    >>> figure = sphere.plot(color="zebra", isolines=0)
    >>> figure.savefig("sphere.png")  # doctest: +SKIP
    """
    cloud = None if points is None else _core.as_points(points)
    if color is None:
        color = "height" if cloud is None else "deviation"
    needed = color == "deviation" and cloud is not None
    deviation = Deviation.of(surface, cloud) if needed and cloud is not None else None
    if is_pyvista(backend):
        from neurbs.plot.pyvista_scene import surface_plotter

        return surface_plotter(
            surface,
            color,
            points=cloud,
            deviation=deviation,
            tolerance=tolerance,
            unit=unit,
            isolines=isolines,
            control_net=control_net,
        )
    net = surface.control_points
    drawn = [surface.tessellate(shape=(60, 60)).vertices]
    drawn += [net.reshape(-1, 3)] if control_net else []
    drawn += [] if cloud is None else [cloud]
    box = AxesBox.around(*drawn)
    figure = new_figure(1.1 * _PANEL + _legend_width(color), box.height * _PANEL, _DPI)
    share = 1.1 * _PANEL / figure.get_figwidth()
    axes = add_panel(figure, box, _surface_title(surface), 0.0, share)
    scale = draw_surface(
        axes,
        box,
        surface,
        color,
        points=cloud,
        deviation=deviation,
        tolerance=tolerance,
        unit=unit,
        isolines=isolines,
    )
    if control_net:
        draw_net(axes, net, POINT)
    scale.add_legend(figure, share)
    return figure


def plot_map(
    som: SelfOrganizingMap, points: ArrayLike | None = None, *, color: str | None = None
) -> Figure:
    """Draw a trained map; `SelfOrganizingMap.plot` is this function.

    Parameters
    ----------
    som : SelfOrganizingMap
        A trained map.
    points : array_like of shape (n, 3), optional
        Points to draw with the map.
    color : {"u-matrix", "hits"}, optional
        The quantity that the colors of the cells show: the mean distance of a node to its
        neighbors, or the number of points nearest to it.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    NeurbsError
        If `color` is unknown, ``"hits"`` is given without points, or the lattice is a graph, which
        has no cells.

    Examples
    --------
    >>> import numpy as np
    >>> import neurbs
    >>> points = np.random.default_rng(0).random((500, 3)) * [2, 1, 0.1]
    >>> som = neurbs.SelfOrganizingMap(8, 6).fit(points)
    >>> som.plot(points, color="u-matrix").texts[0].get_text()
    '8 × 6 lattice, 500 points'
    """
    cloud = None if points is None else _core.as_points(points)
    nodes = som.codebook_.reshape(-1, 3)
    box = AxesBox.around(nodes, *([] if cloud is None else [cloud]))
    # A graph has no rows and columns.
    name = f"{_size(som.codebook_)} lattice" if som.codebook_.ndim == 3 else f"{len(nodes)} nodes"
    title = name if cloud is None else f"{name}, {len(cloud):,} points"
    figure = new_figure(1.1 * _PANEL + (_LEGEND if color else 0.0), box.height * _PANEL, _DPI)
    share = 1.1 * _PANEL / figure.get_figwidth()
    axes = add_panel(figure, box, title, 0.0, share)
    if cloud is not None:
        draw_points(axes, cloud)
    if color is not None:
        scale = _node_values(som, cloud, color)
        _draw_cells(axes, som.codebook_, scale)
        scale.add_legend(figure, share)
    width = float(np.clip(24 / np.sqrt(len(nodes)), 0.3, 1.1))
    draw_lines(axes, nodes[np.array(som.lattice_.edges)], width)
    return figure


def plot_points(points: ArrayLike, *, backend: Backend = "matplotlib") -> Any:
    """Draw points, or a sample of many.

    Parameters
    ----------
    points : array_like of shape (n, 3) or (n, 2)
        The points.
    backend : {"matplotlib", "pyvista"}, default "matplotlib"
        The library that draws.

    Returns
    -------
    matplotlib.figure.Figure or pyvista.Plotter
    """
    cloud = _core.as_points(points)
    if is_pyvista(backend):
        from neurbs.plot.pyvista_scene import points_plotter

        return points_plotter(cloud)
    box = AxesBox.around(cloud)
    figure = new_figure(1.1 * _PANEL, box.height * _PANEL, _DPI)
    draw_points(add_panel(figure, box, f"{len(cloud):,} points"), cloud)
    return figure


def save_picture(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write a figure as PNG; the file is complete or does not exist."""
    with atomic_write(Path(path)) as new:
        figure.savefig(new, format="png", dpi="figure")


def _node_values(
    som: SelfOrganizingMap, points: NDArray[np.float64] | None, color: str
) -> Coloring:
    if color not in _NODE_COLORS:
        raise argument_error("color", f"must be one of {', '.join(_NODE_COLORS)}, got {color!r}")
    if som.codebook_.ndim != 3:
        raise argument_error(
            "color", f"must be None for a graph, which has no cells, got {color!r}"
        )
    if color == "hits":
        if points is None:
            raise argument_error("color", "must not be 'hits' without points")
        values, label = som.hits(points).astype(float), "points nearest to a node"
    else:
        values, label = som.u_matrix(), "mean distance to the neighbors"
    return Coloring(values, values.min(), max(values.max(), values.min() + 1e-300), _CELLS, label)


def _draw_cells(axes: Any, lattice: NDArray[np.float64], scale: Coloring) -> None:
    """Fill the cells of a lattice; each quarter of a cell has the color of its node."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    # A lattice of double resolution, whose cells are the quarters.
    fine = lattice
    for axis in (0, 1):
        moved = np.moveaxis(fine, axis, 0)
        between = (moved[1:] + moved[:-1]) / 2
        fine = np.moveaxis(np.insert(moved, np.arange(1, len(moved)), between, axis=0), 0, axis)
    corners = (fine[:-1, :-1], fine[1:, :-1], fine[1:, 1:], fine[:-1, 1:])
    quarters = np.stack(corners, axis=2).reshape(-1, 4, 3)
    rows, cols = (np.arange(1, 2 * count - 1) // 2 for count in lattice.shape[:2])
    colors = scale.rgba()[np.ix_(rows, cols)].reshape(-1, 4)
    axes.add_collection3d(
        Poly3DCollection(quarters, facecolors=colors, edgecolors=colors, linewidths=0.4)
    )


def is_pyvista(backend: str) -> bool:
    """Return whether PyVista draws; raise for a name of no backend."""
    if backend not in ("matplotlib", "pyvista"):
        raise argument_error("backend", f"must be 'matplotlib' or 'pyvista', got {backend!r}")
    return backend == "pyvista"


def _legend_width(color: str) -> float:
    return 0.0 if color in ("height", "zebra") else _LEGEND


def _size(grid: NDArray[np.float64]) -> str:
    return " × ".join(map(str, grid.shape[:2]))


def _surface_title(surface: NurbsSurface) -> str:
    u, v = surface.degree
    degree = f"degree {u}" if u == v else f"degrees {u} and {v}"
    return f"NURBS surface, {_size(surface.control_points)} control points, {degree}"
