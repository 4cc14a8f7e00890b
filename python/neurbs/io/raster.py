"""Heights on a regular grid: GeoTIFF, read by rasterio."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from neurbs._core import NeurbsError
from neurbs.extras import require_for_file
from neurbs.io.point_cloud import BLOCK, Block, Doubt, PointSource, Request
from neurbs.io.reading import crs_doubt
from neurbs.io.units import of_heights, symbol


def read_geotiff(path: Path, request: Request) -> PointSource:
    """Read the cells with data; z is the value of the band."""
    rasterio = require_for_file(path, "rasterio")
    windows = require_for_file(path, "rasterio.windows")
    errors = require_for_file(path, "rasterio.errors")
    with _opened(rasterio, path) as file:
        if file.count != 1:
            raise NeurbsError(
                f"{path}: must have one band of heights, got {file.count}: it may be a picture"
            )
        width, height = file.width, file.height
        doubts: list[Doubt] = []
        try:
            unit, crs = _reference(file)
        except errors.CRSError as error:
            unit, crs = None, None
            doubts.append(crs_doubt(error))

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

    return PointSource(blocks(), count=width * height, unit=unit, crs=crs, doubts=doubts)


def _reference(file: Any) -> tuple[str | None, str | None]:
    """Return the unit and the coordinate reference system."""
    crs, z_unit = file.crs, file.units[0]
    unit = symbol(crs.linear_units) if crs and crs.is_projected else None
    unit = "degree" if crs and crs.is_geographic else unit
    if unit and z_unit:
        unit = of_heights(unit, symbol(z_unit))
    return unit, crs.to_string() if crs else None


def _opened(rasterio: Any, path: Path) -> Any:
    """Open a local file with the GeoTIFF driver only.

    Other drivers would open files and web addresses that the file refers to.
    """
    return rasterio.open(path.resolve(strict=True), driver="GTiff")
