"""`neurbs info` and `neurbs view`: what a file holds, in words and as a picture."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from neurbs import NeurbsError, NurbsSurface, PointCloud, SelfOrganizingMap
from neurbs.cli.command import app, print_json, print_table
from neurbs.cli.options import AsJson, Config, Quiet, blamed, options_of, values
from neurbs.cli.points import Columns, Nan, read_points
from neurbs.cli.surfaces import load
from neurbs.plot import plot_points, plot_surface, save_picture

_MAP = ".npz"

File = Annotated[
    Path, typer.Argument(metavar="FILE", help="A surface, points or a map", readable=False)
]


@app.command()
def info(
    context: typer.Context,
    file: File,
    *,
    columns: Columns = None,
    nan: Nan = None,
    config: Config = None,
    as_json: AsJson = False,
) -> None:
    """Say what a file holds: a surface, points, or a trained map (.npz).

    Example: neurbs info part.step
    """
    if _is_map(file):
        facts = _of_map(SelfOrganizingMap.load(file))
    else:
        thing = load(context, file, columns, nan)
        facts = _of_surface(thing) if isinstance(thing, NurbsSurface) else _of_points(thing)
    if as_json:
        print_json({"input": str(file), **facts})
    else:
        print_table({name.replace("_", " "): _text(value) for name, value in facts.items()})


@app.command()
@options_of(plot_surface, "surface", "backend")
def view(
    context: typer.Context,
    file: File,
    *,
    points: Annotated[
        Path | None,
        typer.Option(metavar="POINTS", help="Points to draw with a surface", readable=False),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", metavar="OUT.png", help="Write a picture, and open no window"
        ),
    ] = None,
    columns: Columns = None,
    nan: Nan = None,
    config: Config = None,
    quiet: Quiet = False,
    **options: Any,
) -> None:
    """Show a surface or points in a window, or write a picture of them.

    Example: neurbs view part.step --points scan.ply --color deviation
    """
    if output is not None and output.suffix.lower() != ".png":
        raise typer.BadParameter(
            f"{output}: a picture is written as .png", ctx=context, param_hint="'--output'"
        )
    if output is None:
        _check_display()
    thing, given = load(context, file, columns, nan), values(options)
    backend = "pyvista" if output is None else "matplotlib"
    cloud = None if points is None else read_points(context, points, columns, nan)
    with blamed(context, given):
        if isinstance(thing, NurbsSurface):
            drawn = plot_surface(thing, cloud, backend=backend, **given)
        else:
            drawn = plot_points(thing.points, backend=backend)
    if output is None:
        drawn.show(title=str(file))
        return
    save_picture(drawn, output)
    if not quiet:
        print_table({"written": str(output)})


def _is_map(file: Path) -> bool:
    """Whether a NumPy archive is a map; it may also hold points."""
    if file.suffix.lower() != _MAP or not file.is_file():
        return False
    try:
        with np.load(file, allow_pickle=False) as archive:
            return "codebook" in archive.files
    except (OSError, ValueError, EOFError):
        return False


def _of_surface(surface: NurbsSurface) -> dict[str, Any]:
    low, high = surface.bounding_box()
    return {
        "kind": "surface",
        "net": list(surface.control_points.shape[:2]),
        "degree": list(surface.degree),
        "domain": [list(ends) for ends in surface.domain],
        "rational": surface.weights is not None,
        "closed": list(surface.closed),
        "low": low.tolist(),
        "high": high.tolist(),
        "area": surface.area(accuracy=1e-6),
    }


def _of_points(cloud: PointCloud) -> dict[str, Any]:
    low, high = cloud.points.min(axis=0), cloud.points.max(axis=0)
    facts: dict[str, Any] = {
        "kind": "points",
        "points": len(cloud.points),
        "low": low.tolist(),
        "high": high.tolist(),
        "diagonal": float(np.linalg.norm(high - low)),
        "normals": cloud.normals is not None,
        "colors": cloud.colors is not None,
    }
    known = {"unit": cloud.unit, "crs": cloud.crs, "offset": cloud.offset}
    return facts | {name: value for name, value in known.items() if value is not None}


def _of_map(som: SelfOrganizingMap) -> dict[str, Any]:
    return {
        "kind": "map",
        "nodes": list(som.codebook_.shape[:-1]),
        "topology": som.lattice_.topology,
        "training": som.training,
        "steps": som.n_iter_,
        "stopped_by": som.stopped_by_,
    }


def _text(value: Any) -> str:
    match value:
        case bool():
            return "yes" if value else "no"
        case float():
            return f"{value + 0.0:,.10g}"  # There is no −0 for readers.
        case int():
            return f"{value:,}"
        case list() | tuple():
            return ", ".join(map(_text, value))
    return str(value)


def _check_display() -> None:
    """Check that there is a screen, without which VTK ends the whole program."""
    screens = ("DISPLAY", "WAYLAND_DISPLAY")
    if sys.platform == "linux" and not any(map(os.environ.get, screens)):
        raise NeurbsError("a window needs a screen, and there is none: write a picture with -o")
