"""The report of a reconstruction."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from neurbs.candidate import Candidate, table
from neurbs.diagnostics import Diagnostic
from neurbs.renamed import missing_attribute


@dataclasses.dataclass(frozen=True)
class TrimReport:
    """The faces of a surface beside its points. Areas are in the square of the points' unit.

    A spacing is the side of a square with one point each, near a place.

    Attributes
    ----------
    area : float
        Area of the faces.
    surface_area : float
        Area of the whole surface.
    holes : tuple of float
        Area of each hole, the largest first.
    outside : float
        Share of the points that lie more than 0.75 spacings outside of the faces.
    beyond : float or None
        Share of the faces' area that is farther than 1.5 spacings from every point; None if there
        are too few points for a spacing.
    beyond_untrimmed : float or None
        The same share of the whole surface.
    """

    area: float
    surface_area: float
    holes: tuple[float, ...]
    outside: float
    beyond: float | None
    beyond_untrimmed: float | None

    def __str__(self) -> str:
        """Return the figures as a sentence."""
        if self.area == self.surface_area:
            return f"the whole surface, area {short(self.area)}{_beyond(self.beyond)}"
        count = len(self.holes)
        sizes = ", ".join(short(hole, 3) for hole in self.holes[:5]) + ", …" * (count > 5)
        holes = f"{count} hole{'s' * (count > 1)} of {sizes}" if count else "no holes"
        outside = f", {100 * self.outside:.2g} % of the points outside" if self.outside else ""
        before = _beyond(self.beyond_untrimmed)
        return (
            f"area {short(self.area)}{_beyond(self.beyond)}, {holes}{outside}; "
            f"untrimmed {short(self.surface_area)}{before}"
        )


def _beyond(share: float | None) -> str:
    """Return the part of an area that lies beyond the points in words."""
    return "" if share is None else f" ({100 * share:.2g} % beyond the points)"


@dataclasses.dataclass(frozen=True, repr=False)
class Report:
    """The figures of a reconstruction: points, fit, candidates, training, time.

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
        Points used in the fit, including merged duplicates.
    rms, max : float
        Root mean square and largest of the inliers' deviations, in the points' unit.
    percentiles : dict of int to float
        The 50th, 90th, 95th and 99th percentiles of the inliers' deviations.
    tolerance : float or None
        The given tolerance.
    within : float or None
        Share of the inliers within the tolerance.
    ended_by : str
        Reason why the net stopped growing: ``"tolerance"`` (all points are within it), ``"noise"``
        (a larger net would follow the noise of the points), ``"exact"`` (the error is
        negligible), ``"grid"`` (the size was given), ``"defects"`` (larger nets have defects),
        ``"points"`` (the points do not determine a larger net) or ``"max_control_points"``.
    fairness : float or None
        Weight of the fairness energy in the last fit; None for the paper's method, which has no
        least-squares fit.
    iterations : int
        Number of least-squares solutions for the control net.
    kind : {"height", "sheet", "tube", "torus"}
        The kind of surface.
    direction : (float, float, float) or None
        For a height field the direction of the heights.
    axis_scale : (float, float, float)
        Divisors of the coordinates in the fit; 1 unless the axes have different units.
    valid : bool
        Whether the surface has no defects.
    converged : bool
        Whether the tolerance is reached, or none was given. By the paper's method: whether
        training ended before `max_steps`.
    candidates : tuple of Candidate
        Every hypothesis with its score and outcome, the best first.
    diagnostics : tuple of Diagnostic
        Findings about points and surface, each with a stable code.
    duplicates : int
        Points at the position of another point, which were merged with it.
    outliers : int
        Points that were left out because they are far from their neighbors or from the surface,
        or have a no-data value.
    trim : TrimReport or None
        Area and holes of the faces; None if no trimming was asked for.
    steps : int
        Steps of training: presentations by the paper's method, else epochs.
    ordered_at : int
        First step at which the radius was less than one edge.
    stopped_by : str
        Reason for the end of training: ``"reached"``, ``"settled"`` or ``"max_steps"``.
    reached : int
        Number of points on the lattice.
    change : float or None
        Largest move of a lattice node during the last epoch, in the points' unit; None if no epoch
        was finished.
    quantization_error : float
        Mean distance from a point to the nearest lattice node, in the points' unit.
    seconds : dict of str to float
        Wall time of each stage; the sum is the time of the call.
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
    trim: TrimReport | None
    steps: int
    ordered_at: int
    stopped_by: str
    reached: int
    change: float | None
    quantization_error: float
    seconds: dict[str, float]

    if not TYPE_CHECKING:  # Type checkers must report missing attributes.

        def __getattr__(self, name: str) -> Any:
            """Raise for a missing attribute; for an old name the error gives the new one."""
            raise missing_attribute("'Report' object", name)

    def to_dict(self) -> dict[str, Any]:
        """Return all attributes as values for JSON."""
        return {name: _plain(value) for name, value in dataclasses.asdict(self).items()}

    def lines(self) -> dict[str, str]:
        """Return the main figures as texts; the candidates take a line each."""
        rows, cols = self.grid
        within = "" if self.within is None else f", {100 * self.within:.4g} % within the tolerance"
        used = "" if self.inliers == self.points else f", {self.inliers:,} of them used"
        lines = {
            "points": f"{self.points:,}{used}, diagonal {self.diagonal:.6g}",
            "net": f"{rows} × {cols} control points, degrees {self.degree[0]} and {self.degree[1]}",
            "kind": self._kind(),
            "deviations": f"rms {short(self.rms)}, max {short(self.max)}{within}",
            "percentiles": ", ".join(f"{n} % {short(d)}" for n, d in self.percentiles.items()),
        }
        if self.trim is not None:
            lines["face"] = str(self.trim)
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

    def __repr__(self) -> str:
        """Return the main figures in a line."""
        validity = "valid" if self.valid else "not valid"
        return (
            f"Report({self.kind}, {validity}, {self.points} points, "
            f"net {self.grid[0]} × {self.grid[1]}, rms {short(self.rms)}, max {short(self.max)})"
        )

    def __str__(self) -> str:
        """Return the main figures and the diagnostics as a table."""
        lines = [
            *self.lines().items(),
            *((found.code, found.message) for found in self.diagnostics),
        ]
        return "\n".join(aligned(lines))


