"""`neurbs info`: the content of a file in words."""

from __future__ import annotations

from typing import Any

import numpy as np
import typer

from neurbs import NurbsSurface, PointCloud, SelfOrganizingMap, Shell
from neurbs.cli.command import command, print_json, print_table
from neurbs.cli.config import Config
from neurbs.cli.inputs import Columns, File, Nan, is_map, load, only_surface
from neurbs.cli.options import AsJson, Unit
from neurbs.errors import printable

_MAX_NAMES = 10
"""Names of faces that are shown."""


@command(
    "Describe the content of a file. It has a surface, a shell, points or a map (.npz).",
    "neurbs info part.step",
)
def info(
    context: typer.Context,
    file: File,
    *,
    columns: Columns = None,
    nan: Nan = None,
    unit: Unit = None,
    config: Config = None,
    as_json: AsJson = False,
) -> None:
    """Print the main facts about the content of a file."""
    if is_map(file):
        facts = _of_map(SelfOrganizingMap.load(file))
    else:
        thing = load(file, columns, nan, unit)
        facts = _of_shell(thing) if isinstance(thing, Shell) else _of_points(thing)
    if as_json:
        print_json({"input": str(file), **facts})
    else:
        print_table({name.replace("_", " "): _text(value) for name, value in facts.items()})


def _of_shell(shell: Shell) -> dict[str, Any]:
    surface = only_surface(shell)
    facts = _of_faces(shell) if surface is None else _of_surface(surface)
    low, high = shell.bounding_box()
    facts |= {"unit": shell.unit}
    facts |= {"low": low.tolist(), "high": high.tolist(), "area": shell.area(accuracy=1e-6)}
    return facts | ({"volume": shell.volume(accuracy=1e-6)} if shell.is_closed else {})


def _of_surface(surface: NurbsSurface) -> dict[str, Any]:
    return {
        "kind": "surface",
        "net": list(surface.control_points.shape[:2]),
        "degree": list(surface.degree),
        "domain": [list(ends) for ends in surface.domain],
        "rational": surface.weights is not None,
        "closed": list(surface.closed),
    }


def _of_faces(shell: Shell) -> dict[str, Any]:
    names = [face.name for face in shell.faces if face.name]
    return {
        "kind": "shell",
        "faces": len(shell.faces),
        "trimmed_faces": sum(face.is_trimmed for face in shell.faces),
        "holes": sum(len(face.inner) for face in shell.faces),
        "edges": len(shell.edges),
        "border_edges": len(shell.border()),
        "closed": shell.is_closed,
        **({"names": names[:_MAX_NAMES]} if names else {}),
    }


def _of_points(cloud: PointCloud) -> dict[str, Any]:
    low, high = cloud.points.min(axis=0), cloud.points.max(axis=0)
    facts: dict[str, Any] = {
        "kind": "points",
        "points": len(cloud.points),
        "unit": cloud.unit,
        "low": low.tolist(),
        "high": high.tolist(),
        "diagonal": float(np.linalg.norm(high - low)),
        "normals": cloud.normals is not None,
        "colors": cloud.colors is not None,
    }
    known = {"columns": cloud.columns, "crs": cloud.crs, "offset": cloud.offset}
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
        case None:
            return "unknown"
        case bool():
            return "yes" if value else "no"
        case float():
            return f"{value + 0.0:,.10g}"  # Adding 0 turns −0 into 0.
        case int():
            return f"{value:,}"
        case list() | tuple():
            return ", ".join(map(_text, value))
    return printable(str(value))
