"""Rows of text to columns of numbers, and where a file breaks its own table.

NumPy's reader does the work. Only when it refuses a row are the rows walked through one by one,
to say which line and column of the file is at fault.
"""

from __future__ import annotations

import codecs
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO, TypeAlias

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError

Rows: TypeAlias = Callable[[], Iterator[tuple[int, str]]]
"""Walks a file anew at each call: its rows, each with its line number from 1, in order."""

_MOST_SHOWN = 40
"""Characters of a file's own text that an error message repeats."""


@dataclass(frozen=True)
class Layout:
    """How rows are cut into columns.

    Attributes
    ----------
    columns : tuple of int
        Those to read, counted from 0.
    width : int or None
        How many columns each row must have; ``None`` if rows may be longer than they need to be.
    separator : str or None
        What stands between two columns; ``None`` for any amount of whitespace.
    """

    columns: tuple[int, ...]
    width: int | None = None
    separator: str | None = None


def open_text(path: Path) -> TextIO:
    """Open a text file of any common encoding, of which only the ASCII characters matter.

    Bytes that are not UTF-8 (names and units in Latin-1) become replacement characters.
    """
    with path.open("rb") as file:
        wide = file.read(2) in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
    return path.open(encoding="utf-16" if wide else "utf-8-sig", errors="replace")


def is_number(text: str) -> bool:
    """Whether NumPy's reader takes `text` for a number."""
    try:
        float(text)
    except ValueError:
        return False
    # Python's float also takes 1_000 and the digits of other scripts.
    return text.isascii() and "_" not in text


def shown(text: str) -> str:
    """Quote a piece of a file for an error message."""
    return repr(text if len(text) <= _MOST_SHOWN else text[: _MOST_SHOWN - 1] + "…")


def read_columns(path: Path, rows: Rows, layout: Layout) -> NDArray[np.float64]:
    """Read the columns of a table.

    Parameters
    ----------
    path : Path
        The file, named in errors.
    rows : Rows
        Its rows.
    layout : Layout
        How they are cut.

    Returns
    -------
    ndarray of shape (n, len(layout.columns))
        float64, C-contiguous; each number as close to its text as float64 can be.

    Raises
    ------
    NeurbsError
        If a row is not as wide as it must be, or a field is not a finite number.
    """
    lines = (text for _, text in rows())
    try:
        values = _load(lines, layout)
    except ValueError as error:
        raise _fault(path, rows, layout, str(error)) from None
    if not np.isfinite(values).all():
        raise _fault(path, rows, layout, "a number is not finite")
    return values


def _load(lines: Iterator[str], layout: Layout) -> NDArray[np.float64]:
    width, columns = layout.width, layout.columns
    if width is None or columns == tuple(range(width)):
        usecols = columns if width is None else None
        return np.loadtxt(
            lines, delimiter=layout.separator, comments=None, usecols=usecols, ndmin=2
        )
    # `usecols` would let rows of differing width pass. Columns that nobody asked for are kept as
    # one character each instead: they may hold text.
    record = [(str(i), "f8" if i in columns else "U1") for i in range(width)]
    table = np.loadtxt(lines, delimiter=layout.separator, comments=None, dtype=record, ndmin=1)
    return np.column_stack([table[str(i)] for i in columns])


def _fault(path: Path, rows: Rows, layout: Layout, otherwise: str) -> NeurbsError:
    """Find the first row that breaks the table."""
    first = None
    for number, text in rows():
        fields = [field.strip() for field in text.split(layout.separator)]
        first = first or number
        if layout.width is not None and len(fields) != layout.width:
            return _wrong_width(path, number, fields, layout.width, first)
        for column in layout.columns:
            if column >= len(fields):
                return _wrong_width(path, number, fields, max(layout.columns) + 1, first)
            field = fields[column]
            if not is_number(field) or not math.isfinite(float(field)):
                return _wrong_field(path, number, column, field)
    return NeurbsError(f"{path}: must be a table of numbers, but {otherwise}")


def _wrong_width(path: Path, number: int, fields: list[str], width: int, first: int) -> NeurbsError:
    like = f", as line {first} has" if number != first else ""
    got = len(fields)
    if got < width:
        where = f"column {got + 1} is missing after {shown(fields[-1])}"
    else:
        where = f"column {width + 1}, {shown(fields[width])}, is one too many"
    return NeurbsError(f"{path}: line {number} must have {width} columns{like}, got {got}: {where}")


def _wrong_field(path: Path, number: int, column: int, field: str) -> NeurbsError:
    hint = ""
    if is_number(field):
        hint = ": remove or repair the line"
    elif "," in field and is_number(field.replace(",", ".")):
        hint = ": write decimals with a point"
    got = shown(field) if field else "nothing"
    return NeurbsError(
        f"{path}: line {number}, column {column + 1} must be a finite number, got {got}{hint}"
    )
