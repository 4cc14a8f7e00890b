"""PLY files: reader of vertices; writer of meshes and points in double precision.

The vertex table is read here, because mesh libraries merge, drop or reorder vertices.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import chain, islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, TypeAlias

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.io.ply_rows import TYPES, Element, columns, end_of, text_rows
from neurbs.io.point_cloud import BLOCK, Block, PointCloud, PointSource, Request, checked_count
from neurbs.io.reading import check_size, damaged
from neurbs.io.row_blocks import write_rows
from neurbs.io.table import numbered_lines, read_blocks, shown
from neurbs.io.table_layout import Layout
from neurbs.io.units import symbol

if TYPE_CHECKING:
    from neurbs import TriangleMesh

_BYTE_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}

_Columns: TypeAlias = dict[str, tuple[str, NDArray[Any]]]
"""For each group of columns, by their names, the type in the file and the values."""

_AXES = (("x",), ("y",), ("z",))
_NORMALS = (("nx", "normal_x"), ("ny", "normal_y"), ("nz", "normal_z"))
_COLORS = (("red", "diffuse_red"), ("green", "diffuse_green"), ("blue", "diffuse_blue"))
"""Names of columns in files of different programs."""

_MAX_LINE = 4096
"""Most bytes of a header line; a file with a longer one is no PLY file."""

_MAX_ROWS = 10**15
"""Most rows of a table; a header with more is damaged."""


@dataclass
class _Header:
    byte_order: str
    """Empty for a text file."""
    elements: list[Element]
    lines: int
    size: int
    unit: str | None = None
    """From the comment `unit`, which neurbs writes."""


def read_ply(path: Path, request: Request) -> PointSource:
    """Read all vertices of a PLY file, ASCII or binary, in their order."""
    with path.open("rb") as file:
        header = _read_header(path, file)
    names = [element.name for element in header.elements]
    if "vertex" not in names:
        raise NeurbsError(f"{path}: must have an element 'vertex', but has {names}")
    index = names.index("vertex")
    before, vertex, after = (
        header.elements[:index],
        header.elements[index],
        header.elements[index + 1 :],
    )
    points = vertex.columns(_AXES)
    if not points:
        axes = [vertex.properties[i][0] for i in vertex.scalars()]
        raise NeurbsError(f"{path}: vertices must have properties x, y and z, but have {axes}")
    if vertex.count == 0:
        raise NeurbsError(f"{path}: must have at least one point, but has 0 vertices")
    for element in header.elements:
        # The tables are compared with their numbers of rows when they are read.
        check_size(path, element.count, 1, f"rows of {element.name}")
    layout = Layout(
        points,
        vertex.columns(_NORMALS) if request.attributes else (),
        vertex.columns(_COLORS) if request.attributes else (),
        width=len(vertex.properties),
        allow_missing=request.nan == "drop",
    )
    read = _binary if header.byte_order else _ascii
    blocks = checked_count(path, read(path, header, before, vertex, layout), vertex.count)
    check = _check_binary_rows if header.byte_order else _check_text_rows
    return PointSource(
        chain(blocks, check(path, header, [*before, vertex], after)),
        count=vertex.count,
        unit=header.unit,
    )


def _check_text_rows(
    path: Path, header: _Header, before: list[Element], after: list[Element]
) -> Iterator[Block]:
    """Check that the tables after the vertices are whole; yields nothing."""
    body = islice(numbered_lines(path), header.lines, None)
    rows = (text for _, text in body if text.strip())
    deque(islice(rows, sum(element.count for element in before)), 0)
    for element in after:
        count, last = 0, ""
        for last in islice(rows, element.count):  # noqa: B007
            count += 1
        if count < element.count or (count and not element.is_whole(last.split())):
            raise damaged(path, f"it is cut short in the rows of {element.name}")
    yield from ()


def _check_binary_rows(
    path: Path, header: _Header, before: list[Element], after: list[Element]
) -> Iterator[Block]:
    """Check that the tables after the vertices are whole; yields nothing."""
    data = np.memmap(path, np.uint8, mode="r")
    place = header.size
    for element in [*before, *after]:
        place = end_of(path, data, place, element, header.byte_order)
    yield from ()


def _read_header(path: Path, file: BinaryIO) -> _Header:
    """Read the header, which ends with the line `end_header`."""
    if file.readline(_MAX_LINE).strip() != b"ply":
        raise NeurbsError(f"{path}: must be a PLY file, but does not start with a line 'ply'")
    header = _Header("", [], 1, 0)
    while raw := file.readline(_MAX_LINE):
        header.lines += 1
        line = raw.decode(errors="replace").strip()
        try:
            match line.split():
                case ["end_header"]:
                    header.size = file.tell()
                    return header
                case ["format", encoding, _]:
                    header.byte_order = _BYTE_ORDERS[encoding]
                case ["element", name, count] if 0 <= int(count) < _MAX_ROWS:
                    header.elements.append(Element(name, int(count)))
                case ["property", "list", length, kind, name]:
                    element = header.elements[-1]
                    element.lists[len(element.properties)] = TYPES[length]
                    element.properties.append((name, TYPES[kind]))
                case ["property", kind, name]:
                    header.elements[-1].properties.append((name, TYPES[kind]))
                case ["comment", "unit", *name] if name:
                    header.unit = symbol(" ".join(name))
                case ["comment" | "obj_info", *_] | []:
                    pass
                case _:
                    raise ValueError(line)
        except (KeyError, ValueError, IndexError):
            raise NeurbsError(
                f"{path}: line {header.lines} must be part of a PLY header, got {shown(line)}"
            ) from None
    raise NeurbsError(f"{path}: must have a line 'end_header', but is cut short before it")


def _ascii(
    path: Path, header: _Header, before: list[Element], vertex: Element, layout: Layout
) -> Iterator[Block]:
    start = sum(element.count for element in before)

    def rows() -> Iterator[tuple[int, str]]:
        body = islice(numbered_lines(path), header.lines, None)
        rows = ((number, text) for number, text in body if text.strip())
        vertices = islice(rows, start, start + vertex.count)
        return text_rows(path, vertex, vertices) if vertex.lists else vertices

    # The rows are read without their lists.
    place = {column: i for i, column in enumerate(vertex.scalars())}
    groups = (layout.points, layout.normals, layout.colors)
    points, normals, colors = (tuple(place[column] for column in group) for group in groups)
    layout = replace(layout, points=points, normals=normals, colors=colors, width=len(place))
    return read_blocks(path, rows, layout)


def _binary(
    path: Path, header: _Header, before: list[Element], vertex: Element, layout: Layout
) -> Iterator[Block]:
    def stacked(table: Mapping[int, NDArray[Any]], places: tuple[int, ...]) -> Any:
        return np.column_stack([table[i] for i in places]) if places else None

    for table in _tables(path, header, before, vertex):
        groups = (layout.points, layout.normals, layout.colors)
        yield Block(*(stacked(table, places) for places in groups))


def _tables(
    path: Path, header: _Header, before: list[Element], vertex: Element
) -> Iterator[dict[int, NDArray[Any]]]:
    """Yield the columns of the vertices that are no lists, in blocks."""
    place = header.size
    if vertex.lists or any(element.lists for element in before):
        data = np.memmap(path, np.uint8, mode="r")
        for element in before:
            place = end_of(path, data, place, element, header.byte_order)
        if vertex.lists:
            yield from columns(path, data, place, vertex, header.byte_order)
            return
    else:
        place += sum(e.count * e.row(header.byte_order).itemsize for e in before)
    record = vertex.row(header.byte_order)
    with path.open("rb") as file:
        file.seek(place)
        for start in range(0, vertex.count, BLOCK):
            table = np.fromfile(file, record, min(BLOCK, vertex.count - start))
            if not len(table):
                return
            yield {i: table[str(i)] for i in range(len(vertex.properties))}


def write_ply(mesh: TriangleMesh, path: str, unit: str | None = None) -> None:
    """Write a mesh in binary, with coordinates in double precision and normals in single."""
    vertices = {"x y z": ("<f8", mesh.vertices), "nx ny nz": ("<f4", mesh.normals)}
    with open(path, "wb") as file:
        _write_head(file, len(mesh.vertices), vertices, unit, len(mesh.triangles))
        _write_vertices(file, vertices)
        # Indices are signed, because many readers accept no others.
        face = np.dtype([("count", "u1"), ("vertices", "<i4", 3)])
        corners = np.broadcast_to(np.uint8(3), len(mesh.triangles))
        write_rows(file, face, {"count": corners, "vertices": mesh.triangles})


def write_ply_points(cloud: PointCloud, path: str) -> None:
    """Write points and their attributes in binary."""
    vertices: _Columns = {"x y z": ("<f8", cloud.points)}
    if cloud.normals is not None:
        vertices["nx ny nz"] = ("<f4", cloud.normals)
    if cloud.colors is not None:
        vertices["red green blue"] = ("u1", cloud.colors)
    if cloud.distances is not None:
        vertices["distance"] = ("<f8", cloud.distances[:, None])
    with open(path, "wb") as file:
        _write_head(file, len(cloud), vertices, cloud.unit)
        _write_vertices(file, vertices)


def _write_head(
    file: BinaryIO, count: int, vertices: _Columns, unit: str | None, faces: int | None = None
) -> None:
    words = {"<f8": "double", "<f4": "float", "u1": "uchar"}
    lines = [
        "ply",
        "format binary_little_endian 1.0",
        "comment neurbs",
        *([] if unit is None else [f"comment unit {' '.join(unit.split())}"]),
        f"element vertex {count}",
        *(
            f"property {words[dtype]} {name}"
            for names, (dtype, _) in vertices.items()
            for name in names.split()
        ),
    ]
    if faces is not None:
        lines += [f"element face {faces}", "property list uchar int vertex_indices"]
    file.write("\n".join([*lines, "end_header\n"]).encode("ascii", "backslashreplace"))


def _write_vertices(file: BinaryIO, vertices: _Columns) -> None:
    fields = [(names, dtype, len(names.split())) for names, (dtype, _) in vertices.items()]
    record = np.dtype([(names, dtype, (width,)) for names, dtype, width in fields])
    write_rows(file, record, {names: values for names, (_, values) in vertices.items()})
