"""Points from files: every format is read, every damage has its message."""

import os
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

import neurbs
from neurbs import NeurbsError

FAR = [[5000000.001, 7500000.0, 120.25], [0.1, -1e-300, 1e300], [1 / 3, 2.0, 3.0]]
"""Coordinates of which no digit may be lost."""


def written(path: Path, content: str | bytes) -> Path:
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def rows(separator: str = " ") -> str:
    return "".join(separator.join(map(repr, row)) + "\n" for row in FAR)


@pytest.mark.parametrize("separator", [" ", "\t", ",", ";", ", ", " ; ", "   ", " \t "])
@pytest.mark.parametrize("suffix", [".xyz", ".txt", ".csv", ".XYZ"])
def test_text_keeps_every_digit(tmp_path: Path, separator: str, suffix: str) -> None:
    points = neurbs.read_points(written(tmp_path / f"p{suffix}", rows(separator)))
    assert points.tolist() == FAR
    assert points.dtype == np.float64
    assert points.flags.c_contiguous


@pytest.mark.parametrize(
    "text",
    [
        "# x y z\n\n" + rows() + "\n  \n# end",
        "//X Y Z\n" + rows(),
        rows().replace("\n", " # a comment\n"),
        rows().replace("\n", "  // a comment\n"),
        rows().replace("\n", "\r\n"),
        rows().replace("\n", "\r"),
        "x y z\n" + rows(),
        "Easting Northing Height\n" + rows(),
        '"X","Y","Z"\n' + rows(","),
        "x;y;z;\n" + rows(";").replace("\n", ";\n"),
    ],
)
def test_comments_blank_lines_and_headers_are_no_points(tmp_path: Path, text: str) -> None:
    assert neurbs.read_points(written(tmp_path / "p.txt", text)).tolist() == FAR


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("id,z,Y,x\n7,3,2,1\n8,6,5,4\n", [[1, 2, 3], [4, 5, 6]]),
        ("name\tx\ty\tz\nbare ground\t1\t2\t3\ntree\t4\t5\t6\n", [[1, 2, 3], [4, 5, 6]]),
        ("1 2 3 255 0 0\n4 5 6 0 255 0\n", [[1, 2, 3], [4, 5, 6]]),
        ("1 2 3 ground\n4 5 6 tree\n", [[1, 2, 3], [4, 5, 6]]),
        ("point no\tx\ty\tz\n1\t2\t3\t4\n", [[2, 3, 4]]),
        ("1 2\n3 4\n", [[1, 2, 0], [3, 4, 0]]),
        ("x,y\n1,2\n3,4\n", [[1, 2, 0], [3, 4, 0]]),
        ("1 2 3", [[1, 2, 3]]),
    ],
)
def test_columns_are_found(tmp_path: Path, text: str, expected: list[list[float]]) -> None:
    points = neurbs.read_points(written(tmp_path / "p.csv", text))
    assert points.tolist() == expected
    assert points.flags.c_contiguous


@pytest.mark.parametrize("encoding", ["utf-8-sig", "latin-1", "utf-16"])
def test_any_encoding_will_do(tmp_path: Path, encoding: str) -> None:
    text = "# Höhe über Grund\nx,y,z,größe\n1,2,3,é\n4,5,6,ß\n"
    path = written(tmp_path / "p.csv", text.encode(encoding))
    assert neurbs.read_points(path).tolist() == [[1, 2, 3], [4, 5, 6]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 2 3\n4 abc 6\n", "line 2, column 2 must be a finite number, got 'abc'"),
        ("# c\n\nx y z\n1 2 3\n4 5 6e\n", "line 5, column 3 must be a finite number, got '6e'"),
        ("1,2,3\n4,,6\n", "line 2, column 2 must be a finite number, got nothing"),
        ("1;2;3\n4;5;1,234.5\n", "line 2, column 3 must be a finite number, got '1.234.5'"),
        ("1 2 3\n4 5 nan\n", "line 2, column 3 must be a finite number, got 'nan': remove"),
        ("1 2 3\n4 5 1e999\n", "line 2, column 3 must be a finite number, got '1e999': remove"),
        ("1 2 3\n4 5 1_0\n", "line 2, column 3 must be a finite number, got '1_0'"),
        ("1 2 3 a\n4 x 6 b\n", "line 2, column 2 must be a finite number, got 'x'"),
        ("1 2 3\n4 5\n", "line 2 must have 3 columns, as line 1 has, got 2: column 3 is missing"),
        ("1 2 3\n4 5 6 7\n", "line 2 must have 3 .* got 4: column 4, '7', is one too many"),
        ("1 2 3 4\n5 6 7\n", "line 2 must have 4 columns, as line 1 has, got 3"),
        ("1\n2\n", "line 1 must have columns x, y and z .* got column 1 only, '1'"),
        ("4\n1 2 3\n", "line 1 must have columns x, y and z .* got column 1 only, '4'"),
        ("no,x,y,z\n1,2,3\n", "line 2 must have 4 columns, as the header in line 1 has, got 3"),
        ("x y z\n" + "m" * 99 + " 2 3\n", "line 2, column 1 .* got 'm{39}…'"),
        ("", "must hold at least one point, but the file is empty"),
        ("\n# only comments\n", "must hold at least one point, but the file is empty"),
        ("# c\nx y z\n", "must hold at least one point, but ends after the header in line 2"),
    ],
)
def test_a_damaged_table_is_located(tmp_path: Path, text: str, message: str) -> None:
    path = written(tmp_path / "p.txt", text)
    with pytest.raises(NeurbsError, match=f"^{re.escape(str(path))}: {message}"):
        neurbs.read_points(path)


