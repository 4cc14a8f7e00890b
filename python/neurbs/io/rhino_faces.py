"""Faces of Rhino's Breps and surfaces, with their loops."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError, NurbsCurve, NurbsSurface, Shell
from neurbs.io import loop_curves
from neurbs.io.face_file import Edges, FaceData, Loops
from neurbs.io.rhino_archive import BrepData, BrepFace, decodable, read_brep

_OUTER, _INNER = 1, 2
"""Kinds of loops; others are slits and points."""

_SAMPLES = 6
"""Places in each direction at which a surface and its NURBS form are compared."""

_ACCURACY = 1e-9
"""Distance of the NURBS form from the surface, as a share of its size."""

Floats = NDArray[np.float64]
Number = Callable[[], int]
"""Gives the next number."""


@dataclass(frozen=True)
class LeftOut:
    """A face that cannot be read: its number, and the cause."""

    number: int
    cause: str


def surface_data(theirs: Any, number: Number, edge: Number) -> FaceData | LeftOut:
    """Convert a surface that is an object of its own."""
    k = number()
    try:
        surface = nurbs_surface(theirs.ToNurbsSurface())
    except NeurbsError as error:
        return LeftOut(k, str(error))
    given: list[Edges] | None = Shell(surface).to_dict()["edges"]
    edges: Edges | None = None
    if given is not None:
        numbered = _renumbered(itertools.chain.from_iterable(given[0]), edge)
        edges = [[e if e is None else numbered[e] for e in each] for each in given[0]]
    return FaceData(k, surface, edges=edges)


def brep_data(
    rhino3dm: Any, brep: Any, tolerance: float, number: Number, edge: Number
) -> list[FaceData | LeftOut]:
    """Convert the faces of a Brep whose curves meet within a tolerance."""
    encoded = brep.Encode()
    data = read_brep(encoded)
    numbered = _renumbered((trim.edge for trim in data.trims if trim.edge >= 0), edge)
    faces: list[FaceData | LeftOut] = []
    for theirs, face in zip(brep.Faces, data.faces, strict=True):
        k = number()
        own = theirs.UnderlyingSurface()
        about: dict[str, Any] = {"is_reversed": face.is_reversed}
        try:
            surface = nurbs_surface(own.ToNurbsSurface())
        except NeurbsError as error:
            faces.append(LeftOut(k, str(error)))
            continue
        try:
            loops, edges = _loops(rhino3dm, encoded, data, face, numbered)
            loop_curves.check_loops_there(loops)
            to_spline = _parameters(own, surface)
            loops = [[to_spline(curve) for curve in each] for each in loops]
            loops = [loop_curves.closed(each, surface, tolerance) for each in loops]
        except NeurbsError as error:
            faces.append(FaceData(k, surface, is_trimmed=True, defect=str(error), **about))
            continue
        whole = loop_curves.whole_or_trimmed(surface, loops, edges)
        faces.append(FaceData(k, surface, *whole, **about))
    return faces


def _renumbered(edges: Any, edge: Number) -> dict[int, int]:
    """Return numbers that no other object has."""
    found = {e for e in edges if e is not None}
    return {e: edge() for e in sorted(found)}


def _loops(
    rhino3dm: Any, encoded: Any, data: BrepData, face: BrepFace, numbered: dict[int, int]
) -> tuple[Loops, Edges]:
    """Return the loops in the surface's own parameters, the outer one first."""
    loops = [data.loops[k] for k in face.loops if data.loops[k].kind in (_OUTER, _INNER)]
    curves: Loops = []
    edges: Edges = []
    for loop in sorted(loops, key=lambda loop: loop.kind):
        trims = [data.trims[k] for k in loop.trims]
        of_loop: list[NurbsCurve] = []
        for trim in trims:
            theirs = rhino3dm.CommonObject.Decode(decodable(data.plane_curves[trim.curve], encoded))
            curve = _curve(theirs.ToNurbsCurve(), trim.domain)
            of_loop.append(curve.reversed() if trim.is_curve_reversed else curve)
        curves.append(of_loop)
        edges.append([None if trim.edge < 0 else numbered[trim.edge] for trim in trims])
    return curves, edges


def _curve(theirs: Any, domain: tuple[float, float]) -> NurbsCurve:
    points = np.array([(p.X, p.Y, p.W) for p in theirs.Points])
    weights = points[:, 2] if theirs.IsRational else None
    places = points[:, :2] / points[:, 2:] if theirs.IsRational else points[:, :2]
    knots = [theirs.Knots[k] for k in range(len(theirs.Knots))]
    knots = [knots[0], *knots, knots[-1]]
    curve = loop_curves.curve_in_plane(places, weights, theirs.Order - 1, knots)
    first, last = curve.domain
    low, high = max(first, domain[0]), min(last, domain[1])
    return curve if (low, high) == (first, last) else curve.sub_curve(low, high)


def _parameters(own: Any, surface: NurbsSurface) -> Callable[[NurbsCurve], NurbsCurve]:
    """Return the map of curves from the parameters of a surface to those of its NURBS form."""

    def to_spline(places: Floats) -> Floats:
        found = [own.GetNurbsFormParameterFromSurfaceParameter(u, v) for u, v in places.tolist()]
        return np.array([(u, v) for _, u, v in found])

    (u0, u1), (v0, v1) = ((d.T0, d.T1) for d in (own.Domain(0), own.Domain(1)))
    places = np.array(
        [(u, v) for u in np.linspace(u0, u1, _SAMPLES) for v in np.linspace(v0, v1, _SAMPLES)]
    )
    mapped = to_spline(places)
    points = [own.PointAt(u, v) for u, v in places.tolist()]
    expected = np.array([(p.X, p.Y, p.Z) for p in points])
    size = float(abs(expected).max())
    if abs(surface.evaluate(mapped) - expected).max() > _ACCURACY * size:
        raise NeurbsError("the NURBS form of its surface must have known parameters")
    (a0, a1), (b0, b1) = surface.domain
    extent = np.array([a1 - a0, b1 - b0])
    if abs(mapped - places).max() <= _ACCURACY * extent.max():
        return lambda curve: curve
    knots = [np.unique(knots)[1:-1] for knots in surface.knots]
    middle = (0.5 * (a0 + a1), 0.5 * (b0 + b1))
    back = own.GetSurfaceParameterFromNurbsFormParameter
    breaks = (
        np.array([back(u, middle[1])[1] for u in knots[0].tolist()]),
        np.array([back(middle[0], v)[2] for v in knots[1].tolist()]),
    )
    return lambda curve: loop_curves.mapped(curve, to_spline, breaks, extent)


def nurbs_surface(theirs: Any) -> NurbsSurface:
    """Convert a NURBS surface."""
    rows, cols = theirs.Points.CountU, theirs.Points.CountV
    net = np.empty((rows, cols, 4))
    for i in range(rows):
        for j in range(cols):
            point = theirs.Points[i, j]
            net[i, j] = point.X, point.Y, point.Z, point.W
    u, v = ([knots[i] for i in range(len(knots))] for knots in (theirs.KnotsU, theirs.KnotsV))
    weights = net[..., 3] if theirs.IsRational else None
    points = net[..., :3] / net[..., 3:] if theirs.IsRational else net[..., :3]
    degree = (theirs.OrderU - 1, theirs.OrderV - 1)
    return NurbsSurface(points, weights, degree, ([u[0], *u, u[-1]], [v[0], *v, v[-1]]))
