"""The whole job: scattered points in, a surface out."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Iterator
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs import _core, diagnostics
from neurbs import reconstruction_chunks as chunks
from neurbs.errors import argument_error
from neurbs.reconstruction import Reconstruction, scattered, wrapped
from neurbs.renamed import without_old_keywords

_FEWEST = 4
"""Points of the smallest component that may be a surface."""


@overload
def reconstruct(
    points: ArrayLike | Iterator[ArrayLike],
    tolerance: float | None = None,
    *,
    kind: str = "auto",
    component: int | None = None,
    axis_scale: tuple[float, float, float] | None = None,
    grid: tuple[int, int] | None = None,
    degree: int = 3,
    init: ArrayLike | str = "auto",
    weights: ArrayLike | None = None,
    clean: bool = True,
    robust: bool = True,
    rational: bool = False,
    fairness: float | None = None,
    border: float | None = None,
    max_control_points: int = 40_000,
    aspect: str = "data",
    seed: int = 0,
    progress: Callable[[_core.Progress], object] | None = None,
) -> Reconstruction: ...


@overload
def reconstruct(
    points: ArrayLike | Iterator[ArrayLike],
    tolerance: float | None = None,
    *,
    kind: str = "auto",
    component: str,
    axis_scale: tuple[float, float, float] | None = None,
    grid: tuple[int, int] | None = None,
    degree: int = 3,
    init: ArrayLike | str = "auto",
    weights: ArrayLike | None = None,
    clean: bool = True,
    robust: bool = True,
    rational: bool = False,
    fairness: float | None = None,
    border: float | None = None,
    max_control_points: int = 40_000,
    aspect: str = "data",
    seed: int = 0,
    progress: Callable[[_core.Progress], object] | None = None,
) -> list[Reconstruction]: ...


@without_old_keywords
def reconstruct(
    points: ArrayLike | Iterator[ArrayLike],
    tolerance: float | None = None,
    *,
    kind: str = "auto",
    component: int | str | None = None,
    axis_scale: tuple[float, float, float] | None = None,
    grid: tuple[int, int] | None = None,
    degree: int = 3,
    init: ArrayLike | str = "auto",
    weights: ArrayLike | None = None,
    clean: bool = True,
    robust: bool = True,
    rational: bool = False,
    fairness: float | None = None,
    border: float | None = None,
    max_control_points: int = 40_000,
    aspect: str = "data",
    seed: int = 0,
    progress: Callable[[_core.Progress], object] | None = None,
) -> Reconstruction | list[Reconstruction]:
    """Turn scattered points into a NURBS surface.

    Duplicates are merged and gross outliers left out. Charts propose how the points may lie on a
    surface; coarse fits of the proposals are scored, and the best is refined: least squares with
    fairness pull a B-spline surface to the points, while their parameters follow it. A height field
    is fitted as z = f(x, y). A self-organizing map learns the points from the coarse surface.

    Parameters
    ----------
    points : array_like of shape (n, 3) or (n, 2)
        At least four distinct points, finite, not all on one line; two columns lie in z = 0. A
        C-contiguous float64 array is used as it is, anything else is converted once. To more than
        2^20 points, as many are fitted, evenly over space; all are measured. An iterator of
        chunks, or a larger memory map, is read chunk by chunk, in bounded memory, to the same
        result. Points in order, of shape (r, c, 3), belong to `NurbsSurface.interpolate` or
        `NurbsSurface.approximate`.
    tolerance : float, optional
        Distance from the surface within which all points shall lie, in their unit: the net grows
        until they do, or a diagnostic says why it did not. A tolerance never makes a surface
        worse. By default the net grows until cross-validation says that it would follow noise.
    kind : {"auto", "sheet", "height", "tube", "torus"}, default "auto"
        The kind of surface: open (sheet, or height for z = f(x, y)), closed in u (tube) or in both
        directions (torus). Closed directions are smooth across the seam. By default the candidate
        with the best score decides; ``report.candidates`` has all of them. The automatic choice
        may find heights along another direction, which is ``report.direction``.
    component : int or {"each"}, optional
        Which component of the cloud is fitted, 0 being the largest, or ``"each"`` for each by
        itself. By default all together, with a warning if there are several; see
        `neurbs.components`.
    axis_scale : (float, float, float), optional
        What each coordinate is divided by for the fit, where axes have different units. The result
        is in the points' units. By default 1, unless the extents show mixed units.
    grid : (int, int), optional
        Rows and columns of the control net. Their product is a budget, split by `aspect`.
    degree : int, default 3
        Degree of the surface in both directions, lowered where the net has too few rows or columns
        for it.
    init : {"auto", "geodesic", "pca"} or array_like of shape (rows, cols, 3), default "auto"
        Where the nodes of the map lie before it learns: on the best candidate, on the best by
        distances along the surface, on the best over a plane, or as given. A candidate of another
        chart is used where there is none.
    weights : array_like of shape (n,), optional
        What each point's squared distance counts; points with 0 are left out. By default 1.
    clean : bool, default True
        Whether duplicates are merged and gross outliers left out first; see `neurbs.clean`.
    robust : bool, default True
        Whether points that the fitted surface shows to be outliers lose their weight, by Tukey's
        biweight.
    rational : bool, default False
        Whether the weights of the control points are optimized at last, for what is round: it is
        kept where it is better.
    fairness : float, optional
        Weight of the energy of bending: 1 gives it as large a say as all points together. By
        default generalized cross-validation chooses it.
    border : float, optional
        About how far the surface goes on beyond the points where it is open, in their mean
        spacings: less where their border is sure, more where it is in doubt or they are sparse; by
        default 0.5. Heights end with the points.
    max_control_points : int, default 40000
        Control points at most, when the net grows.
    aspect : {"data", "fixed"}, default "data"
        How a budget of control points is split between rows and columns: by the lengths of the
        surface along both, or as given.
    seed : int, default 0
        Seed of everything random; the same seed gives the same bits.
    progress : callable, optional
        Called some 25 times a second with a `Progress`. An exception that it raises ends the job.

    Returns
    -------
    Reconstruction
        Surface, trained map, the points' parameters and deviations, and the report. With
        ``component="each"`` a list, one for each component that has points enough, the largest
        first.

    Raises
    ------
    NeurbsError
        If the points cannot be a surface, or an option is out of its range.
    KeyboardInterrupt
        On Ctrl-C, at once.

    Warns
    -----
    NeurbsWarning
        Once for each of ``report.diagnostics``; each code has a subclass.

    See Also
    --------
    candidates : The ranked hypotheses alone.
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
    for result in found:
        # To who called this function, which is wrapped once.
        diagnostics.warn(result.report.diagnostics, stacklevel=3)
    return found if isinstance(component, str) else found[0]


