"""Shells as Rhino's polysurfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neurbs._core import Edge, Face, NeurbsError, NurbsCurve, NurbsSurface, Shell
from neurbs.io import loop_curves
from neurbs.io.face_file import Edges
from neurbs.io.rhino_archive import (
    BrepData,
    BrepFace,
    Loop,
    Trim,
    brep_dict,
    curve_bytes,
    object_bytes,
)
from neurbs.io.rhino_archive import Edge as BrepEdge
from neurbs.io.undivided import undivided

_BOUNDARY, _MATED, _SEAM, _SINGULAR = 1, 2, 3, 4
"""Kinds of trims."""

_SIDES = (4, 5, 6, 3)
"""Flags of trims on the sides v0, u1, v1, u0."""

_U_FIXED, _V_FIXED = 1, 2
"""Flags of trims along isocurves inside the surface."""

_ISO_WIDTH = 2.0**-22
"""Largest variation along an isocurve, and twice the largest distance from a side.

Both are shares of the domain, measured on openNURBS, which refuses other flags.
"""


def is_surface(shell: Shell) -> bool:
    """Whether a shell is a single open face that is not trimmed."""
    return (
        len(shell.faces) == 1
        and not shell.faces[0].is_trimmed
        and not shell.faces[0].is_reversed
        and all(edge.is_border for edge in shell.edges)
    )


def surface_of(rhino3dm: Any, surface: NurbsSurface) -> Any:
    """Return a surface of rhino3dm; its knots are clamped."""
    surface = surface.clamped()
    rows, cols = surface.control_points.shape[:2]
    p, q = surface.degree
    rational = surface.weights is not None
    weights = np.ones((rows, cols)) if surface.weights is None else surface.weights
    theirs = rhino3dm.NurbsSurface.Create(3, rational, p + 1, q + 1, rows, cols)
    for knots, places in zip(surface.knots, (theirs.KnotsU, theirs.KnotsV), strict=True):
        # Rhino omits the first and the last knot, which have no effect.
        for i, knot in enumerate(knots[1:-1].tolist()):
            places[i] = knot
    homogeneous = np.dstack([surface.control_points * weights[..., None], weights])
    for i, row in enumerate(homogeneous.tolist()):
        for j, point in enumerate(row):
            theirs.Points[i, j] = rhino3dm.Point4d(*point)
    return theirs


def brep_of(rhino3dm: Any, shell: Shell) -> Any:
    """Return a shell as a Brep.

    Raises
    ------
    NeurbsError
        If Rhino's library refuses it.
    """
    shell, edges = undivided(shell)
    brep = _Builder(rhino3dm, shell, edges).built()
    places = np.concatenate([f.surface.control_points.reshape(-1, 3) for f in shell.faces])
    box = (*places.min(axis=0).tolist(), *places.max(axis=0).tolist())
    made = rhino3dm.Brep.Decode(brep_dict(brep, shell.tolerance, box, solid=shell.is_closed))
    if made is None:
        raise NeurbsError("a polysurface must be one that Rhino's library reads, but it refuses it")
    valid, log = made.IsValidWithLog
    if not valid:
        raise NeurbsError(f"a polysurface must be valid for Rhino, but: {' '.join(log.split())}")
    return made


@dataclass
class _Use:
    """A curve of a loop: its edge, whether it runs along it, and its start and end."""

    edge: int | None
    forward: bool
    vertices: tuple[int, int]


class _Builder:
    """The parts of a Brep, made one face after the other."""

    def __init__(self, rhino3dm: Any, shell: Shell, edges: list[Edges]) -> None:
        self._rhino3dm = rhino3dm
        self._shell = shell
        self._identifiers = edges
        self._edges: list[Edge] = shell.edges
        self._first_face: dict[int, int] = {}
        self._brep = BrepData()
        self._trims_of: list[list[int]] = [[] for _ in self._edges]

    def built(self) -> BrepData:
        brep, shell = self._brep, self._shell
        brep.vertices = [tuple(place) for place in shell.vertices.tolist()]
        brep.space_curves = [curve_bytes(edge.curve, 3) for edge in self._edges]
        for f, face in enumerate(shell.faces):
            self._face(f, face)
        brep.edges = [
            BrepEdge(edge.curve.domain, edge.vertices, trims)
            for edge, trims in zip(self._edges, self._trims_of, strict=True)
        ]
        return brep

    def _face(self, f: int, face: Face) -> None:
        brep, surface = self._brep, face.surface
        brep.surfaces.append(object_bytes(surface_of(self._rhino3dm, surface)))
        first = len(brep.loops)
        for index, curves in enumerate(face.loops):
            # Rhino's trims meet exactly.
            curves = loop_curves.closed(curves, surface, float("inf"))
            uses = self._uses(f, face, self._identifiers[f][index])
            numbers = [
                self._trim(f, curve, use, surface, len(brep.loops))
                for curve, use in zip(curves, uses, strict=True)
            ]
            brep.loops.append(Loop(numbers, 1 if index == 0 else 2, f))
        brep.faces.append(BrepFace(list(range(first, len(brep.loops))), f, face.is_reversed))

    def _uses(self, f: int, face: Face, edges: list[int | None]) -> list[_Use]:
        uses: list[_Use] = []
        for edge in edges:
            if edge is None:
                uses.append(_Use(None, True, (-1, -1)))
                continue
            if edge in self._first_face:
                # Two faces with normals on the same side run along their edge in opposite ways.
                first = self._shell.faces[self._first_face[edge]]
                forward = first.is_reversed != face.is_reversed
            else:
                self._first_face[edge] = f
                forward = True
            start, end = self._edges[edge].vertices
            uses.append(_Use(edge, forward, (start, end) if forward else (end, start)))
        for k, use in enumerate(uses):
            if use.edge is None:
                # A pole begins and ends where the next edge begins.
                following = (uses[(k + n) % len(uses)] for n in range(1, len(uses)))
                pole = next(other.vertices[0] for other in following if other.edge is not None)
                use.vertices = (pole, pole)
        return uses

    def _trim(
        self, f: int, curve: NurbsCurve, use: _Use, surface: NurbsSurface, in_loop: int
    ) -> int:
        brep = self._brep
        number = len(brep.trims)
        brep.plane_curves.append(curve_bytes(curve, 2))
        if use.edge is None:
            kind = _SINGULAR
        else:
            self._trims_of[use.edge].append(number)
            kind = _kind(self._edges[use.edge])
        brep.trims.append(
            Trim(
                number,
                curve.domain,
                -1 if use.edge is None else use.edge,
                use.vertices,
                not use.forward,
                kind,
                _iso(curve, surface),
                in_loop,
            )
        )
        return number


def _kind(edge: Edge) -> int:
    if edge.is_border:
        return _BOUNDARY
    return _SEAM if edge.faces[0] == edge.faces[1] else _MATED


def _iso(curve: NurbsCurve, surface: NurbsSurface) -> int:
    """Return the flag of a curve on a side or along an isocurve."""
    (u0, u1), (v0, v1) = surface.domain
    places: NDArray[np.float64] = (curve.control_points[:, :2] - [u0, v0]) / [u1 - u0, v1 - v0]
    low, high = places.min(axis=0), places.max(axis=0)
    fixed = high - low <= _ISO_WIDTH
    near = 0.5 * _ISO_WIDTH
    at_low = np.maximum(abs(low), abs(high)) <= near
    at_high = np.maximum(abs(low - 1), abs(high - 1)) <= near
    on_sides = (at_low[1], at_high[0], at_high[1], at_low[0])
    for flag, on_side in zip(_SIDES, on_sides, strict=True):
        if on_side:
            return flag
    if fixed[0]:
        return _U_FIXED
    return _V_FIXED if fixed[1] else 0
