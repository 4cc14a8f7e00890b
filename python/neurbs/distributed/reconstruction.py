"""`neurbs.distributed.reconstruct`: points of any number, on the workers of Dask."""

from __future__ import annotations

import dataclasses
import time
import warnings
from collections.abc import Callable, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

import neurbs
from neurbs import _core, diagnostics
from neurbs.choices import KindChoice, LengthUnit
from neurbs.distributed import memory, sampling
from neurbs.distributed.deviations import PointArrays
from neurbs.distributed.engine import Engine, Outcome
from neurbs.distributed.parts import Notes, Parts, no_points, parts_of
from neurbs.distributed.refinement import Refinement
from neurbs.distributed.report import DistributedReport
from neurbs.distributed.residuals import Floats, Residuals, breaks_of
from neurbs.distributed.result import DistributedReconstruction
from neurbs.distributed.rounds import CLOSED, BasePlane, Round, moved
from neurbs.errors import argument_error
from neurbs.extras import require
from neurbs.io.point_cloud import PointCloud
from neurbs.reconstruction import Reconstruction, in_unit_of
from neurbs.reconstruction_chunks import MAX_SAMPLE
from neurbs.reconstruction_report import TrimReport

_CHECKED = 1 << 15
"""Points of the sample by which the surface of each round is checked for defects."""

_OF_FACES = ("regions", "trim-doubtful", "untrimmed")
"""Codes of diagnostics about faces, which are found anew for the last surface."""

_UNKNOWN_NET = (64, 64)
"""The net for which memory is checked before its size is known."""


def reconstruct(
    points: Any,
    tolerance: float | None = None,
    *,
    kind: KindChoice = "auto",
    grid: tuple[int, int] | None = None,
    columns: Sequence[str | int] | None = None,
    nan: Literal["error", "drop"] = "error",
    unit: LengthUnit | None = None,
    bounds: ArrayLike | None = None,
    cell: float | None = None,
    las_classes: Sequence[int] | None = None,
    errors: Literal["raise", "skip"] = "raise",
    max_sample: int = MAX_SAMPLE,
    scheduler: Any = None,
    progress: Callable[[Any], object] | None = None,
    **options: Any,
) -> DistributedReconstruction:
    """Turn scattered points in parts into a NURBS surface, on the workers of Dask.

    An even sample of all points chooses kind, chart and first surface as `neurbs.reconstruct` does.
    Rounds over all points follow: workers project them and sum normal equations, robust weights and
    deviations; the client solves, refines knots where points are missed, and repeats until that
    gains nothing. Points are never gathered. The result does not depend on the parts, up to
    rounding. If the sample has all points, the result is that of `neurbs.reconstruct`.

    Parameters
    ----------
    points : dask array of shape (n, 3) or (n, 2), files, or iterator of arrays
        Files are paths of any format that `neurbs.read_points` reads, which all workers can open.
        An iterator is written to a temporary folder once. Each part is read once a round: persist
        an array that is costly to compute.
    tolerance, kind, grid
        As for `neurbs.reconstruct`.
    columns, nan, bounds, cell, las_classes
        For files, as for `neurbs.read_points`. `cell` thins each file by itself.
    unit : {"mm", "cm", "m", "in", "ft"}, optional
        As for `neurbs.reconstruct`: files with another unit are converted.
    errors : {"raise", "skip"}, default "raise"
        Whether a part that cannot be read is an error, or is skipped and reported.
    max_sample : int, default 2^20
        Most points of the even sample.
    scheduler : str or Client, optional
        As for `dask.compute`: by default the current client, or threads of this process.
    progress : callable, optional
        Called with an object that has `stage`, `step`, `total` and `share`. An exception that it
        raises cancels the job.
    **options
        Other options of `neurbs.reconstruct`, without `weights` and `component`.

    Returns
    -------
    DistributedReconstruction
        Surface, faces, report, and arrays of Dask over all points, in `unit` or that of the files.

    Raises
    ------
    NeurbsError
        As for `neurbs.reconstruct`; if a part cannot be read, with its name; if files have
        several units and `unit` is not given.
    NeurbsMemoryError
        If workers or this process have too little memory for the net, with what it takes.

    Notes
    -----
    A rational surface is that of the sample; all points are measured from it. The energy sums
    squared third derivatives; its weight is chosen by the error of each half of the points beside
    the surface of the other half. Faces end where the inliers of the even sample end.

    Examples
    --------
    >>> import dask.array as da
    >>> import numpy as np
    >>> from neurbs import distributed
    >>> x, y = np.random.default_rng(0).random((2, 40_000))
    >>> points = da.from_array(np.column_stack([x, y, np.sin(3 * x) * y]), chunks=(5000, 3))
    >>> result = distributed.reconstruct(points, grid=(9, 7), max_sample=2000)
    >>> result.surface
    NurbsSurface(net 9 × 7, degree (3, 3), domain [0, 1] × [0, 1], polynomial, open)
    >>> result.report.points, result.report.rms < 1e-3
    (40000, True)
    >>> float(result.deviations.max().compute()) < 0.01
    True
    """
    require("dask.array", "points in parts")
    given = {"tolerance": tolerance, "kind": kind, "grid": grid, **options}
    _check(given)
    if not (isinstance(max_sample, int) and max_sample >= 4):
        raise argument_error("max_sample", f"must be an integer from 4, got {max_sample!r}")
    parts = parts_of(
        points,
        columns=columns,
        nan=nan,
        unit=unit,
        bounds=bounds,
        cell=cell,
        las_classes=las_classes,
        errors=errors,
    )
    job = _Job(Engine(scheduler, progress), parts, given, max_sample, unit)
    result = job.run()
    job.notes.warn(result.report.points, stacklevel=2)
    diagnostics.warn(result.report.diagnostics, stacklevel=2)
    return result


