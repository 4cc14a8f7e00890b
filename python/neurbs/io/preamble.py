"""The lines above the points of a text table: titles, names, units and a number of points."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import TypeAlias

from neurbs._core import NeurbsError
from neurbs.io.reading import damaged
from neurbs.io.table import numbered_lines, shown
from neurbs.io.table_header import Header, names_in
from neurbs.io.table_layout import (
    Layout,
    detect_layout,
    is_missing,
    is_number,
    layout_of,
    split,
)
from neurbs.io.table_sample import MAX_ROW, SAMPLE, Sample, check_length

_COMMENT, _COMMENT_LINE = re.compile(r"(?<!\d\.)#|//"), "%!>"
"""The start of a comment, and characters that start a line of comment; not that of ``1.#IND``."""

_HEXADECIMAL = re.compile(r"[+-]?0[xX][0-9a-fA-F.]+(?:[pP][+-]?\d+)?")

_RULER = re.compile(r"[-=_*+|~:\s]*[-=_*~]{3}[-=_*+|~:\s]*")
"""A line of dashes or equals signs."""

_AT_BLANKS = re.compile(r"\s{2,}")
"""Between names that have blanks in them."""

_MOST_LINES = 1000
"""Most lines above the points."""

_KEPT = 50
"""Lines above the points among which the names are sought."""


_Line: TypeAlias = tuple[int, str, str]
"""The number of a line, its text without a comment, and all of it."""


@dataclass(frozen=True)
class Preamble:
    """The lines above the points.

    Attributes
    ----------
    rows : int
        How many of them are neither blank nor comments.
    header : Header
        The names and units of the columns.
    count : (int, int), optional
        A number of points, and its line.
    first : list of (int, str)
        Number and text of the first rows of points.
    guess : str or None
        Why one of the lines may be a point.
    """

    rows: int
    header: Header
    count: tuple[int, int] | None
    first: list[tuple[int, str]]
    guess: str | None = None


def preamble(path: Path) -> Preamble:
    """Find the lines above the points.

    Raises
    ------
    NeurbsError
        If there are no points.
    """
    above: deque[_Line] = deque(maxlen=_KEPT)
    names = _line_of_names(path)
    count: tuple[int, int] | None = None
    rows, skipped = 0, 0
    lines = _with_comments(path)
    first: list[tuple[int, str]] = []
    for number, text, line in lines:
        check_length(number, line)
        if not text:
            above.append((number, text, line))
        elif number <= names or _is_header(text):
            above.append((number, text, line))
            rows, skipped = rows + 1, number
            if rows > _MOST_LINES:
                raise damaged(path, f"no points are in its first {_MOST_LINES:,} lines")
        elif count is None and text.strip().isdecimal():
            count = int(text), number
            rows += 1
        else:
            data = ((n, t) for n, t, _ in lines if t)
            first = [(number, text), *islice(data, SAMPLE)]
            break
    if not first and count is not None:
        # A table of one column has no number of points.
        return Preamble(rows - 1, Header(), None, [(count[1], str(count[0]))])
    if not first:
        but = f"ends after the header in line {skipped}" if skipped else "the file is empty"
        if rows > 1:
            but = f"none of its lines, up to {skipped}, has two columns of numbers"
        raise NeurbsError(f"{path}: must have at least one point, but {but}")
    if count is not None and len(detect_layout(first[0][1]).split(first[0][1])) < 2:
        return Preamble(rows - 1, Header(), None, [(count[1], str(count[0]))])
    header = _header([*above], first)
    if count is not None and (listed := _listed([*above], count, first)).names:
        header, count = listed, None
    return _without_titles(Preamble(rows, header, count, first, _lost([*above], header)))


def _line_of_names(path: Path) -> int:
    """Return the first line that names x, y and z, if no point may be above it; else 0.

    Lines above it may have numbers, such as ``Offset: 0 0 0``, but begin with a word.
    """
    for number, text, _ in islice(_with_comments(path), _KEPT):
        if len(text) > MAX_ROW:
            break
        layout = detect_layout(text)
        fields = layout.split(text)
        if text and _is_header(text) and len(Header.of(fields, number).axes) == 3:
            return number
        if text and is_number(fields[0]) and len(fields) > 1:
            break
    return 0


def _listed(above: list[_Line], count: tuple[int, int], first: list[tuple[int, str]]) -> Header:
    """Return the names of columns that are counted and listed, one in a line, as by GSLIB."""
    number, line = count
    names = [text.strip() for at, text, _ in above if text and at > line]
    widths = {len(detect_layout(text).split(text)) for _, text in first}
    return Header.of(names, line + 1) if widths == {number} == {len(names)} else Header()


def _lost(above: list[_Line], header: Header) -> str | None:
    """Say which line may be a point: one with a number behind the names, or with several above."""
    for number, text, _ in above:
        if not text or not header.line:
            continue
        fields = detect_layout(text).split(text)
        if number < header.line and _is_header(text):
            continue
        if any(is_number(field) for field in fields):
            return f"line {number}, {shown(text.strip())}, is read as a header, not as a point"
    return None


