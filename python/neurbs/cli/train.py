"""`neurbs train`: the self-organizing map alone."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from neurbs import SelfOrganizingMap
from neurbs.cli.command import app, print_json, print_table
from neurbs.cli.options import (
    AsJson,
    Config,
    Quiet,
    blamed,
    options_of,
    values,
)
from neurbs.cli.outputs import check_outputs
from neurbs.cli.points import Columns, Nan, Points, check_points, read_points
from neurbs.cli.progress import progress_bar
from neurbs.io import check_target
from neurbs.plot import save_picture

_MAP, _PICTURE, _FILMS = ".npz", ".png", (".gif", ".mp4", ".html")


@app.command()
@options_of(SelfOrganizingMap)
def train(
    context: typer.Context,
    points: Points,
    output: Annotated[
        list[Path],
        typer.Option(
            "--output",
            "-o",
            metavar="OUT",
            help="File to write; give it again for another. The map: .npz; a picture: .png; "
            "a film of the training: .gif .mp4 .html",
            readable=False,
        ),
    ],
    *,
    paper: Annotated[
        bool,
        typer.Option(
            "--paper", metavar="", help="All of the paper's settings, but for those given here"
        ),
    ] = False,
    columns: Columns = None,
    nan: Nan = None,
    config: Config = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    **options: Any,
) -> None:
    """Train the self-organizing map alone, and write it.

    Example: neurbs train scan.xyz -o map.npz -o training.gif --rows 24 --cols 16
    """
    films = [path for path in output if path.suffix.lower() in _FILMS]
    check_outputs(context, output, [points], check=lambda path: _check(context, path, films))
    check_points(context, points)
    cloud = read_points(context, points, columns, nan)
    given = values(options)
    with blamed(context, given):
        som = SelfOrganizingMap.paper(cloud, **given) if paper else SelfOrganizingMap(**given)
        if films:
            som.animate(cloud, films[0])
        else:
            with progress_bar(not quiet) as progress:
                som.fit(cloud, progress=progress)
    for path in output:
        if path.suffix.lower() == _MAP:
            som.save(path)
        elif path.suffix.lower() == _PICTURE:
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


def _check(context: typer.Context, path: Path, films: list[Path]) -> None:
    known = (_MAP, _PICTURE, *_FILMS)
    if path.suffix.lower() not in known:
        got = f"the suffix {path.suffix!r}" if path.suffix else "no suffix"
        message = f"{path}: a map is written as {' '.join(known)}, got {got}"
        raise typer.BadParameter(message, ctx=context, param_hint="'--output'")
    if len(films) > 1:
        message = f"there must be at most one film, got {len(films)}"
        raise typer.BadParameter(message, ctx=context, param_hint="'--output'")
    # Its folder and its rights are those of any picture.
    check_target(path.with_suffix(_PICTURE))


def _text(value: Any) -> str:
    match value:
        case int():
            return f"{value:,}"
        case float():
            return f"{value:.4g}"
    return str(value)
