"""Surfaces from and to other NURBS libraries, which are imported only when asked for."""

from typing import Any

import numpy as np

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
        Any surface. Its parameters stay as they are.

    Returns
    -------
    geomdl.NURBS.Surface or geomdl.BSpline.Surface
        The former if the surface is rational.
    """
    from geomdl import NURBS, BSpline

    rational = surface.weights is not None
    kind = NURBS.Surface if rational else BSpline.Surface
    other = kind(normalize_kv=False)
    other.degree_u, other.degree_v = surface.degree
    net = _homogeneous(surface) if rational else surface.control_points
    other.set_ctrlpts(net.reshape(-1, net.shape[2]).tolist(), *net.shape[:2])
    other.knotvector_u, other.knotvector_v = (knots.tolist() for knots in surface.knots)
    return other


def from_geomdl(surface: Any) -> NurbsSurface:
    """Take a geomdl surface.

    Parameters
    ----------
    surface : geomdl.NURBS.Surface or geomdl.BSpline.Surface
        Any surface in space.

    Returns
    -------
    NurbsSurface

    Raises
    ------
    NeurbsError
        If net, weights and knots do not belong together.
    """
    shape = (surface.ctrlpts_size_u, surface.ctrlpts_size_v)
    net = np.asarray(surface.ctrlpts, float).reshape(*shape, -1)
    weights = np.asarray(surface.weights, float).reshape(shape) if surface.rational else None
    knots = (surface.knotvector_u, surface.knotvector_v)
    return NurbsSurface(net, weights, (surface.degree_u, surface.degree_v), knots)


def to_splipy(surface: NurbsSurface) -> Any:
    """Make a Splipy surface.

    Parameters
    ----------
    surface : NurbsSurface
        Any surface. Its parameters stay as they are.

    Returns
    -------
    splipy.Surface
    """
    import splipy

    surface = surface.clamped()
    bases = [
        splipy.BSplineBasis(degree + 1, knots)
        for degree, knots in zip(surface.degree, surface.knots, strict=True)
    ]
    rational = surface.weights is not None
    net = _homogeneous(surface) if rational else surface.control_points
    return splipy.Surface(*bases, np.array(net), rational=rational, raw=True)


def from_splipy(surface: Any) -> NurbsSurface:
    """Take a Splipy surface.

    Parameters
    ----------
    surface : splipy.Surface
        Any surface in space that is not periodic; split a periodic one at its seam first.

    Returns
    -------
    NurbsSurface

    Raises
    ------
    NeurbsError
        If net, weights and knots do not belong together, as in a periodic surface.
    """
    net = np.asarray(surface.controlpoints, float)
    weights = net[..., 3] if surface.rational else None
    points = net[..., :3] / net[..., 3:] if surface.rational else net
    degree = tuple(basis.order - 1 for basis in surface.bases)
    knots = tuple(basis.knots for basis in surface.bases)
    return NurbsSurface(points, weights, (degree[0], degree[1]), (knots[0], knots[1]))


def to_opencascade(surface: NurbsSurface) -> Any:
    """Make an OpenCASCADE surface (of the package OCP, version 8).

    Parameters
    ----------
    surface : NurbsSurface
        Any surface. Its parameters stay as they are; its knots become clamped.

    Returns
    -------
    OCP.Geom.Geom_BSplineSurface
    """
    from OCP.collections import Array1_double, Array1_int, Array2_double, Array2_gp_Pnt
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
    values, times = [], []
    for knots in surface.knots:
        distinct, counts = np.unique(knots, return_counts=True)
        places, repeats = Array1_double(1, len(distinct)), Array1_int(1, len(distinct))
        for k, (value, count) in enumerate(zip(distinct.tolist(), counts.tolist(), strict=True)):
            places.SetValue(k + 1, value)
            repeats.SetValue(k + 1, count)
        values.append(places)
        times.append(repeats)
    return Geom_BSplineSurface(poles, weights, *values, *times, *surface.degree, False, False)


def from_opencascade(surface: Any) -> NurbsSurface:
    """Take an OpenCASCADE surface (of the package OCP, version 8).

    Parameters
    ----------
    surface : OCP.Geom.Geom_BSplineSurface
        Any B-spline surface; a periodic one becomes clamped.

    Returns
    -------
    NurbsSurface
    """
    if surface.IsUPeriodic() or surface.IsVPeriodic():
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
    return NurbsSurface(net, weights if rational else None, degree, knots)


def _homogeneous(surface: NurbsSurface) -> Any:
    """(w x, w y, w z, w) of each control point of a rational surface."""
    weights = np.asarray(surface.weights)[..., None]
    return np.concatenate([surface.control_points * weights, weights], axis=-1)
