"""Faces in JSON files: shells as neurbs writes them, or surfaces as geomdl does."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from neurbs._core import Face, NeurbsError, Shell
from neurbs.io.face_file import Edges, FaceData, FaceFile, scaled
from neurbs.io.geomdl_json import surfaces_of
from neurbs.io.reading import read_whole
from neurbs.io.units import ratio

_MAX_BYTES = 1 << 29
"""Most bytes of a file, which is read as a whole."""

_FORMAT = "neurbs-shell"

_VERSION = 1


def write_shells(shells: list[Shell], path: str, unit: str | None = None) -> None:
    """Write shells with all digits; `unit` takes precedence over theirs."""
    dicts = [shell.to_dict() for shell in shells]
    if unit is not None:
        dicts = [{**shell, "unit": unit} for shell in dicts]
    document = {"format": _FORMAT, "version": _VERSION, "shells": dicts}
    with open(path, "w", encoding="utf-8") as file:
        # In pieces, so that Ctrl-C is handled in between.
        file.writelines(json.JSONEncoder().iterencode(document))


def read_json(path: Path) -> FaceFile:
    """Read all faces of a file."""
    try:
        document = json.loads(read_whole(path, _MAX_BYTES))
    except ValueError as error:
        raise NeurbsError(f"{path}: must be JSON, but is damaged or cut short: {error}") from None
    if isinstance(document, dict) and document.get("format") == _FORMAT:
        return _shells(path, document)
    return surfaces_of(path, document)


def _shells(path: Path, document: dict[str, Any]) -> FaceFile:
    if document.get("version") != _VERSION:
        got = document.get("version")
        raise NeurbsError(f"{path}: version must be {_VERSION}, got {got!r}: update neurbs")
    given = document.get("shells")
    if not isinstance(given, list):
        raise NeurbsError(f"{path}: shells must be a list, got {type(given).__name__}")
    faces: list[FaceData] = []
    unit: str | None = None
    tolerances: list[float] = []
    first_edge = 0
    for k, data in enumerate(given):
        try:
            shell = Shell.from_dict(data)
        except NeurbsError as error:
            raise NeurbsError(f"{path}: shell {k + 1}: {error}") from None
        factor = 1.0
        if k == 0:
            unit = shell.unit
        elif shell.unit != unit:
            if shell.unit is None or unit is None:
                raise NeurbsError(f"{path}: shells must all have a unit, or none of them")
            factor = ratio(shell.unit, unit)
        edges: list[Edges] | None = shell.to_dict()["edges"]
        of_shell = [
            _face(
                len(faces) + n + 1, face, None if edges is None else _shifted(edges[n], first_edge)
            )
            for n, face in enumerate(shell.faces)
        ]
        first_edge += len(shell.edges)
        faces.extend(scaled(of_shell, factor))
        tolerances.append(factor * shell.tolerance)
    return FaceFile(faces, unit, tolerance=max(tolerances, default=None))


def _face(number: int, face: Face, edges: Edges | None) -> FaceData:
    return FaceData(
        number,
        face.surface,
        face.loops if face.is_trimmed else None,
        edges,
        face.is_trimmed,
        face.is_reversed,
        face.name,
        face.color,
    )


def _shifted(edges: Edges, by: int) -> Edges:
    return [[None if edge is None else edge + by for edge in each] for each in edges]
