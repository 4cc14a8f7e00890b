"""The whole job: scattered points in, a surface out."""

from __future__ import annotations

import dataclasses
import os
import time
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs import _core, io
from neurbs.som import ConvergenceWarning, SelfOrganizingMap


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
    rms, max : float
        Root mean square and largest of the points' distances from the surface, in their unit.
    percentiles : dict of int to float
        For 50, 90, 95 and 99 percent of the points, how far away they are at most.
    tolerance : float or None
        The tolerance that was asked for.
    within : float or None
        Share of the points that lie within it.
    ended_by : str
        What ended the growth of the net: ``"tolerance"`` (all points lie within it), ``"noise"``
        (a larger net would follow the noise of the points), ``"exact"`` (nobody would see what it
        does), ``"grid"`` (its size was given),
        ``"points"`` (they cannot hold more) or ``"max_control_points"``.
    fairness : float or None
        Weight of the fairness that the fit ended with; None if nothing was fitted.
    iterations : int
        Solutions for the control net.
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
    rms: float
    max: float
    percentiles: dict[int, float]
    tolerance: float | None
    within: float | None
    ended_by: str
    fairness: float | None
    iterations: int
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

    def __str__(self) -> str:
        """Return the main figures as a table to be read."""
        rows, cols = self.grid
        within = "" if self.within is None else f", {100 * self.within:.4g} % within the tolerance"
        lines = {
            "points": f"{self.points:,}, diagonal {self.diagonal:.6g}",
            "net": f"{rows} × {cols} control points, degrees {self.degree[0]} and {self.degree[1]}",
            "distances": f"rms {self.rms:.4g}, max {self.max:.4g}{within}",
            "percentiles": ", ".join(f"{n} % {d:.4g}" for n, d in self.percentiles.items()),
        }
        if self.fairness is None:
            lines["training"] = f"{self.steps:,} steps: {_WHY_STOPPED[self.stopped_by]}"
            lines["on lattice"] = f"{self.reached:,} of {self.points:,} points"
        else:
            lines["fit"] = f"{self.iterations} iterations: {_WHY_ENDED[self.ended_by]}"
        lines["time"] = ", ".join(f"{stage} {time:.2f} s" for stage, time in self.seconds.items())
        text = [f"{name:<12}{line}" for name, line in lines.items()]
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


