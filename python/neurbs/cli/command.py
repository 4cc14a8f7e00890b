"""The command as a program: exit codes, messages, signals."""

from __future__ import annotations

import json
import os
import signal
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from io import TextIOWrapper
from typing import Annotated, Any, NoReturn

import typer

import neurbs

FAILED, WRONG_USAGE, OUTSIDE, NOT_MET, INTERRUPTED, TERMINATED = 1, 2, 3, 4, 130, 143
"""Exit codes other than 0."""

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
    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(TERMINATED))
    code = _run(sys.argv[1:] if arguments is None else list(arguments))
    try:
        print(end="", flush=True)
    except OSError:
        # This has been reported; but Python would try again on leaving, and complain once more.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    sys.exit(code)


def print_json(document: Any) -> None:
    """Print one JSON document, at once."""
    print(json.dumps(document), flush=True)


def print_table(lines: dict[str, str]) -> None:
    """Print names and what they are, one below the other, at once."""
    from neurbs.reconstruction_report import aligned

    print("\n".join(aligned(lines.items())), flush=True)


def failure(error: Exception) -> dict[str, str]:
    """Return what a JSON document says of a failure."""
    return {"type": type(error).__name__, "message": failure_message(error)}


def failure_message(error: Exception) -> str:
    """Say in one line what has failed."""
    match error:
        case OSError(strerror=str(reason), filename=str(name)):
            return f"{name}: {reason}"
        case OSError(strerror=str(reason)):
            return reason
        case neurbs.NeurbsError() | OSError():
            return str(error)
        case MemoryError():
            return "there is not enough memory for this job"
        case Warning():
            return f"a warning, which Python was told to take for an error: {error}"
    return f"{type(error).__name__}: {error} (this is a fault of neurbs, please report it)"


def _run(arguments: list[str]) -> int:
    """Run a command, and turn what it raises into a message and an exit code."""
    code, kind, message = INTERRUPTED, "KeyboardInterrupt", "interrupted"
    try:
        with _interrupts_raised(), _warnings_as_messages():
            command = typer.main.get_command(app)
            returned = command.main(arguments, prog_name="neurbs", standalone_mode=False)
        # This is also Typer's own answer to Ctrl-C.
        if returned != INTERRUPTED:
            return int(returned or 0)
    except KeyboardInterrupt:
        pass
    except typer.TyperException as error:
        code, kind, message = WRONG_USAGE, "UsageError", _usage_message(error)
    except Exception as error:
        code, kind, message = FAILED, type(error).__name__, failure_message(error)
    print(f"neurbs: error: {message}" if code != INTERRUPTED else message, file=sys.stderr)
    # Looked for by hand: a wrong command line has no parsed options.
    if "--json" in arguments:
        with suppress(OSError):
            print_json({"error": {"type": kind, "message": message}})
    return code


def _usage_message(error: typer.TyperException) -> str:
    message = " ".join(error.format_message().split()).rstrip(".")
    context: typer.Context | None = getattr(error, "ctx", None)
    command = context.command_path if context else "neurbs"
    return f"{message} (see '{command} --help')"


@contextmanager
def _interrupts_raised() -> Iterator[None]:
    """Let Ctrl-C raise KeyboardInterrupt, whatever it did before; ignored, it stays so."""
    before = signal.getsignal(signal.SIGINT)
    if before is signal.SIG_IGN:
        yield
        return
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


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


def _print_versions(wanted: bool) -> None:
    if wanted:
        neurbs.show_versions()
        raise typer.Exit


@app.callback()
def _neurbs(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version"),
    ] = False,
    versions: Annotated[
        bool,
        typer.Option(
            "--versions",
            callback=_print_versions,
            is_eager=True,
            help="Print the versions of all that neurbs works with, for reports of faults",
        ),
    ] = False,
) -> None:
    """Turn scattered 3D points into a standard NURBS surface."""
