"""Points in formats of several programs: each file is written by hand or by another library."""

import base64
import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import laspy
import numpy as np
import pye57
import pytest
import pyvista
import trimesh
from laspy.vlrs.known import WktCoordinateSystemVlr
from numpy.typing import NDArray
from pye57 import libe57

import neurbs
from neurbs import NeurbsError

POINTS = np.random.default_rng(0).integers(1, 10**6, (50, 3)) / 1000


def table(points: NDArray[np.float64] = POINTS) -> str:
    return "".join(f"{x} {y} {z}\n" for x, y, z in points.tolist())


# Leica's scans


def ptx(points: NDArray[np.float64], matrix: NDArray[np.float64], rows: str = "") -> str:
    head = ["5", str(len(points) // 5), "0 0 0", "1 0 0", "0 1 0", "0 0 1"]
    head += [" ".join(map(repr, row)) for row in matrix.tolist()]
    body = rows or "".join(f"{x} {y} {z} 0.5\n" for x, y, z in points.tolist())
    return "\n".join(head) + "\n" + body


TURN = np.array([[0.0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 1, 0], [10, 20, 30, 1]])
"""A quarter turn about z and a shift; points are rows."""


def test_ptx_scans_are_joined_in_their_frame(tmp_path: Path) -> None:
    points = POINTS.copy()
    points[7] = 0
    path = tmp_path / "a.ptx"
    path.write_text(ptx(points, TURN) + "\n" + ptx(POINTS[:10], np.eye(4)))
    cloud = neurbs.read_point_cloud(path)
    measured = np.delete(points, 7, axis=0)
    turned = np.column_stack([-measured[:, 1], measured[:, 0], measured[:, 2]])
    turned += [10, 20, 30]
    np.testing.assert_allclose(cloud.points, np.vstack([turned, POINTS[:10]]), atol=1e-12)
    assert (cloud.dropped, cloud.no_data, cloud.colors) == (1, 1, None)
    # The transpose of the matrix, as some programs write it.
    path.write_text(ptx(points, TURN.T))
    np.testing.assert_allclose(neurbs.read_points(path), turned, atol=1e-12)


def test_ptx_has_colors(tmp_path: Path) -> None:
    rows = "1 2 3 0.5 255 0 7\n" * 5
    (tmp_path / "a.PTX").write_text(ptx(POINTS[:5], np.eye(4), rows))
    colors = neurbs.read_point_cloud(tmp_path / "a.PTX").colors
    assert colors is not None
    assert colors.tolist() == [[255, 0, 7]] * 5


def test_a_damaged_ptx_is_refused(tmp_path: Path) -> None:
    whole = ptx(POINTS[:10], TURN) + ptx(POINTS[:5], TURN)
    path = tmp_path / "a.ptx"
    lines = whole.splitlines(keepends=True)
    for count in range(len(lines)):
        if count == 20:
            continue  # The first scan alone.
        path.write_text("".join(lines[:count]))
        with pytest.raises(NeurbsError, match=r"a\.ptx: "):
            neurbs.read_points(path)
    for line, text, message in (
        (0, "-5", "line 1 must start a scan"),
        (0, "9" * 30, "too few"),
        (6, "1 0 0", "line 1 must start a scan"),
        (7, "nan 0 0 0", "line 1 must start a scan"),
        (13, "1 2 q 0", "line 14, column 3 must be a finite number, got 'q'"),
        (13, "1 2", "line 14 must have 4 columns, as in line 11, got 2"),
        (32, "1 q 2 0", "line 33, column 2 must be a finite number, got 'q'"),
    ):
        path.write_text("".join([*lines[:line], text + "\n", *lines[line + 1 :]]))
        with pytest.raises(NeurbsError, match=message):
            neurbs.read_points(path)
    path.write_text(ptx(POINTS[:5], TURN, "0 0 0 0\n" * 5))
    with pytest.raises(NeurbsError, match="at least one point, but all 5 have no data"):
        neurbs.read_points(path)


def test_many_small_scans_are_read_in_one_pass(tmp_path: Path) -> None:
    path = tmp_path / "a.ptx"
    path.write_text(ptx(POINTS[:5], TURN) * 3000)
    start = time.process_time()
    assert len(neurbs.read_points(path)) == 15_000
    assert time.process_time() - start < 10


# Meshes and grids


def test_meshes_of_other_programs(tmp_path: Path) -> None:
    ball = trimesh.creation.icosphere(1)
    scene = trimesh.Scene()
    scene.add_geometry(ball)
    scene.add_geometry(ball, transform=trimesh.transformations.translation_matrix([50, 0, 0]))
    (tmp_path / "a.3mf").write_bytes(scene.export(file_type="3mf"))
    cloud = neurbs.read_point_cloud(tmp_path / "a.3mf")
    assert (len(cloud), cloud.unit) == (2 * len(ball.vertices), "mm")
    assert cloud.points[:, 0].max() == pytest.approx(51)
    ball.export(tmp_path / "a.dae")
    cloud = neurbs.read_point_cloud(tmp_path / "a.dae")
    assert (len(cloud), cloud.unit) == (len(ball.vertices), "m")
    text = (tmp_path / "a.dae").read_text()
    inches = text.replace("<asset>", '<asset><unit name="inch" meter="0.0254"/>', 1)
    (tmp_path / "b.dae").write_text(inches)
    assert neurbs.read_point_cloud(tmp_path / "b.dae").unit == "in"


def gltf(uri: str = "") -> str:
    """Return a triangle in glTF, after the specification."""
    data = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 2]], "<f4").tobytes()
    uri = uri or "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    return json.dumps(
        {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "translation": [10, 0, 0]}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 4}]}],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                 "min": [0, 0, 0], "max": [1, 1, 2]}
            ],
            "bufferViews": [{"buffer": 0, "byteLength": 36}],
            "buffers": [{"byteLength": 36, "uri": uri}],
        }
    )  # fmt: skip


