"""Points of commands: the files that hold them, and how these are read."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, TypeAlias

import numpy as np
import typer
from numpy.typing import NDArray

import neurbs
from neurbs import PointCloud, io
from neurbs.cli.options import blamed
from neurbs.io.points import warn_dropped

Points: TypeAlias = Annotated[
    Path,
    typer.Argument(
        metavar="POINTS", help=f"File of points: {' '.join(io.READABLE)}", readable=False
    ),
]
Columns: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--columns",
        metavar="X,Y,Z",
        help="Columns of a table or an array that hold the coordinates: names or numbers from 0",
    ),
]
Nan: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--nan",
        metavar="WORD",
        help="What becomes of points that are not finite or incomplete (error|drop, "
        "default: error)",
    ),
]


def check_points(context: typer.Context, path: Path) -> None:
    """Check that points may be in a file of this name."""
    # That there is no such file matters more than its suffix; reading it will say so.
    if path.is_file():
        try:
            io.check_source(path)
        except neurbs.NeurbsError as error:
            raise typer.BadParameter(str(error), ctx=context, param_hint="'POINTS'") from None


def read_points(
    context: typer.Context, path: Path, columns: str | None, nan: str | None
) -> NDArray[np.float64]:
    """Read the points of a file alone."""
    given = _given(columns, nan)
    with blamed(context, given):
        points: NDArray[np.float64] = neurbs.read_points(path, **given)
    return points


def read_point_cloud(
    context: typer.Context, path: Path, columns: str | None, nan: str | None
) -> PointCloud:
    """Read a file of points with all that it knows, and say how many were dropped if asked for."""
    given = _given(columns, nan)
    with blamed(context, given):
        cloud = neurbs.read_point_cloud(path, **given)
    if nan == "drop":
        warn_dropped(path, cloud.dropped, len(cloud))
    return cloud


def _given(columns: str | None, nan: str | None) -> dict[str, Any]:
    """Return the options of reading that were given, as Python takes them."""
    given: dict[str, Any] = {}
    if columns is not None:
        given["columns"] = [_column(name) for name in columns.split(",")]
    if nan is not None:
        given["nan"] = nan
    return given


def _column(name: str) -> str | int:
    """Return a column's name, or its number if it is one."""
    name = name.strip()
    return int(name) if name.isdecimal() else name
