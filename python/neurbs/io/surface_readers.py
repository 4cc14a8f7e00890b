"""`neurbs.load_surface` and `neurbs.load_surfaces`: a reader for each suffix."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np

from neurbs._core import LENGTH_UNITS, NeurbsError, NurbsSurface
from neurbs.io import isolation
from neurbs.io.geomdl_json import read_json
from neurbs.io.reading import check_file, reading
from neurbs.io.surface_file import SurfaceFile
from neurbs.io.units import check_unit


def load_surface(path: str | os.PathLike[str], *, unit: str | None = None) -> NurbsSurface:
    """Read the surface of a file that has only one.

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
        As for `load_surfaces`, and if the file has several surfaces.

    Warns
    -----
    UserWarning
        If the face is trimmed.

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
            f"{path}: must have one surface, got {len(surfaces)}: read all with load_surfaces"
        )
    return surfaces[0]


def load_surfaces(path: str | os.PathLike[str], *, unit: str | None = None) -> list[NurbsSurface]:
    """Read all surfaces of a file.

    The suffix, in upper or lower case, selects the format:

    ``.json``
        Surfaces of the library geomdl.
    ``.3dm``
        The surfaces of a Rhino model, and those of the faces of its solids.
    ``.step``, ``.stp``, ``.igs``, ``.iges``
        The surface of each face, converted to a B-spline surface.

    The parametrizations are those of the file. The orientation of faces is not read.

    Parameters
    ----------
    path : str or path-like
        The file. All but ``.json`` need ``pip install 'neurbs[cad]'``.
    unit : {"mm", "cm", "m", "in", "ft"}, optional
        The unit of the result; by default the unit of the file, without a conversion.

    Returns
    -------
    list of NurbsSurface
        At least one surface, in the order of the file.

    Raises
    ------
    NeurbsError
        If the suffix is unknown, the library for the format is not installed, the file is damaged
        or has no surface, or `unit` is given for a file without a unit.
    OSError
        If the file cannot be read.

    Warns
    -----
    UserWarning
        If faces are trimmed: a `NurbsSurface` has no trimming, so the result is the untrimmed
        surface.

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
    check_file(path, "surfaces")  # Also for a missing file, before the check of the suffix.
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        got = f"the suffix {path.suffix!r}" if path.suffix else "no suffix"
        raise NeurbsError(
            f"{path}: surfaces must be in a file with a suffix of {' '.join(LOADABLE)}, got {got}"
        )
    with path.open("rb"), reading(path):
        file = reader(path)
    if not file.surfaces:
        raise NeurbsError(
            f"{path}: must have at least one surface, but has none: it may be cut short"
        )
    if file.trimmed:
        warnings.warn(
            f"{path}: {file.trimmed} of {len(file.surfaces)} faces are trimmed: "
            "the result has the untrimmed surfaces",
            UserWarning,
            # The caller of `load_surface` or `load_surfaces`.
            stacklevel=3,
        )
    if unit is None or unit == file.unit:
        return file.surfaces
    if file.unit is None:
        raise NeurbsError(f"{path}: unit must be left out, as the file has none; got {unit!r}")
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