def _check(given: dict[str, Any]) -> None:
    """Raise for wrong options of the surface, as all points are read before they are used."""
    known = _core.default_options()
    for name in given:
        if name not in known:
            raise TypeError(f"reconstruct() got an unexpected keyword argument {name!r}")
    for name in ("weights", "component"):
        if given.get(name) is not None:
            raise argument_error(name, "must be left out for points in parts")
    _core.check_options(known | given)


@dataclasses.dataclass
class _Job:
    """A reconstruction over parts, stage by stage."""

    engine: Engine
    parts: Parts
    options: dict[str, Any]
    max_sample: int
    unit: LengthUnit | None = None
    notes: Notes = dataclasses.field(default_factory=Notes)
    skipped: dict[str, str] = dataclasses.field(default_factory=dict)
    seconds: dict[str, float] = dataclasses.field(default_factory=dict)
    moved: int = 0

    def run(self) -> DistributedReconstruction:
        """Run all stages."""
        start = time.perf_counter()
        sampled = self._sampled()
        self.seconds["sample"] = time.perf_counter() - start
        points = PointCloud(sampled.value.points(), unit=self.unit or self.notes.unit())
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", neurbs.NeurbsWarning)
            fitted = neurbs.reconstruct(points, progress=self.engine.progress, **self.options)
        self.seconds["fit"] = time.perf_counter() - start - self.seconds["sample"]
        if sampled.value.sample.seen == len(points):
            return self._of_all(fitted, sampled)
        refinement = self._refinement(fitted, sampled)
        first = refinement.work.surface
        found, residuals, usual = refinement.run()
        self.seconds["rounds"] = time.perf_counter() - start - sum(self.seconds.values())
        self.moved += refinement.moved
        work = dataclasses.replace(refinement.work, surface=found, usual=usual, knots=None)
        refined = fitted if found is first else _of_sample(fitted, work)
        refined = in_unit_of(points, refined)
        self.seconds["measure"] = time.perf_counter() - start - sum(self.seconds.values())
        report = self._report(refined, sampled, refinement, residuals)
        return self._result(refined, sampled, work, report)

    def _sampled(self) -> Outcome:
        """Return the even sample of all points; parts that cannot be read are dropped."""
        grid = self.options.get("grid") or _UNKNOWN_NET
        degree = (self.options.get("degree", 3),) * 2
        if self.options.get("grid") is not None:
            memory.check_client(grid, degree)
        memory.check_workers(self.engine, self.parts, self.max_sample, grid, degree)
        outcome = self.engine.summed(self.parts, sampling.step, self.max_sample, stage="sampling")
        self.moved += outcome.bytes
        self.skipped = {self.parts.names[n]: why for n, why in outcome.skipped.items()}
        if outcome.value is None:
            raise no_points(self.skipped, self.parts)
        self.notes = outcome.notes
        self.parts = self.parts.without(set(outcome.skipped))
        counts = dict(enumerate(outcome.counts[n] for n in sorted(outcome.counts)))
        return dataclasses.replace(outcome, counts=counts)

    def _refinement(self, fitted: Reconstruction, sampled: Outcome) -> Refinement:
        """Prepare the rounds, from the surface of the sample and its deviations."""
        options, report = fitted.settings, fitted.report
        low, high = sampled.value.bounds
        origin = low / 2 + high / 2
        surface, kind = moved(fitted.surface, -origin), fitted.report.kind
        breaks, tolerance = breaks_of(surface), options["tolerance"]
        limit = np.inf
        if options["clean"]:
            limit = float(fitted.deviations[fitted.inliers].max())
        weights = fitted.inliers.astype(np.float64)
        residuals = Residuals.of(fitted.deviations, fitted.uv, weights, breaks, tolerance)
        base = None
        if kind == "height" and report.direction is not None:
            base = BasePlane.of(surface, report.direction)
        work = Round(
            surface,
            surface.knots,
            residuals.usual(breaks, limit),
            CLOSED[kind],
            tuple(origin.tolist()),
            base,
            options["robust"],
            tolerance,
        )
        count = sampled.value.sample.seen
        share = len(fitted.points) / count
        grows = options["grid"] is None and report.ended_by not in ("defects", "exact")
        return Refinement(
            self.engine,
            self.parts,
            work,
            (report.fairness or 1e-6) * (share if options["fairness"] is None else 1.0),
            options["fairness"] is None,
            report.axis_scale,
            options["max_control_points"] if grows else 0,
            _validity(fitted, origin),
            time.perf_counter,
            ended_by=report.ended_by,
        )

    def _of_all(self, fitted: Reconstruction, sampled: Outcome) -> DistributedReconstruction:
        """Return the result of a sample that has all points."""
        import dask.array as da

        report = DistributedReport.of(fitted.report, **self._figures(sampled))
        sizes = tuple(sampled.counts[number] for number in range(len(self.parts)))
        points, uv, deviations, inliers = (
            da.from_array(array, chunks=(sizes, *array.shape[1:]))
            for array in (fitted.points, fitted.uv, fitted.deviations, fitted.inliers)
        )
        sample = dataclasses.replace(fitted, report=report)
        return DistributedReconstruction(sample, points, uv, deviations, inliers, report)

    def _result(
        self, refined: Reconstruction, sampled: Outcome, work: Round, report: DistributedReport
    ) -> DistributedReconstruction:
        arrays = PointArrays.of(self.parts, sampled.counts, work)
        return DistributedReconstruction(
            dataclasses.replace(refined, report=report),
            arrays.points,
            arrays.uv,
            arrays.deviations,
            arrays.inliers,
            report,
        )

    def _figures(self, sampled: Outcome) -> dict[str, Any]:
        return {
            "sampled": len(sampled.value.sample.indices),
            "parts": len(self.parts),
            "workers": len(self.engine.workers()),
            "bytes_moved": self.moved,
            "skipped": self.skipped,
        }

    def _report(
        self,
        refined: Reconstruction,
        sampled: Outcome,
        refinement: Refinement,
        residuals: Residuals,
    ) -> DistributedReport:
        low, high = sampled.value.bounds
        tolerance = refinement.work.tolerance
        inliers = max(residuals.inliers, 1)
        return DistributedReport.of(
            refined.report,
            **self._figures(sampled),
            points=residuals.count,
            inliers=residuals.inliers,
            diagonal=float(np.linalg.norm(high - low)),
            grid=refined.surface.control_points.shape[:2],
            rms=residuals.rms,
            max=residuals.max,
            percentiles={
                percent: residuals.of_inliers.quantile(percent / 100)
                for percent in (50, 90, 95, 99)
            },
            within=None if tolerance is None else residuals.within / inliers,
            converged=tolerance is None or residuals.within == residuals.inliers,
            ended_by=refinement.ended_by,
            fairness=refinement.fairness,
            iterations=refined.report.iterations + refinement.solutions,
            rounds=tuple(refinement.rounds),
            seconds=dict(self.seconds),
            worker_seconds=refinement.worker_seconds,
        )


