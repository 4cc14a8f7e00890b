"""Meshes as VTK PolyData, with normals and parameters, in double precision."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neurbs.io.row_blocks import blocks_of, row_blocks, write_blocks

if TYPE_CHECKING:
    from neurbs import TriangleMesh

_LENGTH = struct.Struct("<Q")
"""The size in bytes before each array."""

_TYPES = {"<f8": "Float64", "<f4": "Float32", "<i8": "Int64"}


def write_vtp(mesh: TriangleMesh, path: str) -> None:
    """Write a mesh: an XML header, then the arrays in binary."""
    count, triangles = len(mesh.vertices), len(mesh.triangles)
    ends = (np.arange(3 * part.start, 3 * part.stop, 3) + 3 for part in row_blocks(triangles))
    arrays: list[tuple[str, str, tuple[int, int], Iterator[NDArray[Any]]]] = [
        ("Normals", "<f4", (count, 3), blocks_of(mesh.normals)),
        ("uv", "<f8", (count, 2), blocks_of(mesh.uv)),
        ("Points", "<f8", (count, 3), blocks_of(mesh.vertices)),
        ("connectivity", "<i8", (3 * triangles, 1), blocks_of(mesh.triangles)),
        ("offsets", "<i8", (triangles, 1), ends),
    ]
    elements: list[str] = []
    sizes: list[int] = []
    for name, dtype, (rows, width), _ in arrays:
        elements.append(
            f'<DataArray type="{_TYPES[dtype]}" Name="{name}" NumberOfComponents="{width}" '
            f'format="appended" offset="{sum(sizes) + len(sizes) * _LENGTH.size}"/>'
        )
        sizes.append(rows * width * np.dtype(dtype).itemsize)
    normals, uv, points, *polys = elements
    head = (
        '<?xml version="1.0"?>\n'
        '<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">'
        f'<PolyData><Piece NumberOfPoints="{len(mesh.vertices)}" NumberOfVerts="0" '
        f'NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="{len(mesh.triangles)}">\n'
        f'<PointData Normals="Normals">{normals}{uv}</PointData>\n'
        f"<Points>{points}</Points>\n"
        f"<Polys>{''.join(polys)}</Polys>\n"
        '</Piece></PolyData><AppendedData encoding="raw">\n_'
    )
    with open(path, "wb") as file:
        file.write(head.encode())
        for (_, dtype, _, blocks), size in zip(arrays, sizes, strict=True):
            file.write(_LENGTH.pack(size))
            write_blocks(file, blocks, dtype)
        file.write(b"\n</AppendedData></VTKFile>\n")
