"""Points from a file, chosen by its suffix."""

from __future__ import annotations

import errno
import os
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal, overload

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.io import isolation
from neurbs.io.e57 import read_e57
from neurbs.io.numpy_file import read_npy, read_npz
from neurbs.io.obj import read_obj
from neurbs.io.pcd import read_pcd
from neurbs.io.ply import read_ply
from neurbs.io.point_cloud import Block, Collector, PointCloud, PointSource, Request
from neurbs.io.raster import read_asc, read_geotiff
from neurbs.io.text import read_pts, read_text
from neurbs.io.vertices import read_vertices


@overload
def read_points(
    path: str | os.PathLike[str],
    *,
    columns: Sequence[str | int] | None = ...,
    nan: Literal["error", "drop"] = ...,
    chunks: None = ...,
) -> NDArray[np.float64]: ...


@overload
def read_points(
    path: str | os.PathLike[str],
    *,
    columns: Sequence[str | int] | None = ...,
    nan: Literal["error", "drop"] = ...,
    chunks: int,
) -> Iterator[NDArray[np.float64]]: ...


def read_points(
    path: str | os.PathLike[str],
    *,
    columns: Sequence[str | int] | None = None,
    nan: Literal["error", "drop"] = "error",
    chunks: int | None = None,
) -> NDArray[np.float64] | Iterator[NDArray[np.float64]]:
    r"""Read scattered points from a file.

    The suffix, in any case, says what the file is:

    ``.xyz``, ``.txt``, ``.csv``, ``.asc``, ``.pts``
        A table as text, in any encoding, a point in each line. Columns are separated by
        whitespace, comma, semicolon or tab; where it is not a comma that separates, a comma within
        a number is a decimal comma. ``#`` and ``//`` start a comment; blank lines count for
        nothing. One header line, or the last comment above the points, may name the columns: those
        named x, y and z are taken then (or easting, northing, elevation and the like), otherwise
        the first three after a point's name. A table of two columns lies in z = 0. In ``.pts``,
        lines with one integer are the counts of points.
    ``.asc`` with a header of ``ncols`` and ``nrows``, ``.tif``, ``.tiff``
        An ESRI grid or a GeoTIFF of one band: the centres of the cells, with the value as z. Cells
        without data are left out.
    ``.npy``, ``.npz``
        A NumPy array of shape (n, 3), or (n, 2) in z = 0, of real numbers; of several in ``.npz``
        the one named points, xyz or vertices, or three arrays x, y and z.
    ``.ply``, ``.obj``
        The vertices of a point cloud or a mesh, all of them and in their order.
    ``.stl``, ``.off``, ``.glb``
        The vertices of a mesh, as placed in its scene; those of ``.stl``, which repeats them for
        each triangle, once.
    ``.las``, ``.laz``, ``.e57``
        Laser scans; several of an ``.e57`` are joined in their common frame, and pulses without
        return are left out. They need ``pip install 'neurbs[io]'``, as GeoTIFF does.
    ``.pcd``
        A cloud of the Point Cloud Library, as text, binary or compressed; points that are NaN,
        which mark pixels without measurement there, are left out.
    ``.vtk``, ``.vtp``, ``.vtu``
        The points of a VTK data set, with ``pip install 'neurbs[vtk]'``.

    Points keep their order and their digits: none is merged or moved. They are read block by
    block: beside the array that is returned, little memory is needed.

    Parameters
    ----------
    path : str or path-like
        The file.
    columns : sequence of str or int, optional
        Two or three columns that hold the coordinates, by their names in the header or counted
        from 0. For tables and NumPy arrays only.
    nan : {"error", "drop"}, default "error"
        What becomes of points that are not finite, or whose coordinate is missing.
    chunks : int, optional
        Give the points in arrays of so many, instead of in one: an iterator, that reads the file
        as it goes.

    Returns
    -------
    ndarray of shape (n, 3), or iterator of such
        float64, C-contiguous, n ≥ 1, all finite, in the unit of the file.

    Raises
    ------
    NeurbsError
        If the suffix is unknown, what reads such files is not installed, or the file is damaged or
        does not hold finite points; of a text file the message names line and column.
    OSError
        `FileNotFoundError`, `IsADirectoryError`, `PermissionError`: there is no file to read.

    Warns
    -----
    UserWarning
        How many points were dropped, if any were, because of ``nan="drop"``.

    See Also
    --------
    read_point_cloud : The points, and what else the file knows.

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
        raise NeurbsError(f"chunks must be an integer from 1, got {chunks!r}")
    request = _request(path, columns, nan)
    source = _opened(path, request)
    if chunks is not None:
        return _chunks(path, source, request, chunks)
    cloud = _collected(path, source, request)
    if nan == "drop":
        warn_dropped(path, cloud.dropped, len(cloud))
    return cloud.points


def read_point_cloud(
    path: str | os.PathLike[str],
    *,
    columns: Sequence[str | int] | None = None,
    nan: Literal["error", "drop"] = "error",
) -> PointCloud:
    r"""Read points from a file, with all that it knows of them.

    Parameters
    ----------
    path, columns, nan
        As for `read_points`.

    Returns
    -------
    PointCloud
        The points, their normals and colours, unit, reference system and offset: what the format
        has a place for and the file has. How many points were dropped stands in ``dropped``.

    Raises
    ------
    NeurbsError, OSError
        As `read_points` does.

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
    request = replace(_request(path, columns, nan), attributes=True)
    return _collected(path, _opened(path, request), request)


