"""`neurbs compare`: deviations of points from a surface, with an exit code for a tolerance."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import typer

import neurbs
from neurbs import PointCloud
from neurbs.cli.command import OUTSIDE, command, print_json, print_table
from neurbs.cli.config import Config
from neurbs.cli.inputs import Columns, Nan, Points, Surface, check_points, read_points
from neurbs.cli.options import AsJson, Quiet
from neurbs.cli.outputs import check_outputs
from neurbs.deviation import Deviation

_PERCENTS = (50.0, 90.0, 95.0, 99.0)
"""Percentiles that are reported."""


@command(
    "Measure the deviations of points from a surface or shell; exit code 3 if too many are out.",
    "neurbs compare part.step scan.ply --tolerance 0.05 -o deviations.ply",
)
def compare(
    context: typer.Context,
    surface: Surface,
    points: Points,
    *,
    tolerance: Annotated[
        float | None,
        typer.Option(
            metavar="LENGTH",
            help="Largest distance of a point from the surface, in the points' unit",
        ),
    ] = None,
    share: Annotated[
        float,
        typer.Option(
            metavar="SHARE",
            help="Share of the points, from 0 to 1, that must be within --tolerance",
        ),
    ] = 1.0,
    output: Annotated[
        list[Path] | None,
        typer.Option(
            "--output",
            "-o",
            metavar="OUT",
            help="File to write: the points with their distances (.ply with colors, .csv); "
            "give it again for another",
            readable=False,
        ),
    ] = None,
    columns: Columns = None,
    nan: Nan = None,
    config: Config = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> int:
    """Print the deviations of points from a surface or shell and return the exit code."""
    if tolerance is not None and not 0 < tolerance < math.inf:
        _refuse(context, "tolerance", "a number that is positive and finite", tolerance)
    if not 0 <= share <= 1:
        _refuse(context, "share", "a number from 0 to 1", share)
    check_outputs(context, output or [], [points, surface])
    check_points(context, points)
    loaded = neurbs.load_shell(surface)
    cloud = read_points(points, columns, nan)
    deviation = Deviation.of(loaded, cloud)
    for path in output or []:
        neurbs.save(PointCloud(cloud, distances=deviation.distances), path)
    measures: dict[str, Any] = {
        "points": len(cloud),
        "rms": deviation.rms,
        "mean": deviation.mean,
        "max": deviation.max,
        "percentiles": {f"{p:g}": d for p, d in deviation.percentiles(*_PERCENTS).items()},
    }
    passed = True
    if tolerance is not None:
        within = deviation.within(tolerance)
        passed = within >= share
        measures |= {"tolerance": tolerance, "within": within, "passed": passed}
    files = [str(path) for path in output or []]
    if as_json:
        print_json(
            {"surface": str(surface), "input": str(points), "deviation": measures, "files": files}
        )
    elif not quiet:
        print_table(_summary(measures, files))
    return 0 if passed else OUTSIDE


def _refuse(context: typer.Context, name: str, must: str, got: float) -> None:
    raise typer.BadParameter(f"must be {must}, got {got}", ctx=context, param_hint=f"'--{name}'")


def _summary(measures: dict[str, Any], files: list[str]) -> dict[str, str]:
    lines = {
        "points": f"{measures['points']:,}",
        "rms": f"{measures['rms']:.6g}",
        "mean": f"{measures['mean']:.6g}, signed: positive on the side of the normals",
    }
    lines |= {f"{p} %": f"within {d:.6g}" for p, d in measures["percentiles"].items()}
    lines["largest"] = f"{measures['max']:.6g}"
    if "tolerance" in measures:
        verdict = "passed" if measures["passed"] else "failed"
        lines["tolerance"] = (
            f"{measures['tolerance']:g}: {100 * measures['within']:.3f} % within, {verdict}"
        )
    return lines | ({"written": ", ".join(files)} if files else {})
