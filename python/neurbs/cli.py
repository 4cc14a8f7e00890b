"""The command line: `neurbs reconstruct POINTS -o OUT`.

Exit codes: 0 done; 1 the job failed; 2 the command line is wrong; 130 interrupted. A failure is
one message on stderr, never a traceback.
"""

from __future__ import annotations

import inspect
import json
import os
import signal
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from io import TextIOWrapper
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer

import neurbs
from neurbs import Progress, Report, io

_FAILED, _WRONG_USAGE, _INTERRUPTED, _TERMINATED = 1, 2, 130, 143

app = typer.Typer(
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
)


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line and leave Python with its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        What follows the command's name; by default what Python was called with.
    """
    for stream in (sys.stdout, sys.stderr):
        # The name of a file may hold what the terminal's encoding does not.
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    # Leaves what is half done as Ctrl-C does: cleaned up.
    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(_TERMINATED))
    code = _run(sys.argv[1:] if arguments is None else list(arguments))
    try:
        print(end="", flush=True)
    except OSError:
        # This has been reported; but Python would try again on leaving, and complain once more.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    sys.exit(code)


def _run(arguments: list[str]) -> int:
    """Run a command, and turn what it raises into a message and an exit code."""
    code, kind, message = _INTERRUPTED, "KeyboardInterrupt", "interrupted"
    try:
        with _warnings_as_messages():
            command = typer.main.get_command(app)
            returned = command.main(arguments, prog_name="neurbs", standalone_mode=False)
        # This is also Typer's own answer to Ctrl-C.
        if returned != _INTERRUPTED:
            return int(returned or 0)
    except KeyboardInterrupt:
        pass
    except typer.TyperException as error:
        code, kind, message = _WRONG_USAGE, "UsageError", _usage_message(error)
    except Exception as error:
        code, kind, message = _FAILED, type(error).__name__, _failure_message(error)
    print(f"neurbs: error: {message}" if code != _INTERRUPTED else message, file=sys.stderr)
    # Looked for by hand: a wrong command line has no parsed options.
    if "--json" in arguments:
        with suppress(OSError):
            print(json.dumps({"error": {"type": kind, "message": message}}), flush=True)
    return code


def _usage_message(error: typer.TyperException) -> str:
    message = " ".join(error.format_message().split()).rstrip(".")
    context: typer.Context | None = getattr(error, "ctx", None)
    command = context.command_path if context else "neurbs"
    return f"{message} (see '{command} --help')"


def _failure_message(error: Exception) -> str:
    match error:
        case OSError(strerror=str(reason), filename=str(name)):
            return f"{name}: {reason}"
        case OSError(strerror=str(reason)):
            return reason
        case neurbs.NeurbsError() | OSError():
            return str(error)
        case MemoryError():
            return str(error) or "there is not enough memory for this job"
        case Warning():
            return f"a warning, which Python was told to take for an error: {error}"
    return f"{type(error).__name__}: {error} (this is a fault of neurbs, please report it)"


@contextmanager
def _warnings_as_messages() -> Iterator[None]:
    def show(message: Warning | str, *_: object, **__: object) -> None:
        print(f"neurbs: warning: {message}", file=sys.stderr)

    with warnings.catch_warnings():
        warnings.showwarning = show
        yield


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"neurbs {neurbs.__version__}")
        raise typer.Exit


@app.callback()
def _neurbs(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version"),
    ] = False,
) -> None:
    """Turn scattered 3D points into a standard NURBS surface."""


_DEFAULTS = {
    name: parameter.default
    for name, parameter in inspect.signature(neurbs.reconstruct).parameters.items()
}


def _option(name: str, help: str, metavar: str) -> Any:
    """Make an option of a parameter of `neurbs.reconstruct`, whose default stays there."""
    default = _DEFAULTS[name]
    if default is not None:
        help += f" (default: {default})"
    return typer.Option(_flag(name), metavar=metavar, help=help)


def _flag(name: str) -> str:
    return f"--{name.replace('_', '-')}"


@app.command()
def reconstruct(
    context: typer.Context,
    points: Annotated[
        Path,
        typer.Argument(
            metavar="POINTS", help=f"File of points: {' '.join(io.READABLE)}", readable=False
        ),
    ],
    output: Annotated[
        list[Path],
        typer.Option(
            "--output",
            "-o",
            metavar="OUT",
            help="File to write; give it again for another. "
            + "; ".join(f"{part}: {' '.join(suffixes)}" for part, suffixes in io.WRITABLE.items()),
            readable=False,
        ),
    ],
    tolerance: Annotated[
        str | None,
        _option("tolerance", "How near to the surface all points shall lie", "LENGTH"),
    ] = None,
    method: Annotated[
        str | None, _option("method", "How the surface comes from the points", "NAME")
    ] = None,
    surface: Annotated[
        str | None, _option("surface", "What the lattice is to the surface", "NAME")
    ] = None,
    grid: Annotated[
        tuple[str, str] | None,
        _option("grid", "Size of the control net", "ROWS COLS"),
    ] = None,
    degree: Annotated[str | None, _option("degree", "Degree of the surface", "N")] = None,
    topology: Annotated[
        str | None, _option("topology", "Closed directions: sheet, tube or torus", "NAME")
    ] = None,
    fairness: Annotated[
        str | None, _option("fairness", "Weight of the smoothness against the points", "X")
    ] = None,
    border: Annotated[
        str | None,
        _option("border", "How far to go beyond the points, in their mean spacings", "X"),
    ] = None,
    max_control_points: Annotated[
        str | None, _option("max_control_points", "Control points at most", "N")
    ] = None,
    aspect: Annotated[
        str | None, _option("aspect", "How the grid is split: data or fixed", "NAME")
    ] = None,
    seed: Annotated[str | None, _option("seed", "Seed of everything random", "N")] = None,
    max_steps: Annotated[str | None, _option("max_steps", "Steps of training at most", "N")] = None,
    reach: Annotated[
        str | None,
        _option("reach", "How near to a node a point is on the lattice, in its unit", "LENGTH"),
    ] = None,
    min_change: Annotated[
        str | None,
        _option(
            "min_change", "Training ends when no node moves farther, in the points' unit", "LENGTH"
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document")] = False,
    quiet: Annotated[
        bool, typer.Option("--quiet", "-q", help="Print only warnings and errors")
    ] = False,
) -> None:
    """Learn the points, make the surface, write the files.

    Example: neurbs reconstruct scan.xyz -o scan.step -o scan.png --grid 30 30
    """
    for path in output:
        _check_output(context, path, points)
    _check_points(context, points)
    cloud = neurbs.read_points(points)
    options: dict[str, Any] = {
        "tolerance": tolerance,
        "method": method,
        "surface": surface,
        "grid": grid and tuple(map(_value, grid)),
        "degree": degree,
        "topology": topology,
        "fairness": fairness,
        "border": border,
        "max_control_points": max_control_points,
        "aspect": aspect,
        "seed": seed,
        "max_steps": max_steps,
        "reach": reach,
        "min_change": min_change,
    }
    given = {name: _value(value) for name, value in options.items() if value is not None}
    try:
        with _progress_bar(shown=not quiet) as progress:
            result = neurbs.reconstruct(cloud, progress=progress, **given)
    except neurbs.NeurbsError as error:
        raise _blame_option(context, given, error) from None
    for path in output:
        result.save(path)
    files = [str(path) for path in output]
    if as_json:
        document = {"input": str(points), "report": result.report.to_dict(), "files": files}
        print(json.dumps(document), flush=True)
    elif not quiet:
        print(_summary(result.report, files), flush=True)


def _value(text: Any) -> Any:
    """Make a number of what looks like one; whether it fits, `neurbs.reconstruct` will say."""
    for kind in (int, float):
        with suppress(TypeError, ValueError):
            return kind(text)
    return text


def _check_output(context: typer.Context, path: Path, points: Path) -> None:
    wrong = partial(typer.BadParameter, ctx=context, param_hint="'--output'")
    try:
        io.check_target(path)
    except neurbs.NeurbsError as error:
        raise wrong(str(error)) from None
    if path.exists() and points.exists() and path.samefile(points):
        raise wrong(f"{path}: the points must not be overwritten, give another file")


def _check_points(context: typer.Context, path: Path) -> None:
    # That there is no such file matters more than its suffix; reading it will say so.
    if path.is_file():
        try:
            io.check_source(path)
        except neurbs.NeurbsError as error:
            raise typer.BadParameter(str(error), ctx=context, param_hint="'POINTS'") from None


def _blame_option(
    context: typer.Context, given: dict[str, Any], error: neurbs.NeurbsError
) -> Exception:
    """Find out whether a value given on the command line is to blame, and not the points."""
    # All errors about an argument start with its name: "grid must be ..., got ...".
    name, must, reason = str(error).partition(" must be ")
    if not must or name not in given:
        return error
    return typer.BadParameter(f"must be {reason}", ctx=context, param_hint=f"'{_flag(name)}'")


@contextmanager
def _progress_bar(shown: bool) -> Iterator[Callable[[Progress], None] | None]:
    """Give what draws the progress on a terminal, and `None` where there is none."""
    if not shown or sys.stderr is None or not sys.stderr.isatty():
        yield None
        return
    from rich import progress as rich
    from rich.console import Console
    from rich.table import Column

    def text(form: str) -> rich.ProgressColumn:
        # On a narrow terminal the bar makes room, not the numbers.
        return rich.TextColumn(form, table_column=Column(no_wrap=True))

    columns = (
        text("{task.description}"),
        rich.BarColumn(),
        text("{task.completed:,.0f}/{task.total:,.0f}"),
        text("{task.fields[news]}"),
        rich.TimeElapsedColumn(),
    )
    with rich.Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", news="", visible=False)

        def draw(progress: Progress) -> None:
            reached = f"{progress.reached:,}/{progress.points:,} reached"
            moves = progress.change is not None
            bar.update(
                task,
                visible=True,
                description=progress.stage,
                completed=progress.step,
                total=progress.total,
                news=f"moves {progress.change:.2g}, {reached}" if moves else "",
            )

        yield draw


def _summary(report: Report, files: list[str]) -> str:
    return f"{report}\n{'written':<12}{', '.join(files)}"
