"""`neurbs.load_surface` and `neurbs.load_surfaces`: a reader for each suffix."""

from __future__ import annotations

import os
import warnings
from pathlib import Path

from neurbs._core import NeurbsError, NurbsSurface
from neurbs.io.face_readers import read_faces


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
        Surfaces of the library geomdl, or those of the faces of shells that `save` wrote.
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
        The unit of the result. Numbers of a file with another unit are converted; those of a file
        without one are taken to be in it. By default the unit of the file.

    Returns
    -------
    list of NurbsSurface
        At least one surface, in the order of the file.

    Raises
    ------
    NeurbsError
        If the suffix is unknown, the library for the format is not installed, the file is damaged
        or has no surface, or `unit` is unknown.
    OSError
        If the file cannot be read.

    Warns
    -----
    UserWarning
        If faces are trimmed: a `NurbsSurface` has no trimming, so the result is the untrimmed
        surface.

    See Also
    --------
    load_shell : Read the faces with their trims, orientation, names and colors.

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
    path = Path(path)
    file = read_faces(path, "surface", LOADABLE, unit)
    if file.left_out:
        raise NeurbsError(f"{path}: each surface must be readable, but {file.left_out[0]}")
    trimmed = sum(face.is_trimmed for face in file.faces)
    if trimmed:
        warnings.warn(
            f"{path}: {trimmed} of {len(file.faces)} faces are trimmed: "
            "the result has the untrimmed surfaces",
            UserWarning,
            # The caller of `load_surface` or `load_surfaces`.
            stacklevel=3,
        )
    return [face.surface for face in file.faces]


LOADABLE = (".json", ".3dm", ".step", ".stp", ".igs", ".iges")
"""Suffixes of surfaces that can be read."""
