"""Rows of the tables of PLY files, which may contain lists."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neurbs.io.point_cloud import BLOCK
from neurbs.io.reading import damaged

TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8",
    "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "int64": "i8", "uint64": "u8", "float32": "f4", "float64": "f8",
}  # fmt: skip
"""For each type of PLY, by its old and its new name, the type of NumPy."""

_CODES = {
    "i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "i8": "q", "u8": "Q",
    "f4": "f", "f8": "d",
}  # fmt: skip
"""For each type of NumPy the code of `struct`."""


@dataclass
class Element:
    """One table of the file: number of rows, names and types of columns."""

    name: str
    count: int
    properties: list[tuple[str, str]] = field(default_factory=list)
    lists: dict[int, str] = field(default_factory=dict)
    """For each property that is a list, by its number, the type of its length."""

    def columns(self, names: tuple[tuple[str, ...], ...]) -> tuple[int, ...]:
        """Return the indices of columns by one of their names, or () if one is missing."""
        present = [
            "" if i in self.lists else name.lower() for i, (name, _) in enumerate(self.properties)
        ]
        found = [present.index(name) for known in names for name in known if name in present]
        return tuple(found) if len(found) == len(names) else ()

    def scalars(self) -> list[int]:
        """Return the indices of the columns that are no lists."""
        return [i for i in range(len(self.properties)) if i not in self.lists]

    def without_lists(self, words: list[str]) -> list[str]:
        """Return the words of a row of text that are in no list.

        Raises
        ------
        ValueError
            If the length of a list is no number, or the row is shorter.
        """
        kept, place = [], 0
        for i in range(len(self.properties)):
            if i not in self.lists:
                kept += words[place : place + 1]
                place += 1
            else:
                place += 1 + max(int(float("".join(words[place : place + 1]))), 0)
                if place > len(words):
                    raise ValueError
        return kept + words[place:]

    def is_whole(self, words: list[str]) -> bool:
        """Whether a row of text has all its words."""
        place = 0
        for i in range(len(self.properties)):
            if place >= len(words):
                return False
            place += 1 + (int(float(words[place])) if i in self.lists else 0)
        return place <= len(words)

    def row(self, byte_order: str) -> np.dtype[np.void]:
        """Return the type of a row, with columns named by number, because names may repeat."""
        return np.dtype([(str(i), byte_order + t) for i, (_, t) in enumerate(self.properties)])


def text_rows(
    path: Path, element: Element, rows: Iterator[tuple[int, str]]
) -> Iterator[tuple[int, str]]:
    """Yield rows of text without their lists."""
    for number, text in rows:
        try:
            words = element.without_lists(text.split())
        except (ValueError, OverflowError):
            raise damaged(path, f"a list in line {number} is not whole") from None
        yield number, " ".join(words)


def columns(
    path: Path, data: NDArray[np.uint8], start: int, element: Element, byte_order: str
) -> Iterator[dict[int, NDArray[Any]]]:
    """Yield the columns that are no lists, in blocks."""
    for first in range(0, element.count, BLOCK):
        rows = min(BLOCK, element.count - first)
        places, start = _places(path, data, start, rows, element, byte_order)
        found = {}
        for column in element.scalars():
            dtype = np.dtype(byte_order + element.properties[column][1])
            each = places[:, column, None] + np.arange(dtype.itemsize)
            found[column] = data[each].view(dtype)[:, 0]
        yield found


def end_of(
    path: Path, data: NDArray[np.uint8], start: int, element: Element, byte_order: str
) -> int:
    """Return the place after the rows of an element.

    Raises
    ------
    NeurbsError
        If they are cut short.
    """
    if not element.lists:
        end = start + element.count * element.row(byte_order).itemsize
        if end > len(data):
            raise _cut_short(path, element)
        return end
    for first in range(0, element.count, BLOCK):
        rows = min(BLOCK, element.count - first)
        _, start = _places(path, data, start, rows, element, byte_order)
    return start


def _cut_short(path: Path, element: Element) -> Exception:
    return damaged(path, f"it is cut short in the rows of {element.name}")


def _places(
    path: Path,
    data: NDArray[np.uint8],
    start: int,
    rows: int,
    element: Element,
    byte_order: str,
) -> tuple[NDArray[np.int64], int]:
    """Return the place of each field of some rows, and the place after them."""
    kinds = [
        (np.dtype(kind).itemsize, struct.Struct(byte_order + _CODES[length]))
        if (length := element.lists.get(i))
        else (np.dtype(kind).itemsize, None)
        for i, (_, kind) in enumerate(element.properties)
    ]

    def walk(at: int) -> tuple[list[int], int]:
        """Return the places of the fields of a row, and its end."""
        found = []
        for size, length in kinds:
            found.append(at)
            number = 1
            if length is not None:
                if at + length.size > len(data):
                    raise _cut_short(path, element)
                number = int(length.unpack_from(data.data, at)[0])
                at += length.size
            if number < 0 or at + size * number > len(data):
                raise _cut_short(path, element)
            at += size * number
        return found, at

    smallest = sum(size if length is None else length.size for size, length in kinds)
    if start + rows * smallest > len(data):
        raise _cut_short(path, element)
    fields, end = walk(start)
    size = end - start
    # Nearly always all rows have the same size.
    if size > 0 and start + rows * size <= len(data):
        table = data[start : start + rows * size].reshape(rows, size)
        lists = [
            (at - start, length.size)
            for at, (_, length) in zip(fields, kinds, strict=True)
            if length is not None
        ]
        if all((table[:, at : at + n] == table[0, at : at + n]).all() for at, n in lists):
            each = size * np.arange(rows)[:, None]
            return each + np.array(fields, np.int64), start + rows * size
    places = np.empty((rows, len(kinds)), np.int64)
    for row in range(rows):
        places[row], start = walk(start)
    return places, start
