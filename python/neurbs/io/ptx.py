"""Leica's `.ptx`: scans as text, each with a matrix that places it in the common frame."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.io.point_cloud import Block, PointSource, Request, checked_count
from neurbs.io.reading import check_size
from neurbs.io.table import numbered_lines, read_blocks, shown
from neurbs.io.table_layout import Layout

_HEADER = (1, 1, 3, 3, 3, 3, 4, 4, 4, 4)
"""Numbers in each line of a header: columns, rows, position and axes of the scanner, matrix."""

_COLORS = {7: (4, 5, 6), 6: (3, 4, 5)}
"""By the width of a row: the columns of its colors, after x, y, z and mostly an intensity."""

_SMALLEST_ROW = 6
"""Fewest bytes of a row."""


def read_ptx(path: Path, request: Request) -> PointSource:
    """Read the points of all scans, in their common frame; points at 0 are not measured."""
    # A scan has rows of one width, but only some scans may have colors.
    colored = request.attributes and all(width in _COLORS for width in _widths(path))

    def blocks() -> Iterator[Block]:
        rows = _rows(path)
        while (head := _header(path, rows)) is not None:
            scan = _scan(path, rows, *head, request, colored=colored)
            yield from checked_count(path, scan, head[0])

    return PointSource(blocks())


def _rows(path: Path) -> Iterator[tuple[int, str]]:
    return ((number, text) for number, text in numbered_lines(path) if text.strip())


def _widths(path: Path) -> Iterator[int]:
    """Yield the number of columns of each scan."""
    rows = _rows(path)
    while (head := _header(path, rows)) is not None:
        first = next(rows, None)
        if first is None:
            return
        yield len(first[1].split())
        for _ in islice(rows, head[0] - 1):
            pass


def _header(path: Path, rows: Iterator[tuple[int, str]]) -> tuple[int, NDArray[np.float64]] | None:
    """Read the header of a scan: its number of points and its matrix; None at the end."""
    lines = list(islice(rows, len(_HEADER)))
    if not lines:
        return None
    words = [text.split() for _, text in lines]
    try:
        numbers = [np.array(each, float) for each in words]
        if [len(each) for each in numbers] != list(_HEADER):
            raise ValueError
        count = int(words[0][0]) * int(words[1][0])
        matrix = np.array(numbers[-4:])
        if count < 1 or not np.isfinite(matrix).all():
            raise ValueError
    except ValueError:
        raise NeurbsError(
            f"{path}: line {lines[0][0]} must start a scan of a PTX file (columns, rows, scanner "
            f"and matrix in {len(_HEADER)} lines), got {shown(lines[0][1].strip())}"
        ) from None
    check_size(path, count, _SMALLEST_ROW, "points")
    # Points are rows: the translation is the last row. Some programs write the transpose.
    if matrix[:3, 3].any() and not matrix[3, :3].any():
        matrix = matrix.T
    return count, matrix


def _scan(
    path: Path,
    rows: Iterator[tuple[int, str]],
    count: int,
    matrix: NDArray[np.float64],
    request: Request,
    *,
    colored: bool,
) -> Iterator[Block]:
    """Yield the measured points of a scan, in the common frame."""
    first = next(rows, None)
    if first is None:
        return
    start, text = first
    width = len(text.split())
    layout = Layout(
        (0, 1, 2),
        colors=_COLORS[width] if colored else (),
        width=width,
        allow_missing=request.nan == "drop",
    )
    passes = iter([(row for part in ([first], islice(rows, count - 1)) for row in part)])

    def rows_of_scan() -> Iterator[tuple[int, str]]:
        """Go on in the file; the second time, to find a fault, from the start of the scan."""
        again = (row for row in _rows(path) if row[0] >= start)
        return next(passes, islice(again, count))

    for block in read_blocks(path, rows_of_scan, layout):
        measured = (block.points != 0).any(axis=1)
        points = block.points @ matrix[:3, :3] + matrix[3, :3]
        yield Block(points, colors=block.colors).only(measured)
