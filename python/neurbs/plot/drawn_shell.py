"""The triangles and lines of a shell that a picture shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.plot.axes_box import AxesBox

if TYPE_CHECKING:
    from neurbs import Face, Shell, TriangleMesh

_FLATNESS = 0.2
"""Largest distance of triangles from a face, as a share of their longest side."""

_MAX_TRIANGLES = 1_000_000
"""Most triangles of a face."""

_EDGE_SEGMENTS, _LINE_SEGMENTS = 64, 240
"""Segments of an edge and of an isoparametric line."""


@dataclass(frozen=True, eq=False)
class DrawnShell:
    """A shell as triangles with a place on a face at each vertex, edges and isoparametric lines.

    Each face has its own vertices, as parameters and normals at an edge differ between faces.

    Attributes
    ----------
    faces : list of Face
        The faces.
    vertices : ndarray of shape (n, 3)
        Points on the faces.
    uv : ndarray of shape (n, 2)
        Their parameters.
    face_index : ndarray of int, shape (n,)
        Their faces.
    triangles : ndarray of int, shape (m, 3)
        Indices of vertices.
    edges : list of (ndarray of shape (k, 3), bool)
        Places along each edge, and whether it is a border.
    isolines : list of ndarray of shape (k, 6)
        Places along isoparametric lines inside the faces, and the normals there.
    """

    faces: list[Face]
    vertices: NDArray[np.float64]
    uv: NDArray[np.float64]
    face_index: NDArray[np.int64]
    triangles: NDArray[np.int64]
    edges: list[tuple[NDArray[np.float64], bool]]
    isolines: list[NDArray[np.float64]]

    @classmethod
    def of(cls, shell: Shell, box: AxesBox, facets: int, isolines: int = 0) -> DrawnShell:
        """Divide a shell into triangles.

        Parameters
        ----------
        shell : Shell
            The shell.
        box : AxesBox
            The box in which it is drawn: triangles are small where axes are drawn longer, too.
        facets : int
            Triangles along the longest drawn side of the box.
        isolines : int
            Isoparametric lines across the longer direction of each face; 0 for none.
        """
        faces = shell.faces
        longest, drawn = box.drawn.max() / facets, np.diag([*box.factor, 1.0])
        meshes = [_mesh(face.transformed(drawn), longest) for face in faces]
        counts = [len(mesh.vertices) for mesh in meshes]
        starts = np.cumsum([0, *counts[:-1]])
        lines = (_isolines(face, box, isolines) for face in faces if isolines)
        return cls(
            faces,
            np.concatenate([mesh.vertices for mesh in meshes]) / box.factor,
            np.concatenate([mesh.uv for mesh in meshes]),
            np.repeat(np.arange(len(faces)), counts),
            np.concatenate([m.triangles + start for m, start in zip(meshes, starts, strict=True)]),
            [
                (edge.curve.evaluate(np.linspace(*edge.curve.domain, _EDGE_SEGMENTS + 1)), border)
                for edge in shell.edges
                for border in [edge.is_border]
            ],
            [line for of_face in lines for line in of_face],
        )

    def normals(self) -> NDArray[np.float64]:
        """Return the normal of the surface at each vertex, with the orientation of the face."""
        normals = np.empty_like(self.vertices)
        for face, on_face in self.by_face():
            sign = -1.0 if face.is_reversed else 1.0
            normals[on_face] = sign * face.surface.normals(self.uv[on_face])
        return normals

    def by_face(self) -> list[tuple[Face, NDArray[np.bool_]]]:
        """Return each face with a mask of its vertices."""
        return [(face, self.face_index == index) for index, face in enumerate(self.faces)]

    def face_colors(self, default: tuple[float, float, float]) -> NDArray[np.float64]:
        """Return the color of the face of each vertex, shape (n, 3)."""
        return np.array([face.color or default for face in self.faces])[self.face_index]


def _mesh(face: Face, longest: float) -> TriangleMesh:
    """Divide a face into triangles with sides up to a length, or longer if they are too many."""
    while True:
        try:
            return face.tessellate(
                _FLATNESS * longest, max_edge=longest, max_triangles=_MAX_TRIANGLES
            )
        except NeurbsError:
            # A surface that runs away from its points is as large as the box many times over.
            longest *= 4


def _isolines(face: Face, box: AxesBox, count: int) -> list[NDArray[np.float64]]:
    """Return isoparametric lines of a face with similar distances in u and v."""
    surface = face.surface
    steps = [np.linspace(*ends, _LINE_SEGMENTS + 1) for ends in surface.domain]
    few = [np.linspace(*ends, 9) for ends in surface.domain]
    across = (
        surface.evaluate_grid(steps[0], few[1]),
        surface.evaluate_grid(few[0], steps[1]).swapaxes(0, 1),
    )
    lengths = np.array(
        [np.linalg.norm(np.diff(b * box.factor, axis=0), axis=2).sum(axis=0).mean() for b in across]
    )
    lines = []
    for axis in (0, 1):
        places = max(2, round(count * lengths[axis] / lengths.max()))
        for value in np.linspace(*surface.domain[axis], places):
            uv = np.empty((_LINE_SEGMENTS + 1, 2))
            uv[:, axis], uv[:, 1 - axis] = value, steps[1 - axis]
            inside = face.contains(uv) if face.is_trimmed else np.ones(len(uv), bool)
            lines += [
                np.hstack([surface.evaluate(part), surface.normals(part)])
                for part in _runs(uv, inside)
            ]
    return lines


def _runs(uv: NDArray[np.float64], inside: NDArray[np.bool_]) -> list[NDArray[np.float64]]:
    """Return the longest runs of places inside, of two or more places each."""
    ends = np.flatnonzero(np.diff(inside)) + 1
    parts = np.split(uv, ends)
    return [
        part
        for part, kept in zip(parts, np.split(inside, ends), strict=True)
        if kept[0] and len(part) > 1
    ]
