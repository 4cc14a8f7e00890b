"""Points in `.npy` and `.npz` files of NumPy."""

from __future__ import annotations

import math
import threading
import zipfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.io.point_cloud import BLOCK, Block, PointSource, Request
from neurbs.io.reading import damaged
from neurbs.io.table_columns import Choice
from neurbs.io.table_header import Header

_NAMES = ("points", "xyz", "vertices")
"""Names for the array of points in an archive, or for the field of an array."""

_AXES = ("x", "y", "z")

_MOST_SHRUNK, _HEADER = 1100, 1 << 16
"""Most bytes of an array for each byte in an archive, and most bytes of its header."""

_parsing = threading.Lock()
"""Held while NumPy parses a header by `ast`, which fails in two threads at a time: some versions of
Python 3.11 and 3.12 count the depth of recursion for all threads together."""


def read_npy(path: Path, request: Request) -> PointSource:
    """Read an array of points."""
    magic = np.lib.format.MAGIC_PREFIX
    with path.open("rb") as file:
        if file.read(len(magic)) != magic:
            raise NeurbsError(f"{path}: must be a NumPy array file, but has no header of one")
        file.seek(0)
        with _parsing:
            _, _, dtype = _array_header(file)
    _check_real(path, dtype)
    # A memory map, because NumPy then compares the header with the size of the file.
    with _parsing:
        array: NDArray[Any] = np.load(path, mmap_mode="r", allow_pickle=False)
    return _source(path, array, request)


def read_npz(path: Path, request: Request) -> PointSource:
    """Read the array of points from an archive."""
    with zipfile.ZipFile(path) as archive:
        members = {info.filename.removesuffix(".npy"): info for info in archive.infolist()}
        known = (*_NAMES, *members) if len(members) == 1 else _NAMES
        name = next((name for name in known if name in members), None)
        header = Header.of(members, 0)
        labels = [header.labels[place] for place in header.axes] or _AXES
        axes = request.columns or labels
        if name is not None:
            array = _member(path, archive, members[name])
        elif all(isinstance(axis, str) and axis in members for axis in axes):
            arrays = [_member(path, archive, members[str(axis)]) for axis in axes]
            array = np.stack([np.ravel(each) for each in arrays], axis=1)
            request = replace(request, columns=None)
        else:
            raise NeurbsError(
                f"{path}: must have one array, or one named {', '.join(_NAMES)}, or three "
                f"named {', '.join(map(str, axes))}, got {', '.join(members) or 'none'}"
            )
    return _source(path, array, request)


def _member(path: Path, archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> NDArray[Any]:
    """Read an array of an archive, after a check of its size."""
    # Deflate does not shrink zeros further.
    if info.file_size > _MOST_SHRUNK * info.compress_size + _HEADER:
        raise damaged(path, f"the size of {info.filename} is wrong")
    with archive.open(info) as file:
        with _parsing:
            shape, _, dtype = _array_header(file)
        if math.prod(shape) * dtype.itemsize > info.file_size:
            raise damaged(path, f"{info.filename} is shorter than its shape {shape}")
    with archive.open(info) as file, _parsing:
        array: NDArray[Any] = np.lib.format.read_array(file, allow_pickle=False)
        # The checksum is compared at the end.
        file.read(1)
    return array


def _array_header(file: Any) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Return shape, order and type of an array."""
    version = np.lib.format.read_magic(file)
    read = (
        np.lib.format.read_array_header_1_0
        if version == (1, 0)
        else np.lib.format.read_array_header_2_0
    )
    return read(file)


def _source(path: Path, array: NDArray[Any], request: Request) -> PointSource:
    if array.dtype.names is not None:
        return _of_fields(path, array, array.dtype.names, request)
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
    _check_real(path, array.dtype)

    def blocks() -> Iterator[Block]:
        for start in range(0, len(array), BLOCK):
            yield Block(array[start : start + BLOCK, places])

    return PointSource(blocks(), count=len(array))


def _of_fields(
    path: Path, array: NDArray[Any], names: tuple[str, ...], request: Request
) -> PointSource:
    """Read the coordinates from the fields of a structured array."""
    header = Header.of(names, 0)
    whole = next((name for name in _NAMES if name in names), None)
    if request.columns is None and whole is not None:
        return _source(path, array[whole].reshape(len(array), -1), request)
    places = (
        header.axes if request.columns is None else header.chosen(path, request.columns, len(names))
    )
    if not places or array.ndim != 1:
        raise NeurbsError(
            f"{path}: points must be an array of shape (n,) with fields x, y and z, got shape "
            f"{array.shape} with {', '.join(map(repr, names))}: "
            "choose the coordinates with `columns`"
        )
    chosen = [names[place] for place in places]
    for name in chosen:
        _check_real(path, array.dtype[name])

    def blocks() -> Iterator[Block]:
        for start in range(0, len(array), BLOCK):
            rows = array[start : start + BLOCK]
            yield Block(np.column_stack([rows[name] for name in chosen]))

    unit = header.unit_of(path, tuple(places), request.unit)
    described = Choice(places).described(header)
    return PointSource(blocks(), count=len(array), unit=unit, columns=described)


def _check_real(path: Path, dtype: np.dtype[Any]) -> None:
    if dtype.names is None and dtype.kind not in "iuf":
        raise NeurbsError(f"{path}: points must be real numbers, got an array of {dtype}")
