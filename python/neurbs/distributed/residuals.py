"""Mergeable sums over distances from a surface: deviations, and where the surface misses points."""

from __future__ import annotations

import functools
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from neurbs import _core

Floats: TypeAlias = NDArray[np.float64]
Spans: TypeAlias = "tuple[Floats, Floats]"

_SHIFT = 42
"""Bits of a number that a bin of the histogram ignores: bins are 1/1024 of an octave wide."""

_NEGLIGIBLE = 1e-9
"""Weight below which a point has none."""

_FEW = 8
"""Points below which a usual distance says nothing."""


@dataclass(frozen=True)
class Histogram:
    """Numbers of distances in bins whose width is at most 1/1024 of their value.

    Sums of histograms are exact: they do not depend on the parts.

    Attributes
    ----------
    bins : ndarray of shape (k,)
        Numbers of the bins that are not empty, ascending.
    counts : ndarray of shape (k,)
        Distances in each.
    """

    bins: NDArray[np.int64]
    counts: NDArray[np.int64]

    @classmethod
    def of(cls, distances: Floats) -> Histogram:
        """Count distances."""
        # The bits of positive numbers are in the order of the numbers.
        bins = np.abs(np.asarray(distances, np.float64)).view(np.int64) >> _SHIFT
        return cls(*np.unique(bins, return_counts=True))

    def __add__(self, other: Histogram) -> Histogram:
        """Return the histogram of the distances of both."""
        bins, places = np.unique(np.concatenate([self.bins, other.bins]), return_inverse=True)
        counts = np.zeros(len(bins), np.int64)
        np.add.at(counts, places, np.concatenate([self.counts, other.counts]))
        return Histogram(bins, counts)

    @property
    def count(self) -> int:
        """Number of distances."""
        return int(self.counts.sum())

    def bounded_rms(self, limit: float) -> float:
        """Return the rms of the distances, within 0.1 %; those beyond a limit count as it."""
        edges = np.stack([self.bins, self.bins + 1]) << _SHIFT
        middles = np.minimum(edges.view(np.float64).mean(axis=0), limit)
        return float(np.sqrt(np.sum(self.counts * middles**2) / max(self.count, 1)))

    def quantile(self, share: float) -> float:
        """Return a quantile, within 0.1 %; 0 without distances."""
        if not self.count:
            return 0.0
        ends = np.cumsum(self.counts)
        rank = share * ends[-1]
        at = min(int(np.searchsorted(ends, rank)), len(ends) - 1)
        edges = np.array([self.bins[at], self.bins[at] + 1], np.int64) << _SHIFT
        low, high = edges.view(np.float64)
        # A distance that moves to the next bin then changes little.
        inside = (rank - (ends[at] - self.counts[at])) / self.counts[at]
        return float(low + inside * (high - low))


