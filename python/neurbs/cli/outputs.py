"""What a command will write: every name is known and checked before any work."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import typer

import neurbs
from neurbs import io


def check_outputs(
    context: typer.Context,
    outputs: Iterable[Path],
    inputs: Iterable[Path],
    *,
    sources: Sequence[Path] = (),
    numbered: bool = False,
    check: Callable[[Path], None] = io.check_target,
) -> None:
    """Check that files can be written, are none that is read, and differ from each other.

    Files are compared by identity, not by spelling. With `numbered`, each output stands for any
    number of files, ``name-1.suffix`` and so on.

    Parameters
    ----------
    context : typer.Context
        The command, for the message.
    outputs, inputs : iterable of Path
        What is written, and what is read.
    sources : sequence of Path
        What each output is made of, if of different files.
    numbered : bool, default False
        Whether outputs get numbers.
    check : callable
        What raises if a file cannot be written.

    Raises
    ------
    typer.BadParameter
        If the command must not begin. It names both files.
    """

    def wrong(message: str) -> typer.BadParameter:
        return typer.BadParameter(message, ctx=context, param_hint="'--output'")

    read = list(inputs)
    written: list[Path] = []
    for output in outputs:
        try:
            check(output)
        except neurbs.NeurbsError as error:
            raise wrong(str(error)) from None
        for file in read:
            if _meets(output, file, numbered=numbered):
                raise wrong(
                    f"{output}: would replace {file}, which is read: the input must not be "
                    "overwritten, give another file"
                )
        for other in written:
            clash = _is_same(output, other) or (
                numbered
                and (_meets(output, other, numbered=True) or _meets(other, output, numbered=True))
            )
            if clash:
                both = f"{output} and {other}"
                if sources:
                    at, before = len(written), written.index(other)
                    both = f"{output}: {sources[before]} and {sources[at]}"
                raise wrong(f"{both}: two results would be written to one file")
        written.append(output)


def _meets(output: Path, file: Path, *, numbered: bool) -> bool:
    """Whether an output, or one of those that numbers make of it, is this file."""
    if not numbered:
        return _is_same(output, file)
    number = re.fullmatch(rf"{re.escape(output.stem)}-([1-9]\d*)", file.stem)
    return number is not None and _is_same(output.with_stem(file.stem), file)


def _is_same(one: Path, other: Path) -> bool:
    if one.exists() and other.exists():
        return one.samefile(other)
    # What is not there yet is known by its folder and name.
    return (
        one.name == other.name
        and one.parent.exists()
        and other.parent.exists()
        and one.parent.samefile(other.parent)
    )