def _validity(fitted: Reconstruction, origin: Floats) -> Callable[[_core.NurbsSurface], bool]:
    """Return whether a surface has no defect that the surface of the sample has not."""
    known = {found.code for found in fitted.report.diagnostics if found.is_defect}
    points = fitted.points[fitted.inliers]
    points = points[:: max(len(points) // _CHECKED, 1)] - origin

    def is_valid(surface: _core.NurbsSurface) -> bool:
        return {found.code for found in neurbs.validate(surface, points)} <= known

    return is_valid


def _of_sample(fitted: Reconstruction, work: Round) -> Reconstruction:
    """Return the result of the sample with the surface of a round, and its faces."""
    surface = moved(work.surface, np.asarray(work.origin))
    uv, distances, weights = work.projected(fitted.points - np.asarray(work.origin))
    inliers = weights > 0
    shell, trim, findings = _core.trimmed(
        surface, uv[inliers], fitted.settings["trim"], fitted.report.axis_scale
    )
    others = [found for found in fitted.report.diagnostics if found.code not in _OF_FACES]
    report = dataclasses.replace(
        fitted.report,
        trim=None if trim is None else TrimReport(**trim),
        diagnostics=(*others, *diagnostics.of_core(findings)),
    )
    return dataclasses.replace(
        fitted,
        surface=surface,
        shell=shell,
        uv=uv,
        deviations=distances,
        inliers=inliers,
        report=report,
    )
