"""Reconstruction of more points than memory holds, chunk by chunk."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs import _core

Floats: TypeAlias = NDArray[np.float64]

MAX_SAMPLE = 1 << 20
"""Most points that a surface is fitted to; of more, an even sample is taken."""

CHUNK = 1 << 18
"""Points in memory at a time, of more than fit in it."""

_BINS = 1 << 12
"""Bins of the histograms for quantiles."""


def is_large_map(points: object) -> bool:
    """Whether points are a memory map with more points than the sample has."""
    return isinstance(points, np.memmap) and points.ndim == 2 and len(points) > MAX_SAMPLE


def spooled(chunks: Iterable[ArrayLike]) -> Floats:
    """Write the points of all chunks to a temporary file and return its memory map."""
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
    """Return points in chunks as one array, which may be a memory map."""
    if not isinstance(points, np.memmap):
        return spooled(points)
    if points.dtype == np.float64 and points.shape[1:] == (3,) and points.flags.c_contiguous:
        return points
    return spooled(points[part] for part in slices(points))


def sampled(points: Floats) -> tuple[Floats, NDArray[np.int64], float]:
    """Return an even sample, its indices, and the diagonal of the bounding box of all points."""
    sample = _core.EvenSample(MAX_SAMPLE)
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for part in slices(points):
        chunk = np.asarray(points[part])
        sample.extend(chunk)
        low, high = np.minimum(low, chunk.min(axis=0)), np.maximum(high, chunk.max(axis=0))
    return sample.points, sample.indices, float(np.linalg.norm(high - low))


def temporary_array(shape: tuple[int, ...], dtype: type) -> NDArray[Any]:
    """Return an array in a temporary file."""
    import tempfile

    with tempfile.TemporaryFile() as file:
        return np.memmap(file, dtype=dtype, mode="w+", shape=shape)


def slices(points: Floats) -> Iterator[slice]:
    """Return slices of an array that fit in memory."""
    for start in range(0, len(points), CHUNK):
        yield slice(start, start + CHUNK)


class Summary:
    """Statistics of the distances of inliers, computed slice by slice."""

    def __init__(self, distances: Floats, inliers: NDArray[np.bool_]) -> None:
        self._distances, self._inliers = distances, inliers
        self.count = sum(map(len, self._parts()))
        squares = sum(float(np.sum(part**2)) for part in self._parts())
        self.rms = float(np.sqrt(squares / self.count))
        self.max = max(float(part.max(initial=0.0)) for part in self._parts())

    def _parts(self) -> Iterator[Floats]:
        for part in slices(self._distances):
            yield np.asarray(self._distances[part])[self._inliers[part]]

    def share_within(self, tolerance: float) -> float:
        """Return the share of distances that are at most `tolerance`."""
        return sum(int((part <= tolerance).sum()) for part in self._parts()) / self.count

    def quantile(self, share: float) -> float:
        """Return a quantile of the distances to 12 digits, by repeated histograms."""
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
    """Return parameters, distances and inliers of all points, given those of the sample."""
    is_sampled = len(sample) < len(points)
    uv = temporary_array((len(points), 2), np.float64)
    distances = temporary_array((len(points),), np.float64)
    inliers = temporary_array((len(points),), np.bool_)
    known = np.zeros(len(points), dtype=bool)
    known[sample] = True
    uv[sample], distances[sample], inliers[sample] = of_sample
    limit = of_sample[1][of_sample[2]].max()
    for part in slices(points):
        others = np.flatnonzero(~known[part]) + part.start
        if len(others):
            projections = surface.closest_points(np.asarray(points[others]))
            uv[others], distances[others] = projections.uv, projections.distances
            inliers[others] = is_sampled & (projections.distances <= limit)
    return uv, distances, inliers
