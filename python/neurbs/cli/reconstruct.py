"""`neurbs reconstruct` and `neurbs reconstruct-paper`: points to surfaces, one file or many."""

from __future__ import annotations

import dataclasses
from typing import Annotated, Any, TypeAlias

import typer

import neurbs
from neurbs.cli import reconstruct_files
from neurbs.cli.command import command
from neurbs.cli.config import Config
from neurbs.cli.inputs import Bounds, Cell, Columns, LasClasses, Nan, reading_options
from neurbs.cli.options import REACH, SEED, AsJson, Option, Quiet, Unit, options_of, values
from neurbs.cli.reconstruct_files import Files, Output, Strict, Suffix

RECONSTRUCT_OPTIONS = (
    Option(
        "tolerance",
        "Largest distance from a point to the surface, in the points' unit; the net grows until "
        "all points are within it",
        "NUMBER",
        default="the net grows until it would follow noise",
    ),
    Option(
        "kind",
        "Kind of surface: open (sheet, or height for z = f(x, y)), closed in u (tube) or in both "
        "directions (torus); auto chooses the best candidate",
        choices=("auto", "sheet", "height", "tube", "torus"),
    ),
    Option(
        "component",
        "Number of the component to fit, 0 being the largest; each fits every component and "
        "numbers the files",
        "N|each",
        default="all points together",
    ),
    Option(
        "axis_scale",
        "Divisors of the coordinates for the fit, where axes have different units",
        "X Y Z",
        default="1 1 1, unless the extents show mixed units",
        group="Fit",
    ),
    Option("grid", "Rows and columns of the control net", "N N", default="chosen by the fit"),
    Option(
        "degree",
        "Degree of the surface in both directions; lower if the net has too few rows or columns",
        "N",
    ),
    Option(
        "init",
        "Start of the map: on the best candidate (auto), on the best by distances along the "
        "surface (geodesic) or on the best over a plane (pca)",
        choices=("auto", "geodesic", "pca"),
        group="Fit",
    ),
    Option("clean", "Merge duplicates and leave out gross outliers first", "", group="Fit"),
    Option(
        "robust",
        "Lower the weight of points that are outliers of the fitted surface",
        "",
        group="Fit",
    ),
    Option(
        "rational",
        "Optimize the weights of the control points at the end and keep them if the fit improves",
        "",
    ),
    Option(
        "fairness",
        "Weight of the fairness energy; 1 makes it as important as all points together",
        "NUMBER",
        default="by cross-validation",
        group="Fit",
    ),
    Option(
        "border",
        "Extension of an open surface beyond the points, in mean spacings of the points",
        "NUMBER",
        default="0.5",
    ),
    Option(
        "trim",
        "Where faces end: at the points (yes), at the points but over holes (outer), at the sides "
        "of the surface (no), or at the points where that is certain (auto)",
        choices=("auto", "yes", "outer", "no"),
    ),
    Option("max_control_points", "Most control points of a net that grows", "N"),
    Option(
        "aspect",
        "Ratio of rows to columns: by the lengths of the surface in both directions (data), or as "
        "--grid gives it (fixed)",
        choices=("data", "fixed"),
    ),
    dataclasses.replace(SEED, group="Fit"),
)
"""Options of `neurbs.reconstruct`."""

PAPER_OPTIONS = (
    Option(
        "grid",
        "Rows and columns of the lattice",
        "N N",
        default="4 nodes for each point, at most 2500",
    ),
    Option(
        "degree",
        "Degree of the surface in both directions; lower if the lattice has too few rows or "
        "columns",
        "N",
    ),
    Option(
        "surface",
        "Surface from the lattice: a B-spline surface with the lattice as control net, or through "
        "its nodes (interpolate), or one Bézier surface with it as control net",
        choices=("control-net", "interpolate", "bezier"),
    ),
    Option("max_steps", "Most steps of training", "N", default="500 for each node"),
    REACH,
    Option(
        "min_change",
        "Training ends when no node has moved farther than this in an epoch, in the points' unit",
        "NUMBER",
        default="0.05 of the lattice's mean spacing",
    ),
    SEED,
)
"""Options of `neurbs.reconstruct_paper`."""


Distributed: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--distributed",
        metavar="",
        help="Fit one surface to the points of all files on the workers of Dask, by default one "
        "for each processor of this machine",
    ),
]
Scheduler: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        metavar="ADDRESS",
        help="Address of the scheduler of Dask for --distributed, such as tcp://10.0.0.1:8786",
    ),
]


@command(
    "Fit a surface to points and write it to files.",
    "neurbs reconstruct scan.xyz -o scan.step -o scan.html --grid 30",
    "neurbs reconstruct scans/*.ply -o surfaces/",
    "neurbs reconstruct tiles/*.laz --distributed -o terrain.step",
)
@options_of(neurbs.reconstruct, RECONSTRUCT_OPTIONS, "Surface")
def reconstruct(
    context: typer.Context,
    points: Files,
    output: Output,
    *,
    suffix: Suffix = None,
    columns: Columns = None,
    nan: Nan = None,
    unit: Unit = None,
    bounds: Bounds = None,
    cell: Cell = None,
    las_classes: LasClasses = None,
    strict: Strict = False,
    distributed: Distributed = False,
    scheduler: Scheduler = None,
    config: Config = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    **options: Any,
) -> int:
    """Run `neurbs.reconstruct` on files and return the exit code."""
    reading = reading_options(columns, nan, unit, bounds=bounds, cell=cell, las_classes=las_classes)
    if distributed:
        from neurbs.cli import reconstruct_distributed

        return reconstruct_distributed.run(
            context,
            points,
            output,
            values(options),
            scheduler=scheduler,
            suffix=suffix,
            reading=reading,
            strict=strict,
            as_json=as_json,
            quiet=quiet,
        )
    if scheduler is not None:
        raise typer.BadParameter(
            "must come with --distributed", ctx=context, param_hint="'--scheduler'"
        )
    return reconstruct_files.run(
        context,
        neurbs.reconstruct,
        points,
        output,
        values(options),
        suffix=suffix,
        reading=reading,
        strict=strict,
        as_json=as_json,
        quiet=quiet,
    )


@command(
    "Fit a surface by the paper's method. The trained lattice becomes the surface.",
    "neurbs reconstruct-paper scan.xyz -o scan.step --grid 20",
)
@options_of(neurbs.reconstruct_paper, PAPER_OPTIONS, "Fit")
def reconstruct_paper(
    context: typer.Context,
    points: Files,
    output: Output,
    *,
    suffix: Suffix = None,
    columns: Columns = None,
    nan: Nan = None,
    unit: Unit = None,
    strict: Strict = False,
    config: Config = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    **options: Any,
) -> int:
    """Run `neurbs.reconstruct_paper` on files and return the exit code."""
    return reconstruct_files.run(
        context,
        neurbs.reconstruct_paper,
        points,
        output,
        values(options),
        suffix=suffix,
        reading=reading_options(columns, nan, unit),
        strict=strict,
        as_json=as_json,
        quiet=quiet,
    )
