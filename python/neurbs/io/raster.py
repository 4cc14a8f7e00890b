"""Heights on a regular grid: GeoTIFF, read by rasterio, and ESRI's ASCII grids."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain, islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.extras import require_for_file
from neurbs.io.point_cloud import BLOCK, Block, PointSource, Request, checked_count
from neurbs.io.reading import check_size
from neurbs.io.table import numbered_lines
from neurbs.io.text import check_commas, read_text
from neurbs.io.units import of_heights, symbol

_NO_DATA = -9999.0
"""The no-data value of an ESRI grid whose header has none."""

_HEADER_LINES = 6
"""Lines of the header of an ESRI grid; the last may be left out."""


def read_geotiff(path: Path, request: Request) -> PointSource:
    """Read the cells with data; z is the value of the band."""
    rasterio = require_for_file(path, "rasterio")
    windows = require_for_file(path, "rasterio.windows")
    with _opened(rasterio, path) as file:
        if file.count != 1:
            raise NeurbsError(
                f"{path}: must have one band of heights, got {file.count}: it may be a picture"
            )
        width, height, crs, z_unit = file.width, file.height, file.crs, file.units[0]

    def blocks() -> Iterator[Block]:
        with _opened(rasterio, path) as file:
            rows = max(BLOCK // width, 1)
            for row in range(0, height, rows):
                window = windows.Window(0, row, width, min(rows, height - row))
                values = file.read(1, window=window, masked=True)
                i, j = np.indices(values.shape)
                x, y = file.transform @ (j + 0.5, i + row + 0.5)
                z = values.filled(0) * file.scales[0] + file.offsets[0]
                points = np.stack([x, y, z], axis=-1).reshape(-1, 3)
                has_data = ~np.ma.getmaskarray(values).ravel() & ~np.isnan(points[:, 2])
                yield Block(points).only(has_data)

    unit = symbol(crs.linear_units) if crs and crs.is_projected else None
    if unit and z_unit:
        unit = of_heights(unit, symbol(z_unit))
    return PointSource(
        blocks(), count=width * height, unit=unit, crs=crs.to_string() if crs else None
    )


def _opened(rasterio: Any, path: Path) -> Any:
    """Open a local file with the GeoTIFF driver only.

    Other drivers would open files and web addresses that the file refers to.
    """
    return rasterio.open(path.resolve(strict=True), driver="GTiff")


def read_asc(path: Path, request: Request) -> PointSource:
    """Read an ESRI grid or a table of points, by the first line of the file."""
    head = [line for _, line in islice(numbered_lines(path), _HEADER_LINES)]
    if not head or head[0].lower().split()[:1] != ["ncols"]:
        return read_text(path, request)
    pairs = [line.replace(",", ".").split() for line in head]
    entries = {
        pair[0].lower(): pair[1] for pair in pairs if len(pair) == 2 and pair[0][0].isalpha()
    }
    try:
        cols, rows = int(entries["ncols"]), int(entries["nrows"])
        cell = float(entries["cellsize"])
        no_data = float(entries.get("nodata_value", _NO_DATA))
        x, y = (
            float(entries[f"{axis}llcenter"])
            if f"{axis}llcenter" in entries
            else float(entries[f"{axis}llcorner"]) + cell / 2
            for axis in "xy"
        )
        if cols < 1 or rows < 1 or not (cell > 0 and np.isfinite([cell, x, y]).all()):
            raise ValueError
    except (KeyError, ValueError):
        raise NeurbsError(
            f"{path}: must start with ncols, nrows, xllcorner, yllcorner, cellsize "
            f"above 0 and nodata_value, a number after each, got {' '.join(entries)}"
        ) from None
    check_commas(path, lambda: numbered_lines(path), None)
    # A number takes a character and a separator.
    check_size(path, rows * cols, 2, "cells", -1)
    if request.columns is not None:
        raise NeurbsError(f"{path}: columns must be left out for a grid of heights")

    def blocks() -> Iterator[Block]:
        first = 0
        for values in _values(path, len(entries), max(BLOCK // cols, 1) * cols):
            i, j = np.divmod(np.arange(first, first + len(values)), cols)
            points = np.column_stack([x + j * cell, y + (rows - 1 - i) * cell, values])
            yield Block(points).only(values != no_data)
            first += len(values)

    return PointSource(checked_count(path, blocks(), rows * cols), count=rows * cols)


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
        return float(word)
    except ValueError:
        raise NeurbsError(f"{path}: line {line} must have numbers, got {word!r}") from None