def test_binary_rubbish_in_a_text_file_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path / "p.xyz", bytes(range(256)) * 40)
    with pytest.raises(NeurbsError, match=r"p\.xyz: line"):
        neurbs.read_points(path)


def test_obj_gives_its_vertices_in_order(tmp_path: Path) -> None:
    text = "# a mesh\nv 1 2 3\nvn 0 0 1\n v\t5000000.001 5 6 1.0\nvt 0 0\nf 1 2 1\nv 1 2 3\n"
    points = neurbs.read_points(written(tmp_path / "p.obj", text))
    assert points.tolist() == [[1, 2, 3], [5000000.001, 5, 6], [1, 2, 3]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("v 1 2 3\nf 1 1 1\nv 1 b 3\n", "line 3, column 3 must be a finite number, got 'b'"),
        ("v 1 2 3\nv 1 2\n", "line 2 must have 4 columns, as line 1 has, got 3"),
        ("f 1 2 3\n", "must hold at least one point, but has no 'v' line"),
    ],
)
def test_a_damaged_obj_is_located(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(NeurbsError, match=rf"p\.obj: {message}"):
        neurbs.read_points(written(tmp_path / "p.obj", text))


@pytest.mark.parametrize("dtype", ["f8", ">f8", "f4", "f2", "i4", "u1"])
@pytest.mark.parametrize("order", ["C", "F"])
def test_npy_of_any_real_numbers(tmp_path: Path, dtype: str, order: Any) -> None:
    array = np.arange(12).reshape(4, 3).astype(dtype, order=order)
    np.save(tmp_path / "p.npy", array)
    points = neurbs.read_points(tmp_path / "p.npy")
    assert points.tolist() == array.tolist()
    assert points.dtype == np.float64
    assert points.flags.c_contiguous


def test_npy_of_two_columns_lies_in_the_plane(tmp_path: Path) -> None:
    np.save(tmp_path / "p.npy", np.ones((5, 2)))
    assert neurbs.read_points(tmp_path / "p.npy").tolist() == [[1, 1, 0]] * 5


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (
            np.zeros((4, 4)),
            r"an array of shape \(n, 3\) or \(n, 2\) with n ≥ 1, got shape \(4, 4\)",
        ),
        (np.zeros(3), r"got shape \(3,\)"),
        (np.zeros((0, 3)), r"got shape \(0, 3\)"),
        (np.zeros((2, 3), complex), "real numbers, got an array of complex128"),
        (np.zeros((2, 3), bool), "real numbers, got an array of bool"),
        (np.full((2, 3), "1"), "real numbers, got an array of <U1"),
        (np.array([[1, 2, 3], [4, np.inf, 6]]), r"point 1 \(counted from 0\) is \(4.0, inf, 6.0\)"),
    ],
)
def test_npy_of_something_else(tmp_path: Path, array: NDArray[Any], message: str) -> None:
    np.save(tmp_path / "p.npy", array)
    with pytest.raises(NeurbsError, match=rf"p\.npy: points must be .*{message}"):
        neurbs.read_points(tmp_path / "p.npy")


def test_a_damaged_npy_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "p.npy"
    np.save(path, np.zeros((100, 3)))
    whole = path.read_bytes()
    for damaged in (
        whole[:-1],
        whole[:200],
        whole[:40],
        whole[:8],
        whole.replace(b"(100", b"(1e5"),
    ):
        with pytest.raises(NeurbsError, match="is cut short, damaged or made of Python objects"):
            neurbs.read_points(written(path, damaged))
    with pytest.raises(NeurbsError, match="must be a NumPy array file, but does not start"):
        neurbs.read_points(written(path, b"1 2 3\n"))
    np.save(path, np.array([[{}, 1, 2]], dtype=object))
    with pytest.raises(NeurbsError, match="made of Python objects"):
        neurbs.read_points(path)


def ply(form: str, body: bytes, *, count: int = 3, faces: str = "") -> bytes:
    header = [
        "ply",
        f"format {form} 1.0",
        "comment made by a test",
        f"element vertex {count}",
        "property uchar class",
        *(f"property double {axis}" for axis in "xyz"),
        *([faces] if faces else []),
        "end_header\n",
    ]
    return "\n".join(header).encode() + body


def vertices(order: str) -> bytes:
    table = np.zeros(3, [("class", "u1"), ("position", f"{order}f8", 3)])
    table["position"] = FAR
    return table.tobytes()


