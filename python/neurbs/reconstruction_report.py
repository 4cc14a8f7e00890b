"""How a reconstruction went."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from neurbs.candidate import Candidate, table
from neurbs.diagnostics import Diagnostic
from neurbs.renamed import missing_attribute


@dataclasses.dataclass(frozen=True)
class Report:
    """How a reconstruction went.

    Attributes
    ----------
    points : int
        Number of points.
    diagonal : float
        Length of the diagonal of the points' bounding box, in their unit.
    grid : (int, int)
        Rows and columns of the control net.
    degree : (int, int)
        Degrees of the surface in u and v.
    inliers : int
        Points that were used in the fit, merged duplicates among them.
    rms, max : float
        Root mean square and largest of the inliers' deviations, in their unit.
    percentiles : dict of int to float
        For 50, 90, 95 and 99 percent of the inliers, how far away they are at most.
    tolerance : float or None
        The tolerance that was asked for.
    within : float or None
        Share of the inliers that lie within it.
    ended_by : str
        What ended the growth of the net: ``"tolerance"`` (all points lie within it), ``"noise"``
        (a larger net would follow the noise of the points), ``"exact"`` (the error is too small to
        matter), ``"grid"`` (its size was given, or larger nets have defects),
        ``"points"`` (they cannot hold more) or ``"max_control_points"``.
    fairness : float or None
        Weight of the fairness that the fit ended with; None if nothing was fitted.
    iterations : int
        Solutions for the control net.
    kind : {"height", "sheet", "tube", "torus"}
        The kind of surface.
    direction : (float, float, float) or None
        The direction of the heights, of a height field.
    axis_scale : (float, float, float)
        What each coordinate was divided by for the fit; 1 unless the axes have different units.
    valid : bool
        Whether the surface has no defects.
    converged : bool
        Whether the tolerance, if there was one, is reached. By the paper's method: whether
        training ended by itself, not because its steps were over.
    candidates : tuple of Candidate
        Every hypothesis with its score and why it lost, the best first.
    diagnostics : tuple of Diagnostic
        What one should know, each with a stable code.
    duplicates : int
        Points that lie where others do and were merged with them.
    outliers : int
        Points that were left out as outliers: far from their neighbours, or from the surface.
        Points with a no-data value are among them.
    steps : int
        Steps made in training the map: presentations by the paper's method, else epochs.
    ordered_at : int
        The step from which on its radius was less than an edge.
    stopped_by : str
        What ended the training: ``"reached"``, ``"settled"`` or ``"max_steps"``.
    reached : int
        How many points are on the lattice.
    change : float or None
        Largest move of a lattice node during the last epoch, in the points' unit; None if not even
        one was finished.
    quantization_error : float
        Mean distance from a point to the nearest lattice node, in the points' unit.
    seconds : dict of str to float
        Wall time of each stage; their sum is that of the whole call.
    """

    points: int
    diagonal: float
    grid: tuple[int, int]
    degree: tuple[int, int]
    inliers: int
    rms: float
    max: float
    percentiles: dict[int, float]
    tolerance: float | None
    within: float | None
    ended_by: str
    fairness: float | None
    iterations: int
    kind: str
    direction: tuple[float, float, float] | None
    axis_scale: tuple[float, float, float]
    valid: bool
    converged: bool
    candidates: tuple[Candidate, ...]
    diagnostics: tuple[Diagnostic, ...]
    duplicates: int
    outliers: int
    steps: int
    ordered_at: int
    stopped_by: str
    reached: int
    change: float | None
    quantization_error: float
    seconds: dict[str, float]

    if not TYPE_CHECKING:  # A checker knows all attributes.

        def __getattr__(self, name: str) -> Any:
            """Refuse a missing attribute; the error for an old name gives the new one."""
            raise missing_attribute("'Report' object", name)

    def to_dict(self) -> dict[str, Any]:
        """Return all of it as plain values, as JSON has them."""
        return {name: _plain(value) for name, value in dataclasses.asdict(self).items()}

    def lines(self) -> dict[str, str]:
        """Return the main figures in words; the candidates take a line each."""
        rows, cols = self.grid
        within = "" if self.within is None else f", {100 * self.within:.4g} % within the tolerance"
        used = "" if self.inliers == self.points else f", {self.inliers:,} of them used"
        lines = {
            "points": f"{self.points:,}{used}, diagonal {self.diagonal:.6g}",
            "net": f"{rows} × {cols} control points, degrees {self.degree[0]} and {self.degree[1]}",
            "kind": self._kind(),
            "deviations": f"rms {self.rms:.4g}, max {self.max:.4g}{within}",
            "percentiles": ", ".join(f"{n} % {d:.4g}" for n, d in self.percentiles.items()),
        }
        if self.candidates:
            lines["candidates"] = table(self.candidates)
        if self.duplicates:
            lines["merged"] = f"{self.duplicates:,} duplicates"
        if self.outliers:
            lines["left out"] = f"{self.outliers:,} outliers"
        if self.fairness is None:
            lines["training"] = f"{self.steps:,} steps: {_WHY_STOPPED[self.stopped_by]}"
            lines["on lattice"] = f"{self.reached:,} of {self.points:,} points"
        else:
            several = "" if self.iterations == 1 else "s"
            lines["fit"] = f"{self.iterations} iteration{several}: {_WHY_ENDED[self.ended_by]}"
        lines["time"] = ", ".join(f"{stage} {time:.2f} s" for stage, time in self.seconds.items())
        return lines

    def _kind(self) -> str:
        """Return the kind in words, and whether the surface is valid."""
        words = [self.kind]
        if self.direction is not None:
            words[0] += " along ({:.3g}, {:.3g}, {:.3g})".format(*self.direction)
        for axis, scale in zip("xyz", self.axis_scale, strict=True):
            if scale != 1:
                words.append(f"{axis} divided by {scale:g}")
        if not self.valid:
            defects = [found.code for found in self.diagnostics if found.is_defect]
            words.append(f"not valid: {' '.join(defects)}")
        return ", ".join(words)

    def __str__(self) -> str:
        """Return the main figures as a table to be read, and the diagnostics."""
        lines = [
            *self.lines().items(),
            *((found.code, found.message) for found in self.diagnostics),
        ]
        return "\n".join(aligned(lines))


def aligned(lines: Iterable[tuple[str, str]]) -> list[str]:
    """Return names and texts in two columns; further lines of a text stand below its first."""
    pairs = list(lines)
    width = max(len(name) for name, _ in pairs) + 2
    return [
        f"{title:<{width}}{line}"
        for name, text in pairs
        for title, line in zip((name, *[""] * text.count("\n")), text.split("\n"), strict=True)
    ]


def _plain(value: Any) -> Any:
    """Return a value with lists for tuples, as JSON has it."""
    match value:
        case dict():
            return {name: _plain(part) for name, part in value.items()}
        case list() | tuple():
            return [_plain(part) for part in value]
    return value


_WHY_STOPPED = {
    "reached": "all points are on the lattice",
    "settled": "the lattice has settled",
    "max_steps": "the steps were over",
}

_WHY_ENDED = {
    "tolerance": "all points lie within the tolerance",
    "noise": "a larger net would follow the noise",
    "exact": "a larger net would not be seen",
    "grid": "the net was given",
    "points": "the points hold no larger net",
    "max_control_points": "max_control_points was reached",
}