def _of_each(
    points: ArrayLike | Iterator[ArrayLike],
    options: dict[str, Any],
    progress: Callable[[_core.Progress], object] | None,
    start: float,
) -> list[Reconstruction]:
    """Fit each component by itself; the first one's time has the search for them."""
    if isinstance(points, Iterator) or chunks.is_large_map(points):
        raise argument_error("component", "must be left out where points come in chunks")
    converted = scattered(points)
    kept = _core.clean(converted).kept if options["clean"] else np.arange(len(converted))
    sizes = _core.components(converted[kept], progress=progress).sizes
    found = []
    for component, size in enumerate(sizes):
        if size >= _FEWEST:
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
    """Fit some of the points, and measure all chunk by chunk."""
    for name in ("weights", "component"):
        if options[name] is not None:
            raise argument_error(name, "must be left out where points come in chunks")
    cloud = chunks.mapped(points)
    sample, places, diagonal = chunks.sampled(cloud)
    fitted = _of_scattered(sample, options, progress, start)
    begun = time.perf_counter()
    known = (fitted.uv, fitted.deviations, fitted.inliers)
    uv, deviations, inliers = chunks.measured(fitted.surface, cloud, places, known)
    near = chunks.Summary(deviations, inliers)
    tolerance = options["tolerance"]
    seconds = fitted.report.seconds
    report = dataclasses.replace(
        fitted.report,
        points=len(cloud),
        inliers=near.count,
        diagonal=diagonal,
        rms=near.rms,
        max=near.max,
        percentiles={percent: near.quantile(percent / 100) for percent in (50, 90, 95, 99)},
        within=None if tolerance is None else near.share_within(tolerance),
        seconds=seconds | {"measure": seconds["measure"] + time.perf_counter() - begun},
    )
    return dataclasses.replace(
        fitted, points=cloud, uv=uv, deviations=deviations, inliers=inliers, report=report
    )
