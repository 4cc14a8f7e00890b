"""Checks of the files that a command will write, before it starts."""

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
    """Check that files can be written, are not inputs and differ from each other.

    Files are compared by identity, not by spelling.

    Parameters
    ----------
    context : typer.Context
        The command, for the message.
    outputs, inputs : iterable of Path
        Files to write and to read.
    sources : sequence of Path
        The input of each output, if there are several inputs.
    numbered : bool, default False
        Whether each output stands for the files ``name-1.suffix``, ``name-2.suffix`` and so on.
    check : callable
        Called with each output; raises if the file cannot be written.

    Raises
    ------
    typer.BadParameter
        If a check fails. The message names both files.
    """
    is_option = any(p.name == "output" for p in context.command.params)
    hint = "'--output'" if is_option else "'OUT'"

    def wrong(message: str) -> typer.BadParameter:
        return typer.BadParameter(message, ctx=context, param_hint=hint)

    read = list(inputs)
    written: list[Path] = []
    for output in outputs:
        try:
            check(output)
        except neurbs.NeurbsError as error:
            raise wrong(str(error)) from None
        for file in read:
            if _includes(output, file, numbered=numbered):
                raise wrong(
                    f"{output}: would replace the input {file}: the input must not be "
                    "overwritten, give another file"
                )
        for other in written:
            clash = _is_same(output, other) or (
                numbered
                and (
                    _includes(output, other, numbered=True)
                    or _includes(other, output, numbered=True)
                )
            )
            if clash:
                both = f"{output} and {other}"
                if sources:
                    at, before = len(written), written.index(other)
                    both = f"{output}: {sources[before]} and {sources[at]}"
                raise wrong(f"{both}: two results would be written to one file")
        written.append(output)


def _includes(output: Path, file: Path, *, numbered: bool) -> bool:
    """Whether a file is an output, or one of its numbered files."""
    if not numbered:
        return _is_same(output, file)
    number = re.fullmatch(rf"{re.escape(output.stem)}-([1-9]\d*)", file.stem)
    return number is not None and _is_same(output.with_stem(file.stem), file)


def _is_same(one: Path, other: Path) -> bool:
    if one.exists() and other.exists():
        return one.samefile(other)
    # A file that does not exist yet is identified by its folder and name.
    return (
        one.name == other.name
        and one.parent.exists()
        and other.parent.exists()
        and one.parent.samefile(other.parent)
    )
