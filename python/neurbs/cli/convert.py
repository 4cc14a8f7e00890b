"""`neurbs convert`: shells or points in another format."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import neurbs
from neurbs import NurbsSurface, PointCloud, Shell, io
from neurbs.cli.command import command, print_json, print_table
from neurbs.cli.config import Config
from neurbs.cli.inputs import Columns, Nan, load, only_surface
from neurbs.cli.options import AsJson, Quiet, Unit
from neurbs.cli.outputs import check_outputs


@command("Write a shell or points in another format.", "neurbs convert part.json part.step")
def convert(
    context: typer.Context,
    source: Annotated[
        Path,
        typer.Argument(
            metavar="IN",
            help=f"A surface or shell ({' '.join(io.LOADABLE)}), "
            f"or points ({' '.join(io.READABLE)})",
            readable=False,
        ),
    ],
    target: Annotated[
        Path, typer.Argument(metavar="OUT", help="File to write, in another format", readable=False)
    ],
    *,
    columns: Columns = None,
    nan: Nan = None,
    unit: Unit = None,
    config: Config = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Read a file and write it in the format of another suffix."""
    check_outputs(context, [target], [source])
    thing: Shell | NurbsSurface | PointCloud = load(source, columns, nan)
    surface = only_surface(thing) if isinstance(thing, Shell) else None
    if surface is not None and target.suffix.lower() == ".json":
        # Other programs read the form that geomdl has for one surface.
        thing = surface
    neurbs.save(thing, target, unit=unit)
    if as_json:
        print_json({"input": str(source), "files": [str(target)]})
    elif not quiet:
        print_table({"read": repr(thing), "written": str(target)})
