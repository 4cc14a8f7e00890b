"""Rounds over all points of a cloud: each projects them and sums the equations of the next net."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from neurbs import _core
from neurbs.distributed.residuals import Floats, Residuals, Spans, UsualDistances, breaks_of

CLOSED = {
    "height": (False, False),
    "sheet": (False, False),
    "tube": (True, False),
    "torus": (True, True),
}
"""The closed directions of each kind of surface."""

_AFFINE_ERROR = 1e-6
"""Largest error of a height field's base, in its lengths, beyond which it is fitted as a sheet."""


@dataclass(frozen=True)
class BasePlane:
    """The parameters over the base of a height field: an affine function of the points.

    Attributes
    ----------
    linear : ndarray of shape (2, 3)
    offset : ndarray of shape (2,)
    """

    linear: Floats
    offset: Floats

    @classmethod
    def of(cls, surface: _core.NurbsSurface, up: tuple[float, float, float]) -> BasePlane | None:
        """Return the base of a height field; None if its net is not linear over it."""
        direction = np.asarray(up) / np.linalg.norm(up)
        axes = np.linalg.svd(direction[None, :])[2][1:]
        net = surface.control_points
        places = np.stack(
            np.meshgrid(
                *(_averages(*k) for k in zip(surface.knots, surface.degree, strict=True)),
                indexing="ij",
            ),
            axis=-1,
        ).reshape(-1, 2)
        across = net.reshape(-1, 3) @ axes.T
        columns = np.column_stack([across, np.ones(len(across))])
        solution = np.linalg.lstsq(columns, places, rcond=None)[0]
        error = np.abs(columns @ solution - places).max()
        size = max(end - start for start, end in surface.domain)
        if not error <= _AFFINE_ERROR * size:
            return None
        return cls(solution[:2].T @ axes, solution[2])

    def parameters(self, points: Floats) -> Floats:
        """Return the parameters under points."""
        found: Floats = points @ self.linear.T + self.offset
        return found


@dataclass(frozen=True)
class Round:
    """What the tasks of a round need.

    Attributes
    ----------
    surface : NurbsSurface
        The surface onto which points are projected, relative to the origin.
    knots : (ndarray, ndarray) or None
        Knots of the next surface; None if points are only measured.
    usual : UsualDistances
        The distances by which points are weighted.
    closed : (bool, bool)
        Closed directions.
    origin : tuple of float
        A place in the middle of the points. Relative to it, coordinates keep their digits.
    base : BasePlane or None
        For a height field.
    robust : bool
        Whether outliers lose their weight.
    tolerance : float or None
        The tolerance of the reconstruction.
    """

    surface: _core.NurbsSurface
    knots: Spans | None
    usual: UsualDistances
    closed: tuple[bool, bool]
    origin: tuple[float, float, float]
    base: BasePlane | None
    robust: bool
    tolerance: float | None
    breaks: Spans = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Compute the breaks of the surface."""
        object.__setattr__(self, "breaks", breaks_of(self.surface))

    def projected(self, points: Floats) -> tuple[Floats, Floats, Floats]:
        """Return parameters, distances and weights of points relative to the origin."""
        found = self.surface.closest_points(points)
        weights = self.usual.weights(found.distances, found.uv, self.robust)
        return found.uv, found.distances, weights


def moved(surface: _core.NurbsSurface, offset: Floats) -> _core.NurbsSurface:
    """Return a surface that is moved by an offset."""
    net = surface.control_points + offset
    return _core.NurbsSurface(net, surface.weights, degree=surface.degree, knots=surface.knots)


@dataclass(frozen=True)
class RoundSums:
    """The sums of a round over some points.

    Attributes
    ----------
    residuals : Residuals
        The distances from the surface of the round.
    halves : tuple of PartialSums or None
        Equations of the next surface, over two random halves of the points.
    """

    residuals: Residuals
    halves: tuple[_core.PartialSums | None, _core.PartialSums | None]

    def __add__(self, other: RoundSums) -> RoundSums:
        """Return the sums over the points of both."""
        first, second = map(_added, self.halves, other.halves)
        return RoundSums(self.residuals + other.residuals, (first, second))

    def all(self) -> _core.PartialSums | None:
        """Return the equations over all points."""
        return _added(*self.halves)


def step(work: Round, points: Floats, _start: int, _own: object) -> RoundSums:
    """Return the sums of a round over a chunk: the task of a worker."""
    points = points - np.asarray(work.origin)
    uv, distances, weights = work.projected(points)
    residuals = Residuals.of(distances, uv, weights, work.breaks, work.tolerance)
    if work.knots is None:
        return RoundSums(residuals, (None, None))
    used = weights > 0
    if work.base is not None:
        uv = work.base.parameters(points)
        for axis, (start, end) in enumerate(work.surface.domain):
            # The sides of the base go through points, where rounding decides.
            margin = 1e-9 * (end - start)
            used &= (uv[:, axis] >= start - margin) & (uv[:, axis] <= end + margin)
            uv[:, axis] = np.clip(uv[:, axis], start, end)
    first = _first_half(points)
    return RoundSums(
        residuals,
        (
            _equations(work, points, uv, weights, used & first),
            _equations(work, points, uv, weights, used & ~first),
        ),
    )


def _equations(
    work: Round, points: Floats, uv: Floats, weights: Floats, used: NDArray[np.bool_]
) -> _core.PartialSums | None:
    if not used.any():
        return None
    assert work.knots is not None
    return _core.PartialSums.of(
        points[used],
        uv[used],
        work.knots,
        degree=work.surface.degree,
        closed=work.closed,
        weights=weights[used],
    )


def _first_half(points: Floats) -> NDArray[np.bool_]:
    """Return whether points belong to the first half, by a hash: chunks play no role."""
    bits = (np.ascontiguousarray(points) + 0.0).view(np.uint64)
    mixed = bits[:, 0]
    for axis in range(3):
        # SplitMix64, in which overflow is meant.
        mixed = (mixed ^ bits[:, axis]) + np.uint64(0x9E3779B97F4A7C15)
        mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    half: NDArray[np.bool_] = (mixed >> np.uint64(63)) == 0
    return half


def _added(
    first: _core.PartialSums | None, second: _core.PartialSums | None
) -> _core.PartialSums | None:
    if first is None or second is None:
        return second if first is None else first
    return first + second


def _averages(knots: Floats, degree: int) -> Floats:
    """Return the mean of the knots of each control point, at which linear functions have it."""
    count = len(knots) - degree - 1
    return np.array([knots[i + 1 : i + degree + 1].mean() for i in range(count)])
