"""The reader of faces for each suffix, for `load_shell` and `load_surfaces`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from neurbs._core import NeurbsError
from neurbs.io import isolation
from neurbs.io.face_file import FaceFile, in_unit, no_faces
from neurbs.io.face_json import read_json
from neurbs.io.obj_faces import read_obj
from neurbs.io.reading import check_file, reading
from neurbs.io.units import check_unit


def read_faces(path: Path, kind: str, suffixes: tuple[str, ...], unit: str | None) -> FaceFile:
    """Read a file of faces.

    Parameters
    ----------
    path : Path
        The file.
    kind : str
        What is wanted of it, as a singular: "surface".
    suffixes : tuple of str
        The suffixes that it may have.
    unit : str, optional
        The unit of the result; by default that of the file.

    Raises
    ------
    NeurbsError
        If suffix or unit is wrong, or the file is damaged or has no faces.
    OSError
        If the file cannot be read.
    """
    check_unit(unit)
    check_file(path, f"{kind}s")  # Also for a missing file, before the check of the suffix.
    if path.suffix.lower() not in suffixes:
        got = f"the suffix {path.suffix!r}" if path.suffix else "no suffix"
        raise NeurbsError(
            f"{path}: {kind}s must be in a file with a suffix of {' '.join(suffixes)}, got {got}"
        )
    with path.open("rb"), reading(path):
        file = _READERS[path.suffix.lower()](path)
    if not file.faces:
        raise no_faces(path, file, kind)
    return in_unit(file, unit)


_READERS: dict[str, Callable[[Path], FaceFile]] = {
    ".json": read_json,
    ".3dm": isolation.read_faces,
    ".step": isolation.read_faces,
    ".stp": isolation.read_faces,
    ".igs": isolation.read_faces,
    ".iges": isolation.read_faces,
    ".obj": read_obj,
}

READABLE_FACES = tuple(_READERS)
"""Suffixes of faces that can be read."""
