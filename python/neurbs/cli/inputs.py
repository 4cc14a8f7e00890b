"""The files that commands read: arguments, options and readers."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, TypeAlias, cast

import numpy as np
import typer
from numpy.typing import NDArray

import neurbs
from neurbs import NurbsSurface, PointCloud, Shell, io
from neurbs.cli.completion import of_words
from neurbs.cli.options import FILES, values
from neurbs.io.obj import is_free_form
from neurbs.io.packed import name_of
from neurbs.io.point_readers import warn_dropped

FACE_FILES = f"{' '.join(io.LOADABLE)}, free-form .obj"
"""The formats of surfaces and shells, for help texts."""

Surface: TypeAlias = Annotated[
    Path,
    typer.Argument(
        metavar="SURFACE",
        help=f"File of a surface or shell: {FACE_FILES}",
        readable=False,
    ),
]
Points: TypeAlias = Annotated[
    Path,
    typer.Argument(
        metavar="POINTS", help=f"File of points: {' '.join(io.READABLE)}", readable=False
    ),
]
File: TypeAlias = Annotated[
    Path, typer.Argument(metavar="FILE", help="A surface or shell, points or a map", readable=False)
]
Columns: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--columns",
        metavar="X,Y,Z",
        help="Columns of the coordinates in a table or an array: names, or numbers from 0",
        rich_help_panel=FILES,
    ),
]
Nan: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--nan",
        metavar="WORD",
        help="Treatment of points that are incomplete or not finite (error|drop, default: error)",
        autocompletion=of_words("error", "drop"),
        rich_help_panel=FILES,
    ),
]
Bounds: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--bounds",
        metavar="XMIN,YMIN,XMAX,YMAX",
        help="The lowest and the highest coordinates of the points to read, of x and y or of x, y "
        "and z (default: all points)",
        rich_help_panel=FILES,
    ),
]
Cell: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--cell",
        metavar="SIZE",
        help="Side of the cubes of which each keeps its first point (default: all points)",
        rich_help_panel=FILES,
    ),
]
LasClasses: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--las-classes",
        metavar="N,N",
        help="Classes of the points to read from .las and .laz: 2 is ground (default: all)",
        rich_help_panel=FILES,
    ),
]


def check_points(context: typer.Context, path: Path) -> None:
    """Raise if a file has no suffix of a point format."""
    # A missing file is reported by the reader.
    if path.is_file():
        try:
            io.check_source(path)
        except neurbs.NeurbsError as error:
            raise typer.BadParameter(str(error), ctx=context, param_hint="'POINTS'") from None


def read_points(
    path: Path, columns: str | None, nan: str | None, unit: str | None = None
) -> NDArray[np.float64]:
    """Read the coordinates of a file."""
    points: NDArray[np.float64] = neurbs.read_points(path, **reading_options(columns, nan, unit))
    return points


def read_point_cloud(path: Path, reading: dict[str, Any]) -> PointCloud:
    """Read the points of a file with their attributes, and warn of dropped points."""
    cloud = neurbs.read_point_cloud(path, **reading)
    if reading.get("nan") == "drop":
        warn_dropped(name_of(path), cloud.dropped - cloud.no_data, len(cloud))
    return cloud


def has_faces(path: Path) -> bool:
    """Whether a file has a surface or a shell, and not points, by its suffix."""
    suffix = path.suffix.lower()
    # The vertices of other OBJ files are points.
    return suffix in io.LOADABLE or (suffix == ".obj" and path.is_file() and is_free_form(path))


def is_map(file: Path) -> bool:
    """Whether a file is an archive with a map; an .npz may also have points."""
    if file.suffix.lower() != ".npz" or not file.is_file():
        return False
    try:
        with np.load(file, allow_pickle=False) as archive:
            return "codebook" in archive.files
    except Exception:  # A damaged archive may raise any error. The reader reports it.
        return False


def load(
    path: Path, columns: str | None, nan: str | None, unit: str | None = None
) -> Shell | PointCloud:
    """Read a shell or points."""
    if has_faces(path):
        return neurbs.load_shell(path, unit=unit)
    return read_point_cloud(path, reading_options(columns, nan, unit))


def in_unit(thing: Shell | PointCloud, unit: str) -> Shell | PointCloud:
    """Convert a shell or points to a unit of `LENGTH_UNITS`."""
    return thing.to_unit(cast(Any, unit))


def only_surface(shell: Shell) -> NurbsSurface | None:
    """Return the surface of a shell of one face that is whole and not reversed."""
    face, *others = shell.faces
    return None if others or face.is_trimmed or face.is_reversed else face.surface


def reading_options(
    columns: str | None,
    nan: str | None,
    unit: str | None,
    *,
    bounds: str | None = None,
    cell: str | None = None,
    las_classes: str | None = None,
) -> dict[str, Any]:
    """Return the given options as arguments of `neurbs.read_points`."""
    given = values({"nan": nan, "unit": unit, "bounds": bounds, "cell": cell})
    if columns is not None:
        given["columns"] = [_column(name) for name in columns.split(",")]
    if las_classes is not None:
        given["las_classes"] = [_column(number) for number in las_classes.split(",")]
    return given


def _column(name: str) -> str | int:
    """Return the number of a column, or its name if it is no number."""
    name = name.strip()
    return int(name) if name.isdecimal() else name
