"""Curves in (u, v) that files store, made fit for the loops of a face."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError, NurbsCurve, NurbsSurface
from neurbs.io.face_file import Edges, Loops

_ACCURACY = 1e-9
"""Distance of a curve in other parameters from its true place, as a share of the rectangle."""

_ON_SIDE = 1e-5
"""Distance from a side within which a curve lies on it, as a share of the rectangle."""

_ROUNDING = 1e-7
"""Distance from a side that is no more than rounding in files, as a share of the rectangle."""

_FIRST, _MOST = 17, 2049
"""Points that a curve in other parameters is interpolated through: at first, and at most."""

_DEGREE = 5
"""Degree of a curve in other parameters."""

_SAMPLES = 65
"""Points of a curve among which crossings with a knot line are sought."""

_NARROWINGS = 9
"""Divisions of an interval by the number of samples, to the resolution of floating point."""

Floats = NDArray[np.float64]
Map = Callable[[Floats], Floats]
"""A map of points in (u, v), of shape (n, 2), that takes isocurves to isocurves."""


def curve_in_plane(
    points: Any, weights: Any | None, degree: int, knots: Sequence[float] | Floats
) -> NurbsCurve:
    """Make a curve in (u, v) with z = 0 and clamped knots."""
    points = np.asarray(points, float)
    flat = np.column_stack([points[:, :2], np.zeros(len(points))])
    return NurbsCurve(flat, weights, degree, knots).clamped()


def line(start: Any, end: Any, domain: tuple[float, float] = (0.0, 1.0)) -> NurbsCurve:
    """Make a line in (u, v)."""
    return NurbsCurve([[*start[:2], 0.0], [*end[:2], 0.0]], degree=1).with_domain(*domain)


def mapped(curve: NurbsCurve, to: Map, breaks: tuple[Floats, Floats], size: Floats) -> NurbsCurve:
    """Return a curve in other parameters of the same surface.

    Parameters
    ----------
    curve : NurbsCurve
        The curve in (u, v).
    to : callable
        The map from (u, v) to the other parameters.
    breaks : (ndarray, ndarray)
        The values of u and of v where the map is not smooth.
    size : ndarray of shape (2,)
        The size of the rectangle of the other parameters.
    """
    places = curve.control_points[:, :2]
    extent = np.ptp(places, axis=0)
    if (extent <= _ACCURACY * max(float(extent.max()), 1e-300)).any():
        start, end = to(places[[0, -1]])
        middle = to(places.mean(axis=0)[None])[0]
        fixed = int(np.argmin(extent))
        start[fixed] = end[fixed] = middle[fixed]
        return line(start, end, curve.domain)
    first, last = curve.domain
    cuts = [first, *_crossings(curve, breaks), last]
    pieces = [_interpolated(curve, to, a, b, size) for a, b in itertools.pairwise(cuts)]
    whole = pieces[0]
    for piece in pieces[1:]:
        whole = whole.joined(piece, tolerance=float(size.max()) * _ACCURACY)
    return whole


def _crossings(curve: NurbsCurve, breaks: tuple[Floats, Floats]) -> list[float]:
    """Return the inner parameters where a curve crosses the lines of the breaks."""
    first, last = curve.domain
    at = np.linspace(first, last, _SAMPLES)
    places = curve.evaluate(at)
    found: list[float] = []
    for axis in (0, 1):
        for value in breaks[axis]:
            above = places[:, axis] > value
            for k in np.flatnonzero(above[1:] != above[:-1]):
                found.append(_crossing(curve, axis, float(value), at[k : k + 2]))
    least = (last - first) * _ACCURACY
    kept: list[float] = []
    for place in sorted(found):
        if place - (kept[-1] if kept else first) > least and last - place > least:
            kept.append(place)
    return kept


def _crossing(curve: NurbsCurve, axis: int, value: float, bracket: Floats) -> float:
    """Return the parameter in a bracket where a coordinate has a value."""
    low, high = float(bracket[0]), float(bracket[1])
    for _ in range(_NARROWINGS):
        at = np.linspace(low, high, _SAMPLES)
        above = curve.evaluate(at)[:, axis] > value
        changes = np.flatnonzero(above[1:] != above[:-1])
        if not len(changes):
            break
        low, high = float(at[changes[0]]), float(at[changes[0] + 1])
    return 0.5 * (low + high)


def _interpolated(curve: NurbsCurve, to: Map, a: float, b: float, size: Floats) -> NurbsCurve:
    """Interpolate a smooth part of a curve, with more points until it is accurate."""
    count = _FIRST
    while True:
        at = np.linspace(a, b, 2 * count - 1)
        true = np.column_stack([to(curve.evaluate(at)[:, :2]), np.zeros(len(at))])
        made = NurbsCurve.interpolate(true[::2], _DEGREE, parametrization="uniform").with_domain(
            a, b
        )
        gap = abs(made.evaluate(at[1::2])[:, :2] - true[1::2, :2]) / size
        if gap.max() <= _ACCURACY or count >= _MOST:
            return made
        count = 2 * count - 1


def closed(curves: list[NurbsCurve], surface: NurbsSurface, tolerance: float) -> list[NurbsCurve]:
    """Return a loop whose curves meet exactly where they meet within a tolerance in space.

    Curves that lie on a side of the rectangle but for rounding lie on it exactly.
    """
    places = [curve.control_points[:, :2].copy() for curve in curves]
    (u0, u1), (v0, v1) = surface.domain
    low, high = np.array([u0, v0]), np.array([u1, v1])
    for k, points in enumerate(places):
        following = places[(k + 1) % len(places)]
        end, start = points[-1], following[0]
        if (end == start).all():
            continue
        ends = np.clip([end, start], low, high)
        distance = float(np.linalg.norm(np.subtract(*surface.evaluate(ends))))
        # Far away in (u, v) although near in space: a pole, whose curve is missing.
        near = abs(end - start) < 0.5 * (high - low)
        if distance <= tolerance and near.all():
            points[-1] = following[0] = np.clip(0.5 * (end + start), low, high)
    for points in places:
        for value in (low, high):
            on_side = (abs(points - value) <= _ROUNDING * (high - low)).all(axis=0)
            points[:, on_side] = value[on_side]
    for k, points in enumerate(places):
        # Next to a curve that was moved to its side.
        following = places[(k + 1) % len(places)]
        moved = abs(points[-1] - following[0]) <= 2 * _ROUNDING * (high - low)
        for value in (low, high):
            on_side = moved & ((points[-1] == value) | (following[0] == value))
            points[-1, on_side] = following[0, on_side] = value[on_side]
    return [
        curve
        if (points == curve.control_points[:, :2]).all()
        else curve_in_plane(points, curve.weights, curve.degree, curve.knots)
        for curve, points in zip(curves, places, strict=True)
    ]


def side(curve: NurbsCurve, surface: NurbsSurface) -> int | None:
    """Return the side of the rectangle on which a curve lies: 0 to 3 for v0, u1, v1, u0."""
    (u0, u1), (v0, v1) = surface.domain
    u, v = curve.control_points[:, 0], curve.control_points[:, 1]
    gaps = (
        abs(v - v0) / (v1 - v0),
        abs(u - u1) / (u1 - u0),
        abs(v - v1) / (v1 - v0),
        abs(u - u0) / (u1 - u0),
    )
    return next((k for k, gap in enumerate(gaps) if gap.max() <= _ON_SIDE), None)


def whole_or_trimmed(
    surface: NurbsSurface, loops: Loops, edges: Edges | None
) -> tuple[Loops | None, Edges | None, bool]:
    """Return loops, edges, and whether the face is trimmed.

    The loops are None if they are the four sides of the rectangle. Sides that consist of several
    edges stay curves of a loop, so that each keeps its edge.
    """
    sides = [side(curve, surface) for curve in loops[0]]
    if len(loops) > 1 or None in sides:
        return loops, edges, True
    if sorted(sides, key=lambda k: k or 0) != [0, 1, 2, 3]:
        return loops, edges, False
    return None, edges and [[edges[0][sides.index(k)] for k in range(4)]], False


def check_loops_there(loops: Loops) -> None:
    """Raise if there is no loop or one without curves."""
    if not loops or not all(loops):
        raise NeurbsError("a face must have loops of at least one curve each")
