"""Signed distances of points from a surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs import _core

if TYPE_CHECKING:
    from neurbs import NurbsSurface, Reconstruction, Shell
    from neurbs.io import PointCloud

_CHUNK = 1_000_000
"""Points whose normals are computed at a time, to bound the memory."""

_POINTS_PER_BIN = 6
"""Mean number of points in a bin over (u, v)."""

SAMPLES = 20_000
"""Points that stand for the area of a shell."""

_R2 = np.array([0.7548776662466927, 0.5698402909980532])
"""1/g and 1/g² for the root g of x³ = x + 1."""

_MAX_BINS = 128
"""Largest number of bins along u and along v."""


@dataclass(frozen=True, eq=False)
class Deviation:
    """Signed distances from points to a surface, in the points' unit.

    Attributes
    ----------
    uv : ndarray of shape (n, 2)
        Parameters of each point's projection onto the surface.
    signed : ndarray of shape (n,)
        Distance from each point to its projection, positive on the side of the normal.
    face_index : ndarray of int, shape (n,), or None
        Face of each projection onto a shell.
    """

    uv: NDArray[np.float64]
    signed: NDArray[np.float64]
    face_index: NDArray[np.uint32] | None = None

    @classmethod
    def of(cls, surface: NurbsSurface | Shell | PointCloud, points: ArrayLike) -> Deviation:
        """Measure the deviation of points from a surface, a shell or a cloud.

        Parameters
        ----------
        surface : NurbsSurface, Shell or PointCloud
            The reference. The distance from a cloud is that to its nearest point: it is never
            negative, and `uv` is empty.
        points : array_like of shape (n, 3) or (n, 2)
            The points.

        Examples
        --------
        >>> import neurbs
        >>> from neurbs.deviation import Deviation
        >>> plane = neurbs.NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0])
        >>> deviation = Deviation.of(plane, [[0.5, 0.5, 0.3], [0.2, 0.1, -0.4]])
        >>> deviation.signed.tolist()
        [0.3, -0.4]
        >>> round(deviation.rms, 4), deviation.max, deviation.within(0.35)
        (0.3536, 0.4, 0.5)
        """
        points = _core.as_points(points)
        if isinstance(surface, _core.Shell):
            return cls._of_shell(surface, points)
        if not isinstance(surface, _core.NurbsSurface):
            return cls(np.empty((0, 2)), _core.cloud_distances(surface, points))
        projections = surface.closest_points(points)
        return cls._with_signs(surface, points, projections.uv, projections.distances)

    @classmethod
    def of_result(cls, result: Reconstruction) -> Deviation:
        """Return the deviation of a result's inliers, without measuring it again."""
        inliers = result.inliers
        measured = (result.points[inliers], result.uv[inliers], result.deviations[inliers])
        return cls._with_signs(result.surface, *measured)

    @classmethod
    def _of_shell(cls, shell: Shell, points: NDArray[np.float64]) -> Deviation:
        projections = shell.closest_points(points)
        signed = np.empty(len(points))
        for index, face in enumerate(shell.faces):
            on_face = projections.face_index == index
            measured = (points[on_face], projections.uv[on_face], projections.distances[on_face])
            of_face = cls._with_signs(face.surface, *measured)
            signed[on_face] = -of_face.signed if face.is_reversed else of_face.signed
        return cls(projections.uv, signed, projections.face_index)

    @classmethod
    def _with_signs(
        cls,
        surface: NurbsSurface,
        points: NDArray[np.float64],
        uv: NDArray[np.float64],
        distances: NDArray[np.float64],
    ) -> Deviation:
        signed = np.empty(len(points))
        for start in range(0, len(points), _CHUNK):
            part = slice(start, start + _CHUNK)
            offset = points[part] - surface.evaluate(uv[part], extrapolate=True)
            normals = surface.normals(uv[part], extrapolate=True)
            side = np.einsum("ij,ij->i", offset, normals)
            np.copysign(distances[part], side, out=signed[part])
        return cls(uv, signed)

    @property
    def distances(self) -> NDArray[np.float64]:
        """Distances without their sign, shape (n,)."""
        return np.abs(self.signed)

    @property
    def rms(self) -> float:
        """Root mean square of the distances."""
        return float(np.sqrt(np.mean(self.signed**2)))

    @property
    def mean(self) -> float:
        """Mean of the signed distances; 0 if the points lie evenly on both sides."""
        return float(self.signed.mean())

    @property
    def max(self) -> float:
        """Largest distance."""
        return float(self.distances.max())

    def percentiles(self, *shares: float) -> dict[float, float]:
        """Return percentiles of the distances, for shares from 0 to 100."""
        return dict(zip(shares, np.percentile(self.distances, shares).tolist(), strict=True))

    def within(self, tolerance: float) -> float:
        """Return the share of points, from 0 to 1, whose distance is at most `tolerance`."""
        return float(np.mean(self.distances <= tolerance))

    def over_surface(
        self, surface: NurbsSurface, uv: NDArray[np.float64], face: int = 0
    ) -> NDArray[np.float64]:
        """Return the local mean of the signed distances at places on a surface.

        Parameters
        ----------
        surface : NurbsSurface
            The surface from which the deviation was measured.
        uv : ndarray of shape (n, 2)
            Parameters of the places.
        face : int, default 0
            The face of the surface, if the deviation was measured from a shell.

        Returns
        -------
        ndarray of shape (n,)
            NaN where no points are near.
        """
        on_face = slice(None) if self.face_index is None else self.face_index == face
        measured, signed = self.uv[on_face], self.signed[on_face]
        bins = int(np.clip(np.sqrt(len(signed) / _POINTS_PER_BIN), 2, _MAX_BINS))
        low, high = np.transpose(surface.domain)
        row, col = np.clip((measured - low) / (high - low) * bins, 0, bins - 1).astype(int).T
        cell, shape = row * bins + col, bins * bins
        counts: NDArray[np.float64]
        sums: NDArray[np.float64]
        counts = np.bincount(cell, minlength=shape).astype(float).reshape(bins, bins)
        sums = np.bincount(cell, signed, minlength=shape).astype(float).reshape(bins, bins)
        # Fractional indices of the places between the centers of bins.
        at = (uv - low) / (high - low) * bins - 0.5
        weight, total = (_sampled(_smoothed(grid), at) for grid in (counts, sums))
        return np.divide(total, weight, out=np.full_like(total, np.nan), where=weight > 1e-9)


