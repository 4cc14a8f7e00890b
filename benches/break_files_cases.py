"""Small valid files of every format that neurbs reads, and their damages, for ``break_files.py``.

They hold 60 points, a mesh of 5 x 4 vertices, one surface, or the six faces of a box. A file is
the same each time, but for the identifiers and dates in Rhino's.
"""

import base64
import datetime
import gzip
import json
import re
import struct
import warnings
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import neurbs
from neurbs.io import LOADABLE, READABLE

NUMBERS = ("0", "-1", "1000000000", "2147483647", "9223372036854775808", "nan")

Rng = np.random.Generator
Damage = tuple[bytes, str, int | None]
"""The damaged content, how it was damaged, and where it was cut."""

# Valid files

POINTS = np.random.default_rng(0).integers(0, 10**6, (60, 3)) / 1000
NORMALS = np.tile([0.0, 0.6, 0.8], (60, 1))
COLORS = np.random.default_rng(1).integers(0, 256, (60, 3)).astype(np.uint8)
CLOUD = neurbs.PointCloud(POINTS, NORMALS, COLORS)


def surface() -> neurbs.NurbsSurface:
    rng = np.random.default_rng(2)
    x, y = np.meshgrid(np.linspace(0, 30, 5), np.linspace(0, 20, 4), indexing="ij")
    net = np.stack([x, y, 9 * rng.random((5, 4))], axis=-1)
    return neurbs.NurbsSurface(net, rng.uniform(0.5, 2, (5, 4)), (3, 2))


def write_grid(path: Path) -> None:
    head = "ncols 10\nnrows 6\nxllcorner 5\nyllcorner 7\ncellsize 2.5\nNODATA_value -9999\n"
    rows = POINTS[:, 2].reshape(6, 10).tolist()
    path.write_text(head + "".join(" ".join(map(repr, row)) + "\n" for row in rows))


def write_pts(path: Path) -> None:
    rows = np.column_stack([POINTS, np.full(60, 99), COLORS]).tolist()
    path.write_text(
        "60\n" + "".join("{} {} {} {:.0f} {:.0f} {:.0f} {:.0f}\n".format(*r) for r in rows)
    )


def write_grass(path: Path) -> None:
    head = "north: 20\nsouth: 8\neast: 25\nwest: 5\nrows: 6\ncols: 10\nnull: -9999\n"
    rows = POINTS[:, 2].reshape(6, 10).tolist()
    path.write_text(head + "".join(" ".join(map(repr, row)) + "\n" for row in rows))


def write_survey(path: Path) -> None:
    rows = [f"{i},{x},{y},{z},P{i}" for i, (x, y, z) in enumerate(POINTS.tolist(), start=1)]
    path.write_text("Survey\nNo,East,North,Height,Code\n,m,m,m,\n" + "\n".join(rows) + "\n")


def write_ptx(path: Path) -> None:
    head = "10\n3\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 1 0 0\n-1 0 0 0\n0 0 1 0\n5 6 7 1\n"
    rows = np.column_stack([POINTS, np.full(60, 0.5), COLORS]).tolist()
    lines = ["{} {} {} {} {:.0f} {:.0f} {:.0f}\n".format(*row) for row in rows]
    path.write_text(head + "".join(lines[:30]) + head + "".join(lines[30:]))


def write_lists(path: Path) -> None:
    """Write a PLY file with a list of 0 to 2 numbers in each vertex."""
    head = (
        "ply\nformat binary_little_endian 1.0\nelement vertex 60\nproperty list uchar int seen\n"
        "property double x\nproperty double y\nproperty double z\nend_header\n"
    )
    rows = [bytes([i % 3]) + bytes(4 * (i % 3)) + point.tobytes() for i, point in enumerate(POINTS)]
    path.write_bytes(head.encode() + b"".join(rows))


def write_fields(path: Path) -> None:
    table = np.zeros(60, [("label", "U2"), *((axis, "f8") for axis in "xyz")])
    for i, axis in enumerate("xyz"):
        table[axis] = POINTS[:, i]
    np.save(path, table)


