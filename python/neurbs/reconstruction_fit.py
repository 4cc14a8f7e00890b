"""`neurbs.reconstruct`: scattered points to a surface.

The module is not called ``reconstruct``: importing it would replace the function of this name.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Iterator
from typing import Any, Literal, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs import _core, diagnostics
from neurbs import reconstruction_chunks as chunks
from neurbs.choices import KindChoice, LengthUnit, Positions, TrimChoice
from neurbs.errors import argument_error
from neurbs.reconstruction import Reconstruction, converted_to, in_unit_of, scattered, wrapped
from neurbs.renamed import without_old_keywords

_MIN_POINTS = 4
"""Fewest points of a component that a surface is fitted to."""


@overload
def reconstruct(
    points: ArrayLike | Iterator[ArrayLike],
    tolerance: float | None = None,
    *,
    kind: KindChoice = "auto",
    component: int | None = None,
    axis_scale: tuple[float, float, float] | None = None,
    grid: tuple[int, int] | None = None,
    degree: int = 3,
    init: Positions | Literal["auto", "geodesic", "pca"] = "auto",
    weights: ArrayLike | None = None,
    clean: bool = True,
    robust: bool = True,
    rational: bool = False,
    fairness: float | None = None,
    border: float | None = None,
    trim: TrimChoice = "auto",
    max_control_points: int = 40_000,
    aspect: Literal["data", "fixed"] = "data",
    seed: int = 0,
    unit: LengthUnit | None = None,
    progress: Callable[[_core.Progress], object] | None = None,
) -> Reconstruction: ...


@overload
def reconstruct(
    points: ArrayLike | Iterator[ArrayLike],
    tolerance: float | None = None,
    *,
    kind: KindChoice = "auto",
    component: Literal["each"],
    axis_scale: tuple[float, float, float] | None = None,
    grid: tuple[int, int] | None = None,
    degree: int = 3,
    init: Positions | Literal["auto", "geodesic", "pca"] = "auto",
    weights: ArrayLike | None = None,
    clean: bool = True,
    robust: bool = True,
    rational: bool = False,
    fairness: float | None = None,
    border: float | None = None,
    trim: TrimChoice = "auto",
    max_control_points: int = 40_000,
    aspect: Literal["data", "fixed"] = "data",
    seed: int = 0,
    unit: LengthUnit | None = None,
    progress: Callable[[_core.Progress], object] | None = None,
) -> list[Reconstruction]: ...


@without_old_keywords
def reconstruct(
    points: ArrayLike | Iterator[ArrayLike],
    tolerance: float | None = None,
    *,
    kind: KindChoice = "auto",
    component: int | Literal["each"] | None = None,
    axis_scale: tuple[float, float, float] | None = None,
    grid: tuple[int, int] | None = None,
    degree: int = 3,
    init: Positions | Literal["auto", "geodesic", "pca"] = "auto",
    weights: ArrayLike | None = None,
    clean: bool = True,
    robust: bool = True,
    rational: bool = False,
    fairness: float | None = None,
    border: float | None = None,
    trim: TrimChoice = "auto",
    max_control_points: int = 40_000,
    aspect: Literal["data", "fixed"] = "data",
    seed: int = 0,
    unit: LengthUnit | None = None,
    progress: Callable[[_core.Progress], object] | None = None,
) -> Reconstruction | list[Reconstruction]:
    """Turn scattered points into a NURBS surface.

    Duplicates are merged and gross outliers left out. Each chart proposes parameters (u, v) for the
    points. A coarse fit of each proposal gets a score, and the best is refined. A B-spline surface
    is fitted by least squares with fairness, and the parameters of the points are corrected. A
    height field is fitted as z = f(x, y). A self-organizing map is trained from the coarse surface.
    Loops around the points, and around holes in them, bound the faces.

    Parameters
    ----------
    points : array_like of shape (n, 3) or (n, 2)
        At least four distinct points, finite, not all on one line; two columns lie in z = 0. A
        C-contiguous float64 array is used without a copy, anything else is converted once. Of more
        than 2^20 points, a sample of this size that is even in space is fitted, and all are
        measured. An iterator of chunks, or a larger memory map, is read chunk by chunk in bounded
        memory, with the same result. For an ordered grid of shape (r, c, 3) use
        `NurbsSurface.interpolate` or `NurbsSurface.approximate`.
    tolerance : float, optional
        Largest distance from a point to the surface, in the points' unit. The net grows until all
        points are within it, or a diagnostic gives the reason why not. A tolerance never makes a
        surface worse. By default the net grows until, by cross-validation, it would follow noise.
    kind : {"auto", "sheet", "height", "tube", "torus"}, default "auto"
        The kind of surface: open (sheet, or height for z = f(x, y)), closed in u (tube) or in both
        directions (torus). Closed directions are smooth across the seam. By default it is the kind
        of the candidate with the best score; ``report.candidates`` has all of them. The automatic
        choice may find heights along another direction, given by ``report.direction``.
    component : int or {"each"}, optional
        The component of the cloud to fit, 0 being the largest, or ``"each"`` for a surface of each.
        By default one surface is fitted to all, with a warning if there are several; see
        `neurbs.components`.
    axis_scale : (float, float, float), optional
        Divisors of the three coordinates for the fit, where axes have different units. The result
        is in the points' units. By default 1, unless the extents show mixed units.
    grid : (int, int), optional
        Rows and columns of the control net. With ``aspect="data"`` only their product is kept.
    degree : int, default 3
        Degree of the surface in both directions; lower where the net has too few rows or columns.
    init : {"auto", "geodesic", "pca"} or array_like of shape (rows, cols, 3), default "auto"
        Start of the nodes of the map: on the best candidate (``"auto"``), on the best by distances
        along the surface (``"geodesic"``), on the best over a plane (``"pca"``), or given
        positions. Without a candidate of that sort, the best of the others is used.
    weights : array_like of shape (n,), optional
        Weights of the squared distances; points with weight 0 are left out. By default 1.
    clean : bool, default True
        Whether to merge duplicates and leave out gross outliers first; see `neurbs.clean`.
    robust : bool, default True
        Whether to lower the weights of outliers of the fitted surface, by Tukey's biweight.
    rational : bool, default False
        Whether to optimize the weights of the control points at the end, for round shapes. The
        rational surface is kept if it fits better.
    fairness : float, optional
        Weight of the fairness energy: 1 makes it as important as all points together. The energy
        sums squared third derivatives, or second ones where points are few. By default the weight
        is chosen by generalized cross-validation.
    border : float, optional
        Extension of the whole surface beyond the points at open sides, in mean spacings of the
        points, by default 0.5. A height field ends with the points.
    trim : {"auto", True, "outer", False}, default "auto"
        Whether faces end where the points end, and leave holes open; see `neurbs.trim`. With
        ``"auto"`` the face is the whole surface where loops are doubtful, or say no more than the
        sides of the surface. ``"outer"`` covers holes. Deviations are measured from the whole
        surface all the same.
    max_control_points : int, default 40000
        Most control points of a net that grows.
    aspect : {"data", "fixed"}, default "data"
        Ratio of rows to columns: by the lengths of the surface in both directions, or as `grid`
        gives it.
    seed : int, default 0
        Seed of all random numbers; the same seed gives the same bits.
    unit : {"mm", "cm", "m", "in", "ft"}, optional
        The unit of the result, and of lengths such as `tolerance`. A `PointCloud` with another unit
        is converted; points without one are taken to be in it. By default that of the cloud.
    progress : callable, optional
        Called some 25 times a second with a `Progress`. An exception that it raises ends the job.

    Returns
    -------
    Reconstruction
        Surface, faces, trained map, the points' parameters and deviations, and the report. With
        ``component="each"`` a list, one for each component with enough points, the largest first.

    Raises
    ------
    NeurbsError
        If no surface fits the points (fewer than four distinct ones, or all on one line), or an
        option is out of its range.
    KeyboardInterrupt
        On Ctrl-C, at once.

    Warns
    -----
    NeurbsWarning
        One for each of ``report.diagnostics``; each code has a subclass.

    See Also
    --------
    candidates : The ranked hypotheses without a final fit.
    reconstruct_paper : The paper's method.
    recover_net : Exact recovery of a net from points of its surface.

    References
    ----------
    W. Wang, H. Pottmann and Y. Liu, Fitting B-spline curves to point clouds by curvature-based
    squared distance minimization, ACM Transactions on Graphics 25 (2006).
    https://doi.org/10.1145/1138450.1138453

    Examples
    --------
    >>> import numpy as np
    >>> import neurbs
    >>> x, y = np.random.default_rng(0).random((2, 500))
    >>> result = neurbs.reconstruct(np.column_stack([x, y, np.sin(3 * x) * y]), grid=(10, 8))
    >>> result.surface
    NurbsSurface(net 10 × 8, degree (3, 3), domain [0, 1] × [0, 1], polynomial, open)
    >>> result.report.rms < 1e-3, result.report.valid
    (True, True)
    """
    start = time.perf_counter()
    points = converted_to(points, unit)
    options: dict[str, Any] = {
        "tolerance": tolerance,
        "kind": kind,
        "component": component,
        "axis_scale": axis_scale,
        "grid": grid,
        "degree": degree,
        "init": init,
        "weights": weights,
        "clean": clean,
        "robust": robust,
        "rational": rational,
        "fairness": fairness,
        "border": border,
        "trim": trim,
        "max_control_points": max_control_points,
        "aspect": aspect,
        "seed": seed,
    }
    if isinstance(component, str):
        if component != "each":
            raise argument_error("component", f"must be a number or 'each', got {component!r}")
        found = _of_each(points, options, progress, start)
    elif isinstance(points, Iterator) or chunks.is_large_map(points):
        found = [_of_chunks(points, options, progress, start)]
    else:
        found = [_of_scattered(scattered(points), options, progress, start)]
    found = [in_unit_of(points, result, unit) for result in found]
    for result in found:
        # The caller is one level farther away, because this function is wrapped.
        diagnostics.warn(result.report.diagnostics, stacklevel=3)
    return found if isinstance(component, str) else found[0]


def _of_each(
    points: ArrayLike | Iterator[ArrayLike],
    options: dict[str, Any],
    progress: Callable[[_core.Progress], object] | None,
    start: float,
) -> list[Reconstruction]:
    """Fit each component; the time of the first includes the search for components."""
    if isinstance(points, Iterator) or chunks.is_large_map(points):
        raise argument_error("component", "must be left out for points in chunks")
    converted = scattered(points)
    kept = _core.clean(converted).kept if options["clean"] else np.arange(len(converted))
    sizes = _core.components(converted[kept], progress=progress).sizes
    found = []
    for component, size in enumerate(sizes):
        if size >= _MIN_POINTS:
            own = options | {"component": component}
            found.append(_of_scattered(converted, own, progress, start))
            start = time.perf_counter()
    return found


def _of_scattered(
    points: NDArray[np.float64],
    options: dict[str, Any],
    progress: Callable[[_core.Progress], object] | None,
    start: float,
) -> Reconstruction:
    return wrapped(points, _core.reconstruct(points, options, progress), options, start)


def _of_chunks(
    points: object,
    options: dict[str, Any],
    progress: Callable[[_core.Progress], object] | None,
    start: float,
) -> Reconstruction:
    """Fit an even sample of the points, and measure all of them chunk by chunk."""
    for name in ("weights", "component"):
        if options[name] is not None:
            raise argument_error(name, "must be left out for points in chunks")
    cloud = chunks.mapped(points)
    sample, indices, diagonal = chunks.sampled(cloud)
    fitted = _of_scattered(sample, options, progress, start)
    measure_start = time.perf_counter()
    known = (fitted.uv, fitted.deviations, fitted.inliers)
    uv, deviations, inliers = chunks.measured(fitted.surface, cloud, indices, known)
    summary = chunks.Summary(deviations, inliers)
    tolerance = options["tolerance"]
    seconds = fitted.report.seconds
    report = dataclasses.replace(
        fitted.report,
        points=len(cloud),
        inliers=summary.count,
        diagonal=diagonal,
        rms=summary.rms,
        max=summary.max,
        percentiles={percent: summary.quantile(percent / 100) for percent in (50, 90, 95, 99)},
        within=None if tolerance is None else summary.share_within(tolerance),
        seconds=seconds | {"measure": seconds["measure"] + time.perf_counter() - measure_start},
    )
    return dataclasses.replace(
        fitted, points=cloud, uv=uv, deviations=deviations, inliers=inliers, report=report
    )
