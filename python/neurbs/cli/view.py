"""`neurbs view`: the content of a file as a picture."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from numpy.typing import NDArray

from neurbs import NeurbsError, PointCloud, SelfOrganizingMap, Shell, io
from neurbs.choices import Backend
from neurbs.cli.command import command, print_table
from neurbs.cli.completion import of_suffixes
from neurbs.cli.config import Config
from neurbs.cli.inputs import Columns, File, Nan, is_map, load, only_surface, read_points
from neurbs.cli.options import FILES, Option, Quiet, Unit, flag, options_of, values
from neurbs.io.units import file_unit
from neurbs.plot import plot_map, plot_points, plot_shell, plot_surface, save_picture
from neurbs.plot.standard_view import VIEWS

OPTIONS = (
    Option(
        "color",
        "Quantity that colors show: height, deviation of the points, mean or Gaussian curvature, "
        "or zebra stripes",
        choices=("height", "deviation", "mean", "gaussian", "zebra"),
        default="deviation with --points, else height",
    ),
    Option(
        "tolerance",
        "Deviation at the ends of the color scale, in the points' unit",
        "NUMBER",
        default="by the deviations",
    ),
    Option("isolines", "Isoparametric lines across the longer direction; 0 for none", "N"),
    Option("control_net", "Draw the control net of a surface too", ""),
    Option(
        "view",
        "Direction of the viewer: at an angle from above, or along z, y or x",
        choices=tuple(VIEWS),
    ),
    Option(
        "size",
        "Width and height of the picture in inches",
        "N N",
        default="without empty space",
    ),
    Option("dpi", "Dots per inch", "N"),
    Option(
        "exaggeration",
        "Factor by which heights are drawn longer; 1 is to scale",
        "NUMBER",
        default="1, unless heights would hardly be seen",
    ),
)
"""Options of `neurbs.plot.plot_surface`."""

_OF_POINTS = ("view", "size", "dpi", "exaggeration")
"""Options that pictures of points and maps have, too."""


@command(
    "Show a file in a window, or write a picture. It has a surface, a shell, points or a map.",
    "neurbs view part.step --points scan.ply --color deviation",
)
@options_of(plot_surface, OPTIONS, "Picture")
def view(
    context: typer.Context,
    file: File,
    *,
    points: Annotated[
        Path | None,
        typer.Option(
            metavar="POINTS",
            help="Points to draw with a surface",
            readable=False,
            rich_help_panel=FILES,
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="OUT",
            help=f"Write a picture ({' '.join(io.WRITABLE['picture'])}) and open no window",
            autocompletion=of_suffixes(*io.WRITABLE["picture"]),
            rich_help_panel=FILES,
        ),
    ] = None,
    columns: Columns = None,
    nan: Nan = None,
    unit: Unit = None,
    config: Config = None,
    quiet: Quiet = False,
    **options: Any,
) -> None:
    """Run `plot_surface`, `plot_shell`, `plot_points` or `plot_map` on the content of a file."""
    if output is not None and output.suffix.lower() not in io.WRITABLE["picture"]:
        suffixes = ", ".join(io.WRITABLE["picture"])
        raise typer.BadParameter(
            f"{output}: must have the suffix {suffixes}", ctx=context, param_hint="'--output'"
        )
    if output is None:
        _check_display()
    given = values(options)
    drawn: Any
    if is_map(file):
        if output is None:
            raise NeurbsError(f"{file}: a map is drawn as a picture: write one with -o")
        _refuse(file, "a map", [name for name in given if name not in _OF_POINTS])
        cloud = None if points is None else read_points(points, columns, nan, unit)
        drawn = plot_map(SelfOrganizingMap.load(file), cloud, **given)
    else:
        thing = load(file, columns, nan, unit)
        cloud = None if points is None else read_points(points, columns, nan, file_unit(thing.unit))
        drawn = _drawn(file, thing, cloud, given, "pyvista" if output is None else "matplotlib")
    if output is None:
        drawn.show(title=str(file))
        return
    save_picture(drawn, output)
    if not quiet:
        print_table({"written": str(output)})


def _drawn(
    file: Path,
    thing: Shell | PointCloud,
    cloud: NDArray[np.float64] | None,
    given: dict[str, Any],
    backend: Backend,
) -> Any:
    """Draw the content of a file, with points in its unit."""
    # Parts in millimeters are drawn to scale.
    unit = thing.unit or ""
    if isinstance(thing, PointCloud):
        _refuse(file, "points", [name for name in given if name not in _OF_POINTS])
        return plot_points(thing.points, backend=backend, unit=unit, **given)
    if surface := only_surface(thing):
        return plot_surface(surface, cloud, backend=backend, unit=unit, **given)
    _refuse(file, "a shell", [name for name in given if name == "control_net"])
    return plot_shell(thing, cloud, backend=backend, unit=unit, **given)


def _refuse(file: Path, content: str, names: list[str]) -> None:
    """Raise if there are options that the content of a file does not have."""
    if names:
        words = ", ".join(map(flag, names))
        raise NeurbsError(f"{file}: {words} must be left out: the file has {content}")


def _check_display() -> None:
    """Raise if there is no screen: VTK would end the process."""
    screens = ("DISPLAY", "WAYLAND_DISPLAY")
    if sys.platform == "linux" and not any(map(os.environ.get, screens)):
        raise NeurbsError("a window needs a screen, and there is none: write a picture with -o")
