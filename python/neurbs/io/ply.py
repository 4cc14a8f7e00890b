"""PLY files: reader of vertices; writer of meshes and points in double precision.

The vertex table is read here, because mesh libraries merge, drop or reorder vertices.
"""

from __future__ import annotations

import struct
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import chain, islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, TypeAlias

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.io.point_cloud import BLOCK, Block, PointCloud, PointSource, Request, checked_count
from neurbs.io.reading import check_size, damaged
from neurbs.io.row_blocks import write_rows
from neurbs.io.table import Layout, numbered_lines, read_blocks, shown
from neurbs.io.units import symbol

if TYPE_CHECKING:
    from neurbs import TriangleMesh

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8",
    "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "int64": "i8", "uint64": "u8", "float32": "f4", "float64": "f8",
}  # fmt: skip
"""For each type of PLY, by its old and its new name, the type of NumPy."""

_CODES = {
    "i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "i8": "q", "u8": "Q",
    "f4": "f", "f8": "d",
}  # fmt: skip
"""For each type of NumPy the code of `struct`."""

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
class _Element:
    """One table of the file: number of rows, names and types of columns."""

    name: str
    count: int
    properties: list[tuple[str, str]] = field(default_factory=list)
    lists: dict[int, str] = field(default_factory=dict)
    """For each property that is a list, by its number, the type of its length."""

    def columns(self, names: tuple[tuple[str, ...], ...]) -> tuple[int, ...]:
        """Return the indices of columns by one of their names, or () if one is missing."""
        present = [name for name, _ in self.properties]
        found = [present.index(name) for known in names for name in known if name in present]
        return tuple(found) if len(found) == len(names) else ()

    def is_whole(self, words: list[str]) -> bool:
        """Whether a row of text has all its words."""
        place = 0
        for i in range(len(self.properties)):
            if place >= len(words):
                return False
            place += 1 + (int(float(words[place])) if i in self.lists else 0)
        return place <= len(words)

    def row(self, byte_order: str) -> np.dtype[np.void]:
        """Return the type of a row, with columns named by number, because names may repeat."""
        return np.dtype([(str(i), byte_order + t) for i, (_, t) in enumerate(self.properties)])


@dataclass
class _Header:
    byte_order: str
    """Empty for a text file."""
    elements: list[_Element]
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
    if vertex.lists or not points:
        axes = [name for i, (name, _) in enumerate(vertex.properties) if i not in vertex.lists]
        lists = " and lists" if vertex.lists else ""
        raise NeurbsError(
            f"{path}: vertices must have properties x, y and z and no lists, but have {axes}{lists}"
        )
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
    path: Path, header: _Header, before: list[_Element], after: list[_Element]
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
    path: Path, header: _Header, before: list[_Element], after: list[_Element]
) -> Iterator[Block]:
    """Check that the tables after the vertices are whole; yields nothing."""
    data = np.memmap(path, np.uint8, mode="r")
    place = header.size + sum(e.count * e.row(header.byte_order).itemsize for e in before)
    for element in after:
        for start in range(0, element.count, BLOCK):
            rows = min(BLOCK, element.count - start)
            place = _end_of_rows(data, place, rows, element, header.byte_order)
            if not 0 <= place <= len(data):
                raise damaged(path, f"it is cut short in the rows of {element.name}")
    yield from ()


def _end_of_rows(
    data: NDArray[np.uint8], place: int, rows: int, element: _Element, byte_order: str
) -> int:
    """Return the place after some rows; -1 if they are cut short."""
    kinds = [
        (np.dtype(kind).itemsize, struct.Struct((byte_order or "=") + _CODES[length]))
        if (length := element.lists.get(i))
        else (np.dtype(kind).itemsize, None)
        for i, (_, kind) in enumerate(element.properties)
    ]

    def end(start: int) -> tuple[int, list[tuple[int, int]]]:
        """Return the end of a row, and where in it the lists are, with their lengths."""
        at, found = start, []
        for size, length in kinds:
            if length is None:
                at += size
                continue
            if at + length.size > len(data):
                return -1, []
            (number,) = length.unpack_from(data.data, at)
            if number < 0:
                return -1, []
            found.append((at - start, int(number)))
            at += length.size + size * int(number)
        return at, found

    after, lists = end(place)
    size = after - place
    # Nearly always all rows have the same size.
    if size > 0 and place + rows * size <= len(data):
        table = data[place : place + rows * size].reshape(rows, size)
        lengths = [length for _, length in kinds if length is not None]
        if all(
            (table[:, at : at + length.size] == table[0, at : at + length.size]).all()
            for (at, _), length in zip(lists, lengths, strict=True)
        ):
            return place + rows * size
    for _ in range(rows):
        place, _ = end(place)
        if not 0 <= place <= len(data):
            return -1
    return place


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
                    header.elements.append(_Element(name, int(count)))
                case ["property", "list", length, kind, name]:
                    element = header.elements[-1]
                    element.lists[len(element.properties)] = _TYPES[length]
                    element.properties.append((name, _TYPES[kind]))
                case ["property", kind, name]:
                    header.elements[-1].properties.append((name, _TYPES[kind]))
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
    path: Path, header: _Header, before: list[_Element], vertex: _Element, layout: Layout
) -> Iterator[Block]:
    start = sum(element.count for element in before)

    def rows() -> Iterator[tuple[int, str]]:
        body = islice(numbered_lines(path), header.lines, None)
        rows = ((number, text) for number, text in body if text.strip())
        yield from islice(rows, start, start + vertex.count)

    return read_blocks(path, rows, layout)


def _binary(
    path: Path, header: _Header, before: list[_Element], vertex: _Element, layout: Layout
) -> Iterator[Block]:
    for element in before:
        if element.lists:
            raise NeurbsError(
                f"{path}: vertices must come before elements with lists, but {element.name!r} "
                "comes first: save the file again in another order"
            )
    record = vertex.row(header.byte_order)

    def columns(table: NDArray[np.void], places: tuple[int, ...]) -> NDArray[Any] | None:
        return np.column_stack([table[str(i)] for i in places]) if places else None

    with path.open("rb") as file:
        file.seek(header.size + sum(e.count * e.row(header.byte_order).itemsize for e in before))
        for start in range(0, vertex.count, BLOCK):
            table = np.fromfile(file, record, min(BLOCK, vertex.count - start))
            if not len(table):
                return
            points = np.column_stack([table[str(i)] for i in layout.points])
            yield Block(points, columns(table, layout.normals), columns(table, layout.colors))


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
