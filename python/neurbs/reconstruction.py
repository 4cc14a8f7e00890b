"""The whole job: scattered points in, a surface out."""

from __future__ import annotations

import dataclasses
import functools
import os
import time
import warnings
from collections.abc import Callable, Iterator
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs import _core
from neurbs import reconstruction_chunks as chunks
from neurbs.reconstruction_report import Report
from neurbs.som import ConvergenceWarning, SelfOrganizingMap

_FEWEST = 4
"""Points of the smallest piece that may be a surface."""


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
    som : SelfOrganizingMap
        The trained map; of points that were in order already, the points themselves.
    uv : ndarray of shape (n, 2)
        Where on the surface each point has its foot; of heights in another unit than x and y,
        where it lies straight above or below.
    distances : ndarray of shape (n,)
        Each point's distance from there.
    inliers : ndarray of bool, shape (n,)
        Which points count: neither gross outliers nor shown to be outliers by the surface, nor of
        another piece or without weight.
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
    som: SelfOrganizingMap
    uv: NDArray[np.float64] = dataclasses.field(repr=False)
    distances: NDArray[np.float64] = dataclasses.field(repr=False)
    inliers: NDArray[np.bool_] = dataclasses.field(repr=False)
    report: Report = dataclasses.field(repr=False)
    settings: dict[str, Any] = dataclasses.field(default_factory=dict, repr=False)
    history: list[tuple[str, int, float]] = dataclasses.field(default_factory=list, repr=False)

    @functools.cached_property
    def mesh(self) -> _core.TriangleMesh:
        """The surface as triangles, none farther from it than 0.001 of the net's diagonal.

        Made when it is asked for first; ``surface.tessellate`` makes others.
        """
        return self.surface.tessellate()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write surface, mesh or picture to a file; the suffix picks, as in `neurbs.save`."""
        from neurbs import io

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


@overload
def reconstruct(
    points: ArrayLike | Iterator[ArrayLike],
    tolerance: float | None = None,
    *,
    method: str = "fit",
    surface: str = "control-net",
    grid: tuple[int, int] | None = None,
    degree: int = 3,
    topology: str = "auto",
    init: ArrayLike | str = "auto",
    weights: ArrayLike | None = None,
    clean: bool = True,
    robust: bool = True,
    pieces: int | None = None,
    rational: bool = False,
    fairness: float | None = None,
    border: float | None = None,
    max_control_points: int = 40_000,
    aspect: str = "data",
    seed: int = 0,
    max_steps: int | None = None,
    reach: float | None = None,
    min_change: float | None = None,
    progress: Callable[[_core.Progress], object] | None = None,
) -> Reconstruction: ...


@overload
def reconstruct(
    points: ArrayLike | Iterator[ArrayLike],
    tolerance: float | None = None,
    *,
    method: str = "fit",
    surface: str = "control-net",
    grid: tuple[int, int] | None = None,
    degree: int = 3,
    topology: str = "auto",
    init: ArrayLike | str = "auto",
    weights: ArrayLike | None = None,
    clean: bool = True,
    robust: bool = True,
    pieces: str,
    rational: bool = False,
    fairness: float | None = None,
    border: float | None = None,
    max_control_points: int = 40_000,
    aspect: str = "data",
    seed: int = 0,
    max_steps: int | None = None,
    reach: float | None = None,
    min_change: float | None = None,
    progress: Callable[[_core.Progress], object] | None = None,
) -> list[Reconstruction]: ...


def reconstruct(
    points: ArrayLike | Iterator[ArrayLike],
    tolerance: float | None = None,
    *,
    method: str = "fit",
    surface: str = "control-net",
    grid: tuple[int, int] | None = None,
    degree: int = 3,
    topology: str = "auto",
    init: ArrayLike | str = "auto",
    weights: ArrayLike | None = None,
    clean: bool = True,
    robust: bool = True,
    pieces: int | str | None = None,
    rational: bool = False,
    fairness: float | None = None,
    border: float | None = None,
    max_control_points: int = 40_000,
    aspect: str = "data",
    seed: int = 0,
    max_steps: int | None = None,
    reach: float | None = None,
    min_change: float | None = None,
    progress: Callable[[_core.Progress], object] | None = None,
) -> Reconstruction | list[Reconstruction]:
    """Turn scattered points into a NURBS surface.

    Duplicates are merged and gross outliers left out. A self-organizing map brings the points in
    order from a start that follows the surface, however folded it is; least squares with fairness
    then pull a B-spline surface to the points, while their parameters follow it. Heights over a
    plane need no map to be in order: they are fitted as z = f(x, y). Points that are in order
    already, an array of shape (r, c, 3), become a surface as the paper's lattice does.

    Parameters
    ----------
    points : array_like of shape (n, 3) or (n, 2)
        At least four distinct points, finite, not all on one line; two columns lie in z = 0. A
        C-contiguous float64 array is used as it is, anything else is converted once. Of shape
        (r, c, 3) they are the rows of an ordered grid, and the lattice themselves: only `surface`,
        `degree` and `progress` have a meaning then. To more than 2^20 points, as many are fitted,
        evenly over space; all are measured. An iterator of chunks, or a larger memory map, is read
        chunk by chunk, in bounded memory, to the same result.
    tolerance : float, optional
        Distance from the surface within which all points shall lie, in their unit: the net grows
        until they do, or says why it did not. No surface folds over to keep it. By default the net
        grows until cross-validation says that it would follow noise.
    method : {"fit", "paper"}, default "fit"
        How the surface comes from the points: by least squares, or by the paper's method, where
        the trained lattice itself makes the surface.
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
    topology : {"auto", "sheet", "height", "tube", "torus"}, default "auto"
        What kind of surface the points lie on: open (sheet, or height for heights over a plane),
        closed in u (tube) or in both directions (torus). Closed directions are smooth across the
        seam. By default it is found out, and the report says why; sheets that turn out to be
        heights over a rectangle, or a ground that trees stand on, are fitted as such. So are those
        that would fold over or run away whatever their net; where tubes and tori would, they become
        round ones.
    init : {"auto", "geodesic", "pca"} or array_like of shape (rows, cols, 3), default "auto"
        Where the nodes of the map lie before it learns: in order along the surface, in the
        principal plane, or as given. By default along the surface, or in the plane if that turns
        out better.
    weights : array_like of shape (n,), optional
        What each point's squared distance counts; points with 0 are left out. By default 1.
    clean : bool, default True
        Whether duplicates are merged and gross outliers left out first; see `neurbs.clean`.
    robust : bool, default True
        Whether points that the fitted surface shows to be outliers lose their weight, by Tukey's
        biweight.
    pieces : int or {"each"}, optional
        Which of the pieces that the cloud falls into is fitted, 0 being the largest, or ``"each"``
        for each by itself. By default all together, with a warning if there are several; see
        `neurbs.pieces`.
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
        surface along both, or as given. With ``"fixed"``, ``grid`` is the net: points of a surface
        that has it give that surface back, as far as it is found and ``fairness``, ``border`` and
        the like are left open; ``result.report.ended_by`` is ``"exact"`` then.
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
        Surface, trained map, the points' parameters and distances, and the report. With
        ``pieces="each"`` a list, one for each piece that has points enough, the largest first.

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
    if isinstance(points, str | os.PathLike):
        raise _core.NeurbsError(
            f"points must be an array, got the path {os.fspath(points)!r}: "
            "read it with neurbs.read_points"
        )
    if not isinstance(points, Iterator) and _is_ordered(points):
        return _of_ordered(points, surface, degree, progress)
    options: dict[str, Any] = {
        "tolerance": tolerance,
        "method": method,
        "surface": surface,
        "grid": grid,
        "degree": degree,
        "topology": topology,
        "init": init,
        "weights": weights,
        "clean": clean,
        "robust": robust,
        "pieces": pieces,
        "rational": rational,
        "fairness": fairness,
        "border": border,
        "max_control_points": max_control_points,
        "aspect": aspect,
        "seed": seed,
        "max_steps": max_steps,
        "reach": reach,
        "min_change": min_change,
    }
    if isinstance(points, Iterator) or chunks.is_large_map(points):
        return _of_chunks(points, options, progress)
    converted = _core.as_points(points)
    if not isinstance(pieces, str):
        return _of_scattered(converted, options, progress)
    if pieces != "each":
        raise _core.NeurbsError(f"pieces must be a number or 'each', got {pieces!r}")
    kept = _core.clean(converted).kept if clean else np.arange(len(converted))
    sizes = _core.pieces(converted[kept], progress=progress).sizes
    return [
        _of_scattered(converted, options | {"pieces": piece}, progress)
        for piece, size in enumerate(sizes)
        if size >= _FEWEST
    ]