def _request(
    path: Path, columns: Sequence[str | int] | None, nan: Literal["error", "drop"]
) -> Request:
    """Check the options."""
    if nan not in ("error", "drop"):
        raise NeurbsError(f"nan must be 'error' or 'drop', got {nan!r}")
    if columns is None:
        return Request(nan=nan)
    chosen = tuple(columns)
    if len(chosen) not in (2, 3) or not all(isinstance(c, str | int) for c in chosen):
        raise NeurbsError(f"columns must be two or three names or numbers, got {columns!r}")
    if path.suffix.lower() not in _TABLES:
        raise NeurbsError(
            f"{path}: columns must be left to the file, unless it is {' '.join(_TABLES)}; "
            f"got {columns!r}"
        )
    return Request(chosen, nan)


def check_source(path: str | os.PathLike[str]) -> None:
    """Check that points may be in a file of this name.

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
    if path.is_dir():
        raise IsADirectoryError(
            errno.EISDIR, "points are read from a file, not a folder", str(path)
        )
    path.stat()  # A file that is not there matters more than its suffix.
    if not path.is_file():
        raise NeurbsError(f"{path}: points are read from a file, but this is a device or a pipe")
    check_source(path)
    # Opened here, so that any library's trouble with it comes as the system's own error.
    with path.open("rb"):
        return _READERS[path.suffix.lower()](path, request)


def _finite(path: Path, source: PointSource, request: Request) -> Iterator[Block]:
    """Hand on finite points in space; what is left out is counted in each block."""
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
                f"{tuple(points[index].tolist())}: remove or repair it, or leave such points out "
                'with nan="drop"'
            )
        first += len(points)


def _collected(path: Path, source: PointSource, request: Request) -> PointCloud:
    """Join all blocks."""
    # A damaged count would ask for all memory; if a file is compressed well, arrays will grow.
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
    """Cut the blocks anew, all to the same size but the last."""
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
    if request.nan == "drop":
        warn_dropped(path, dropped, total)


def _check_any(path: Path, points: int, dropped: int) -> None:
    if not points:
        got = f"all {dropped} are not finite or not measured" if dropped else "it is empty"
        raise NeurbsError(f"{path}: must hold at least one point, but {got}")


def warn_dropped(path: Path, dropped: int, kept: int) -> None:
    """Say how many points were left out, if any were."""
    if dropped:
        warnings.warn(
            f"{path}: {dropped} of {dropped + kept} points are not finite and were dropped",
            UserWarning,
            # To who called `read_points`, or asked for the next chunk.
            stacklevel=3,
        )


_TABLES: dict[str, Callable[[Path, Request], PointSource]] = {
    ".xyz": read_text,
    ".txt": read_text,
    ".csv": read_text,
    ".asc": read_asc,
    ".pts": read_pts,
    ".npy": read_npy,
    ".npz": read_npz,
}
"""Files whose columns somebody may choose."""

_READERS = _TABLES | {
    ".ply": read_ply,
    ".obj": read_obj,
    ".stl": read_vertices,
    ".off": read_vertices,
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
"""Suffixes that can be read."""
