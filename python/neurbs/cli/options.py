"""Options of commands: those that stand for keyword arguments of functions, and common ones."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Annotated, Any, TypeAlias, TypeVar

import typer

from neurbs._core import LENGTH_UNITS
from neurbs.cli.completion import of_words

PAIR = 2
"""Words of an option that may be one number."""

Command = TypeVar("Command", bound=Callable[..., Any])

FILES = "Files"
"""The group of options about files."""

AsJson: TypeAlias = Annotated[
    bool, typer.Option("--json", metavar="", help="Print one JSON document")
]
Quiet: TypeAlias = Annotated[
    bool, typer.Option("--quiet", "-q", metavar="", help="Print only warnings and errors")
]
Unit: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--unit",
        metavar="UNIT",
        help="Unit of the results: numbers of a file with another unit are converted; a file "
        f"without one is taken to be in it ({'|'.join(LENGTH_UNITS)}, default: the unit of the "
        "file)",
        autocompletion=of_words(*LENGTH_UNITS),
        rich_help_panel=FILES,
    ),
]


@dataclass(frozen=True)
class Option:
    """An option of a command that stands for a keyword argument of a function.

    Attributes
    ----------
    name : str
        Name of the argument.
    help : str
        The help text, without choices and default.
    metavar : str
        The values as the help shows them: ``"N"``, ``"NUMBER"``, ``"N N"``. An option takes as
        many words as there are here; without any it is a switch with a `no` form.
    choices : tuple of str
        The values that the function takes, where they are words.
    default : str
        The default in words, for an argument whose default is None.
    group : str
        The group in the help, one of `neurbs.cli.help.GROUPS`; by default that of the command.
    """

    name: str
    help: str
    metavar: str = "WORD"
    choices: tuple[str, ...] = ()
    default: str = ""
    group: str = ""


SEED = Option("seed", "Seed of all random numbers; the same seed gives the same result", "N")
REACH = Option(
    "reach",
    "Distance from a node within which a point counts as reached, in the points' unit; training "
    "ends when all points are reached",
    "NUMBER",
    default="0.001 of the diagonal of the points' bounding box",
)


def flag(name: str) -> str:
    """Return the option that stands for an argument."""
    return f"--{name.replace('_', '-')}"


def with_pairs(parameters: Sequence[Any], words: Sequence[str]) -> list[str]:
    """Double the one number after an option that takes two: `--grid 30` means `--grid 30 30`."""
    pairs = {word for each in parameters if each.nargs == PAIR for word in each.opts}
    result: list[str] = []
    rest = list(words)
    while rest:
        word = rest.pop(0)
        name, equal, value = word.partition("=")
        if name not in pairs:
            result.append(word)
            continue
        if equal:
            rest.insert(0, value)
        count = next((n for n, each in enumerate(rest) if not _is_number(each)), len(rest))
        # A word that is no number is doubled, too: the function says what it must be.
        is_wrong = rest and not rest[0].startswith("-") and not any(map(_is_number, rest[:2]))
        result += [name, *([rest.pop(0)] * 2 if count == 1 or is_wrong else [])]
    return result


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def options_of(
    function: Callable[..., Any], options: tuple[Option, ...], group: str
) -> Callable[[Command], Command]:
    """Give a command options in the place of its ``**options``.

    Parameters
    ----------
    function : callable
        The function that the command calls; defaults come from its signature.
    options : tuple of Option
        One for each of its arguments that the command line can give.
    group : str
        The group of options without one.
    """
    arguments = inspect.signature(function).parameters

    def with_options(command: Command) -> Command:
        signature = inspect.signature(command, eval_str=True)
        own = [p for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD]
        keyword = [p for p in own if p.kind is p.KEYWORD_ONLY]
        positional = [p for p in own if p.kind is not p.KEYWORD_ONLY]
        added = [_parameter(option, arguments[option.name].default, group) for option in options]
        # Typer reads the signature; the command itself gets the values as `**options`.
        command.__signature__ = signature.replace(  # type: ignore[attr-defined]
            parameters=[*positional, *added, *keyword]
        )
        return command

    return with_options


def values(options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options that were given, with the types that the function takes."""
    given = {name: value for name, value in options.items() if value is not None}
    return {name: _value(value) for name, value in given.items()}


def _parameter(option: Option, default: Any, group: str) -> inspect.Parameter:
    """Return the parameter of the command for an option, with the function's default."""
    words = len(option.metavar.split())
    annotation: Any = bool | None
    names = [flag(option.name)]
    if words == 0:
        names = [f"{names[0]}/--no-{names[0][2:]}"]
    elif words == 1:
        annotation = str | None
    else:
        annotation = tuple[(str,) * words] | None  # type: ignore[misc]
    notes = ["|".join(option.choices)] if option.choices else []
    shown = option.default if default in (None, "") else _word(default)
    if shown:
        notes.append(f"default: {shown}")
    text = f"{option.help} ({', '.join(notes)})" if notes else option.help
    return inspect.Parameter(
        option.name,
        inspect.Parameter.KEYWORD_ONLY,
        default=None,
        annotation=Annotated[
            annotation,
            typer.Option(
                *names,
                metavar=option.metavar,
                help=text,
                autocompletion=of_words(*option.choices) if option.choices else None,
                rich_help_panel=option.group or group,
            ),
        ],
    )


def _word(value: Any) -> str:
    """Return a default as the help shows it; a switch is on or off."""
    return {True: "on", False: "off"}[value] if isinstance(value, bool) else str(value)


def _value(text: Any) -> Any:
    """Return a number for a text that is one, a tuple for a text with commas."""
    if isinstance(text, tuple):
        return tuple(map(_value, text))
    if isinstance(text, str) and "," in text:
        return tuple(map(_value, text.split(",")))
    if text in TRUTHS:
        return TRUTHS[text]
    for kind in (int, float):
        with suppress(TypeError, ValueError):
            return text if isinstance(text, bool) else kind(text)
    return text


TRUTHS = {"yes": True, "no": False}
"""The words for truth values."""