@dataclasses.dataclass(frozen=True, eq=False)
class Reconstruction:
    """What `reconstruct` returns, everything in the points' own frame and unit.

    Attributes
    ----------
    points : ndarray of shape (n, 3)
        The points, row by row if they were ordered: a read-only view of the array that was given,
        or of its conversion.
    surface : NurbsSurface
        The surface.
    mesh : TriangleMesh
        The surface as triangles.
    som : SelfOrganizingMap or None
        The trained map; None for points that were in order already.
    uv : ndarray of shape (n, 2)
        Where on the surface each point has its foot.
    distances : ndarray of shape (n,)
        Each point's distance from its foot.
    report : Report
        How it went.
    settings : dict of str to object
        The options that it was made with.
    history : list of (str, int, float)
        How the error fell: stage, step and error in the points' unit, for each epoch of the
        training and each step of what comes after it.
    """

    points: NDArray[np.float64] = dataclasses.field(repr=False)
    surface: _core.NurbsSurface
    mesh: _core.TriangleMesh
    som: SelfOrganizingMap | None
    uv: NDArray[np.float64] = dataclasses.field(repr=False)
    distances: NDArray[np.float64] = dataclasses.field(repr=False)
    report: Report = dataclasses.field(repr=False)
    settings: dict[str, Any] = dataclasses.field(default_factory=dict, repr=False)
    history: list[tuple[str, int, float]] = dataclasses.field(default_factory=list, repr=False)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write surface, mesh or picture to a file; the suffix picks, as in `neurbs.save`."""
        io.save(self, path)

    def plot(
        self,
        *,
        color: str = "height",
        tolerance: float | None = None,
        unit: str = "",
        isolines: int = 20,
        backend: str = "matplotlib",
    ) -> Any:
        """Draw points, lattice and surface: see `neurbs.plot.plot_reconstruction`."""
        from neurbs.plot import plot_reconstruction

        return plot_reconstruction(
            self,
            color=color,
            tolerance=tolerance,
            unit=unit,
            isolines=isolines,
            backend=backend,
        )

    def write_report(
        self,
        path: str | os.PathLike[str],
        *,
        tolerance: float | None = None,
        unit: str = "",
        source: str | os.PathLike[str] | None = None,
    ) -> None:
        """Write a page that shows surface, deviations and settings: see `neurbs.report.write`."""
        from neurbs import report

        report.write(self, path, tolerance=tolerance, unit=unit, source=source)

    def _repr_html_(self) -> str:
        from neurbs.plot import reconstruction_html

        return reconstruction_html(self)


def reconstruct(
    points: ArrayLike,
    tolerance: float | None = None,
    *,
    method: str = "fit",
    surface: str = "control-net",
    grid: tuple[int, int] | None = None,
    degree: int = 3,
    topology: str = "sheet",
    fairness: float | None = None,
    border: float | None = None,
    max_control_points: int = 40_000,
    aspect: str = "data",
    seed: int = 0,
    max_steps: int | None = None,
    reach: float | None = None,
    min_change: float | None = None,
    progress: Callable[[_core.Progress], object] | None = None,
) -> Reconstruction:
    """Turn scattered points into a NURBS surface.

    A self-organizing map brings the points in order from a start that follows the surface, however
    folded it is; least squares with fairness then pull a B-spline surface to the points, while
    their parameters follow it. Points that are in order already, an array of shape (r, c, 3),
    become a surface without a map.

    Parameters
    ----------
    points : array_like of shape (n, 3) or (n, 2)
        At least four distinct points, finite, not all on one line; two columns lie in z = 0. A
        C-contiguous float64 array is used as it is, anything else is converted once. Of shape
        (r, c, 3) they are the rows of an ordered grid, and the lattice themselves: only `surface`,
        `degree` and `progress` have a meaning then.
    tolerance : float, optional
        Distance from the surface within which all points shall lie, in their unit: the net grows
        until they do, or says why it did not. By default it grows until cross-validation says that
        it would follow noise.
    method : {"fit", "paper"}, default "fit"
        How the surface comes from the points: as above, or by the paper's method, where the
        trained lattice itself makes the surface.
    surface : {"control-net", "interpolate", "bezier"}, default "control-net"
        With ``method="paper"``: what the lattice is to the surface (section 5 of the paper): the
        control net of a clamped B-spline surface, the points that such a surface passes through,
        or the control net of one Bézier surface.
    grid : (int, int), optional
        Rows and columns of the control net. Their product is a budget, split by `aspect`; with
        ``method="paper"`` they are those of the lattice, by default four nodes for each of few
        points, at least 400 nodes for many, and up to 2500. A Bézier surface has from 2 to 10 of
        each, by default up to 10.
    degree : int, default 3
        Degree of the surface in both directions, lowered where the net has too few rows or columns
        for it. A Bézier surface's degrees are one less than rows and columns, whatever it is.
    topology : {"sheet", "tube", "torus"}, default "sheet"
        Whether no direction is closed, u, or both. Closed directions are smooth across the seam.
    fairness : float, optional
        Weight of the energy of bending: 1 gives it as large a say as all points together. By
        default generalized cross-validation chooses it.
    border : float, optional
        How far the surface goes on beyond the points where it is open, in their mean spacings; by
        default 0.5.
    max_control_points : int, default 40000
        Control points at most, when the net grows.
    aspect : {"data", "fixed"}, default "data"
        How a budget of control points is split between rows and columns: by the lengths of the
        surface along both, or as given.
    seed : int, default 0
        Seed of everything random; the same seed gives the same bits.
    max_steps : int, optional
        With ``method="paper"``: steps of training at most; by default 500 for each node.
    reach : float, optional
        With ``method="paper"``: a point is on the lattice when a node is at most this far, in the
        points' unit; by default 0.001 of the diagonal of their bounding box. When all are,
        training ends.
    min_change : float, optional
        With ``method="paper"``: training ends when no node has moved farther than this during an
        epoch, in the points' unit; by default 0.05 of the lattice's mean spacing.
    progress : callable, optional
        Called some 25 times a second with a `Progress`. An exception that it raises ends the job.

    Returns
    -------
    Reconstruction
        Surface, mesh, trained map, the points' parameters and distances, and the report.

    Raises
    ------
    NeurbsError
        If the points cannot be a surface, or an option is out of its range.
    KeyboardInterrupt
        On Ctrl-C, at once.

    Warns
    -----
    ConvergenceWarning
        If something did not come out as it was asked for; `Report.warnings` has it too.

    References
    ----------
    W. Wang, H. Pottmann and Y. Liu, Fitting B-spline curves to point clouds by curvature-based
    squared distance minimization, ACM Transactions on Graphics 25 (2006).
    https://doi.org/10.1145/1138450.1138453

    M. Hoffmann and L. Várady, Free-form Surfaces for Scattered Data by Neural Networks, Journal
    for Geometry and Graphics 2 (1998).

    Examples
    --------
    >>> import numpy as np
    >>> import neurbs
    >>> x, y = np.random.default_rng(0).random((2, 500))
    >>> result = neurbs.reconstruct(np.column_stack([x, y, np.sin(3 * x) * y]), grid=(10, 8))
    >>> result.surface
    NurbsSurface(net 10 × 8, degree (3, 3), domain [0, 1] × [0, 1], polynomial, open)
    >>> result.report.rms < 1e-3
    True
    """
    if _is_ordered(points):
        return _of_ordered(points, surface, degree, progress)
    settings: dict[str, Any] = {
        "tolerance": tolerance,
        "method": method,
        "surface": surface,
        "grid": grid,
        "degree": degree,
        "topology": topology,
        "fairness": fairness,
        "border": border,
        "max_control_points": max_control_points,
        "aspect": aspect,
        "seed": seed,
        "max_steps": max_steps,
        "reach": reach,
        "min_change": min_change,
    }
    converted = _core.as_points(points)
    made, trained, uv, distances, facts, history = _core.reconstruct(
        converted, **settings, progress=progress
    )
    som = SelfOrganizingMap._of_core(
        trained, seed=seed, max_steps=max_steps, reach=reach, min_change=min_change
    )
    report, mesh = _tessellated(made, facts, progress)
    kept = _read_only(converted)
    result = Reconstruction(kept, made, mesh, som, uv, distances, report, settings, history)
    for text in result.report.shortcomings():
        warnings.warn(text, ConvergenceWarning, stacklevel=2)
    return result


def _is_ordered(points: ArrayLike) -> bool:
    try:
        return np.ndim(points) == 3
    except ValueError:  # Rows that differ in length: whoever converts them says what is wrong.
        return False


def _of_ordered(
    points: ArrayLike,
    surface: str,
    degree: int,
    progress: Callable[[_core.Progress], object] | None,
) -> Reconstruction:
    """Make the surface of points in order, without a network."""
    start = time.perf_counter()
    made = _core.ordered_surface(points, surface, degree, progress)
    flat = np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3)
    feet = made.closest_points(flat)
    percents = (50, 90, 95, 99)
    percentiles = np.percentile(feet.distances, percents, method="inverted_cdf").tolist()
    rows, cols = made.control_points.shape[:2]
    facts: dict[str, Any] = dict(
        points=len(flat),
        diagonal=float(np.linalg.norm(np.ptp(flat, axis=0))),
        grid=(rows, cols),
        degree=made.degree,
        rms=float(np.sqrt(np.mean(feet.distances**2))),
        max=float(feet.distances.max()),
        percentiles=dict(zip(percents, percentiles, strict=True)),
        tolerance=None,
        within=None,
        ended_by="grid",
        fairness=None,
        iterations=0,
        warnings=(),
        steps=0,
        ordered_at=0,
        stopped_by="ordered",
        reached=len(flat),
        change=None,
        quantization_error=0.0,
        seconds={"surface": time.perf_counter() - start},
    )
    report, mesh = _tessellated(made, facts, progress)
    settings = {"surface": surface, "degree": degree}
    return Reconstruction(
        _read_only(flat), made, mesh, None, feet.uv, feet.distances, report, settings
    )


def _tessellated(
    surface: _core.NurbsSurface,
    facts: dict[str, Any],
    progress: Callable[[_core.Progress], object] | None,
) -> tuple[Report, _core.TriangleMesh]:
    """Return the report with the time that the mesh took, and the mesh."""
    start = time.perf_counter()
    mesh = surface.tessellate(progress=progress)
    seconds = facts["seconds"] | {"tessellation": time.perf_counter() - start}
    return Report(**facts | {"seconds": seconds}), mesh


def _read_only(points: NDArray[np.float64]) -> NDArray[np.float64]:
    view = points.view()
    view.flags.writeable = False
    return view
