"""A check that a `.vtk` file is complete.

VTK's own reader does not check this and returns uninitialized memory for missing data.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from neurbs.io.reading import damaged
from neurbs.io.table import shown

_BYTES = {
    "bit": 1 / 8,
    "unsigned_char": 1,
    "char": 1,
    "unsigned_short": 2,
    "short": 2,
    "unsigned_int": 4,
    "int": 4,
    "unsigned_long": 8,
    "long": 8,
    "vtkidtype": 4,
    "vtktypeint64": 8,
    "vtktypeuint64": 8,
    "float": 4,
    "double": 8,
}
"""Bytes of a value of each type."""

_MAX_LINE = 1 << 16
"""Most bytes of a header line."""

_MAX_DATA_LINE = 1 << 24
"""Most bytes of a line of numbers."""

_CELLS = ("vertices", "lines", "polygons", "triangle_strips", "cells")
_PER_POINT = {
    "vectors": 3,
    "normals": 3,
    "tensors": 9,
    "tensors6": 6,
    "global_ids": 1,
    "pedigree_ids": 1,
}
"""Number of values of an attribute for each point or cell."""


def check_whole(path: Path) -> None:
    """Check that a binary file in VTK's legacy format has all data of its headers.

    Raises
    ------
    NeurbsError
        If the file is cut short.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        version = file.readline(_MAX_LINE)
        file.readline(_MAX_LINE)
        coding = file.readline(_MAX_LINE).strip().upper()
        if coding not in (b"ASCII", b"BINARY"):
            return
        offsets = version.split()[-1:] >= [b"5"]
        for name, count, bytes_each in _arrays(file, offsets=offsets):
            if coding == b"ASCII":
                missing, what = count - _skip_words(file, count), "numbers"
            else:
                length = math.ceil(count * bytes_each)
                missing, what = file.tell() + length - size, "bytes"
                file.seek(max(length, 0), 1)
            if missing > 0:
                raise damaged(path, f"{missing:,} {what} of {name} are missing")


def _skip_words(file: BinaryIO, count: int) -> int:
    """Skip lines with at least so many words, or all; return how many of the words are there."""
    found = 0
    while found < count and (line := file.readline(_MAX_DATA_LINE)):
        found += len(line.split())
    return min(found, count)


def _arrays(file: BinaryIO, *, offsets: bool) -> Iterator[tuple[str, int, float]]:
    """Yield name, number of values and bytes of each of them, with the file at its start.

    The caller skips the array. `offsets` is True if cells are two arrays, as from version 5 on.
    """
    tuples = 0
    cells = (0, 0)
    expected: list[str] = []
    seen: set[str] = set()
    attributes_of = ""
    while words := _words(file):
        key = words[0].lower()
        seen.add(key)
        attributes_of = ""
        try:
            if key == "points":
                yield words[0], 3 * int(words[1]), _BYTES[words[2].lower()]
            elif key.endswith("_coordinates") and key[0] in "xyz":
                yield words[0], int(words[1]), _BYTES[words[2].lower()]
            elif key in _CELLS:
                cells = (int(words[1]), int(words[2]))
                if offsets:
                    expected = ["connectivity", "offsets"]
                else:
                    yield words[0], cells[1], 4
            elif key in ("offsets", "connectivity"):
                expected.remove(key)
                yield words[0], cells[key == "connectivity"], _BYTES[words[1].lower()]
            elif key == "cell_types":
                yield words[0], int(words[1]), 4
            elif key in ("point_data", "cell_data"):
                tuples = int(words[1])
                attributes_of = words[0] if tuples else ""
            elif key == "scalars":
                components = int(words[3]) if len(words) > 3 else 1
                # The next line names a table of colors.
                _words(file)
                yield words[1], tuples * components, _BYTES[words[2].lower()]
            elif key == "lookup_table":
                yield words[1], 4 * int(words[2]), 1
            elif key == "color_scalars":
                yield words[1], tuples * int(words[2]), 1
            elif key == "texture_coordinates":
                yield words[1], tuples * int(words[2]), _BYTES[words[3].lower()]
            elif key in _PER_POINT:
                yield words[1], tuples * _PER_POINT[key], _BYTES[words[2].lower()]
            elif key == "field":
                yield from _fields(file, int(words[2]))
            elif key == "metadata":
                _skip_paragraph(file)
        except (IndexError, KeyError, ValueError):
            # An unknown or damaged section: VTK reports it.
            return
    if expected:
        raise EOFError(f"{expected[-1]} are missing")
    if "cells" in seen and "cell_types" not in seen:
        raise EOFError("cell_types are missing")
    if attributes_of:
        raise EOFError(f"the arrays of {attributes_of} are missing")


def _fields(file: BinaryIO, count: int) -> Iterator[tuple[str, int, float]]:
    while count > 0 and (words := _words(file)):
        if words[0].lower() == "metadata":
            _skip_paragraph(file)
            continue
        yield words[0], int(words[1]) * int(words[2]), _BYTES[words[3].lower()]
        count -= 1
    if count > 0:
        raise EOFError(f"{count} arrays are missing")


def _words(file: BinaryIO) -> list[str]:
    """Return the words of the next line that is not blank; [] at the end of the file."""
    while line := file.readline(_MAX_LINE):
        if words := line.decode("latin-1").split():
            if not line.endswith(b"\n"):
                raise EOFError(f"its last line is cut short: {shown(line.decode('latin-1'))}")
            return words
    return []


def _skip_paragraph(file: BinaryIO) -> None:
    while file.readline(_MAX_LINE).strip():
        pass
