"""The binary form of openNURBS objects: rhino3dm neither makes joined faces nor shows their trims.

The layout is that of `ON_Brep::Write` in openNURBS, version 3.3, in an archive of version 60:
nested chunks of a type, a length and bytes, most with a checksum.
"""

from __future__ import annotations

import base64
import struct
import zlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError, NurbsCurve

_ANONYMOUS, _OBJECT, _CLASS, _DATA, _END = 0x40008000, 0x27FFA, 0x2FFFB, 0x2FFFC, 0x80027FFF
"""Types of chunks."""

_CURVE = bytes.fromhex("ddd4d74e47e9d311bfe50010830122f0")
_BREP = bytes.fromhex("c5dbb56060e6d311bfe40010830122f0")
"""Identifiers of the classes `ON_NurbsCurve` and `ON_Brep`."""

_VERSION = 0x33
"""Major and minor version of the data of a Brep."""

_EMPTY_BOX = (1.0, 0.0, 0.0, -1.0, 0.0, 0.0)
_UNSET = -1.23432101234321e308
"""Values of a box and a number that are not set."""

_HEAD = {"version": 10000, "archive3dm": 60, "opennurbs": -1869833980}
"""What rhino3dm writes beside the bytes of an object."""

Interval = tuple[float, float]
Item = TypeVar("Item")


@dataclass(frozen=True)
class Trim:
    """A part of a loop: its curve in (u, v), and the edge on it, or -1 at a pole."""

    curve: int
    domain: Interval
    edge: int
    vertices: tuple[int, int]
    is_reversed: bool
    kind: int
    iso: int
    loop: int
    is_curve_reversed: bool = False


@dataclass(frozen=True)
class Loop:
    """A loop: its trims, its kind (1 outer, 2 inner) and its face."""

    trims: list[int]
    kind: int
    face: int


@dataclass(frozen=True)
class BrepFace:
    """A face: its loops, its surface, and whether its normals are opposite to the surface's."""

    loops: list[int]
    surface: int
    is_reversed: bool


@dataclass(frozen=True)
class Edge:
    """An edge: the domain of its curve in space, which has its number, its ends and its trims."""

    domain: Interval
    vertices: tuple[int, int]
    trims: list[int]


@dataclass
class BrepData:
    """The parts of a Brep. Objects are the bytes of curves and surfaces."""

    plane_curves: list[bytes] = field(default_factory=list)
    space_curves: list[bytes] = field(default_factory=list)
    surfaces: list[bytes] = field(default_factory=list)
    vertices: list[tuple[float, ...]] = field(default_factory=list)
    edges: list[Edge] = field(default_factory=list)
    trims: list[Trim] = field(default_factory=list)
    loops: list[Loop] = field(default_factory=list)
    faces: list[BrepFace] = field(default_factory=list)


# Writing


def curve_bytes(curve: NurbsCurve, dimension: int) -> bytes:
    """Return the bytes of a clamped curve in the plane or in space."""
    points = curve.control_points[:, :dimension]
    rational = curve.weights is not None
    if curve.weights is not None:
        points = np.column_stack([points * curve.weights[:, None], curve.weights])
    knots = curve.knots[1:-1]  # openNURBS omits the first and the last, which have no effect.
    return _object(
        _CURVE,
        b"\x11"
        + _ints(dimension, rational, curve.degree + 1, len(points), 0, 0)
        + _reals(*_EMPTY_BOX)
        + _ints(len(knots))
        + _reals(*knots)
        + _ints(len(points))
        + _reals(*points.ravel())
        + b"\0",
    )


def object_bytes(theirs: Any) -> bytes:
    """Return the bytes of an object of rhino3dm."""
    return base64.b64decode(theirs.Encode()["data"])


def brep_dict(brep: BrepData, tolerance: float, box: Iterable[float], *, solid: bool) -> Any:
    """Return the dict from which `rhino3dm.Brep.Decode` makes a Brep."""
    of_vertex: list[list[int]] = [[] for _ in brep.vertices]
    for e, edge in enumerate(brep.edges):
        for vertex in edge.vertices:
            of_vertex[vertex].append(e)
    vertices = [
        _ints(k) + _reals(*place) + _indices(edges) + _reals(tolerance)
        for k, (place, edges) in enumerate(zip(brep.vertices, of_vertex, strict=True))
    ]
    edges = [
        _ints(e, e, 0)
        + _reals(*edge.domain)
        + _ints(*edge.vertices)
        + _indices(edge.trims)
        + _reals(tolerance, *edge.domain)
        for e, edge in enumerate(brep.edges)
    ]
    trims = [
        _ints(t, trim.curve)
        + _reals(*trim.domain)
        + _ints(trim.edge, *trim.vertices, trim.is_reversed, trim.kind, trim.iso, trim.loop)
        + _reals(0, 0, *trim.domain)
        + bytes(32)
        + _reals(_UNSET, _UNSET)
        for t, trim in enumerate(brep.trims)
    ]
    loops = [
        _ints(k) + _indices(loop.trims) + _ints(loop.kind, loop.face)
        for k, loop in enumerate(brep.loops)
    ]
    faces = [
        _ints(k) + _indices(face.loops) + _ints(face.surface, face.is_reversed, 0)
        for k, face in enumerate(brep.faces)
    ]
    objects = (brep.plane_curves, brep.space_curves, brep.surfaces)
    no_meshes = _chunk(_ANONYMOUS, bytes(len(faces)))
    data = (
        bytes([_VERSION])
        + b"".join(_array([_ints(1) + each for each in kind]) for kind in objects)
        + b"".join(_array(kind) for kind in (vertices, edges, trims, loops))
        # After the faces an identifier of each, not set.
        + _chunk(_ANONYMOUS, b"\x11" + _ints(len(faces)) + b"".join(faces) + bytes(16 * len(faces)))
        + _reals(*box)
        + no_meshes
        + no_meshes
        + _ints(1 if solid else 3)
        + _chunk(_ANONYMOUS, _ints(1, 1) + b"\0")  # No regions.
    )
    return {**_HEAD, "data": base64.b64encode(_object(_BREP, data)).decode()}


