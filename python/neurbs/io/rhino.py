"""Rhino files: `.3dm`, by rhino3dm."""

from __future__ import annotations

import errno
import itertools
import warnings
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError, Shell
from neurbs.extras import require_for_file
from neurbs.io.face_file import FaceData, FaceFile, label, scaled
from neurbs.io.reading import cause
from neurbs.io.rhino_faces import LeftOut, brep_data, surface_data
from neurbs.io.rhino_shells import brep_of, is_surface, surface_of

_UNITS = {
    "mm": "Millimeters",
    "cm": "Centimeters",
    "m": "Meters",
    "in": "Inches",
    "ft": "Feet",
}
"""Names of the units in Rhino."""

_OTHER_UNITS = {
    "Microns": 1e-3,
    "Decimeters": 100.0,
    "Dekameters": 1e4,
    "Hectometers": 1e5,
    "Kilometers": 1e6,
    "Microinches": 25.4e-6,
    "Mils": 25.4e-3,
    "Yards": 914.4,
    "Miles": 1609344.0,
}
"""Names of other units in Rhino, with their millimeters: these files are read in millimeters."""

_VERSION = 7
"""Version of the written files, for Rhino 7 and later."""

_KINDS = {"PointSet": "point cloud", "SubD": "SubD", "ClipPlane": "clipping plane"}
"""Kinds of objects whose name is not that of their type in small letters."""

_FULL = 255.0
"""The highest component of a color."""

Color = tuple[float, float, float]


# Writing


def write_3dm(shells: list[Shell], path: str, unit: str | None = None) -> None:
    """Write each shell as one joined polysurface, with all digits and clamped knots.

    A single open face that is not trimmed is written as a surface.
    """
    rhino3dm = require_for_file(Path(path), "rhino3dm")
    model = rhino3dm.File3dm()
    model.Settings.ModelUnitSystem = getattr(rhino3dm.UnitSystem, _UNITS[unit or "mm"])
    for shell in shells:
        attributes = _attributes(rhino3dm, shell)
        if is_surface(shell):
            model.Objects.AddSurface(surface_of(rhino3dm, shell.faces[0].surface), attributes)
        else:
            model.Objects.AddBrep(brep_of(rhino3dm, shell), attributes)
    if not model.Write(path, _VERSION):
        raise OSError(errno.EIO, "Rhino's library cannot write this file", path)


def _attributes(rhino3dm: Any, shell: Shell) -> Any:
    """Return the name and color that all faces have; a polysurface has one of each."""
    attributes = rhino3dm.ObjectAttributes()
    # Not that of the layer, which is black.
    attributes.ColorSource = rhino3dm.ObjectColorSource.ColorFromParent
    names = {face.name for face in shell.faces}
    colors = {face.color for face in shell.faces}
    lost = [what for what, found in (("name", names), ("color", colors)) if len(found) > 1]
    if lost:
        warnings.warn(
            f"a polysurface of a Rhino file has one {' and one '.join(lost)}: "
            "those of the faces differ and are not written",
            UserWarning,
            stacklevel=4,  # The caller of `save`.
        )
    name, color = next(iter(names)), next(iter(colors))
    if len(names) == 1 and name is not None:
        attributes.Name = name
    if len(colors) == 1 and color is not None:
        attributes.ColorSource = rhino3dm.ObjectColorSource.ColorFromObject
        attributes.ObjectColor = (*(round(_FULL * value) for value in color), int(_FULL))
    return attributes


# Reading


def read_3dm(path: Path) -> FaceFile:
    """Read all surfaces, faces of solids and extrusions, in blocks at each of their places."""
    rhino3dm = require_for_file(path, "rhino3dm")
    model = rhino3dm.File3dm.Read(str(path))
    if model is None:
        raise NeurbsError(f"{path}: must be a complete Rhino file, but is damaged or cut short")
    reader = _Reader(rhino3dm, model)
    top = (item for item in model.Objects if not item.Attributes.IsInstanceDefinitionObject)
    reader.read(top, _Place(np.eye(4), None, None, ()))
    name = model.Settings.ModelUnitSystem.name
    unit = next((symbol for symbol, theirs in _UNITS.items() if theirs == name), None)
    faces = reader.faces
    if name in _OTHER_UNITS:
        faces, unit = scaled(faces, _OTHER_UNITS[name]), "mm"
    return FaceFile(faces, unit, reader.left_out, reader.others)


