"""Points that are compressed or come from standard input: a temporary copy is read."""

from __future__ import annotations

import codecs
import gzip
import importlib
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from neurbs._core import NeurbsError
from neurbs.extras import require_for_file

STANDARD_INPUT = "-"
"""The path that stands for standard input."""

UNPACKABLE = (".gz", ".zst", ".npz")
"""Suffixes of what is compressed itself: within another archive it may be of any size."""

_BLOCK = 1 << 20
"""Bytes that are copied at a time."""

_FREE, _MOST_SHRUNK = 64 << 20, 100
"""Bytes that an archive may have unpacked, and more of them for each byte of the archive."""

_MOST_OF_DISK = 0.5
"""Share of the free disk space that a copy of standard input may take."""

_MAX_LINE = 1 << 24
"""Most bytes of text without the end of a line."""

_WIDE = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
"""The starts of text in UTF-16, which has zero bytes."""

_MAGIC: tuple[tuple[str, str], ...] = (
    (".gz", r"\x1f\x8b"),
    (".zst", r"\x28\xb5\x2f\xfd"),
    (".ply", r"ply\r?\n"),
    (".las", r"LASF"),
    (".e57", r"ASTM-E57"),
    (".npy", r"\x93NUMPY"),
    (".3mf", r"PK\x03\x04(?s:.{26,100})(?:3D/|_rels/|\[Content_Types)"),
    (".npz", r"PK\x03\x04"),
    (".glb", r"glTF"),
    (".tif", r"II\*\x00|MM\x00\*"),
    (".vtk", r"# vtk DataFile"),
    (".pcd", r"(?:#.*\n)*VERSION\s"),
    (".vtp", r"\s*<(?s:.{0,500})<?VTKFile[^>]*PolyData"),
    (".vtu", r"\s*<(?s:.{0,500})<?VTKFile[^>]*UnstructuredGrid"),
    (".vti", r"\s*<(?s:.{0,500})<?VTKFile[^>]*ImageData"),
    (".vts", r"\s*<(?s:.{0,500})<?VTKFile[^>]*StructuredGrid"),
    (".vtr", r"\s*<(?s:.{0,500})<?VTKFile[^>]*RectilinearGrid"),
    (".dae", r"\s*<(?s:.{0,500})<?COLLADA"),
    (".gltf", r"\s*\{"),
    (".off", r"(?:ST)?C?N?OFF\s"),
    (".stl", r"solid\s"),
    (".obj", r"(?:\s*#.*\n|\s*\n)*(?:v|vn|vt|mtllib|o|g)\s+\S"),
    (".ptx", r"\s*\d+\s*\n\s*\d+\s*\n\s*\S+[ \t]+\S+[ \t]+\S+\s*\n"),
)
"""For each suffix the start of such a file."""


def name_of(path: str | os.PathLike[str]) -> str:
    """Return the name of a path for messages."""
    name = os.fspath(path)
    return "standard input" if name == STANDARD_INPUT else name


def suffix_of(head: bytes) -> str:
    r"""Return the suffix of a format by the start of its content; of text by default.

    Examples
    --------
    >>> suffix_of(b"ply\nformat ascii 1.0\n"), suffix_of(b"1 2 3\n")
    ('.ply', '.txt')
    """
    text = head[:4096].decode("latin-1")
    found = (suffix for suffix, start in _MAGIC if re.match(start, text))
    return next(found, ".txt")


def spooled(stream: BinaryIO) -> Path:
    """Copy a stream to a temporary file, whose suffix shows the format of its content.

    Raises
    ------
    NeurbsError
        If it is no text of lines and of no known format, or too large for the disk.
    """
    most = shutil.disk_usage(tempfile.gettempdir()).free * _MOST_OF_DISK

    def check(copied: int, head: bytes) -> None:
        if copied > most:
            raise NeurbsError(
                f"standard input: must have at most {most:.2g} bytes, half of the disk space in "
                f"{tempfile.gettempdir()}"
            )
        if copied > _MAX_LINE and suffix_of(head) == ".txt" and b"\n" not in head:
            raise NeurbsError("standard input: must be points, but its first line does not end")

    return _copied(stream, "standard input", "", check)


def unpacked(path: Path) -> Path:
    """Unpack a file to a temporary one.

    Raises
    ------
    NeurbsError
        If it becomes much larger, or the library for the format is not installed.
    """
    most = _FREE + _MOST_SHRUNK * path.stat().st_size

    def check(copied: int, _: bytes) -> None:
        if copied > most:
            raise NeurbsError(
                f"{path}: must not grow beyond {most:,} bytes when it is unpacked: "
                "unpack it first if you trust it"
            )

    suffix = Path(path.stem).suffix.lower()
    with PACKED[path.suffix.lower()](path) as stream:
        copy = _copied(stream, str(path), suffix, check)
    if copy.suffix in UNPACKABLE:
        remove(copy)
        raise NeurbsError(f"{path}: must be packed once only, but has {copy.suffix} in it")
    return copy


def _copied(stream: BinaryIO, name: str, suffix: str, check: Callable[[int, bytes], None]) -> Path:
    """Copy a stream; `check` gets the number of bytes and the first ones."""
    folder = Path(tempfile.mkdtemp(prefix="neurbs-"))
    try:
        head = stream.read(_BLOCK)
        copy = folder / f"points{suffix or suffix_of(head)}"
        if copy.suffix == ".txt" and b"\0" in head and not head.startswith(_WIDE):
            raise NeurbsError(
                f"{name}: must be text, or start as a known format, but is binary: give a file "
                "with the suffix of its format, such as .stl"
            )
        copied = 0
        with copy.open("wb") as file:
            block = head
            while block:
                copied += len(block)
                check(copied, head)
                file.write(block)
                block = stream.read(_BLOCK)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    return copy


def remove(copy: Path) -> None:
    """Remove a temporary file with its folder."""
    shutil.rmtree(copy.parent, ignore_errors=True)


@contextmanager
def renamed(copy: Path, name: str) -> Iterator[None]:
    """Name the source of a temporary copy in messages."""
    try:
        yield
    except NeurbsError as error:
        error.args = (str(error).replace(str(copy), name),)
        raise
    except OSError as error:
        if error.filename == str(copy):
            error.filename = name
        raise


def _open_gzip(path: Path) -> Any:
    return gzip.open(path, "rb")


def _open_zstd(path: Path) -> Any:
    if sys.version_info >= (3, 14):
        zstd = importlib.import_module("compression.zstd")
    else:
        zstd = require_for_file(path, "backports.zstd")
    return zstd.open(path, "rb")


PACKED: dict[str, Callable[[Path], Any]] = {".gz": _open_gzip, ".zst": _open_zstd}
"""How compressed files are opened, by suffix."""
