"""Text tables of points: `.xyz`, `.txt`, `.csv`, and the vertex lines of `.obj`."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.io.table import Layout, is_number, open_text, read_columns, shown

_COMMENT = re.compile("#|//")
_AXES = ("x", "y", "z")


def read_text(path: Path) -> NDArray[np.float64]:
    """Read a table of points whose separator, header and columns are found out.

    See `neurbs.read_points` for what is understood.
    """
    header, layout = _layout(path)

    def rows() -> Iterator[tuple[int, str]]:
        return islice(_rows(path), 1 if header else 0, None)

    return read_columns(path, rows, layout)


def read_obj(path: Path) -> NDArray[np.float64]:
    """Read the vertices of a Wavefront file, all of them and in their order."""

    def rows() -> Iterator[tuple[int, str]]:
        return ((number, text) for number, text in _rows(path) if text.split(None, 1)[0] == "v")

    if next(rows(), None) is None:
        raise NeurbsError(f"{path}: must hold at least one point, but has no 'v' line")
    # Column 0 is the 'v' itself. A weight or a colour may follow the coordinates.
    return read_columns(path, rows, Layout(columns=(1, 2, 3)))


def _rows(path: Path) -> Iterator[tuple[int, str]]:
    """Walk the lines that are neither blank nor only a comment, with their numbers from 1."""
    with open_text(path) as file:
        for number, line in enumerate(file, start=1):
            text = line
            if "#" in line or "//" in line:
                text = _COMMENT.split(line, maxsplit=1)[0]
            if text.strip():
                yield number, text


def _layout(path: Path) -> tuple[bool, Layout]:
    """Whether the table has a header, and how its rows are cut."""
    rows = _rows(path)
    top = number, text = next(rows, (0, ""))
    if not text:
        raise NeurbsError(f"{path}: must hold at least one point, but the file is empty")
    header = _is_header(text)
    if header:
        number, text = next(rows, (0, ""))
        if not text:
            raise NeurbsError(
                f"{path}: must hold at least one point, but ends after the header in line {top[0]}"
            )
    separator = _separator(text)
    fields = text.split(separator)
    if len(fields) < 2:
        raise NeurbsError(
            f"{path}: line {number} must have columns x, y and z (or x and y), "
            f"got column 1 only, {shown(text.strip())}: "
            "separate columns by whitespace, comma, semicolon or tab"
        )
    columns = tuple(range(min(len(fields), 3)))
    if header:
        names = [name.strip().strip("\"'").lower() for name in top[1].split(separator)]
        if set(_AXES) <= set(names):
            if len(names) != len(fields):
                raise NeurbsError(
                    f"{path}: line {number} must have {len(names)} columns, "
                    f"as the header in line {top[0]} has, got {len(fields)}"
                )
            columns = tuple(names.index(axis) for axis in _AXES)
    return header, Layout(columns, width=len(fields), separator=separator)


def _is_header(text: str) -> bool:
    """Names, and not a number among them."""
    fields = text.split(_separator(text))
    return any(map(str.isalpha, text)) and not any(is_number(field) for field in fields)


def _separator(text: str) -> str | None:
    for separator in ";,":
        if separator in text:
            return separator
    # A tab is one blank among others, unless it sets apart fields that have blanks of their own.
    fields = [field.split() for field in text.split("\t")]
    whole = (len(words) == 1 or (words and not is_number(words[0])) for words in fields)
    return "\t" if len(fields) > 1 and all(whole) else None
