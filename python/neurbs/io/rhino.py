"""Surfaces in Rhino files: `.3dm`, by rhino3dm."""

from __future__ import annotations

import errno
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from neurbs._core import NeurbsError, NurbsSurface
from neurbs.extras import require_for_file
from neurbs.io.surface_file import SurfaceFile

_UNITS = {
    "mm": "Millimeters",
    "cm": "Centimeters",
    "m": "Meters",
    "in": "Inches",
    "ft": "Feet",
}
"""Names of the units in Rhino."""

_VERSION = 7
"""Version of the written files, for Rhino 7 and later."""


def write_3dm(surface: NurbsSurface, path: str, unit: str | None = None) -> None:
    """Write a surface with all digits; its knots become clamped."""
    rhino3dm = require_for_file(Path(path), "rhino3dm")
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
    model = rhino3dm.File3dm()
    model.Settings.ModelUnitSystem = getattr(rhino3dm.UnitSystem, _UNITS[unit or "mm"])
    model.Objects.AddSurface(theirs)
    if not model.Write(path, _VERSION):
        raise OSError(errno.EIO, "Rhino's library cannot write this file", path)


def read_3dm(path: Path) -> SurfaceFile:
    """Read all surfaces, including those of the faces of solids."""
    rhino3dm = require_for_file(path, "rhino3dm")
    model = rhino3dm.File3dm.Read(str(path))
    if model is None:
        raise NeurbsError(f"{path}: must be a complete Rhino file, but is damaged or cut short")
    surfaces, trimmed = [], 0
    for surface, is_trimmed in _faces(rhino3dm, model):
        surfaces.append(_surface(path, surface))
        trimmed += is_trimmed
    name = model.Settings.ModelUnitSystem.name
    unit = next((symbol for symbol, theirs in _UNITS.items() if theirs == name), None)
    return SurfaceFile(surfaces, trimmed, unit)


def _faces(rhino3dm: Any, model: Any) -> Iterator[tuple[Any, bool]]:
    for item in model.Objects:
        geometry = item.Geometry
        if isinstance(geometry, rhino3dm.Extrusion):
            geometry = geometry.ToBrep(True)
        if isinstance(geometry, rhino3dm.Brep):
            for face in geometry.Faces:
                yield (
                    face.UnderlyingSurface().ToNurbsSurface(),
                    not face.DuplicateFace(False).IsSurface,
                )
        elif isinstance(geometry, rhino3dm.Surface):
            yield geometry.ToNurbsSurface(), False


def _surface(path: Path, theirs: Any) -> NurbsSurface:
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
    knots = ([u[0], *u, u[-1]], [v[0], *v, v[-1]])
    try:
        return NurbsSurface(points, weights, degree, knots)
    except NeurbsError as error:
        raise NeurbsError(f"{path}: {error}") from None
