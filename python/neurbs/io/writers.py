"""`neurbs.save`: the contents and the writer of each suffix."""

from __future__ import annotations

import errno
import os
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from neurbs import _core
from neurbs._core import LENGTH_UNITS, Face, NeurbsError, NurbsSurface, Shell, TriangleMesh
from neurbs.errors import argument_error
from neurbs.extras import check_installed
from neurbs.io.atomic_write import atomic_write
from neurbs.io.csv_table import write_csv
from neurbs.io.face_json import write_shells
from neurbs.io.geomdl_json import write_json
from neurbs.io.glb import write_glb
from neurbs.io.off import write_off
from neurbs.io.ply import write_ply, write_ply_points
from neurbs.io.point_cloud import PointCloud
from neurbs.io.rhino import write_3dm
from neurbs.io.stl import write_stl
from neurbs.io.units import check_unit, conversion, file_unit
from neurbs.io.vtp import write_vtp

if TYPE_CHECKING:
    from neurbs import Reconstruction

    Thing: TypeAlias = NurbsSurface | Face | Shell | TriangleMesh | Reconstruction | PointCloud

_SMALLEST = 1e-5
"""Size in millimeters below which OpenCASCADE fails to read a surface, or changes it."""


def save(
    thing: Thing | list[Any] | tuple[Any, ...],
    path: str | os.PathLike[str],
    *,
    unit: str | None = None,
    pcurves: bool = True,
) -> None:
    """Write a surface, a face, a shell, a mesh, points or a result to a file.

    The suffix, in upper or lower case, selects the content and the format:

    ``.step`` ``.stp`` ``.igs`` ``.iges`` ``.3dm`` ``.json``
        A `NurbsSurface`, the faces of a `Reconstruction`, a `Face`, a `Shell`, or a list of
        these, with trims and all digits; closed shells as solids. ``.3dm`` keeps the name and the
        color that all faces of a shell have. The format of ``.json`` is geomdl's for a single
        surface, else that of `load_shell`.
    ``.obj``
        The same as free-form geometry. For a `TriangleMesh` or a `Reconstruction` the triangles,
        which more programs read.
    ``.ply`` ``.glb`` ``.stl`` ``.vtp`` ``.off``
        A `TriangleMesh`, the mesh of a `Reconstruction`, or a `NurbsSurface`, a `Face` or a
        `Shell` tessellated by default. All but ``.stl`` keep the digits of meshes far from the
        origin.
    ``.ply`` ``.csv``
        A `PointCloud` with its normals, colors and distances. For a `Reconstruction`, ``.csv`` has
        the points with their distances to the surface.
    ``.png`` ``.svg`` ``.pdf``
        A picture of a `Reconstruction`: points, lattice and faces. The last two have letters and
        lines as vectors; the faces are an image in them.
    ``.html``
        The report of a `Reconstruction`; `Reconstruction.write_report` has options for it.

    The file is written under another name and then renamed: it is complete or does not exist, and
    a file that it replaces is unchanged until then.

    Parameters
    ----------
    thing : NurbsSurface, Face, Shell, TriangleMesh, Reconstruction, PointCloud or list
        The object to write, or several faces, shells and surfaces.
    path : str or path-like
        The file; its folder must exist.
    unit : {"mm", "cm", "m", "in", "ft"}, optional
        The unit of the file. Numbers of an object with another unit are converted: the size stays.
        Those of an object without a unit are taken to be in it. By default it is the unit of the
        shell, points or result. STEP, IGES and Rhino files are in millimeters if it is unknown.
        See "Units" in the documentation for the formats that store it.
    pcurves : bool, default True
        Whether edges of trimmed faces in STEP files have curves in (u, v), too. Some programs
        stumble over them; without them programs compute their own.

    Raises
    ------
    NeurbsError
        If suffix or unit is unknown, the format cannot store the object, shells have different
        units and `unit` is not given, or it is given and the unit of the object is not a length.
    OSError
        If the file cannot be written.

    Warns
    -----
    UserWarning
        If the single precision of ``.stl`` moves vertices by more than a millionth of the mesh's
        diagonal, or faces of a polysurface in ``.3dm`` differ in name or color.

    Examples
    --------
    >>> import neurbs
    >>> import numpy as np
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> net = np.stack(np.meshgrid(range(4), range(4), [0.0]), axis=-1)[:, :, 0]
    >>> surface = neurbs.NurbsSurface(net.astype(float))
    >>> with TemporaryDirectory() as folder:
    ...     neurbs.save(surface, Path(folder, "plane.step"), unit="m")
    ...     [file.name for file in Path(folder).iterdir()]
    ['plane.step']
    """
    check_target(path)
    check_unit(unit)
    path = Path(path)
    formats = _FORMATS[path.suffix.lower()]
    parts = _parts(thing)
    # The parts are in order of preference.
    part = next((part for part in parts if part in formats), None)
    if part is None:
        suffixes = " ".join(suffix for suffix, held in _FORMATS.items() if held.keys() & parts)
        contents = " or a ".join(_NAMES.get(part, part) for part in formats)
        raise NeurbsError(
            f"{path}: the content must be a {contents}, got a "
            f"{type(thing).__name__}: it can be written as {suffixes or 'nothing'}"
        )
    write, known = formats[part], _unit_of(thing, unit)
    if unit is None and write in _IN_UNIT:
        unit = file_unit(known)
        if known is not None and unit is None:
            warnings.warn(
                f"{path}: the unit {known!r} is not a length: the numbers are written as they are",
                UserWarning,
                stacklevel=2,
            )
    elif part in _DRAWN and None not in (unit, known) and unit != known:
        raise argument_error("unit", f"must be {known!r}, that of the result, got {unit!r}")
    content = parts[part]() if unit is None else _converted(thing, parts, part, unit)
    if write is _write_step:
        write = partial(_write_step, pcurves=pcurves)
    with atomic_write(path) as new:
        if formats[part] in _IN_UNIT:
            write(content, new, unit)
        elif write in _WITH_NAME:
            write(content, new, unit or known)
        else:
            write(content, new)