def test_gltf_with_its_data_in_itself(tmp_path: Path) -> None:
    path = tmp_path / "a.gltf"
    path.write_text(gltf())
    cloud = neurbs.read_point_cloud(path)
    assert cloud.points.tolist() == [[10, 0, 0], [11, 0, 0], [10, 1, 2]]
    assert cloud.unit == "m"
    path.write_text(gltf("a.bin"))
    with pytest.raises(NeurbsError, match=r"must have its data in itself, .* in 'a\.bin': save"):
        neurbs.read_points(path)


def test_vtk_grids_as_pyvista_reads_them(tmp_path: Path) -> None:
    image = pyvista.ImageData(dimensions=(3, 4, 2), spacing=(1, 2, 3), origin=(5, 6, 7))
    image["a"] = np.arange(24.0)
    lines = pyvista.RectilinearGrid([0, 1.0, 5], [2.0, 3], [4.0, 9])
    curved = pyvista.StructuredGrid(*np.meshgrid([0.0, 1, 4], [2.0, 3], [5.0]))
    for name, data in (
        ("a.vti", image),
        ("a.vtk", image),
        ("b.vtk", lines),
        ("a.vtr", lines),
        ("a.vts", curved),
        ("c.vtk", curved),
    ):
        data.save(tmp_path / name)
        np.testing.assert_array_equal(neurbs.read_points(tmp_path / name), data.points)


