"""The command line: `neurbs reconstruct POINTS -o OUT`.

Exit codes: 0 done; 1 the job failed; 2 the command line is wrong; 130 interrupted. A failure is
one message on stderr, never a traceback.
"""

from __future__ import annotations

import inspect
import json as jsonlib
import os
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, NoReturn, TypeAlias

import typer

import neurbs
from neurbs import io

_FAILED, _WRONG_USAGE, _INTERRUPTED = 1, 2, 130

_TyperUsageError: type[Exception] = typer.BadParameter.__mro__[1]
"""The base of all errors that Typer finds in a command line.

It has no public name that is the same in all versions of Typer.
"""

_WHY_STOPPED = {
    "reached": "all points are on the lattice",
    "settled": "the lattice has settled",
    "max_steps": "the steps were over",
}


class UsageError(Exception):
    """An argument or option of the command line is wrong."""


app = typer.Typer(
    help="Turn scattered 3D points into a standard NURBS surface.",
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
)


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line and leave Python with its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        What follows the command's name; by default what Python was called with.
    """
    arguments = sys.argv[1:] if arguments is None else arguments
    for stream in (sys.stdout, sys.stderr):
        # A name of a file may hold what the terminal's encoding does not.
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    code = _run(arguments)
    try:
        sys.stdout.flush()
    except OSError:
        # It has been reported; Python would try again on leaving, and complain again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    sys.exit(code)


def _run(arguments: Sequence[str]) -> int:
    """Run a command, and turn what it raises into a message and an exit code."""
    try:
        with _warnings_as_messages():
            command = typer.main.get_command(app)
            code = command.main(list(arguments), prog_name="neurbs", standalone_mode=False)
        # Typer itself answers Ctrl-C by this code, and in older versions by Abort.
        if code != _INTERRUPTED:
            return code or 0
        code, kind, message = _INTERRUPTED, "KeyboardInterrupt", "interrupted"
    except (KeyboardInterrupt, typer.Abort):
        code, kind, message = _INTERRUPTED, "KeyboardInterrupt", "interrupted"
    except (UsageError, _TyperUsageError) as error:
        code, kind, message = _WRONG_USAGE, "UsageError", _usage_message(error)
    except Exception as error:
        code, kind, message = _FAILED, type(error).__name__, _failure_message(error)
    print(message if code == _INTERRUPTED else f"neurbs: error: {message}", file=sys.stderr)
    # Looked for by hand, because a wrong command line has no parsed options.
    if "--json" in arguments:
        print(jsonlib.dumps({"error": {"type": kind, "message": message}}))
    return code
