"""The result of a reconstruction."""

from __future__ import annotations

import dataclasses
import functools
import os
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs import _core, candidate, diagnostics
from neurbs._core import NeurbsError
from neurbs.choices import Backend, LengthUnit, SurfaceColor, ViewChoice
from neurbs.errors import argument_error
from neurbs.reconstruction_report import Report, TrimReport
from neurbs.renamed import missing_attribute
from neurbs.som import SelfOrganizingMap

if TYPE_CHECKING:
    from neurbs.io import PointCloud

_LENGTHS: tuple[LengthUnit, ...] = get_args(LengthUnit)


@dataclasses.dataclass(frozen=True, eq=False)
class Reconstruction:
    """The result of `reconstruct`, in the coordinates and the unit of the points.

    Attributes
    ----------
    points : ndarray of shape (n, 3)
        The points: a read-only view of the given array, or of its conversion to float64.
    surface : NurbsSurface
        The whole surface, from which the deviations are measured.
    shell : Shell
        The faces of the surface: they end where the points end, unless that says no more than the
        sides of the surface. Each region with points has a face.
    som : SelfOrganizingMap
        The trained map.
    uv : ndarray of shape (n, 2)
        Parameters of each point's projection onto the surface.
    deviations : ndarray of shape (n,)
        Distance of each point to its projection.
    inliers : ndarray of bool, shape (n,)
        True for points used in the fit and their duplicates. False for outliers, points with
        weight 0 and points of other components.
    report : Report
        The figures of the fit, its candidates and diagnostics.
    settings : dict of str to object
        The options of the call.
    history : list of (str, int, float)
        Stage, step and error in the points' unit, for each epoch of the training and each later
        step.
    unit : str, optional
        The unit of the points, if it is given or they are a `PointCloud` that has one.
    """

    points: NDArray[np.float64] = dataclasses.field(repr=False)
    surface: _core.NurbsSurface
    shell: _core.Shell = dataclasses.field(repr=False)
    som: SelfOrganizingMap
    uv: NDArray[np.float64] = dataclasses.field(repr=False)
    deviations: NDArray[np.float64] = dataclasses.field(repr=False)
    inliers: NDArray[np.bool_] = dataclasses.field(repr=False)
    report: Report = dataclasses.field(repr=False)
    settings: dict[str, Any] = dataclasses.field(default_factory=dict, repr=False)
    history: list[tuple[str, int, float]] = dataclasses.field(default_factory=list, repr=False)
    unit: str | None = None

    if not TYPE_CHECKING:  # Type checkers must report missing attributes.

        def __getattr__(self, name: str) -> Any:
            """Raise for a missing attribute; for an old name the error gives the new one."""
            raise missing_attribute("'Reconstruction' object", name)

    @property
    def face(self) -> _core.Face:
        """The only face of the shell; an error if there are several."""
        faces = self.shell.faces
        if len(faces) != 1:
            raise NeurbsError(
                f"face must be the only one, got {len(faces)} faces: use result.shell.faces"
            )
        return faces[0]

    @functools.cached_property
    def mesh(self) -> _core.TriangleMesh:
        """The faces as triangles, as ``shell.tessellate`` makes them by default.

        It is made when it is first used.
        """
        return self.shell.tessellate()

    def z(self, x: ArrayLike, y: ArrayLike, *, out: NDArray[np.float64] | None = None) -> Any:
        """Return the height of the surface at x and y; see `NurbsSurface.z`."""
        return self.surface.z(x, y, out=out)

    def save(
        self, path: str | os.PathLike[str], *, unit: str | None = None, pcurves: bool = True
    ) -> None:
        """Write surface, mesh, picture or report to a file, by its suffix: see `neurbs.save`."""
        from neurbs import io

        io.save(self, path, unit=unit, pcurves=pcurves)

    def _file_parts(self) -> dict[str, Callable[[], Any]]:
        """Return the parts that files can store, in order of preference, for `neurbs.save`."""
        # A format that holds a surface only would lose trims.
        trimmed = any(face.is_trimmed for face in self.shell.faces)
        surface = {} if trimmed else {"surface": lambda: self.surface}
        return {
            "mesh": lambda: self.mesh,
            **surface,
            "shell": lambda: [self.shell],
            "points": self._with_distances,
            "picture": lambda: self,
            "report": lambda: self,
        }

    def _with_distances(self) -> PointCloud:
        """Return the points with their distances to the surface."""
        from neurbs.io import PointCloud

        distances = self.surface.closest_points(self.points).distances
        return PointCloud(self.points, distances=distances, unit=self.unit)

    def plot(
        self,
        *,
        color: SurfaceColor = "height",
        tolerance: float | None = None,
        unit: str = "",
        isolines: int = 20,
        view: ViewChoice = "iso",
        size: Sequence[float] | None = None,
        dpi: float = 100.0,
        exaggeration: float | None = None,
        backend: Backend = "matplotlib",
    ) -> Any:
        """Draw points, lattice and faces: see `neurbs.plot.plot_reconstruction`."""
        from neurbs.plot import plot_reconstruction

        return plot_reconstruction(
            self,
            color=color,
            tolerance=tolerance,
            unit=unit,
            isolines=isolines,
            view=view,
            size=size,
            dpi=dpi,
            exaggeration=exaggeration,
            backend=backend,
        )

    def write_report(
        self,
        path: str | os.PathLike[str],
        *,
        tolerance: float | None = None,
        unit: str = "",
        source: str | os.PathLike[str] | None = None,
        command: str | None = None,
    ) -> None:
        """Write a page with verdict, faces, deviations and settings: see `neurbs.report.write`."""
        from neurbs import report

        report.write(self, path, tolerance=tolerance, unit=unit, source=source, command=command)

    def _repr_html_(self) -> str:
        from neurbs.plot import reconstruction_html

        return reconstruction_html(self)


