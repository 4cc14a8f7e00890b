"""How a reconstruction went."""

from __future__ import annotations

import dataclasses
from typing import Any


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
        Points that count: the rest are duplicates, outliers or of other pieces.
    rms, max : float
        Root mean square and largest of the inliers' distances from the surface, in their unit.
    percentiles : dict of int to float
        For 50, 90, 95 and 99 percent of the inliers, how far away they are at most.
    tolerance : float or None
        The tolerance that was asked for.
    within : float or None
        Share of the inliers that lie within it.
    ended_by : str
        What ended the growth of the net: ``"tolerance"`` (all points lie within it), ``"noise"``
        (a larger net would follow the noise of the points), ``"exact"`` (nobody would see what it
        does), ``"grid"`` (its size was given, or what grows further folds over or runs away),
        ``"points"`` (they cannot hold more) or ``"max_control_points"``.
    fairness : float or None
        Weight of the fairness that the fit ended with; None if nothing was fitted.
    iterations : int
        Solutions for the control net.
    topology : str
        What kind of surface it is: ``"sheet"``, ``"height"``, ``"tube"`` or ``"torus"``.
    topology_reason : str or None
        Why, if that was found out.
    duplicates : int
        Points that were merged with others, of those that were looked at.
    outliers : int
        Points that were left out: far from all that their neighbours could form, or from the
        surface.
    warnings : tuple of str
        What one should know, in words.
    steps : int
        Steps made in training the map: presentations by the paper's method, else epochs.
    ordered_at : int
        The step from which on its radius was less than an edge.
    stopped_by : str
        What ended the training: ``"reached"``, ``"settled"`` or ``"max_steps"``; ``"ordered"`` for
        points that were in order already, which need none.
    reached : int
        How many points are on the lattice.
    change : float or None
        Largest move of a lattice node during the last epoch, in the points' unit; None if not even
        one was finished.
    quantization_error : float
        Mean distance from a point to the nearest lattice node, in the points' unit.
    seconds : dict of str to float
        Time spent, stage by stage.
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
    topology: str
    topology_reason: str | None
    duplicates: int
    outliers: int
    warnings: tuple[str, ...]
    steps: int
    ordered_at: int
    stopped_by: str
    reached: int
    change: float | None
    quantization_error: float
    seconds: dict[str, float]

    @property
    def converged(self) -> bool:
        """Whether all points lie within the tolerance, if there was one.

        By the paper's method: whether training ended by itself, not because its steps were over.
        """
        if self.fairness is None:
            return self.stopped_by != "max_steps"
        return self.tolerance is None or self.ended_by == "tolerance"

    def to_dict(self) -> dict[str, Any]:
        """Return all of it as plain values, as JSON has them."""
        values = dataclasses.asdict(self) | {"converged": self.converged}
        listed = {"grid": list(self.grid), "degree": list(self.degree)}
        return values | listed | {"warnings": list(self.warnings)}

    def lines(self) -> dict[str, str]:
        """Return the main figures in words, line by line."""
        rows, cols = self.grid
        within = "" if self.within is None else f", {100 * self.within:.4g} % within the tolerance"
        counting = "" if self.inliers == self.points else f", {self.inliers:,} of them count"
        lines = {
            "points": f"{self.points:,}{counting}, diagonal {self.diagonal:.6g}",
            "net": f"{rows} × {cols} control points, degrees {self.degree[0]} and {self.degree[1]}",
            "kind": self.topology + (f": {self.topology_reason}" if self.topology_reason else ""),
            "distances": f"rms {self.rms:.4g}, max {self.max:.4g}{within}",
            "percentiles": ", ".join(f"{n} % {d:.4g}" for n, d in self.percentiles.items()),
        }
        if self.duplicates or self.outliers:
            lines["left out"] = f"{self.duplicates:,} duplicates, {self.outliers:,} outliers"
        if self.fairness is None:
            lines["training"] = f"{self.steps:,} steps: {_WHY_STOPPED[self.stopped_by]}"
            lines["on lattice"] = f"{self.reached:,} of {self.points:,} points"
        else:
            several = "" if self.iterations == 1 else "s"
            lines["fit"] = f"{self.iterations} iteration{several}: {_WHY_ENDED[self.ended_by]}"
        lines["time"] = ", ".join(f"{stage} {time:.2f} s" for stage, time in self.seconds.items())
        return lines

    def __str__(self) -> str:
        """Return the main figures as a table to be read, and the warnings."""
        text = [f"{name:<12}{line}" for name, line in self.lines().items()]
        return "\n".join(text + [f"{'warning':<12}{warning}" for warning in self.warnings])

    def shortcomings(self) -> list[str]:
        """Return in words what did not come out as it was asked for."""
        texts = list(self.warnings)
        if self.fairness is None and not self.converged:
            moved = (
                ""
                if self.change is None
                else f", while the lattice still moved {self.change:.3g} an epoch"
            )
            texts.append(
                f"training ended after max_steps={self.steps} steps{moved}: "
                "give it more steps, or raise min_change"
            )
        return texts


_WHY_STOPPED = {
    "ordered": "the points were in order",
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
