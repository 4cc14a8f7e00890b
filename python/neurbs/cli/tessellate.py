"""`neurbs tessellate`: a surface or shell to triangles."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

import neurbs
from neurbs import NeurbsError, NurbsSurface, io
from neurbs.cli.command import command, print_json, print_table
from neurbs.cli.completion import of_suffixes
from neurbs.cli.config import Config
from neurbs.cli.inputs import Surface, only_surface
from neurbs.cli.options import FILES, AsJson, Option, Quiet, Unit, options_of, values
from neurbs.cli.outputs import check_outputs

OPTIONS = (
    Option(
        "tolerance",
        "Largest distance between surface and triangles, in the points' unit",
        "NUMBER",
        default="0.001 of the diagonal of the control net's bounding box",
    ),
    Option(
        "shape",
        "Vertices along u and v of a uniform grid, instead of a tolerance",
        "N N",
        default="no grid",
    ),
    Option(
        "relative",
        "Take --tolerance as a share of the diagonal of the control net's bounding box",
        "",
    ),
    Option(
        "max_angle",
        "Largest angle between the surface's normals at the ends of an edge, in radians",
        "NUMBER",
        default="no limit",
    ),
    Option(
        "max_edge",
        "Largest length of an edge, in the points' unit",
        "NUMBER",
        default="no limit",
    ),
    Option(
        "max_aspect",
        "Largest ratio of the sides of a piece that becomes two triangles, at least 4",
        "NUMBER",
        default="no limit",
    ),
    Option("split_seams", "Split closed directions at the seam, with two vertices for each", ""),
    Option("max_triangles", "Most triangles of the mesh", "N"),
)
"""Options of `neurbs.NurbsSurface.tessellate`."""


@command("Turn a surface or shell into triangles.", "neurbs tessellate part.step -o part.stl")
@options_of(NurbsSurface.tessellate, OPTIONS, "Triangles")
def tessellate(
    context: typer.Context,
    surface: Surface,
    output: Annotated[
        list[Path],
        typer.Option(
            "--output",
            "-o",
            metavar="MESH",
            help="File to write: " + " ".join(io.WRITABLE["mesh"]),
            autocompletion=of_suffixes(*io.WRITABLE["mesh"]),
            rich_help_panel=FILES,
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
    """Run `neurbs.NurbsSurface.tessellate` on the surface or shell of a file."""
    check_outputs(context, output, [surface])
    given = values(options)
    shell = neurbs.load_shell(surface, unit=unit)
    loaded = only_surface(shell) or shell
    if "shape" in given and loaded is shell:
        raise NeurbsError(f"{surface}: --shape must be left out: the file has trims or many faces")
    mesh = loaded.tessellate(**given)
    for path in output:
        neurbs.save(mesh, path, unit=shell.unit)
    files = [str(path) for path in output]
    counts = {"vertices": len(mesh.vertices), "triangles": len(mesh.triangles)}
    if as_json:
        print_json({"input": str(surface), **counts, "files": files})
    elif not quiet:
        print_table({name: f"{n:,}" for name, n in counts.items()} | {"written": ", ".join(files)})
