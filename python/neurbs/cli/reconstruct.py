"""`neurbs reconstruct`: points to surfaces, one file or many."""

from __future__ import annotations

import errno
import glob
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

import neurbs
from neurbs import Reconstruction, io
from neurbs.cli.command import FAILED, app, failure, failure_message, print_json, print_table
from neurbs.cli.options import (
    AsJson,
    Config,
    Quiet,
    Unit,
    blamed,
    check_output,
    check_points,
    options_of,
    values,
)
from neurbs.cli.progress import progress_bar

_WRITABLE = "; ".join(f"{part}: {' '.join(suffixes)}" for part, suffixes in io.WRITABLE.items())


@app.command()
@options_of(neurbs.reconstruct)
def reconstruct(
    context: typer.Context,
    points: Annotated[
        list[Path],
        typer.Argument(
            metavar="POINTS", help=f"Files of points: {' '.join(io.READABLE)}", readable=False
        ),
    ],
    output: Annotated[
        list[Path],
        typer.Option(
            "--output",
            "-o",
            metavar="OUT",
            help="File to write; give it again for another. With several files of points, the "
            f"folder for their results. {_WRITABLE}",
            readable=False,
        ),
    ],
    *,
    suffix: Annotated[
        list[str] | None,
        typer.Option(
            "--suffix",
            metavar="SUFFIX",
            help="What is written into a folder; give it again for another (default: .step)",
        ),
    ] = None,
    unit: Unit = None,
    config: Config = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    **options: Any,
) -> int:
    """Learn the points, make the surface, write the files.

    Examples: neurbs reconstruct scan.xyz -o scan.step -o scan.html --grid 30 30;
    neurbs reconstruct scans/*.ply -o surfaces/
    """
    files = [file for path in points for file in _expanded(path)]
    batch = len(files) > 1 or any(path.is_dir() for path in output)
    jobs = {file: _targets(context, file, output, suffix, batch=batch) for file in files}
    for file, targets in jobs.items():
        for target in targets:
            check_output(context, target, *files)
        if not batch:
            check_points(context, file)
    given = values(options)
    documents: list[dict[str, Any]] = []
    for file, targets in jobs.items():
        try:
            results = _one(context, file, targets, unit, given, quiet=quiet, batch=batch)
        except (neurbs.NeurbsError, OSError, MemoryError) as error:
            if not batch:
                raise
            documents.append({"input": str(file), "error": failure(error)})
            print(f"neurbs: error: {_named(file, failure_message(error))}", file=sys.stderr)
            continue
        for result, written in results:
            names = [str(target) for target in written]
            report = result.report.to_dict()
            documents.append({"input": str(file), "report": report, "files": names})
            if not quiet and not as_json:
                print_table(_summary(file if batch else "", result, names))
    failed = sum("error" in document for document in documents)
    if as_json:
        print_json(documents[0] if len(documents) == 1 and not batch else {"results": documents})
    if failed and not quiet:
        print(f"neurbs: {failed} of {len(files)} files failed", file=sys.stderr)
    return FAILED if failed else 0


def _expanded(path: Path) -> list[Path]:
    """Find what a pattern stands for, which not all shells do."""
    if path.exists() or not glob.has_magic(str(path)):
        return [path]
    return sorted(map(Path, glob.glob(str(path)))) or [path]


def _targets(
    context: typer.Context,
    file: Path,
    output: list[Path],
    suffixes: list[str] | None,
    *,
    batch: bool,
) -> list[Path]:
    if not batch:
        return output
    if suffixes is None:
        suffixes = [".step"]
    for folder in output:
        if folder.suffix and not folder.is_dir():
            raise typer.BadParameter(
                f"{folder}: must be a folder, because there are several files of points",
                ctx=context,
                param_hint="'--output'",
            )
        if not folder.exists():
            raise FileNotFoundError(
                errno.ENOENT, "there is no such folder, make it first", str(folder)
            )
    return [folder / f"{file.stem}.{s.lstrip('.')}" for folder in output for s in suffixes]


def _one(
    context: typer.Context,
    file: Path,
    targets: list[Path],
    unit: str | None,
    given: dict[str, Any],
    *,
    quiet: bool,
    batch: bool,
) -> list[tuple[Reconstruction, list[Path]]]:
    """Do the job for one file of points; of each piece come files of its own, numbered."""
    cloud = neurbs.read_point_cloud(file)
    with (
        blamed(context, given),
        progress_bar(not quiet, file.name if batch else "") as progress,
    ):
        found = neurbs.reconstruct(cloud, progress=progress, **given)
    if not isinstance(found, list):
        results = [(found, targets)]
    else:
        results = [
            (result, [target.with_stem(f"{target.stem}-{number}") for target in targets])
            for number, result in enumerate(found, 1)
        ]
    for result, written in results:
        for target in written:
            if target.suffix.lower() in io.WRITABLE["report"]:
                result.write_report(target, unit=unit or cloud.unit or "", source=file)
            else:
                neurbs.save(result, target, unit=unit)
    return results


def _named(file: Path, message: str) -> str:
    return message if message.startswith(str(file)) else f"{file}: {message}"


def _summary(name: Path | str, result: Reconstruction, files: list[str]) -> dict[str, str]:
    lines = {"file": str(name), **result.report.lines(), "written": ", ".join(files)}
    return {title: line for title, line in lines.items() if line}
