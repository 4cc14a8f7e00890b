"""Meshes as binary STL: the corners of each triangle."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from neurbs.io.row_blocks import blocks_of, write_rows
from neurbs.io.single_precision import check_single_precision

if TYPE_CHECKING:
    from neurbs import TriangleMesh

_HEADER_BYTES = 80
"""Bytes before the number of triangles; they must not start with 'solid'."""

_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])


def write_stl(mesh: TriangleMesh, path: str) -> None:
    """Write a mesh with its coordinates: the format has no offset."""
    check_single_precision(mesh.vertices, np.zeros(3), "STL", stacklevel=4)
    with open(path, "wb") as file:
        file.write(b"neurbs".ljust(_HEADER_BYTES))
        file.write(np.uint32(len(mesh.triangles)).astype("<u4").tobytes())
        for triangles in blocks_of(mesh.triangles):
            corners = mesh.vertices[triangles]
            normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            lengths = np.linalg.norm(normals, axis=1, keepdims=True)
            # The normal of a triangle without area is zero, as in the specification.
            np.divide(normals, lengths, out=normals, where=lengths > 0)
            write_rows(file, _TRIANGLE, {"normal": normals, "corners": corners})