@dataclass(frozen=True)
class _Place:
    """Where and how objects stand: a map, the name and color of their block, and the blocks."""

    matrix: NDArray[np.float64]
    name: str | None
    color: Color | None
    blocks: tuple[str, ...]


class _Reader:
    """The faces read so far."""

    def __init__(self, rhino3dm: Any, model: Any) -> None:
        self.faces: list[FaceData] = []
        self.left_out: list[str] = []
        self.others: Counter[str] = Counter()
        self._rhino3dm = rhino3dm
        self._model = model
        self._numbers = itertools.count(1)
        self._edges = itertools.count()

    def read(self, items: Iterable[Any], place: _Place) -> None:
        """Read objects at a place."""
        for item in items:
            geometry, attributes = item.Geometry, item.Attributes
            if geometry is None:
                self.others["unknown object"] += 1
                continue
            if isinstance(geometry, self._rhino3dm.InstanceReference):
                self._read_block(geometry, attributes, place)
                continue
            name, color = self._name(attributes, place), self._color(attributes, place)
            for face in self._faces(geometry):
                if isinstance(face, LeftOut):
                    self.left_out.append(f"{label(face.number, name)}: {face.cause}")
                    continue
                self.faces.append(_placed(replace(face, name=name, color=color), place.matrix))

    def _read_block(self, reference: Any, attributes: Any, place: _Place) -> None:
        identifier = str(reference.ParentIdefId)
        definition = self._model.InstanceDefinitions.FindId(reference.ParentIdefId)
        if definition is None or identifier in place.blocks:
            self.others["block without its objects" if definition is None else "endless block"] += 1
            return
        matrix = np.array(reference.Xform.ToFloatArray(True), float).reshape(4, 4)
        items = (self._model.Objects.FindId(each) for each in definition.GetObjectIds())
        inner = _Place(
            place.matrix @ matrix,
            self._name(attributes, place),
            self._color(attributes, place),
            (*place.blocks, identifier),
        )
        self.read((item for item in items if item is not None), inner)

    def _faces(self, geometry: Any) -> list[FaceData | LeftOut]:
        """Convert an object."""
        rhino3dm = self._rhino3dm
        number, edge = self._numbers.__next__, self._edges.__next__
        tolerance = self._model.Settings.ModelAbsoluteTolerance
        kind = geometry.ObjectType.name
        if isinstance(geometry, rhino3dm.Extrusion):
            geometry = geometry.ToBrep(True)
        try:
            if isinstance(geometry, rhino3dm.Brep):
                return brep_data(rhino3dm, geometry, tolerance, number, edge)
            if kind == "Surface":
                return [surface_data(geometry, number, edge)]
        except NeurbsError as error:
            return [LeftOut(number(), cause(error))]
        self.others[_KINDS.get(kind, kind.lower())] += 1
        return []

    def _name(self, attributes: Any, place: _Place) -> str | None:
        """Return the name of an object, or of its block, or of its layer if there are several."""
        layer = self._layer(attributes) if len(self._model.Layers) > 1 else None
        return attributes.Name or place.name or (layer.Name if layer is not None else "") or None

    def _color(self, attributes: Any, place: _Place) -> Color | None:
        source = attributes.ColorSource.name
        if source == "ColorFromObject":
            return _shares(attributes.ObjectColor)
        layer = self._layer(attributes)
        if source == "ColorFromLayer" and layer is not None:
            return _shares(layer.Color)
        return place.color

    def _layer(self, attributes: Any) -> Any:
        index = attributes.LayerIndex
        layers = self._model.Layers
        return layers[index] if 0 <= index < len(layers) else None


def _shares(color: Any) -> Color:
    red, green, blue = (value / _FULL for value in tuple(color)[:3])
    return red, green, blue


def _placed(face: FaceData, matrix: NDArray[np.float64]) -> FaceData:
    """Return a face of a block at its place; its normals stay on the same side."""
    if (matrix == np.eye(4)).all():
        return face
    is_mirrored = bool(np.linalg.det(matrix[:3, :3]) < 0)
    return replace(
        face,
        surface=face.surface.transformed(matrix),
        is_reversed=face.is_reversed != is_mirrored,
    )
