"""Chunks of points as a source that a map can draw from."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs import _core


class Chunks:
    """Chunks of any lengths as a source that gives as many points as it is asked for."""

    def __init__(self, chunks: Iterator[ArrayLike]) -> None:
        self._chunks = chunks
        self._left = np.empty((0, 3))
        self._given = 0

    def __call__(self, count: int) -> NDArray[np.float64]:
        """Return the next `count` points."""
        parts = [self._left]
        missing = count - len(self._left)
        while missing > 0:
            try:
                chunk = _core.as_points(next(self._chunks))
            except StopIteration:
                got = self._given + count - missing
                needed = self._given + count
                raise _core.NeurbsError(
                    f"chunks must hold at least {needed} points for this training, got {got}: "
                    "give more, or lower epochs or max_steps"
                ) from None
            parts.append(chunk)
            missing -= len(chunk)
        points = np.concatenate(parts)
        self._left = points[count:]
        self._given += count
        return points[:count]