def check_target(path: str | os.PathLike[str]) -> None:
    """Check that a file can be written, before a long computation.

    Parameters
    ----------
    path : str or path-like
        The path for `save`.

    Raises
    ------
    NeurbsError
        If the suffix is unknown, or the library for the format is not installed.
    OSError
        `IsADirectoryError` if `path` is a folder, `FileNotFoundError` or `NotADirectoryError` if
        its folder does not exist, `PermissionError` if it is not writeable.
    """
    path = Path(path)
    if path.suffix.lower() not in _FORMATS and not path.is_dir():
        got = f"the suffix {path.suffix!r}" if path.suffix else "no suffix"
        raise NeurbsError(f"{path}: results are written as {' '.join(_FORMATS)}, got {got}")
    check_place(path)
    if library := _LIBRARIES.get(path.suffix.lower()):
        check_installed(path, library)


def check_place(path: Path) -> None:
    """Check that a file of any format can be written at a place.

    Raises
    ------
    NeurbsError, OSError
        As for `check_target`.
    """
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, "a result is a file, but this is a folder", str(path))
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


def _parts(thing: object) -> dict[str, Callable[[], Any]]:
    """Return the parts of an object that files can store, in order of preference."""
    match thing:
        case TriangleMesh():
            return {"mesh": lambda: thing}
        case NurbsSurface():
            return {"surface": lambda: thing, **_shell(thing), "mesh": thing.tessellate}
        case Face() | Shell():
            return {**_shell(thing), "mesh": thing.tessellate}
        case PointCloud():
            return {"points": lambda: thing}
        case list() | tuple():
            return _shell(*thing)
    # Not by its class, as the module of `Reconstruction` uses this one.
    parts: dict[str, Callable[[], Any]] = getattr(thing, "_file_parts", dict)()
    return parts


def _shell(*things: Any) -> dict[str, Callable[[], Any]]:
    """Return one shell for each of several things; nothing if some is no surface."""
    if not things or not all(isinstance(each, Shell | Face | NurbsSurface) for each in things):
        return {}
    return {"shell": lambda: [each if isinstance(each, Shell) else Shell(each) for each in things]}


def _unit_of(thing: object, wanted: str | None) -> str | None:
    """Return the unit of an object; several shells must have the same, unless one is wanted."""
    if not isinstance(thing, list | tuple):
        unit: str | None = getattr(thing, "unit", None)
        return unit
    units = {each.unit for each in thing if isinstance(each, Shell)}
    if len(units) > 1 and wanted is None:
        got = " and ".join(sorted(str(unit) for unit in units))
        raise NeurbsError(f"shells in a file must have the same unit, got {got}: give `unit`")
    return units.pop() if len(units) == 1 else None


