"""The even sample of a cloud in parts, with its bounds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurbs import _core
from neurbs.distributed.residuals import Floats


@dataclass(frozen=True)
class Sampled:
    """An even sample of some points, and those with the lowest and highest coordinates.

    Attributes
    ----------
    sample : EvenSample
        The sample.
    extremes : ndarray of shape (6, 3)
        Points with the lowest x, y and z, then with the highest.
    """

    sample: _core.EvenSample
    extremes: Floats

    def __add__(self, other: Sampled) -> Sampled:
        """Return the sample of the points of both."""
        return Sampled(_core.EvenSample.from_bytes(self.sample.to_bytes()), self.extremes).absorb(
            other
        )

    def absorb(self, other: Sampled | Rest) -> Sampled:
        """Return the sample of the points of both, in place of this one."""
        if isinstance(other, Rest):
            self.sample.extend(other.points)
            return Sampled(self.sample, _extremes(np.concatenate([self.extremes, other.points])))
        self.sample.merge(other.sample)
        return Sampled(self.sample, _extremes(np.concatenate([self.extremes, other.extremes])))

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """The lowest and the highest coordinates."""
        return self.extremes.min(axis=0), self.extremes.max(axis=0)

    def points(self) -> Floats:
        """Return the sample, with the extremes, so that the others lie within its bounds."""
        points = self.sample.points
        if self.sample.seen == len(points):
            return points
        rows = {row.tobytes() for row in points}
        others = {row.tobytes(): row for row in self.extremes if row.tobytes() not in rows}
        return np.concatenate([points, *(row[None, :] for row in others.values())])


@dataclass(frozen=True)
class Rest:
    """A chunk behind the first one of its part, whose sample it joins: two samples cost more."""

    points: Floats


def step(most: int, points: Floats, start: int, _own: object) -> Sampled | Rest:
    """Return the sample of a chunk: the task of a worker."""
    if start > 0:
        return Rest(points)
    sample = _core.EvenSample(most)
    sample.extend(points)
    return Sampled(sample, _extremes(points))


def _extremes(points: Floats) -> Floats:
    """Return the points with the lowest and highest coordinates; ties go by the next coordinate."""
    found = []
    for pick in (0, -1):
        for axis in range(3):
            column = points[:, axis]
            rows = points[column == (column.min() if pick == 0 else column.max())]
            order = np.lexsort([rows[:, (axis + k) % 3] for k in (2, 1, 0)])
            found.append(rows[order[pick]])
    return np.array(found)
