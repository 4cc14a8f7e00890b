"""Faces in STEP and IGES files, read by OpenCASCADE."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from neurbs._core import LENGTH_UNITS, NeurbsError
from neurbs.extras import require_for_file
from neurbs.io.cad_faces import face_data
from neurbs.io.cad_parts import Part, located_faces, parts
from neurbs.io.face_file import FaceData, FaceFile, label, scaled
from neurbs.io.reading import cause
from neurbs.io.units import ratio, symbol

_STEP = (".step", ".stp")

_SECTION = 72
"""Column, from 0, of the letter of the section in a line of an IGES file."""

_IGES_UNITS = {1: "in", 2: "mm", 4: "ft", 6: "m", 10: "cm"}
"""The unit flags of the IGES standard."""


def read_cad(path: Path) -> FaceFile:
    """Read each face in the unit of the file, with its loops, edges, name and color."""
    require_for_file(path, "OCP")
    with _quiet():
        content = (_step if path.suffix.lower() in _STEP else _iges)(path)
        faces, left_out = _faces(content)
        others = Counter[str]() if faces or left_out else _others(content)
    # OpenCASCADE converts coordinates to millimeters.
    return FaceFile(scaled(faces, ratio("mm", content.unit)), content.unit, left_out, others)


@dataclass(frozen=True)
class _Content:
    """The shapes of a file, and what gives the entity of each.

    Labels of parts and the transfer are valid as long as the document and the reader exist.
    """

    reader: Any
    document: Any
    unit: str
    transfer: Any
    has_part_names: bool

    def parts(self) -> list[Part]:
        return parts(self.document)


def _step(path: Path) -> _Content:
    from OCP.collections import Sequence_TCollection_AsciiString
    from OCP.STEPCAFControl import STEPCAFControl_Reader

    reader = _read(path, STEPCAFControl_Reader())
    reader.SetColorMode(True)
    reader.SetNameMode(True)
    document = _transferred(reader)
    step = reader.ChangeReader()
    lengths, angles, solid_angles = (Sequence_TCollection_AsciiString() for _ in range(3))
    step.FileUnits(lengths, angles, solid_angles)
    unit = symbol(lengths.Value(1).ToCString()) if lengths.Size() else "mm"
    # For an unknown unit the coordinates stay in millimeters.
    unit = unit if unit in LENGTH_UNITS else "mm"
    return _Content(reader, document, unit, step.WS().TransferReader(), True)


def _iges(path: Path) -> _Content:
    from OCP.IGESCAFControl import IGESCAFControl_Reader

    _check_iges(path)
    reader = _read(path, IGESCAFControl_Reader())
    reader.SetColorMode(True)
    reader.SetNameMode(True)
    unit = _IGES_UNITS.get(reader.IGESModel().GlobalSection().UnitFlag(), "mm")
    document = _transferred(reader)
    return _Content(reader, document, unit, reader.WS().TransferReader(), False)


def _transferred(reader: Any) -> Any:
    """Return the document of a file that is read."""
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDocStd import TDocStd_Document

    document = TDocStd_Document(TCollection_ExtendedString("XCAF"))
    reader.Transfer(document)
    return document


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


def _faces(content: _Content) -> tuple[list[FaceData], list[str]]:
    """Return the faces that can be read, and number, name and cause for the others."""
    from OCP.collections import IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher

    edges = IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher()
    read: list[FaceData] = []
    left_out: list[str] = []
    all_parts = content.parts()
    # Parts of IGES files have no names: OpenCASCADE calls them "SOLID".
    named_parts = content.has_part_names and len(all_parts) > 1
    has_names = _has_named_faces(content.transfer.Model())
    number = 0
    for part in all_parts:
        for face in located_faces(part):
            number += 1
            own = content.transfer.EntityFromShapeResult(face.own, 1) if has_names else None
            name = _name_of(own) or (part.name if named_parts else None)
            try:
                read.append(face_data(face.located, number, edges.Add, name, face.color))
            except (MemoryError, OSError):
                raise
            except Exception as error:
                # A `NeurbsError`, or what OpenCASCADE raises for a surface that it cannot convert.
                left_out.append(f"{label(number, name)}: {cause(error)}")
    return read, left_out


def _has_named_faces(model: Any) -> bool:
    """Whether an entity of a face has a name. To find the entity of each face takes long."""
    from OCP.IGESData import IGESData_IGESEntity
    from OCP.StepShape import StepShape_Face

    return any(
        _name_of(entity) is not None
        for entity in (model.Value(k + 1) for k in range(model.NbEntities()))
        if isinstance(entity, StepShape_Face | IGESData_IGESEntity)
    )


def _name_of(entity: Any) -> str | None:
    """Return the name of an entity."""
    from OCP.IGESData import IGESData_IGESEntity
    from OCP.StepRepr import StepRepr_RepresentationItem

    name = None
    if isinstance(entity, StepRepr_RepresentationItem):
        name = entity.Name()
    elif isinstance(entity, IGESData_IGESEntity) and entity.HasName():
        name = entity.NameValue()
    return (name.ToCString().strip() or None) if name is not None else None


def _others(content: _Content) -> Counter[str]:
    """Count the shapes of parts that have no faces."""
    from OCP.TopAbs import TopAbs_EDGE, TopAbs_VERTEX
    from OCP.TopExp import TopExp_Explorer

    counts: Counter[str] = Counter()
    for part in content.parts():
        edges = TopExp_Explorer(part.shape, TopAbs_EDGE)
        while edges.More():
            counts["curve"] += 1
            edges.Next()
        points = TopExp_Explorer(part.shape, TopAbs_VERTEX, TopAbs_EDGE)
        while points.More():
            counts["point"] += 1
            points.Next()
    return counts
