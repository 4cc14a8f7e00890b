"""`neurbs convert`: shells or points in another format or unit."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

import neurbs
from neurbs import NeurbsError, NurbsSurface, PointCloud, Shell, io
from neurbs._core import LENGTH_UNITS
from neurbs.cli.command import command, print_json, print_table
from neurbs.cli.completion import of_suffixes, of_words
from neurbs.cli.config import Config
from neurbs.cli.inputs import FACE_FILES, Columns, Nan, has_faces, in_unit, load, only_surface
from neurbs.cli.options import FILES, AsJson, Quiet, Unit
from neurbs.cli.outputs import check_outputs
from neurbs.io.units import check_unit

_TARGETS = tuple(
    dict.fromkeys(suffix for part in ("surface", "mesh", "points") for suffix in io.WRITABLE[part])
)


@command(
    "Write a shell or points in another format or unit.",
    "neurbs convert part.json part.step",
    "neurbs convert inches.step millimeters.step --unit mm",
)
def convert(
    context: typer.Context,
    source: Annotated[
        Path,
        typer.Argument(
            metavar="IN",
            help=f"A surface or shell ({FACE_FILES}), or points ({' '.join(io.READABLE)})",
            readable=False,
        ),
    ],
    target: Annotated[
        Path,
        typer.Argument(
            metavar="OUT",
            help="File to write, in another format or unit",
            readable=False,
            autocompletion=of_suffixes(*_TARGETS),
        ),
    ],
    *,
    columns: Columns = None,
    nan: Nan = None,
    from_unit: Annotated[
        str | None,
        typer.Option(
            "--from-unit",
            metavar="UNIT",
            help=f"Unit of the numbers in IN, if the file has none ({'|'.join(LENGTH_UNITS)})",
            autocompletion=of_words(*LENGTH_UNITS),
            rich_help_panel=FILES,
        ),
    ] = None,
    unit: Unit = None,
    config: Config = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Read a file and write it in the format of another suffix."""
    check_outputs(context, [target], [source])
    check_unit(unit)
    if from_unit not in (None, *LENGTH_UNITS):
        _refuse_unit(context, f"must be one of {', '.join(LENGTH_UNITS)}, got {from_unit!r}")
    if not has_faces(source) and target.suffix.lower() not in io.WRITABLE["points"]:
        _point_to_reconstruct(source, target, columns, nan, unit or from_unit)
    read = load(source, columns, nan, unit if from_unit is None else None)
    if from_unit is not None and read.unit not in (None, from_unit):
        _refuse_unit(context, f"must be left out, as {source} has the unit {read.unit!r}")
    for wanted in (from_unit, unit):
        read = read if wanted is None else in_unit(read, wanted)
    thing: Shell | NurbsSurface | PointCloud = read
    surface = only_surface(read) if isinstance(read, Shell) else None
    if surface is not None and target.suffix.lower() == ".json":
        # Other programs read the form that geomdl has for one surface.
        thing = surface
    # The unit of points, which may not be a length, is theirs.
    neurbs.save(thing, target, unit=None if isinstance(read, PointCloud) else read.unit)
    if as_json:
        print_json({"input": str(source), "unit": read.unit, "files": [str(target)]})
    elif not quiet:
        print_table({"read": repr(thing), "written": str(target)})


def _refuse_unit(context: typer.Context, message: str) -> None:
    raise typer.BadParameter(message, ctx=context, param_hint="'--from-unit'")


def _point_to_reconstruct(
    source: Path, target: Path, columns: str | None, nan: str | None, unit: str | None
) -> None:
    """Raise an error with the command that makes a surface from the points of a file."""
    io.check_source(source)
    words = ["neurbs", "reconstruct", str(source), "-o", str(target)]
    for name, value in (("--columns", columns), ("--nan", nan), ("--unit", unit)):
        words += [] if value is None else [name, value]
    raise NeurbsError(
        f"{source}: has points, and {target.suffix} files are made from a surface: fit one with "
        f"`{shlex.join(words)}`"
    )
