"""Files that are damaged, are cut short, are no files, or refer to other files."""

import gzip
import io
import os
import struct
import subprocess
import sys
import time
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import (
    vtkCellArray,
    vtkPolyData,
    vtkStructuredGrid,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkIOLegacy import (
    vtkPolyDataWriter,
    vtkStructuredGridWriter,
    vtkUnstructuredGridWriter,
)

import neurbs
from neurbs.io.table import numbered_lines

COUNT = 500

PCD = """VERSION 0.7
FIELDS x y z
SIZE 4 4 4
TYPE F F F
COUNT 1 1 1
WIDTH 2
HEIGHT 1
POINTS 2
DATA ascii
1 2 3
4 5 6
"""

GRID = "ncols 2\nnrows 2\nxllcorner 5\nyllcorner 7\ncellsize 2.5\n1 2\n3 4\n"


PTX = "1\n2\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1 2 3 0\n4 5 6 0\n"

GRASS = "north: 9\nsouth: 5\neast: 9\nwest: 5\nrows: 2\ncols: 2\n1 2\n3 4\n"


def npy() -> bytes:
    file = io.BytesIO()
    np.save(file, np.zeros((9, 3)))
    return file.getvalue()


def npz(compression: int = zipfile.ZIP_DEFLATED, *, old: bytes = b"", new: bytes = b"") -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", compression) as archive:
        archive.writestr("points.npy", npy())
    return file.getvalue().replace(old, new, 1) if old else file.getvalue()


# A local header of an archive has the method at 8, the central one at 10.
UNKNOWN_METHOD = bytearray(npz())
UNKNOWN_METHOD[8] = UNKNOWN_METHOD[npz().index(b"PK\x01\x02") + 10] = 77

# Likewise the flags are at 6 and 8; the first says that the array is encrypted.
ENCRYPTED = bytearray(npz())
ENCRYPTED[6] = ENCRYPTED[npz().index(b"PK\x01\x02") + 8] = 1

DAMAGED_LZMA = bytearray(npz(zipfile.ZIP_LZMA))
DAMAGED_LZMA[60:70] = bytes(10)

DAMAGED: dict[str, tuple[str, bytes, str]] = {
    "array as archive": (".npz", npy(), "must be a whole"),
    "unknown compression": (".npz", bytes(UNKNOWN_METHOD), "must be a whole"),
    "encrypted array": (".npz", bytes(ENCRYPTED), "must be a whole"),
    "points without end": (".pcd", PCD.replace("S 2", f"S {2**64}").encode(), "cut short"),
    "damaged LZMA": (".npz", bytes(DAMAGED_LZMA), "must be a whole"),
    "wrong checksum": (".npz", npz(0, old=b"\n" + bytes(8), new=b"\n" + bytes(7) + b"\1"), "CRC"),
    "array without end": (".npz", npz(0, old=b"(9, 3)", new=b"(99,3)"), "must be a whole"),
    "no numbers per field": (".pcd", PCD.replace("1 1 1", "1 0 1").encode(), "must start with"),
    "columns without end": (
        ".asc",
        GRID.replace("ncols 2", f"ncols {2**63}").encode(),
        "cut short",
    ),
    "quotation without end": (".csv", b'a,"' + b"b" * 140_000 + b'"\n1,2,3\n', "must be a whole"),
    "nested brackets": (".json", b"[" * 200_000, "must be"),
    "endless degree": (
        ".json",
        b'{"shape": {"type": "surface", "data": [{"control_points": {"points": [[0, 0, 0]]}, '
        b'"size_u": 1e999, "size_v": 1, "knotvector_u": [], "knotvector_v": []}]}}',
        "must be",
    ),
    "not UTF-8": (
        ".vtk",
        b"# vtk DataFile Version 3.0\n\xff\nASCII\nDATASET \xff\n",
        "must be a whole",
    ),
    "short scan": (".las", b"LASF" + bytes(90), "must be a whole"),
    "no numbers": (".off", b"OFF\n3 one 0\n", "must be a whole"),
    "scan of one byte": (".e57", b"A", "must be a whole"),
    "mesh of one byte": (".glb", b"g", "must be a whole"),
    "scans without end": (".ptx", PTX.replace("1\n2", f"1\n{10**20}", 1).encode(), "cut short"),
    "scan without rows": (".ptx", PTX.replace("1\n2", "1\n0", 1).encode(), "must start a scan"),
    "half a scan": (".ptx", PTX[:-10].encode(), "cut short after 1"),
    "rows without end": (".asc", GRASS.replace("s: 2", f"s: {10**20}").encode(), "cut short"),
    "half a grid": (".txt", GRASS[:-4].encode(), "cut short after 2"),
    "a count of points only": (".xyz", b"9" * 5000 + b"\n1 2 3\n", "must be a whole"),
    "no archive": (".gz", b"1 2 3\n", "must be a whole"),
    "half an archive": (".xyz.gz", gzip.compress(b"1 2 3\n" * 999)[:-9], "must be a whole"),
    "archive with a wrong checksum": (
        ".xyz.gz",
        gzip.compress(b"1 2 3\n" * 999)[:-8] + bytes(8),
        "must be a whole",
    ),
    "no archive of zstd": (".zst", b"1 2 3\n", "must be a whole"),
    "endless list": (
        ".ply",
        b"ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty list uint int l\n"
        b"property float x\nproperty float y\nproperty float z\nend_header\n" + b"\xff" * 20,
        "must be a whole",
    ),
    "nested JSON": (".gltf", b"[" * 10**6, "must be a whole"),
    "JSON of something else": (".gltf", b"[1, 2]", "must be a whole"),
    "deep XML": (".dae", b"<a>" * 10**6, "must be a whole"),
    "no zip": (".3mf", b"PK", "must be a whole"),
    "zip of something else": (".3mf", npz(), "must be a whole"),
    "image without end": (".vti", b"<VTKFile><ImageData/>", "must be a whole"),
}
"""By the kind of damage: suffix, content and message."""


@pytest.mark.parametrize("kind", DAMAGED)
def test_a_damaged_file_is_an_error_of_neurbs(kind: str, tmp_path: Path) -> None:
    suffix, content, message = DAMAGED[kind]
    path = tmp_path / f"a{suffix}"
    path.write_bytes(content)
    read: Callable[..., object] = neurbs.read_points
    if suffix == ".json":
        read = neurbs.load_surface
    with pytest.raises(neurbs.NeurbsError, match=message) as caught:
        read(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)
    if suffix != ".json":
        # Lazily read, too.
        with pytest.raises(neurbs.NeurbsError, match=message):
            list(neurbs.read_points(path, chunks=10))


def test_a_path_with_a_null_character_is_an_error_of_neurbs() -> None:
    for read in (neurbs.read_points, neurbs.load_surface):
        with pytest.raises(neurbs.NeurbsError, match=r"a\\x00b: must be a path"):
            read("a\0b")


def test_errors_about_the_file_itself_stay(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        neurbs.read_points(tmp_path / "a.csv")
    with pytest.raises(IsADirectoryError):
        neurbs.load_surface(tmp_path)


# What is no file


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")
@pytest.mark.parametrize("suffix", [".step", ".json", ".3dm", ".csv", ".npz", ".toml"])
def test_a_pipe_or_a_device_is_refused_at_once(suffix: str, tmp_path: Path) -> None:
    pipe, device = tmp_path / f"a{suffix}", tmp_path / f"b{suffix}"
    os.mkfifo(pipe)
    device.symlink_to("/dev/zero")
    for path in (pipe, device):
        words = (
            ["reconstruct", "a.csv", "-o", "b.step", "--config"] if suffix == ".toml" else ["info"]
        )
        done = subprocess.run(
            [sys.executable, "-m", "neurbs", *words, str(path)],
            capture_output=True,
            text=True,
            timeout=20,
        )
        assert "this is a device or a pipe" in done.stderr
        assert "Traceback" not in done.stderr


def test_settings_are_of_a_bounded_size(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    with path.open("wb") as file:
        file.truncate(10**9)
    done = subprocess.run(
        [sys.executable, "-m", "neurbs", "info", "a.csv", "--config", str(path)],
        capture_output=True,
        text=True,
        timeout=20,
    )
    assert "must be a file of at most 1,048,576 bytes" in done.stderr


def test_a_line_has_a_bounded_size(tmp_path: Path) -> None:
    path = tmp_path / "a.xyz"
    with path.open("wb") as file:
        file.truncate(10**9)
    with pytest.raises(neurbs.NeurbsError, match="line 1 has more than 16,777,216 characters"):
        neurbs.read_points(path)
    path.write_text("1 2 3\n\n4 5 6")
    assert list(numbered_lines(path)) == [(1, "1 2 3\n"), (2, "\n"), (3, "4 5 6")]


@pytest.mark.parametrize("line", [b"1 " * (7 << 20), b"a " * (1 << 20), b"#" * (1 << 20)])
def test_long_lines_packed_in_a_small_archive_take_no_memory(line: bytes, tmp_path: Path) -> None:
    path = tmp_path / "a.xyz.gz"
    path.write_bytes(gzip.compress((line + b"\n") * 4))
    with pytest.raises(neurbs.NeurbsError, match="line 1 has more than 65,536 characters"):
        neurbs.read_points(path)


def test_a_mesh_packed_in_a_small_archive_takes_no_memory(tmp_path: Path) -> None:
    path = tmp_path / "a.3mf"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("[Content_Types].xml", "<Types/>")
        with archive.open("3D/3dmodel.model", "w") as file:
            file.write(b'<model unit="inch"><resources><object id="1"><mesh><vertices>')
            for _ in range(300):
                file.write(b'<vertex x="0" y="0" z="0"/>' * 40_000)
    start = time.monotonic()
    with pytest.raises(neurbs.NeurbsError, match=r"a\.3mf: "):
        neurbs.read_points(path)
    assert time.monotonic() - start < 60


# Cut short


def saved_mesh(path: Path) -> None:
    net = np.stack([*np.indices((4, 5), float), np.ones((4, 5))], axis=-1)
    neurbs.save(neurbs.NurbsSurface(net).tessellate(shape=(4, 5)), path)


def text_ply(path: Path) -> None:
    rows = "".join(f"{x} {x * x} 5\n" for x in range(9))
    faces = "".join(f"{3 + x % 2} {x} {x + 1} {x + 2}{' 8' * (x % 2)}\n" for x in range(6))
    path.write_text(
        "ply\nformat ascii 1.0\nelement vertex 9\nproperty float x\nproperty float y\n"
        "property float z\nelement face 6\nproperty list uchar int vertex_indices\n"
        f"end_header\n{rows}{faces}"
    )


def mixed_ply(path: Path) -> None:
    rows = np.arange(27, dtype="<f4").tobytes()
    corners = [list(range(3 + x % 2)) for x in range(70)]
    faces = b"".join(struct.pack(f"<B{len(c)}i", len(c), *c) for c in corners)
    path.write_bytes(
        b"ply\nformat binary_little_endian 1.0\nelement vertex 9\nproperty float x\n"
        b"property float y\nproperty float z\nelement face 70\n"
        b"property list uchar int vertex_indices\nend_header\n" + rows + faces
    )


def vtk_text(path: Path) -> None:
    data, writer = poly_data()
    places = vtkPoints()
    places.SetData(numpy_to_vtk(np.arange(3.0 * COUNT).reshape(-1, 3), deep=1))
    data.SetPoints(places)
    data.GetPointData().SetNormals(numpy_to_vtk(np.ones((COUNT, 3)), deep=1))
    writer.SetInputData(data)
    writer.SetFileName(str(path))
    writer.Write()


@pytest.mark.parametrize(
    ("suffix", "write"),
    [
        (".ply", saved_mesh),
        (".ply", text_ply),
        (".ply", mixed_ply),
        (".off", saved_mesh),
        (".vtp", saved_mesh),
        (".vtk", vtk_text),
    ],
)
def test_a_cut_after_the_points_is_an_error(
    suffix: str, write: Callable[[Path], None], tmp_path: Path
) -> None:
    path = tmp_path / f"a{suffix}"
    write(path)
    whole = path.read_bytes()
    points = neurbs.read_points(path)
    assert len(points) in (9, 20, COUNT)
    end = len(whole.rstrip())
    if suffix in (".off", ".vtk") or write is text_ply:
        # Within the last number a cut cannot be seen.
        end = max(whole.rfind(b"\n", 0, end), whole.rfind(b" ", 0, end))
    ends = np.unique(np.linspace(len(whole) // 3, end - 1, 60).astype(int))
    for cut in ends:
        path.write_bytes(whole[:cut])
        if suffix == ".vtk" and whole[cut - 1 : cut + 1] == b"\nP":
            continue  # Before a section that nothing announces.
        with pytest.raises(neurbs.NeurbsError):
            neurbs.read_points(path)


def triangles() -> Any:
    cells = vtkCellArray()
    for first in range(COUNT - 2):
        cells.InsertNextCell(3, (first, first + 1, first + 2))
    return cells


def poly_data() -> tuple[Any, Any]:
    data = vtkPolyData()
    data.SetPolys(triangles())
    return data, vtkPolyDataWriter()


def unstructured_grid() -> tuple[Any, Any]:
    data = vtkUnstructuredGrid()
    data.SetCells(5, triangles())
    return data, vtkUnstructuredGridWriter()


def structured_grid() -> tuple[Any, Any]:
    data = vtkStructuredGrid()
    data.SetDimensions(COUNT // 10, 10, 1)
    return data, vtkStructuredGridWriter()


@pytest.mark.parametrize("version", [42, 51])
@pytest.mark.parametrize("kind", [poly_data, unstructured_grid, structured_grid])
def test_a_vtk_file_that_is_cut_short_is_an_error(
    kind: Callable[[], tuple[Any, Any]], version: int, tmp_path: Path, rng: np.random.Generator
) -> None:
    points = rng.random((COUNT, 3))
    data, writer = kind()
    places = vtkPoints()
    places.SetData(numpy_to_vtk(points, deep=1))
    data.SetPoints(places)
    attributes = data.GetPointData()
    for name, values in {
        "RGB": rng.integers(0, 255, (COUNT, 3)).astype(np.uint8),
        "number": rng.integers(0, 9, COUNT),
    }.items():
        array = numpy_to_vtk(values, deep=1)
        array.SetName(name)
        attributes.AddArray(array)
    attributes.SetNormals(numpy_to_vtk(rng.random((COUNT, 3)), deep=1))
    attributes.SetScalars(numpy_to_vtk(rng.random(COUNT).astype(np.float32), deep=1))
    path = tmp_path / "whole.vtk"
    writer.SetInputData(data)
    writer.SetFileName(str(path))
    writer.SetFileTypeToBinary()
    writer.SetFileVersion(version)
    writer.Write()
    np.testing.assert_array_equal(neurbs.read_points(path), points)
    whole = path.read_bytes()
    cut = tmp_path / "cut.vtk"
    for end in np.linspace(200, len(whole) - 3, 40).astype(int):
        cut.write_bytes(whole[:end])
        with pytest.raises(neurbs.NeurbsError, match=r"must be a whole \.vtk file"):
            neurbs.read_points(cut)


def test_a_vtk_file_has_what_its_last_line_announces(tmp_path: Path) -> None:
    head = "# vtk DataFile Version {0}\nmade by hand\nASCII\nDATASET {1}\n"
    rows = "POINTS 3 float\n0 0 0 1 0 0\n0 1 0\n"
    grid = head.format("3.0", "UNSTRUCTURED_GRID") + rows
    cells = "CELLS 1 4\n3 0 1 2\n"
    mesh = head.format("5.1", "POLYDATA") + rows
    path = tmp_path / "a.vtk"
    for missing in (
        grid + cells,
        grid + cells + "CELL_TYPES 1\n",
        grid + cells + "CELL_TYPES 1\n5\nPOINT_DATA 3\n",
        mesh + "POLYGONS 2 3\n",
        mesh + "POLYGONS 2 3\nOFFSETS vtktypeint64\n0 3\n",
        mesh + "POINT_DATA 3\n",
        mesh + "CELL_DATA 3\n\n",
        mesh + "POINT_DATA 3\nNORMALS n float\n",
        mesh + "POINT_DATA 3\nFIELD FieldData 1\n",
    ):
        path.write_text(missing)
        with pytest.raises(neurbs.NeurbsError, match="missing"):
            neurbs.read_points(path)
    for whole in (grid + cells + "CELL_TYPES 1\n5\n", mesh, mesh + "CELL_DATA 0\n"):
        path.write_text(whole)
        assert len(neurbs.read_points(path)) == 3


# Names that change what a terminal shows


@pytest.mark.skipif(os.name == "nt", reason="names of files have no control characters")
def test_control_characters_are_shown_escaped(tmp_path: Path) -> None:
    bad = "a\x1b[2J\x07\u202eb\nneurbs: done"
    shown = r"a\x1b[2J\x07\u202eb\nneurbs: done"
    files: dict[str, str | bytes] = {
        f"{bad}.csv": "1 2\n1\n",
        f"{bad}.json": "{",
        f"{bad}.strange": "",
        "a.csv": "\x1b[2J,x,\x07\n1,2,3\n",
        "a.pcd": PCD.replace("FIELDS x", "FIELDS \x1b[2Jx"),
        "a.ply": "ply\nformat \x1b[2J 1.0\n",
        "a.npz": b"",
    }
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("\x1b[2Ja.npy", npy())
        archive.writestr("b.npy", npy())
    files.pop("a.npz")
    for name, content in files.items():
        (tmp_path / name).write_text(str(content), newline="")
    for name in [*files, "a.npz"]:
        path = str(tmp_path / name)
        for words in (["info", path], ["reconstruct", path, path, "-o", str(tmp_path)]):
            done = subprocess.run(
                [sys.executable, "-m", "neurbs", *words], capture_output=True, timeout=60
            )
            assert done.returncode in (1, 2)
            text = done.stdout + done.stderr
            assert not set(text) & {0x1B, 7}
            assert "\u202e".encode() not in text
            assert not any(line.startswith(b"neurbs: done") for line in text.splitlines())
            if bad in name:
                assert shown.encode() in text
    (tmp_path / "b.csv").write_text("x [\x1b[2J],y [\x1b[2J],z [\x1b[2J]\n1,2,3\n")
    done = subprocess.run(
        [sys.executable, "-m", "neurbs", "info", str(tmp_path / "b.csv")], capture_output=True
    )
    assert done.returncode == 0
    assert b"\x1b" not in done.stdout
    assert rb"\x1b[2j" in done.stdout