FACES = "element face 2\nproperty list uchar int vertex_indices"
MIXED = b"".join(
    bytes([len(face)]) + np.array(face, "<i4").tobytes() for face in [(0, 1, 2), (0, 1, 2, 0)]
)


@pytest.mark.parametrize(
    "content",
    [
        ply("ascii", "".join(f"0 {row}\n" for row in rows().splitlines()).encode()),
        ply("ascii", "".join(f"0 {row}\r\n\r\n" for row in rows().splitlines()).encode()),
        ply("binary_little_endian", vertices("<")),
        ply("binary_big_endian", vertices(">")),
        ply("binary_little_endian", vertices("<") + MIXED, faces=FACES),
        ply("ascii", b"").replace(
            b"element vertex", b"element camera 1\nproperty int a\nelement vertex"
        )
        + b"7\n"
        + "".join(f"0 {row}\n" for row in rows().splitlines()).encode(),
        ply("binary_little_endian", b"\7\0\0\0" + vertices("<")).replace(
            b"element vertex", b"element camera 1\nproperty int a\nelement vertex"
        ),
    ],
)
def test_ply_keeps_every_vertex_and_digit(tmp_path: Path, content: bytes) -> None:
    points = neurbs.read_points(written(tmp_path / "p.ply", content))
    assert points.tolist() == FAR
    assert points.dtype == np.float64
    assert points.flags.c_contiguous


def test_ply_written_by_another_library(tmp_path: Path) -> None:
    for encoding in ("ascii", "binary_little_endian"):
        box = trimesh.creation.box()
        box.export(tmp_path / "box.ply", encoding=encoding)
        assert neurbs.read_points(tmp_path / "box.ply").tolist() == box.vertices.tolist()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (ply("ascii", b"0 1 2 3\n0 1 b 3\n0 1 2 3\n"), "line 11, column 3 must .* got 'b'"),
        (ply("ascii", b"0 1 2 3\n0 1 2\n0 1 2 3\n"), "line 11 must have 4 columns, as line 10 has"),
        (ply("ascii", b"0 1 2 3\n0 4 5 6\n"), "must hold 3 points, .* cut short after 2"),
        (ply("ascii", b""), "must hold 3 points, as the file says, but is cut short after 0"),
        (ply("binary_little_endian", vertices("<")[:-1]), "must hold 3 points, .* after 2"),
        (ply("binary_little_endian", b"", count=10**14), "must hold 10{14} points, .* after 0"),
        (ply("ascii", b"", count=0), "must hold at least one point, but has 0 vertices"),
        (
            ply("ascii", b"").replace(b"double z", b"double w"),
            "vertices must have properties x, y and z and no lists",
        ),
        (
            ply("ascii", b"").replace(b"vertex", b"corner"),
            r"must have an element 'vertex', but has \['corner'\]",
        ),
        (ply("ascii", b"").replace(b"double x", b"quad x"), "line 6 must be part of a PLY header"),
        (
            ply("ascii", b"", count=-1),
            "line 4 must be part of a PLY header, got 'element vertex -1'",
        ),
        (ply("utf-8", b""), "line 2 must be part of a PLY header, got 'format utf-8 1.0'"),
        (ply("ascii", b"")[:60], "must have a line 'end_header', but is cut short before it"),
        (b"", "must be a PLY file, but does not start with a line 'ply'"),
        (b"\0" * 10_000, "must be a PLY file, but does not start with a line 'ply'"),
        (
            ply("binary_little_endian", vertices("<")).replace(
                b"element vertex", FACES.encode() + b"\nelement vertex"
            ),
            "vertices must come before any list, but element 'face'",
        ),
        (
            ply("binary_little_endian", vertices("<")).replace(b"uchar class", b"list uchar int l"),
            "vertices must have properties x, y and z and no lists",
        ),
    ],
)
def test_a_damaged_ply_is_refused(tmp_path: Path, content: bytes, message: str) -> None:
    with pytest.raises(NeurbsError, match=rf"p\.ply: {message}"):
        neurbs.read_points(written(tmp_path / "p.ply", content))


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"missing\.xyz"):
        neurbs.read_points(tmp_path / "missing.xyz")
    with pytest.raises(IsADirectoryError, match=re.escape(str(tmp_path))):
        neurbs.read_points(tmp_path)
    with pytest.raises(
        NeurbsError, match=r"\.xyz \.txt \.csv .*\.las \.laz .*\.tiff, got the suffix '\.dwg'"
    ):
        neurbs.read_points(written(tmp_path / "p.dwg", ""))
    with pytest.raises(NeurbsError, match="got no suffix"):
        neurbs.read_points(written(tmp_path / "p", ""))


def test_a_file_that_is_protected(tmp_path: Path) -> None:
    path = written(tmp_path / "p.xyz", "1 2 3\n")
    path.chmod(0)
    if os.access(path, os.R_OK):
        pytest.skip("this user may read everything")
    with pytest.raises(PermissionError, match=r"p\.xyz"):
        neurbs.read_points(path)
