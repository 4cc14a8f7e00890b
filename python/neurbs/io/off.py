"""Meshes as OFF, a text format: reader of vertices, and writer with all digits."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import chain, islice
from pathlib import Path
from typing import TYPE_CHECKING

from neurbs._core import NeurbsError
from neurbs.io.point_cloud import Block, PointSource, Request, checked_count
from neurbs.io.preamble import data_rows
from neurbs.io.reading import check_size, damaged
from neurbs.io.row_blocks import blocks_of
from neurbs.io.table import read_blocks, shown
from neurbs.io.table_layout import Layout

if TYPE_CHECKING:
    from neurbs import TriangleMesh

_KEYWORD = re.compile("(?:ST)?C?N?OFF")
"""The first word: texture coordinates, colors and normals follow the coordinates."""


def read_off(path: Path, request: Request) -> PointSource:
    """Read the vertices of a mesh, in their order."""

    def words() -> Iterator[tuple[int, str]]:
        """Yield the rows after the keyword, which may be in a line with the counts."""
        for number, text in data_rows(path):
            rest = text.split(None, 1)[1:] if _KEYWORD.match(text.lstrip()) else [text]
            yield from ((number, part) for part in rest)

    _, first = next(data_rows(path), (0, ""))
    if not _KEYWORD.fullmatch(first.split()[0] if first else ""):
        raise NeurbsError(f"{path}: must start with the word OFF, got {shown(first.strip())}")
    _, row = next(words(), (0, ""))
    try:
        count, faces = map(int, row.split()[:2])
    except ValueError:
        raise damaged(path, f"it must have the numbers of vertices and faces, got {row}") from None
    if count < 1 or faces < 0:
        raise NeurbsError(f"{path}: must have at least one point, but has {count} vertices")
    check_size(path, count, 6, "vertices")
    check_size(path, faces, 2, "faces")

    def vertices() -> Iterator[tuple[int, str]]:
        return islice(words(), 1, 1 + count)

    def check_faces() -> Iterator[Block]:
        """Check that all faces are there; yields nothing."""
        found, last = 0, ""
        for _, last in islice(words(), 1 + count, 1 + count + faces):  # noqa: B007
            found += 1
        corners = last.split() or ["0"]
        if found < faces or len(corners) <= int(corners[0]):
            raise damaged(path, f"it is cut short after {found} of {faces} faces")
        yield from ()

    layout = Layout((0, 1, 2), allow_missing=request.nan == "drop")
    blocks = checked_count(path, read_blocks(path, vertices, layout), count)
    return PointSource(chain(blocks, check_faces()), count=count)


def write_off(mesh: TriangleMesh, path: str) -> None:
    """Write vertices and triangles."""
    with open(path, "w", encoding="ascii", newline="\n") as file:
        file.write(f"OFF\n{len(mesh.vertices)} {len(mesh.triangles)} 0\n")
        for block in blocks_of(mesh.vertices):
            file.writelines(f"{x!r} {y!r} {z!r}\n" for x, y, z in block.tolist())
        for block in blocks_of(mesh.triangles):
            file.writelines(f"3 {a} {b} {c}\n" for a, b, c in block.tolist())
