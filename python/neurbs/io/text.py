"""Text tables of points: `.xyz`, `.txt`, `.csv`, `.pts`, `.asc`."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

from neurbs._core import NeurbsError
from neurbs.io.point_cloud import PointSource, Request, checked_count
from neurbs.io.table import Layout, Rows, is_number, numbered_lines, read_blocks, shown, split
from neurbs.io.table_header import Header

_COMMENT = re.compile("#|//")

_HEXADECIMAL = re.compile(r"[+-]?0[xX][0-9a-fA-F.]+(?:[pP][+-]?\d+)?")

_THOUSANDS, _COMMA_ROWS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}"), 1000
"""A number whose comma may separate thousands, and how many rows are searched for another."""

_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?")

_PTS_WITH_COLORS, _PTS_COLORS = 7, (4, 5, 6)
"""Width of a `.pts` row x, y, z, intensity, red, green, blue, and the columns of its colors."""


def read_text(path: Path, request: Request) -> PointSource:
    """Read a table of points; separator, header and columns are detected.

    The accepted forms are listed in `neurbs.read_points`.
    """
    table = _table(path, request)

    def rows() -> Iterator[tuple[int, str]]:
        return islice(data_rows(path), 1 if table.has_header else 0, None)

    return table.source(path, rows)


def read_pts(path: Path, request: Request) -> PointSource:
    """Read a `.pts` file of a laser scanner: scans, each after a line with its point count."""

    def rows() -> Iterator[tuple[int, str]]:
        return (row for row in data_rows(path) if not _is_count(row[1]))

    declared = sum(int(text) for _, text in data_rows(path) if _is_count(text))
    first = next(rows(), None)
    if not declared or first is None:
        return read_text(path, request)
    table = _table_of(path, request, Header(), *first)
    if request.attributes and table.layout.width == _PTS_WITH_COLORS:
        table = replace(table, layout=replace(table.layout, colors=_PTS_COLORS))
    return PointSource(checked_count(path, table.source(path, rows).blocks, declared))


def _is_count(text: str) -> bool:
    return text.strip().isdecimal()


def data_rows(path: Path) -> Iterator[tuple[int, str]]:
    """Yield number, from 1, and text of each line that is not blank and not only a comment."""
    for number, line in numbered_lines(path):
        text = line
        if "#" in line or "//" in line:
            text = _COMMENT.split(line, maxsplit=1)[0]
        if text.strip():
            yield number, text


def _comment_above(path: Path, line: int) -> str:
    """Return the last comment above a line, where some programs name the columns."""
    comment = ""
    for _, text in islice(numbered_lines(path), line - 1):
        comment = text.strip() or comment
    return comment.lstrip("#/ ")


@dataclass(frozen=True)
class _Table:
    """The layout, header and unit of a file."""

    layout: Layout
    has_header: bool = False
    unit: str | None = None

    def source(self, path: Path, rows: Rows) -> PointSource:
        """Return the points of rows."""
        if self.layout.decimal_comma:
            check_commas(path, rows, self.layout.separator)
        return PointSource(read_blocks(path, rows, self.layout), unit=self.unit)


def _table(path: Path, request: Request) -> _Table:
    """Detect the table from the first lines of a file."""
    rows = data_rows(path)
    number, text = next(rows, (0, ""))
    if not text:
        raise NeurbsError(f"{path}: must have at least one point, but the file is empty")
    if not _is_header(text):
        layout = _detect_layout(text)
        named = Header.of(split(_comment_above(path, number), layout.separator), number)
        # The comment counts as a header only if it names the columns.
        fits = named.has_axes and len(named.names) == len(layout.split(text))
        return _table_of(path, request, named if fits else Header(), number, text)
    header_number, names = number, text
    number, text = next(rows, (0, ""))
    if not text:
        raise NeurbsError(
            f"{path}: must have at least one point, "
            f"but ends after the header in line {header_number}"
        )
    header = Header.of(split(names, _detect_layout(text).separator), header_number)
    return replace(_table_of(path, request, header, number, text), has_header=True)


def _table_of(path: Path, request: Request, header: Header, number: int, text: str) -> _Table:
    """Detect the layout from the first row of points."""
    layout = _detect_layout(text)
    fields = layout.split(text)
    if len(fields) < 2:
        raise NeurbsError(
            f"{path}: line {number} must have columns x, y and z (or x and y), "
            f"got column 1 only, {shown(text.strip())}: "
            "separate columns by whitespace, comma, semicolon or tab"
        )
    if request.columns is not None:
        points = header.chosen(path, request.columns, len(fields))
    else:
        points = header.coordinates(path, number, len(fields)) or _leading_numbers(fields)
    header.check_units(path, points)
    layout = replace(
        layout,
        points=points,
        normals=header.normals if request.attributes else (),
        colors=header.colors if request.attributes else (),
        width=len(fields),
        allow_missing=request.nan == "drop",
    )
    return _Table(layout, unit=header.unit_of(points))


def check_commas(path: Path, rows: Rows, separator: str | None) -> None:
    """Raise if commas may separate thousands as well as decimals.

    Parameters
    ----------
    path : Path
        The file, for the message.
    rows : callable
        Returns an iterator over number and text of each row.
    separator : str or None
        What separates fields; None for whitespace.

    Raises
    ------
    NeurbsError
        If no field has a comma that can only be a decimal one.
    """
    first = None
    for number, text in islice(rows(), _COMMA_ROWS):
        for field in split(text, separator):
            if "," in field and not _THOUSANDS.fullmatch(field.strip()):
                return
            if "," in field and first is None:
                first = number, field.strip()
    if first is not None:
        number, field = first
        raise NeurbsError(
            f"{path}: line {number} has {field}, which may be {field.replace(',', '.')} or "
            f"{field.replace(',', '')}: write numbers with a decimal point and without separators"
        )


def _leading_numbers(fields: list[str]) -> tuple[int, ...]:
    """Return the first three columns after a column with a point's name, if there is one."""
    start = next((i for i, field in enumerate(fields) if is_number(field)), 0)
    if len(fields) - start < 3:
        start = 0
    return tuple(range(start, min(start + 3, len(fields))))


def _is_header(text: str) -> bool:
    """Whether a row has names and no number."""
    fields = _detect_layout(text).split(text)
    return any(map(str.isalpha, text)) and not any(
        is_number(field) or _HEXADECIMAL.fullmatch(field) for field in fields
    )


def _detect_layout(text: str) -> Layout:
    """Detect the separator of the columns, and whether a comma is a decimal point."""
    if ";" in text:
        return Layout((), separator=";", decimal_comma=True)
    with_comma = [word for word in text.split() if "," in word]
    if with_comma and all(map(_DECIMAL_COMMA.fullmatch, with_comma)) and len(text.split()) > 1:
        return Layout((), separator="\t" if "\t" in text else None, decimal_comma=True)
    if with_comma:
        return Layout((), separator=",")
    # A tab is whitespace like others, unless it separates fields that contain blanks.
    fields = [field.split() for field in text.split("\t")]
    whole = (len(words) == 1 or (words and not is_number(words[0])) for words in fields)
    separator = "\t" if len(fields) > 1 and all(whole) else None
    return Layout((), separator=separator, decimal_comma=True)
