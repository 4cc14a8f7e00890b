"""The job of the `reconstruct` commands: files of points to files of surfaces, one or many."""

from __future__ import annotations

import errno
import glob
import itertools
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, TypeAlias

import typer

import neurbs
from neurbs import Reconstruction, Report, io
from neurbs.cli.command import FAILED, NOT_MET, print_json, print_table, repeated
from neurbs.cli.completion import of_suffixes, of_words
from neurbs.cli.inputs import check_points, read_point_cloud
from neurbs.cli.messages import failure, option_argument, with_options
from neurbs.cli.options import FILES
from neurbs.cli.outputs import check_outputs
from neurbs.cli.progress import progress_bar
from neurbs.errors import printable
from neurbs.io.units import check_unit

_WRITABLE = "; ".join(f"{part}: {' '.join(suffixes)}" for part, suffixes in io.WRITABLE.items())

_SUFFIXES = tuple(dict.fromkeys(itertools.chain.from_iterable(io.WRITABLE.values())))
"""Suffixes of all files that a result can be written to."""

Files: TypeAlias = Annotated[
    list[Path],
    typer.Argument(
        metavar="POINTS", help=f"Files of points: {' '.join(io.READABLE)}", readable=False
    ),
]
Output: TypeAlias = Annotated[
    list[str],
    typer.Option(
        "--output",
        "-o",
        metavar="OUT",
        help="File to write. With several files of points, or a / at its end: the folder for the "
        f"results. {_WRITABLE}",
        autocompletion=of_suffixes(*_SUFFIXES),
        rich_help_panel=FILES,
    ),
]
Suffix: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--suffix",
        metavar="SUFFIX",
        help="Suffix of the files in a folder (default: .step)",
        autocompletion=of_words(*_SUFFIXES, *(suffix[1:] for suffix in _SUFFIXES)),
        rich_help_panel=FILES,
    ),
]
Strict: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--strict",
        metavar="",
        help="Exit with code 4 if a result misses the tolerance or is not valid; its files are "
        "still written",
    ),
]


def run(
    context: typer.Context,
    function: Callable[..., Reconstruction | list[Reconstruction]],
    points: list[Path],
    output: list[str],
    given: dict[str, Any],
    *,
    suffix: list[str] | None,
    reading: dict[str, Any],
    strict: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Call a function on each file of points and write its results.

    Returns
    -------
    int
        The exit code.
    """
    files = [file for path in points for file in expanded(path)]
    batch = len(files) > 1 or any(map(is_folder, output))
    check_unit(reading.get("unit"))
    jobs = _jobs(context, files, output, suffix, batch=batch)
    written = [target for targets in jobs.values() for target in targets]
    sources = [file for file, targets in jobs.items() for _ in targets] if batch else []
    numbered = given.get("component") == "each"
    check_outputs(context, written, files, sources=sources, numbered=numbered)
    documents: list[dict[str, Any]] = []
    met = True
    for file, targets in jobs.items():
        try:
            cloud = read_point_cloud(file, reading)
            with progress_bar(not quiet, printable(file.name) if batch else "") as progress:
                found = function(cloud, progress=progress, **given)
            results = _numbered(found, targets)
            for result, written in results:
                write(result, written, file, repeated(context))
        except (neurbs.NeurbsError, OSError, MemoryError) as error:
            wrong_option = isinstance(error, neurbs.NeurbsError) and option_argument(context, error)
            if wrong_option or not batch:
                raise
            entry = failure(error)
            entry["message"] = with_options(context, entry["message"])
            documents.append({"input": str(file), "error": entry})
            print(f"neurbs: error: {_with_name(file, entry['message'])}", file=sys.stderr)
            continue
        for result, written in results:
            names = [str(target) for target in written]
            report = result.report
            met = met and report.converged and report.valid
            documents.append(document(str(file), result.unit, report, names))
            if not quiet and not as_json:
                print_table(summary(file if batch else "", result.unit, result.report, names))
    failed = sum("error" in document for document in documents)
    if as_json:
        print_json(documents[0] if len(documents) == 1 and not batch else {"results": documents})
    if failed and not quiet:
        print(f"neurbs: {failed} of {len(files)} files failed", file=sys.stderr)
    if failed:
        return FAILED
    return NOT_MET if strict and not met else 0


def _jobs(
    context: typer.Context,
    files: list[Path],
    output: list[str],
    suffix: list[str] | None,
    *,
    batch: bool,
) -> dict[Path, list[Path]]:
    """Return the files to write for each file of points, after checks of both."""
    places = [Path(place) for place in output]
    jobs = {file: _targets(context, file, places, suffix, batch=batch) for file in files}
    if not batch:
        check_points(context, files[0])
    return jobs


def expanded(path: Path) -> list[Path]:
    """Return the files that match a pattern; not all shells expand them."""
    if path.exists() or not glob.has_magic(str(path)):
        return [path]
    return sorted(map(Path, glob.glob(str(path)))) or [path]


def is_folder(place: str) -> bool:
    """Whether a place for results is a folder."""
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
    return [folder / f"{io.stem_of(file)}.{s.lstrip('.')}" for folder in output for s in suffixes]


def _numbered(
    found: Reconstruction | list[Reconstruction], targets: list[Path]
) -> list[tuple[Reconstruction, list[Path]]]:
    """Return each result with its files, which are numbered for a list of results."""
    if not isinstance(found, list):
        return [(found, targets)]
    return [
        (result, [target.with_stem(f"{target.stem}-{number}") for target in targets])
        for number, result in enumerate(found, 1)
    ]


def write(result: Reconstruction, targets: list[Path], source: Path, command: str) -> None:
    """Write the files of a result; `command` is for the report."""
    for target in targets:
        if target.suffix.lower() in io.WRITABLE["report"]:
            result.write_report(target, source=source, command=command)
        else:
            neurbs.save(result, target)


def _with_name(file: Path, message: str) -> str:
    name = printable(str(file))
    return message if message.startswith(name) else f"{name}: {message}"


def document(
    points: str | list[str], unit: str | None, report: Report, files: list[str]
) -> dict[str, Any]:
    """Return a result for `--json`: its files of points, its figures and the files written."""
    return {"input": points, "unit": unit, "report": report.to_dict(), "files": files}


def summary(name: Path | str, unit: str | None, report: Report, files: list[str]) -> dict[str, str]:
    """Return the lines of a result: its file of points, its figures and the files written."""
    written = printable(", ".join(files))
    lines = {
        "file": printable(str(name)),
        "unit": printable(unit or ""),
        **report.lines(),
        "written": written,
    }
    return {title: line for title, line in lines.items() if line}