@pytest.mark.parametrize("suffix", [".grd", ".dat", ".txt", ".asc"])
def test_a_grid_of_surfer(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    head = "DSAA\r\n3 2\r\n10 20\r\n100 101\r\n1 6\r\n"
    path.write_text(f"{head}1 2 1.70141e+038\r\n4 5\r\n6\r\n")
    cloud = neurbs.read_point_cloud(path)
    rows = [[10, 100, 1], [15, 100, 2], [10, 101, 4], [15, 101, 5], [20, 101, 6]]
    assert (cloud.points.tolist(), cloud.no_data) == (rows, 1)
    for text in (
        "DSAA\n3 2\n10 q\n100 101\n1 6\n1 2\n",
        "DSAA\n3 2\n20 10\n0 1\n1 6\n1\n",
        "DSAA\n",
    ):
        path.write_text(text)
        with pytest.raises(NeurbsError, match="must start with DSAA, the numbers of columns"):
            neurbs.read_points(path)
    path.write_text(f"{head}1 2 3\n4 5\n")
    with pytest.raises(NeurbsError, match=r"must have 6 points, .* but is cut short after 5"):
        neurbs.read_points(path)


def test_a_binary_grid_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.grd"
    path.write_bytes(b"DSRB" + bytes(600))
    with pytest.raises(NeurbsError, match=r"must be a grid as text, .* but is binary: convert it"):
        neurbs.read_points(path)
    path.write_text("ncols 1\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 2\n7\n")
    assert neurbs.read_points(path).tolist() == [[1, 1, 7]]


def test_a_grid_without_values_is_of_a_bounded_size(tmp_path: Path) -> None:
    path = tmp_path / "a.vti"
    pyvista.ImageData(dimensions=(3, 4, 2)).save(path)
    whole = path.read_bytes()
    for ends in (b"0 99999 0 99999 0 99999", b"0 2147483647 0 2147483647 0 2147483647"):
        path.write_bytes(whole.replace(b"0 2 0 3 0 1", ends))
        with pytest.raises(NeurbsError, match=r"must have at most .* nodes"):
            neurbs.read_points(path)
    path = tmp_path / "a.vtk"
    path.write_text(
        "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\n"
        "DIMENSIONS 99999 99999 9\nORIGIN 0 0 0\nSPACING 1 1 1\n"
    )
    with pytest.raises(NeurbsError, match=r"must have at most .* nodes"):
        neurbs.read_points(path)


# Attributes that readers refuse


def write_las(path: Path, wkt: str = "") -> None:
    header = laspy.LasHeader(point_format=6 if wkt else 0, version="1.4")
    header.scales = np.full(3, 0.001)
    if wkt:
        header.vlrs.append(WktCoordinateSystemVlr(wkt))
        header.global_encoding.wkt = True
    data = laspy.LasData(header)
    data.x, data.y, data.z = POINTS.T
    data.write(path)


@pytest.mark.parametrize("suffix", [".las", ".laz"])
@pytest.mark.parametrize("wkt", ['PROJCS["nonsense"', "EPSG:99999999", "\x01"])
def test_a_scan_with_a_reference_system_that_is_refused(
    tmp_path: Path, wkt: str, suffix: str
) -> None:
    path = tmp_path / f"a{suffix}"
    write_las(path, wkt)
    with pytest.warns(
        neurbs.CrsUnknownWarning, match="its reference system cannot be read"
    ) as seen:
        cloud = neurbs.read_point_cloud(path)
    assert seen[0].filename == __file__
    np.testing.assert_allclose(cloud.points, POINTS, atol=1e-9)
    assert (cloud.crs, cloud.unit) == (None, None)
    np.testing.assert_allclose(neurbs.read_points(path), POINTS, atol=1e-9)


def test_a_scan_in_the_cloud_optimized_format_is_one_in_laz(tmp_path: Path) -> None:
    """COPC is LAZ with a record of its own that comes first."""
    path = tmp_path / "a.copc.laz"
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.scales = np.full(3, 0.001)
    header.vlrs.append(laspy.VLR("copc", 1, "COPC info VLR", bytes(160)))
    data = laspy.LasData(header)
    data.x, data.y, data.z = POINTS.T
    data.write(path)
    np.testing.assert_allclose(neurbs.read_points(path), POINTS, atol=1e-9)


def write_e57(path: Path, most: int, *, limits: bool = True, count: int = 50) -> NDArray[Any]:
    """Write a scan with integer colors up to a largest value, and return them."""
    colors = np.random.default_rng(1).integers(0, most + 1, (count, 3))
    with pye57.E57(str(path), mode="w") as file:
        image = file.image_file
        scan = libe57.StructureNode(image)
        scan.set("guid", libe57.StringNode(image, "{1}"))
        names = ["colorRed", "colorGreen", "colorBlue"]
        if limits:
            box = libe57.StructureNode(image)
            for name in names:
                box.set(f"{name}Minimum", libe57.IntegerNode(image, 0))
                box.set(f"{name}Maximum", libe57.IntegerNode(image, most))
            scan.set("colorLimits", box)
        prototype = libe57.StructureNode(image)
        for axis in "XYZ":
            prototype.set(f"cartesian{axis}", libe57.FloatNode(image, 0.0, libe57.E57_DOUBLE))
        for name in names:
            prototype.set(name, libe57.IntegerNode(image, 0, 0, most))
        points = libe57.CompressedVectorNode(image, prototype, libe57.VectorNode(image, True))
        scan.set("points", points)
        file.data3d.append(scan)
        if count:
            arrays = {f"cartesian{a}": POINTS[:count, i].copy() for i, a in enumerate("XYZ")}
            arrays |= {n: colors[:, i].astype(np.uint16) for i, n in enumerate(names)}
            buffers = libe57.VectorSourceDestBuffer()
            for name, array in arrays.items():
                buffers.append(libe57.SourceDestBuffer(image, name, array, count, True, True))
            points.writer(buffers).write(count)
    return colors


@pytest.mark.parametrize("limits", [True, False])
@pytest.mark.parametrize("most", [255, 1023, 65535])
def test_e57_with_colors_of_any_depth(tmp_path: Path, most: int, limits: bool) -> None:
    path = tmp_path / "a.e57"
    colors = write_e57(path, most, limits=limits)
    cloud = neurbs.read_point_cloud(path)
    np.testing.assert_array_equal(cloud.points, POINTS)
    assert cloud.colors is not None
    np.testing.assert_array_equal(cloud.colors, (colors * (255 / most)).round())


# Clouds and arrays

PCD = (
    "VERSION 0.7\nFIELDS X Y Z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 50\nHEIGHT 1\n"
    "POINTS 50\nDATA ascii\n"
)


def test_pcd_with_names_in_upper_case(tmp_path: Path) -> None:
    (tmp_path / "a.pcd").write_text(PCD + table())
    np.testing.assert_array_equal(neurbs.read_points(tmp_path / "a.pcd"), POINTS)


def test_structured_arrays(tmp_path: Path) -> None:
    path = tmp_path / "a.npy"
    fields = [("time", "i8"), ("Y", "f4"), ("X", "f8"), ("z [m]", "f8"), ("label", "U3")]
    array = np.zeros(3, fields)
    array["X"], array["Y"], array["z [m]"], array["time"] = [1, 4, 7], [2, 5, 8], [3, 6, 9], 5
    np.save(path, array)
    cloud = neurbs.read_point_cloud(path)
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6], [7, 8, 9]]
    assert cloud.columns == "x, y, z are columns 'X', 'Y', 'z [m]'"
    points = neurbs.read_points(path, columns=("X", "Y", "time"))
    assert points.tolist() == [[1, 2, 5], [4, 5, 5], [7, 8, 5]]
    assert neurbs.read_points(path, columns=(2, 1)).tolist() == [[1, 2, 0], [4, 5, 0], [7, 8, 0]]
    with pytest.raises(
        NeurbsError, match=r"from 0 to 4 or of 'time', 'Y', 'X', 'z \[m\]', 'label'"
    ):
        neurbs.read_points(path, columns=("a", "b"))
    with pytest.raises(NeurbsError, match="points must be real numbers, got an array of <U3"):
        neurbs.read_points(path, columns=("X", "label"))
    np.save(path, np.zeros(3, [("a", "f8"), ("b", "f8")]))
    with pytest.raises(NeurbsError, match=r"with fields x, y and z, got .* 'a', 'b': choose"):
        neurbs.read_points(path)
    np.save(path, np.array([{}]), allow_pickle=True)
    with pytest.raises(NeurbsError, match="points must be real numbers, got an array of object"):
        neurbs.read_points(path)
    np.save(path, np.array([(1, 2, 3)], [("x [ft]", "f4"), ("y [ft]", "f4"), ("z [ft]", "f4")]))
    assert neurbs.read_point_cloud(path).unit == "ft"
    np.savez(tmp_path / "a.npz", East=[1, 4], North=[2, 5], Elev=[3, 6], t=[9, 9])
    assert neurbs.read_points(tmp_path / "a.npz").tolist() == [[1, 2, 3], [4, 5, 6]]
    whole = np.zeros(2, [("points", "f4", (3,)), ("t", "i4")])
    whole["points"] = [[1, 2, 3], [4, 5, 6]]
    np.savez(tmp_path / "a.npz", scan=whole)
    assert neurbs.read_points(tmp_path / "a.npz").tolist() == [[1, 2, 3], [4, 5, 6]]


