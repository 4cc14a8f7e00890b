"""The whole job: scattered points in, a surface out."""

from __future__ import annotations

import dataclasses
import os
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
    steps : int
        Presentations made in training.
    ordered_at : int
        The step from which on the radius was zero.
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
        Time spent on ``"training"`` (with checking and measuring) and on ``"tessellation"``.
    """

    points: int
    diagonal: float
    grid: tuple[int, int]
    degree: tuple[int, int]
    steps: int
    ordered_at: int
    stopped_by: str
    reached: int
    change: float | None
    quantization_error: float
    seconds: dict[str, float]

    @property
    def converged(self) -> bool:
        """Whether training ended by itself, not because its steps were over."""
        return self.stopped_by != "max_steps"

    def to_dict(self) -> dict[str, Any]:
        """Return all of it as plain values, as JSON has them."""
        values = dataclasses.asdict(self) | {"converged": self.converged}
        return values | {"grid": list(self.grid), "degree": list(self.degree)}


@dataclasses.dataclass(frozen=True, eq=False)
class Reconstruction:
    """What `reconstruct` returns, everything in the points' own frame and unit.

    Attributes
    ----------
    points : ndarray of shape (n, 3)
        The points: a read-only view of the array that was given, or of its conversion.
    surface : NurbsSurface
        The surface.
    mesh : TriangleMesh
        The surface as triangles.
    som : SelfOrganizingMap
        The trained map.
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
    som: SelfOrganizingMap
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
    *,
    method: str = "paper",
    grid: tuple[int, int] | None = None,
    degree: int = 3,
    seed: int = 0,
    max_steps: int | None = None,
    reach: float | None = None,
    min_change: float | None = None,
    progress: Callable[[_core.Progress], object] | None = None,
) -> Reconstruction:
    """Turn scattered points into a NURBS surface.

    A Kohonen network learns the points, its lattice becomes the control net of a clamped B-spline
    surface, which is tessellated uniformly.

    Parameters
    ----------
    points : array_like of shape (n, 3) or (n, 2)
        At least four distinct points, finite, not all on one line; two columns lie in z = 0. A
        C-contiguous float64 array is used as it is, anything else is converted once.
    method : {"paper"}, default "paper"
        How the surface comes from the points: by the paper's method, the trained lattice is the
        control net.
    grid : (int, int), optional
        Rows and columns of the lattice, and so of the control net; by default four nodes for each
        of few points, at least 400 nodes for many, and up to 2500.
    degree : int, default 3
        Degree of the surface in both directions, lowered where the net has too few rows or columns
        for it.
    seed : int, default 0
        Seed of everything random; the same seed gives the same bits.
    max_steps : int, optional
        Steps of training at most; by default 500 for each node.
    reach : float, optional
        A point is on the lattice when a node is at most this far, in the points' unit; by default
        0.001 of the diagonal of their bounding box. When all are, training ends.
    min_change : float, optional
        Training ends when no node has moved farther than this during an epoch, in the points'
        unit; by default 0.05 of the lattice's mean spacing.
    progress : callable, optional
        Called some 25 times a second with a `Progress`. An exception that it raises ends the job.

    Returns
    -------
    Reconstruction
        Surface, mesh, trained map and report.

    Raises
    ------
    NeurbsError
        If the points cannot be a surface, or an option is out of its range.
    KeyboardInterrupt
        On Ctrl-C, at once.

    Warns
    -----
    ConvergenceWarning
        If training ended because its steps were over.

    References
    ----------
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
    >>> result.report.stopped_by
    'settled'
    """
    settings: dict[str, Any] = {
        "method": method,
        "grid": grid,
        "degree": degree,
        "seed": seed,
        "max_steps": max_steps,
        "reach": reach,
        "min_change": min_change,
    }
    converted = _core.as_points(points)
    surface, mesh, trained, report, history = _core.reconstruct(
        converted, **settings, progress=progress
    )
    som = SelfOrganizingMap._of_core(
        trained, seed=seed, max_steps=max_steps, reach=reach, min_change=min_change
    )
    if converted is not points:
        converted.flags.writeable = False
    kept = converted.view()
    kept.flags.writeable = False
    result = Reconstruction(kept, surface, mesh, som, Report(**report), settings, history)
    if not result.report.converged:
        change = result.report.change
        moved = "" if change is None else f", while the lattice still moved {change:.3g} an epoch"
        warnings.warn(
            f"training ended after max_steps={result.report.steps} steps{moved}: "
            "give it more steps, or raise min_change",
            ConvergenceWarning,
            stacklevel=2,
        )
    return result
