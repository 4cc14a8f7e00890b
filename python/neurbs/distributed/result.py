"""The result of a reconstruction over parts."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs import _core
from neurbs.distributed.report import DistributedReport
from neurbs.reconstruction import Reconstruction
from neurbs.som import SelfOrganizingMap


@dataclasses.dataclass(frozen=True, eq=False)
class DistributedReconstruction:
    """The result of `neurbs.distributed.reconstruct`.

    Arrays over all points are those of Dask and are computed when they are used.

    Attributes
    ----------
    sample : Reconstruction
        The result with the even sample as its points; its surface is fitted to all points, and its
        report is about all points.
    points : dask array of shape (n, 3)
        All points.
    uv : dask array of shape (n, 2)
        Parameters of each point's projection onto the surface.
    deviations : dask array of shape (n,)
        Distance of each point to its projection.
    inliers : dask array of bool, shape (n,)
        True for points used in the fit, False for outliers.
    report : DistributedReport
        The figures of all points, with the rounds.
    """

    sample: Reconstruction
    points: Any = dataclasses.field(repr=False)
    uv: Any = dataclasses.field(repr=False)
    deviations: Any = dataclasses.field(repr=False)
    inliers: Any = dataclasses.field(repr=False)
    report: DistributedReport = dataclasses.field(repr=False)

    @property
    def surface(self) -> _core.NurbsSurface:
        """The whole surface, from which the deviations are measured."""
        return self.sample.surface

    @property
    def shell(self) -> _core.Shell:
        """The faces of the surface, which end where the even sample ends."""
        return self.sample.shell

    @property
    def face(self) -> _core.Face:
        """The only face of the shell; an error if there are several."""
        return self.sample.face

    @property
    def som(self) -> SelfOrganizingMap:
        """The map, trained with the even sample."""
        return self.sample.som

    @property
    def mesh(self) -> _core.TriangleMesh:
        """The faces as triangles."""
        return self.sample.mesh

    @property
    def unit(self) -> str | None:
        """The unit of the points, if their files have one or it was given."""
        return self.sample.unit

    @property
    def settings(self) -> dict[str, Any]:
        """The options of the call."""
        return self.sample.settings

    @property
    def history(self) -> list[tuple[str, int, float]]:
        """Stage, step and error of the fit to the even sample; see `Reconstruction`."""
        return self.sample.history

    def z(self, x: ArrayLike, y: ArrayLike, *, out: NDArray[np.float64] | None = None) -> Any:
        """Return the height of the surface at x and y; see `NurbsSurface.z`."""
        return self.sample.z(x, y, out=out)

    def save(
        self, path: str | os.PathLike[str], *, unit: str | None = None, pcurves: bool = True
    ) -> None:
        """Write surface, mesh, picture or report to a file: see `neurbs.save`.

        Files of points, pictures and reports have the points of the even sample.
        """
        self.sample.save(path, unit=unit, pcurves=pcurves)

    def _file_parts(self) -> dict[str, Callable[[], Any]]:
        """Return the parts that files can store, for `neurbs.save`."""
        return self.sample._file_parts()

    def plot(self, **options: Any) -> Any:
        """Draw the even sample, lattice and faces: see `Reconstruction.plot`."""
        return self.sample.plot(**options)

    def write_report(self, path: str | os.PathLike[str], **options: Any) -> None:
        """Write a page with verdict, faces and deviations: see `Reconstruction.write_report`."""
        self.sample.write_report(path, **options)

    def _repr_html_(self) -> str:
        return self.sample._repr_html_()