# Nothing in a file


def empty_las(path: Path) -> None:
    laspy.LasData(laspy.LasHeader(point_format=0, version="1.2")).write(path)


EMPTY: dict[str, Any] = {
    ".las": empty_las,
    ".laz": empty_las,
    ".e57": lambda path: write_e57(path, 255, count=0),
    ".pcd": lambda path: path.write_text(PCD.replace("50", "0")),
    ".vtp": lambda path: pyvista.PolyData().save(path),
    ".vtu": lambda path: pyvista.UnstructuredGrid().save(path),
    ".vtk": lambda path: pyvista.PolyData().save(path),
    ".vts": lambda path: pyvista.StructuredGrid().save(path),
    ".vti": lambda path: pyvista.ImageData().save(path),
    ".npy": lambda path: np.save(path, np.zeros((0, 3))),
    ".ply": lambda path: path.write_text(
        "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n"
    ),
    ".stl": lambda path: path.write_text("solid\nendsolid\n"),
    ".off": lambda path: path.write_text("OFF\n0 0 0\n"),
    ".obj": lambda path: path.write_text("# nothing\n"),
    ".gltf": lambda path: path.write_text('{"asset": {"version": "2.0"}}'),
    ".dae": lambda path: path.write_text(
        '<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" '
        'version="1.4.1"><library_visual_scenes><visual_scene id="s"/></library_visual_scenes>'
        '<scene><instance_visual_scene url="#s"/></scene></COLLADA>'
    ),
    ".csv": lambda path: path.write_text("x,y,z\n"),
    ".xyz": lambda path: path.touch(),
    ".ptx": lambda path: path.touch(),
}  # fmt: skip


@pytest.mark.parametrize("suffix", EMPTY)
def test_an_empty_cloud_is_not_called_damaged(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"a{suffix}"
    EMPTY[suffix](path)
    for read in (neurbs.read_points, neurbs.read_point_cloud):
        with pytest.raises(NeurbsError) as caught:
            read(path)
        assert "damaged" not in str(caught.value)
        assert "at least one point" in str(caught.value) or "n ≥ 1" in str(caught.value)


def test_info_shows_what_was_read(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("Lon;Lat;Depth [m]\n1;2;3\n")
    done = subprocess.run(
        [sys.executable, "-m", "neurbs", "info", str(path)], capture_output=True, text=True
    )
    assert "columns   x, y, z are columns 'Lon', 'Lat', 'Depth [m]'" in done.stdout
