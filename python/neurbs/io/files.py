"""Results to files: which suffix holds what, who writes it, and whether it can be written."""

from __future__ import annotations

import errno
import importlib.util
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from neurbs import _core
from neurbs._core import NeurbsError, NurbsSurface, TriangleMesh
from neurbs.io.mesh import write_glb, write_stl
from neurbs.io.ply import write_ply
from neurbs.io.replacement import replacement

if TYPE_CHECKING:
    from neurbs import Reconstruction


def save(thing: NurbsSurface | TriangleMesh | Reconstruction, path: str | os.PathLike[str]) -> None:
    """Write a surface, a mesh or a whole result to a file.

    The suffix, in any case, says what is written:

    ``.step`` ``.stp`` ``.igs`` ``.iges``
        The NURBS surface, to the last digit, of a `NurbsSurface` or a `Reconstruction`.
    ``.obj`` ``.ply`` ``.glb`` ``.stl``
        A `TriangleMesh`, that of a `Reconstruction`, or a `NurbsSurface` tessellated with its
        defaults. All but ``.stl`` keep their digits far from the origin too.
    ``.png``
        A picture of a `Reconstruction`: points, lattice and surface.

    The file is written beside its place and then renamed: it is whole or not there, and a file
    that it replaces is untouched until then.

    Parameters
    ----------
    thing : NurbsSurface, TriangleMesh or Reconstruction
        What to write.
    path : str or path-like
        The file; its folder must exist.

    Raises
    ------
    NeurbsError
        If the suffix is unknown, or does not hold such a thing.
    OSError
        If the file cannot be written.

    Warns
    -----
    UserWarning
        If ``.stl``, which stores single precision, moves vertices by more than a millionth of
        the mesh's diagonal.

    Examples
    --------
    >>> import neurbs
    >>> import numpy as np
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> net = np.stack(np.meshgrid(range(4), range(4), [0.0]), axis=-1)[:, :, 0]
    >>> surface = neurbs.NurbsSurface(net.astype(float))
    >>> with TemporaryDirectory() as folder:
    ...     neurbs.save(surface, Path(folder, "plane.step"))
    ...     [file.name for file in Path(folder).iterdir()]
    ['plane.step']
    """
    check_target(path)
    path = Path(path)
    part, write = _FORMATS[path.suffix.lower()]
    parts = _parts(thing)
    if part not in parts:
        fitting = " ".join(suffix for suffix, (held, _) in _FORMATS.items() if held in parts)
        raise NeurbsError(
            f"{path}: this file holds a {part}, which a {type(thing).__name__} has not: "
            f"it can be written as {fitting or 'nothing'}"
        )
    with replacement(path) as new:
        write(parts[part](), new)


def check_target(path: str | os.PathLike[str]) -> None:
    """Check, before the work that leads to it, that a file can be written.

    Parameters
    ----------
    path : str or path-like
        Where `save` will write.

    Raises
    ------
    NeurbsError
        If the suffix is unknown, or what writes it is not installed.
    OSError
        `IsADirectoryError` if `path` is a folder, `FileNotFoundError` or `NotADirectoryError` if
        there is no folder to write into, `PermissionError` if it must not be written.
    """
    path = Path(path)
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, "a result is a file, but this is a folder", str(path))
    if path.suffix.lower() not in _FORMATS:
        got = f"the suffix {path.suffix!r}" if path.suffix else "no suffix"
        raise NeurbsError(f"{path}: results are written as {' '.join(_FORMATS)}, got {got}")
    folder = Path(os.path.realpath(path)).parent
    if not folder.exists():
        raise FileNotFoundError(errno.ENOENT, "there is no such folder, make it first", str(folder))
    if not folder.is_dir():
        raise NotADirectoryError(errno.ENOTDIR, "this is not a folder", str(folder))
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(errno.EACCES, "this folder is not writeable", str(folder))
    if path.exists() and not path.is_file():
        raise NeurbsError(f"{path}: a result replaces a file, but this is a device or a pipe")
    if path.exists() and not os.access(path, os.W_OK):
        raise PermissionError(errno.EACCES, "this file is not writeable", str(path))
    if path.suffix.lower() == ".png" and importlib.util.find_spec("matplotlib") is None:
        raise NeurbsError(f"{path}: pictures need matplotlib: pip install 'neurbs[plot]'")


def _parts(thing: object) -> dict[str, Callable[[], Any]]:
    """Name what a thing can give to a file."""
    # Imported here because a Reconstruction saves itself with this module.
    from neurbs.reconstruction import Reconstruction

    match thing:
        case TriangleMesh():
            return {"mesh": lambda: thing}
        case NurbsSurface():
            return {"surface": lambda: thing, "mesh": thing.tessellate}
        case Reconstruction():
            return {
                "surface": lambda: thing.surface,
                "mesh": lambda: thing.mesh,
                "picture": lambda: thing,
            }
    return {}


def _write_png(result: Reconstruction, path: str) -> None:
    from neurbs.plot import plot_reconstruction

    plot_reconstruction(result).savefig(path, format="png", dpi="figure")


_FORMATS: dict[str, tuple[str, Callable[[Any, str], None]]] = {
    ".step": ("surface", _core.write_step),
    ".stp": ("surface", _core.write_step),
    ".igs": ("surface", _core.write_iges),
    ".iges": ("surface", _core.write_iges),
    ".obj": ("mesh", _core.write_obj),
    ".ply": ("mesh", write_ply),
    ".glb": ("mesh", write_glb),
    ".stl": ("mesh", write_stl),
    ".png": ("picture", _write_png),
}
"""Of each suffix: what part of a thing it holds, and who writes it."""

WRITABLE = {
    part: tuple(suffix for suffix, (held, _) in _FORMATS.items() if held == part)
    for part in ("surface", "mesh", "picture")
}
"""Suffixes that can be written, by what their files hold."""
