"""Surfaces in STEP and IGES files, read by OpenCASCADE."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from neurbs._core import LENGTH_UNITS, NeurbsError, NurbsSurface
from neurbs.extras import require_for_file
from neurbs.interop import from_opencascade
from neurbs.io.surface_file import SurfaceFile
from neurbs.io.units import symbol

_TRIMMED = 1e-5
"""A face is trimmed if an edge is at least this share of the domain within its surface.

In space, the edge must also be farther from the border than its own tolerance.
"""

_SAMPLES = 9
"""Points of an edge that are compared with the border."""

_STEP = (".step", ".stp")

_SECTION = 72
"""Column, from 0, of the letter of the section in a line of an IGES file."""

_IGES_UNITS = {1: "in", 2: "mm", 4: "ft", 6: "m", 10: "cm"}
"""The unit flags of the IGES standard."""


def read_cad(path: Path) -> SurfaceFile:
    """Read the surface of each face in the unit of the file."""
    require_for_file(path, "OCP")
    with _quiet():
        reader, unit = (_step if path.suffix.lower() in _STEP else _iges)(path)
        reader.TransferRoots()
        shape = reader.OneShape()
        faces = [] if shape.IsNull() else list(_faces(shape))
    # OpenCASCADE converts coordinates to millimeters.
    factor = 1 / LENGTH_UNITS[unit]
    scale = np.diag([factor, factor, factor, 1.0])
    surfaces = [s if factor == 1 else s.transformed(scale) for s, _ in faces]
    return SurfaceFile(surfaces, sum(is_trimmed for _, is_trimmed in faces), unit)


def _step(path: Path) -> tuple[Any, str]:
    from OCP.collections import Sequence_TCollection_AsciiString
    from OCP.STEPControl import STEPControl_Reader

    reader = _read(path, STEPControl_Reader())
    lengths, angles, solid_angles = (Sequence_TCollection_AsciiString() for _ in range(3))
    reader.FileUnits(lengths, angles, solid_angles)
    unit = symbol(lengths.Value(1).ToCString()) if lengths.Size() else "mm"
    # For an unknown unit the coordinates stay in millimeters.
    return reader, unit if unit in LENGTH_UNITS else "mm"


def _iges(path: Path) -> tuple[Any, str]:
    from OCP.IGESControl import IGESControl_Reader

    _check_iges(path)
    reader = _read(path, IGESControl_Reader())
    return reader, _IGES_UNITS.get(reader.IGESModel().GlobalSection().UnitFlag(), "mm")


def _check_iges(path: Path) -> None:
    """Compare a file with its last line, which has the number of lines of each section.

    OpenCASCADE crashes on some files that are cut short.
    """
    with path.open(encoding="latin-1") as file:
        lines = [line[:80] for line in file if line.strip()]
    last = lines[-1] if lines else ""
    counts = Counter(line[_SECTION:][:1] for line in lines)
    expected = {
        letter: int(count) for letter, count in re.findall(r"([SGDP]) *(\d+)", last[:_SECTION])
    }
    if last[_SECTION:][:1] != "T" or any(
        counts[letter] != expected.get(letter) for letter in "SGDP"
    ):
        raise _damaged(path)


def _damaged(path: Path) -> NeurbsError:
    return NeurbsError(
        f"{path}: must be a complete {path.suffix.lower()} file, but is damaged or cut short"
    )


def _read(path: Path, reader: Any) -> Any:
    from OCP.IFSelect import IFSelect_ReturnStatus

    if reader.ReadFile(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise _damaged(path)
    return reader


@contextmanager
def _quiet() -> Iterator[None]:
    """Suppress the messages that OpenCASCADE prints."""
    from OCP.Message import Message

    messenger = Message.DefaultMessenger_s()
    printers = list(messenger.Printers())
    for printer in printers:
        messenger.RemovePrinter(printer)
    try:
        yield
    finally:
        for printer in printers:
            messenger.AddPrinter(printer)


def _faces(shape: Any) -> Iterator[tuple[NurbsSurface, bool]]:
    """Yield the B-spline surface of each face, and whether the face is trimmed."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert
    from OCP.Geom import Geom_BSplineSurface
    from OCP.TopAbs import TopAbs_FACE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    faces = TopExp_Explorer(shape, TopAbs_FACE)
    while faces.More():
        face = TopoDS.Face(faces.Current())
        surface = BRep_Tool.Surface_s(face)
        if not isinstance(surface, Geom_BSplineSurface):
            # A plane, a cylinder or another one. To convert a B-spline, too, takes many seconds
            # far from the origin.
            converted = BRepBuilderAPI_NurbsConvert(face).Shape()
            face = TopoDS.Face(TopExp_Explorer(converted, TopAbs_FACE).Current())
            surface = BRep_Tool.Surface_s(face)
        yield from_opencascade(surface), _is_trimmed(face, surface)
        faces.Next()


def _is_trimmed(face: Any, surface: Any) -> bool:
    """Whether an edge of a face is within its surface and is no seam, which may be anywhere.

    Areas are not compared: at kinks they are inexact.
    """
    from OCP.BRep import BRep_Tool
    from OCP.BRepAdaptor import BRepAdaptor_Curve2d
    from OCP.TopAbs import TopAbs_EDGE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    u1, u2, v1, v2 = surface.Bounds()
    low, high = np.array([u1, v1]), np.array([u2, v2])
    edges = TopExp_Explorer(face, TopAbs_EDGE)
    while edges.More():
        edge = TopoDS.Edge(edges.Current())
        curve = BRepAdaptor_Curve2d(edge, face)
        parameters = np.linspace(curve.FirstParameter(), curve.LastParameter(), _SAMPLES)
        places = [curve.Value(float(parameter)) for parameter in parameters]
        uv = np.array([(place.X(), place.Y()) for place in places])
        near = np.minimum(abs(uv - low), abs(uv - high)) < _TRIMMED * (high - low)
        inside = uv[~near.any(axis=1)].tolist()
        tolerance = BRep_Tool.Tolerance_s(edge)
        if not BRep_Tool.IsClosed_s(edge, face) and not all(
            _is_on_border(surface, u, v, tolerance) for u, v in inside
        ):
            return True
        edges.Next()
    return False


def _is_on_border(surface: Any, u: float, v: float, tolerance: float) -> bool:
    """Whether a place is within a distance of the border: near a pole parameters say little."""
    u1, u2, v1, v2 = surface.Bounds()
    place = surface.Value(u, v)
    border = ((u1, v), (u2, v), (u, v1), (u, v2))
    return any(place.Distance(surface.Value(*other)) <= tolerance for other in border)