def _chunk(kind: int, body: bytes, *, checked: bool = True) -> bytes:
    if checked:
        body += struct.pack("<I", zlib.crc32(body))
    return struct.pack("<Iq", kind, len(body)) + body


def _object(identifier: bytes, data: bytes) -> bytes:
    end = struct.pack("<Iq", _END, 0)
    return _chunk(_OBJECT, _chunk(_CLASS, identifier) + _chunk(_DATA, data) + end, checked=False)


def _array(items: list[bytes]) -> bytes:
    return _chunk(_ANONYMOUS, b"\x10" + _ints(len(items)) + b"".join(items))


def _ints(*values: int) -> bytes:
    return struct.pack(f"<{len(values)}i", *values)


def _indices(values: list[int]) -> bytes:
    return _ints(len(values), *values)


def _reals(*values: float) -> bytes:
    return struct.pack(f"<{len(values)}d", *values)


# Reading


def read_brep(encoded: dict[str, Any]) -> BrepData:
    """Return the parts of a Brep from what its `Encode` returns; without edges and vertices.

    Raises
    ------
    NeurbsError
        If the data are of another version.
    """
    whole = _Bytes(base64.b64decode(encoded["data"]))
    chunks = whole.chunk(_OBJECT)
    chunks.chunk(_CLASS)
    data = chunks.chunk(_DATA)
    version = data.take(1)[0]
    if version >> 4 != _VERSION >> 4:
        raise NeurbsError(f"a Brep must be of version 3, got {version >> 4}")
    plane_curves, _, surfaces = (data.array(_Bytes.embedded) for _ in range(3))
    for _ in ("vertices", "edges"):
        data.chunk(_ANONYMOUS)
    trims = data.array(_Bytes.trim)
    loops = data.array(_Bytes.loop)
    faces = data.array(_Bytes.face)
    return BrepData(plane_curves, [], surfaces, [], [], trims, loops, faces)


def decodable(data: bytes, encoded: dict[str, Any]) -> dict[str, Any]:
    """Return the dict from which rhino3dm makes an object that is a part of another one."""
    return {**encoded, "data": base64.b64encode(data).decode()}


class _Bytes:
    """Bytes that are read one after the other."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._at = 0

    def take(self, size: int) -> bytes:
        taken = self._data[self._at : self._at + size]
        if size < 0 or len(taken) < size:
            raise NeurbsError("a Brep must be whole, but its data end early")
        self._at += size
        return taken

    def ints(self, count: int) -> tuple[int, ...]:
        return struct.unpack(f"<{count}i", self.take(4 * count))

    def reals(self, count: int) -> NDArray[np.float64]:
        return np.frombuffer(self.take(8 * count), "<f8")

    def indices(self) -> list[int]:
        (count,) = self.ints(1)
        return list(self.ints(count))

    def chunk(self, kind: int) -> _Bytes:
        found, size = struct.unpack("<Iq", self.take(12))
        if found != kind:
            raise NeurbsError(f"a chunk of type {kind:#x} must follow, got {found:#x}")
        return _Bytes(self.take(size))

    def array(self, read: Callable[[_Bytes], Item]) -> list[Item]:
        chunk = self.chunk(_ANONYMOUS)
        chunk.take(1)  # The version.
        (count,) = chunk.ints(1)
        return [read(chunk) for _ in range(count)]

    def embedded(self) -> bytes:
        (exists,) = self.ints(1)
        if not exists:
            return b""
        start = self._at
        self.chunk(_OBJECT)
        return self._data[start : self._at]

    def trim(self) -> Trim:
        _, curve = self.ints(2)
        first, last = self.reals(2).tolist()
        edge, start, end, is_reversed, kind, iso, loop = self.ints(7)
        self.reals(4)  # Tolerances, and the domain of the trim.
        is_curve_reversed = self.take(32)[0] != 0
        self.reals(2)
        ends = (start, end)
        return Trim(
            curve, (first, last), edge, ends, bool(is_reversed), kind, iso, loop, is_curve_reversed
        )

    def loop(self) -> Loop:
        self.ints(1)
        trims = self.indices()
        kind, face = self.ints(2)
        return Loop(trims, kind, face)

    def face(self) -> BrepFace:
        self.ints(1)
        loops = self.indices()
        surface, is_reversed, _ = self.ints(3)
        return BrepFace(loops, surface, bool(is_reversed))
