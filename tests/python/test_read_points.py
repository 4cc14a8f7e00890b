"""Points from files: formats, damaged files and their messages."""

import os
import re
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

import neurbs
from neurbs import NeurbsError

FAR = [[5000000.001, 7500000.0, 120.25], [0.1, -1e-300, 1e300], [1 / 3, 2.0, 3.0]]
"""Coordinates with all digits."""


def written(path: Path, content: str | bytes) -> Path:
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def rows(separator: str = " ") -> str:
    return "".join(separator.join(map(repr, row)) + "\n" for row in FAR)


def test_obj_gives_its_vertices_in_order(tmp_path: Path) -> None:
    text = "# a mesh\nv 1 2 3\nvn 0 0 1\n v\t5000000.001 5 6 1.0\nvt 0 0\nf 1 2 1\nv 1 2 3\n"
    points = neurbs.read_points(written(tmp_path / "p.obj", text))
    assert points.tolist() == [[1, 2, 3], [5000000.001, 5, 6], [1, 2, 3]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("v 1 2 3\nf 1 1 1\nv 1 b 3\n", "line 3, column 3 must be a finite number, got 'b'"),
        ("v 1 2 3\nv 1 2\n", "line 2 must have 4 columns, as in line 1, got 3"),
        ("f 1 2 3\n", "must have at least one point, but has no 'v' line"),
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
        with pytest.raises(NeurbsError, match=r"must be a whole \.npy file, but is damaged"):
            neurbs.read_points(written(path, damaged))
    with pytest.raises(NeurbsError, match="must be a NumPy array file, but has no header"):
        neurbs.read_points(written(path, b"1 2 3\n"))
    np.save(path, np.array([[{}, 1, 2]], dtype=object))
    with pytest.raises(NeurbsError, match="real numbers, got an array of object"):
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


def with_lists(form: str, body: bytes) -> bytes:
    """Return a file with lists before and after the coordinates of a vertex."""
    head = ply(form, body, faces="property list uint double b")
    return head.replace(b"uchar class", b"list uchar int a")


@pytest.mark.parametrize("lengths", [(2, 2, 2), (0, 3, 1)])
@pytest.mark.parametrize("order", ["", "<", ">"])
def test_ply_with_lists_in_vertices(tmp_path: Path, order: str, lengths: tuple[int, ...]) -> None:
    body = b""
    for row, n in zip(FAR, lengths, strict=True):
        if order:
            body += bytes([n]) + np.arange(n, dtype=f"{order}i4").tobytes()
            body += np.array(row, f"{order}f8").tobytes()
            body += np.array(n, f"{order}u4").tobytes() + np.ones(n, f"{order}f8").tobytes()
        else:
            words = [n, *range(n), *row, n, *[0.5] * n]
            body += (" ".join(map(repr, words)) + "\n").encode()
    form = {"": "ascii", "<": "binary_little_endian", ">": "binary_big_endian"}[order]
    path = written(tmp_path / "p.ply", with_lists(form, body))
    assert neurbs.read_points(path).tolist() == FAR
    for end in range(len(body) - 1):
        # A cut within the last number of a text cannot be seen.
        if order or body[end : end + 1].isspace():
            written(path, with_lists(form, body[:end]))
            with pytest.raises(NeurbsError, match=r"p\.ply: "):
                neurbs.read_points(path)


def test_ply_with_lists_before_the_vertices(tmp_path: Path) -> None:
    head, rest = "element face 2\nproperty list uchar int vertex_indices\n", vertices("<")
    content = ply("binary_little_endian", MIXED + rest).replace(
        b"element vertex", head.encode() + b"element vertex"
    )
    assert neurbs.read_points(written(tmp_path / "p.ply", content)).tolist() == FAR


def test_ply_with_names_in_upper_case(tmp_path: Path) -> None:
    content = ply("ascii", b"0 1 2 3\n0 4 5 6\n0 7 8 9\n")
    for axis in (b"x", b"y", b"z"):
        content = content.replace(b"double " + axis, b"double " + axis.upper())
    points = neurbs.read_points(written(tmp_path / "p.ply", content))
    assert points.tolist() == [[1, 2, 3], [4, 5, 6], [7, 8, 9]]


def test_ply_written_by_another_library(tmp_path: Path) -> None:
    for encoding in ("ascii", "binary_little_endian"):
        box = trimesh.creation.box()
        box.export(tmp_path / "box.ply", encoding=encoding)
        assert neurbs.read_points(tmp_path / "box.ply").tolist() == box.vertices.tolist()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (ply("ascii", b"0 1 2 3\n0 1 b 3\n0 1 2 3\n"), "line 11, column 3 must .* got 'b'"),
        (ply("ascii", b"0 1 2 3\n0 1 2\n0 1 2 3\n"), "line 11 must have 4 columns, as in line 10"),
        (ply("ascii", b"0 1 2 3\n0 4 5 6\n"), "must have 3 points, .* cut short after 2"),
        (ply("ascii", b""), "must have 3 points, as in its header, but is cut short after 0"),
        (ply("binary_little_endian", vertices("<")[:-1]), "must have 3 points, .* after 2"),
        (
            ply("binary_little_endian", b"", count=10**14),
            "must have 10{14} rows of vertex, .* cut short",
        ),
        (ply("ascii", b"", count=0), "must have at least one point, but has 0 vertices"),
        (
            ply("ascii", b"").replace(b"double z", b"double w"),
            "vertices must have properties x, y and z, but have",
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
            ply("binary_little_endian", rb"\9" + vertices("<")[1:]).replace(
                b"uchar class", b"list uchar int l"
            ),
            r"must be a whole \.ply file, .* cut short in the rows of vertex",
        ),
        (
            ply("ascii", b"q 1 2 3\n").replace(b"uchar class", b"list uchar int l"),
            r"must be a whole \.ply file, .* a list in line 10 is not whole",
        ),
        (
            ply("ascii", b"2 7 8 1 2 3\n2 7 8 1 2\n").replace(b"uchar class", b"list uchar int l"),
            "line 11 must have 3 columns, as in line 10, got 2",
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
        NeurbsError, match=r"\.xyz \.txt \.csv .*\.las \.laz .*\.gz \.zst, got the suffix '\.dwg'"
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


# Points that are not finite

HOLES = "x,y,z,note\n1,2,3,a\nnan,2,3,b\n4,,6,c\n7,8,9,d\n1,-inf,0,e\n1,NA,0,f\n"


def test_points_that_are_not_finite_are_an_error_or_dropped(tmp_path: Path) -> None:
    path = written(tmp_path / "p.csv", HOLES)
    with pytest.raises(NeurbsError, match=r'line 3, column 1 .* got \'nan\': .*nan="drop"'):
        neurbs.read_points(path)
    with pytest.warns(UserWarning, match=r"4 of 6 points are not finite and were dropped") as seen:
        points = neurbs.read_points(path, nan="drop")
    assert seen[0].filename == __file__
    assert points.tolist() == [[1, 2, 3], [7, 8, 9]]
    cloud = neurbs.read_point_cloud(path, nan="drop")
    assert (len(cloud), cloud.dropped) == (2, 4)
    with pytest.raises(NeurbsError, match=r"line 2, column 4 must be a finite number, got 'a'"):
        neurbs.read_points(path, nan="drop", columns=(0, 1, 3))
    with pytest.raises(NeurbsError, match="nan must be 'error' or 'drop', got 'keep'"):
        neurbs.read_points(path, nan="keep")  # type: ignore[call-overload]
    path = written(tmp_path / "p.csv", "x,y,z\nnan,1,2\n")
    with pytest.raises(NeurbsError, match="at least one point, but all 1 are not finite"):
        neurbs.read_points(path, nan="drop")


@pytest.mark.parametrize("suffix", [".npy", ".ply"])
def test_holes_in_binary_files_are_dropped(tmp_path: Path, suffix: str) -> None:
    points = np.arange(12.0).reshape(4, 3)
    points[2, 1] = np.inf
    path = tmp_path / f"p{suffix}"
    if suffix == ".npy":
        np.save(path, points)
    else:
        trimesh.PointCloud(points).export(path)
    with pytest.raises(NeurbsError, match=r"point 2 \(counted from 0\) is \(6.0, inf, 8.0\)"):
        neurbs.read_points(path)
    cloud = neurbs.read_point_cloud(path, nan="drop")
    assert cloud.points.tolist() == points[[0, 1, 3]].tolist()
    assert cloud.dropped == 1


# Large files


@pytest.mark.parametrize("size", [1, 7, 65536, 10**6])
def test_chunks_are_the_points(tmp_path: Path, size: int) -> None:
    count = 200 if size == 1 else 150_000
    points = np.random.default_rng(0).random((count, 3)).round(3)
    np.save(tmp_path / "p.npy", points)
    chunks = list(neurbs.read_points(tmp_path / "p.npy", chunks=size))
    assert np.array_equal(np.vstack(chunks), points)
    assert {len(chunk) for chunk in chunks[:-1]} <= {size}
    assert all(chunk.flags.c_contiguous for chunk in chunks)


def test_chunks_of_a_table_with_holes(tmp_path: Path) -> None:
    path = written(tmp_path / "p.csv", HOLES)
    with pytest.warns(UserWarning, match="4 of 6"):
        chunks = list(neurbs.read_points(path, nan="drop", chunks=1))
    assert [chunk.tolist() for chunk in chunks] == [[[1, 2, 3]], [[7, 8, 9]]]
    with pytest.raises(FileNotFoundError):  # at once, and not with the first chunk
        neurbs.read_points(tmp_path / "missing.csv", chunks=5)
    for wrong in (0, -1, 2.5):
        with pytest.raises(NeurbsError, match="chunks must be an integer from 1, got"):
            neurbs.read_points(path, chunks=wrong)  # type: ignore[arg-type]


def test_a_fault_far_down_a_table_is_located(tmp_path: Path) -> None:
    path = written(tmp_path / "p.xyz", "1 2 3\n" * 100_000 + "1 2 b\n" + "1 2 3\n" * 10)
    with pytest.raises(NeurbsError, match=r"line 100001, column 3 must .* got 'b'"):
        neurbs.read_points(path)


MEMORY = """
    import resource, sys
    import numpy as np
    import neurbs

    def peak():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024

    neurbs.read_points({small!r})
    before = peak()
    points = neurbs.read_points({large!r})
    print((peak() - before) / points.nbytes)
"""


@pytest.mark.skipif(os.name == "nt", reason="memory is measured by POSIX")
@pytest.mark.parametrize("suffix", [".xyz", ".ply"])
def test_memory_is_that_of_the_points(tmp_path: Path, suffix: str) -> None:
    """With a second copy the ratio would be 2."""
    points = np.random.default_rng(0).integers(0, 99, (2_000_000, 3)).astype(float)
    for name, part in (("small", points[:10]), ("large", points)):
        path = tmp_path / f"{name}{suffix}"
        if suffix == ".ply":
            neurbs.save(neurbs.PointCloud(part), path)
        else:
            text = "\n".join(f"{x} {y} {z}" for x, y, z in part.astype(int).tolist())
            path.write_text(text)
    code = MEMORY.format(
        small=str(tmp_path / f"small{suffix}"), large=str(tmp_path / f"large{suffix}")
    )
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True, check=True
    )
    # The number of rows of a table is unknown, so its array grows by a quarter at a time.
    assert float(done.stdout) < 1.7


# Attributes


def test_ply_has_normals_and_colors(tmp_path: Path) -> None:
    cloud = neurbs.PointCloud(
        np.array(FAR), np.eye(3), np.array([[1, 2, 3], [4, 5, 6], [7, 8, 255]], np.uint8)
    )
    neurbs.save(cloud, tmp_path / "p.ply")
    read = neurbs.read_point_cloud(tmp_path / "p.ply")
    assert repr(read) == "PointCloud(3 points, normals, colors)"
    for name in ("points", "normals", "colors"):
        np.testing.assert_array_equal(getattr(read, name), getattr(cloud, name))


def test_tables_have_units_normals_and_colors(tmp_path: Path) -> None:
    text = "X [mm],Y [mm],Z [mm],nx,ny,nz,R,G,B\n1,2,3,0,0,1,1.0,0.5,0\n4,5,6,,,,0,0,0\n"
    cloud = neurbs.read_point_cloud(written(tmp_path / "p.csv", text))
    assert cloud.unit == "mm"
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert cloud.normals is not None
    np.testing.assert_array_equal(cloud.normals, [[0, 0, 1], [np.nan] * 3])
    assert cloud.colors is not None
    assert cloud.colors.tolist() == [[255, 128, 0], [0, 0, 0]]
    obj = written(tmp_path / "p.obj", "v 1 2 3 1 0 0\nv 4 5 6 0 1 0\nf 1 2 1\n")
    colors = neurbs.read_point_cloud(obj).colors
    assert colors is not None
    assert colors.tolist() == [[255, 0, 0], [0, 255, 0]]


def test_npz_of_several_arrays(tmp_path: Path) -> None:
    path, points = tmp_path / "p.npz", np.arange(6.0).reshape(2, 3)
    for arrays in (
        {"anything": points},
        {"points": points, "time": np.zeros(9)},
        dict(zip("xyz", points.T, strict=True)),
    ):
        np.savez(path, **arrays)
        assert neurbs.read_points(path).tolist() == points.tolist()
    np.savez(path, a=points[:, 0], b=points[:, 1], c=points[:, 2])
    with pytest.raises(NeurbsError, match=r"must have one array, or one named points, .* got a, b"):
        neurbs.read_points(path)
    assert neurbs.read_points(path, columns=("b", "a", "c")).tolist() == [[1, 0, 2], [4, 3, 5]]
    np.save(tmp_path / "p.npy", np.arange(10).reshape(2, 5))
    assert neurbs.read_points(tmp_path / "p.npy", columns=(4, 0)).tolist() == [[4, 0, 0], [9, 5, 0]]
    path.write_bytes(b"PK\3\4 nonsense")
    with pytest.raises(NeurbsError, match=r"must be a whole \.npz file"):
        neurbs.read_points(path)


def test_a_point_cloud_is_accepted_for_points(terrain_points: NDArray[np.float64]) -> None:
    cloud = neurbs.PointCloud(terrain_points, unit="m")
    assert np.asarray(cloud) is cloud.points
    assert neurbs.reconstruct(cloud, grid=(5, 5)).surface == (
        neurbs.reconstruct(terrain_points, grid=(5, 5)).surface
    )
    with pytest.raises(NeurbsError, match=r"normals must be of shape \(400, 3\), .* got .*\(3,\)"):
        neurbs.PointCloud(terrain_points, np.zeros(3))
    with pytest.raises(NeurbsError, match=r"points must be an array of shape \(n, 3\), got"):
        neurbs.PointCloud(np.zeros(3))


@pytest.mark.skipif("NEURBS_DATA" not in os.environ, reason="NEURBS_DATA names no folder")
@pytest.mark.parametrize(
    ("file", "name"),
    [
        ("am_wave_sheet/c5dataReg.txt", "am_wave_sheet"),
        ("bmx_hill/autzen-bmx-2010.las", "bmx_hill_2010"),
        ("bmx_hill/autzen-bmx-2023.las", "bmx_hill_2023"),
        ("mediapipe_face/canonical_face_model.obj", "mediapipe_face"),
        ("milk_carton/milk.pcd", "milk_carton"),
        ("owl_photogrammetry/owl_decimated.vtp", "owl_photogrammetry"),
        ("soybean_leaf/11_20190508T043118_pot1_36.txt", "soybean_leaf"),
        ("valve_leaflets/data.c.txt", "valve_tube"),
    ],
)
def test_real_files_as_others_read_them(file: str, name: str) -> None:
    folder = Path(os.environ["NEURBS_DATA"])
    points = neurbs.read_points(folder / file)
    np.testing.assert_array_equal(points, np.load(folder / "npy" / f"{name}.npy"))


@pytest.mark.skipif("NEURBS_DATA" not in os.environ, reason="NEURBS_DATA names no folder")
def test_attributes_of_real_files() -> None:
    folder = Path(os.environ["NEURBS_DATA"])
    hill = neurbs.read_point_cloud(folder / "bmx_hill/autzen-bmx-2010.las")
    assert hill.unit == "m, z: US survey foot"
    assert hill.crs is not None
    assert "Oregon LCC" in hill.crs
    horizons = neurbs.read_point_cloud(folder / "claudius_horizons/claudius.csv")
    assert horizons.normals is not None
    # Only 25 rows of this table, of 21,048, are orientations.
    assert np.isfinite(horizons.normals).all(axis=1).sum() == 25
