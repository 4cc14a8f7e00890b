"""Meshes as OFF, a text format, with all digits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from neurbs.io.row_blocks import blocks_of

if TYPE_CHECKING:
    from neurbs import TriangleMesh


def write_off(mesh: TriangleMesh, path: str) -> None:
    """Write vertices and triangles."""
    with open(path, "w", encoding="ascii", newline="\n") as file:
        file.write(f"OFF\n{len(mesh.vertices)} {len(mesh.triangles)} 0\n")
        for block in blocks_of(mesh.vertices):
            file.writelines(f"{x!r} {y!r} {z!r}\n" for x, y, z in block.tolist())
        for block in blocks_of(mesh.triangles):
            file.writelines(f"3 {a} {b} {c}\n" for a, b, c in block.tolist())
