"""The help of a command: arguments, then options in groups of one kind."""

from __future__ import annotations

import textwrap
from typing import Any

import typer

GROUPS = ("Files", "Surface", "Fit", "Training", "Triangles", "Picture", "Check", "General")
"""Groups of options, in the order of the help. An option without a group is in the last one."""

_MAX_NAME = 28
"""Width of the column of names. The text of a longer one begins in the next line."""


def write_options(context: typer.Context, formatter: Any) -> None:
    """Write the arguments and options of a command, wrapped at the width of the terminal."""
    arguments: list[tuple[str, str]] = []
    groups: dict[str, list[tuple[str, str]]] = {group: [] for group in GROUPS}
    for parameter in context.command.get_params(context):
        if parameter.param_type_name == "argument":
            arguments.append((parameter.metavar or parameter.name, _text(parameter)))
        else:
            group = groups[getattr(parameter, "rich_help_panel", None) or GROUPS[-1]]
            group.append((_names(parameter), _text(parameter)))
    for title, rows in [("Arguments", arguments), *groups.items()]:
        if rows:
            with formatter.section(title):
                formatter.write("\n".join(_lines(rows, formatter.width)) + "\n")


def _lines(rows: list[tuple[str, str]], width: int) -> list[str]:
    """Return two columns as lines; words are not divided, also not at hyphens."""
    column = min(max(len(name) for name, _ in rows), _MAX_NAME)
    indent = " " * (column + 4)
    lines: list[str] = []
    for name, text in rows:
        head = f"  {name:{column}}  "
        lines += [] if len(name) <= column else [head.rstrip()]
        wrapped = textwrap.wrap(
            text,
            width,
            initial_indent=head if len(name) <= column else indent,
            subsequent_indent=indent,
            break_on_hyphens=False,
            break_long_words=False,
        )
        lines += wrapped
    return lines


def _names(option: Any) -> str:
    """Return the words of an option, the short one first, with its values."""
    words = ", ".join(sorted(option.opts, key=len))
    if option.secondary_opts:
        words = f"{words} / {option.secondary_opts[0]}"
    return words if option.is_flag else f"{words} {option.metavar}".strip()


def _text(parameter: Any) -> str:
    notes = ["required"] if parameter.required else []
    if getattr(parameter, "multiple", False):
        notes.append("repeatable")
    text = str(parameter.help).rstrip(".")
    return f"{text} [{', '.join(notes)}]" if notes else text
