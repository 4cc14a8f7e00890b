"""`neurbs.read_points` and `neurbs.read_point_cloud`: a reader for each suffix."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal, overload

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.errors import argument_error
from neurbs.io import isolation
from neurbs.io.e57 import read_e57
from neurbs.io.mesh_vertices import read_vertices
from neurbs.io.numpy_file import read_npy, read_npz
from neurbs.io.obj import read_obj
from neurbs.io.off import read_off
from neurbs.io.pcd import read_pcd
from neurbs.io.ply import read_ply
from neurbs.io.point_cloud import Block, Collector, PointCloud, PointSource, Request
from neurbs.io.raster import read_asc, read_geotiff
from neurbs.io.reading import blocks_of_file, check_file, reading
from neurbs.io.text import read_pts, read_text
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

    ``.xyz``, ``.txt``, ``.csv``, ``.asc``, ``.pts``
        A text table in any encoding, with one point in each line. Columns are separated by
        whitespace, comma, semicolon or tab. Unless commas separate columns, a comma within a
        number is a decimal comma. ``#`` and ``//`` start a comment; blank lines are skipped. One
        header line, or the last comment above the points, may name the columns. The columns x, y
        and z are read (or easting, northing, elevation and similar names); without such names, the
        first three after a point's name. A table of two columns lies in z = 0. In ``.pts``, lines
        with one integer are point counts.
    ``.asc`` with a header of ``ncols`` and ``nrows``, ``.tif``, ``.tiff``
        An ESRI grid or a GeoTIFF with one band: the centers of the cells, with the value as z.
        Cells without data are left out.
    ``.npy``, ``.npz``
        A NumPy array of real numbers of shape (n, 3), or (n, 2) in z = 0. Of several arrays in
        ``.npz``: the one named points, xyz or vertices, or three arrays x, y and z.
    ``.ply``, ``.obj``
        All vertices of a point cloud or a mesh, in their order.
    ``.stl``, ``.off``, ``.glb``
        The vertices of a mesh in the frame of its scene. Vertices of ``.stl``, which repeats them
        for each triangle, are read once.
    ``.las``, ``.laz``, ``.e57``
        Laser scans. The scans of an ``.e57`` are joined in their common frame, and pulses without
        return are left out. These formats and GeoTIFF need ``pip install 'neurbs[io]'``.
    ``.pcd``
        A cloud of the Point Cloud Library, as text, binary or compressed. NaN marks pixels without
        a measurement, which are left out.
    ``.vtk``, ``.vtp``, ``.vtu``
        The points of a VTK data set, with ``pip install 'neurbs[vtk]'``.

    Points keep their order and all digits; none are merged or moved. Files are read in blocks, with
    little memory beside the returned array.

    Parameters
    ----------
    path : str or path-like
        The file.
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
    UserWarning
        If points were dropped because of ``nan="drop"``; the message gives their number. If the
        vertices of an ``.obj`` file are control points of free-form surfaces.

    See Also
    --------
    read_point_cloud : The points with their attributes.

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
    path = Path(path)
    if chunks is not None and not (isinstance(chunks, int) and chunks > 0):
        raise argument_error("chunks", f"must be an integer from 1, got {chunks!r}")
    request = _request(path, columns, nan, unit)
    source = _opened(path, request)
    if chunks is not None:
        return _chunks(path, source, request, chunks)
    cloud = _collected(path, source, request)
    _warn_doubts(path, source)
    if nan == "drop":
        warn_dropped(path, cloud.dropped, len(cloud))
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
    """
    path = Path(path)
    request = replace(_request(path, columns, nan, unit), attributes=True)
    source = _opened(path, request)
    cloud = _collected(path, source, request)
    _warn_doubts(path, source)
    return cloud


