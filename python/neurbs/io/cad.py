"""Surfaces in STEP and IGES files, read by OpenCASCADE."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from neurbs._core import LENGTH_UNITS, NeurbsError, NurbsSurface
from neurbs.interop import from_opencascade
from neurbs.io.extras import imported
from neurbs.io.surface_file import SurfaceFile
from neurbs.io.units import symbol

_TRIMMED = 1e-6
"""Share of its surface's area that a face must lack to count as trimmed."""

_IGES_UNITS = {1: "in", 2: "mm", 4: "ft", 6: "m", 10: "cm"}
"""The standard's numbers of the units."""


def read_cad(path: Path) -> SurfaceFile:
    """Read the surface of each face, in the file's unit."""
    imported(path, "OCP")
    is_step = path.suffix.lower() in (".step", ".stp")
    reader, unit = _step(path) if is_step else _iges(path)
    reader.TransferRoots()
    surfaces, trimmed = [], 0
    for surface, is_trimmed in _faces(reader.OneShape()):
        surfaces.append(surface)
        trimmed += is_trimmed
    # OpenCASCADE has turned all into millimetres.
    factor = 1 / LENGTH_UNITS[unit] if unit in LENGTH_UNITS else 1.0
    if factor != 1:
        scale = np.diag([factor, factor, factor, 1.0])
        surfaces = [surface.transformed(scale) for surface in surfaces]
    return SurfaceFile(surfaces, trimmed, unit if unit in LENGTH_UNITS else "mm")


def _step(path: Path) -> tuple[Any, str]:
    from OCP.collections import Sequence_AsciiString
    from OCP.STEPControl import STEPControl_Reader

    reader = _read(path, STEPControl_Reader())
    lengths, angles, solid_angles = (Sequence_AsciiString() for _ in range(3))
    reader.FileUnits(lengths, angles, solid_angles)
    return reader, symbol(lengths.Value(1).ToCString()) if lengths.Size() else "mm"


def _iges(path: Path) -> tuple[Any, str]:
    from OCP.IGESControl import IGESControl_Reader

    reader = _read(path, IGESControl_Reader())
    flag = reader.IGESModel().GlobalSection().UnitFlag()
    return reader, _IGES_UNITS.get(flag, "mm")


def _read(path: Path, reader: Any) -> Any:
    from OCP.IFSelect import IFSelect_ReturnStatus

    if reader.ReadFile(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise NeurbsError(
            f"{path}: must be a whole {path.suffix.lower()} file, but is damaged or cut short"
        )
    return reader


def _faces(shape: Any) -> Iterator[tuple[NurbsSurface, bool]]:
    """Give the B-spline surface of each face, and whether the face is smaller than it."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_NurbsConvert
    from OCP.BRepGProp import BRepGProp
    from OCP.Geom import Geom_BSplineSurface
    from OCP.GProp import GProp_GProps
    from OCP.TopAbs import TopAbs_FACE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    def area(face: Any) -> float:
        properties = GProp_GProps()
        BRepGProp.SurfaceProperties_s(face, properties)
        return abs(float(properties.Mass()))

    # Planes, cylinders and the like become B-splines, too.
    faces = TopExp_Explorer(BRepBuilderAPI_NurbsConvert(shape).Shape(), TopAbs_FACE)
    while faces.More():
        face = TopoDS.Face(faces.Current())
        surface = Geom_BSplineSurface.DownCast_s(BRep_Tool.Surface_s(face))
        whole = BRepBuilderAPI_MakeFace(surface, 0.0).Face()
        yield from_opencascade(surface), area(face) < (1 - _TRIMMED) * area(whole)
        faces.Next()