def write_packed(path: Path) -> None:
    """Write a packed table, or a packed cloud with attributes."""
    if path.suffix == ".gz":
        path.write_bytes(
            gzip.compress(
                "".join(f"{x} {y} {z}\n" for x, y, z in POINTS.tolist()).encode(), mtime=0
            )
        )
        return
    from backports import zstd

    inner = path.with_suffix(".ply")
    neurbs.save(CLOUD, inner)
    path.write_bytes(zstd.compress(inner.read_bytes()))
    inner.unlink()


def write_gltf(path: Path) -> None:
    """Write a mesh whose buffer is in the file."""
    mesh = surface().tessellate(shape=(5, 4)).to_trimesh()
    parts = mesh.scene().export(file_type="gltf", merge_buffers=True)
    document = json.loads(parts["model.gltf"])
    for buffer in document["buffers"]:
        data = base64.b64encode(parts[buffer["uri"]]).decode()
        buffer["uri"] = f"data:application/octet-stream;base64,{data}"
    path.write_text(json.dumps(document))


def write_3mf(path: Path) -> None:
    scene = surface().tessellate(shape=(5, 4)).to_trimesh().scene()
    path.write_bytes(scene.export(file_type="3mf"))


def write_nodes(path: Path) -> None:
    import pyvista

    if path.suffix == ".vti":
        data: Any = pyvista.ImageData(dimensions=(5, 4, 3), spacing=(1, 2, 3), origin=(5, 6, 7))
    else:
        data = pyvista.StructuredGrid(*(POINTS[:, i].reshape(5, 4, 3) for i in range(3)))
    data["height"] = np.arange(60.0)
    data.save(path, binary=False)


def write_trimesh(path: Path, **options: Any) -> None:
    surface().tessellate(shape=(5, 4)).to_trimesh().export(path, **options)


def write_las(path: Path) -> None:
    import laspy

    header = laspy.LasHeader(point_format=3, version="1.2")
    header.scales, header.creation_date = np.full(3, 0.001), datetime.date(2020, 1, 1)
    scan = laspy.LasData(header)
    scan.x, scan.y, scan.z = POINTS.T
    scan.red, scan.green, scan.blue = COLORS.T.astype(np.uint16) * 257
    scan.write(path)


def write_e57(path: Path) -> None:
    import pye57

    columns = {f"cartesian{axis}": POINTS[:, i].copy() for i, axis in enumerate("XYZ")}
    colors = {f"color{c}": COLORS[:, i].copy() for i, c in enumerate(("Red", "Green", "Blue"))}
    with pye57.E57(str(path), mode="w") as file:
        file.write_scan_raw({**columns, **colors})


def write_pcd(path: Path, encoding: str) -> None:
    from pypcd4 import Encoding, PointCloud

    red, green, blue = COLORS.astype(np.uint32).T
    rgb = ((red << 16) + (green << 8) + blue).view(np.float32)
    points = np.column_stack([POINTS, rgb]).astype(np.float32)
    PointCloud.from_xyzrgb_points(points).save(path, encoding=Encoding(encoding))


def write_vtk(path: Path, mode: str) -> None:
    from vtkmodules import vtkIOLegacy, vtkIOXML
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData, vtkUnstructuredGrid

    cells = vtkCellArray()
    for first in range(len(POINTS) - 2):
        cells.InsertNextCell(3, (first, first + 1, first + 2))
    places = vtkPoints()
    places.SetData(numpy_to_vtk(POINTS, deep=1))
    data = vtkPolyData() if path.suffix == ".vtk" else vtkUnstructuredGrid()
    data.SetPoints(places)
    data.GetPointData().SetNormals(numpy_to_vtk(NORMALS, deep=1))
    if path.suffix == ".vtk":
        data.SetPolys(cells)
        writer = vtkIOLegacy.vtkPolyDataWriter()
        (writer.SetFileTypeToASCII if mode == "ascii" else writer.SetFileTypeToBinary)()
    else:
        data.SetCells(5, cells)
        writer = vtkIOXML.vtkXMLUnstructuredGridWriter()
        (writer.SetDataModeToAscii if mode == "ascii" else writer.SetDataModeToAppended)()
        writer.EncodeAppendedDataOff()
        (writer.SetCompressorTypeToZLib if mode == "zlib" else writer.SetCompressorTypeToNone)()
    writer.SetInputData(data)
    writer.SetFileName(str(path))
    writer.Write()


