"""`neurbs reconstruct`: points to surfaces, one file or many."""

from __future__ import annotations

import errno
import glob
import os
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

import neurbs
from neurbs import Reconstruction, io
from neurbs._core import LENGTH_UNITS
from neurbs.cli.command import FAILED, app, failure, failure_message, print_json, print_table
from neurbs.cli.options import (
    AsJson,
    Config,
    Quiet,
    Unit,
    blamed,
    check_output,
    options_of,
    values,
)
from neurbs.cli.points import Columns, Nan, check_points, read_point_cloud
from neurbs.cli.progress import progress_bar
from neurbs.io.units import check_unit

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
        list[str],
        typer.Option(
            "--output",
            "-o",
            metavar="OUT",
            help="File to write; give it again for another. With several files of points, or a / "
            f"at its end, the folder for their results. {_WRITABLE}",
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
    columns: Columns = None,
    nan: Nan = None,
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
    batch = len(files) > 1 or any(map(_is_folder, output))
    places = [Path(place) for place in output]
    jobs = {file: _targets(context, file, places, suffix, batch=batch) for file in files}
    for file, targets in jobs.items():
        for target in targets:
            check_output(context, target, *files)
            with blamed(context, {"unit": unit}):
                # The legend of a report may have any.
                check_unit(None if _is_report(target) else unit)
        if not batch:
            check_points(context, file)
    given = values(options)
    documents: list[dict[str, Any]] = []
    for file, targets in jobs.items():
        try:
            cloud = read_point_cloud(context, file, columns, nan)
            name = file.name if batch else ""
            with blamed(context, given), progress_bar(not quiet, name) as progress:
                found = neurbs.reconstruct(cloud, progress=progress, **given)
            results = _numbered(found, targets)
            for result, written in results:
                _write(result, written, unit, cloud.unit, file)
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


def _is_folder(place: str) -> bool:
    return place.endswith(("/", os.sep)) or Path(place).is_dir()


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


def _numbered(
    found: Reconstruction | list[Reconstruction], targets: list[Path]
) -> list[tuple[Reconstruction, list[Path]]]:
    """Give each result its files: of each piece come files of its own, numbered."""
    if not isinstance(found, list):
        return [(found, targets)]
    return [
        (result, [target.with_stem(f"{target.stem}-{number}") for target in targets])
        for number, result in enumerate(found, 1)
    ]


def _write(
    result: Reconstruction,
    targets: list[Path],
    unit: str | None,
    unit_of_points: str | None,
    source: Path,
) -> None:
    """Write the files, in the unit that was given, or else in that of the points if it is known."""
    for target in targets:
        if _is_report(target):
            result.write_report(target, unit=unit or unit_of_points or "", source=source)
        else:
            known = unit_of_points if unit_of_points in LENGTH_UNITS else None
            neurbs.save(result, target, unit=unit or known)


def _is_report(target: Path) -> bool:
    return target.suffix.lower() in io.WRITABLE["report"]


def _named(file: Path, message: str) -> str:
    return message if message.startswith(str(file)) else f"{file}: {message}"


def _summary(name: Path | str, result: Reconstruction, files: list[str]) -> dict[str, str]:
    lines = {"file": str(name), **result.report.lines(), "written": ", ".join(files)}
    return {title: line for title, line in lines.items() if line}