def scattered(points: ArrayLike) -> NDArray[np.float64]:
    """Return scattered points as an array for the core; raise for anything else."""
    if isinstance(points, str | os.PathLike):
        raise argument_error(
            "points",
            f"must be an array, got the path {os.fspath(points)!r}: "
            "read it with neurbs.read_points",
        )
    if _is_ordered(points):
        raise argument_error(
            "points",
            f"must be scattered, of shape (n, 3), got an ordered grid of shape {np.shape(points)}: "
            "use NurbsSurface.interpolate or NurbsSurface.approximate",
        )
    return _core.as_points(points)


def converted_to(points: Any, unit: LengthUnit | None) -> Any:
    """Return points in a unit: a `PointCloud` is converted, other points have no unit.

    Raises
    ------
    NeurbsError
        If the unit is unknown, or that of the cloud is no length.
    """
    if unit is None:
        return points
    from neurbs.io.units import check_unit

    check_unit(unit)
    # Not by its class, whose module would be loaded.
    return points.to_unit(unit) if isinstance(getattr(points, "unit", None), str) else points


def in_unit_of(points: object, result: Reconstruction, unit: str | None = None) -> Reconstruction:
    """Return a result in a unit, by default in that of its points if they are a `PointCloud`."""
    unit = unit or getattr(points, "unit", None)
    if not isinstance(unit, str):
        return result
    # A shell keeps lengths only.
    length = next((length for length in _LENGTHS if length == unit), None)
    shell = result.shell if length is None else result.shell.to_unit(length)
    return dataclasses.replace(result, unit=unit, shell=shell)


def wrapped(
    points: NDArray[np.float64], found: _core._Found, options: dict[str, Any], start: float
) -> Reconstruction:
    """Make a result from the output of the core; `start` is the time of the call."""
    surface, shell, trained, uv, deviations, inliers, facts, history = found
    som = SelfOrganizingMap._of_core(trained, facts.pop("som"))
    facts["candidates"] = candidate.of_core(facts["candidates"])
    facts["diagnostics"] = diagnostics.of_core(facts["diagnostics"])
    facts["trim"] = facts["trim"] and TrimReport(**facts["trim"])
    facts["seconds"] = _with_python(facts["seconds"], start)
    return Reconstruction(
        _read_only(points),
        surface,
        shell,
        som,
        uv,
        deviations,
        inliers,
        Report(**facts),
        options,
        history,
    )


def _with_python(seconds: dict[str, float], start: float) -> dict[str, float]:
    """Add the time since `start` that is not in a stage of the core."""
    rest = time.perf_counter() - start - sum(seconds.values())
    return seconds | {"python": max(rest, 0.0)}


def _is_ordered(points: ArrayLike) -> bool:
    try:
        return np.ndim(points) == 3 and np.shape(points)[2] == 3
    except ValueError:  # Rows of different lengths; the conversion to an array reports them.
        return False


def _read_only(points: NDArray[np.float64]) -> NDArray[np.float64]:
    view = points.view()
    view.flags.writeable = False
    return view
