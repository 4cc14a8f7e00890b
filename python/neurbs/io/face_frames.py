"""Faces as the frames that a worker sends: a dict for JSON, and arrays."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any

from numpy.typing import NDArray

from neurbs._core import NurbsCurve, NurbsSurface
from neurbs.io.face_file import FaceData, FaceFile

Frame = tuple[dict[str, Any], list[NDArray[Any] | None]]

_PLAIN = ("number", "edges", "is_trimmed", "is_reversed", "name", "color", "defect")
"""Attributes of a face that JSON can store."""


def frames(file: FaceFile) -> Iterator[Frame]:
    """Yield a frame for the file, then one for each face."""
    yield (
        {
            "count": len(file.faces),
            "unit": file.unit,
            "left_out": file.left_out,
            "others": file.others,
        },
        [],
    )
    for face in file.faces:
        head: dict[str, Any] = {name: getattr(face, name) for name in _PLAIN}
        head["degree"] = face.surface.degree
        surface = face.surface
        arrays: list[NDArray[Any] | None] = [surface.control_points, surface.weights]
        arrays.extend(surface.knots)
        head["loops"] = face.loops and [[curve.degree for curve in each] for each in face.loops]
        for curve in (curve for each in face.loops or [] for curve in each):
            arrays.extend([curve.control_points, curve.weights, curve.knots])
        yield head, arrays


def face_of(head: dict[str, Any], arrays: list[Any]) -> FaceData:
    """Make the face of a frame."""
    points, weights, u, v = arrays[:4]
    surface = NurbsSurface(points, weights, tuple(head["degree"]), (u, v))
    left = iter(arrays[4:])
    loops = head["loops"] and [
        [NurbsCurve(next(left), next(left), degree, next(left)) for degree in each]
        for each in head["loops"]
    ]
    plain = {name: head[name] for name in _PLAIN}
    plain["color"] = head["color"] and tuple(head["color"])
    return FaceData(surface=surface, loops=loops, **plain)


def file_of(head: dict[str, Any], faces: list[FaceData]) -> FaceFile:
    """Make the file of its first frame and its faces."""
    return FaceFile(faces, head["unit"], head["left_out"], Counter(head["others"]))
