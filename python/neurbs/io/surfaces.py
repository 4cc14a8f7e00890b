"""Surfaces from a file, chosen by its suffix."""

from __future__ import annotations

import errno
import os
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np

from neurbs._core import LENGTH_UNITS, NeurbsError, NurbsSurface
from neurbs.io import isolation
from neurbs.io.geomdl_json import read_json
from neurbs.io.surface_file import SurfaceFile
from neurbs.io.units import check_unit


def load_surface(path: str | os.PathLike[str], *, unit: str | None = None) -> NurbsSurface:
    """Read the one surface of a file.

    Parameters
    ----------
    path, unit
        As for `load_surfaces`.

    Returns
    -------
    NurbsSurface

    Raises
    ------
    NeurbsError, OSError
        As `load_surfaces` does, and if the file holds several surfaces.

    Warns
    -----
    UserWarning
        If the file holds a trimmed face.

    Examples
    --------
    >>> import neurbs
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> plane = neurbs.NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0])
    >>> with TemporaryDirectory() as folder:
    ...     neurbs.save(plane, Path(folder, "plane.json"))
    ...     neurbs.load_surface(Path(folder, "plane.json")) == plane
    True
    """
    surfaces = _load(path, unit)
    if len(surfaces) > 1:
        raise NeurbsError(
            f"{path}: must hold one surface, got {len(surfaces)}: read all with load_surfaces"
        )
    return surfaces[0]


def load_surfaces(path: str | os.PathLike[str], *, unit: str | None = None) -> list[NurbsSurface]:
    """Read all surfaces of a file.

    The suffix, in any case, says what the file is:

    ``.json``
        Surfaces of the library geomdl.
    ``.3dm``
        The surfaces of a Rhino model, and those of the faces of its solids.
    ``.step``, ``.stp``, ``.igs``, ``.iges``
        The surface of each face, turned into a B-spline surface if it is none.

    Parametrizations are those of the file; which side of a face is its outside is not read.

    Parameters
    ----------
    path : str or path-like
        The file. All but ``.json`` need ``pip install 'neurbs[cad]'``.
    unit : {"mm", "cm", "m", "in", "ft"}, optional
        In which the coordinates come; by default in that of the file, as they are written there.

    Returns
    -------
    list of NurbsSurface
        At least one, in the file's order.

    Raises
    ------
    NeurbsError
        If the suffix is unknown, what reads such files is not installed, the file is damaged or
        holds no surface, or a unit is asked for and the file has none.
    OSError
        If there is no file to read.

    Warns
    -----
    UserWarning
        If faces are trimmed: their surfaces come whole, as trimming has no place in a
        `NurbsSurface`.

    Examples
    --------
    >>> import neurbs
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> ball = neurbs.NurbsSurface.sphere([0, 0, 0], 2.0)
    >>> with TemporaryDirectory() as folder:
    ...     neurbs.save(ball, Path(folder, "ball.json"))
    ...     len(neurbs.load_surfaces(Path(folder, "ball.json")))
    1
    """
    return _load(path, unit)


def _load(path: str | os.PathLike[str], unit: str | None) -> list[NurbsSurface]:
    check_unit(unit)
    path = Path(path)
    if path.is_dir():
        raise IsADirectoryError(
            errno.EISDIR, "surfaces are read from a file, not a folder", str(path)
        )
    path.stat()  # A file that is not there matters more than its suffix.
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        got = f"the suffix {path.suffix!r}" if path.suffix else "no suffix"
        raise NeurbsError(
            f"{path}: surfaces must be in a file with a suffix of {' '.join(LOADABLE)}, got {got}"
        )
    with path.open("rb"):
        file = reader(path)
    if not file.surfaces:
        raise NeurbsError(
            f"{path}: must hold at least one surface, but holds none: it may be cut short"
        )
    if file.trimmed:
        warnings.warn(
            f"{path}: {file.trimmed} of {len(file.surfaces)} faces are trimmed: "
            "their surfaces come whole",
            UserWarning,
            # To who called `load_surface` or `load_surfaces`.
            stacklevel=3,
        )
    if unit is None or unit == file.unit:
        return file.surfaces
    if file.unit is None:
        raise NeurbsError(f"{path}: unit must be left out, for the file has none; got {unit!r}")
    factor = LENGTH_UNITS[file.unit] / LENGTH_UNITS[unit]
    scale = np.diag([factor, factor, factor, 1.0])
    return [surface.transformed(scale) for surface in file.surfaces]


_READERS: dict[str, Callable[[Path], SurfaceFile]] = {
    ".json": read_json,
    ".3dm": isolation.read_surfaces,
    ".step": isolation.read_surfaces,
    ".stp": isolation.read_surfaces,
    ".igs": isolation.read_surfaces,
    ".iges": isolation.read_surfaces,
}

LOADABLE = tuple(_READERS)
"""Suffixes of surfaces that can be read."""
