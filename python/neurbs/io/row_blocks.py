"""Rows of large arrays, a block at a time: Ctrl-C is heard in between."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from neurbs.io.point_cloud import BLOCK


def row_blocks(rows: int) -> Iterator[slice]:
    """Cut so many rows into blocks.

    Examples
    --------
    >>> [(part.start, part.stop) for part in row_blocks(70_000)]
    [(0, 65536), (65536, 70000)]
    """
    return (slice(start, min(start + BLOCK, rows)) for start in range(0, rows, BLOCK))


def write_rows(
    file: BinaryIO, record: np.dtype[np.void], columns: Mapping[str, NDArray[Any]]
) -> None:
    """Write a table of which each row is one `record`; fields without a column are zero."""
    for part in row_blocks(len(next(iter(columns.values())))):
        table = np.zeros(part.stop - part.start, record)
        for name, values in columns.items():
            table[name] = values[part]
        file.write(table.tobytes())


def blocks_of(array: NDArray[Any]) -> Iterator[NDArray[Any]]:
    """Give the rows of an array, a block at a time."""
    return (array[part] for part in row_blocks(len(array)))


def write_blocks(file: BinaryIO, blocks: Iterable[NDArray[Any]], dtype: str) -> None:
    """Write arrays as numbers of this type."""
    for block in blocks:
        file.write(block.astype(dtype).tobytes())


def bounds(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the least and the largest of each coordinate."""
    corners = [(block.min(axis=0), block.max(axis=0)) for block in blocks_of(points)]
    low, high = zip(*corners, strict=True)
    return np.min(low, axis=0), np.max(high, axis=0)
