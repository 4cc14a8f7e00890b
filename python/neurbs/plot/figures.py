"""Figures of a reconstruction, a surface and points."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from neurbs import _core
from neurbs._core import NeurbsError
from neurbs.choices import Backend, SurfaceColor, ViewChoice
from neurbs.deviation import Deviation
from neurbs.io import WRITABLE
from neurbs.io.atomic_write import atomic_write
from neurbs.plot import pyvista_scene
from neurbs.plot.maps import grid_size
from neurbs.plot.matplotlib_scene import draw_net, draw_points, draw_shell
from neurbs.plot.panel import add_panel, figure_of_panels, panel_scale
from neurbs.plot.picture import Picture
from neurbs.plot.shells import colored, is_pyvista, picture_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

    from neurbs import NurbsSurface, Reconstruction, Shell

_VECTOR_DPI = 200.0
"""Dots per inch of the images in files of vectors: surfaces with tens of thousands of facets."""


def plot_reconstruction(
    result: Reconstruction,
    *,
    color: SurfaceColor = "height",
    tolerance: float | None = None,
    unit: str = "",
    isolines: int = 20,
    view: ViewChoice = "iso",
    size: Sequence[float] | None = None,
    dpi: float = 100.0,
    exaggeration: float | None = None,
    backend: Backend = "matplotlib",
) -> Any:
    """Draw the points with the trained lattice, and the faces beside them.

    Points that were left out of the fit are not drawn. Parts are drawn to scale. Heights that would
    hardly be seen, such as those of terrain, are drawn longer, and the label of z gives the factor;
    so are axes whose units differ.

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
        Name of the points' unit, for the legend; by default that of the result. With a unit of
        parts (mm, cm or in) heights are to scale.
    isolines : int, default 20
        Isoparametric lines across the longer direction; 0 for none.
    view : {"iso", "top", "front", "side"}, default "iso"
        The direction of the viewer: at an angle from above; along z, x to the right; along y, x to
        the right; along x, y to the right.
    size : (float, float), optional
        Width and height in inches; by default without empty space.
    dpi : float, default 100
        Dots per inch.
    exaggeration : float, optional
        The factor by which heights are drawn longer; 1 is to scale.
    backend : {"matplotlib", "pyvista"}, default "matplotlib"
        The library that draws. PyVista shows faces and points in a window that is turned with
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
    picture = Picture(view, size, dpi, exaggeration, unit)
    deviation = Deviation.of_result(result) if color == "deviation" else None
    points = result.points[result.inliers]
    if is_pyvista(backend):
        return picture_of(
            result.shell,
            picture,
            "",
            color=color,
            points=points,
            deviation=deviation,
            tolerance=tolerance,
            isolines=isolines,
            backend=backend,
        )
    box = picture.box(points, np.array(result.shell.bounding_box()))
    drawn, colors = colored(result.shell, box, color, isolines, unit, tolerance, deviation)
    figure, share = figure_of_panels(box, 2, picture, legend=bool(colors and colors.label))
    scale = panel_scale(figure, share)
    lattice = result.som.codebook_
    left_out = len(result.points) - len(points)
    counts = f"{len(points):,} points" + (f" ({left_out:,} left out)" if left_out else "")
    left = add_panel(figure, box, f"{counts}, {grid_size(lattice)} lattice", 0.0, share)
    right = add_panel(figure, box, _title(result.surface, result.shell), share, share)
    draw_points(left, points, scale)
    draw_net(left, lattice, scale=scale)
    shown = points if color == "height" else None
    draw_shell(right, box, drawn, colors, points=shown, scale=scale)
    if colors is not None:
        colors.add_legend(figure, 2 * share)
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
    view: ViewChoice = "iso",
    size: Sequence[float] | None = None,
    dpi: float = 100.0,
    exaggeration: float | None = None,
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
    view, size, dpi, exaggeration
        As for `plot_reconstruction`.
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
    measured = color == "deviation" and cloud is not None
    shell = _core.Shell(surface)
    return picture_of(
        shell,
        Picture(view, size, dpi, exaggeration, unit),
        _title(surface, shell),
        color=color,
        points=cloud,
        deviation=Deviation.of(surface, cloud) if measured and cloud is not None else None,
        tolerance=tolerance,
        isolines=isolines,
        net=surface.control_points if control_net else None,
        backend=backend,
    )


def plot_points(
    points: ArrayLike,
    *,
    unit: str = "",
    view: ViewChoice = "iso",
    size: Sequence[float] | None = None,
    dpi: float = 100.0,
    exaggeration: float | None = None,
    backend: Backend = "matplotlib",
) -> Any:
    """Draw points, or a sample of many.

    Parameters
    ----------
    points : array_like of shape (n, 3) or (n, 2)
        The points.
    unit, view, size, dpi, exaggeration
        As for `plot_reconstruction`.
    backend : {"matplotlib", "pyvista"}, default "matplotlib"
        The library that draws.

    Returns
    -------
    matplotlib.figure.Figure or pyvista.Plotter
    """
    cloud = _core.as_points(points)
    picture = Picture(view, size, dpi, exaggeration, unit)
    box = picture.box(cloud)
    if is_pyvista(backend):
        return pyvista_scene.points_plotter(box, cloud, picture)
    figure, share = figure_of_panels(box, 1, picture, legend=False)
    axes = add_panel(figure, box, f"{len(cloud):,} points", 0.0, share)
    draw_points(axes, cloud, panel_scale(figure, share))
    return figure


def save_picture(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write a figure as PNG, SVG or PDF; the file is complete or does not exist.

    Raises
    ------
    NeurbsError
        If the suffix is another.
    OSError
        If the file cannot be written.
    """
    with atomic_write(Path(path)) as new:
        write_picture(figure, new, Path(path).suffix)


def write_picture(figure: Figure, path: str, suffix: str) -> None:
    """Write a figure directly to a file of any name, in the format of a suffix."""
    import matplotlib

    kind = suffix.lower()
    if kind not in WRITABLE["picture"]:
        got = f"the suffix {suffix!r}" if suffix else "no suffix"
        suffixes = ", ".join(WRITABLE["picture"])
        raise NeurbsError(f"a picture must have the suffix {suffixes}, got {got}")
    # The same figure gives the same file: without the date, and with fixed names of its parts.
    dates = {".png": {}, ".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
    dpi = figure.dpi if kind == ".png" else max(figure.dpi, _VECTOR_DPI)
    with matplotlib.rc_context({"svg.hashsalt": "neurbs"}):
        figure.savefig(path, format=kind[1:], dpi=dpi, metadata=dates[kind])


def _title(surface: NurbsSurface, shell: Shell) -> str:
    u, v = surface.degree
    degree = f"degree {u}" if u == v else f"degrees {u} and {v}"
    return f"{_name(shell)}, {grid_size(surface.control_points)} control points, {degree}"


def _name(shell: Shell) -> str:
    """Return what a shell on one surface is."""
    faces = shell.faces
    if len(faces) > 1:
        return f"{len(faces)} NURBS faces"
    if not faces[0].is_trimmed:
        return "NURBS surface"
    holes = len(faces[0].inner)
    return "NURBS face" + (f" with {holes} hole{'s' * (holes > 1)}" if holes else "")
