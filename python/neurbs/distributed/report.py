"""The report of a reconstruction over parts."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

from neurbs.distributed.refinement import RoundReport
from neurbs.reconstruction_report import Report


@dataclass(frozen=True)
class DistributedReport(Report):
    """The figures of a reconstruction over parts: those of `neurbs.Report`, and of its rounds.

    Deviations, inliers and percentiles are those of all points; percentiles are within 0.1 %.
    Candidates, diagnostics, training, faces, duplicates and outliers are those of the even sample.

    Attributes
    ----------
    sampled : int
        Points of the even sample.
    parts : int
        Files or blocks that were read.
    workers : int
        Worker processes; 0 for the schedulers of this process.
    rounds : tuple of RoundReport
        The passes over all points.
    bytes_moved : int
        Size of all results of parts and of all surfaces sent to workers.
    skipped : dict of str to str
        For each part that could not be read and was skipped, the reason.
    worker_seconds : dict of str to float
        Seconds of all tasks of the rounds together: ``"reading"`` and ``"computing"``.
    """

    sampled: int = 0
    parts: int = 0
    workers: int = 0
    rounds: tuple[RoundReport, ...] = ()
    bytes_moved: int = 0
    skipped: dict[str, str] | None = None
    worker_seconds: dict[str, float] | None = None

    @classmethod
    def of(cls, report: Report, **figures: Any) -> DistributedReport:
        """Return the report of the sample with other figures."""
        known = {one.name: getattr(report, one.name) for one in fields(Report)}
        return cls(**known | figures)

    def lines(self) -> dict[str, str]:
        """Return the main figures as texts."""
        lines = super().lines()
        time = lines.pop("time")
        where = f"{self.workers} workers" if self.workers else "one process"
        lines["parts"] = f"{self.parts:,} on {where}, even sample of {self.sampled:,} points"
        lines["rounds"] = f"{len(self.rounds)}, {self.bytes_moved / 1e6:,.1f} MB moved"
        if self.skipped:
            lines["skipped"] = f"{len(self.skipped)} parts that cannot be read"
        return lines | {"time": time}
