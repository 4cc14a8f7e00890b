"""Terrestrial laser scans: `.e57`, read by pye57."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.extras import require_for_file
from neurbs.io.point_cloud import BLOCK, Block, PointSource, Request
from neurbs.io.reading import check_size, damaged

_HEADER = struct.Struct("<24xQQQ")
"""Place and length of the XML, and bytes of a page."""

_PAGE, _CHECKSUM = 1024, 4
"""Bytes of a page, the only size of the standard, and of the checksum at its end."""

_START, _ENCODING = (
    re.compile(rb"(?:\xef\xbb\xbf)?\s*<[?!\w]"),
    re.compile(rb"""(?:\xef\xbb\xbf)?\s*<\?xml[^>]*?encoding\s*=\s*["']([^"']*)"""),
)

_CARTESIAN = ("cartesianX", "cartesianY", "cartesianZ")
_SPHERICAL = ("sphericalRange", "sphericalAzimuth", "sphericalElevation")
_COLORS = ("colorRed", "colorGreen", "colorBlue")

_MOST_COLOR = 65535
"""Largest range of a color: 16 bits."""


def read_e57(path: Path, request: Request) -> PointSource:
    """Read the points of all scans, in their common frame."""
    pye57 = require_for_file(path, "pye57")
    _check_xml(path)
    with closing(pye57.E57(str(path))) as file:
        headers = [file.get_header(i) for i in range(file.scan_count)]
        fields = [set(header.point_fields) for header in headers]
        count = sum(header.point_count for header in headers)
        crs = _text(file, "coordinateMetadata")
    for scan, present in enumerate(fields):
        if not (set(_CARTESIAN) <= present or set(_SPHERICAL) <= present):
            raise NeurbsError(
                f"{path}: scan {scan} must have cartesian or spherical coordinates, "
                f"got {', '.join(sorted(present))}"
            )
    colored = request.attributes and all(set(_COLORS) <= present for present in fields)

    def blocks() -> Iterator[Block]:
        with closing(pye57.E57(str(path))) as file:
            for scan in range(file.scan_count):
                yield from _scan(path, file, scan, colored=colored)

    # The unit of the E57 standard is the meter.
    return PointSource(blocks(), count=count, unit="m", crs=crs or None)


def _check_xml(path: Path) -> None:
    """Check that the XML of a file names no other files, which the library would read.

    The file consists of pages, each with a checksum at its end.
    """
    with path.open("rb") as file:
        head = file.read(_HEADER.size)
        if len(head) < _HEADER.size:
            raise damaged(path, "it is shorter than its header")
        start, length, page = _HEADER.unpack(head)
        if page != _PAGE:
            raise damaged(path, f"its pages must have {_PAGE} bytes, got {page}")
        check_size(path, length, 1, "bytes of XML", start)
        file.seek(start - start % _PAGE)
        content = file.read((start % _PAGE + length) // (_PAGE - _CHECKSUM) * _PAGE + 2 * _PAGE)
    pages = (content[i : i + _PAGE - _CHECKSUM] for i in range(0, len(content), _PAGE))
    xml = b"".join(pages)[start % _PAGE :][:length]
    encoding = _ENCODING.match(xml)
    if not _START.match(xml) or (encoding and encoding[1].lower() != b"utf-8"):
        raise damaged(path, "its XML must be UTF-8")
    if b"<!DOCTYPE" in xml:
        raise damaged(path, "its XML must have no document type, which can name other files")


def _text(file: Any, name: str) -> str:
    return str(file.root[name].value()) if file.root.isDefined(name) else ""


def _scan(path: Path, file: Any, scan: int, *, colored: bool) -> Iterator[Block]:
    header = file.get_header(scan)
    if not header.point_count:
        return
    present = header.point_fields
    cartesian = set(_CARTESIAN) <= set(present)
    axes = _CARTESIAN if cartesian else _SPHERICAL
    invalid = "cartesianInvalidState" if cartesian else "sphericalInvalidState"
    names = [*axes, *([invalid] if invalid in present else [])]
    data, buffers = file.make_buffers(names, min(BLOCK, header.point_count))
    if colored:
        # The buffers of the library for colors have 8 bits.
        data |= {name: np.empty(min(BLOCK, header.point_count)) for name in _COLORS}
        for name in _COLORS:
            buffers.append(_buffer(path, file, name, data[name]))
    ranges = [_range(path, header, name) for name in _COLORS] if colored else []
    rotation, translation = header.rotation_matrix, header.translation
    with closing(header.points.reader(buffers)) as reader:
        while count := reader.read():
            points = np.column_stack([data[name][:count] for name in axes])
            if not cartesian:
                points = _from_spherical(points)
            colors = None
            if colored:
                columns = zip(_COLORS, ranges, strict=True)
                colors = np.column_stack([_bytes(data[c][:count], *ends) for c, ends in columns])
            block = Block(points @ rotation.T + translation, colors=colors)
            yield block.only(data[invalid][:count] == 0) if invalid in data else block


def _buffer(path: Path, file: Any, name: str, array: NDArray[np.float64]) -> Any:
    """Return a buffer of the library that fills an array, whatever type the field has."""
    library = require_for_file(path, "pye57.libe57")
    return library.SourceDestBuffer(file.image_file, name, array, len(array), True, True)


def _range(path: Path, header: Any, name: str) -> tuple[float, float]:
    """Return the least and the largest value of a color: by its limits, else by its type."""
    ends = [f"{name}Minimum", f"{name}Maximum"]
    limits = header["colorLimits"] if header.node.isDefined("colorLimits") else None
    if limits is not None and all(map(limits.isDefined, ends)):
        low, high = (float(limits[end].value()) for end in ends)
    else:
        library = require_for_file(path, "pye57.libe57")
        field = library.StructureNode(header.points.prototype())[name]
        scaled = hasattr(field, "scaledMaximum")
        # A field without bounds has those of 64 bits, or of a real number.
        low = float(field.scaledMinimum() if scaled else field.minimum())
        high = float(field.scaledMaximum() if scaled else field.maximum())
    return (low, high) if 0 < high - low <= _MOST_COLOR else (0, 255)


def _bytes(values: NDArray[np.float64], low: float, high: float) -> NDArray[np.uint8]:
    scaled = (values - low) * (255 / (high - low))
    as_bytes: NDArray[np.uint8] = scaled.round().clip(0, 255).astype(np.uint8)
    return as_bytes


def _from_spherical(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Convert range, azimuth and elevation to x, y and z."""
    distance, azimuth, elevation = points.T
    flat = distance * np.cos(elevation)
    return np.column_stack(
        [flat * np.cos(azimuth), flat * np.sin(azimuth), distance * np.sin(elevation)]
    )
