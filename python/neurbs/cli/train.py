"""`neurbs train`: the self-organizing map without a surface."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from neurbs import SelfOrganizingMap, io
from neurbs.cli.command import command, print_json, print_table
from neurbs.cli.completion import of_suffixes
from neurbs.cli.config import Config
from neurbs.cli.inputs import Columns, Nan, Points, check_points, read_points
from neurbs.cli.options import FILES, REACH, SEED, AsJson, Option, Quiet, Unit, options_of, values
from neurbs.cli.outputs import check_outputs
from neurbs.cli.progress import progress_bar
from neurbs.extras import check_installed
from neurbs.io.writers import check_place
from neurbs.plot import save_picture

_MAP, _PICTURES, _ANIMATIONS = ".npz", io.WRITABLE["picture"], (".gif", ".mp4", ".html")

_WRITABLE = (
    f"the map: {_MAP}; a picture: {' '.join(_PICTURES)}; an animation of the training: "
    f"{' '.join(_ANIMATIONS)}"
)


OPTIONS = (
    Option("rows", "Rows of the lattice", "N"),
    Option("cols", "Columns of the lattice", "N"),
    Option(
        "topology",
        "Closed directions of the lattice: none (sheet), rows (tube), rows and columns (torus)",
        choices=("sheet", "tube", "torus"),
    ),
    Option(
        "lattice",
        "Neighbors of an inner node: four (quad) or six (triangular)",
        choices=("quad", "triangular"),
    ),
    Option(
        "training",
        "Kohonen's batch map, or one point at a time as in the paper (online)",
        choices=("batch", "online"),
    ),
    Option(
        "init",
        "Start of the nodes: on the principal plane (pca), by distances along the surface "
        "(geodesic), the better of both (auto), or random around the centroid, the densest cluster "
        "or the origin (random)",
        choices=("pca", "geodesic", "auto", "centroid", "densest-cluster", "random"),
    ),
    Option(
        "neighborhood",
        "How far neighbors follow the winner: less with the distance (gaussian), or fully within "
        "the radius (bubble)",
        choices=("gaussian", "bubble"),
    ),
    Option(
        "kernel",
        "New position of a node in batch training: the weighted mean of the points around it, or "
        "the value at the node of a linear fit to them (linear)",
        choices=("mean", "linear"),
        default="linear on quad lattices with gaussian neighborhoods, else mean",
    ),
    Option(
        "presentation",
        "Points of online training: any at random, those not yet reached once the radius is zero, "
        "or all in each epoch in random order",
        choices=("random", "skip-reached", "shuffled"),
    ),
    Option(
        "gain",
        "Share of the way to the point that nodes move in online training: a number, or a schedule "
        "such as linear,0.5,0.1",
        "NUMBER",
        default="as in the paper",
    ),
    Option(
        "radius",
        "Reach of the neighborhood in cells: a number, or a schedule such as exponential,5,0.7",
        "NUMBER",
        default="from a quarter of the longer side down to 0.7, or as in the paper for a bubble",
    ),
    Option(
        "epochs", "Passes over the points", "N", default="20 in batch training, else by --max-steps"
    ),
    Option(
        "max_steps",
        "Most steps of training: epochs of batch training, presentations of online training",
        "N",
        default="500 presentations for each node",
    ),
    REACH,
    Option(
        "min_change",
        "Training ends when no node has moved farther than this in an epoch after the radius has "
        "reached its end, in the points' unit",
        "NUMBER",
        default="0.05 of the lattice's mean spacing",
    ),
    SEED,
)
"""Options of `neurbs.SelfOrganizingMap`."""


@command(
    "Train a self-organizing map and write it to files.",
    "neurbs train scan.xyz -o map.npz -o training.gif --rows 24 --cols 16",
)
@options_of(SelfOrganizingMap, OPTIONS, "Training")
def train(
    context: typer.Context,
    points: Points,
    output: Annotated[
        list[Path],
        typer.Option(
            "--output",
            "-o",
            metavar="OUT",
            help=f"File to write; {_WRITABLE}",
            autocompletion=of_suffixes(_MAP, *_PICTURES, *_ANIMATIONS),
            rich_help_panel=FILES,
            readable=False,
        ),
    ],
    *,
    paper: Annotated[
        bool,
        typer.Option(
            "--paper",
            metavar="",
            help="Use the paper's settings for all options that are not given",
        ),
    ] = False,
    columns: Columns = None,
    nan: Nan = None,
    unit: Unit = None,
    config: Config = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    **options: Any,
) -> None:
    """Train a `neurbs.SelfOrganizingMap` with the points of a file."""
    animations = [path for path in output if path.suffix.lower() in _ANIMATIONS]
    check_outputs(context, output, [points], check=lambda path: _check(context, path, animations))
    check_points(context, points)
    cloud = read_points(points, columns, nan, unit)
    given = values(options)
    som = SelfOrganizingMap.paper(cloud, **given) if paper else SelfOrganizingMap(**given)
    if animations:
        som.animate(cloud, animations[0])
    else:
        with progress_bar(not quiet) as progress:
            som.fit(cloud, progress=progress)
    for path in output:
        if path.suffix.lower() == _MAP:
            som.save(path)
        elif path.suffix.lower() in _PICTURES:
            save_picture(som.plot(cloud), path)
    files = [str(path) for path in output]
    measures: dict[str, Any] = {
        "points": len(cloud),
        "nodes": som.lattice_.nodes,
        "steps": som.n_iter_,
        "stopped_by": som.stopped_by_,
        "quantization_error": som.quantization_error(cloud),
        "topographic_error": som.topographic_error(cloud),
        "fold_overs": som.fold_overs(),
    }
    if as_json:
        print_json({"input": str(points), "map": measures, "files": files})
    elif not quiet:
        rows = {name.replace("_", " "): _text(value) for name, value in measures.items()}
        print_table(rows | {"written": ", ".join(files)})


def _check(context: typer.Context, path: Path, animations: list[Path]) -> None:
    suffix = path.suffix.lower()
    if suffix not in (_MAP, *_PICTURES, *_ANIMATIONS):
        got = f"the suffix {path.suffix!r}" if path.suffix else "no suffix"
        message = f"{path}: must have the suffix of a result ({_WRITABLE}), got {got}"
        raise typer.BadParameter(message, ctx=context, param_hint="'--output'")
    if len(animations) > 1:
        message = f"there must be at most one animation, got {len(animations)}"
        raise typer.BadParameter(message, ctx=context, param_hint="'--output'")
    check_place(path)
    if suffix != _MAP:
        check_installed(path, "matplotlib")


def _text(value: Any) -> str:
    match value:
        case int():
            return f"{value:,}"
        case float():
            return f"{value:.4g}"
    return str(value)
