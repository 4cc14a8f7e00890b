"""Faces of OpenCASCADE as surfaces with loops."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError, NurbsCurve, NurbsSurface
from neurbs.interop import from_opencascade
from neurbs.io import loop_curves
from neurbs.io.face_file import Edges, FaceData, Loops

_ACCURACY = 1e-9
"""Distance of the B-spline surface from the face's own, as a share of its size."""

_SAMPLES = 6
"""Places in each direction at which the two surfaces are compared."""

_ENDS = 2.0
"""Ends of curves meet within this multiple of their vertex's tolerance: one for each end."""

Floats = NDArray[np.float64]


def face_data(
    face: Any,
    number: int,
    edge_number: Callable[[Any], int],
    name: str | None,
    color: tuple[float, float, float] | None,
) -> FaceData:
    """Convert a face; coordinates are OpenCASCADE's.

    Raises
    ------
    NeurbsError
        If the surface cannot be converted: its degree may be too high.
    """
    from OCP.TopAbs import TopAbs_FORWARD, TopAbs_REVERSED
    from OCP.TopoDS import TopoDS

    is_reversed = face.Orientation() == TopAbs_REVERSED
    forward = TopoDS.Face(face.Oriented(TopAbs_FORWARD))
    surface, to_spline, forward = _spline_surface(forward)
    about: dict[str, Any] = {"is_reversed": is_reversed, "name": name, "color": color}
    try:
        loops, edges = _loops(forward, surface, to_spline, edge_number)
    except NeurbsError as error:
        return FaceData(number, surface, is_trimmed=True, defect=str(error), **about)
    if not loops:
        return FaceData(number, surface, **about)
    whole = loop_curves.whole_or_trimmed(surface, loops, edges)
    return FaceData(number, surface, *whole, **about)


class _Axis:
    """How a parameter of a face's surface becomes that of the B-spline surface.

    OpenCASCADE's B-splines of circles have the knots of equal angles, with the parameter
    proportional to the tangent of half the angle in between.
    """

    def __init__(self, knots: Floats, start: float, is_angle: bool) -> None:
        self._knots = knots
        self._start = start
        self._is_angle = is_angle

    def breaks(self) -> Floats:
        inner = self._knots[1:-1] - self._knots[0] + self._start
        return np.asarray(inner if self._is_angle else inner[:0])

    def __call__(self, values: Floats) -> Floats:
        moved = np.asarray(values) - self._start + self._knots[0]
        if not self._is_angle:
            return np.asarray(moved)
        spans = np.searchsorted(self._knots, moved, side="right") - 1
        spans = np.clip(spans, 0, len(self._knots) - 2)
        low, high = self._knots[spans], self._knots[spans + 1]
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        tangent = np.tan(0.5 * (moved - middle)) / np.tan(0.5 * half)
        return np.asarray(middle + half * tangent)


class _Parameters:
    """The map from the parameters of a face's surface to those of its B-spline surface."""

    def __init__(self, surface: NurbsSurface, start: tuple[float, float], angles: Any) -> None:
        knots = [np.unique(knots) for knots in surface.knots]
        pairs = zip(knots, start, angles, strict=True)
        self._axes = [_Axis(*of_axis) for of_axis in pairs]
        self._size = np.array([of_axis[-1] - of_axis[0] for of_axis in knots])
        self._are_angles = any(angles)

    def __call__(self, places: Floats) -> Floats:
        places = np.asarray(places, float)
        return np.column_stack([axis(places[:, k]) for k, axis in enumerate(self._axes)])

    def curve(self, curve: NurbsCurve) -> NurbsCurve:
        """Return a curve in the parameters of the B-spline surface."""
        if self._are_angles:
            breaks = (self._axes[0].breaks(), self._axes[1].breaks())
            return loop_curves.mapped(curve, self, breaks, self._size)
        places = self(curve.control_points[:, :2])
        return loop_curves.curve_in_plane(places, curve.weights, curve.degree, curve.knots)


