"""The job of `neurbs reconstruct --distributed`: all files together, on the workers of Dask."""

from __future__ import annotations

import logging
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import typer

from neurbs import distributed
from neurbs.cli.command import NOT_MET, print_json, print_table, repeated
from neurbs.cli.inputs import check_points
from neurbs.cli.outputs import check_outputs
from neurbs.cli.progress import progress_bar
from neurbs.cli.reconstruct_files import document, expanded, is_folder, summary, write
from neurbs.extras import require
from neurbs.io.units import check_unit


def run(
    context: typer.Context,
    points: list[Path],
    output: list[str],
    given: dict[str, Any],
    *,
    scheduler: str | None,
    suffix: list[str] | None,
    reading: dict[str, Any],
    strict: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Reconstruct one surface from all files and write it.

    Returns
    -------
    int
        The exit code.
    """
    files = [file for path in points for file in expanded(path)]
    if suffix is not None or any(map(is_folder, output)):
        raise typer.BadParameter(
            f"{', '.join(output)}: must be files, because all points give one surface",
            ctx=context,
            param_hint="'--output'",
        )
    targets = [Path(place) for place in output]
    check_unit(reading.get("unit"))
    for file in files:
        check_points(context, file)
    check_outputs(context, targets, files)
    with _workers(scheduler), progress_bar(not quiet) as progress:
        result = distributed.reconstruct(files, progress=progress, **given, **reading)
    write(result.sample, targets, files[0], repeated(context))
    names = [str(target) for target in targets]
    report = result.report
    if as_json:
        print_json(document([str(file) for file in files], result.unit, report, names))
    elif not quiet:
        print_table(summary("", result.unit, report, names))
    met = report.converged and report.valid
    return NOT_MET if strict and not met else 0


@contextmanager
def _workers(scheduler: str | None) -> Iterator[None]:
    """Connect to a scheduler, or start workers on this machine, until the job ends."""
    dask = require("distributed", "workers")
    if scheduler is not None:
        with dask.Client(scheduler, timeout=10):
            yield
        return
    with _ignored_by_workers():
        # Errors of tasks come back as exceptions; the library would print them as well.
        cluster = dask.LocalCluster(
            threads_per_worker=1, dashboard_address=":0", silence_logs=logging.CRITICAL
        )
    with cluster, dask.Client(cluster):
        yield


@contextmanager
def _ignored_by_workers() -> Iterator[None]:
    """Let processes that start here ignore Ctrl-C.

    A terminal sends it to all processes, but only this one has to answer.
    """
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
