"""`neurbs.read_points` and `neurbs.read_point_cloud`."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Literal, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs._core import NeurbsError
from neurbs.diagnostics import CATEGORIES, PointsDroppedWarning
from neurbs.errors import argument_error
from neurbs.io.point_cloud import Collector, PointCloud, Request
from neurbs.io.point_files import PointFiles
from neurbs.io.point_filters import PointFilter
from neurbs.io.units import check_unit


@overload
def read_points(
    path: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    *,
    columns: Sequence[str | int] | None = ...,
    nan: Literal["error", "drop"] = ...,
    unit: str | None = ...,
    bounds: ArrayLike | None = ...,
    cell: float | None = ...,
    las_classes: Sequence[int] | None = ...,
    chunks: None = ...,
) -> NDArray[np.float64]: ...


@overload
def read_points(
    path: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    *,
    columns: Sequence[str | int] | None = ...,
    nan: Literal["error", "drop"] = ...,
    unit: str | None = ...,
    bounds: ArrayLike | None = ...,
    cell: float | None = ...,
    las_classes: Sequence[int] | None = ...,
    chunks: int,
) -> Iterator[NDArray[np.float64]]: ...


def read_points(
    path: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    *,
    columns: Sequence[str | int] | None = None,
    nan: Literal["error", "drop"] = "error",
    unit: str | None = None,
    bounds: ArrayLike | None = None,
    cell: float | None = None,
    las_classes: Sequence[int] | None = None,
    chunks: int | None = None,
) -> NDArray[np.float64] | Iterator[NDArray[np.float64]]:
    r"""Read scattered points from a file or several.

    The suffix, in upper or lower case, selects the format:

    ``.xyz``, ``.txt``, ``.csv``, ``.tsv``, ``.dat``, ``.asc``, ``.pts``, ``.xyzrgb``, ``.xyzn``
        A text table in any encoding, with one point in each line. Columns are separated by
        whitespace, comma, semicolon, tab or ``|``. Unless commas separate columns, a comma in a
        number is a decimal comma. ``#`` and ``//`` start a comment; blank lines are skipped. See
        the notes for the choice of the columns. In ``.pts``, lines with one integer are point
        counts.
    Text with a header of ``ncols`` and ``nrows``, ``north:`` or ``DSAA``; ``.grd``, ``.tif``
        A grid of ESRI, GDAL, GRASS or Surfer, or a GeoTIFF (also ``.tiff``) with one band: the
        centers of the cells, with the value as z. Cells without data are left out.
    Text with ``VARIABLES =`` and ``ZONE``
        The nodes of all zones of Tecplot, by points or by blocks; the names give the coordinates.
    ``.ptx``
        Leica's scans, joined in their common frame. Points at 0 are not measured and left out.
    ``.npy``, ``.npz``
        A NumPy array of real numbers of shape (n, 3), or (n, 2) in z = 0, or a structured array
        with fields for x, y and z. Of several arrays in ``.npz``: the one named points, xyz or
        vertices, or three arrays x, y and z.
    ``.ply``, ``.obj``
        All vertices of a point cloud or a mesh, in their order.
    ``.stl``, ``.off``, ``.glb``, ``.gltf``, ``.dae``, ``.3mf``
        The vertices of a mesh in the frame of its scene. Vertices of ``.stl``, which repeats them
        for each triangle, are read once. ``.dae`` and ``.3mf`` need ``pip install 'neurbs[io]'``.
    ``.las``, ``.laz``, ``.e57``
        Laser scans. The scans of an ``.e57`` are joined in their common frame, and pulses without
        return are left out. These formats and GeoTIFF need ``pip install 'neurbs[io]'``.
    ``.pcd``
        A cloud of the Point Cloud Library, as text, binary or compressed. NaN marks pixels without
        a measurement, which are left out.
    ``.vtk``, ``.vtp``, ``.vtu``, ``.vts``, ``.vti``, ``.vtr``
        The points of a VTK data set, or the nodes of a regular grid, with ``pip install
        'neurbs[vtk]'``.
    ``.gz``, ``.zst``
        A compressed file of another format, such as ``scan.xyz.gz``.

    Points keep their order and all digits; none are merged or moved. Files are read in blocks, with
    little memory beside the returned array.

    Parameters
    ----------
    path : str or path-like, or sequence of them
        The file, or files that are read one after the other as one; ``"-"`` is standard input,
        whose first bytes show the format.
    columns : sequence of str or int, optional
        The two or three columns of the coordinates, by names in the header or numbers from 0. For
        tables and NumPy arrays only.
    nan : {"error", "drop"}, default "error"
        Whether points that are not finite, or lack a coordinate, are an error or are dropped.
    unit : {"mm", "cm", "m", "in", "ft"}, optional
        The unit of the result. Numbers of a file with another unit are converted; those of a file
        without one are taken to be in it. By default the unit of the file.
    bounds : array_like, optional
        The lowest and the highest coordinates of the points to read: ``(xmin, ymin, xmax, ymax)``,
        or with z, in the unit of the result. LAS files whose header has other bounds are not
        opened, unless `unit` is given.
    cell : float, optional
        Side of the cubes of which each keeps its first point, in the unit of the result.
    las_classes : sequence of int, optional
        Classes of the points to read: 2 is ground. For ``.las`` and ``.laz`` only.
    chunks : int, optional
        Number of points of a chunk. With it, the function returns an iterator of chunks that reads
        the file step by step.

    Returns
    -------
    ndarray of shape (n, 3), or iterator of such arrays
        float64, C-contiguous, n ≥ 1, all finite, in the unit of the file or in `unit`.

    Raises
    ------
    NeurbsError
        If the suffix is unknown, the library for the format is not installed, the file is damaged,
        points are not finite, `unit` is given and the unit of the file is not a length, several
        files have several units, or the filters leave no point. For a text file the message gives
        line and column.
    OSError
        `FileNotFoundError`, `IsADirectoryError` or `PermissionError`, if the file cannot be read.

    Warns
    -----
    PointsDroppedWarning
        If points were dropped because of ``nan="drop"``; the message gives their number.
    ColumnsGuessedWarning
        If the columns of a table are a guess.
    ControlPointsWarning
        If the vertices of an ``.obj`` file are control points of free-form surfaces.

    See Also
    --------
    read_point_cloud : The points with their attributes.

    Notes
    -----
    The columns of a table are found by names first, in a line above the points: x, y and z, or
    easting, northing and elevation, longitude, latitude and depth and similar names, with units in
    brackets. Several lines may be above the points, as well as a row of units and a line with the
    number of points.

    Without names the content decides. A first row 0, 1, 2, … is a header. A first column of
    consecutive integers with three or more columns of numbers behind it counts the points; so does
    one of integers that increase unevenly beside decimals. Columns of text are skipped. The next
    three columns of numbers are x, y and z. A table of two columns lies in z = 0.
    `read_point_cloud` returns what was read as what, in its attribute ``columns``.

    Examples
    --------
    >>> import neurbs
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder, "scan.csv")
    ...     _ = file.write_text("name,x,y,z\na,1,2,3\nb,4,5,6\n")
    ...     neurbs.read_points(file)
    array([[1., 2., 3.],
           [4., 5., 6.]])
    """
    if chunks is not None and not (isinstance(chunks, int) and chunks > 0):
        raise argument_error("chunks", f"must be an integer from 1, got {chunks!r}")
    files = point_files(
        path,
        columns=columns,
        nan=nan,
        unit=unit,
        bounds=bounds,
        cell=cell,
        las_classes=las_classes,
    )
    if chunks is not None:
        return _chunks(files, chunks)
    points = _collected(files).joined()
    _warn(files)
    return points


def read_point_cloud(
    path: str | os.PathLike[str],
    *,
    columns: Sequence[str | int] | None = None,
    nan: Literal["error", "drop"] = "error",
    unit: str | None = None,
    bounds: ArrayLike | None = None,
    cell: float | None = None,
    las_classes: Sequence[int] | None = None,
) -> PointCloud:
    r"""Read points with their attributes from a file.

    Parameters
    ----------
    path : str or path-like
        The file; ``"-"`` is standard input.
    columns, nan, unit, bounds, cell, las_classes
        As for `read_points`.

    Returns
    -------
    PointCloud
        The points, with normals, colors, unit, reference system and offset if the file has them.
        ``dropped`` is the number of dropped points.

    Raises
    ------
    NeurbsError, OSError
        As for `read_points`.

    Warns
    -----
    ColumnsGuessedWarning, ControlPointsWarning
        As for `read_points`.
    CrsUnknownWarning
        If the file has a reference system that cannot be read.

    Examples
    --------
    >>> import neurbs
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder, "scan.csv")
    ...     _ = file.write_text("x [mm];y [mm];z [mm];r;g;b\n1,5;2;3;255;0;0\n")
    ...     cloud = neurbs.read_point_cloud(file)
    >>> cloud
    PointCloud(1 points, colors, unit='mm')
    >>> cloud.points
    array([[1.5, 2. , 3. ]])
    >>> cloud.columns
    "x, y, z are columns 'x [mm]', 'y [mm]', 'z [mm]'; the points start in line 2"
    """
    files = point_files(
        [path],
        columns=columns,
        nan=nan,
        unit=unit,
        bounds=bounds,
        cell=cell,
        las_classes=las_classes,
        attributes=True,
    )
    cloud = _cloud(files)
    _warn_doubts(files)
    return cloud


def point_files(
    path: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    *,
    columns: Sequence[str | int] | None = None,
    nan: Literal["error", "drop"] = "error",
    unit: str | None = None,
    bounds: ArrayLike | None = None,
    cell: float | None = None,
    las_classes: Sequence[int] | None = None,
    attributes: bool = False,
    reference: bool = False,
) -> PointFiles:
    """Open a file of points or several, after a check of the options.

    Parameters
    ----------
    path, columns, nan, unit, bounds, cell, las_classes
        As for `read_points`.
    attributes, reference
        As for `Request`.

    Raises
    ------
    NeurbsError, OSError
        As for `read_points`.
    """
    check_unit(unit)
    if nan not in ("error", "drop"):
        raise argument_error("nan", f"must be 'error' or 'drop', got {nan!r}")
    classes = None if las_classes is None else tuple(las_classes)
    if classes is not None and not (classes and all(map(_is_class, classes))):
        raise argument_error("las_classes", f"must be integers from 0 to 255, got {las_classes!r}")
    names = None if columns is None else tuple(columns)
    if names is not None and not (
        len(names) in (2, 3) and all(isinstance(name, str | int) for name in names)
    ):
        raise argument_error("columns", f"must be two or three names or numbers, got {columns!r}")
    paths = [path] if isinstance(path, str | os.PathLike) else list(path)
    if not paths:
        raise argument_error("path", "must be at least one file, got none")
    request = Request(names, nan, attributes, unit, classes, reference)
    return PointFiles(paths, request, PointFilter.of(bounds, cell))


def _is_class(number: object) -> bool:
    return isinstance(number, int | np.integer) and bool(0 <= number < 256)


def _collected(files: PointFiles) -> Collector:
    """Return the points of all files."""
    points = Collector(files.count)
    for block in files.blocks():
        points.add(block.points, np.float64)
    _check_left(points.rows)
    return points


def _cloud(files: PointFiles) -> PointCloud:
    """Return the points of a file with their attributes."""
    points, normals, colors = (Collector(files.count) for _ in range(3))
    for block in files.blocks():
        points.add(block.points, np.float64)
        if block.normals is not None:
            normals.add(block.normals, np.float64)
        if block.colors is not None:
            colors.add(block.colors, block.colors.dtype)
    _check_left(points.rows)
    file = files.read[0]
    return PointCloud(
        points.joined(),
        normals.joined() if normals.rows else None,
        colors.joined() if colors.rows else None,
        unit=file.source.unit,
        crs=file.source.crs,
        offset=file.source.offset,
        dropped=file.not_finite + file.no_data,
        no_data=file.no_data,
        columns=file.source.columns,
    )


def _chunks(files: PointFiles, size: int) -> Iterator[NDArray[np.float64]]:
    left = 0
    for chunk in files.chunks(size):
        left += len(chunk)
        yield chunk
    _check_left(left)
    _warn(files)


def _check_left(points: int) -> None:
    if not points:
        raise NeurbsError("bounds and las_classes must leave at least one point, but leave none")


def warn_dropped(name: str | Path, not_finite: int, points: int, *, stacklevel: int = 3) -> None:
    """Warn if points were dropped because they are not finite; `points` are the others."""
    if not_finite:
        warnings.warn(
            f"{name}: {not_finite} of {not_finite + points} points are not finite and were dropped",
            PointsDroppedWarning,
            stacklevel=stacklevel,
        )


def _warn(files: PointFiles) -> None:
    """Warn of all files, for the caller of `read_points` or of the next chunk."""
    _warn_doubts(files, stacklevel=4)
    if files.request.nan == "drop":
        for file in files.read:
            warn_dropped(file.name, file.not_finite, file.points, stacklevel=4)


def _warn_doubts(files: PointFiles, *, stacklevel: int = 3) -> None:
    for file in files.read:
        for doubt in file.source.doubts:
            message = f"{file.name}: {doubt.message}"
            warnings.warn(message, CATEGORIES[doubt.code], stacklevel=stacklevel)