def _spline_surface(face: Any) -> tuple[NurbsSurface, _Parameters, Any]:
    """Return the B-spline surface of a face, the map to its parameters, and the face for loops."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepTools import BRepTools
    from OCP.Geom import Geom_BSplineSurface, Geom_RectangularTrimmedSurface
    from OCP.GeomConvert import GeomConvert

    own = BRep_Tool.Surface_s(face)
    is_spline = isinstance(own, Geom_BSplineSurface)
    if is_spline and not (own.IsUPeriodic() or own.IsVPeriodic()):
        surface = from_opencascade(own)
        return surface, _identity(surface), face
    low_u, high_u, low_v, high_v = BRepTools.UVBounds_s(face)
    first_u, last_u, first_v, last_v = own.Bounds()
    start_u, start_v = _lowest_ends(face)
    u0, u1 = _range((low_u, high_u), (first_u, last_u), own.IsUPeriodic(), start_u)
    v0, v1 = _range((low_v, high_v), (first_v, last_v), own.IsVPeriodic(), start_v)
    if u1 > u0 and v1 > v0:
        part = Geom_RectangularTrimmedSurface(own, u0, u1, v0, v1)
        surface = from_opencascade(GeomConvert.SurfaceToBSplineSurface_s(part))
        places = np.array(
            [(u, v) for u in np.linspace(u0, u1, _SAMPLES) for v in np.linspace(v0, v1, _SAMPLES)]
        )
        points = np.array([own.Value(*place).Coord() for place in places.tolist()])
        for angles in ((False, False), (True, False), (True, True), (False, True)):
            to_spline = _Parameters(surface, (u0, v0), angles)
            if _agree(surface, to_spline(places), points):
                return surface, to_spline, face
    return _converted(face)


def _range(
    wanted: tuple[float, float], there: tuple[float, float], is_periodic: bool, start: float
) -> tuple[float, float]:
    """Return the range of a parameter that a face needs, inside the range of its surface.

    Rounded numbers of a file exceed it by little, and OpenCASCADE refuses them. A whole turn begins
    at `start`, the lowest end of an edge: OpenCASCADE's own bounds are wider than the edges.
    """
    least = _ACCURACY * (wanted[1] - wanted[0])
    snapped = [next((end for end in there if abs(value - end) <= least), value) for value in wanted]
    low, high = snapped
    if not is_periodic:
        return max(low, there[0]), min(high, there[1])
    period = there[1] - there[0]
    if high - low >= period - least:
        low = max(low, start) if np.isfinite(start) else low
        high = low + period
        while high - low > period:
            high = float(np.nextafter(high, low))
    return low, high


def _lowest_ends(face: Any) -> tuple[float, float]:
    """Return the lowest parameters at which edges of a face end; infinite without edges."""
    from OCP.BRep import BRep_Tool
    from OCP.TopAbs import TopAbs_EDGE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    lowest = np.full(2, np.inf)
    explorer = TopExp_Explorer(face, TopAbs_EDGE)
    while explorer.More():
        edge = TopoDS.Edge(explorer.Current())
        curve = BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 0.0)
        if curve is not None:
            ends = [curve.Value(end).Coord() for end in BRep_Tool.Range_s(edge, face)]
            lowest = np.minimum(lowest, np.min(ends, axis=0))
        explorer.Next()
    return float(lowest[0]), float(lowest[1])


def _agree(surface: NurbsSurface, places: Floats, points: Floats) -> bool:
    (u0, u1), (v0, v1) = surface.domain
    there = surface.evaluate(np.clip(places, [u0, v0], [u1, v1]))
    size = float(abs(points).max()) + float(np.ptp(points, axis=0).max())
    return bool(abs(there - points).max() <= _ACCURACY * size)


def _identity(surface: NurbsSurface) -> _Parameters:
    (u0, _), (v0, _) = surface.domain
    return _Parameters(surface, (u0, v0), (False, False))


def _converted(face: Any) -> tuple[NurbsSurface, _Parameters, Any]:
    """Convert a face by OpenCASCADE, which takes seconds for some."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert
    from OCP.TopAbs import TopAbs_FACE, TopAbs_FORWARD
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    shape = BRepBuilderAPI_NurbsConvert(face).Shape()
    face = TopoDS.Face(TopExp_Explorer(shape, TopAbs_FACE).Current().Oriented(TopAbs_FORWARD))
    surface = from_opencascade(BRep_Tool.Surface_s(face))
    return surface, _identity(surface), face


