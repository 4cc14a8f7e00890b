"""`neurbs.read_points` and `neurbs.read_point_cloud`."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal, overload

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.diagnostics import CATEGORIES, PointsDroppedWarning
from neurbs.errors import argument_error
from neurbs.io.packed import name_of
from neurbs.io.point_cloud import Block, Collector, PointCloud, PointSource, Request
from neurbs.io.point_formats import opened
from neurbs.io.units import check_unit


@overload
def read_points(
    path: str | os.PathLike[str],
    *,
    columns: Sequence[str | int] | None = ...,
    nan: Literal["error", "drop"] = ...,
    unit: str | None = ...,
    chunks: None = ...,
) -> NDArray[np.float64]: ...


@overload
def read_points(
    path: str | os.PathLike[str],
    *,
    columns: Sequence[str | int] | None = ...,
    nan: Literal["error", "drop"] = ...,
    unit: str | None = ...,
    chunks: int,
) -> Iterator[NDArray[np.float64]]: ...


def read_points(
    path: str | os.PathLike[str],
    *,
    columns: Sequence[str | int] | None = None,
    nan: Literal["error", "drop"] = "error",
    unit: str | None = None,
    chunks: int | None = None,
) -> NDArray[np.float64] | Iterator[NDArray[np.float64]]:
    r"""Read scattered points from a file.

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
    path : str or path-like
        The file; ``"-"`` is standard input, whose first bytes show the format.
    columns : sequence of str or int, optional
        The two or three columns of the coordinates, by names in the header or numbers from 0. For
        tables and NumPy arrays only.
    nan : {"error", "drop"}, default "error"
        Whether points that are not finite, or lack a coordinate, are an error or are dropped.
    unit : {"mm", "cm", "m", "in", "ft"}, optional
        The unit of the result. Numbers of a file with another unit are converted; those of a file
        without one are taken to be in it. By default the unit of the file.
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
        points are not finite, or `unit` is given and the unit of the file is not a length. For a
        text file the message gives line and column.
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
    request = _request(columns, nan, unit)
    source = opened(path, request)
    name = name_of(path)
    if chunks is not None:
        return _chunks(name, source, request, chunks)
    cloud = _collected(name, source, request)
    _warn_doubts(name, source)
    if nan == "drop":
        warn_dropped(name, cloud.dropped - cloud.no_data, len(cloud))
    return cloud.points


def read_point_cloud(
    path: str | os.PathLike[str],
    *,
    columns: Sequence[str | int] | None = None,
    nan: Literal["error", "drop"] = "error",
    unit: str | None = None,
) -> PointCloud:
    r"""Read points with their attributes from a file.

    Parameters
    ----------
    path, columns, nan, unit
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
    request = replace(_request(columns, nan, unit), attributes=True)
    source = opened(path, request)
    name = name_of(path)
    cloud = _collected(name, source, request)
    _warn_doubts(name, source)
    return cloud


def _request(
    columns: Sequence[str | int] | None, nan: Literal["error", "drop"], unit: str | None
) -> Request:
    """Return the options after a check."""
    check_unit(unit)
    if nan not in ("error", "drop"):
        raise argument_error("nan", f"must be 'error' or 'drop', got {nan!r}")
    if columns is None:
        return Request(nan=nan, unit=unit)
    chosen = tuple(columns)
    if len(chosen) not in (2, 3) or not all(isinstance(c, str | int) for c in chosen):
        raise argument_error("columns", f"must be two or three names or numbers, got {columns!r}")
    return Request(chosen, nan, unit=unit)


def _finite(name: str, source: PointSource, request: Request) -> Iterator[Block]:
    """Yield blocks of finite points in space, with the number of dropped ones."""
    first = 0
    for block in source.blocks:
        points = block.points
        if points.shape[1] == 2:
            flat = np.zeros((len(points), 1))
            block = replace(block, points=np.column_stack([points, flat]))
        finite = np.isfinite(points).all(axis=1)
        if finite.all():
            yield block
        elif request.nan == "drop":
            others = len(finite) - int(np.count_nonzero(finite))
            yield replace(block.only(finite), dropped=block.dropped, not_finite=others)
        else:
            index = int(finite.argmin())
            raise NeurbsError(
                f"{name}: points must be finite, but point {first + index} (counted from 0) is "
                f'{tuple(points[index].tolist())}: remove or repair it, or use `nan="drop"`'
            )
        first += len(points)


def _collected(name: str, source: PointSource, request: Request) -> PointCloud:
    """Return all blocks as one cloud."""
    points, normals, colors = (Collector(source.count) for _ in range(3))
    no_data = not_finite = 0
    for block in _finite(name, source, request):
        no_data += block.dropped
        not_finite += block.not_finite
        points.add(block.points, np.float64)
        if block.normals is not None:
            normals.add(block.normals, np.float64)
        if block.colors is not None:
            colors.add(block.colors, block.colors.dtype)
    _check_any(name, points.rows, not_finite, no_data)
    return PointCloud(
        points.joined(),
        normals.joined() if normals.rows else None,
        colors.joined() if colors.rows else None,
        unit=source.unit,
        crs=source.crs,
        offset=source.offset,
        dropped=not_finite + no_data,
        no_data=no_data,
        columns=source.columns,
    )


def _chunks(
    name: str, source: PointSource, request: Request, size: int
) -> Iterator[NDArray[np.float64]]:
    """Yield the points in arrays of a size; the last may be smaller."""
    chunk, filled, total = np.empty((size, 3)), 0, 0
    no_data = not_finite = 0
    for block in _finite(name, source, request):
        no_data += block.dropped
        not_finite += block.not_finite
        rest = block.points
        while len(rest):
            part = rest[: size - filled]
            chunk[filled : filled + len(part)] = part
            filled, rest = filled + len(part), rest[len(part) :]
            total += len(part)
            if filled == size:
                yield chunk
                chunk, filled = np.empty((size, 3)), 0
    _check_any(name, total, not_finite, no_data)
    if filled:
        yield chunk[:filled]
    _warn_doubts(name, source)
    if request.nan == "drop":
        warn_dropped(name, not_finite, total)


def _check_any(name: str, points: int, not_finite: int, no_data: int) -> None:
    if not points:
        reasons = {"are not finite": not_finite, "have no data": no_data}
        causes = [f"{count} {reason}" for reason, count in reasons.items() if count]
        but = f"all {' and '.join(causes)}" if causes else "it is empty"
        raise NeurbsError(f"{name}: must have at least one point, but {but}")


def warn_dropped(name: str | Path, not_finite: int, kept: int) -> None:
    """Warn if points were dropped because they are not finite."""
    if not_finite:
        warnings.warn(
            f"{name}: {not_finite} of {not_finite + kept} points are not finite and were dropped",
            PointsDroppedWarning,
            # The caller of `read_points`, or of the next chunk.
            stacklevel=3,
        )


def _warn_doubts(name: str, source: PointSource) -> None:
    for doubt in source.doubts:
        # The caller of `read_points`, or of the next chunk.
        warnings.warn(f"{name}: {doubt.message}", CATEGORIES[doubt.code], stacklevel=3)
