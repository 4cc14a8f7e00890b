"""Text tables of points: `.xyz`, `.txt`, `.csv`, `.pts` and others."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

from neurbs._core import NeurbsError
from neurbs.io.point_cloud import Block, PointSource, Request, checked_count
from neurbs.io.preamble import data_rows, preamble
from neurbs.io.table import Rows, read_blocks
from neurbs.io.table_columns import Choice, choose, doubts
from neurbs.io.table_header import Header
from neurbs.io.table_layout import Layout, layout_of, split
from neurbs.io.table_sample import SAMPLE, Sample
from neurbs.io.tecplot import is_tecplot, read_tecplot

_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")
"""A number whose comma may separate thousands."""

_PTS_WITH_COLORS, _PTS_COLORS = 7, (4, 5, 6)
"""Width of a `.pts` row x, y, z, intensity, red, green, blue, and the columns of its colors."""

_SIX = {".xyzrgb": "colors", ".xyzn": "normals"}
"""By suffix: the three columns after the coordinates in a table of six."""


def read_text(path: Path, request: Request) -> PointSource:
    """Read a table of points; separator, header and columns are detected.

    The accepted forms are listed in `neurbs.read_points`.
    """
    if is_tecplot(path):
        return read_tecplot(path, request)
    above = preamble(path)
    table = _table(path, request, above.header, above.first)
    attributes = _SIX.get(path.suffix.lower())
    if attributes and table.layout.width == 6 and not (above.header.names or request.columns):
        # The format has no column that numbers the points.
        choice = Choice((0, 1, 2))
        layout = replace(
            table.layout,
            points=choice.points,
            normals=(3, 4, 5) if request.attributes and attributes == "normals" else (),
            colors=(3, 4, 5) if request.attributes and attributes == "colors" else (),
        )
        table = _Table(layout, table.unit, choice.described(above.header))

    def rows() -> Iterator[tuple[int, str]]:
        return islice(data_rows(path), above.rows, None)

    source = table.source(path, rows)
    described = f"{table.described}; the points start in line {above.first[0][0]}"
    source.doubts.extend(doubts(table.described, [above.guess, table.guess]))
    if above.count is not None:
        source = replace(source, blocks=_counted(path, source.blocks, *above.count))
    return replace(source, columns=described)


def _counted(path: Path, blocks: Iterator[Block], count: int, line: int) -> Iterator[Block]:
    """Yield blocks, and compare the number of their points with that in a line above them."""
    got = 0
    for block in blocks:
        got += len(block.points)
        yield block
    if got != count:
        but = "the file is cut short after" if got < count else "there are"
        raise NeurbsError(
            f"{path}: must have {count} points, as in line {line}, but {but} {got}: "
            "remove the line if it is no number of points"
        )


def read_pts(path: Path, request: Request) -> PointSource:
    """Read a `.pts` file of a laser scanner: scans, each after a line with its point count."""

    def rows() -> Iterator[tuple[int, str]]:
        return (row for row in data_rows(path) if not _is_count(row[1]))

    declared = sum(int(text) for _, text in data_rows(path) if _is_count(text))
    first = list(islice(rows(), SAMPLE))
    if not declared or not first:
        return read_text(path, request)
    table = _table(path, request, Header(), first)
    if request.columns is None:
        # The format has no column that numbers the points.
        points = tuple(range(min(3, len(table.layout.split(first[0][1])))))
        table = replace(table, layout=replace(table.layout, points=points))
    if request.attributes and table.layout.width == _PTS_WITH_COLORS:
        table = replace(table, layout=replace(table.layout, colors=_PTS_COLORS))
    return PointSource(checked_count(path, table.source(path, rows).blocks, declared))


def _is_count(text: str) -> bool:
    return text.strip().isdecimal()


@dataclass(frozen=True)
class _Table:
    """The layout and unit of a table, and how its columns were chosen."""

    layout: Layout
    unit: str | None
    described: str
    guess: str | None = None

    def source(self, path: Path, rows: Rows) -> PointSource:
        """Return the points of rows."""
        if self.layout.decimal_comma:
            check_commas(path, rows, self.layout.separator)
        return PointSource(read_blocks(path, rows, self.layout), unit=self.unit)


def _table(path: Path, request: Request, header: Header, first: list[tuple[int, str]]) -> _Table:
    """Detect the layout from the first rows of points."""
    layout = layout_of([text for _, text in first])
    sample = Sample.of(first, layout)
    choice = choose(path, header, sample, request.columns)
    unit = header.unit_of(path, choice.points, request.unit)
    layout = replace(
        layout,
        points=choice.points,
        normals=header.normals if request.attributes else (),
        colors=header.colors if request.attributes else (),
        width=sample.width,
        allow_missing=request.nan == "drop",
    )
    return _Table(layout, unit, choice.described(header), choice.guess)


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
    for number, text in islice(rows(), SAMPLE):
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
