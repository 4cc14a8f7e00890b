"""How the rows of a text table are split into fields, and how its numbers are written."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from neurbs.io.point_cloud import Block

_FORTRAN = re.compile(r"""(?<![^\s,;"])([+-]?(?:\d+\.\d*|\.\d+))[dD]([+-]?\d+)(?![^\s,;"])""")
"""A number as Fortran writes it in double precision."""

_MISSING = {"", "-", "na", "n/a", "null", "none"}
"""Texts for a missing number, beside ``nan``."""

_OVERFLOW = re.compile(r"\*+|[+-]?1\.#(?:ind|qnan|snan|inf)\d*", re.IGNORECASE)
"""A number that is not finite, as older programs of Fortran and C write it."""

_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?")

_DECIMAL = re.compile(r"[+-]?\d*([.,])\d*(?:[eE][+-]?\d+)?")
"""A number with decimals."""

_GROUPED = re.compile(
    r"[+-]?[1-9]\d{0,2}(?P<mark>[.,'\u2019 \u00a0\u2009\u202f])\d{3}(?:(?P=mark)\d{3})*"
    r"(?:(?P<decimal>[.,])\d*)?"
)
"""A number that may have a mark between thousands."""

_QUOTED = re.compile(r'"[^"]*"')

_MINUS = "\u2212"
"""The sign of Unicode for minus."""


@dataclass(frozen=True)
class Layout:
    """The columns of a table and the way to split its rows.

    Attributes
    ----------
    points : tuple of int
        The columns of the coordinates, from 0.
    normals, colors : tuple of int
        The columns of the normals and colors to read, three or none.
    width : int or None
        The number of columns of each row; None if rows may have additional columns.
    separator : str or None
        The text between two columns; None for any amount of whitespace.
    decimal_comma : bool
        Whether a comma is a decimal point.
    thousands : str
        The mark between thousands, or nothing.
    quoted : bool
        Whether numbers have these marks between quotation marks only.
    tail : int or None
        The column in which a description of any number of words begins, if rows have one.
    allow_missing : bool
        Whether a coordinate may be missing or not finite. Normals and colors always may.
    """

    points: tuple[int, ...]
    normals: tuple[int, ...] = ()
    colors: tuple[int, ...] = ()
    width: int | None = None
    separator: str | None = None
    decimal_comma: bool = False
    thousands: str = ""
    quoted: bool = False
    tail: int | None = None
    allow_missing: bool = False

    @property
    def columns(self) -> tuple[int, ...]:
        """All columns to read, first the coordinates."""
        return self.points + self.normals + self.colors

    @property
    def required(self) -> tuple[int, ...]:
        """The columns with a finite number in each row."""
        return () if self.allow_missing else self.points

    def plain(self, row: str) -> str:
        """Return a row whose numbers have decimal points and no other marks."""
        if self.quoted:
            return _QUOTED.sub(lambda match: self._without_marks(match[0]), row)
        return self._without_marks(row)

    def split(self, text: str) -> list[str]:
        """Split a row into fields, with decimal points; a description is one field."""
        fields = split(self.plain(text), self.separator)
        fields = [without_fortran(field.strip()) for field in fields]
        if self.tail is None or len(fields) < self.tail:
            return fields
        words = fields[self.tail :]
        if len(words) > 1 and is_number(words[0]):
            # Rather a number too many than a description.
            return fields
        return [*fields[: self.tail], " ".join(words)]

    def block(self, values: NDArray[np.float64]) -> Block:
        """Return the columns as points, normals and colors."""
        ends = np.cumsum([len(self.points), len(self.normals)])
        points, normals, colors = np.split(values, ends, axis=1)
        return Block(points, normals if self.normals else None, colors if self.colors else None)

    def _without_marks(self, text: str) -> str:
        if self.thousands:
            text = _before_thousands(self.thousands).sub("", text)
        if self.decimal_comma:
            text = text.replace(",", ".")
        return text.replace(_MINUS, "-")


@cache
def _before_thousands(mark: str) -> re.Pattern[str]:
    return re.compile(rf"(?<=\d){re.escape(mark)}(?=\d{{3}}(?!\d))")


def layout_of(rows: Sequence[str]) -> Layout:
    """Detect the layout of a table by its first rows: the separator by the first, the rest by all.

    A comma or a point between thousands is recognized if a number has both, and none has the mark
    for decimals. Other marks are recognized at once.

    Examples
    --------
    >>> layout_of(["7;1.250,5"]).split("7;1.250,5"), layout_of(["1'250.5 7"]).split("1'250.5 7")
    (['7', '1250.5'], ['1250.5', '7'])
    """
    layout = _with_marks(detect_layout(rows[0]), rows)
    if any(row.count('"') % 2 for row in rows):
        # A text between quotation marks may go on in the next line.
        return layout
    return replace(layout, tail=_tail([layout.split(row) for row in rows]))


def _tail(rows: Sequence[list[str]]) -> int | None:
    """Return the column in which descriptions of different numbers of words begin.

    At least half of the rows have one, and at least half have their last number before it.
    """
    if len(set(map(len, rows))) == 1:
        return None
    numbers = ([i for i, field in enumerate(fields, 1) if is_number(field)] for fields in rows)
    ((column, count),) = Counter(max(places, default=0) for places in numbers).most_common(1)
    described = sum(len(row) > column and not is_number(row[column]) for row in rows)
    return column if column >= 2 and 2 * min(count, described) >= len(rows) else None


def _with_marks(layout: Layout, rows: Sequence[str]) -> Layout:
    """Return the layout with the marks within the numbers of some rows."""
    fields = {field.strip() for row in rows for field in split(row, layout.separator)}
    grouped = {field: match for field in fields if (match := _GROUPED.fullmatch(field))}
    decimals = {
        match[1] for match in map(_DECIMAL.fullmatch, fields - grouped.keys()) if match is not None
    }
    marks = {
        match["mark"]
        for match in grouped.values()
        if match["mark"] not in ".," or match["decimal"] not in (None, match["mark"])
    } - decimals
    # A comma that separates columns can have another meaning between quotation marks only.
    quoted = layout.separator == ","
    if len(marks) == 1:
        (mark,) = marks
        if mark not in ".,":
            return replace(layout, thousands=mark)
        return replace(layout, thousands=mark, decimal_comma=mark == ".", quoted=quoted)
    if quoted and any(map(_DECIMAL_COMMA.fullmatch, fields)):
        return replace(layout, decimal_comma=True, quoted=True)
    return layout


def detect_layout(text: str) -> Layout:
    """Detect the separator of the columns, and whether a comma is a decimal point."""
    if ";" in text:
        return Layout((), separator=";", decimal_comma=True)
    if sum(is_number(field.strip().replace(",", ".")) for field in text.split("|")) > 1:
        return Layout((), separator="|", decimal_comma=True)
    words = text.split()
    with_comma = [word for word in words if "," in word]
    if with_comma and len(words) > 1 and all(map(_has_comma_inside, with_comma)):
        return Layout((), separator="\t" if "\t" in text else None, decimal_comma=True)
    if with_comma:
        return Layout((), separator=",")
    # A tab is whitespace like others, unless it separates fields that contain blanks.
    fields = [field.split() for field in text.split("\t")]
    whole = (len(words) == 1 or (words and not is_number(words[0])) for words in fields)
    separator = "\t" if len(fields) > 1 and all(whole) else None
    return Layout((), separator=separator, decimal_comma=True)


def _has_comma_inside(word: str) -> bool:
    """Whether a word is a number with a decimal comma, or a comma between thousands."""
    grouped = _GROUPED.fullmatch(word)
    marks = "" if grouped is None else f"{grouped['mark']}{grouped['decimal']}"
    return marks in (",.", ".,") or _DECIMAL_COMMA.fullmatch(word) is not None


def is_missing(text: str) -> bool:
    """Whether a text stands for a number that is missing or not finite, beside ``nan``."""
    return text.lower() in _MISSING or _OVERFLOW.fullmatch(text) is not None


def is_number(text: str) -> bool:
    """Whether NumPy reads `text` as a number."""
    try:
        float(text)
    except ValueError:
        return False
    # Python's float also accepts 1_000 and digits of other scripts.
    return text.isascii() and "_" not in text


def without_fortran(text: str) -> str:
    """Replace the exponents of Fortran.

    Examples
    --------
    >>> without_fortran("P1.D 1.0D+03 -.5d0")
    'P1.D 1.0e+03 -.5e0'
    """
    return _FORTRAN.sub(r"\1e\2", text) if "D" in text or "d" in text else text


def split(text: str, separator: str | None) -> list[str]:
    """Split a row into fields; separators between quotation marks are part of a field."""
    if '"' not in text:
        return text.split(separator)
    if separator is None:
        text, separator = " ".join(text.split()), " "
    return next(csv.reader([text.strip()], delimiter=separator, skipinitialspace=True))
