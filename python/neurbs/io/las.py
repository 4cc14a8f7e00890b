"""Airborne laser scans: `.las` and `.laz`, read by laspy."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from neurbs.extras import require_for_file
from neurbs.io.point_cloud import BLOCK, Block, Doubt, PointSource, Request, checked_count
from neurbs.io.reading import check_size, crs_doubt, damaged
from neurbs.io.units import of_heights, symbol

_OLD_HEADER, _HEADER, _RECORD, _EXTENDED_RECORD = 227, 375, 54, 60
"""Bytes of a header before and from version 1.4, and fewest bytes of a record and of a long one."""

_COMPRESSED = 0x80
"""Bit of the point format that marks compressed points."""

_COLORS = ("red", "green", "blue")

LAS = (".las", ".laz")
"""Suffixes of files with classes of points, and with bounds in the header."""

_BOUNDS = struct.Struct("<6d")
"""The bounds in a header: the highest and the lowest x, then y and z."""

_BOUNDS_START = 179
"""The place of the bounds in a header."""

Corner: TypeAlias = "tuple[float, float, float]"


def read_las(path: Path, request: Request) -> PointSource:
    """Read the points of all returns, or those of some classes."""
    laspy = require_for_file(path, "laspy")
    _check_header(path)
    if request.needs_reference:
        # Without pyproj, laspy does not read the reference system.
        require_for_file(path, "pyproj")
    with laspy.open(path) as file:
        header = file.header
    doubts: list[Doubt] = []
    unit = crs = None
    if request.needs_reference:
        try:
            unit, crs = _reference(header)
        except MemoryError:
            raise
        except Exception as error:  # Of laspy, of pyproj or of PROJ: the points can be read.
            doubts.append(crs_doubt(error))
    colored = request.attributes and set(_COLORS) <= set(header.point_format.dimension_names)

    def blocks() -> Iterator[Block]:
        if not header.point_count:
            return
        with laspy.open(path) as file:
            for chunk in file.chunk_iterator(BLOCK):
                points = np.column_stack([chunk.x, chunk.y, chunk.z])
                colors = np.column_stack([chunk[c] for c in _COLORS]) if colored else None
                block = Block(points, colors=colors)
                if request.las_classes is not None:
                    wanted = np.isin(np.asarray(chunk.classification), request.las_classes)
                    block = block.chosen(wanted)
                yield block

    return PointSource(
        checked_count(path, blocks(), header.point_count),
        count=header.point_count,
        unit=unit,
        crs=crs,
        offset=tuple(header.offsets.tolist()) if request.attributes else None,
        doubts=doubts,
    )


def bounds_of(path: Path) -> tuple[Corner, Corner] | None:
    """Return the lowest and the highest coordinates by the header; None if it is damaged."""
    with path.open("rb") as file:
        head = file.read(_BOUNDS_START + _BOUNDS.size)
    if len(head) < _BOUNDS_START + _BOUNDS.size or not head.startswith(b"LASF"):
        return None
    high_x, low_x, high_y, low_y, high_z, low_z = _BOUNDS.unpack_from(head, _BOUNDS_START)
    return (low_x, low_y, low_z), (high_x, high_y, high_z)


def _check_header(path: Path) -> None:
    """Compare the numbers of records and points with the size of the file.

    The library would read as many records as the header says.
    """
    with path.open("rb") as file:
        head = file.read(_HEADER)
    if len(head) < _OLD_HEADER:
        raise damaged(path, "it is shorter than its header")
    size, start, records, layout, length, count = struct.unpack_from("<HIIBHI", head, 94)
    check_size(path, records, _RECORD, "records", size)
    if head[25] >= 4 and len(head) == _HEADER:
        extended, records, count = struct.unpack_from("<QIQ", head, 235)
        check_size(path, records, _EXTENDED_RECORD, "extended records", records and extended)
    if not layout & _COMPRESSED:
        check_size(path, count, length, "points", start)


def _reference(header: Any) -> tuple[str | None, str | None]:
    """Return the unit of x and y, with that of z if it differs, and the reference system."""
    crs = header.parse_crs()
    if crs is None:
        return None, None
    units = [symbol(axis.unit_name) for axis in crs.axis_info]
    if not units:
        return None, crs.to_string()
    return of_heights(units[0], units[-1]), crs.to_string()
