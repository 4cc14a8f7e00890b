"""Files of points that are read one after the other, as one."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.io.packed import STANDARD_INPUT, name_of
from neurbs.io.point_cloud import Block, PointSource, Request
from neurbs.io.point_filters import PointFilter
from neurbs.io.point_formats import opened
from neurbs.io.reading import check_file


@dataclass
class ReadFile:
    """A file of points that is open or has been read.

    Attributes
    ----------
    name : str
        Its name, for messages.
    source : PointSource
        What its header says.
    points, no_data, not_finite : int
        Numbers of points up to now: finite ones, before filters; marked as not measured; others.
    """

    name: str
    source: PointSource
    points: int = 0
    no_data: int = 0
    not_finite: int = 0

    def finite(self, request: Request) -> Iterator[Block]:
        """Yield blocks of finite points in space, and count them.

        Raises
        ------
        NeurbsError
            If points are not finite, unless they are dropped, or there are none.
        """
        first = 0
        for block in self.source.blocks:
            points = block.points
            if points.shape[1] == 2:
                flat = np.zeros((len(points), 1))
                block = replace(block, points=np.column_stack([points, flat]))
            finite = np.isfinite(points).all(axis=1)
            if not finite.all():
                if request.nan != "drop":
                    index = int(finite.argmin())
                    raise NeurbsError(
                        f"{self.name}: points must be finite, but point {first + index} (counted "
                        f"from 0) is {tuple(points[index].tolist())}: remove or repair it, or use "
                        '`nan="drop"`'
                    )
                block = block.finite(finite)
            first += len(points)
            self.points += len(block.points) + block.left_out
            self.no_data += block.dropped
            self.not_finite += block.not_finite
            yield block
        self._check_any()

    def _check_any(self) -> None:
        if not self.points:
            reasons = {"are not finite": self.not_finite, "have no data": self.no_data}
            causes = [f"{count} {reason}" for reason, count in reasons.items() if count]
            but = f"all {' and '.join(causes)}" if causes else "it is empty"
            raise NeurbsError(f"{self.name}: must have at least one point, but {but}")


class PointFiles:
    """Files of points that are read one after the other, through filters.

    Parameters
    ----------
    paths : sequence of str or path-like
        The files, at least one.
    request : Request
        How each is read.
    kept : PointFilter
        Which points are kept.

    Attributes
    ----------
    request : Request
        How each is read.
    read : list of ReadFile
        The files that are open or have been read. Those without points in the box, by their
        headers, are not opened.
    """

    def __init__(
        self, paths: Sequence[str | os.PathLike[str]], request: Request, kept: PointFilter
    ) -> None:
        self.request = request
        self._kept = kept
        self._rest = iter(paths)
        self.read: list[ReadFile] = []
        # Opened now, so that errors of the first file come from this call, not from its blocks.
        self._next = self._open_next()

    @property
    def unit(self) -> str | None:
        """The unit of the files that have been opened; None if it is unknown."""
        units = (file.source.unit for file in self.read)
        return next((unit for unit in units if unit is not None), None)

    @property
    def count(self) -> int:
        """Largest number of points of the first file by its header; 0 if unknown or filtered."""
        return self.read[0].source.count if self.read and not self._kept else 0

    def blocks(self) -> Iterator[Block]:
        """Yield the blocks of all files, once.

        Raises
        ------
        NeurbsError
            If a file cannot be read or has no points, or units differ.
        """
        return self._kept.blocks(self._all())

    def chunks(self, size: int) -> Iterator[NDArray[np.float64]]:
        """Yield the points of all files in arrays of a size; the last may be smaller.

        Raises
        ------
        NeurbsError
            As for `blocks`.
        """
        chunk, filled = np.empty((size, 3)), 0
        for block in self.blocks():
            rest = block.points
            while len(rest):
                part = rest[: size - filled]
                chunk[filled : filled + len(part)] = part
                filled, rest = filled + len(part), rest[len(part) :]
                if filled == size:
                    yield chunk
                    chunk, filled = np.empty((size, 3)), 0
        if filled:
            yield chunk[:filled]

    def _all(self) -> Iterator[Block]:
        while self._next is not None:
            yield from self._next.finite(self.request)
            self._next = self._open_next()

    def _open_next(self) -> ReadFile | None:
        """Open the next file that may have points, None behind the last."""
        for path in self._rest:
            if not self._may_have_points(path):
                continue
            file = ReadFile(name_of(path), opened(path, self.request))
            unit, known = file.source.unit, self.unit
            if unit is not None and known is not None and unit != known:
                raise NeurbsError(
                    f"{file.name}: files must have one unit, got {known!r} before and {unit!r} "
                    "here: give `unit`, to which they are converted"
                )
            self.read.append(file)
            return file
        return None

    def _may_have_points(self, path: str | os.PathLike[str]) -> bool:
        # The header has the unit of the file, the box that of the result.
        if os.fspath(path) == STANDARD_INPUT or self.request.unit is not None:
            return True
        check_file(Path(path), "points")
        return self._kept.may_have_points(Path(path))