def _smoothed(grid: NDArray[np.float64]) -> NDArray[np.float64]:
    """Smooth a grid with weights 1, 2, 1 in both directions."""
    for _ in range(2):
        padded = np.pad(grid, ((1, 1), (0, 0)))
        grid = (padded[:-2] + 2 * padded[1:-1] + padded[2:]).T / 4
    return grid


def _sampled(grid: NDArray[np.float64], places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Interpolate a square grid bilinearly, with constant values beyond its border."""
    places = np.clip(places, 0, len(grid) - 1)
    first = np.minimum(places.astype(int), len(grid) - 2)
    (row, col), (down, right) = first.T, (places - first).T
    upper, lower = (
        (1 - right) * grid[at, col] + right * grid[at, col + 1] for at in (row, row + 1)
    )
    values: NDArray[np.float64] = (1 - down) * upper + down * lower
    return values


def sampled(shell: Shell, count: int = SAMPLES) -> NDArray[np.float64]:
    """Return points that are spread evenly over the area of a shell.

    Examples
    --------
    >>> import neurbs
    >>> from neurbs.deviation import sampled
    >>> ball = neurbs.Shell(neurbs.NurbsSurface.sphere([0, 0, 0], 2.0))
    >>> points = sampled(ball, 1000)
    >>> bool(np.allclose(np.linalg.norm(points, axis=1), 2.0))
    True
    """
    mesh = shell.tessellate()
    corners = mesh.vertices[mesh.triangles]
    sides = corners[:, 1:] - corners[:, :1]
    areas = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1).cumsum()
    steps = np.arange(count)
    at = np.minimum(areas.searchsorted((steps + 0.5) / count * areas[-1]), len(areas) - 1)
    # The R2 sequence of M. Roberts (2018), folded onto the half of a square that is a triangle.
    shares = (0.5 + steps[:, None] * _R2) % 1
    outside = shares.sum(axis=1) > 1
    shares[outside] = 1 - shares[outside]
    points = corners[at, 0] + np.einsum("ij,ijk->ik", shares, sides[at])
    # From the triangles onto the faces.
    return np.asarray(shell.closest_points(points).points)
