"""Airborne laser scans: `.las` and `.laz`, read by laspy."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from neurbs._core import NeurbsError
from neurbs.extras import require_for_file
from neurbs.io.point_cloud import BLOCK, Block, PointSource, Request, checked_count
from neurbs.io.units import symbol

_COLORS = ("red", "green", "blue")


def read_las(path: Path, request: Request) -> PointSource:
    """Read the points of all returns."""
    laspy = require_for_file(path, "laspy")
    if request.attributes:
        # Without pyproj, laspy does not read the reference system.
        require_for_file(path, "pyproj")
    damaged = NeurbsError(f"{path}: must be a complete LAS file, but is damaged or cut short")
    try:
        with laspy.open(path) as file:
            header = file.header
            crs = header.parse_crs() if request.attributes else None
    except (laspy.errors.LaspyException, ValueError, EOFError):
        raise damaged from None
    colored = request.attributes and set(_COLORS) <= set(header.point_format.dimension_names)

    def blocks() -> Iterator[Block]:
        try:
            with laspy.open(path) as file:
                for chunk in file.chunk_iterator(BLOCK):
                    points = np.column_stack([chunk.x, chunk.y, chunk.z])
                    colors = np.column_stack([chunk[c] for c in _COLORS]) if colored else None
                    yield Block(points, colors=colors)
        except (laspy.errors.LaspyException, ValueError, EOFError, RuntimeError):
            raise damaged from None

    return PointSource(
        checked_count(path, blocks(), header.point_count),
        count=header.point_count,
        unit=None if crs is None else _unit(crs),
        crs=None if crs is None else crs.to_string(),
        offset=tuple(header.offsets.tolist()) if request.attributes else None,
    )


def _unit(crs: Any) -> str:
    """Return the unit of x and y, and the unit of z if it differs."""
    units = [symbol(axis.unit_name) for axis in crs.axis_info]
    return units[0] if len({units[0], units[-1]}) == 1 else f"{units[0]}, z: {units[-1]}"
