"""Heights on a regular grid as text: grids of ESRI and GDAL, of GRASS, and of Surfer."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.io.point_cloud import BLOCK, Block, PointSource, Request, checked_count
from neurbs.io.reading import check_size
from neurbs.io.table import numbered_lines
from neurbs.io.text import check_commas, read_text

_NO_DATA = -9999.0
"""The no-data value of an ESRI grid whose header has none."""

_SURFER, _SURFER_LINES, _BLANK = "dsaa", 5, 1.70141e38
"""The first line of a grid of Surfer, the lines of its header, and its value without data."""

_NULL = "*"
"""A cell without data in a GRASS grid."""

_FIRST = re.compile(r"\s*(?:ncols|nrows)\s+\S+\s*|\s*(?:north|south|east|west|rows|cols)\s*:.*")
"""The first line of a grid of ESRI or of GRASS."""

_KEYS = {
    "ncols", "nrows", "xllcorner", "yllcorner", "xllcenter", "yllcenter", "cellsize", "dx", "dy",
    "nodata_value", "north", "south", "east", "west", "rows", "cols", "null", "type", "multiplier",
}  # fmt: skip

_ANGLE = re.compile(r"([+-]?\d+(?:\.\d*)?)(?::(\d+(?:\.\d*)?))?(?::(\d+(?:\.\d*)?))?([NSEWnsew]?)")
"""A coordinate of GRASS, which may be degrees, minutes and seconds: ``45:30:00N``."""

_LARGE = 1e30
"""A larger no-data value is the end of single precision, in more or less digits."""


@dataclass(frozen=True)
class _Grid:
    cols: int
    rows: int
    x: float
    y: float
    """The center of the cell in the first column of the last row."""
    dx: float
    dy: float
    no_data: float
    lines: int
    """Lines of the header."""
    factor: float = 1.0


def read_asc(path: Path, request: Request) -> PointSource:
    """Read a grid or a table of points, by the first line of the file."""
    _, first = next(numbered_lines(path), (0, ""))
    first = first.strip().lower()
    if first != _SURFER and not _FIRST.fullmatch(first):
        return read_text(path, request)
    if request.columns is not None:
        raise NeurbsError(f"{path}: columns must be left out for a grid of heights")
    grid = _of_surfer(path) if first == _SURFER else _grid(path)
    check_commas(path, lambda: numbered_lines(path), None)
    # A number takes a character and a separator.
    check_size(path, grid.rows * grid.cols, 2, "cells", -1)

    def blocks() -> Iterator[Block]:
        first = 0
        for values in _values(path, grid.lines, max(BLOCK // grid.cols, 1) * grid.cols):
            i, j = np.divmod(np.arange(first, first + len(values)), grid.cols)
            x, y = grid.x + j * grid.dx, grid.y + (grid.rows - 1 - i) * grid.dy
            points = np.column_stack([x, y, values * grid.factor])
            yield Block(points).only(_has_data(values, grid.no_data))
            first += len(values)

    count = grid.rows * grid.cols
    described = f"a grid of {grid.rows} x {grid.cols} cells: z is their value"
    return PointSource(checked_count(path, blocks(), count), count=count, columns=described)


def read_grd(path: Path, request: Request) -> PointSource:
    """Read a grid of Surfer or another one as text."""
    with path.open("rb") as file:
        if b"\0" in file.read(512):
            raise NeurbsError(
                f"{path}: must be a grid as text, which starts with DSAA or ncols, but is binary: "
                "convert it to .tif, for instance with gdal_translate"
            )
    return read_asc(path, request)


def _has_data(values: NDArray[np.float64], no_data: float) -> NDArray[np.bool_]:
    digits = 1e-6 if abs(no_data) > _LARGE else 0
    missing = np.isclose(values, no_data, rtol=digits, atol=0) | np.isnan(values)
    return np.logical_not(missing)


def _grid(path: Path) -> _Grid:
    """Read the header."""
    entries: dict[str, str] = {}
    lines = 0
    for number, line in numbered_lines(path):
        words = line.replace(":", " ", 1).split()
        if words and (len(words) != 2 or words[0].lower() not in _KEYS):
            break
        if words:
            entries[words[0].lower()] = words[1].replace(",", ".")
            lines = number
    try:
        grid = _of_grass(entries, lines) if "north" in entries else _of_esri(entries, lines)
        numbers = [grid.x, grid.y, grid.dx, grid.dy, grid.factor]
        if grid.cols < 1 or grid.rows < 1 or not np.isfinite(numbers).all():
            raise ValueError
        if grid.dx <= 0 or grid.dy <= 0:
            raise ValueError
    except (KeyError, ValueError):
        keys = (
            "north, south, east, west, rows and cols"
            if {"north", "south", "east", "west"} & entries.keys()
            else "ncols, nrows, xllcorner, yllcorner, cellsize above 0 (or dx and dy) and "
            "nodata_value"
        )
        raise NeurbsError(
            f"{path}: must start with {keys}, a number after each, got {' '.join(entries)}"
        ) from None
    return grid


def _of_esri(entries: dict[str, str], lines: int) -> _Grid:
    dx, dy = (float(entries[n] if n in entries else entries["cellsize"]) for n in ("dx", "dy"))
    x, y = (
        float(entries[f"{axis}llcenter"])
        if f"{axis}llcenter" in entries
        else float(entries[f"{axis}llcorner"]) + size / 2
        for axis, size in zip("xy", (dx, dy), strict=True)
    )
    no_data = float(entries.get("nodata_value", _NO_DATA))
    return _Grid(int(entries["ncols"]), int(entries["nrows"]), x, y, dx, dy, no_data, lines)


def _of_surfer(path: Path) -> _Grid:
    """Read the header of a grid of nodes, whose first row is the lowest."""
    lines = [line.split() for _, line in islice(numbered_lines(path), 1, _SURFER_LINES)]
    try:
        (cols, rows), (low, high), (bottom, top), _ = (tuple(map(float, line)) for line in lines)
        steps = (high - low) / max(cols - 1, 1), (top - bottom) / max(rows - 1, 1)
        if not (cols >= 1 and rows >= 1 and np.isfinite([*steps, low, top]).all()):
            raise ValueError
        if not (cols.is_integer() and rows.is_integer() and high >= low and top >= bottom):
            raise ValueError
    except ValueError:
        raise NeurbsError(
            f"{path}: must start with DSAA, the numbers of columns and rows, and the lowest and "
            "highest x, y and z"
        ) from None
    return _Grid(int(cols), int(rows), low, top, steps[0], -steps[1], _BLANK, _SURFER_LINES)


def _of_grass(entries: dict[str, str], lines: int) -> _Grid:
    north, south, east, west = (
        _coordinate(entries[side]) for side in ("north", "south", "east", "west")
    )
    cols, rows = int(entries["cols"]), int(entries["rows"])
    dx, dy = (east - west) / max(cols, 1), (north - south) / max(rows, 1)
    null = entries.get("null", _NULL)
    return _Grid(
        cols, rows, west + dx / 2, south + dy / 2, dx, dy,
        np.nan if null == _NULL else float(null), lines, float(entries.get("multiplier", 1)),
    )  # fmt: skip


def _coordinate(text: str) -> float:
    match = _ANGLE.fullmatch(text)
    if match is None:
        return float(text)
    degrees, minutes, seconds, side = match.groups()
    value = abs(float(degrees)) + float(minutes or 0) / 60 + float(seconds or 0) / 3600
    return -value if degrees.startswith("-") or side.upper() in ("S", "W") else value


def _values(path: Path, header: int, size: int) -> Iterator[NDArray[np.float64]]:
    """Yield the numbers after the header in arrays of a size; line breaks have no meaning."""
    lines = islice(numbered_lines(path), header, None)
    numbers = chain.from_iterable(
        (_number(path, line, word) for word in text.replace(",", ".").split())
        for line, text in lines
    )
    while len(values := np.fromiter(islice(numbers, size), np.float64)):
        yield values


def _number(path: Path, line: int, word: str) -> float:
    try:
        return np.nan if word == _NULL else float(word)
    except ValueError:
        raise NeurbsError(f"{path}: line {line} must have numbers, got {word!r}") from None
