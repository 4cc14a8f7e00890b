"""The option `--config`: other options from a TOML file."""

from __future__ import annotations

import difflib
import sys
from functools import partial
from pathlib import Path
from typing import Annotated, Any, TypeAlias

import typer

from neurbs import NeurbsError
from neurbs.cli.options import PAIR
from neurbs.io.reading import check_file, read_whole

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

_MAX_BYTES = 1 << 20
"""Most bytes of a file of settings."""


def _read_config(context: typer.Context, path: Path | None) -> Path | None:
    """Make the settings of a file the defaults of the command."""
    if path is None:
        return None
    wrong = partial(typer.BadParameter, ctx=context, param_hint="'--config'")
    try:
        check_file(path, "settings")
        content = read_whole(path, _MAX_BYTES)
    except NeurbsError as error:
        raise wrong(str(error)) from None
    try:
        tables = tomllib.loads(content.decode())
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise wrong(f"{path} must be a TOML file, but: {error}") from None
    _check_tables(context, path, tables)
    options = _options(context.command)
    defaults = {}
    for key, value in tables.get(str(context.info_name), {}).items():
        option = options[key.replace("-", "_")]
        if not isinstance(value, (str, int, float, list)):
            must = "a string, a number, a boolean or an array"
            raise wrong(f"{path}: {key} must be {must}, got {value!r}")
        if isinstance(value, bool) and not getattr(option, "is_flag", False):
            # An option of words, such as --trim.
            value = "yes" if value else "no"
        # One number stands for a pair, as on the command line.
        pair = option.nargs == PAIR and not isinstance(value, list)
        defaults[option.name] = [value, value] if pair else value
    context.default_map = {**(context.default_map or {}), **defaults}
    return path


def _check_tables(context: typer.Context, path: Path, tables: dict[str, Any]) -> None:
    """Check that each table of a file is named like a command, and each setting like an option."""
    wrong = partial(typer.BadParameter, ctx=context, param_hint="'--config'")
    program = context.parent.command if context.parent else None
    commands = getattr(program, "commands", {context.info_name: context.command})
    for name, settings in tables.items():
        if name in commands and not isinstance(settings, dict):
            raise wrong(f"{path}: [{name}] must be a table, got {settings!r}")
        if not isinstance(settings, dict):
            raise wrong(
                f"{path}: settings must be in a table of a command, as [{context.info_name}], "
                f"got {name!r} above all tables"
            )
        if name not in commands:
            raise wrong(f"{path}: {_unknown('table', name, list(commands))}")
        known = _options(commands[name])
        for key in settings:
            if key.replace("-", "_") not in known:
                raise wrong(f"{path}: [{name}] {_unknown('setting', key, list(known))}")


def _options(command: Any) -> dict[str, Any]:
    """Return the options of a command by their names in a file of settings."""
    return {
        word.lstrip("-").replace("-", "_"): parameter
        for parameter in command.params
        for word in parameter.opts
        if word.startswith("--") and word not in ("--config", "--help")
    }


def _unknown(what: str, got: str, known: list[str]) -> str:
    """Say that a name is unknown, with the nearest of those that are known."""
    near = difflib.get_close_matches(got.replace("-", "_"), known, n=1, cutoff=0.5)
    if near:
        return f"has an unknown {what} {got!r}: did you mean {near[0]!r}?"
    return f"has an unknown {what} {got!r}: it must be one of {', '.join(known)}"


Config: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "--config",
        metavar="FILE.toml",
        help="Read options from the table of this file that is named like the command; options "
        "of the command line override them",
        callback=_read_config,
        is_eager=True,
    ),
]