def _loops(
    face: Any, surface: NurbsSurface, to_spline: _Parameters, edge_number: Callable[[Any], int]
) -> tuple[Loops, Edges]:
    """Return the loops of a face, the outer one first; none for a surface without borders."""
    from OCP.BRepTools import BRepTools
    from OCP.TopAbs import TopAbs_WIRE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    outer = BRepTools.OuterWire_s(face)
    wires = [] if outer.IsNull() else [outer]
    explorer = TopExp_Explorer(face, TopAbs_WIRE)
    while explorer.More():
        if not explorer.Current().IsSame(outer):
            wires.append(TopoDS.Wire(explorer.Current()))
        explorer.Next()
    loops: Loops = []
    all_edges: Edges = []
    for wire in wires:
        curves, edges, tolerance = _loop(face, wire, to_spline, edge_number)
        loops.append(loop_curves.closed(curves, surface, tolerance))
        all_edges.append(edges)
    if loops:
        loop_curves.check_loops_there(loops)
    return loops, all_edges


def _loop(
    face: Any, wire: Any, to_spline: _Parameters, edge_number: Callable[[Any], int]
) -> tuple[list[NurbsCurve], list[int | None], float]:
    """Return the curves of a wire, their edges, and the distance within which ends meet."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepTools import BRepTools_WireExplorer
    from OCP.TopAbs import TopAbs_EDGE, TopAbs_REVERSED
    from OCP.TopExp import TopExp, TopExp_Explorer

    curves: list[NurbsCurve] = []
    edges: list[int | None] = []
    tolerance = 0.0
    explorer = BRepTools_WireExplorer(wire, face)
    while explorer.More():
        edge = explorer.Current()
        curve = to_spline.curve(_curve_in_plane(edge, face))
        curves.append(curve.reversed() if edge.Orientation() == TopAbs_REVERSED else curve)
        edges.append(None if BRep_Tool.Degenerated_s(edge) else edge_number(edge))
        for vertex in (TopExp.FirstVertex_s(edge), TopExp.LastVertex_s(edge)):
            if not vertex.IsNull():
                tolerance = max(tolerance, _ENDS * BRep_Tool.Tolerance_s(vertex))
        explorer.Next()
    count, there = 0, TopExp_Explorer(wire, TopAbs_EDGE)
    while there.More():
        count += 1
        there.Next()
    if count != len(curves):
        raise NeurbsError(f"a loop must be a chain of its {count} edges, but {len(curves)} follow")
    return curves, edges, tolerance


def _curve_in_plane(edge: Any, face: Any) -> NurbsCurve:
    """Return the curve of an edge in the parameters of the face's surface."""
    from OCP.BRep import BRep_Tool
    from OCP.Geom2d import Geom2d_TrimmedCurve
    from OCP.Geom2dConvert import Geom2dConvert

    own = BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 0.0)
    if own is None:
        raise NeurbsError("each edge of a face must have a curve in (u, v), but one has none")
    first, last = BRep_Tool.Range_s(edge, face)
    spline = Geom2dConvert.CurveToBSplineCurve_s(Geom2d_TrimmedCurve(own, first, last))
    if spline.IsPeriodic():
        spline.SetNotPeriodic()
    count = spline.NbPoles()
    points = [spline.Pole(k + 1).Coord() for k in range(count)]
    weights = [spline.Weight(k + 1) for k in range(count)] if spline.IsRational() else None
    knots = [spline.Knot(k + 1) for k in range(spline.NbKnots())]
    times = [spline.Multiplicity(k + 1) for k in range(len(knots))]
    return loop_curves.curve_in_plane(points, weights, spline.Degree(), np.repeat(knots, times))
