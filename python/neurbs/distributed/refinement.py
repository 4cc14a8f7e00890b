"""Refinement of a surface over all points: rounds on the workers, solutions on the client."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from neurbs import _core
from neurbs.distributed import memory
from neurbs.distributed.engine import Engine, Outcome
from neurbs.distributed.parts import Parts
from neurbs.distributed.residuals import Residuals, Spans, UsualDistances
from neurbs.distributed.rounds import Round, RoundSums, step

_MAX_ROUNDS = 16
"""Passes over the points, at most."""

_MIN_DECREASE = 0.01
"""Relative decrease of the rms, by the equations, below which a net is not solved again."""

_MAX_ERROR_RATIO = 0.95
"""Ratio of the expected squared errors of a finer net and of the net before, at most, as in one
process."""

_POINTS_PER_CONTROL_POINT = 3
"""Points for each control point, at least, as in one process."""

_DECADES = 6
"""Steps of the search for the fairness in each direction, at most; each is a factor of ten."""

_ERROR_RATIO = 1.01
"""Ratio of the error to the least error, at most, for a larger fairness to be preferred, as in one
process."""


@dataclass(frozen=True)
class RoundReport:
    """A round over all points.

    Attributes
    ----------
    grid : (int, int)
        Rows and columns of the net whose equations were summed; that of the surface, if points were
        only measured.
    rms, max : float
        Deviations of the inliers from the surface before the round, in the points' unit.
    inliers : int
        Points with weight.
    bytes : int
        Size of the results of all parts.
    seconds : float
        Wall time, with the solution.
    """

    grid: tuple[int, int]
    rms: float
    max: float
    inliers: int
    bytes: int
    seconds: float


@dataclass
class Refinement:
    """The refinement of a surface over all points.

    Attributes
    ----------
    engine, parts
        Where and over what it runs.
    work : Round
        The next round.
    fairness : float
        Weight of the fairness energy.
    chooses_fairness : bool
        Whether cross-validation between two halves of the points chooses it.
    axis_scale : tuple of float
        Divisors of the coordinates, for the lengths of the domain.
    most : int
        Most control points of a net that grows; 0 if its size is given.
    is_valid : callable
        Whether a surface may replace the one before.
    """

    engine: Engine
    parts: Parts
    work: Round
    fairness: float
    chooses_fairness: bool
    axis_scale: tuple[float, float, float]
    most: int
    is_valid: Callable[[_core.NurbsSurface], bool]
    clock: Callable[[], float]
    rounds: list[RoundReport] = field(default_factory=list)
    moved: int = 0
    solutions: int = 0
    ended_by: str = "grid"
    worker_seconds: dict[str, float] = field(default_factory=dict)

    def run(self) -> tuple[_core.NurbsSurface, Residuals, UsualDistances]:
        """Run rounds until more of them gain nothing.

        Returns
        -------
        (NurbsSurface, Residuals, UsualDistances)
            The best surface, relative to the origin; the deviations of all points from it; and the
            distances by which they were weighted.
        """
        # The sample is nearer to its own surface than the other points are.
        measured = self._round(None).residuals
        self.work = replace(self.work, usual=self._usual(measured))
        is_rational = self.work.surface.weights is not None
        outcome = self._round(None if is_rational else self.work.surface.knots)
        best = (self.work.surface, outcome.residuals, self.work.usual)
        while not is_rational and len(self.rounds) < _MAX_ROUNDS:
            found = self._next(outcome)
            if found is None:
                break
            usual = self._usual(outcome.residuals)
            self.work = replace(self.work, surface=found, usual=usual)
            outcome = self._round(found.knots)
            if not _is_better(outcome.residuals, best[1]):
                # A finer net that leads away from the points follows their noise.
                self.ended_by = "noise" if self.most else self.ended_by
                break
            best = (found, outcome.residuals, usual)
        return best

    def _usual(self, residuals: Residuals) -> UsualDistances:
        """Return the distances by which the next round weights points."""
        return residuals.usual(self.work.breaks, self.work.usual.limit)

    def _next(self, outcome: RoundSums) -> _core.NurbsSurface | None:
        """Return the next surface: with the same net while that gains, else with a finer one."""
        sums = outcome.all()
        if sums is None:
            return None
        surface = self.work.surface
        first = self.solutions == 0
        if first:
            self._choose_fairness(outcome, surface)
        again = self._solved(sums, surface)
        before, after = sums.squared_distance(surface), sums.squared_distance(again)
        gains = after < (1 - _MIN_DECREASE) ** 2 * before
        if (first or gains) and after < before and self.is_valid(again):
            return again
        return self._finer(outcome) if self.most else None

    def _finer(self, outcome: RoundSums) -> _core.NurbsSurface | None:
        """Return a surface with a finer net; None if it would not be better."""
        surface, residuals = self.work.surface, outcome.residuals
        if self.work.tolerance is not None and residuals.max <= self.work.tolerance:
            self.ended_by = "tolerance"
            return None
        supported = residuals.inliers // _POINTS_PER_CONTROL_POINT
        limit = min(self.most, supported)
        knots = _core.refined_knots(surface, self.work.closed, residuals.spans, limit)
        if knots is None:
            self.ended_by = "points" if supported < self.most else "max_control_points"
            return None
        expected = self._expected(outcome, surface, self.fairness)
        finer = self._round(knots)
        self._choose_fairness(finer, surface)
        sums = finer.all()
        if sums is None:
            return None
        if self.work.tolerance is None:
            error = self._expected(finer, surface, self.fairness)
            if not error <= _MAX_ERROR_RATIO * expected:
                self.ended_by = "noise"
                return None
        found = self._solved(sums, surface)
        if not self.is_valid(found):
            self.ended_by = "defects"
            return None
        return found

    def _round(self, knots: Spans | None) -> RoundSums:
        """Project all points onto the surface and sum the equations of a net with these knots."""
        start = self.clock()
        work = replace(self.work, knots=knots)
        degree = work.surface.degree
        of_u, of_v = work.surface.knots if knots is None else knots
        grid = (len(of_u) - degree[0] - 1, len(of_v) - degree[1] - 1)
        memory.check_client(grid, degree)
        memory.check_workers(self.engine, self.parts, 0, grid, degree)
        last = self.rounds[-1].rms if self.rounds else None
        outcome: Outcome = self.engine.summed(self.parts, step, work, stage="fitting", error=last)
        sums: RoundSums = outcome.value
        # Each worker gets the surface once.
        sent = len(pickle.dumps(work)) * max(len(self.engine.workers()), 1)
        self.moved += outcome.bytes + sent
        for name, seconds in (("reading", outcome.reading), ("computing", outcome.computing)):
            self.worker_seconds[name] = self.worker_seconds.get(name, 0.0) + seconds
        found = sums.residuals
        self.rounds.append(
            RoundReport(
                grid, found.rms, found.max, found.inliers, outcome.bytes, self.clock() - start
            )
        )
        return sums

    def _solved(
        self, sums: _core.PartialSums, like: _core.NurbsSurface, fairness: float | None = None
    ) -> _core.NurbsSurface:
        """Solve for a surface, with the lengths of the one before."""
        scaled = like.control_points / np.asarray(self.axis_scale)
        lengths = _core.isocurve_lengths(
            _core.NurbsSurface(scaled, degree=like.degree, knots=like.knots)
        )
        self.solutions += 1
        return sums.solve(self.fairness if fairness is None else fairness, lengths)

    def _choose_fairness(self, outcome: RoundSums, like: _core.NurbsSurface) -> None:
        """Choose the fairness by cross-validation, in decades from the last one.

        Of those with nearly the least error it is the largest, as in one process: where points are
        missing, the surface then bulges least.
        """
        if not self.chooses_fairness:
            return
        known = self.fairness
        errors = {0: self._expected(outcome, like, known)}
        for way in (1, -1):
            for decade in range(way, way * (_DECADES + 1), way):
                error = errors[decade] = self._expected(outcome, like, known * 10.0**decade)
                # A smaller fairness must gain more than a larger one may lose.
                before = errors[decade - way]
                worst = min(errors.values()) * _ERROR_RATIO if way > 0 else before / _ERROR_RATIO
                if not error <= worst:
                    break
        least = min(errors.values())
        if np.isfinite(least):
            good = (decade for decade, error in errors.items() if error <= _ERROR_RATIO * least)
            self.fairness = known * 10.0 ** max(good)

    def _expected(self, outcome: RoundSums, like: _core.NurbsSurface, fairness: float) -> float:
        """Return the sum of squared distances of each half from the surface of the other half."""
        first, second = outcome.halves
        if first is None or second is None:
            return np.inf
        try:
            of_first = self._solved(first, like, fairness)
            of_second = self._solved(second, like, fairness)
        except _core.NeurbsMemoryError:
            raise
        except _core.NeurbsError:  # A half does not determine the net.
            return np.inf
        return second.squared_distance(of_first) + first.squared_distance(of_second)


def _is_better(found: Residuals, before: Residuals) -> bool:
    """Whether points are nearer to a surface than to the one before.

    All points count. Weights differ between rounds, so outliers count as the farthest inlier of
    both.
    """
    limit = max(found.max, before.max)
    return found.of_all.bounded_rms(limit) < before.of_all.bounded_rms(limit)
