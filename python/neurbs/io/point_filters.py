"""Filters of points while files are read: a box, and one point for each cell."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs._core import NeurbsError
from neurbs.errors import argument_error
from neurbs.io.las import LAS, bounds_of
from neurbs.io.point_cloud import Block

_BITS = 21
"""Bits of a cell's number in each direction: three fill an integer of 64."""


@dataclass(frozen=True)
class PointFilter:
    """The points that are kept.

    Attributes
    ----------
    low, high : tuple of float, optional
        Corners of a box, of two or three coordinates, in the unit of the blocks.
    cell : float, optional
        Side of the cubes of which each keeps its first point, in the same unit.
    """

    low: tuple[float, ...] | None = None
    high: tuple[float, ...] | None = None
    cell: float | None = None

    @classmethod
    def of(cls, bounds: ArrayLike | None, cell: float | None) -> PointFilter:
        """Return the filter for the arguments of `neurbs.read_points`, after a check."""
        if cell is not None and not (isinstance(cell, int | float) and 0 < cell < np.inf):
            raise argument_error("cell", f"must be a number above 0, got {cell!r}")
        if bounds is None:
            return cls(cell=cell)
        try:
            corners = np.array(bounds, np.float64)
        except (TypeError, ValueError):
            corners = np.empty(0)
        if corners.shape in ((4,), (6,)):
            corners = corners.reshape(2, -1)
        if corners.shape not in ((2, 2), (2, 3)) or not (corners[0] <= corners[1]).all():
            raise argument_error(
                "bounds",
                f"must be the lowest and the highest x, y or x, y, z, got {bounds!r}",
            )
        low, high = map(tuple, corners.tolist())
        return cls(low, high, cell)

    def __bool__(self) -> bool:
        """Whether some points may be left out."""
        return self.low is not None or self.cell is not None

    def blocks(self, blocks: Iterator[Block]) -> Iterator[Block]:
        """Yield the blocks with the points that are kept, with none where none are."""
        seen = _Cells(self.cell) if self.cell is not None else None
        for block in blocks:
            if self.low is not None:
                block = block.chosen(self._inside(block.points))
            if seen is not None:
                block = block.chosen(seen.new(block.points))
            yield block

    def may_have_points(self, path: Path) -> bool:
        """Whether points of a file may lie in the box, by the bounds in its header, if it has."""
        if self.low is None or self.high is None or path.suffix.lower() not in LAS:
            return True
        found = bounds_of(path)
        if found is None:
            return True  # The reader reports the damage.
        pairs = zip(self.low, self.high, *found, strict=False)
        return not any(most < low or high < least for low, high, least, most in pairs)

    def _inside(self, points: NDArray[Any]) -> NDArray[np.bool_]:
        assert self.low is not None
        columns = points[:, : len(self.low)]
        inside: NDArray[np.bool_] = np.all((columns >= self.low) & (columns <= self.high), axis=1)
        return inside


@dataclass
class _Cells:
    """The cells that have a point: sorted arrays, each at most half as long as the one before."""

    side: float
    _first: NDArray[np.float64] | None = None
    _runs: list[NDArray[np.int64]] = field(default_factory=list)

    def new(self, points: NDArray[Any]) -> NDArray[np.bool_]:
        """Return the rows that are the first point of their cell, and note their cells."""
        keep = np.zeros(len(points), dtype=bool)
        if not len(points):
            return keep
        numbers, rows = np.unique(self._numbers(points), return_index=True)
        fresh: NDArray[np.bool_] = np.ones(len(numbers), dtype=bool)
        for run in self._runs:
            at = np.searchsorted(run, numbers)
            fresh[run[np.minimum(at, len(run) - 1)] == numbers] = False
        keep[rows[fresh]] = True
        if fresh.any():
            self._runs.append(numbers[fresh])
        while len(self._runs) > 1 and len(self._runs[-2]) < 2 * len(self._runs[-1]):
            last = self._runs.pop()
            self._runs[-1] = np.sort(np.concatenate([self._runs[-1], last]))
        return keep

    def _numbers(self, points: NDArray[Any]) -> NDArray[np.int64]:
        """Return the cell of each point as one integer."""
        cells = np.floor(points / self.side)
        if self._first is None:
            self._first = cells[0].copy()
        cells -= self._first
        half = 1 << (_BITS - 1)
        if not (np.abs(cells) < half).all():
            raise NeurbsError(
                f"cell must be at least 1/{half} of the extent of the points, got {self.side}"
            )
        integers = cells.astype(np.int64) + half
        packed: NDArray[np.int64] = (
            (integers[:, 0] << (2 * _BITS)) | (integers[:, 1] << _BITS) | integers[:, 2]
        )
        return packed
