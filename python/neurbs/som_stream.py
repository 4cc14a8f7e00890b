"""A stream of points for the training of a map: from a sampler, or from chunks of any lengths."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs import _core
from neurbs.errors import argument_error

Source: TypeAlias = "Callable[[int, np.random.Generator], ArrayLike] | Iterable[ArrayLike]"
"""A callable ``source(count, rng)`` that returns points of shape (count, 3), or chunks."""


class PointStream:
    """Points from a source in portions of any size; it can be restored to a saved state."""

    def __init__(self, source: Source, seed: int) -> None:
        self._rng = np.random.default_rng(seed)
        self._sampler = source if callable(source) else None
        if not callable(source) and not isinstance(source, Iterable):
            raise argument_error(
                "source", f"must be a callable or an iterable of arrays, got {source!r}"
            )
        self._chunks = iter(()) if callable(source) else iter(source)
        self._left = np.empty((0, 3))
        self._given = 0

    def __call__(self, count: int) -> ArrayLike:
        """Return the next `count` points."""
        points = self._next(count) if self._sampler is None else self._sampler(count, self._rng)
        self._given += count
        return points

    @property
    def state(self) -> dict[str, Any]:
        """The state of the stream as values for JSON."""
        return {"given": self._given, "rng": self._rng.bit_generator.state}

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from a state; chunks start from the first one, and used points are skipped."""
        if self._sampler is None:
            self._next(state["given"])
        else:
            self._rng.bit_generator.state = state["rng"]
        self._given = state["given"]

    def _next(self, count: int) -> NDArray[np.float64]:
        parts = [self._left]
        missing = count - len(self._left)
        while missing > 0:
            try:
                chunk = _core.as_points(next(self._chunks))
            except StopIteration:
                needed = self._given + count
                raise _core.NeurbsError(
                    f"chunks must have at least {needed} points for this training, "
                    f"got {needed - missing}: give more, or lower `epochs` or `max_steps`"
                ) from None
            parts.append(chunk)
            missing -= len(chunk)
        points = np.concatenate(parts)
        self._left = points[count:]
        return points[:count]
