"""Points from a file, chosen by its suffix."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path
from tokenize import TokenError
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.io.ply import read_ply
from neurbs.io.text import read_obj, read_text


def read_points(path: str | os.PathLike[str]) -> NDArray[np.float64]:
    r"""Read scattered points from a file.

    The suffix, in any case, says what the file is:

    ``.xyz``, ``.txt``, ``.csv``
        A table as text, a point in each line. Columns are separated by whitespace, comma,
        semicolon or tab; ``#`` and ``//`` start a comment; blank lines count for nothing. One
        header line may name the columns: those named x, y and z are taken then, otherwise the
        first three. A table of two columns lies in z = 0.
    ``.npy``
        A NumPy array of shape (n, 3), or (n, 2) in z = 0, of real numbers.
    ``.ply``
        The vertices of a point cloud or a mesh, ASCII or binary.
    ``.obj``
        The vertices (``v`` lines) of a Wavefront file.

    Points keep their order and their digits: none is merged, moved or left out.

    Parameters
    ----------
    path : str or path-like
        The file.

    Returns
    -------
    ndarray of shape (n, 3)
        float64, C-contiguous, n ≥ 1, all finite, in the unit of the file.

    Raises
    ------
    NeurbsError
        If the suffix is unknown, or the file is damaged or does not hold finite points; of a text
        file the message names line and column.
    OSError
        `FileNotFoundError`, `IsADirectoryError`, `PermissionError`: there is no file to read.

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
    if path.is_dir():
        raise IsADirectoryError(
            errno.EISDIR, "points are read from a file, not a folder", str(path)
        )
    path.stat()  # A file that is not there matters more than its suffix.
    if not path.is_file():
        raise NeurbsError(f"{path}: points are read from a file, but this is a device or a pipe")
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        got = f"the suffix {path.suffix!r}" if path.suffix else "no suffix"
        raise NeurbsError(
            f"{path}: points must be in a file with a suffix of {' '.join(READABLE)}, got {got}"
        )
    points = reader(path)
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    finite = np.isfinite(points).all(axis=1)
    if not finite.all():
        index = int(finite.argmin())
        raise NeurbsError(
            f"{path}: points must be finite, but point {index} (counted from 0) is "
            f"{tuple(points[index].tolist())}: remove or repair it"
        )
    return np.ascontiguousarray(points)


def _read_npy(path: Path) -> NDArray[np.float64]:
    magic = np.lib.format.MAGIC_PREFIX
    with path.open("rb") as file:
        if file.read(len(magic)) != magic:
            raise NeurbsError(f"{path}: must be a NumPy array file, but does not start like one")
    try:
        # Mapped, because then the header's promises are held against the size of the file.
        array: NDArray[Any] = np.load(path, mmap_mode="r", allow_pickle=False)
    except (ValueError, OverflowError, SyntaxError, TokenError):  # So headers are parsed.
        raise NeurbsError(
            f"{path}: must be a whole NumPy array of numbers, but is cut short, damaged or "
            "made of Python objects: save it again with numpy.save"
        ) from None
    if array.ndim != 2 or array.shape[1] not in (2, 3) or not len(array):
        raise NeurbsError(
            f"{path}: points must be an array of shape (n, 3) or (n, 2) with n ≥ 1, "
            f"got shape {array.shape}"
        )
    if array.dtype.kind not in "iuf":
        raise NeurbsError(f"{path}: points must be real numbers, got an array of {array.dtype}")
    return np.array(array, dtype=np.float64, order="C")


_READERS: dict[str, Callable[[Path], NDArray[np.float64]]] = {
    ".xyz": read_text,
    ".txt": read_text,
    ".csv": read_text,
    ".npy": _read_npy,
    ".ply": read_ply,
    ".obj": read_obj,
}

READABLE = tuple(_READERS)
"""Suffixes that can be read."""