def aligned(lines: Iterable[tuple[str, str]]) -> list[str]:
    """Return the lines of two columns, names and texts; a text may have several lines."""
    pairs = list(lines)
    width = max(len(name) for name, _ in pairs) + 2
    return [
        f"{title:<{width}}{line}"
        for name, text in pairs
        for title, line in zip((name, *[""] * text.count("\n")), text.split("\n"), strict=True)
    ]


def short(value: float, digits: int = 4) -> str:
    """Format a measure with a few digits; large ones are grouped, as in 16,990,000."""
    rounded = float(f"{value:.{digits}g}")
    return f"{rounded:,.0f}" if 10**digits <= abs(rounded) < 1e12 else f"{value:.{digits}g}"


def _plain(value: Any) -> Any:
    """Return a value with lists instead of tuples."""
    match value:
        case dict():
            return {name: _plain(part) for name, part in value.items()}
        case list() | tuple():
            return [_plain(part) for part in value]
    return value


_WHY_STOPPED = {
    "reached": "all points are on the lattice",
    "settled": "the lattice has settled",
    "max_steps": "max_steps was reached",
}

_WHY_ENDED = {
    "tolerance": "all points lie within the tolerance",
    "noise": "a larger net would follow the noise",
    "exact": "the error is negligible",
    "grid": "the size of the net was given",
    "defects": "larger nets have defects",
    "points": "the points do not determine a larger net",
    "max_control_points": "max_control_points was reached",
}
