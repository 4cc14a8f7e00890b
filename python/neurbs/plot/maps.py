"""Pictures of maps."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs import _core
from neurbs.errors import argument_error
from neurbs.plot.coloring import Coloring
from neurbs.plot.matplotlib_scene import draw_lines, draw_points
from neurbs.plot.panel import add_panel, figure_of_panels, panel_scale
from neurbs.plot.picture import Picture

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

    from neurbs import SelfOrganizingMap

_NODE_COLORS = ("u-matrix", "hits")
"""Quantities that the colors of a map's cells show."""

_CELLS = ("#f4f3ee", "#c9d8d2", "#7fae9f", "#3c7f7a", "#174d57", "#0c2a36")
"""Palette of the cells of a map."""


def plot_map(
    som: SelfOrganizingMap,
    points: ArrayLike | None = None,
    *,
    color: str | None = None,
    view: str = "iso",
    size: Sequence[float] | None = None,
    dpi: float = 100.0,
    exaggeration: float | None = None,
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
    view, size, dpi, exaggeration
        As for `plot_reconstruction`.

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
    picture = Picture(view, size, dpi, exaggeration)
    box = picture.box(nodes, *([] if cloud is None else [cloud]))
    # A graph has no rows and columns.
    name = (
        f"{grid_size(som.codebook_)} lattice" if som.codebook_.ndim == 3 else f"{len(nodes)} nodes"
    )
    title = name if cloud is None else f"{name}, {len(cloud):,} points"
    figure, share = figure_of_panels(box, 1, picture, legend=color is not None)
    axes = add_panel(figure, box, title, 0.0, share)
    letters = panel_scale(figure, share)
    if cloud is not None:
        draw_points(axes, cloud, letters)
    if color is not None:
        scale = _node_values(som, cloud, color)
        _draw_cells(axes, som.codebook_, scale)
        scale.add_legend(figure, share)
    width = float(np.clip(24 / np.sqrt(len(nodes)), 0.3, 1.1)) * letters
    draw_lines(axes, nodes[np.array(som.lattice_.edges)], width)
    return figure


def grid_size(grid: NDArray[np.float64]) -> str:
    """Return rows and columns in words."""
    return " × ".join(map(str, grid.shape[:2]))


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
