"""Rows of text to columns of numbers, with errors that name line and column.

NumPy reads the rows. Only after it fails are the rows checked one by one, to find the line and the
column at fault.
"""

from __future__ import annotations

import codecs
import math
from collections.abc import Callable, Iterator
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, TextIO, TypeAlias

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.io.point_cloud import BLOCK, Block
from neurbs.io.reading import damaged
from neurbs.io.table_layout import Layout, is_missing, is_number, without_fortran

Rows: TypeAlias = Callable[[], Iterator[tuple[int, str]]]
"""Returns an iterator over the rows of a file, each with its line number from 1."""

_MAX_LINE = 1 << 24
"""Most characters of a line."""

_MAX_SHOWN = 40
"""Most characters of a file's text in an error message."""


def open_text(path: Path) -> TextIO:
    """Open a text file in UTF-8, UTF-16 or an encoding with the same ASCII characters.

    Bytes that are not UTF-8, as in names in Latin-1, become replacement characters.
    """
    with path.open("rb") as file:
        wide = file.read(2) in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
    return path.open(encoding="utf-16" if wide else "utf-8-sig", errors="replace")


def numbered_lines(path: Path) -> Iterator[tuple[int, str]]:
    """Yield number, from 1, and text of each line of a text file.

    Raises
    ------
    NeurbsError
        If a line is too long for a file of text.
    """
    with open_text(path) as file:
        for number, line in enumerate(iter(partial(file.readline, _MAX_LINE), ""), start=1):
            if len(line) == _MAX_LINE:
                raise damaged(path, f"line {number} has more than {_MAX_LINE:,} characters")
            yield number, line


def shown(text: str) -> str:
    """Quote text of a file for an error message."""
    return repr(text if len(text) <= _MAX_SHOWN else text[: _MAX_SHOWN - 1] + "…")


def read_blocks(path: Path, rows: Rows, layout: Layout) -> Iterator[Block]:
    """Read the points of a table in blocks.

    Parameters
    ----------
    path : Path
        The file, for error messages.
    rows : Rows
        The rows of the file.
    layout : Layout
        The columns to read.

    Yields
    ------
    Block
        The float64 numbers that are nearest to the texts.

    Raises
    ------
    NeurbsError
        If a row has a wrong number of columns, or a required field is not a finite number.
    """
    walk = rows()
    required = len(layout.required)
    while lines := [text for _, text in islice(walk, BLOCK)]:
        try:
            if layout.tail is None:
                values = _load(list(map(layout.plain, lines)), layout)
            else:
                values = _load_described(lines, layout)
        except ValueError as error:
            raise _fault(path, rows, layout, str(error)) from None
        if not np.isfinite(values[:, :required]).all():
            raise _fault(path, rows, layout, "a number is not finite")
        yield layout.block(values)


def _load(lines: list[str], layout: Layout) -> NDArray[np.float64]:
    options: dict[str, Any] = {
        "delimiter": layout.separator,
        "comments": None,
        "quotechar": '"',
        "encoding": None,
    }
    width, columns = layout.width, layout.columns
    if width is None or columns == tuple(range(width)):
        options |= {"usecols": columns if width is None else None, "ndmin": 2}
    else:
        # `usecols` would accept rows of different widths. Therefore the other columns, which may
        # be text, are read as one character each.
        record = [(str(i), "f8" if i in columns else "U1") for i in range(width)]
        options |= {"dtype": record, "ndmin": 1}
    try:
        try:
            table = np.loadtxt(lines, **options)
        except ValueError:
            lines = list(map(without_fortran, lines))
            table = np.loadtxt(lines, **options)
    except ValueError:
        optional = set(columns) - set(layout.required)
        if not optional:
            raise
        options["converters"] = dict.fromkeys(optional, _number_or_nan)
        table = np.loadtxt(lines, **options)
    if table.dtype.names is None:
        return table
    return np.column_stack([table[str(i)] for i in columns])


def _load_described(lines: list[str], layout: Layout) -> NDArray[np.float64]:
    """Convert rows with descriptions, which NumPy cannot split."""
    rows = list(map(layout.split, lines))
    if any(len(fields) != layout.width for fields in rows):
        raise ValueError("rows have different numbers of columns")
    required = set(layout.required)
    values = [
        [float(row[i]) if i in required else _number_or_nan(row[i]) for i in layout.columns]
        for row in rows
    ]
    if not all(is_number(row[i]) for row in rows for i in required):
        raise ValueError("a field is no number")
    return np.array(values)


def _number_or_nan(text: str) -> float:
    text = text.strip()
    return math.nan if is_missing(text) else float(text)


def _fault(path: Path, rows: Rows, layout: Layout, reason: str) -> NeurbsError:
    """Return the error for the first wrong row."""
    first = None
    for number, text in rows():
        fields = layout.split(text)
        first = first or number
        if layout.width is not None and len(fields) != layout.width:
            return _wrong_width(path, number, fields, layout.width, first)
        for column in layout.columns:
            if column >= len(fields):
                return _wrong_width(path, number, fields, max(layout.columns) + 1, first)
            field = fields[column]
            if column in layout.required:
                good = is_number(field) and math.isfinite(float(field))
            else:
                good = is_number(field) or is_missing(field)
            if not good:
                return _wrong_field(path, number, column, field)
    return NeurbsError(f"{path}: must be a table of numbers, but {reason}")


def _wrong_width(path: Path, number: int, fields: list[str], width: int, first: int) -> NeurbsError:
    like = f", as in line {first}" if number != first else ""
    got = len(fields)
    if got < width:
        where = f"column {got + 1} is missing after {shown(fields[-1])}"
    else:
        where = f"column {width + 1}, {shown(fields[width])}, is one too many"
    return NeurbsError(f"{path}: line {number} must have {width} columns{like}, got {got}: {where}")


def _wrong_field(path: Path, number: int, column: int, field: str) -> NeurbsError:
    hint = ""
    if is_number(field) or is_missing(field):
        hint = ': remove or repair the line, or leave it out with `nan="drop"`'
    elif field.replace("_", "").isalpha():
        hint = ": choose the coordinates with `columns`"
    got = shown(field) if field else "nothing"
    return NeurbsError(
        f"{path}: line {number}, column {column + 1} must be a finite number, got {got}{hint}"
    )
