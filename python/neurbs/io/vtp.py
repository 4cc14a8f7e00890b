"""VTK PolyData: a mesh with normals and parameters, in double precision, for ParaView."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neurbs.io.binary import write_array

if TYPE_CHECKING:
    from neurbs import TriangleMesh

_LENGTH = struct.Struct("<Q")
"""What stands before each array: how many bytes it takes."""

_TYPES = {"<f8": "Float64", "<f4": "Float32", "<i8": "Int64"}


def write_vtp(mesh: TriangleMesh, path: str) -> None:
    """Write a mesh: an XML head, then the arrays as they are."""
    ends = np.arange(3, 3 * len(mesh.triangles) + 1, 3)
    arrays: list[tuple[str, str, NDArray[Any]]] = [
        ("Normals", "<f4", mesh.normals),
        ("uv", "<f8", mesh.uv),
        ("Points", "<f8", mesh.vertices),
        ("connectivity", "<i8", mesh.triangles.reshape(-1)),
        ("offsets", "<i8", ends),
    ]
    elements, start = [], 0
    for name, dtype, array in arrays:
        width = array.shape[1] if array.ndim == 2 else 1
        elements.append(
            f'<DataArray type="{_TYPES[dtype]}" Name="{name}" NumberOfComponents="{width}" '
            f'format="appended" offset="{start}"/>'
        )
        start += _LENGTH.size + _bytes(array, dtype)
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
        for _, dtype, array in arrays:
            file.write(_LENGTH.pack(_bytes(array, dtype)))
            write_array(file, array, dtype)
        file.write(b"\n</AppendedData></VTKFile>\n")


def _bytes(array: NDArray[Any], dtype: str) -> int:
    """Return how many an array takes when it is written as this type."""
    return array.size * np.dtype(dtype).itemsize
