"""Parts of a STEP or IGES file in their places, with names and colors."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

Color = tuple[float, float, float]

_DIGITS = 6
"""Decimals of a color: OpenCASCADE keeps colors in single precision."""


@dataclass(frozen=True)
class Part:
    """A shape at one of its places.

    Attributes
    ----------
    shape : TopoDS_Shape
        The shape itself.
    location : TopLoc_Location
        Its place.
    label : TDF_Label
        What the document knows of it.
    name : str, optional
        The name of the part.
    color : (float, float, float), optional
        The color of this instance.
    """

    shape: Any
    location: Any
    label: Any
    name: str | None
    color: Color | None


@dataclass(frozen=True)
class LocatedFace:
    """A face of a part.

    Attributes
    ----------
    own : TopoDS_Face
        The face of the part itself.
    located : TopoDS_Face
        The face at the part's place.
    color : (float, float, float), optional
        The color.
    """

    own: Any
    located: Any
    color: Color | None


def parts(document: Any) -> list[Part]:
    """Return the parts of a document, one for each place of each."""
    from OCP.collections import Sequence_TDF_Label
    from OCP.TopLoc import TopLoc_Location
    from OCP.XCAFDoc import XCAFDoc_DocumentTool

    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    labels = Sequence_TDF_Label()
    tool.GetFreeShapes(labels)
    found: list[Part] = []
    for label in _all(labels):
        found.extend(_parts_of(label, TopLoc_Location(), None))
    return found


def _parts_of(label: Any, location: Any, color: Color | None) -> Iterator[Part]:
    from OCP.collections import Sequence_TDF_Label
    from OCP.TDF import TDF_Label
    from OCP.XCAFDoc import XCAFDoc_ShapeTool

    color = _color(label) or color
    if XCAFDoc_ShapeTool.IsAssembly_s(label):
        components = Sequence_TDF_Label()
        XCAFDoc_ShapeTool.GetComponents_s(label, components)
        for component in _all(components):
            referred = TDF_Label()
            if XCAFDoc_ShapeTool.GetReferredShape_s(component, referred):
                place = location * XCAFDoc_ShapeTool.GetLocation_s(component)
                yield from _parts_of(referred, place, _color(component) or color)
        return
    shape = XCAFDoc_ShapeTool.GetShape_s(label)
    if shape is not None and not shape.IsNull():
        yield Part(shape, location, label, _name(label), color)


def located_faces(part: Part) -> Iterator[LocatedFace]:
    """Yield the faces of a part. A face without a color has that of its solid, or of the part."""
    from OCP.TopAbs import TopAbs_FACE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    colors = _Colors(part)
    faces = TopExp_Explorer(part.shape, TopAbs_FACE)
    while faces.More():
        own = faces.Current()
        located = TopoDS.Face(own.Moved(part.location))
        yield LocatedFace(own, located, colors.of(own) or part.color)
        faces.Next()


class _Colors:
    """The colors that faces of a part have for themselves or from their solid."""

    def __init__(self, part: Part) -> None:
        from OCP.collections import (
            IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher,
            Sequence_TDF_Label,
        )
        from OCP.TopAbs import TopAbs_FACE
        from OCP.TopExp import TopExp_Explorer
        from OCP.XCAFDoc import XCAFDoc_ShapeTool

        labels = Sequence_TDF_Label()
        XCAFDoc_ShapeTool.GetSubShapes_s(part.label, labels)
        colored = [(XCAFDoc_ShapeTool.GetShape_s(label), _color(label)) for label in _all(labels)]
        # Solids before their shells and faces, whose colors take precedence.
        colored.sort(key=lambda pair: pair[0].ShapeType().value)
        self._numbers = IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher()
        self._colors: dict[int, Color] = {}
        for shape, color in colored:
            faces = TopExp_Explorer(shape, TopAbs_FACE)
            while color is not None and faces.More():
                self._colors[self._numbers.Add(faces.Current())] = color
                faces.Next()

    def of(self, face: Any) -> Color | None:
        return self._colors.get(self._numbers.FindIndex(face))


def _color(label: Any) -> Color | None:
    from OCP.Quantity import Quantity_Color, Quantity_TypeOfColor
    from OCP.XCAFDoc import XCAFDoc_ColorTool, XCAFDoc_ColorType

    color = Quantity_Color()
    for kind in (XCAFDoc_ColorType.XCAFDoc_ColorSurf, XCAFDoc_ColorType.XCAFDoc_ColorGen):
        if XCAFDoc_ColorTool.GetColor_s(label, kind, color):
            values = color.Values(Quantity_TypeOfColor.Quantity_TOC_sRGB)
            red, green, blue = (min(1.0, max(0.0, round(value, _DIGITS))) for value in values)
            return red, green, blue
    return None


def _name(label: Any) -> str | None:
    from OCP.TDataStd import TDataStd_Name

    name = TDataStd_Name()
    if not label.FindAttribute(TDataStd_Name.GetID_s(), name):
        return None
    return name.Get().ToExtString().strip() or None


def _all(labels: Any) -> list[Any]:
    return [labels.Value(k + 1) for k in range(labels.Length())]