def _request(
    path: Path,
    columns: Sequence[str | int] | None,
    nan: Literal["error", "drop"],
    unit: str | None,
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
    if path.suffix.lower() not in _TABLES:
        raise NeurbsError(
            f"{path}: columns must be left out, unless the file is {' '.join(_TABLES)}; "
            f"got {columns!r}"
        )
    return Request(chosen, nan, unit=unit)


def check_source(path: str | os.PathLike[str]) -> None:
    """Check that the suffix of a path is a format of points.

    Raises
    ------
    NeurbsError
        If the suffix is unknown.
    """
    suffix = Path(path).suffix
    if suffix.lower() not in _READERS:
        got = f"the suffix {suffix!r}" if suffix else "no suffix"
        raise NeurbsError(
            f"{path}: points must be in a file with a suffix of {' '.join(READABLE)}, got {got}"
        )


def _opened(path: Path, request: Request) -> PointSource:
    check_file(path, "points")  # Also for a missing file, before the check of the suffix.
    check_source(path)
    # Opened first, so that a file that cannot be read raises OSError, not an error of a library.
    with path.open("rb"), reading(path):
        source = _READERS[path.suffix.lower()](path, request).to_unit(request.unit)
    return replace(source, blocks=blocks_of_file(path, source.blocks))


def _finite(path: Path, source: PointSource, request: Request) -> Iterator[Block]:
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
            yield block.only(finite)
        else:
            index = int(finite.argmin())
            raise NeurbsError(
                f"{path}: points must be finite, but point {first + index} (counted from 0) is "
                f'{tuple(points[index].tolist())}: remove or repair it, or use `nan="drop"`'
            )
        first += len(points)


def _collected(path: Path, source: PointSource, request: Request) -> PointCloud:
    """Return all blocks as one cloud."""
    # A count in a damaged header may exceed the memory. No point takes less than a byte of a file,
    # unless it is compressed; then the arrays grow.
    capacity = min(source.count, path.stat().st_size)
    points, normals, colors = (Collector(capacity) for _ in range(3))
    dropped = 0
    for block in _finite(path, source, request):
        dropped += block.dropped
        points.add(block.points, np.float64)
        if block.normals is not None:
            normals.add(block.normals, np.float64)
        if block.colors is not None:
            colors.add(block.colors, block.colors.dtype)
    _check_any(path, points.rows, dropped)
    return PointCloud(
        points.joined(),
        normals.joined() if normals.rows else None,
        colors.joined() if colors.rows else None,
        unit=source.unit,
        crs=source.crs,
        offset=source.offset,
        dropped=dropped,
    )


def _chunks(
    path: Path, source: PointSource, request: Request, size: int
) -> Iterator[NDArray[np.float64]]:
    """Yield the points in arrays of a size; the last may be smaller."""
    chunk, filled, total, dropped = np.empty((size, 3)), 0, 0, 0
    for block in _finite(path, source, request):
        dropped += block.dropped
        rest = block.points
        while len(rest):
            part = rest[: size - filled]
            chunk[filled : filled + len(part)] = part
            filled, rest = filled + len(part), rest[len(part) :]
            total += len(part)
            if filled == size:
                yield chunk
                chunk, filled = np.empty((size, 3)), 0
    _check_any(path, total, dropped)
    if filled:
        yield chunk[:filled]
    _warn_doubts(path, source)
    if request.nan == "drop":
        warn_dropped(path, dropped, total)


def _check_any(path: Path, points: int, dropped: int) -> None:
    if not points:
        got = f"all {dropped} are not finite or not measured" if dropped else "it is empty"
        raise NeurbsError(f"{path}: must have at least one point, but {got}")


def warn_dropped(path: Path, dropped: int, kept: int) -> None:
    """Warn if points were dropped."""
    if dropped:
        warnings.warn(
            f"{path}: {dropped} of {dropped + kept} points are not finite and were dropped",
            UserWarning,
            # The caller of `read_points`, or of the next chunk.
            stacklevel=3,
        )


def _warn_doubts(path: Path, source: PointSource) -> None:
    for doubt in source.doubts:
        # The caller of `read_points`, or of the next chunk.
        warnings.warn(f"{path}: {doubt}", UserWarning, stacklevel=3)


_TABLES: dict[str, Callable[[Path, Request], PointSource]] = {
    ".xyz": read_text,
    ".txt": read_text,
    ".csv": read_text,
    ".asc": read_asc,
    ".pts": read_pts,
    ".npy": read_npy,
    ".npz": read_npz,
}
"""Readers of formats with columns."""

_READERS = _TABLES | {
    ".ply": read_ply,
    ".obj": read_obj,
    ".stl": read_vertices,
    ".off": read_off,
    ".glb": read_vertices,
    ".las": isolation.read_points,
    ".laz": isolation.read_points,
    ".e57": read_e57,
    ".pcd": read_pcd,
    ".vtk": isolation.read_points,
    ".vtp": isolation.read_points,
    ".vtu": isolation.read_points,
    ".tif": read_geotiff,
    ".tiff": read_geotiff,
}

READABLE = tuple(_READERS)
"""Suffixes of points that can be read."""
