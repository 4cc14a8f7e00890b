"""Meshes as binary glTF 2.0."""

from __future__ import annotations

import json
import struct
from typing import TYPE_CHECKING, Any

import numpy as np

from neurbs._core import LENGTH_UNITS, NeurbsError
from neurbs.io.row_blocks import blocks_of, bounds, write_blocks
from neurbs.io.single_precision import check_single_precision

if TYPE_CHECKING:
    from neurbs import TriangleMesh

_FLOAT, _UINT32 = 5126, 5125
_ARRAY_BUFFER, _ELEMENT_ARRAY_BUFFER = 34962, 34963
"""Codes of the standard for the types and uses of buffers."""

_MAX_BYTES = 2**32 - 2**16
"""Most bytes of the arrays: lengths have 32 bits, and the header needs some room."""


def write_glb(mesh: TriangleMesh, path: str, unit: str | None = None) -> None:
    """Write a mesh with vertices relative to their center, and the center as translation.

    The format stores vertices in single precision, but the translation of a node as text, so
    coordinates far from the origin keep their digits. The unit of the format is the meter: another
    unit is written as the scale of the node.
    """
    low, high = bounds(mesh.vertices)
    # Halved before the sum, which may overflow.
    center = low / 2 + high / 2
    check_single_precision(mesh.vertices, center, "GLB", stacklevel=4)
    meters = 1.0 if unit is None else LENGTH_UNITS[unit] / LENGTH_UNITS["m"]
    count, corners = len(mesh.vertices), 3 * len(mesh.triangles)
    extent = {"min": _single(low - center), "max": _single(high - center)}
    sizes = [12 * count, 12 * count, 4 * corners]
    starts = [0, sizes[0], sizes[0] + sizes[1]]
    targets = [_ARRAY_BUFFER, _ARRAY_BUFFER, _ELEMENT_ARRAY_BUFFER]
    node: dict[str, Any] = {"mesh": 0, "name": "surface", "translation": (meters * center).tolist()}
    if meters != 1:
        node["scale"] = [meters] * 3
    primitive = {"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": 0}
    document = {
        "asset": {"version": "2.0", "generator": "neurbs"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [node],
        "meshes": [{"name": "surface", "primitives": [primitive]}],
        # Surfaces are visible from both sides.
        "materials": [{"doubleSided": True, "pbrMetallicRoughness": {"metallicFactor": 0}}],
        "buffers": [{"byteLength": sum(sizes)}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": start, "byteLength": size, "target": target}
            for start, size, target in zip(starts, sizes, targets, strict=True)
        ],
        "accessors": [
            {"bufferView": 0, "componentType": _FLOAT, "count": count, "type": "VEC3"} | extent,
            {"bufferView": 1, "componentType": _FLOAT, "count": count, "type": "VEC3"},
            {"bufferView": 2, "componentType": _UINT32, "count": corners, "type": "SCALAR"},
        ],
    }
    if sum(sizes) > _MAX_BYTES:
        raise NeurbsError(
            f"GLB files must be below 4 GiB, but these triangles take {sum(sizes):,} bytes: "
            "tessellate more coarsely, or write .ply"
        )
    text = json.dumps(document, separators=(",", ":")).encode()
    text = text.ljust(-len(text) % 4 + len(text))
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + sum(sizes)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text)
        file.write(struct.pack("<I4s", sum(sizes), b"BIN\0"))
        write_blocks(file, (block - center for block in blocks_of(mesh.vertices)), "<f4")
        write_blocks(file, blocks_of(mesh.normals), "<f4")
        write_blocks(file, blocks_of(mesh.triangles), "<u4")


def _single(numbers: Any) -> list[float]:
    """Round to single precision like the vertices, because readers compare both."""
    rounded: list[float] = np.asarray(numbers, np.float32).tolist()
    return rounded
