"""`neurbs tessellate` and `neurbs convert`: from one file to another."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

import neurbs
from neurbs import NurbsSurface, PointCloud, io
from neurbs.cli.command import app, print_json, print_table
from neurbs.cli.options import (
    AsJson,
    Config,
    Quiet,
    Surface,
    Unit,
    blamed,
    options_of,
    values,
)
from neurbs.cli.outputs import check_outputs
from neurbs.cli.points import Columns, Nan, read_point_cloud


@app.command()
@options_of(NurbsSurface.tessellate)
def tessellate(
    context: typer.Context,
    surface: Surface,
    output: Annotated[
        list[Path],
        typer.Option(
            "--output",
            "-o",
            metavar="MESH",
            help="File to write; give it again for another: " + " ".join(io.WRITABLE["mesh"]),
            readable=False,
        ),
    ],
    *,
    unit: Unit = None,
    config: Config = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    **options: Any,
) -> None:
    """Turn a surface into triangles.

    Example: neurbs tessellate part.step -o part.stl
    """
    check_outputs(context, output, [surface])
    given = values(options)
    loaded = neurbs.load_surface(surface)
    with blamed(context, given):
        mesh = loaded.tessellate(**given)
    for path in output:
        neurbs.save(mesh, path, unit=unit)
    files = [str(path) for path in output]
    counts = {"vertices": len(mesh.vertices), "triangles": len(mesh.triangles)}
    if as_json:
        print_json({"input": str(surface), **counts, "files": files})
    elif not quiet:
        print_table({name: f"{n:,}" for name, n in counts.items()} | {"written": ", ".join(files)})


@app.command()
def convert(
    context: typer.Context,
    source: Annotated[
        Path,
        typer.Argument(
            metavar="IN",
            help=f"A surface ({' '.join(io.LOADABLE)}) or points ({' '.join(io.READABLE)})",
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
    """Write a surface or points in another format.

    Example: neurbs convert part.json part.step
    """
    check_outputs(context, [target], [source])
    thing = load(context, source, columns, nan)
    with blamed(context, {"unit": unit}):
        neurbs.save(thing, target, unit=unit)
    if as_json:
        print_json({"input": str(source), "files": [str(target)]})
    elif not quiet:
        print_table({"read": repr(thing), "written": str(target)})


def load(
    context: typer.Context, path: Path, columns: str | None, nan: str | None
) -> NurbsSurface | PointCloud:
    """Read what a file holds, by its suffix: a surface or points."""
    if path.suffix.lower() in io.LOADABLE:
        return neurbs.load_surface(path)
    return read_point_cloud(context, path, columns, nan)
