"""The formats of points: a reader for each suffix, and the way to it."""

from __future__ import annotations

import os
import sys
import weakref
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

from neurbs._core import NeurbsError
from neurbs.io import isolation
from neurbs.io.ascii_grid import read_asc, read_grd
from neurbs.io.e57 import read_e57
from neurbs.io.las import LAS
from neurbs.io.mesh_vertices import read_vertices
from neurbs.io.numpy_file import read_npy, read_npz
from neurbs.io.obj import read_obj
from neurbs.io.off import read_off
from neurbs.io.packed import (
    PACKED,
    STANDARD_INPUT,
    UNPACKABLE,
    remove,
    renamed,
    spooled,
    unpacked,
)
from neurbs.io.pcd import read_pcd
from neurbs.io.ply import read_ply
from neurbs.io.point_cloud import Block, PointSource, Request
from neurbs.io.ptx import read_ptx
from neurbs.io.raster import read_geotiff
from neurbs.io.reading import blocks_of_file, check_file, reading
from neurbs.io.text import read_pts, read_text


def check_source(path: str | os.PathLike[str]) -> None:
    """Check that the suffix of a path is a format of points.

    Raises
    ------
    NeurbsError
        If the suffix is unknown.
    """
    if os.fspath(path) == STANDARD_INPUT:
        return
    path = Path(path)
    suffix = path.suffix
    if suffix.lower() in PACKED:
        # A name without a second suffix: the content shows the format.
        suffix = Path(path.stem).suffix
        if not suffix:
            return
        if suffix.lower() in UNPACKABLE:
            raise NeurbsError(
                f"{path}: must be packed once only, but is {suffix} within {path.suffix}: unpack it"
            )
    if suffix.lower() not in _READERS:
        got = f"the suffix {suffix!r}" if suffix else "no suffix"
        raise NeurbsError(
            f"{path}: points must be in a file with a suffix of {' '.join(READABLE)}, got {got}"
        )


def stem_of(path: str | os.PathLike[str]) -> str:
    """Return the name of a file of points without the suffixes of its format and packing.

    Examples
    --------
    >>> stem_of("scans/a.xyz.gz"), stem_of("a.copc.laz"), stem_of("a.v2.ply")
    ('a', 'a', 'a.v2')
    """
    if os.fspath(path) == STANDARD_INPUT:
        return "standard-input"
    path = Path(path)
    if path.suffix.lower() in PACKED:
        path = path.with_suffix("")
    if path.suffix.lower() in _READERS:
        path = path.with_suffix("")
    return path.stem if path.suffix.lower() in _VARIANTS else path.name


def opened(path: str | os.PathLike[str], request: Request) -> PointSource:
    """Open a file of points, a compressed one, or standard input.

    Raises
    ------
    NeurbsError, OSError
        As for `neurbs.read_points`.
    """
    if os.fspath(path) == STANDARD_INPUT:
        if sys.stdin is None:
            raise NeurbsError("standard input: must be open, but this process has none")
        return _of_copy(spooled(sys.stdin.buffer), "standard input", request)
    path = Path(path)
    check_file(path, "points")  # Also for a missing file, before the check of the suffix.
    check_source(path)
    suffix = path.suffix.lower()
    # Opened first, so that a file that cannot be read raises OSError, not an error of a library.
    with path.open("rb"), reading(path):
        if suffix in PACKED:
            return _of_copy(unpacked(path), str(path), request)
        if request.columns is not None and suffix not in _TABLES:
            raise NeurbsError(
                f"{path}: columns must be left out, unless the file is {' '.join(_TABLES)}; "
                f"got {request.columns!r}"
            )
        if request.las_classes is not None and suffix not in LAS:
            raise NeurbsError(
                f"{path}: las_classes must be left out, unless the file is {' '.join(LAS)}; "
                f"got {list(request.las_classes)}"
            )
        source = _READERS[suffix](path, request).to_unit(request.unit)
    # A count in a damaged header may exceed the memory. No point takes less than a byte of a file,
    # unless it is compressed; then the arrays grow.
    count = min(source.count, path.stat().st_size)
    return replace(source, blocks=blocks_of_file(path, source.blocks), count=count)


def _of_copy(copy: Path, name: str, request: Request) -> PointSource:
    """Open a temporary copy, which is removed at the end; messages have the name of its source."""
    try:
        with renamed(copy, name):
            source = opened(copy, request)
    except BaseException:
        remove(copy)
        raise

    def blocks() -> Iterator[Block]:
        with renamed(copy, name):
            yield from source.blocks

    kept = blocks()
    weakref.finalize(kept, remove, copy)
    return replace(source, blocks=kept)


_TABLES: dict[str, Callable[[Path, Request], PointSource]] = {
    ".xyz": read_asc,
    ".txt": read_asc,
    ".csv": read_text,
    ".tsv": read_text,
    ".dat": read_asc,
    ".asc": read_asc,
    ".grd": read_grd,
    ".pts": read_pts,
    ".xyzrgb": read_text,
    ".xyzn": read_text,
    ".npy": read_npy,
    ".npz": read_npz,
}
"""Readers of formats with columns."""

_READERS = _TABLES | {
    ".ptx": read_ptx,
    ".ply": read_ply,
    ".obj": read_obj,
    ".stl": read_vertices,
    ".off": read_off,
    ".glb": read_vertices,
    ".gltf": isolation.read_points,
    ".dae": isolation.read_points,
    ".3mf": isolation.read_points,
    ".las": isolation.read_points,
    ".laz": isolation.read_points,
    ".e57": read_e57,
    ".pcd": read_pcd,
    ".vtk": isolation.read_points,
    ".vtp": isolation.read_points,
    ".vtu": isolation.read_points,
    ".vti": isolation.read_points,
    ".vts": isolation.read_points,
    ".vtr": isolation.read_points,
    ".tif": read_geotiff,
    ".tiff": read_geotiff,
}

_VARIANTS = (".copc",)
"""Suffixes of variants of a format, which stand before its own."""

READABLE = (*_READERS, *PACKED)
"""Suffixes of points that can be read."""
