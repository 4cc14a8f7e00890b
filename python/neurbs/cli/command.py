"""The command `neurbs` as a program: exit codes, output, signals."""

from __future__ import annotations

import json
import os
import shlex
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from io import TextIOWrapper
from typing import Annotated, Any, NoReturn, TypeVar

import typer

import neurbs
from neurbs.cli.messages import Command, failure_message, usage_message, warnings_printed
from neurbs.errors import printable

FAILED, WRONG_USAGE, OUTSIDE, NOT_MET, INTERRUPTED, TERMINATED = 1, 2, 3, 4, 130, 143
"""Exit codes other than 0."""

Function = TypeVar("Function", bound=Callable[..., Any])

app = typer.Typer(
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
    # Plain text: the tables of Rich cut words at 80 columns.
    rich_markup_mode=None,
)


def command(summary: str, *examples: str) -> Callable[[Function], Function]:
    """Make a function a command of `app`, with a help text of a summary and examples."""
    label = "Examples" if len(examples) > 1 else "Example"
    # The lines after \b are not joined.
    lines = "\n".join([f"{label}:", *(f"  {example}" for example in examples)])
    text = f"{summary}\n\n\b\n{lines}"
    return app.command(cls=Command, help=text)


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line and leave Python with its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        The words after the command's name, by default those of the process.
    """
    for stream in (sys.stdout, sys.stderr):
        # Names of files may have characters that the terminal's encoding lacks.
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    # SystemExit unwinds the stack, so unfinished files are removed as after Ctrl-C.
    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(TERMINATED))
    code = _run(sys.argv[1:] if arguments is None else list(arguments))
    try:
        print(end="", flush=True)
    except OSError:
        # This was reported. Else Python flushes again at exit and reports it twice.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    sys.exit(code)


def print_json(document: Any) -> None:
    """Print a JSON document and flush."""
    print(json.dumps(document), flush=True)


def print_table(lines: dict[str, str]) -> None:
    """Print names and texts in two columns and flush."""
    from neurbs.reconstruction_report import aligned

    # A text may have several lines.
    seen = {name: "\n".join(map(printable, text.split("\n"))) for name, text in lines.items()}
    print("\n".join(aligned(seen.items())), flush=True)


def repeated(context: typer.Context) -> str:
    """Return the whole command line, quoted for a shell."""
    return shlex.join(["neurbs", *(context.find_root().obj or ())])


def _run(arguments: list[str]) -> int:
    """Run a command and return its exit code; an exception becomes a message."""
    code, kind, message = INTERRUPTED, "KeyboardInterrupt", "interrupted"
    try:
        with _interrupts_raised(), warnings_printed():
            program = typer.main.get_command(app)
            returned = program.main(
                arguments, prog_name="neurbs", standalone_mode=False, obj=tuple(arguments)
            )
        # Typer returns this code after Ctrl-C.
        if returned != INTERRUPTED:
            return int(returned or 0)
    except KeyboardInterrupt:
        pass
    except typer.TyperException as error:
        code, kind, message = WRONG_USAGE, "UsageError", usage_message(error)
    except Exception as error:
        code, kind, message = FAILED, type(error).__name__, failure_message(error)
    print(f"neurbs: error: {message}" if code != INTERRUPTED else message, file=sys.stderr)
    # A wrong command line has no parsed options.
    if "--json" in arguments:
        with suppress(OSError):
            print_json({"error": {"type": kind, "message": message}})
    return code


@contextmanager
def _interrupts_raised() -> Iterator[None]:
    """Let Ctrl-C raise KeyboardInterrupt, unless the process ignores it."""
    before = signal.getsignal(signal.SIGINT)
    if before is signal.SIG_IGN:
        yield
        return
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"neurbs {neurbs.__version__}")
        raise typer.Exit


def _print_versions(wanted: bool) -> None:
    if wanted:
        neurbs.show_versions()
        raise typer.Exit


@app.callback(help="Turn scattered 3D points into a standard NURBS surface.")
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
            help="Print the versions of neurbs and of the libraries it uses, for bug reports",
        ),
    ] = False,
) -> None:
    """Take the options of the program itself."""