def write_tif(path: Path) -> None:
    import rasterio

    shape = {"height": 6, "width": 10, "count": 1, "dtype": "float64", "crs": "EPSG:32633"}
    transform = rasterio.transform.from_origin(5, 8, 2, 2)
    with rasterio.open(path, "w", driver="GTiff", transform=transform, **shape) as file:
        file.write(POINTS[:, 2].reshape(6, 10), 1)


def write_box(path: Path) -> None:
    """Write the six faces of a box, as another program does."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
    from OCP.IGESControl import IGESControl_Controller, IGESControl_Writer
    from OCP.Message import Message
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

    messenger = Message.DefaultMessenger_s()
    for printer in list(messenger.Printers()):
        messenger.RemovePrinter(printer)
    shape = BRepPrimAPI_MakeBox(10.0, 20.0, 30.0).Shape()
    if path.suffix == ".step":
        step = STEPControl_Writer()
        step.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
        step.Write(str(path))
    else:
        IGESControl_Controller.Init_s()
        iges = IGESControl_Writer("MM", 1)
        iges.AddShape(shape)
        iges.Write(str(path))


def write_mesh(path: Path) -> None:
    neurbs.save(surface().tessellate(shape=(5, 4)), path)


def write_surface(path: Path) -> None:
    neurbs.save(surface(), path)


def write_table(path: Path) -> None:
    np.savetxt(path, POINTS, fmt="%.3f", header="x y z", comments="# " if path.suffix else "")


FORMATS: dict[str, Callable[[Path], object]] = {
    ".xyz": write_table,
    ".txt": lambda path: np.savetxt(path, POINTS, fmt="%.3f", delimiter="\t", header="x\ty\tz"),
    ".csv": lambda path: neurbs.save(CLOUD, path),
    "table.asc": write_table,
    "grid.asc": write_grid,
    "grass.asc": write_grass,
    "survey.csv": write_survey,
    ".dat": write_survey,
    ".xyzrgb": lambda path: np.savetxt(path, np.column_stack([POINTS, COLORS]), fmt="%.3f"),
    ".xyzn": lambda path: np.savetxt(path, np.column_stack([POINTS, NORMALS]), fmt="%.3f"),
    ".pts": write_pts,
    ".ptx": write_ptx,
    "xyz.gz": write_packed,
    "ply.zst": write_packed,
    "fields.npy": write_fields,
    "lists.ply": write_lists,
    ".npy": lambda path: np.save(path, POINTS),
    ".npz": lambda path: np.savez_compressed(path, points=POINTS),
    "ascii.ply": lambda path: write_trimesh(path, encoding="ascii"),
    "mesh.ply": write_mesh,
    "cloud.ply": lambda path: neurbs.save(CLOUD, path),
    ".obj": write_mesh,
    "ascii.stl": lambda path: write_trimesh(path, file_type="stl_ascii"),
    "binary.stl": write_mesh,
    ".off": write_mesh,
    ".glb": write_mesh,
    ".gltf": write_gltf,
    ".dae": write_trimesh,
    ".3mf": write_3mf,
    ".las": write_las,
    ".laz": write_las,
    ".e57": write_e57,
    "ascii.pcd": lambda path: write_pcd(path, "ascii"),
    "binary.pcd": lambda path: write_pcd(path, "binary"),
    "compressed.pcd": lambda path: write_pcd(path, "binary_compressed"),
    "ascii.vtk": lambda path: write_vtk(path, "ascii"),
    "binary.vtk": lambda path: write_vtk(path, "binary"),
    ".vtp": write_mesh,
    "ascii.vtu": lambda path: write_vtk(path, "ascii"),
    "raw.vtu": lambda path: write_vtk(path, "raw"),
    "zlib.vtu": lambda path: write_vtk(path, "zlib"),
    ".vti": write_nodes,
    ".vts": write_nodes,
    ".tif": write_tif,
    ".json": write_surface,
    ".3dm": write_surface,
    ".step": write_surface,
    "box.step": write_box,
    ".iges": write_surface,
    "box.iges": write_box,
}
ENDLESS = {".xyz", ".txt", ".csv", "survey.csv", ".dat", ".xyzrgb", ".xyzn", "table.asc", ".obj"}
"""Formats without end mark and count: a cut cannot be seen."""
COUNTED_TEXT = {
    "grid.asc", "grass.asc", ".pts", ".ptx", "ascii.ply", ".off", "ascii.pcd", "ascii.vtk",
}  # fmt: skip
"""Text without end mark: a cut can be seen if it takes a whole word."""


_DATES = re.compile(rb"(?<=\d{2}H)\d{8}\.\d{6}|\d{4}-\d\d-\d\dT[\d:]{8}|(?<=\[{)[-0-9a-f]{36}(?=})")
"""Dates in STEP and IGES files, identifiers in E57 files."""

_PAGE = 1024
"""Bytes of a page of an E57 file, of which the last four are a checksum of the others."""


def content_of(name: str, folder: Path) -> bytes:
    """Write the valid file of a format, and return its content."""
    path = folder / f"valid{suffix_of(name)}"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        FORMATS[name](path)
    content = path.read_bytes()
    path.unlink()
    if name in (".e57", "box.step", "box.iges"):
        content = _DATES.sub(lambda found: re.sub(rb"[0-9a-f]", b"1", found.group()), content)
    return sealed(content) if name == ".e57" else content


def sealed(content: bytes) -> bytes:
    """Give each page of an E57 file the checksum that its bytes have: CRC-32C, big-endian."""
    pages = [content[start : start + _PAGE - 4] for start in range(0, len(content), _PAGE)]
    return b"".join(page + _crc(page).to_bytes(4, "big") for page in pages)


def _crc(page: bytes) -> int:
    value = 0xFFFFFFFF
    for byte in page:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0x82F63B78 if value & 1 else 0)
    return value ^ 0xFFFFFFFF


def suffix_of(name: str) -> str:
    return "." + name.rpartition(".")[2]


def is_cut(name: str, content: bytes, place: int) -> bool:
    """Whether the start of a file, up to a place, is no complete file of its format."""
    if name in ENDLESS:
        return False
    # Sections that nothing before them announces: without them a file is complete.
    optional = {".vtk": (b"\nPOLYGONS ", b"\nPOINT_DATA "), ".ptx": (b"\n10\n3\n",)}.get(
        suffix_of(name), ()
    )
    ends = [content.index(section) + 1 for section in optional]
    return not any(_last_word(name, content[:end]) <= place <= end for end in ends) and (
        place < _last_word(name, content)
    )


def _last_word(name: str, content: bytes) -> int:
    """Return the end of a complete file without blanks, and of text without its last word."""
    end = len(content.rstrip(b"\n\r "))
    if name in COUNTED_TEXT:
        return max(content.rfind(b"\n", 0, end), content.rfind(b" ", 0, end))
    if name == "binary.vtk":
        # The last byte of an array may be that of a blank.
        return len(content) - content.endswith(b"\n")
    # The last number of an IGES file repeats what is known.
    return end - 7 if suffix_of(name) == ".iges" else end


# Damages


def flip_bits(content: bytes, rng: Rng) -> Damage:
    damaged, places = bytearray(content), rng.integers(0, 8 * len(content), rng.integers(1, 9))
    for place in places:
        damaged[place // 8] ^= 1 << (place % 8)
    return bytes(damaged), f"bits {sorted(places.tolist())} flipped", None


def cut(content: bytes, rng: Rng) -> Damage:
    end = int(rng.integers(0, len(content)))
    return content[:end], f"cut at {end} of {len(content)}", end


def cut_at_structure(content: bytes, rng: Rng) -> Damage:
    """Cut before or after a line, a tag or a section, at a round number, or near the end."""
    lines = [m.end() for m in re.finditer(rb"[\n;>}\]]", content)]
    steps = range(0, len(content), int(2 ** rng.integers(2, 8)))
    near_end = range(max(len(content) - 64, 0), len(content))
    places = [place for place in (lines, steps, near_end)[rng.integers(3)] if place < len(content)]
    end = int(rng.choice(places or [0])) - int(rng.integers(2))
    return content[: max(end, 0)], f"cut at {max(end, 0)} of {len(content)}", max(end, 0)


def replace_text_number(content: bytes, rng: Rng) -> Damage:
    numbers = list(re.finditer(rb"-?\d+(\.\d*)?([eE][-+]?\d+)?", content))
    if not numbers:
        return flip_bits(content, rng)
    # Half of the time a number of the header.
    number = numbers[rng.integers(min(len(numbers), 30) if rng.random() < 0.5 else len(numbers))]
    new = NUMBERS[rng.integers(len(NUMBERS))]
    damaged = content[: number.start()] + new.encode() + content[number.end() :]
    return damaged, f"{number.group()!r} at {number.start()} replaced by {new}", None


def replace_binary_number(content: bytes, rng: Rng) -> Damage:
    values: tuple[tuple[str, float], ...] = (
        *(("<i", value) for value in (0, -1, 10**9, 2**31 - 1)),
        *((">i", value) for value in (-1, 10**9, 2**31 - 1)),
        *(("<Q", value) for value in (0, 2**63, 2**64 - 1, 10**9)),
        ("<H", 0xFFFF), ("<d", float("nan")), ("<f", float("nan")), (">d", float("nan")),
    )  # fmt: skip
    kind, value = values[rng.integers(len(values))]
    new = struct.pack(kind, value)
    limit = min(len(content), 400) if rng.random() < 0.5 else len(content)
    place = int(rng.integers(max(limit - len(new), 1)))
    damaged = content[:place] + new + content[place + len(new) :]
    return damaged, f"{value} written as {kind} at {place}", None


def block(content: bytes, rng: Rng) -> tuple[int, int]:
    """Choose a line, some lines, or some bytes."""
    if rng.random() < 0.5 and content.count(b"\n") > 3:
        ends = [0, *(m.end() for m in re.finditer(rb"\n", content))]
        first = int(rng.integers(len(ends) - 1))
        return ends[first], ends[min(first + int(rng.integers(1, 5)), len(ends) - 1)]
    start = int(rng.integers(len(content)))
    return start, min(start + int(2 ** rng.integers(0, 10)), len(content))


def repeat(content: bytes, rng: Rng) -> Damage:
    start, end = block(content, rng)
    times = int(rng.choice([1, 2, 50]))
    damaged = content[:end] + content[start:end] * times + content[end:]
    return damaged, f"{start} to {end} repeated {times} times", None


def delete(content: bytes, rng: Rng) -> Damage:
    start, end = block(content, rng)
    return content[:start] + content[end:], f"{start} to {end} deleted", None


def swap(content: bytes, rng: Rng) -> Damage:
    (a, b), (c, d) = sorted([block(content, rng), block(content, rng)])
    b = min(b, c)
    damaged = content[:a] + content[c:d] + content[b:c] + content[a:b] + content[d:]
    return damaged, f"{a} to {b} and {c} to {d} swapped", None


def insert(content: bytes, rng: Rng) -> Damage:
    foreign = (
        b"\0",
        b"\0" * 16,
        b"\0" * 512,
        b"\xff\xfe",
        b"\xc3\x28",
        b"\x80\x81\x82",
        b"\xed\xa0\x80",
    )
    new = foreign[rng.integers(len(foreign))]
    place = int(rng.integers(len(content) + 1))
    shown = f"{new[:4]!r} × {len(new) // len(new[:4])}"
    return content[:place] + new + content[place:], f"{shown} inserted at {place}", None


DAMAGES: tuple[Callable[[bytes, Rng], Damage], ...] = (
    flip_bits, cut, cut_at_structure, cut_at_structure, replace_text_number, replace_text_number,
    replace_binary_number, replace_binary_number, repeat, delete, swap, insert,
)  # fmt: skip


def damaged_file(
    folder: Path, name: str, number: int, seed: int, content: bytes
) -> tuple[Path, str, int | None, bool]:
    """Write a case; return the file, its damage, its cut, and whether attributes are read."""
    rng = np.random.default_rng([seed, zlib.crc32(name.encode()), number])
    suffix, attributes = suffix_of(name), bool(rng.integers(2))
    if rng.random() < 0.03:
        other = [s for s in (*READABLE, *LOADABLE) if s != suffix]
        suffix = other[rng.integers(len(other))]
        how, end = f"suffix {suffix}", None
    else:
        content, how, end = DAMAGES[rng.integers(len(DAMAGES))](content, rng)
        if suffix == ".e57" and rng.random() < 0.7:
            # Or else nothing but the checksums is tested.
            content, how, end = sealed(content), f"{how}, checksums renewed", None
    path = folder / f"{name.replace('.', '-').strip('-')}-{seed}-{number}{suffix}"
    path.write_bytes(content)
    return path, how, end, attributes
