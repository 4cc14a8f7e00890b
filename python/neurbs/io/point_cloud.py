"""Points with attributes, and the blocks in which files of points are read."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import DTypeLike, NDArray

from neurbs._core import NeurbsError
from neurbs.errors import argument_error
from neurbs.io.units import check_unit, conversion

BLOCK = 1 << 16
"""Rows processed at a time: this bounds the memory and the time until Ctrl-C is handled."""

Columns: TypeAlias = "tuple[str | int, ...]"


@dataclass(frozen=True, eq=False)
class PointCloud:
    """Points with their attributes, read from a file or to be written to one.

    Every function that takes points also takes a `PointCloud`.

    Attributes
    ----------
    points : ndarray of shape (n, 3)
        float64.
    normals : ndarray of shape (n, 3), optional
        float64, as in the file.
    colors : ndarray of shape (n, 3), optional
        uint8: red, green and blue.
    distances : ndarray of shape (n,), optional
        Distance of each point to a surface, in the points' unit.
    unit : str, optional
        The unit of the coordinates: ``"mm"``, ``"m"``, ``"ft"``, ``"US survey foot"``,
        ``"degree"``; if the unit of z differs, both, as in ``"m, z: ft"``. Results and files that
        are made of the points have the same unit.
    crs : str, optional
        The coordinate reference system, as ``"EPSG:26910"`` or in WKT, for ``pyproj.CRS`` and
        geopandas.
    offset : (float, float, float), optional
        The origin of the coordinates in the file. It has been added to the points.
    dropped : int, default 0
        Number of points of the file that were left out: not finite, or marked as not measured.
    no_data : int, default 0
        How many of them the file marks as not measured, such as cells of a grid without data.
    columns : str, optional
        Which columns of a table were read as coordinates.

    Examples
    --------
    >>> import neurbs
    >>> import numpy as np
    >>> cloud = neurbs.PointCloud(np.random.default_rng(0).random((400, 3)), unit="m")
    >>> cloud
    PointCloud(400 points, unit='m')
    >>> neurbs.reconstruct(cloud, grid=(4, 4)).surface.degree
    (3, 3)
    """

    points: NDArray[np.float64]
    normals: NDArray[np.float64] | None = None
    colors: NDArray[np.uint8] | None = None
    distances: NDArray[np.float64] | None = None
    unit: str | None = None
    crs: str | None = None
    offset: tuple[float, float, float] | None = None
    dropped: int = 0
    no_data: int = 0
    columns: str | None = None

    def __post_init__(self) -> None:
        """Convert the attributes to arrays of the right types, and check their shapes."""
        points = np.ascontiguousarray(self.points, np.float64)
        if points.ndim != 2 or points.shape[1] != 3:
            raise argument_error(
                "points", f"must be an array of shape (n, 3), got shape {points.shape}"
            )
        object.__setattr__(self, "points", points)
        shapes = {"normals": points.shape, "colors": points.shape, "distances": points.shape[:1]}
        for name, shape in shapes.items():
            if getattr(self, name) is None:
                continue
            array = np.asarray(getattr(self, name))
            if array.shape != shape:
                raise NeurbsError(
                    f"{name} must be of shape {shape}, as there are {len(points)} points, "
                    f"got shape {array.shape}"
                )
            converted = (
                as_bytes(array) if name == "colors" else array.astype(np.float64, copy=False)
            )
            object.__setattr__(self, name, converted)

    def to_unit(self, unit: str) -> PointCloud:
        """Convert the points to another unit: the numbers change, the size stays.

        Parameters
        ----------
        unit : {"mm", "cm", "m", "in", "ft"}
            The new unit. Points without a unit get it, with their numbers unchanged.

        Returns
        -------
        PointCloud
            With this unit for x, y and z, distances and offset converted too.

        Raises
        ------
        NeurbsError
            If the unit is unknown, or the points' unit is not a length.

        Examples
        --------
        >>> import neurbs
        >>> cloud = neurbs.PointCloud([[1, 2, 3]], unit="in")
        >>> cloud.to_unit("mm").points
        array([[25.4, 50.8, 76.2]])
        """
        check_unit(unit)
        factors = conversion(self.unit, unit)
        if np.all(factors == 1):
            return replace(self, unit=unit)
        if self.distances is not None and np.ptp(factors):
            raise NeurbsError(
                f"points with distances must have one unit for x, y and z, got {self.unit!r}"
            )
        return replace(
            self,
            points=self.points * factors,
            normals=converted_normals(self.normals, factors),
            distances=None if self.distances is None else self.distances * factors[0],
            offset=converted_offset(self.offset, factors),
            unit=unit,
        )

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.points)

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        """Return the points."""
        return self.points.astype(self.points.dtype if dtype is None else dtype, copy=bool(copy))

    def __repr__(self) -> str:
        """Return the number of points and the attributes that are present."""
        arrays = (
            name for name in ("normals", "colors", "distances") if getattr(self, name) is not None
        )
        values = (
            f"{name}={getattr(self, name)!r}"
            for name in ("unit", "crs", "offset", "dropped")
            if getattr(self, name)
        )
        return f"PointCloud({', '.join([f'{len(self)} points', *arrays, *values])})"


@dataclass(frozen=True)
class Request:
    """The options for reading a file.

    Attributes
    ----------
    columns : tuple of str or int, optional
        The columns of the coordinates, by name or by number from 0.
    nan : {"error", "drop"}
        Whether points that are not finite are an error or are dropped.
    attributes : bool
        Whether to read the attributes too.
    unit : str, optional
        The unit to which the coordinates are converted.
    las_classes : tuple of int, optional
        The classes of a LAS file whose points are read.
    reference : bool
        Whether to read the reference system, and the unit that it gives, of a LAS file. It is also
        read for attributes and for `unit`.
    """

    columns: Columns | None = None
    nan: Literal["error", "drop"] = "error"
    attributes: bool = False
    unit: str | None = None
    las_classes: tuple[int, ...] | None = None
    reference: bool = False

    @property
    def needs_reference(self) -> bool:
        """Whether the reference system of a LAS file is read."""
        return self.attributes or self.unit is not None or self.reference


@dataclass(frozen=True)
class Block:
    """A block of points of a file.

    Attributes
    ----------
    points : ndarray of shape (k, 3)
        Real numbers, including those that are not finite.
    normals, colors : ndarray of shape (k, 3), optional
        Colors of any number type; see `as_bytes`.
    dropped : int
        Number of points that the file marks as not measured.
    not_finite : int
        Number of points that were left out because they are not finite.
    left_out : int
        Number of points that were not asked for.
    """

    points: NDArray[Any]
    normals: NDArray[Any] | None = None
    colors: NDArray[Any] | None = None
    dropped: int = 0
    not_finite: int = 0
    left_out: int = 0

    def only(self, rows: NDArray[np.bool_]) -> Block:
        """Return the block with some rows only; the others are added to `dropped`."""
        return replace(self._of(rows), dropped=self.dropped + int(np.count_nonzero(~rows)))

    def finite(self, rows: NDArray[np.bool_]) -> Block:
        """Return the block with some rows only; the others are added to `not_finite`."""
        return replace(self._of(rows), not_finite=self.not_finite + int(np.count_nonzero(~rows)))

    def chosen(self, rows: NDArray[np.bool_]) -> Block:
        """Return the block with some rows only; the others are added to `left_out`."""
        return replace(self._of(rows), left_out=self.left_out + int(np.count_nonzero(~rows)))

    def _of(self, rows: NDArray[np.bool_]) -> Block:
        """Return the block with some rows only."""

        def kept(array: NDArray[Any] | None) -> NDArray[Any] | None:
            return None if array is None else array[rows]

        return replace(
            self, points=self.points[rows], normals=kept(self.normals), colors=kept(self.colors)
        )


@dataclass(frozen=True)
class Doubt:
    """A reason to doubt the points of a file.

    Attributes
    ----------
    code : str
        The code of its warning; see `neurbs.diagnostics.READER_CODES`.
    message : str
        Cause and remedy.
    """

    code: str
    message: str


@dataclass(frozen=True)
class PointSource:
    """An open file of points whose header has been read.

    Attributes
    ----------
    blocks : iterator of Block
        The points, in the order of the file.
    count : int
        Largest number of points by the header, for which memory is allocated; 0 if unknown.
    unit, crs, offset
        As in `PointCloud`.
    doubts : list of Doubt
        Complete after the last block.
    columns
        As in `PointCloud`.
    """

    blocks: Iterator[Block]
    count: int = 0
    unit: str | None = None
    crs: str | None = None
    offset: tuple[float, float, float] | None = None
    doubts: list[Doubt] = field(default_factory=list)
    columns: str | None = None

    def to_unit(self, unit: str | None) -> PointSource:
        """Convert coordinates to a unit while they are read; None changes nothing.

        Raises
        ------
        NeurbsError
            If the unit of the file is not a length.
        """
        if unit is None or unit == self.unit:
            return self
        factors = conversion(self.unit, unit)
        if np.all(factors == 1):
            return replace(self, unit=unit)

        def converted(block: Block) -> Block:
            points = block.points * factors[: block.points.shape[1]]
            normals = converted_normals(block.normals, factors)
            return replace(block, points=points, normals=normals)

        offset = converted_offset(self.offset, factors)
        return replace(self, blocks=map(converted, self.blocks), unit=unit, offset=offset)


def converted_normals(
    normals: NDArray[Any] | None, factors: NDArray[np.float64]
) -> NDArray[Any] | None:
    """Return normals where x, y and z are converted by factors; their lengths stay."""
    if normals is None or not np.ptp(factors):
        return normals
    turned = normals / factors
    lengths = [np.linalg.norm(each, axis=1, keepdims=True) for each in (normals, turned)]
    # A normal of length 0 stays.
    scale = np.divide(lengths[0], lengths[1], out=lengths[0], where=lengths[1] > 0)
    return np.asarray(turned * scale)


def converted_offset(
    offset: tuple[float, float, float] | None, factors: NDArray[np.float64]
) -> tuple[float, float, float] | None:
    """Return an origin where x, y and z are converted by factors."""
    if offset is None:
        return None
    x, y, z = (np.asarray(offset) * factors).tolist()
    return x, y, z


def checked_count(path: Path, blocks: Iterator[Block], count: int) -> Iterator[Block]:
    """Yield blocks, and compare the number of their points with the header at the end.

    Raises
    ------
    NeurbsError
        If the numbers differ.
    """
    got = 0
    for block in blocks:
        got += len(block.points) + block.dropped + block.left_out
        yield block
    if got != count:
        but = "is cut short after" if got < count else "has"
        raise NeurbsError(f"{path}: must have {count} points, as in its header, but {but} {got}")


@dataclass
class Collector:
    """Joins blocks of rows to one array, which grows in place.

    To join a list of arrays at the end would take twice the memory.
    """

    capacity: int = 0
    rows: int = 0
    _array: NDArray[Any] | None = field(default=None, repr=False)

    def add(self, block: NDArray[Any], dtype: DTypeLike) -> None:
        """Append rows."""
        end = self.rows + len(block)
        if self._array is None:
            self._array = np.empty((max(self.capacity, end), block.shape[1]), dtype)
        if end > len(self._array):
            # In place, as there is no other reference to the array.
            self._array.resize((end + end // 4, block.shape[1]), refcheck=False)
        self._array[self.rows : end] = block
        self.rows = end

    def joined(self) -> NDArray[Any]:
        """Return all rows, and release the unused memory."""
        array = np.empty((0, 3)) if self._array is None else self._array
        if self.rows < len(array):
            array.resize((self.rows, array.shape[1]), refcheck=False)
        return array


def as_bytes(colors: NDArray[Any]) -> NDArray[np.uint8]:
    """Convert colors of any type to integers from 0 to 255.

    Real numbers up to 1 are shares of 255. Integers have 8 bits if the largest is at most 255, else
    16, because some programs write 8 bits in fields of 16.
    """
    if colors.dtype == np.uint8:
        return colors
    largest = np.nanmax(colors, initial=0)
    if colors.dtype.kind == "f" and largest <= 1:
        colors = colors * 255
    elif largest > 255:
        colors = colors / 257
    rounded: NDArray[np.uint8] = np.nan_to_num(colors).round().clip(0, 255).astype(np.uint8)
    return rounded
