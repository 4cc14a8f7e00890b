"""Points in files of scanners, grids and simulations, written by other libraries."""

import re
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import laspy
import meshio
import numpy as np
import pye57
import pyproj
import pytest
import rasterio
import rasterio.transform
import trimesh
from numpy.typing import NDArray
from pypcd4 import Encoding
from pypcd4 import PointCloud as PcdCloud

import neurbs
from neurbs import NeurbsError

BLOCKS = 150_000
"""More points than one block."""


def survey(n: int) -> NDArray[np.float64]:
    """Make points whose coordinates have three decimals and are large."""
    points: NDArray[np.float64] = np.random.default_rng(0).integers(0, 10**6, (n, 3)) / 1000
    points += [500_000, 5_400_000, 100]
    return points


def write_las(path: Path, points: NDArray[np.float64], *, crs: int | None = None) -> None:
    header = laspy.LasHeader(point_format=3, version="1.2")
    header.scales, header.offsets = np.full(3, 0.001), np.array([500_000.0, 5_400_000.0, 0.0])
    if crs is not None:
        header.add_crs(pyproj.CRS.from_epsg(crs))
    scan = laspy.LasData(header)
    scan.x, scan.y, scan.z = points.T
    scan.red = np.full(len(points), 65535, np.uint16)
    scan.write(path)


def write_e57(path: Path, scans: list[NDArray[np.float64]], **pose: Any) -> None:
    with pye57.E57(str(path), mode="w") as file:
        for points in scans:
            columns = {f"cartesian{axis}": points[:, i].copy() for i, axis in enumerate("XYZ")}
            colors = {
                f"color{name}": np.full(len(points), value, np.uint8)
                for name, value in {"Red": 255, "Green": 7, "Blue": 0}.items()
            }
            file.write_scan_raw({**columns, **colors}, **pose)


def write_geotiff(path: Path, heights: NDArray[Any], *, crs: str | None = "EPSG:32633") -> None:
    transform = rasterio.transform.from_origin(500_000, 5_400_000, 2.0, 5.0)
    rows, cols = heights.shape[-2:]
    with rasterio.open(
        path,
        "w",
        driver="GTiff",
        width=cols,
        height=rows,
        count=heights.shape[0] if heights.ndim == 3 else 1,
        dtype=heights.dtype,
        crs=crs,
        transform=transform,
        nodata=None if heights.dtype == np.uint8 else -9999,
        compress="lzw",
    ) as file:
        file.write(heights if heights.ndim == 3 else heights[None])


# Laser scans


@pytest.mark.parametrize("suffix", [".las", ".LAZ"])
def test_las_keeps_every_point(tmp_path: Path, suffix: str) -> None:
    points = survey(BLOCKS)
    write_las(tmp_path / f"a{suffix}", points)
    read = neurbs.read_points(tmp_path / f"a{suffix}")
    # The format stores multiples of its scale, here a millimeter.
    np.testing.assert_allclose(read, points, rtol=0, atol=1e-9)
    assert read.flags.c_contiguous
    assert read.flags.owndata


@pytest.mark.parametrize(("crs", "unit"), [(32633, "m"), (2225, "US survey foot")])
def test_las_has_attributes(tmp_path: Path, crs: int, unit: str) -> None:
    write_las(tmp_path / "a.las", survey(9), crs=crs)
    cloud = neurbs.read_point_cloud(tmp_path / "a.las")
    assert cloud.crs == f"EPSG:{crs}"
    assert cloud.unit == unit
    assert cloud.offset == (500_000.0, 5_400_000.0, 0.0)
    assert cloud.colors is not None
    assert cloud.colors.tolist() == [[255, 0, 0]] * 9
    write_las(tmp_path / "b.las", survey(9))
    assert neurbs.read_point_cloud(tmp_path / "b.las").crs is None


def test_e57_joins_its_scans_in_their_frame(tmp_path: Path) -> None:
    points = np.random.default_rng(0).normal(size=(BLOCKS, 3))
    quarter = np.array([np.sqrt(0.5), 0, 0, np.sqrt(0.5)])
    write_e57(
        tmp_path / "a.e57", [points, points[:5]], rotation=quarter, translation=np.array([9, 8, 7])
    )
    cloud = neurbs.read_point_cloud(tmp_path / "a.e57")
    turned = np.column_stack([-points[:, 1], points[:, 0], points[:, 2]])
    turned += [9, 8, 7]
    # pye57 writes single precision.
    np.testing.assert_allclose(cloud.points, np.vstack([turned, turned[:5]]), rtol=0, atol=5e-7)
    assert cloud.unit == "m"
    assert cloud.colors is not None
    assert cloud.colors[[0, -1]].tolist() == [[255, 7, 0]] * 2


