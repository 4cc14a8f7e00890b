"""`neurbs compare`: distances between two files, with an exit code for a tolerance."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, TypeAlias

import typer

import neurbs
from neurbs import PointCloud, Shell, io
from neurbs.cli.command import OUTSIDE, command, print_json, print_table
from neurbs.cli.completion import of_suffixes
from neurbs.cli.config import Config
from neurbs.cli.inputs import FACE_FILES, Columns, Nan, check_points, has_faces, in_unit, load
from neurbs.cli.options import FILES, AsJson, Quiet, Unit
from neurbs.cli.outputs import check_outputs
from neurbs.deviation import Deviation, sampled
from neurbs.io.units import check_unit, file_unit

_PERCENTS = (50.0, 90.0, 95.0, 99.0)
"""Percentiles that are reported."""

_CHECK = "Check"
"""The group of the options about the tolerance."""

_WRITABLE = " ".join(io.WRITABLE["points"])

Thing: TypeAlias = "Shell | PointCloud"


@command(
    "Measure the distances between two files. They have points, surfaces or shells; exit code 3 "
    "if too many distances are out of tolerance.",
    "neurbs compare part.step scan.ply --tolerance 0.05 -o deviations.ply",
    "neurbs compare old.step new.step",
    "neurbs compare monday.las friday.las",
)
def compare(
    context: typer.Context,
    reference: Annotated[
        Path,
        typer.Argument(
            metavar="A",
            help=f"The reference: a surface or shell ({FACE_FILES}), or points "
            f"({' '.join(io.READABLE)})",
            readable=False,
        ),
    ],
    measured: Annotated[
        Path,
        typer.Argument(
            metavar="B",
            help="The file whose distances from A are measured, in one of the same formats",
            readable=False,
        ),
    ],
    *,
    tolerance: Annotated[
        float | None,
        typer.Option(
            metavar="LENGTH",
            help="Largest distance from A, in the unit of the results",
            rich_help_panel=_CHECK,
        ),
    ] = None,
    share: Annotated[
        float,
        typer.Option(
            metavar="SHARE",
            help="Share of the distances, from 0 to 1, that must be within --tolerance "
            "(default: 1)",
            show_default=False,
            rich_help_panel=_CHECK,
        ),
    ] = 1.0,
    output: Annotated[
        list[Path] | None,
        typer.Option(
            "--output",
            "-o",
            metavar="OUT",
            help=f"File to write: the points with their distances ({_WRITABLE})",
            readable=False,
            autocompletion=of_suffixes(*io.WRITABLE["points"]),
            rich_help_panel=FILES,
        ),
    ] = None,
    columns: Columns = None,
    nan: Nan = None,
    unit: Unit = None,
    config: Config = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> int:
    """Print the distances of a file from another and return the exit code."""
    paths = [reference, measured]
    _check(context, paths, output or [], tolerance, share)
    check_unit(unit)
    a, b = _in_one_unit(*(load(path, columns, nan, unit) for path in paths))
    if isinstance(a, PointCloud) and isinstance(b, Shell):
        # A point lies on a surface or not, but a cloud has gaps.
        a, b, paths = b, a, paths[::-1]
    cloud, deviation = _deviation(a, b)
    for path in output or []:
        distances = PointCloud(cloud.points, distances=deviation.distances, unit=cloud.unit)
        neurbs.save(distances, path)
    measures = _measures(deviation, signed=isinstance(a, Shell))
    if type(a) is type(b):
        back = _deviation(b, a)[1]
        measures["back"] = {"points": len(back.signed), "rms": back.rms, "max": back.max}
    passed = True
    if tolerance is not None:
        within = deviation.within(tolerance)
        passed = within >= share
        measures |= {"tolerance": tolerance, "within": within, "passed": passed}
    document = {
        "reference": str(paths[0]),
        "input": str(paths[1]),
        "unit": cloud.unit or a.unit,
        "deviation": measures,
        "files": [str(path) for path in output or []],
    }
    if as_json:
        print_json(document)
    elif not quiet:
        print_table(_summary(document))
    return 0 if passed else OUTSIDE


def _deviation(reference: Thing, measured: Thing) -> tuple[PointCloud, Deviation]:
    """Return points, or points that stand for a shell, and their distances from a reference."""
    cloud = measured
    if isinstance(cloud, Shell):
        cloud = PointCloud(sampled(cloud), unit=cloud.unit)
    return cloud, Deviation.of(reference, cloud)


def _check(
    context: typer.Context,
    paths: list[Path],
    output: list[Path],
    tolerance: float | None,
    share: float,
) -> None:
    if tolerance is not None and not 0 < tolerance < math.inf:
        _refuse(context, "tolerance", "a number that is positive and finite", tolerance)
    if not 0 <= share <= 1:
        _refuse(context, "share", "a number from 0 to 1", share)
    check_outputs(context, output, paths)
    for path in paths:
        if not has_faces(path):
            check_points(context, path)


def _in_one_unit(a: Thing, b: Thing) -> tuple[Thing, Thing]:
    """Return two things in the unit of the second; one without a unit has that of the other."""
    unit = file_unit(b.unit)
    if unit is None or a.unit in (None, b.unit):
        return a, b
    return in_unit(a, unit), in_unit(b, unit)


def _refuse(context: typer.Context, name: str, must: str, got: float) -> None:
    raise typer.BadParameter(f"must be {must}, got {got}", ctx=context, param_hint=f"'--{name}'")


def _measures(deviation: Deviation, *, signed: bool) -> dict[str, Any]:
    return {
        "points": len(deviation.signed),
        "rms": deviation.rms,
        "mean": deviation.mean,
        "signed": signed,
        "max": deviation.max,
        "percentiles": {f"{p:g}": d for p, d in deviation.percentiles(*_PERCENTS).items()},
    }


def _summary(document: dict[str, Any]) -> dict[str, str]:
    measures = document["deviation"]
    side = ", signed: positive on the side of the normals" if measures["signed"] else ""
    lines = {
        "from": f"{document['reference']} to {document['input']}",
        "unit": document["unit"] or "unknown",
        "points": f"{measures['points']:,}",
        "rms": f"{measures['rms']:.6g}",
        "mean": f"{measures['mean']:.6g}{side}",
    }
    lines |= {f"{p} %": f"within {d:.6g}" for p, d in measures["percentiles"].items()}
    lines["largest"] = f"{measures['max']:.6g}"
    if back := measures.get("back"):
        lines["back"] = (
            f"from {document['input']}: rms {back['rms']:.6g}, {back['max']:.6g} largest"
        )
    if "tolerance" in measures:
        verdict = "passed" if measures["passed"] else "failed"
        lines["tolerance"] = (
            f"{measures['tolerance']:g}: {100 * measures['within']:.3f} % within, {verdict}"
        )
    return lines | ({"written": ", ".join(document["files"])} if document["files"] else {})