def _converted(thing: object, parts: dict[str, Callable[[], Any]], part: str, unit: str) -> Any:
    """Return a part of an object in another unit."""
    if part == "points":
        return parts[part]().to_unit(unit)
    if isinstance(thing, list | tuple):
        # Each may have a unit of its own.
        return [shell.to_unit(unit) for shell in parts[part]()]
    factors = conversion(getattr(thing, "unit", None), unit)
    if np.all(factors == 1) or part in _DRAWN:
        return parts[part]()
    matrix = np.diag([*factors, 1.0])
    if part == "shell":
        return [shell.transformed(matrix) for shell in parts[part]()]
    # A mesh alone has no unit, so there is a surface or one shell.
    whole = parts["surface"]() if "surface" in parts else parts["shell"]()[0]
    transformed = whole.transformed(matrix)
    return transformed.tessellate() if part == "mesh" else transformed


def _write_step(shells: list[Shell], path: str, unit: str | None, *, pcurves: bool = True) -> None:
    _check_size(shells, "STEP", unit)
    _core.write_step(shells, path, unit, pcurves=pcurves)


def _write_iges(shells: list[Shell], path: str, unit: str | None) -> None:
    _check_size(shells, "IGES", unit)
    _core.write_iges(shells, path, unit)


def _check_size(shells: list[Shell], name: str, unit: str | None) -> None:
    """Raise if a surface is too small for CAD systems, which merge points within 1e-7 mm."""
    for face in (face for shell in shells for face in shell.faces):
        low, high = face.surface.bounding_box(tight=False)
        size = float(np.linalg.norm(high - low)) * LENGTH_UNITS[unit or "mm"] / LENGTH_UNITS["mm"]
        if size < _SMALLEST:
            raise NeurbsError(
                f"surfaces in {name} files must be larger than {_SMALLEST} mm, got {size:.2g} mm: "
                "scale the surface, give another `unit`, or write .json"
            )


def _write_report(result: Reconstruction, path: str, unit: str | None) -> None:
    from neurbs.report import write_page

    write_page(result, path, unit=unit or "")


def _write_picture(result: Reconstruction, path: str, unit: str | None, *, suffix: str) -> None:
    from neurbs.plot.figures import plot_reconstruction, write_picture

    write_picture(plot_reconstruction(result, unit=unit or ""), path, suffix)


_PICTURES = (".png", ".svg", ".pdf")
"""Suffixes of pictures."""

_FORMATS: dict[str, dict[str, Callable[..., None]]] = {
    ".step": {"shell": _write_step},
    ".stp": {"shell": _write_step},
    ".igs": {"shell": _write_iges},
    ".iges": {"shell": _write_iges},
    ".3dm": {"shell": write_3dm},
    ".json": {"surface": write_json, "shell": write_shells},
    ".obj": {"shell": _core.write_obj_shells, "mesh": _core.write_obj},
    ".ply": {"mesh": write_ply, "points": write_ply_points},
    ".glb": {"mesh": write_glb},
    ".stl": {"mesh": write_stl},
    ".vtp": {"mesh": write_vtp},
    ".off": {"mesh": write_off},
    ".csv": {"points": write_csv},
    **{suffix: {"picture": partial(_write_picture, suffix=suffix)} for suffix in _PICTURES},
    ".html": {"report": _write_report},
}
"""For each suffix the parts of an object that it can store, with their writers."""

_NAMES = {"shell": "surface or a shell"}
"""What messages call a part, if not by its key. A surface is written as a shell."""

_IN_UNIT = (_write_step, _write_iges, write_3dm, write_glb, write_shells, write_json)
"""Writers of files whose unit is one of `LENGTH_UNITS`."""

_WITH_NAME = (write_ply, _write_report, *(_FORMATS[suffix]["picture"] for suffix in _PICTURES))
"""Writers that take the name of any unit. The unit of points is theirs."""

_DRAWN = ("picture", "report")
"""Parts whose numbers are not converted."""

_LIBRARIES = {".3dm": "rhino3dm", ".html": "plotly", **dict.fromkeys(_PICTURES, "matplotlib")}
"""The library that a format needs."""

WRITABLE = {
    part: tuple(suffix for suffix, parts in _FORMATS.items() if not parts.keys().isdisjoint(stored))
    for part, stored in {
        # A surface can be written as a shell.
        "surface": ("surface", "shell"),
        "mesh": ("mesh",),
        "points": ("points",),
        "picture": ("picture",),
        "report": ("report",),
    }.items()
}
"""Suffixes that can be written, for each part of an object."""