def _of_scattered(
    points: NDArray[np.float64],
    options: dict[str, Any],
    progress: Callable[[_core.Progress], object] | None,
) -> Reconstruction:
    surface, trained, uv, distances, inliers, facts, history = _core.reconstruct(
        points, options, progress
    )
    training = ("seed", "max_steps", "reach", "min_change")
    som = SelfOrganizingMap._of_core(trained, **{name: options[name] for name in training})
    report = Report(**facts)
    result = Reconstruction(
        _read_only(points), surface, som, uv, distances, inliers, report, options, history
    )
    for text in report.shortcomings():
        warnings.warn(text, ConvergenceWarning, stacklevel=3)
    return result


def _of_chunks(
    points: object,
    options: dict[str, Any],
    progress: Callable[[_core.Progress], object] | None,
) -> Reconstruction:
    """Fit some of the points, and measure all chunk by chunk."""
    for name in ("weights", "pieces"):
        if options[name] is not None:
            raise _core.NeurbsError(f"{name} must be left out where points come in chunks")
    cloud = chunks.mapped(points)
    sample, places, diagonal = chunks.sampled(cloud)
    fitted = _of_scattered(sample, options, progress)
    start = time.perf_counter()
    known = (fitted.uv, fitted.distances, fitted.inliers)
    uv, distances, inliers = chunks.measured(fitted.surface, cloud, places, known)
    near = chunks.Summary(distances, inliers)
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
        seconds=seconds | {"measuring": seconds["measuring"] + time.perf_counter() - start},
    )
    return dataclasses.replace(
        fitted, points=cloud, uv=uv, distances=distances, inliers=inliers, report=report
    )


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
    report = Report(
        points=len(flat),
        inliers=len(flat),
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
        topology="sheet",
        topology_reason=None,
        duplicates=0,
        outliers=0,
        warnings=(),
        steps=0,
        ordered_at=0,
        stopped_by="ordered",
        reached=len(flat),
        change=None,
        quantization_error=0.0,
        seconds={"surface": time.perf_counter() - start},
    )
    settings = {"surface": surface, "degree": degree}
    inliers = np.ones(len(flat), dtype=bool)
    lattice = flat.reshape(np.shape(points))
    som = SelfOrganizingMap(*lattice.shape[:2], init=lattice).start(flat)
    return Reconstruction(
        _read_only(flat), made, som, feet.uv, feet.distances, inliers, report, settings
    )


def _read_only(points: NDArray[np.float64]) -> NDArray[np.float64]:
    view = points.view()
    view.flags.writeable = False
    return view
