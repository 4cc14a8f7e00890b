"""Errors and warnings as messages that name options of the command line, not arguments.

In a message of neurbs an argument stands between backticks, alone or with a value: `fairness`,
`kind="tube"`. An error about the value of an argument has its name as attribute `argument`.
"""

from __future__ import annotations

import re
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import typer
from typer.core import TyperCommand

import neurbs
from neurbs.cli.help import write_options
from neurbs.cli.options import TRUTHS, flag, with_pairs
from neurbs.errors import printable

TRUTH_WORDS = {str(truth): word for word, truth in TRUTHS.items()}
"""The words of the command line for the truth values in messages."""


class Command(TyperCommand):
    """A command with groups of options, whose errors name options instead of arguments."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write arguments and options in groups."""
        write_options(ctx, formatter)

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the words of the command line; a pair of equal numbers may be one number."""
        try:
            return super().parse_args(ctx, with_pairs(self.params, args))
        except typer.TyperException as error:
            # The message names the help of the command, not that of the program.
            wrong: Any = error
            wrong.ctx = getattr(error, "ctx", None) or ctx
            raise

    def invoke(self, ctx: Any) -> Any:
        """Run the command; an error about an option is a wrong command line."""
        with warnings_printed(ctx):
            try:
                return super().invoke(ctx)
            except neurbs.NeurbsError as error:
                message = with_options(ctx, str(error))
                argument = option_argument(ctx, error)
                if argument is None:
                    error.args = (message,)
                    raise
                for truth, word in TRUTH_WORDS.items():
                    message = re.sub(rf"(?<!')\b{truth}\b", repr(word), message)
                raise typer.BadParameter(
                    message.removeprefix(f"{argument} "),
                    ctx=ctx,
                    param_hint=f"'{flag(argument)}'",
                ) from None


def option_argument(context: typer.Context, error: neurbs.NeurbsError) -> str | None:
    """Return the argument that an error is about, if an option has given its value."""
    value = None if error.argument is None else context.params.get(error.argument)
    # Points come from files, which are arguments of the command, not options.
    return None if value is None or isinstance(value, (Path, list)) else error.argument


def with_options(context: typer.Context, message: str) -> str:
    """Replace the arguments between backticks by the options of the command."""
    options = {p.name: p for p in context.command.params if p.param_type_name == "option"}

    def replaced(match: re.Match[str]) -> str:
        option = options.get(match["name"])
        if option is None:
            return match[0]
        value = (match["value"] or "").strip("\"'")
        word = option.opts[0]
        if option.secondary_opts:
            return option.secondary_opts[0] if value == "False" else word
        value = TRUTH_WORDS.get(value, value)
        return f"{word} {value}".rstrip()

    return re.sub(r"`(?P<name>\w+)(?:=(?P<value>[^`]+))?`", replaced, message)


@contextmanager
def warnings_printed(context: typer.Context | None = None) -> Iterator[None]:
    """Print each warning as one line on stderr."""

    def show(message: Warning | str, *_: object, **__: object) -> None:
        text = str(message) if context is None else with_options(context, str(message))
        print(f"neurbs: warning: {printable(text)}", file=sys.stderr)

    with warnings.catch_warnings():
        warnings.showwarning = show
        yield


def failure(error: Exception) -> dict[str, str]:
    """Return the entry of a JSON document for a failure."""
    return {"type": type(error).__name__, "message": failure_message(error)}


def failure_message(error: Exception) -> str:
    """Return one line about a failure."""
    return printable(_failure_text(error))


def _failure_text(error: Exception) -> str:
    match error:
        case OSError(strerror=str(reason), filename=str(name)):
            return f"{name}: {reason}"
        case OSError(strerror=str(reason)):
            return reason
        case neurbs.NeurbsError() | OSError():
            return str(error)
        case MemoryError():
            return "not enough memory for this job"
        case Warning():
            return f"this warning was turned into an error: {error}"
    return f"{type(error).__name__}: {error} (this is a bug in neurbs, please report it)"


def usage_message(error: typer.TyperException) -> str:
    """Return one line about a wrong command line."""
    message = " ".join(error.format_message().split()).rstrip(".")
    context: typer.Context | None = getattr(error, "ctx", None)
    command = context.command_path if context else "neurbs"
    return printable(f"{message} (see '{command} --help')")
