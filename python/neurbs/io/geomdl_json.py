"""Surfaces as JSON, in the format of the library geomdl."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, cast

import numpy as np

from neurbs._core import LENGTH_UNITS, NeurbsError, NurbsSurface
from neurbs.io.face_file import FaceData, FaceFile

_TRIMMED: dict[str, Any] = {"is_trimmed": True, "defect": "trims of geomdl are not read"}
"""What a face with trims has."""


def write_json(surface: NurbsSurface, path: str, unit: str | None = None) -> None:
    """Write a surface with all digits; the key `unit` is an addition, which geomdl ignores."""
    (rows, cols), (p, q) = surface.control_points.shape[:2], surface.degree
    net: dict[str, Any] = {"points": surface.control_points.reshape(-1, 3).tolist()}
    if surface.weights is not None:
        net["weights"] = surface.weights.ravel().tolist()
    data = {
        "type": "spline",
        "rational": surface.weights is not None,
        "dimension": 3,
        "degree_u": p,
        "degree_v": q,
        "knotvector_u": surface.knots[0].tolist(),
        "knotvector_v": surface.knots[1].tolist(),
        "size_u": rows,
        "size_v": cols,
        "control_points": net,
    }
    document: dict[str, Any] = {"shape": {"type": "surface", "count": 1, "data": [data]}}
    if unit is not None:
        document["unit"] = unit
    with open(path, "w", encoding="utf-8") as file:
        # In pieces, so that Ctrl-C is handled in between.
        file.writelines(json.JSONEncoder().iterencode(document))


def surfaces_of(path: Path, document: Any) -> FaceFile:
    """Return all surfaces of a file's document."""
    try:
        shape = document["shape"]
        if shape["type"] != "surface":
            raise NeurbsError(f"{path}: must have a shape of type 'surface', got {shape['type']!r}")
        faces = [
            FaceData(k + 1, _surface(path, item), **_TRIMMED if item.get("trims") else {})
            for k, item in enumerate(shape["data"])
        ]
    except (KeyError, TypeError, AttributeError) as error:
        raise NeurbsError(
            f"{path}: must be a surface as geomdl writes it, but {error} is missing or wrong"
        ) from None
    return FaceFile(faces, _unit(path, document.get("unit")))


def _unit(path: Path, unit: Any) -> str | None:
    if unit is not None and unit not in LENGTH_UNITS:
        known = " or ".join(map(repr, LENGTH_UNITS))
        raise NeurbsError(f"{path}: unit must be {known}, got {unit!r}")
    return cast(str | None, unit)


def _surface(path: Path, item: dict[str, Any]) -> NurbsSurface:
    net = item["control_points"]
    shape = (item["size_u"], item["size_v"])
    knots = (item["knotvector_u"], item["knotvector_v"])
    try:
        points = np.asarray(net["points"], float).reshape(*shape, -1)
        weights = net.get("weights")
        if weights is not None:
            weights = np.asarray(weights, float).reshape(shape)
        return NurbsSurface(points, weights, (item["degree_u"], item["degree_v"]), knots)
    except ValueError as error:
        raise NeurbsError(f"{path}: {error}") from None