def test_e57_leaves_out_pulses_without_return(tmp_path: Path) -> None:
    points = np.arange(12.0).reshape(4, 3)
    columns = {f"cartesian{axis}": points[:, i].copy() for i, axis in enumerate("XYZ")}
    with pye57.E57(str(tmp_path / "a.e57"), mode="w") as file:
        invalid = np.array([0, 2, 0, 0], np.int8)
        file.write_scan_raw({**columns, "cartesianInvalidState": invalid})
    cloud = neurbs.read_point_cloud(tmp_path / "a.e57")
    assert cloud.points.tolist() == points[[0, 2, 3]].tolist()
    assert cloud.dropped == 1


# Clouds of the Point Cloud Library


@pytest.mark.parametrize("encoding", ["ascii", "binary", "binary_compressed"])
def test_pcd_in_every_encoding(tmp_path: Path, encoding: str) -> None:
    rng = np.random.default_rng(0)
    n = BLOCKS if encoding != "ascii" else 500
    points = rng.random((n, 3)).astype(np.float32)
    points[7, 1] = np.nan
    rgb = np.full(n, (10 << 16) + (20 << 8) + 30, np.uint32).view(np.float32)
    PcdCloud.from_xyzrgb_points(np.column_stack([points, rgb])).save(
        tmp_path / "a.pcd", encoding=Encoding(encoding)
    )
    cloud = neurbs.read_point_cloud(tmp_path / "a.pcd")
    expected = np.delete(points, 7, axis=0)
    # Text has fewer digits.
    np.testing.assert_allclose(cloud.points, expected, atol=1e-6 if encoding == "ascii" else 0)
    assert cloud.dropped == 1
    assert cloud.colors is not None
    if encoding != "ascii":
        assert cloud.colors[[0, -1]].tolist() == [[10, 20, 30]] * 2


PCD = (
    "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z normal_x normal_y normal_z rgba _\n"
    "SIZE 8 4 4 4 4 4 4 1\n"
    "TYPE F F F F F F U U\nCOUNT 1 1 1 1 1 1 1 2\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\n"
    "POINTS 2\nDATA ascii\n1.5 2 3 0 0 1 658188 0 0\n4 5 6 0 1 0 0 0 0\n"
)


