"""Large arrays in blocks of rows: Ctrl-C is handled between two blocks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from neurbs.io.point_cloud import BLOCK


def row_blocks(rows: int) -> Iterator[slice]:
    """Return the slices of a number of rows, one for each block.

    Examples
    --------
    >>> [(part.start, part.stop) for part in row_blocks(70_000)]
    [(0, 65536), (65536, 70000)]
    """
    return (slice(start, min(start + BLOCK, rows)) for start in range(0, rows, BLOCK))


def write_rows(
    file: BinaryIO, record: np.dtype[np.void], columns: Mapping[str, NDArray[Any]]
) -> None:
    """Write a table whose rows are of type `record`; fields without a column are 0."""
    for part in row_blocks(len(next(iter(columns.values())))):
        table = np.zeros(part.stop - part.start, record)
        for name, values in columns.items():
            table[name] = values[part]
        file.write(table.tobytes())


def blocks_of(array: NDArray[Any]) -> Iterator[NDArray[Any]]:
    """Yield the rows of an array in blocks."""
    return (array[part] for part in row_blocks(len(array)))


def write_blocks(file: BinaryIO, blocks: Iterable[NDArray[Any]], dtype: str) -> None:
    """Write arrays as numbers of a type."""
    for block in blocks:
        file.write(block.astype(dtype).tobytes())


def bounds(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the smallest and the largest value of each coordinate."""
    corners = [(block.min(axis=0), block.max(axis=0)) for block in blocks_of(points)]
    low, high = zip(*corners, strict=True)
    return np.min(low, axis=0), np.max(high, axis=0)
