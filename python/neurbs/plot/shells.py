"""Pictures of shells: faces in their colors or by a quantity, with their edges."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs import _core
from neurbs.choices import Backend, SurfaceColor, ViewChoice
from neurbs.deviation import Deviation
from neurbs.errors import argument_error
from neurbs.plot import matplotlib_scene, pyvista_scene
from neurbs.plot.axes_box import INK, AxesBox, number
from neurbs.plot.coloring import Coloring, coloring
from neurbs.plot.drawn_shell import DrawnShell
from neurbs.plot.panel import add_panel, figure_of_panels, panel_scale
from neurbs.plot.picture import Picture

if TYPE_CHECKING:
    from collections.abc import Sequence

    from neurbs import Face, Shell

_BORDER = "#b3261e"
"""Color of border edges."""


def plot_shell(
    shell: Shell | Face,
    points: ArrayLike | None = None,
    *,
    color: SurfaceColor | None = None,
    tolerance: float | None = None,
    unit: str = "",
    isolines: int = 0,
    view: ViewChoice = "iso",
    size: Sequence[float] | None = None,
    dpi: float = 100.0,
    exaggeration: float | None = None,
    backend: Backend = "matplotlib",
) -> Any:
    """Draw the faces of a shell, with edges in black and the border in red.

    Parameters
    ----------
    shell : Shell or Face
        The shell.
    points : array_like of shape (n, 3), optional
        Points to draw with it, and to measure the deviation from the shell.
    color : {"height", "deviation", "mean", "gaussian", "zebra"}, optional
        The quantity that colors show, as in `plot_reconstruction`; by default the colors of the
        faces.
    tolerance, unit, view, size, dpi, exaggeration
        As for `plot_reconstruction`.
    isolines : int, default 0
        Isoparametric lines across the longer direction of each face; 0 for none.
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
    picture = Picture(view, size, dpi, exaggeration, unit)
    if isinstance(shell, _core.Face):
        shell = _core.Shell(shell)
    cloud = None if points is None else _core.as_points(points)
    measured = color == "deviation" and cloud is not None
    return picture_of(
        shell,
        picture,
        _title(shell),
        color=color,
        points=cloud,
        deviation=Deviation.of(shell, cloud) if measured and cloud is not None else None,
        tolerance=tolerance,
        isolines=isolines,
        border=_BORDER,
        backend=backend,
    )


def picture_of(
    shell: Shell,
    picture: Picture,
    title: str,
    *,
    color: str | None,
    points: NDArray[np.float64] | None = None,
    deviation: Deviation | None = None,
    tolerance: float | None = None,
    isolines: int = 0,
    net: NDArray[np.float64] | None = None,
    border: str = INK,
    backend: Backend = "matplotlib",
) -> Any:
    """Draw a shell in one panel or a window.

    Returns
    -------
    matplotlib.figure.Figure or pyvista.Plotter
    """
    in_window = is_pyvista(backend)
    others = [] if points is None else [points]
    others += [] if net is None else [net.reshape(-1, 3)]
    box = picture.box(np.array(shell.bounding_box()), *others)
    drawn, colors = colored(
        shell, box, color, isolines, picture.unit, tolerance, deviation, in_window=in_window
    )
    if in_window:
        return pyvista_scene.shell_plotter(
            box, drawn, colors, picture, points=points, net=net, border=border
        )
    figure, share = figure_of_panels(box, 1, picture, legend=bool(colors and colors.label))
    scale = panel_scale(figure, share)
    axes = add_panel(figure, box, title, 0.0, share)
    matplotlib_scene.draw_shell(axes, box, drawn, colors, points=points, border=border, scale=scale)
    if net is not None:
        matplotlib_scene.draw_net(axes, net, matplotlib_scene.POINT, scale)
    if colors is not None:
        colors.add_legend(figure, share)
    return figure


def colored(
    shell: Shell,
    box: AxesBox,
    color: str | None,
    isolines: int,
    unit: str,
    tolerance: float | None,
    deviation: Deviation | None,
    *,
    in_window: bool = False,
) -> tuple[DrawnShell, Coloring | None]:
    """Divide a shell into triangles and color them; None for the colors of the faces."""
    facets = matplotlib_scene.FINE_FACETS if color == "zebra" else matplotlib_scene.FACETS
    drawn = DrawnShell.of(shell, box, pyvista_scene.FACETS if in_window else facets, isolines)
    if color is None:
        return drawn, None
    scale = coloring(
        drawn, color, view=box.view, deviation=deviation, tolerance=tolerance, unit=unit
    )
    return drawn, scale


def is_pyvista(backend: str) -> bool:
    """Return whether PyVista draws; raise for a name of no backend."""
    if backend not in ("matplotlib", "pyvista"):
        raise argument_error("backend", f"must be 'matplotlib' or 'pyvista', got {backend!r}")
    return backend == "pyvista"


def _title(shell: Shell) -> str:
    faces, edges = len(shell.faces), len(shell.edges)
    counts = [f"{faces:,} face{'s' * (faces != 1)}", f"{edges:,} edge{'s' * (edges != 1)}"]
    if shell.is_closed:
        return ", ".join([*counts, f"closed, volume {_rounded(shell.volume(accuracy=1e-6))}"])
    return ", ".join([*counts, f"area {_rounded(shell.area(accuracy=1e-6))}"])


def _rounded(value: float) -> str:
    return number(float(f"{value:.4g}"))