def _without_titles(found: Preamble) -> Preamble:
    """Leave out a first row that is a header: column numbers, or a title with numbers."""
    (line, text), *rest = found.first
    if not rest:
        return found
    layout = layout_of([row for _, row in found.first])
    fields = [field.strip("\"' ") for field in layout.split(text)]
    numbers = fields[1:] if fields[0] == "" else fields
    if not found.header.names and numbers == [str(i) for i in range(len(numbers))]:
        guess = f"line {line}, {shown(text.strip())}, is read as a header, not as a point"
    elif len(rest) > 1 and _is_title([text, rest[0][1], rest[1][1]], layout):
        guess = f"line {line}, {shown(text.strip())}, is read as a title, not as a point"
    else:
        return found
    return replace(found, rows=found.rows + 1, first=rest, guess=guess)


def _is_title(rows: list[str], layout: Layout) -> bool:
    """Whether the first row starts with a word, and has other columns than the next two."""
    kinds = [[_is_numeric(field) for field in layout.split(row)] for row in rows]
    return not kinds[0][0] and kinds[0] != kinds[1] and kinds[1] == kinds[2] and kinds[1][0]


def _header(above: list[_Line], first: list[tuple[int, str]]) -> Header:
    """Find the names and units of the columns in the lines above the points.

    Names of coordinates count anywhere; other names only in a line that is no comment. If several
    lines have names, the last counts.
    """
    layout = layout_of([text for _, text in first])
    sample = Sample.of(first, layout)
    candidates = [
        (_best_split(line, layout.separator, sample), bool(line[1])) for line in reversed(above)
    ]
    fitting = [(found, is_row) for found, is_row in candidates if len(found.names) == sample.width]
    units = next((found for found, _ in fitting if found.is_units), None)
    named = [(found, is_row) for found, is_row in fitting if not found.is_units]
    header = next((found for found, _ in named if found.axes), None)
    header = header or next((found for found, is_row in named if is_row), None)
    header = header or next(
        (found for found, is_row in candidates if is_row and len(found.axes) == 3), None
    )
    if header is None:
        return Header()
    return header if units is None else header.with_units(units)


def _best_split(line: _Line, separator: str | None, sample: Sample) -> Header:
    """Split a line of names as the points are split, or so that there are as many.

    The line counts without its comment first, then without the mark of a comment, then as it is:
    ``# X Y`` and ``Point#,X,Y`` may have a column with the number of the point.
    """
    number, text, whole = line
    splits = [
        _AT_BLANKS.split(each.strip()) if one == "  " else split(names_in(each), one)
        for each in (text, whole.lstrip("#/%!>;* "), whole)
        if each
        for one in (separator, detect_layout(text).separator, ",", ";", "\t", "  ", None)
    ]
    fitted = [Header.of(fields, number) for each in splits if (fields := _fitted(each, sample))]
    fitted += [Header.of(splits[0], number)]
    return next((header for header in fitted if header.axes), fitted[0])


def _fitted(names: list[str], sample: Sample) -> list[str] | None:
    """Return names for all columns of a table, or None if there are more or fewer names.

    Separators at the end count as nothing. R writes no name above a first column of row names.
    """
    while names and not names[-1].strip() and len(names) != sample.width:
        names = names[:-1]
    if len(names) == sample.width:
        return names
    if len(names) == sample.filled:
        return names + [""] * (sample.width - len(names))
    if len(names) == sample.width - 1 and (sample.counts(0) or not sample.is_number[0]):
        shifted = ["", *names]
        return shifted if len(Header.of(shifted, 0).axes) == 3 else None
    return None


def data_rows(path: Path) -> Iterator[tuple[int, str]]:
    """Yield number, from 1, and text of each line that is not blank and not only a comment."""
    for number, line in numbered_lines(path):
        text = line
        if "#" in line or "//" in line or line[0] in _COMMENT_LINE:
            text = _without_comment(line)
        if text.strip():
            yield number, text


def _with_comments(path: Path) -> Iterator[_Line]:
    """Yield each line that is not blank."""
    for number, line in numbered_lines(path):
        if line.strip():
            text = _without_comment(line)
            yield number, text if text.strip() else "", line.strip()


def _without_comment(line: str) -> str:
    return "" if line[0] in _COMMENT_LINE else _COMMENT.split(line, maxsplit=1)[0]


def _is_header(text: str) -> bool:
    """Whether a row has letters and less than two numbers, or is a line of dashes."""
    if _RULER.fullmatch(text):
        return True
    if not any(map(str.isalpha, text)):
        return False
    fields = layout_of([text]).split(text)
    return sum(_is_numeric(field) for field in fields if field) < 2


def _is_numeric(field: str) -> bool:
    """Whether a field is a number, a missing or a hexadecimal one."""
    return is_number(field) or is_missing(field) or _HEXADECIMAL.fullmatch(field) is not None
