"""The option `--config`: other options from a TOML file."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from neurbs import NeurbsError
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
    settings = tables.get(str(context.info_name), {})
    if not isinstance(settings, dict):
        raise wrong(f"{path}: [{context.info_name}] must be a table, got {settings!r}")
    names = {
        word.lstrip("-").replace("-", "_"): parameter.name
        for parameter in context.command.params
        for word in parameter.opts
        if word.startswith("--") and word not in ("--config", "--help")
    }
    defaults = {}
    for key, value in settings.items():
        name = names.get(key.replace("-", "_"))
        if name is None:
            known = ", ".join(names)
            raise wrong(f"{path}: a setting must be one of {known}, got {key!r}")
        if not isinstance(value, (str, int, float, list)):
            must = "a string, a number, a boolean or an array"
            raise wrong(f"{path}: {key} must be {must}, got {value!r}")
        defaults[name] = value
    context.default_map = {**(context.default_map or {}), **defaults}
    return path


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
