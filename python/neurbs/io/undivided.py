"""Shells whose edges are whole curves of the faces' loops."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from neurbs._core import Face, NeurbsError, NurbsCurve, NurbsSurface, Shell
from neurbs.io.face_file import Edges

_SAMPLES = 65
"""Points of a curve among which the nearest one to a vertex is sought."""

_NARROWINGS = 9
"""Divisions of an interval by half the number of samples, to the resolution of floating point."""

_AT_END = 1e-9
"""Share of a curve's domain within which a place is its end."""


def undivided(shell: Shell) -> tuple[Shell, list[Edges]]:
    """Return a shell of the same faces whose loops' curves are one edge each, and the edges.

    Joining by position divides edges where others end on them; here the loops are divided, too.

    Raises
    ------
    NeurbsError
        If the faces cannot be divided so.
    """
    edges: list[Edges] | None = shell.to_dict()["edges"]
    if edges is not None:
        return shell, edges
    faces = [_divided(f, face, shell) for f, face in enumerate(shell.faces)]
    made = Shell(faces, tolerance=shell.tolerance, unit=shell.unit)
    edges = made.to_dict()["edges"]
    if edges is None:
        raise NeurbsError("a shell must have edges that are curves of its faces: write .step")
    return made, edges


def _divided(f: int, face: Face, shell: Shell) -> Face:
    """Return a face with its loops divided at the vertices of its edges."""
    numbers = {v for edge in shell.edges if f in edge.faces for v in edge.vertices}
    vertices = shell.vertices[sorted(numbers)]
    loops = [
        [part for curve in each for part in _parts(curve, face.surface, vertices, shell.tolerance)]
        for each in face.loops
    ]
    if [len(each) for each in loops] == [len(each) for each in face.loops]:
        return face
    return Face(face.surface, loops, name=face.name, color=face.color, reversed=face.is_reversed)


def _parts(
    curve: NurbsCurve, surface: NurbsSurface, vertices: NDArray[np.float64], tolerance: float
) -> list[NurbsCurve]:
    first, last = curve.domain
    ends = _points(curve, surface, np.array([first, last]))
    cuts = []
    for vertex in vertices:
        # Edges that other faces end on are within the tolerance of each other's ends.
        if (np.linalg.norm(ends - vertex, axis=1) <= 2 * tolerance).any():
            continue
        at, distance = _nearest(curve, surface, vertex)
        if distance <= 2 * tolerance:
            cuts.append(at)
    places = [first, *sorted(cuts), last]
    least = _AT_END * (last - first)
    pairs = itertools.pairwise(places)
    return [curve.sub_curve(a, b) for a, b in pairs if b - a > least] if cuts else [curve]


def _points(
    curve: NurbsCurve, surface: NurbsSurface, at: NDArray[np.float64]
) -> NDArray[np.float64]:
    (u0, u1), (v0, v1) = surface.domain
    return surface.evaluate(np.clip(curve.evaluate(at)[:, :2], [u0, v0], [u1, v1]))


def _nearest(
    curve: NurbsCurve, surface: NurbsSurface, vertex: NDArray[np.float64]
) -> tuple[float, float]:
    """Return the parameter where a curve on a surface is nearest to a point, and the distance."""
    low, high = curve.domain
    for _ in range(_NARROWINGS):
        at = np.linspace(low, high, _SAMPLES)
        distances = np.linalg.norm(_points(curve, surface, at) - vertex, axis=1)
        k = int(np.argmin(distances))
        low, high = float(at[max(k - 1, 0)]), float(at[min(k + 1, _SAMPLES - 1)])
    return float(at[k]), float(distances[k])
