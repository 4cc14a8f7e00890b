"""Clouds of the Point Cloud Library: `.pcd` as text, binary and compressed.

The format is a header and a table. It is read here because no library reads it in blocks; only
the decompression uses one.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, BinaryIO, TypeAlias

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.extras import require_for_file
from neurbs.io.point_cloud import BLOCK, Block, PointSource, Request, checked_count
from neurbs.io.reading import check_size
from neurbs.io.table import numbered_lines, read_blocks, shown
from neurbs.io.table_layout import Layout

_KINDS = {"I": "i", "U": "u", "F": "f"}
_AXES = ("x", "y", "z")
_NORMALS = ("normal_x", "normal_y", "normal_z")
_PACKED = ("rgb", "rgba")
"""Fields with red, green and blue in the bytes of one number."""

_Fields: TypeAlias = dict[str, NDArray[Any]]
"""The first number of each field, for a block of points."""

_MOST_SHRUNK = 100
"""Most bytes of points for each compressed byte; three bytes are at most 264."""

_MAX_LINE = 1 << 16
"""Most bytes of a header line; a file with a longer one is no PCD file."""


@dataclass(frozen=True)
class _Header:
    names: list[str]
    types: list[np.dtype[Any]]
    """The NumPy type of each field, which may have several numbers."""
    points: int
    encoding: str
    size: int
    """Bytes of the header."""
    lines: int

    def missing(self, columns: tuple[str, ...]) -> bool:
        """Whether one of these fields is missing."""
        return not set(columns) <= set(self.names)


def read_pcd(path: Path, request: Request) -> PointSource:
    """Read the measured points; the others are NaN."""
    with path.open("rb") as file:
        header = _read_header(path, file)
    if header.missing(_AXES):
        raise NeurbsError(f"{path}: must have fields x, y and z, got {' '.join(header.names)}")
    if header.encoding == "binary_compressed":
        lzf = require_for_file(path, "lzf")
    tables = {
        "ascii": lambda: _ascii(path, header),
        "binary": lambda: _binary(path, header),
        "binary_compressed": lambda: _compressed(path, header, lzf),
    }[header.encoding]()
    blocks = checked_count(path, _measured(header, tables, request), header.points)
    return PointSource(blocks, count=header.points)


def _measured(header: _Header, tables: Iterator[_Fields], request: Request) -> Iterator[Block]:
    """Yield blocks of points without those that are not measured."""
    for fields in tables:
        points = np.column_stack([fields[axis] for axis in _AXES])
        normals = colors = None
        if request.attributes and not header.missing(_NORMALS):
            normals = np.column_stack([fields[name] for name in _NORMALS])
        packed = next((name for name in _PACKED if name in header.names), None)
        if request.attributes and packed is not None:
            colors = _unpacked(fields[packed])
        yield Block(points, normals, colors).only(~np.isnan(points).any(axis=1))


def _unpacked(column: NDArray[Any]) -> NDArray[np.uint8]:
    """Return red, green and blue from the bytes of numbers, which are often typed as floats."""
    each = np.ascontiguousarray(column).view("u1").reshape(len(column), -1)
    return each[:, 2::-1]


def _read_header(path: Path, file: BinaryIO) -> _Header:
    """Read the header, which ends with the line `DATA`."""
    entries: dict[str, list[str]] = {}
    lines = 0
    while raw := file.readline(_MAX_LINE):
        lines += 1
        key, *values = raw.decode(errors="replace").partition("#")[0].split() or [""]
        entries[key.upper()] = values
        if key.upper() == "DATA":
            break
    try:
        names = [name.lower() for name in entries.get("FIELDS") or entries["COLUMNS"]]
        counts = entries.get("COUNT", ["1"] * len(names))
        types = [
            np.dtype((f"<{_KINDS[kind]}{int(size)}", (int(count),)))
            for kind, size, count in zip(entries["TYPE"], entries["SIZE"], counts, strict=True)
        ]
        if "POINTS" in entries:
            (points,) = map(int, entries["POINTS"])
        else:
            points = int(entries["WIDTH"][0]) * int(entries["HEIGHT"][0])
        (encoding,) = entries["DATA"]
        if len(types) != len(names) or points < 0 or not all(t.shape[0] for t in types):
            raise ValueError
        if encoding not in ("ascii", "binary", "binary_compressed"):
            raise ValueError
    except (KeyError, ValueError, TypeError, IndexError):
        raise NeurbsError(
            f"{path}: must start with a PCD header of FIELDS, SIZE, TYPE, POINTS and DATA, "
            f"but it ends in line {lines} with {shown(' '.join(entries))}"
        ) from None
    header = _Header(names, types, points, encoding, file.tell(), lines)
    size = sum(dtype.itemsize for dtype in types)
    # Other tables are compared with the number of points when they are read.
    compressed = encoding == "binary_compressed"
    check_size(path, points, size / _MOST_SHRUNK if compressed else 1, "points")
    return header


def _ascii(path: Path, header: _Header) -> Iterator[_Fields]:
    def rows() -> Iterator[tuple[int, str]]:
        body = islice(numbered_lines(path), header.lines, None)
        yield from islice((row for row in body if row[1].strip()), header.points)

    starts = np.cumsum([0, *(dtype.shape[0] for dtype in header.types)]).tolist()
    layout = Layout(tuple(starts[:-1]), width=starts[-1], allow_missing=True)
    for block in read_blocks(path, rows, layout):
        yield {
            name: block.points[:, i].astype(dtype.base)
            for i, (name, dtype) in enumerate(zip(header.names, header.types, strict=True))
        }


def _binary(path: Path, header: _Header) -> Iterator[_Fields]:
    # Fields are named by number, because names may repeat: '_' is padding.
    record = np.dtype([(str(i), dtype) for i, dtype in enumerate(header.types)])
    with path.open("rb") as file:
        file.seek(header.size)
        for start in range(0, header.points, BLOCK):
            table = np.fromfile(file, record, min(BLOCK, header.points - start))
            if not len(table):
                return
            yield {name: table[str(i)][:, 0] for i, name in enumerate(header.names)}


def _compressed(path: Path, header: _Header, lzf: Any) -> Iterator[_Fields]:
    """Decompress the whole table, which is stored field by field."""
    if not header.points:
        return
    with path.open("rb") as file:
        file.seek(header.size)
        sizes = np.fromfile(file, "<u4", 2)
        packed = file.read(int(sizes[0])) if len(sizes) == 2 else b""
    expected = header.points * sum(dtype.itemsize for dtype in header.types)
    data = None
    if len(sizes) == 2 and len(packed) == sizes[0] and sizes[1] == expected:
        with suppress(ValueError):
            data = lzf.decompress(packed, expected)
    if data is None or len(data) != expected:
        raise NeurbsError(
            f"{path}: must have {header.points} compressed points, as its header says, "
            "but is damaged or cut short"
        )
    fields, start = {}, 0
    for name, dtype in zip(header.names, header.types, strict=True):
        fields[name] = np.frombuffer(data, dtype, header.points, start)[:, 0]
        start += header.points * dtype.itemsize
    for first in range(0, header.points, BLOCK):
        yield {name: column[first : first + BLOCK] for name, column in fields.items()}
