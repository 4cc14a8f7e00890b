"""Reconstruction of more points than memory holds, chunk by chunk."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs import _core

Floats: TypeAlias = NDArray[np.float64]

MOST = 1 << 20
"""A surface is fitted to this many points at most, evenly over space."""

_CHUNK = 1 << 18
"""Points that are read at a time from a memory map."""

_BINS = 1 << 12
"""Bins of a histogram that quantiles are found in."""


def is_large_map(points: object) -> bool:
    """Say whether points are a memory map of more than a surface is fitted to."""
    return isinstance(points, np.memmap) and points.ndim == 2 and len(points) > MOST


def spooled(chunks: Iterable[ArrayLike]) -> Floats:
    """Return the points of all chunks, as a map of a file that goes with the process."""
    import tempfile

    count = 0
    with tempfile.TemporaryFile() as file:
        for chunk in chunks:
            points = _core.as_points(chunk)
            file.write(points.data)
            count += len(points)
        file.flush()
        if count == 0:
            return np.empty((0, 3))
        return np.memmap(file, dtype=np.float64, mode="r", shape=(count, 3))


def mapped(points: Any) -> Floats:
    """Return points that come in chunks as one array, which need not be in memory."""
    if not isinstance(points, np.memmap):
        return spooled(points)
    if points.dtype == np.float64 and points.shape[1:] == (3,) and points.flags.c_contiguous:
        return points
    return spooled(points[part] for part in slices(points))


def sampled(points: Floats) -> tuple[Floats, NDArray[np.int64], float]:
    """Return those points that a surface is fitted to, their places, and the box's diagonal."""
    sample = _core.EvenSample(MOST)
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for part in slices(points):
        chunk = np.asarray(points[part])
        sample.extend(chunk)
        low, high = np.minimum(low, chunk.min(axis=0)), np.maximum(high, chunk.max(axis=0))
    return sample.points, sample.indices, float(np.linalg.norm(high - low))


def scratch(shape: tuple[int, ...], dtype: type) -> NDArray[Any]:
    """Make an array in a file that has no name and goes with the process."""
    import tempfile

    with tempfile.TemporaryFile() as file:
        return np.memmap(file, dtype=dtype, mode="w+", shape=shape)


def slices(points: Floats) -> Iterator[slice]:
    """Cut an array into pieces that memory holds."""
    for start in range(0, len(points), _CHUNK):
        yield slice(start, start + _CHUNK)


class Summary:
    """What can be said of the distances that count, piece by piece."""

    def __init__(self, distances: Floats, counted: NDArray[np.bool_]) -> None:
        self._distances, self._counted = distances, counted
        self.count = sum(map(len, self._parts()))
        squares = sum(float(np.sum(part**2)) for part in self._parts())
        self.rms = float(np.sqrt(squares / self.count))
        self.max = max(float(part.max(initial=0.0)) for part in self._parts())

    def _parts(self) -> Iterator[Floats]:
        for part in slices(self._distances):
            yield np.asarray(self._distances[part])[self._counted[part]]

    def share_within(self, tolerance: float) -> float:
        """Return the share of those that do not exceed a tolerance."""
        return sum(int((part <= tolerance).sum()) for part in self._parts()) / self.count

    def quantile(self, share: float) -> float:
        """Return the least distance that this share does not exceed, bin by bin, to 12 digits."""
        rank = int(np.ceil(share * self.count))
        low, high = 0.0, self.max
        while high - low > 1e-12 * high:
            edges = np.linspace(low, high, _BINS + 1)
            counts = np.zeros(_BINS, dtype=np.int64)
            below = 0
            for part in self._parts():
                counts += np.histogram(part, edges)[0]
                below += int((part < low).sum())
            at = min(int(np.searchsorted(below + np.cumsum(counts), rank)), _BINS - 1)
            if (edges[at], edges[at + 1]) == (low, high):
                break
            low, high = float(edges[at]), float(edges[at + 1])
        return high


def measured(
    surface: _core.NurbsSurface,
    points: Floats,
    sample: NDArray[np.int64],
    of_sample: tuple[Floats, Floats, NDArray[np.bool_]],
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Return parameters, distances and inliers of all points; those of the sample are known."""
    thinned = len(sample) < len(points)
    uv = scratch((len(points), 2), np.float64)
    distances = scratch((len(points),), np.float64)
    inliers = scratch((len(points),), np.bool_)
    known = np.zeros(len(points), dtype=bool)
    known[sample] = True
    uv[sample], distances[sample], inliers[sample] = of_sample
    limit = of_sample[1][of_sample[2]].max()
    for part in slices(points):
        others = np.flatnonzero(~known[part]) + part.start
        if len(others):
            feet = surface.closest_points(np.asarray(points[others]))
            uv[others], distances[others] = feet.uv, feet.distances
            inliers[others] = thinned & (feet.distances <= limit)
    return uv, distances, inliers
