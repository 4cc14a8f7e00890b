"""Points in `.npy` and `.npz` files of NumPy."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from tokenize import TokenError
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.io.point_cloud import BLOCK, Block, PointSource, Request

_NAMES = ("points", "xyz", "vertices")
"""Names for the array of points in an archive."""

_AXES = ("x", "y", "z")


def read_npy(path: Path, request: Request) -> PointSource:
    """Read an array of points."""
    magic = np.lib.format.MAGIC_PREFIX
    with path.open("rb") as file:
        if file.read(len(magic)) != magic:
            raise NeurbsError(f"{path}: must be a NumPy array file, but has no header of one")
    try:
        # A memory map, because NumPy then compares the header with the size of the file.
        array: NDArray[Any] = np.load(path, mmap_mode="r", allow_pickle=False)
    except (ValueError, OverflowError, SyntaxError, TokenError):  # Errors of the header.
        raise NeurbsError(
            f"{path}: must be a complete NumPy array of numbers, but is cut short, damaged "
            "or made of Python objects: save it again with numpy.save"
        ) from None
    return _source(path, array, request)


def read_npz(path: Path, request: Request) -> PointSource:
    """Read the array of points from an archive."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            if not isinstance(archive, np.lib.npyio.NpzFile):
                raise ValueError
            names = archive.files
            name = next((n for n in (*_NAMES, *names[: len(names) == 1]) if n in names), None)
            axes = request.columns or _AXES
            if name is not None:
                array = archive[name]
            elif all(isinstance(axis, str) and axis in names for axis in axes):
                array = np.stack([np.ravel(archive[str(axis)]) for axis in axes], axis=1)
                request = Request(nan=request.nan)
            else:
                raise NeurbsError(
                    f"{path}: must have one array, or one named {', '.join(_NAMES)}, or three "
                    f"named {', '.join(map(str, axes))}, got {', '.join(names) or 'none'}"
                )
    except NeurbsError:
        raise
    except (ValueError, EOFError, zipfile.BadZipFile, zlib.error):
        raise NeurbsError(
            f"{path}: must be a complete archive of NumPy arrays of numbers, but is cut "
            "short, damaged or made of Python objects: save it again with numpy.savez"
        ) from None
    return _source(path, array, request)


def _source(path: Path, array: NDArray[Any], request: Request) -> PointSource:
    columns = request.columns
    if columns is not None:
        width = array.shape[1] if array.ndim == 2 else 0
        places = [place for place in columns if isinstance(place, int) and 0 <= place < width]
        if len(places) < len(columns):
            raise NeurbsError(
                f"{path}: columns must be from 0 to {width - 1}, as the array has shape "
                f"{array.shape}, got {columns}"
            )
    elif array.ndim != 2 or array.shape[1] not in (2, 3) or not len(array):
        raise NeurbsError(
            f"{path}: points must be an array of shape (n, 3) or (n, 2) with n ≥ 1, "
            f"got shape {array.shape}: save it so, or choose the coordinates with `columns`"
        )
    else:
        places = list(range(array.shape[1]))
    if array.dtype.kind not in "iuf":
        raise NeurbsError(f"{path}: points must be real numbers, got an array of {array.dtype}")

    def blocks() -> Iterator[Block]:
        for start in range(0, len(array), BLOCK):
            yield Block(array[start : start + BLOCK, places])

    return PointSource(blocks(), count=len(array))
