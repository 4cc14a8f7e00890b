"""`neurbs.load_shell`: all faces of a file, joined."""

from __future__ import annotations

import itertools
import os
import warnings
from collections import Counter
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray

from neurbs._core import Face, NeurbsError, Shell
from neurbs.choices import LengthUnit
from neurbs.io.face_file import Edges, FaceFile, label, no_faces
from neurbs.io.face_readers import READABLE_FACES, read_faces
from neurbs.io.reading import cause

_APART = 1e-3
"""Share of the diagonal beyond which curves of the same edge show that a file is wrong."""

_NAMED = 3
"""Most faces that a warning names."""


def load_shell(path: str | os.PathLike[str], *, unit: str | None = None) -> Shell:
    """Read all faces of a file, with loops, orientation, names and colors, as one shell.

    The suffix, in upper or lower case, selects the format:

    ``.step``, ``.stp``, ``.igs``, ``.iges``
        All faces, in their places in assemblies, converted to B-spline surfaces.
    ``.3dm``
        The surfaces, solids and extrusions of a Rhino model, and those of its blocks at each place.
    ``.json``
        Shells that `save` wrote, or surfaces of the library geomdl.
    ``.obj``
        Free-form surfaces of the type B-spline, with their trims.

    Several solids or shells become components of the same shell. Edges are those of the file. A
    file that shares no edges between faces has its faces joined by position.

    Parameters
    ----------
    path : str or path-like
        The file. ``.step .stp .igs .iges .3dm`` need ``pip install 'neurbs[cad]'``.
    unit : {"mm", "cm", "m", "in", "ft"}, optional
        The unit of the result. Numbers of a file with another unit are converted; those of a file
        without one are taken to be in it. By default the unit of the file.

    Returns
    -------
    Shell
        At least one face, in the order of the file.

    Raises
    ------
    NeurbsError
        If the suffix is unknown, the library for the format is not installed, the file is damaged
        or has no face that can be read, or `unit` is unknown.
    OSError
        If the file cannot be read.

    Warns
    -----
    UserWarning
        If faces are left out because they cannot be read, if the faces cannot be joined, or if the
        file has things that are not faces. The message names them, or gives the place.

    See Also
    --------
    load_surfaces : Read the untrimmed surfaces.

    Examples
    --------
    >>> import neurbs
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> ball = neurbs.Shell(neurbs.NurbsSurface.sphere([0, 0, 0], 2.0), unit="cm")
    >>> with TemporaryDirectory() as folder:
    ...     neurbs.save(ball, Path(folder, "ball.json"))
    ...     neurbs.load_shell(Path(folder, "ball.json")) == ball
    True
    """
    path = Path(path)
    file = read_faces(path, "face", READABLE_FACES, unit)
    faces, edges, left_out = _checked(file)
    if not faces:
        raise no_faces(path, FaceFile([], left_out=left_out), "face")
    shell, problem = _joined(faces, edges, file)
    if left_out:
        more = f", and {len(left_out) - _NAMED} more" if len(left_out) > _NAMED else ""
        named = "; ".join(left_out[:_NAMED]) + more
        total = len(faces) + len(left_out)
        _warn(f"{path}: {len(left_out)} of {total} faces are left out: {named}")
    if problem is not None:
        _warn(f"{path}: the {len(faces)} faces are not joined: {problem}")
    if file.others:
        _warn(f"{path}: only faces are read; left out: {file.contents()}")
    return shell


def _warn(message: str) -> None:
    warnings.warn(message, UserWarning, stacklevel=3)  # The caller of `load_shell`.


def _checked(file: FaceFile) -> tuple[list[Face], list[Edges | None], list[str]]:
    """Return the faces, their edges, and number, name and cause for those that are wrong."""
    faces: list[Face] = []
    all_edges: list[Edges | None] = []
    left_out = list(file.left_out)
    for data in file.faces:
        try:
            if data.defect is not None:
                raise NeurbsError(data.defect)
            face = data.face()
        except NeurbsError as error:
            left_out.append(f"{label(data.number, data.name)}: {cause(error)}")
            continue
        faces.append(face)
        all_edges.append(data.edges_of(face))
    return faces, all_edges, left_out


def _joined(
    faces: list[Face], edges: list[Edges | None], file: FaceFile
) -> tuple[Shell, str | None]:
    """Join faces by the file's edges, or by position; else say why they are not joined."""
    unit = cast(LengthUnit | None, file.unit)
    known = [of_face for of_face in edges if of_face is not None]
    if len(known) == len(faces) and _shared(known) and _meet(faces, known):
        try:
            shell = Shell(faces, edges=known, tolerance=file.tolerance, unit=unit)
        except NeurbsError:
            pass
        else:
            return shell, None
    try:
        return Shell(faces, tolerance=file.tolerance, unit=unit), None
    except NeurbsError as error:
        problem = str(error)
    numbers = itertools.count()
    apart = [[[next(numbers) for _ in each] for each in face.loops] for face in faces]
    return Shell(faces, edges=apart, tolerance=file.tolerance, unit=unit), problem


def _shared(edges: list[Edges]) -> bool:
    """Whether an edge belongs to two faces; or, of a single face, is a seam."""
    uses = [[edge for each in face for edge in each if edge is not None] for face in edges]
    if len(uses) > 1:
        uses = [list(set(of_face)) for of_face in uses]
    return any(count > 1 for count in Counter(itertools.chain.from_iterable(uses)).values())


def _meet(faces: list[Face], edges: list[Edges]) -> bool:
    """Whether the curves of each edge begin and end at the same two places."""
    nets = np.concatenate([face.surface.control_points.reshape(-1, 3) for face in faces])
    largest = _APART * float(np.linalg.norm(np.ptp(nets, axis=0)))
    ends: dict[int, NDArray[np.float64]] = {}
    for face, of_face in zip(faces, edges, strict=True):
        curves = itertools.chain.from_iterable(face.loops)
        places = np.array([curve.control_points[[0, -1], :2] for curve in curves])
        (u0, u1), (v0, v1) = face.surface.domain
        inside = np.clip(places.reshape(-1, 2), [u0, v0], [u1, v1])
        points = face.surface.evaluate(inside).reshape(-1, 2, 3)
        numbers = itertools.chain.from_iterable(of_face)
        for number, here in zip(numbers, points, strict=True):
            if number is not None:
                there = ends.setdefault(number, here)
                if min(abs(here - there).max(), abs(here[::-1] - there).max()) > largest:
                    return False
    return True
