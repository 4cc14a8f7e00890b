"""Surfaces from and to other NURBS libraries, which are imported when they are used."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NurbsSurface

__all__ = [
    "from_geomdl",
    "from_opencascade",
    "from_splipy",
    "to_geomdl",
    "to_opencascade",
    "to_splipy",
]


def to_geomdl(surface: NurbsSurface) -> Any:
    """Make a geomdl surface.

    Parameters
    ----------
    surface : NurbsSurface
        Any surface. Its parameters and knots stay as they are.

    Returns
    -------
    geomdl.NURBS.Surface or geomdl.BSpline.Surface
        `NURBS.Surface` if the surface is rational.

    Raises
    ------
    ImportError
        If geomdl is not installed.

    Examples
    --------
    >>> import neurbs
    >>> sphere = neurbs.NurbsSurface.sphere([0, 0, 0], 1)
    >>> other = neurbs.to_geomdl(sphere)  # doctest: +SKIP
    >>> neurbs.from_geomdl(other) == sphere  # doctest: +SKIP
    True
    """
    from geomdl import NURBS, BSpline

    rational = surface.weights is not None
    kind = NURBS.Surface if rational else BSpline.Surface
    other = kind(normalize_kv=False)
    other.degree_u, other.degree_v = surface.degree
    net = _net(surface)
    other.set_ctrlpts(net.reshape(-1, net.shape[2]).tolist(), *net.shape[:2])
    other.knotvector_u, other.knotvector_v = (knots.tolist() for knots in surface.knots)
    return other


def from_geomdl(surface: Any) -> NurbsSurface:
    """Convert a geomdl surface.

    Parameters
    ----------
    surface : geomdl.NURBS.Surface or geomdl.BSpline.Surface
        Any surface in space, or in the plane z = 0.

    Returns
    -------
    NurbsSurface
        With the same net, weights and knots.

    Raises
    ------
    NeurbsError
        If net, weights and knots do not fit together.

    Examples
    --------
    >>> import neurbs
    >>> from geomdl import BSpline  # doctest: +SKIP
    >>> surface = BSpline.Surface(degree_u=1, degree_v=1)  # doctest: +SKIP
    >>> surface.set_ctrlpts([[0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 1]], 2, 2)  # doctest: +SKIP
    >>> surface.knotvector_u = surface.knotvector_v = [0, 0, 1, 1]  # doctest: +SKIP
    >>> neurbs.from_geomdl(surface)  # doctest: +SKIP
    NurbsSurface(net 2 × 2, degree (1, 1), domain [0, 1] × [0, 1], polynomial, open)
    """
    shape = (surface.ctrlpts_size_u, surface.ctrlpts_size_v)
    net = _in_space(np.asarray(surface.ctrlpts, float).reshape(*shape, -1))
    weights = np.asarray(surface.weights, float).reshape(shape) if surface.rational else None
    knots = (surface.knotvector_u, surface.knotvector_v)
    return NurbsSurface(net, weights, (surface.degree_u, surface.degree_v), knots)


def to_splipy(surface: NurbsSurface) -> Any:
    """Make a Splipy surface.

    Parameters
    ----------
    surface : NurbsSurface
        Any surface. Its parameters stay as they are; its knots become clamped.

    Returns
    -------
    splipy.Surface

    Raises
    ------
    ImportError
        If Splipy is not installed.

    Examples
    --------
    >>> import neurbs
    >>> sphere = neurbs.NurbsSurface.sphere([0, 0, 0], 1)
    >>> other = neurbs.to_splipy(sphere)  # doctest: +SKIP
    >>> neurbs.from_splipy(other).degree  # doctest: +SKIP
    (2, 2)
    """
    import splipy

    surface = surface.clamped()
    bases = [
        splipy.BSplineBasis(degree + 1, knots)
        for degree, knots in zip(surface.degree, surface.knots, strict=True)
    ]
    rational = surface.weights is not None
    return splipy.Surface(*bases, np.array(_net(surface)), rational=rational, raw=True)


def from_splipy(surface: Any) -> NurbsSurface:
    """Convert a Splipy surface.

    Parameters
    ----------
    surface : splipy.Surface
        Any surface in space, or in the plane z = 0, periodic or not.

    Returns
    -------
    NurbsSurface
        With the same knots; the net of a periodic surface repeats its first rows.

    Raises
    ------
    NeurbsError
        If net, weights and knots do not fit together.

    Examples
    --------
    >>> import neurbs
    >>> from splipy import surface_factory  # doctest: +SKIP
    >>> neurbs.from_splipy(surface_factory.torus()).closed  # doctest: +SKIP
    (True, True)
    """
    net = np.asarray(surface.controlpoints, float)
    for axis, basis in enumerate(surface.bases):
        # Splipy omits the repeated rows: the number of continuous derivatives plus one.
        first = net.take(range(basis.periodic + 1), axis)
        net = np.concatenate([net, first], axis)
    weights = net[..., -1] if surface.rational else None
    points = net[..., :-1] / net[..., -1:] if surface.rational else net
    degree = tuple(basis.order - 1 for basis in surface.bases)
    knots = tuple(basis.knots for basis in surface.bases)
    return NurbsSurface(_in_space(points), weights, (degree[0], degree[1]), (knots[0], knots[1]))


def to_opencascade(surface: NurbsSurface) -> Any:
    """Make an OpenCASCADE surface of the package OCP, version 8.

    Parameters
    ----------
    surface : NurbsSurface
        Any surface. Its parameters stay as they are; its knots become clamped.

    Returns
    -------
    OCP.Geom.Geom_BSplineSurface

    Raises
    ------
    ImportError
        If OCP is not installed.

    Examples
    --------
    >>> import neurbs
    >>> sphere = neurbs.NurbsSurface.sphere([0, 0, 0], 1)
    >>> other = neurbs.to_opencascade(sphere)  # doctest: +SKIP
    >>> other.Value(0.0, 1.0).Coord()  # doctest: +SKIP
    (0.0, 0.0, 1.0)
    """
    from OCP.collections import Array2_double, Array2_gp_Pnt
    from OCP.Geom import Geom_BSplineSurface
    from OCP.gp import gp_Pnt

    surface = surface.clamped()
    rows, cols = surface.control_points.shape[:2]
    poles, weights = Array2_gp_Pnt(1, rows, 1, cols), Array2_double(1, rows, 1, cols)
    for i in range(rows):
        for j in range(cols):
            poles.SetValue(i + 1, j + 1, gp_Pnt(*surface.control_points[i, j].tolist()))
            weight = 1.0 if surface.weights is None else float(surface.weights[i, j])
            weights.SetValue(i + 1, j + 1, weight)
    (knots_u, times_u), (knots_v, times_v) = map(_opencascade_knots, surface.knots)
    knots = (knots_u, knots_v, times_u, times_v)
    return Geom_BSplineSurface(poles, weights, *knots, *surface.degree, False, False)


def from_opencascade(surface: Any) -> NurbsSurface:
    """Convert an OpenCASCADE surface of the package OCP, version 8.

    Parameters
    ----------
    surface : OCP.Geom.Geom_BSplineSurface
        Any B-spline surface; a periodic one becomes clamped.

    Returns
    -------
    NurbsSurface

    Raises
    ------
    NeurbsError
        If its degree is above 25.

    Examples
    --------
    >>> import neurbs
    >>> sphere = neurbs.NurbsSurface.sphere([0, 0, 0], 1)
    >>> other = neurbs.to_opencascade(sphere)  # doctest: +SKIP
    >>> neurbs.from_opencascade(other).closed  # doctest: +SKIP
    (True, False)
    """
    is_periodic = surface.IsUPeriodic() or surface.IsVPeriodic()
    if is_periodic:
        surface = surface.Copy()
        surface.SetUNotPeriodic()
        surface.SetVNotPeriodic()
    rows, cols = surface.NbUPoles(), surface.NbVPoles()
    net, weights = np.empty((rows, cols, 3)), np.empty((rows, cols))
    for i in range(rows):
        for j in range(cols):
            net[i, j] = surface.Pole(i + 1, j + 1).Coord()
            weights[i, j] = surface.Weight(i + 1, j + 1)
    u = [surface.UKnot(k + 1) for k in range(surface.NbUKnots())]
    v = [surface.VKnot(k + 1) for k in range(surface.NbVKnots())]
    times_u = [surface.UMultiplicity(k + 1) for k in range(len(u))]
    times_v = [surface.VMultiplicity(k + 1) for k in range(len(v))]
    rational = surface.IsURational() or surface.IsVRational()
    knots = (np.repeat(u, times_u), np.repeat(v, times_v))
    degree = (surface.UDegree(), surface.VDegree())
    ours = NurbsSurface(net, weights if rational else None, degree, knots)
    # OpenCASCADE leaves the knots of degree 1 unclamped.
    return clamped(ours) if is_periodic else ours


def clamped(surface: NurbsSurface) -> NurbsSurface:
    """Return the surface with clamped knots; one that has them keeps all digits."""
    directions = zip(surface.knots, surface.degree, strict=True)
    if all(u[0] == u[degree] and u[-1] == u[-degree - 1] for u, degree in directions):
        return surface
    return surface.clamped()


def _opencascade_knots(knots: NDArray[np.float64]) -> tuple[Any, Any]:
    """Return the distinct knots and their multiplicities."""
    from OCP.collections import Array1_double, Array1_int

    distinct, counts = np.unique(knots, return_counts=True)
    places, repeats = Array1_double(1, len(distinct)), Array1_int(1, len(distinct))
    for k, (value, count) in enumerate(zip(distinct.tolist(), counts.tolist(), strict=True)):
        places.SetValue(k + 1, value)
        repeats.SetValue(k + 1, count)
    return places, repeats


def _net(surface: NurbsSurface) -> NDArray[np.float64]:
    """Return the control points, for a rational surface as (w x, w y, w z, w)."""
    if surface.weights is None:
        return surface.control_points
    weights = surface.weights[..., None]
    return np.concatenate([surface.control_points * weights, weights], axis=-1)


def _in_space(net: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return control points in space; points in the plane get z = 0."""
    missing = 3 - net.shape[-1]
    return np.pad(net, [(0, 0), (0, 0), (0, missing)]) if missing > 0 else net
