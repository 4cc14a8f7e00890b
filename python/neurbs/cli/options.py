"""Options: those of Python's functions, and those that commands have in common."""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Annotated, Any, TypeAlias, TypeVar

import typer

import neurbs
from neurbs import io

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

Command = TypeVar("Command", bound=Callable[..., Any])

_NOT_WORDS = ("array", "callable")
"""Types of parameters that no word of a command line stands for."""


def _read_config(context: typer.Context, path: Path | None) -> Path | None:
    """Take the settings of a file for defaults."""
    if path is None:
        return None
    wrong = partial(typer.BadParameter, ctx=context, param_hint="'--config'")
    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise wrong(f"{path} must be a file of TOML, but: {error}") from None
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
            raise wrong(f"{path}: {key} must be a text, a number, a list or a truth, got {value!r}")
        defaults[name] = value
    context.default_map = {**(context.default_map or {}), **defaults}
    return path


AsJson: TypeAlias = Annotated[
    bool, typer.Option("--json", metavar="", help="Print one JSON document")
]
Quiet: TypeAlias = Annotated[
    bool, typer.Option("--quiet", "-q", metavar="", help="Print only warnings and errors")
]
Config: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "--config",
        metavar="FILE.toml",
        help="Options from a file, under the command's name; those given here go before",
        callback=_read_config,
        is_eager=True,
    ),
]
Unit: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--unit",
        metavar="UNIT",
        help="Unit of the coordinates, for files and legends; by default that of the points, if "
        "their file knows it",
    ),
]
Surface: TypeAlias = Annotated[
    Path,
    typer.Argument(
        metavar="SURFACE", help=f"File of a surface: {' '.join(io.LOADABLE)}", readable=False
    ),
]


def flag(name: str) -> str:
    """Return the option of a parameter."""
    return f"--{name.replace('_', '-')}"


def options_of(function: Callable[..., Any], *skipped: str) -> Callable[[Command], Command]:
    """Give a command, in the place of its ``**options``, the keyword options of a function.

    Names, defaults and help come from the function's signature and numpydoc, where they stand
    once. Parameters that no word can stand for, arrays and callbacks, are left out.
    """
    described = _described(inspect.getdoc(function) or "")

    def with_options(command: Command) -> Command:
        signature = inspect.signature(command, eval_str=True)
        own = [p for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD]
        added = [
            _option(parameter, *described[name])
            for name, parameter in inspect.signature(function).parameters.items()
            if name in described and name not in skipped and _is_word(described[name][0])
        ]
        # Typer reads the signature; the command itself takes what it is given.
        command.__signature__ = signature.replace(  # type: ignore[attr-defined]
            parameters=[*_positional(own), *added, *_keyword(own)]
        )
        return command

    return with_options


def values(options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options that were given, as the function takes them."""
    given = {name: value for name, value in options.items() if value is not None}
    return {name: _value(value) for name, value in given.items()}


@contextmanager
def blamed(context: typer.Context, given: Mapping[str, Any]) -> Iterator[None]:
    """Say of an error whether a value given on the command line is to blame, and not the points."""
    try:
        yield
    except neurbs.NeurbsError as error:
        # All errors about an argument start with its name: "grid must be ..., got ...".
        name, must, reason = str(error).partition(" must be ")
        if not must or name not in given:
            raise
        raise typer.BadParameter(
            f"must be {reason}", ctx=context, param_hint=f"'{flag(name)}'"
        ) from None


def _described(doc: str) -> dict[str, tuple[str, str]]:
    """Read type and description of each parameter out of a numpydoc text."""
    _, _, section = doc.partition("Parameters\n----------\n")
    section = re.split(r"\n\n?\w[\w ]*\n-{3,}\n", section)[0]
    found = re.findall(r"^(\w[\w, ]*) : (.+)\n((?:    .+\n?|\n(?=    ))+)", section, re.MULTILINE)
    return {
        name: (kind, " ".join(text.replace("``", "").replace("`", "").split()))
        for names, kind, text in found
        for name in names.split(", ")
    }


def _is_word(kind: str) -> bool:
    # What comes first counts: a choice of words may also be an array, in Python.
    return not kind.startswith(_NOT_WORDS)


def _option(parameter: inspect.Parameter, kind: str, text: str) -> inspect.Parameter:
    """Make an option of a parameter, described by its type and text."""
    first = re.split(r"\. (?=[A-Z])|; see ", text)[0].rstrip(".")
    default = parameter.default
    annotation: Any = str | None
    words = [flag(parameter.name)]
    metavar = "WORD"
    notes = []
    if named := re.match(r"int or \{\"(.+?)\"\}", kind):
        metavar = f"N|{named[1]}"
    elif choices := re.match(r"\{(.+?)\}", kind):
        notes.append(choices[1].replace('"', "").replace(", ", "|"))
    elif kind.startswith("(int, int)"):
        annotation, metavar = tuple[str, str] | None, "N N"
    elif kind.startswith("(float, float, float)"):
        annotation, metavar = tuple[str, str, str] | None, "X Y Z"
    elif kind.startswith("bool"):
        annotation, metavar = bool | None, ""
        words = [f"{words[0]}/--no-{words[0][2:]}"]
    elif kind.startswith("int"):
        metavar = "N"
    elif kind.startswith(("float", "number")):
        metavar = "NUMBER"
    if default not in (None, "", inspect.Parameter.empty):
        notes.append(f"default: {_word(default)}")
    text = f"{first} ({', '.join(notes)})" if notes else first
    option = typer.Option(*words, metavar=metavar, help=text)
    return inspect.Parameter(
        parameter.name,
        inspect.Parameter.KEYWORD_ONLY,
        default=None,
        annotation=Annotated[annotation, option],
    )


def _word(value: Any) -> str:
    """Write a default as it is given on the command line; switches are on or off."""
    return {True: "on", False: "off"}[value] if isinstance(value, bool) else str(value)


def _positional(parameters: list[inspect.Parameter]) -> list[inspect.Parameter]:
    return [p for p in parameters if p.kind is not p.KEYWORD_ONLY]


def _keyword(parameters: list[inspect.Parameter]) -> list[inspect.Parameter]:
    return [p for p in parameters if p.kind is p.KEYWORD_ONLY]


def _value(text: Any) -> Any:
    """Make a number of what looks like one; whether it fits, the function will say."""
    if isinstance(text, tuple):
        return tuple(map(_value, text))
    if isinstance(text, str) and "," in text:
        return tuple(map(_value, text.split(",")))
    for kind in (int, float):
        with suppress(TypeError, ValueError):
            return text if isinstance(text, bool) else kind(text)
    return text