def test_pcd_with_normals_and_padding(tmp_path: Path) -> None:
    path = tmp_path / "a.pcd"
    path.write_text(PCD)
    cloud = neurbs.read_point_cloud(path)
    assert cloud.points.tolist() == [[1.5, 2, 3], [4, 5, 6]]
    assert cloud.normals is not None
    assert cloud.normals.tolist() == [[0, 0, 1], [0, 1, 0]]
    assert cloud.colors is not None
    assert cloud.colors.tolist() == [[10, 11, 12], [0, 0, 0]]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("FIELDS x", "FIELDS q", "must have fields x, y and z, got q y z"),
        ("SIZE 8 4", "SIZE 3 4", "must start with a PCD header"),
        ("TYPE F F", "TYPE Q F", "must start with a PCD header"),
        ("DATA ascii", "DATA morse", "must start with a PCD header"),
        ("POINTS 2", "POINTS -2", "must start with a PCD header"),
        ("DATA ascii\n", "", "must start with a PCD header"),
        ("POINTS 2", "POINTS 3", "must have 3 points, as in its header, but is cut short after 2"),
        ("4 5 6", "4 b 6", r"line 13, column 2 must be a finite number, got 'b'"),
        ("1.5 2 3", "1.5 2", r"line 12 must have 9 columns, got 8"),
        ("DATA ascii", "DATA binary_compressed", "must have 2 compressed points"),
        ("1.5 2 3 0 0 1 658188 0 0\n4 5 6 0 1 0 0 0 0\n", "", "cut short after 0"),
    ],
)
def test_a_damaged_pcd_is_refused(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert old in PCD
    path = tmp_path / "a.pcd"
    path.write_text(PCD.replace(old, new))
    with pytest.raises(NeurbsError, match=rf"a\.pcd: .*{message}"):
        neurbs.read_points(path)


def test_a_count_beyond_all_memory_is_cut_short(tmp_path: Path) -> None:
    path = tmp_path / "a.pcd"
    path.write_text(PCD.replace("POINTS 2", f"POINTS {10**15}").replace("ascii", "binary"))
    with pytest.raises(NeurbsError, match=r"must have 10{15} points, .* cut short"):
        neurbs.read_points(path)
    write_las(tmp_path / "a.las", survey(9))
    content = bytearray((tmp_path / "a.las").read_bytes())
    content[107:111] = b"\xff" * 4  # The number of points, in version 1.2.
    (tmp_path / "a.las").write_bytes(content)
    with pytest.raises(NeurbsError, match=r"a\.las: must "):
        neurbs.read_points(tmp_path / "a.las")


# Grids of heights

ESRI = "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 10\nNODATA_value -9999\n"


@pytest.mark.parametrize("body", ["1 2 3\n4 -9999 6\n", "1 2\n3 4 -9999\n6", "1,0 2 3 4 -9999 6"])
def test_an_esri_grid_is_distinguished_from_a_table(tmp_path: Path, body: str) -> None:
    path = tmp_path / "a.asc"
    path.write_text(ESRI + body)
    cloud = neurbs.read_point_cloud(path)
    expected = [[105, 215, 1], [115, 215, 2], [125, 215, 3], [105, 205, 4], [125, 205, 6]]
    assert cloud.points.tolist() == expected
    assert cloud.dropped == 1
    path.write_text("1 2 3\n4 5 6\n")
    assert neurbs.read_points(path).tolist() == [[1, 2, 3], [4, 5, 6]]


def test_an_esri_grid_as_rasterio_reads_it(tmp_path: Path) -> None:
    heights = np.random.default_rng(0).random((70, 1001)).round(4)
    text = "\n".join(" ".join(map(str, row)) for row in heights.tolist())
    head = "NCOLS 1001\nNROWS 70\nXLLCENTER 5\nYLLCENTER -7\nCELLSIZE 0.5\n"
    (tmp_path / "a.asc").write_text(head + text)
    points = neurbs.read_points(tmp_path / "a.asc")
    with rasterio.open(tmp_path / "a.asc") as file:
        i, j = np.indices(heights.shape)
        x, y = file.transform @ (j + 0.5, i + 0.5)
        np.testing.assert_allclose(file.read(1).ravel(), points[:, 2], atol=1e-6)
    np.testing.assert_allclose(points[:, :2], np.column_stack([x.ravel(), y.ravel()]), atol=1e-9)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (ESRI + "1 2 3\n4 5\n", "must have 6 points, .* cut short after 5"),
        (ESRI + "1 2 3 4 5 6 7\n", "must have 6 points, .* but has 7"),
        (ESRI + "1 2 3\n4 b 6\n", "line 8 must have numbers, got 'b'"),
        (ESRI + "-9999 " * 6, "at least one point, but all 6 have no data"),
        (ESRI.replace("cellsize 10", "size 10"), "must start with ncols, nrows, xllcorner"),
        (ESRI.replace("nrows 2", "nrows b"), "must start with ncols, nrows, xllcorner"),
    ],
)
def test_a_damaged_esri_grid_is_refused(tmp_path: Path, content: str, message: str) -> None:
    path = tmp_path / "a.asc"
    path.write_text(content)
    with pytest.raises(NeurbsError, match=message):
        neurbs.read_points(path)


def test_a_grid_of_gdal_with_two_sizes_as_rasterio_reads_it(tmp_path: Path) -> None:
    path = tmp_path / "a.asc"
    head = "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ndx 10\ndy 2.5\nNODATA_value nan\n"
    path.write_text(head + "1 2 3\n4 nan 6\n")
    cloud = neurbs.read_point_cloud(path)
    with rasterio.open(path) as file:
        i, j = np.indices((2, 3))
        x, y = file.transform @ (j + 0.5, i + 0.5)
        expected = np.column_stack([x.ravel(), y.ravel(), file.read(1).ravel()])
    np.testing.assert_array_equal(cloud.points, np.delete(expected, 4, axis=0))
    assert (cloud.dropped, cloud.no_data) == (1, 1)
    assert cloud.columns == "a grid of 2 x 3 cells: z is their value"


GRASS = "north: 20\nsouth: 10\neast: 30\nwest: 0\nrows: 2\ncols: 3\n"


