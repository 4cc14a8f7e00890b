"""`neurbs reconstruct` and `neurbs reconstruct-paper`: points to surfaces, one file or many."""

from __future__ import annotations

from typing import Any

import typer

import neurbs
from neurbs.cli import batch
from neurbs.cli.batch import Files, Output, Strict, Suffix
from neurbs.cli.command import app
from neurbs.cli.options import AsJson, Config, Quiet, Unit, options_of, values
from neurbs.cli.points import Columns, Nan


@app.command()
@options_of(neurbs.reconstruct)
def reconstruct(
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
    """Learn the points, make the surface, write the files.

    Examples: neurbs reconstruct scan.xyz -o scan.step -o scan.html --grid 30 30;
    neurbs reconstruct scans/*.ply -o surfaces/
    """
    return batch.run(
        context,
        neurbs.reconstruct,
        points,
        output,
        values(options),
        suffix=suffix,
        columns=columns,
        nan=nan,
        unit=unit,
        strict=strict,
        as_json=as_json,
        quiet=quiet,
    )


@app.command()
@options_of(neurbs.reconstruct_paper)
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
    """Reconstruct by the paper's method: the trained lattice makes the surface.

    Example: neurbs reconstruct-paper scan.xyz -o scan.step --grid 20 20
    """
    return batch.run(
        context,
        neurbs.reconstruct_paper,
        points,
        output,
        values(options),
        suffix=suffix,
        columns=columns,
        nan=nan,
        unit=unit,
        strict=strict,
        as_json=as_json,
        quiet=quiet,
    )
