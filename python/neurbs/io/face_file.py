"""The content of a file of faces."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from neurbs._core import Face, NeurbsError, NurbsCurve, NurbsSurface
from neurbs.io.units import ratio

Loops = list[list[NurbsCurve]]
"""Closed chains of curves in (u, v), the outer one first."""

Edges = list[list[int | None]]
"""For each curve of each loop the number of its edge; None where it is one point in space."""


@dataclass(frozen=True)
class FaceData:
    """A face as a file describes it, not yet checked.

    Attributes
    ----------
    number : int
        The place in the file, from 1.
    surface : NurbsSurface
        The surface.
    loops : list of lists of NurbsCurve, optional
        The loops; None for the whole surface.
    edges : list of lists of int or None, optional
        The edges of the loops, or of the four sides of the whole surface; None if the file has no
        common edges.
    is_trimmed : bool
        Whether a loop runs inside the surface's rectangle.
    is_reversed : bool
        Whether the normals are opposite to the surface's.
    name : str, optional
        The name.
    color : (float, float, float), optional
        Red, green and blue between 0 and 1.
    defect : str, optional
        Why the loops could not be read.
    """

    number: int
    surface: NurbsSurface
    loops: Loops | None = None
    edges: Edges | None = None
    is_trimmed: bool = False
    is_reversed: bool = False
    name: str | None = None
    color: tuple[float, float, float] | None = None
    defect: str | None = None

    def face(self) -> Face:
        """Make the face.

        Raises
        ------
        NeurbsError
            If a loop is wrong.
        """
        return Face(
            self.surface, self.loops, name=self.name, color=self.color, reversed=self.is_reversed
        )

    def edges_of(self, face: Face) -> Edges | None:
        """Return the edges in the order of the face's loops, which it may have turned round."""
        if self.edges is None or self.loops is None:
            return self.edges
        pairs = zip(self.edges, self.loops, face.loops, strict=True)
        return [
            edges if given[0] == made[0] else edges[::-1]  # A turned curve differs.
            for edges, given, made in pairs
        ]


@dataclass(frozen=True)
class FaceFile:
    """The faces of a file, with its unit.

    Attributes
    ----------
    faces : list of FaceData
        The faces, in the order of the file.
    unit : str, optional
        The unit of the coordinates, one of `LENGTH_UNITS`; None if the file has no or another unit.
    left_out : list of str
        For each face that could not be read its number, its name and the cause.
    others : Counter
        What the file has besides faces: how many of each kind, as "curve" or "mesh".
    tolerance : float, optional
        Distance within which edges are the same; None if the file has none.
    """

    faces: list[FaceData]
    unit: str | None = None
    left_out: list[str] = field(default_factory=list)
    others: Counter[str] = field(default_factory=Counter)
    tolerance: float | None = None

    def contents(self) -> str:
        """Return what the file has besides faces: "3 curves, 1 mesh"."""
        counts = sorted(self.others.items())
        return ", ".join(f"{n} {kind if n == 1 else plural(kind)}" for kind, n in counts)


def plural(kind: str) -> str:
    """Return the plural of a noun."""
    return f"{kind}es" if kind.endswith(("sh", "x", "s")) else f"{kind}s"


def label(number: int, name: str | None) -> str:
    """Name a face of a file in a message.

    Examples
    --------
    >>> label(3, "lid"), label(4, None)
    ("face 3 ('lid')", 'face 4')
    """
    return f"face {number}" + (f" ({name!r})" if name else "")


def no_faces(path: Path, file: FaceFile, kind: str) -> NeurbsError:
    """Return the error for a file without faces; `kind` is what was wanted."""
    if file.left_out:
        return NeurbsError(f"{path}: must have {kind}s that can be read, but {file.left_out[0]}")
    got = f"only {file.contents()}" if file.others else "none: it may be cut short"
    return NeurbsError(f"{path}: must have at least one {kind}, but has {got}")


def in_unit(file: FaceFile, unit: str | None) -> FaceFile:
    """Return a file with its coordinates in another unit; one without a unit gets it."""
    if unit is None or unit == file.unit:
        return file
    if file.unit is None:
        return replace(file, unit=unit)
    factor = ratio(file.unit, unit)
    tolerance = None if file.tolerance is None else factor * file.tolerance
    return replace(file, faces=scaled(file.faces, factor), unit=unit, tolerance=tolerance)


def scaled(faces: list[FaceData], factor: float) -> list[FaceData]:
    """Return faces with their coordinates multiplied by a factor."""
    if factor == 1:
        return faces
    matrix = np.diag([factor, factor, factor, 1.0])
    return [replace(face, surface=face.surface.transformed(matrix)) for face in faces]