@pytest.mark.parametrize("suffix", [".asc", ".txt", ".xyz", ".dat"])
def test_a_grid_of_grass(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    path.write_text(GRASS + "1 2 *\n4 5 6\n")
    expected = [[5, 17.5, 1], [15, 17.5, 2], [5, 12.5, 4], [15, 12.5, 5], [25, 12.5, 6]]
    assert neurbs.read_points(path).tolist() == expected
    options = "null: -9999\ntype: float\nmultiplier: 2\n"
    path.write_text(GRASS.replace(": ", ":") + options + "1 2 -9999\n4 5 6\n")
    doubled = [[x, y, 2 * z] for x, y, z in expected]
    assert neurbs.read_points(path).tolist() == doubled
    angles = (
        GRASS.replace("20", "0:30:00N").replace("10", "0:15N").replace("0\nrows", "1:30W\nrows")
    )
    path.write_text(angles.replace("30\n", "0:30:36E\n") + "1 2 3 4 5 6\n")
    points = neurbs.read_points(path)
    step = (0.51 + 1.5) / 3
    np.testing.assert_allclose(points[0], [-1.5 + step / 2, 0.5 - 0.25 / 4, 1], atol=1e-12)


@pytest.mark.parametrize(
    ("old", "new"),
    [("cols: 3\n", ""), ("rows: 2", "rows: 0"), ("east: 30", "east: -1"), ("20", "nan")],
)
def test_a_damaged_grid_of_grass_is_refused(tmp_path: Path, old: str, new: str) -> None:
    path = tmp_path / "a.asc"
    path.write_text(GRASS.replace(old, new) + "1 2 3 4 5 6\n")
    with pytest.raises(NeurbsError, match="must start with north, south, east, west, rows and"):
        neurbs.read_points(path)


def test_cells_without_data_are_not_called_not_finite(tmp_path: Path) -> None:
    path = tmp_path / "a.asc"
    path.write_text(ESRI + "1 -9999 3\n4 -9999 inf\n")
    with pytest.warns(neurbs.PointsDroppedWarning, match="1 of 4 points are not finite"):
        assert len(neurbs.read_points(path, nan="drop")) == 3
    cloud = neurbs.read_point_cloud(path, nan="drop")
    assert (cloud.dropped, cloud.no_data) == (3, 2)
    path.write_text(ESRI + "1 -9999 3\n4 -9999 6\n")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(neurbs.read_points(path, nan="drop")) == 4
    path.write_text(ESRI + "-9999 inf " * 3)
    with pytest.raises(NeurbsError, match="but all 3 are not finite and 3 have no data"):
        neurbs.read_points(path, nan="drop")


def test_no_data_of_single_precision_in_other_digits(tmp_path: Path) -> None:
    path = tmp_path / "a.asc"
    head = ESRI.replace("-9999", "-3.40282346638529e+38")
    path.write_text(head + "1 2 -3.4028234663852886e+38\n4 5 6\n")
    assert len(neurbs.read_points(path)) == 5


def test_geotiff_gives_the_centers_of_its_cells(tmp_path: Path) -> None:
    heights = np.random.default_rng(0).random((300, 400)).astype(np.float32)
    heights[0, 1], heights[2, 3] = -9999, np.nan
    write_geotiff(tmp_path / "a.tif", heights)
    cloud = neurbs.read_point_cloud(tmp_path / "a.tif")
    assert cloud.points[:2].tolist() == [
        [500_001.0, 5_399_997.5, heights[0, 0]],
        [500_005.0, 5_399_997.5, heights[0, 2]],
    ]
    assert (len(cloud), cloud.dropped) == (300 * 400 - 2, 2)
    assert (cloud.crs, cloud.unit) == ("EPSG:32633", "m")
    write_geotiff(tmp_path / "d.tif", heights, crs="EPSG:4326")
    assert neurbs.read_point_cloud(tmp_path / "d.tif").unit == "degree"
    write_geotiff(tmp_path / "b.tiff", np.ones((5, 5), np.int16), crs=None)
    assert neurbs.read_point_cloud(tmp_path / "b.tiff").crs is None
    write_geotiff(tmp_path / "c.tif", np.zeros((3, 5, 5), np.uint8))
    with pytest.raises(NeurbsError, match="must have one band of heights, got 3"):
        neurbs.read_points(tmp_path / "c.tif")


# Data sets and meshes


@pytest.mark.parametrize("suffix", [".vtu", ".vtk"])
def test_vtk_written_by_meshio(tmp_path: Path, suffix: str) -> None:
    points = np.random.default_rng(0).random((BLOCKS, 3))
    cells = [("triangle", np.array([[0, 1, 2]]))]
    normals = np.tile([0.0, 0.0, 1.0], (BLOCKS, 1))
    meshio.Mesh(points, cells, {"Normals": normals}).write(tmp_path / f"a{suffix}")
    assert np.array_equal(neurbs.read_points(tmp_path / f"a{suffix}"), points)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.vtp", "nonsense", "must be a whole .vtp file, .* does not end with </VTKFile>"),
        ("a.vtk", "nonsense", "must be a whole .vtk file"),
        (
            "a.vtk",
            "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 9 float\n0 0\n",
            "numbers of POINTS are missing",
        ),
        (
            "a.vtk",
            "# vtk DataFile Version 3.0\nt\nASCII\nDATASET TABLE\n"
            "ROW_DATA 1\nFIELD a 1\nx 1 1 int\n7\n",
            "must be a data set with points .* got vtkTable",
        ),
    ],
)
def test_a_damaged_vtk_is_refused_and_vtk_is_quiet(
    tmp_path: Path, name: str, content: str, message: str, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / name).write_text(content)
    with pytest.raises(NeurbsError, match=message):
        neurbs.read_points(tmp_path / name)
    assert capfd.readouterr() == ("", "")