@dataclass(frozen=True)
class UsualDistances:
    """The usual distances from a surface: of all points, and in each cell between its knots.

    Attributes
    ----------
    median : float
        The median distance of all points.
    breaks : (ndarray, ndarray)
        The knots in u and v without repetitions.
    roots : ndarray of shape (n_u, n_v)
        Sum of the square roots of the distances in each cell.
    counts : ndarray of shape (n_u, n_v)
        Points in each cell.
    limit : float
        Distance from which on a point counts as an outlier where weights are not robust.
    """

    median: float
    breaks: Spans
    roots: Floats
    counts: NDArray[np.int64]
    limit: float = np.inf

    @functools.cached_property
    def of_cells(self) -> Floats:
        """The usual distance of each cell, and of more cells around it where points are few.

        It is the square of the mean root, on which few outliers have little influence.
        """
        roots, counts = self.roots, self.counts
        usual = np.zeros(roots.shape)
        missing = np.ones(roots.shape, dtype=bool)
        shape, size = roots.shape, 1
        while True:
            rows, cols = np.ix_(np.arange(shape[0]) // size, np.arange(shape[1]) // size)
            found = missing & (counts[rows, cols] >= _FEW)
            usual[found] = ((roots / np.maximum(counts, 1)) ** 2)[rows, cols][found]
            missing &= ~found
            if not missing.any() or counts.size == 1:
                return usual
            roots, counts, size = _halved(roots), _halved(counts), 2 * size

    def around(self, uv: Floats) -> Floats:
        """Return the usual distance around parameters."""
        found: Floats = self.of_cells[places_of(self.breaks, uv)]
        return found

    def weights(self, distances: Floats, uv: Floats, robust: bool) -> Floats:
        """Return the weights of points at these distances and parameters."""
        if not robust:
            return (distances <= self.limit).astype(np.float64)
        weights = _core.robust_weights(distances, self.around(uv), self.median)
        return np.where(weights < _NEGLIGIBLE, 0.0, weights)


@dataclass(frozen=True)
class Residuals:
    """Sums over the distances of points from a surface.

    Attributes
    ----------
    count, inliers : int
        Number of points, and of those with weight.
    weights, squares : float
        Sum of the weights, and of the weighted squared distances.
    max : float
        Largest distance of an inlier.
    within : int
        Inliers within the tolerance.
    of_inliers, of_all : Histogram
        Distances of the inliers, and of all points.
    spans : (ndarray, ndarray)
        For each span in u and v, the sum of the weighted squared distances of points that are not
        within the tolerance.
    roots, counts : ndarray of shape (n_u, n_v)
        As in `UsualDistances`.
    """

    count: int
    inliers: int
    weights: float
    squares: float
    max: float
    within: int
    of_inliers: Histogram
    of_all: Histogram
    spans: Spans = field(repr=False)
    roots: Floats = field(repr=False)
    counts: NDArray[np.int64] = field(repr=False)

    @classmethod
    def of(
        cls, distances: Floats, uv: Floats, weights: Floats, breaks: Spans, tolerance: float | None
    ) -> Residuals:
        """Sum the residuals of some points."""
        used = weights > 0
        inliers = distances[used]
        limit = 0.0 if tolerance is None else tolerance
        missed = np.where(distances > limit, weights * distances**2, 0.0)
        rows, cols = places_of(breaks, uv)
        shape = (len(breaks[0]) - 1, len(breaks[1]) - 1)
        cells = rows * shape[1] + cols
        size = shape[0] * shape[1]
        return cls(
            len(distances),
            int(used.sum()),
            float(weights.sum()),
            float(np.sum(weights * distances**2)),
            float(inliers.max(initial=0.0)),
            int(np.sum(inliers <= limit)),
            Histogram.of(inliers),
            Histogram.of(distances),
            (_sums(rows, missed, shape[0]), _sums(cols, missed, shape[1])),
            _sums(cells, np.sqrt(distances), size).reshape(shape),
            np.bincount(cells, minlength=size).reshape(shape),
        )

    def __add__(self, other: Residuals) -> Residuals:
        """Return the sums over the points of both."""
        return Residuals(
            self.count + other.count,
            self.inliers + other.inliers,
            self.weights + other.weights,
            self.squares + other.squares,
            max(self.max, other.max),
            self.within + other.within,
            self.of_inliers + other.of_inliers,
            self.of_all + other.of_all,
            (self.spans[0] + other.spans[0], self.spans[1] + other.spans[1]),
            self.roots + other.roots,
            self.counts + other.counts,
        )

    @property
    def rms(self) -> float:
        """Root of the weighted mean of the squared distances."""
        return float(np.sqrt(self.squares / self.weights)) if self.weights else 0.0

    def usual(self, breaks: Spans, limit: float = np.inf) -> UsualDistances:
        """Return the usual distances from the surface, whose knots are `breaks`."""
        return UsualDistances(self.of_all.quantile(0.5), breaks, self.roots, self.counts, limit)


def breaks_of(surface: _core.NurbsSurface) -> Spans:
    """Return the knots of a surface within its domain, in u and v, without repetitions."""
    found = []
    for knots, (start, end) in zip(surface.knots, surface.domain, strict=True):
        distinct = np.unique(knots)
        found.append(distinct[(distinct >= start) & (distinct <= end)])
    return found[0], found[1]


def places_of(breaks: Spans, uv: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the span of each parameter in u and v."""
    rows, cols = (
        np.clip(np.searchsorted(of, uv[:, axis], "right") - 1, 0, len(of) - 2)
        for axis, of in enumerate(breaks)
    )
    return rows, cols


def _halved(values: NDArray[Any]) -> NDArray[Any]:
    """Return the sums of two by two cells; the last row and column may stand alone."""
    for axis in (0, 1):
        starts = np.arange(0, values.shape[axis], 2)
        values = np.add.reduceat(values, starts, axis=axis)
    return values


def _sums(places: NDArray[np.int64], values: Floats, size: int) -> Floats:
    """Return the sum of the values at each place; without values the counts would be integers."""
    return np.bincount(places, values, size).astype(np.float64)
