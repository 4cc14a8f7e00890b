"""`neurbs.reconstruct_paper`: the method of Hoffmann and Várady (1998)."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Literal

from numpy.typing import ArrayLike

from neurbs import _core, diagnostics
from neurbs.choices import LengthUnit
from neurbs.reconstruction import Reconstruction, converted_to, in_unit_of, scattered, wrapped


def reconstruct_paper(
    points: ArrayLike,
    *,
    grid: tuple[int, int] | None = None,
    degree: int = 3,
    surface: Literal["control-net", "interpolate", "bezier"] = "control-net",
    max_steps: int | None = None,
    reach: float | None = None,
    min_change: float | None = None,
    seed: int = 0,
    unit: LengthUnit | None = None,
    progress: Callable[[_core.Progress], object] | None = None,
) -> Reconstruction:
    """Turn scattered points into a surface by the paper's method.

    A Kohonen network is trained with the points (section 4 of the paper). Its lattice becomes the
    control net of a clamped B-spline surface, a grid to interpolate, or a Bézier net (section 5).

    Parameters
    ----------
    points : array_like of shape (n, 3) or (n, 2)
        At least four distinct points, finite, not all on one line; two columns lie in z = 0.
    grid : (int, int), optional
        Rows and columns of the lattice. By default there are four nodes for each point, at least
        400 for many points and at most 2500. A Bézier surface has from 2 to 26 rows and
        columns, by default at most 10.
    degree : int, default 3
        Degree of the surface in both directions; lower where the lattice has too few rows or
        columns. The degrees of a Bézier surface are one less than rows and columns.
    surface : {"control-net", "interpolate", "bezier"}, default "control-net"
        Use of the lattice: as the control net of a clamped B-spline surface, as points that a
        B-spline surface interpolates, or as the control net of one Bézier surface.
    max_steps : int, optional
        Most steps of training; by default 500 for each node.
    reach : float, optional
        A point is on the lattice when a node is within this distance, in the points' unit; by
        default 0.001 of the diagonal of their bounding box. Training ends when all points are.
    min_change : float, optional
        Training ends when no node has moved farther than this during an epoch, in the points'
        unit; by default 0.05 of the lattice's mean spacing.
    seed : int, default 0
        Seed of all random numbers; the same seed gives the same bits.
    unit : {"mm", "cm", "m", "in", "ft"}, optional
        The unit of the result; see `neurbs.reconstruct`.
    progress : callable, optional
        Called some 25 times a second with a `Progress`. An exception that it raises ends the job.

    Returns
    -------
    Reconstruction
        Surface, trained map, the points' parameters and deviations, and the report.

    Raises
    ------
    NeurbsError
        If no surface fits the points (fewer than four distinct ones, or all on one line), or an
        option is out of its range.
    KeyboardInterrupt
        On Ctrl-C, at once.

    Warns
    -----
    ConvergenceWarning
        If training ended after `max_steps`, before the lattice settled.

    References
    ----------
    M. Hoffmann and L. Várady, Free-form Surfaces for Scattered Data by Neural Networks, Journal
    for Geometry and Graphics 2 (1998).

    Examples
    --------
    >>> import numpy as np
    >>> import neurbs
    >>> x, y = np.random.default_rng(0).random((2, 500))
    >>> points = np.column_stack([x, y, np.sin(3 * x) * y])
    >>> neurbs.reconstruct_paper(points, grid=(10, 8)).surface
    NurbsSurface(net 10 × 8, degree (3, 3), domain [0, 1] × [0, 1], polynomial, open)
    """
    start = time.perf_counter()
    points = converted_to(points, unit)
    options: dict[str, Any] = {
        "grid": grid,
        "degree": degree,
        "surface": surface,
        "max_steps": max_steps,
        "reach": reach,
        "min_change": min_change,
        "seed": seed,
    }
    converted = scattered(points)
    found = _core.reconstruct_paper(converted, options, progress)
    result = wrapped(converted, found, options, start)
    result = in_unit_of(points, result, unit)
    diagnostics.warn(result.report.diagnostics, stacklevel=2)
    return result