def test_meshes_give_their_vertices_where_they_are_placed(tmp_path: Path) -> None:
    ball = trimesh.creation.icosphere(2)
    for suffix in (".off", ".stl"):
        ball.export(tmp_path / f"ball{suffix}")
        points = neurbs.read_points(tmp_path / f"ball{suffix}")
        assert points.shape == ball.vertices.shape
        assert trimesh.PointCloud(points).bounds == pytest.approx(ball.bounds, abs=1e-6)
    scene = trimesh.Scene()
    scene.add_geometry(ball, transform=trimesh.transformations.translation_matrix([5e6, 0, 0]))
    scene.add_geometry(trimesh.PointCloud([[1.0, 2, 3]]))
    scene.export(tmp_path / "scene.glb")
    cloud = neurbs.read_point_cloud(tmp_path / "scene.glb")
    assert len(cloud) == len(ball.vertices) + 1
    assert cloud.points.max(axis=0).tolist() == pytest.approx([5e6 + 1, 2, 3])
    assert cloud.unit == "m"


# Damaged files and missing libraries

SCANS: dict[str, Callable[[Path], None]] = {
    ".las": lambda path: write_las(path, survey(5000)),
    ".laz": lambda path: write_las(path, survey(5000)),
    ".e57": lambda path: write_e57(path, [survey(5000)]),
    ".tif": lambda path: write_geotiff(path, survey(5000)[:, 2].reshape(50, 100)),
    ".vtu": lambda path: meshio.Mesh(survey(5000), [("vertex", np.zeros((1, 1), int))]).write(path),
    ".glb": lambda path: trimesh.creation.icosphere(4).export(path),
    ".stl": lambda path: trimesh.creation.icosphere(4).export(path),
    ".off": lambda path: trimesh.creation.icosphere(4).export(path),
    ".npz": lambda path: np.savez_compressed(path, points=survey(5000)),
}


@pytest.mark.parametrize("share", [0.0, 0.02, 0.4, 0.9])
@pytest.mark.parametrize("suffix", SCANS)
def test_a_truncated_file_is_refused(
    tmp_path: Path, suffix: str, share: float, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / f"a{suffix}"
    if (suffix, share) == (".off", 0.9):
        pytest.skip("all points are there, and only triangles are lost")
    SCANS[suffix](path)
    assert len(neurbs.read_points(path)) > 1000
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(NeurbsError, match=rf"^{re.escape(str(path))}: "):
        neurbs.read_points(path)
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize(
    ("module", "suffix", "extra"),
    [
        ("laspy", ".laz", "io"),
        ("pye57", ".e57", "io"),
        ("rasterio", ".tif", "io"),
        ("vtkmodules", ".vtu", "vtk"),
        ("pyproj", ".las", "io"),
    ],
)
def test_a_missing_library_is_named(
    tmp_path: Path, module: str, suffix: str, extra: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / f"a{suffix}"
    SCANS[suffix](path)
    for name in list(sys.modules):
        if name.partition(".")[0] == module:
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(sys, "meta_path", [Missing(module), *sys.meta_path])
    message = rf"{suffix} files need {module[:3]}.*: pip install 'neurbs\[{extra}\]'"
    with pytest.raises(NeurbsError, match=message):
        neurbs.read_point_cloud(path)


class Missing:
    """Import finder that hides a module."""

    def __init__(self, name: str) -> None:
        self.name = name

    def find_spec(self, name: str, *_: object) -> None:
        """Raise the error of Python for a missing module."""
        if name.partition(".")[0] == self.name:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
