"""Results to files: content, and atomic writing."""

import os
import re
import stat
import subprocess
import sys
import textwrap
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

import neurbs
from neurbs import NeurbsError, NurbsSurface, Reconstruction
from neurbs.io import check_target
from neurbs.io.atomic_write import atomic_write

MESHES = (".obj", ".ply", ".glb", ".stl", ".vtp", ".off")
SURFACES = (".step", ".stp", ".igs", ".iges", ".3dm", ".json")


def plane() -> NurbsSurface:
    x, y = np.meshgrid(np.arange(5.0), np.arange(4.0), indexing="ij")
    return NurbsSurface(np.stack([x, y, x * y], axis=-1))


def existing(path: Path) -> Path:
    path.write_text("before")
    return path


def loaded(path: Path) -> tuple[Any, NDArray[np.float64]]:
    """Read a mesh with trimesh, with its vertices in the frame of the scene."""
    scene = trimesh.load(path, force="scene", process=False)
    (node,) = scene.graph.nodes_geometry
    transform, name = scene.graph[node]
    mesh = scene.geometry[name]
    return mesh, trimesh.transform_points(mesh.vertices, transform)


@pytest.mark.parametrize(
    ("suffix", "lost"), [(".obj", 0), (".ply", 0), (".glb", 1e-5), (".off", 0)]
)
def test_meshes_keep_their_digits(
    tmp_path: Path, result: Reconstruction, suffix: str, lost: float
) -> None:
    path = tmp_path / f"mesh{suffix}"
    neurbs.save(result.mesh, path)
    mesh, placed = loaded(path)
    np.testing.assert_array_equal(mesh.faces, result.mesh.triangles)
    np.testing.assert_allclose(placed, result.mesh.vertices, rtol=0, atol=lost)
    if suffix != ".off":
        np.testing.assert_allclose(mesh.vertex_normals, result.mesh.normals, rtol=0, atol=1e-6)
    if suffix != ".glb":
        np.testing.assert_array_equal(neurbs.read_points(path), result.mesh.vertices)


def test_vtp_has_all_of_a_mesh(tmp_path: Path, result: Reconstruction) -> None:
    neurbs.save(result.mesh, tmp_path / "a.vtp")
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(str(tmp_path / "a.vtp"))
    reader.Update()
    data = reader.GetOutput()
    mesh, attributes = result.mesh, data.GetPointData()
    corners = vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    np.testing.assert_array_equal(corners, mesh.triangles)
    np.testing.assert_array_equal(vtk_to_numpy(data.GetPoints().GetData()), mesh.vertices)
    np.testing.assert_allclose(vtk_to_numpy(attributes.GetNormals()), mesh.normals, atol=1e-7)
    np.testing.assert_array_equal(vtk_to_numpy(attributes.GetArray("uv")), mesh.uv)


@pytest.mark.parametrize(("unit", "meters"), [(None, 1), ("mm", 1e-3), ("in", 0.0254)])
def test_glb_is_in_meters(tmp_path: Path, unit: str | None, meters: float) -> None:
    mesh = plane().tessellate()
    neurbs.save(mesh, tmp_path / "a.glb", unit=unit)
    _, placed = loaded(tmp_path / "a.glb")
    np.testing.assert_allclose(placed, meters * mesh.vertices, rtol=0, atol=1e-6 * meters)


def test_stl_has_the_normals_of_its_triangles(tmp_path: Path) -> None:
    mesh = plane().tessellate(shape=(9, 7))
    neurbs.save(mesh, tmp_path / "a.stl")
    record = [("normal", "<f4", 3), ("corners", "<f4", 9), ("attributes", "<u2")]
    table = np.fromfile(tmp_path / "a.stl", np.dtype(record), offset=84)
    theirs, _ = loaded(tmp_path / "a.stl")
    np.testing.assert_allclose(table["normal"], theirs.face_normals, atol=1e-6)


POINTS = neurbs.PointCloud(
    np.array([[5000000.001, 7500000.0, 120.25], [0.1, -1e-300, 1e300], [1 / 3, 2.0, 3.0]]),
    np.eye(3),
    np.array([[1, 2, 3], [4, 5, 6], [7, 8, 255]], np.uint8),
    np.array([0.1, 2.0, 1e-9]),
)


def test_points_with_distances_as_ply(tmp_path: Path) -> None:
    neurbs.save(POINTS, tmp_path / "a.ply")
    mesh = meshio.read(tmp_path / "a.ply")
    np.testing.assert_array_equal(mesh.points, POINTS.points)
    np.testing.assert_array_equal(mesh.point_data["distance"], POINTS.distances)
    np.testing.assert_array_equal(trimesh.load(tmp_path / "a.ply").colors[:, :3], POINTS.colors)
    neurbs.save(neurbs.PointCloud(POINTS.points), tmp_path / "b.ply")
    np.testing.assert_array_equal(meshio.read(tmp_path / "b.ply").points, POINTS.points)


def test_points_with_distances_as_csv(tmp_path: Path) -> None:
    neurbs.save(POINTS, tmp_path / "a.csv")
    table = np.genfromtxt(tmp_path / "a.csv", delimiter=",", names=True)
    assert table.dtype.names == (*"xyz", "nx", "ny", "nz", "red", "green", "blue", "distance")
    np.testing.assert_array_equal(table["distance"], POINTS.distances)
    read = neurbs.read_point_cloud(tmp_path / "a.csv")
    for name in ("points", "normals", "colors"):
        np.testing.assert_array_equal(getattr(read, name), getattr(POINTS, name))


def test_a_result_as_csv_has_its_distances(tmp_path: Path, result: Reconstruction) -> None:
    result.save(tmp_path / "a.csv")
    table = np.genfromtxt(tmp_path / "a.csv", delimiter=",", names=True)
    points = np.column_stack([table[axis] for axis in "xyz"])
    np.testing.assert_array_equal(points, result.points)
    distances = result.surface.closest_points(points).distances
    np.testing.assert_array_equal(table["distance"], distances)


def test_an_unknown_unit(tmp_path: Path) -> None:
    message = "unit must be 'mm' or 'cm' or 'm' or 'in' or 'ft', got 'parsec'"
    for suffix in (".step", ".obj"):
        with pytest.raises(NeurbsError, match=message):
            neurbs.save(plane(), tmp_path / f"a{suffix}", unit="parsec")
    assert list(tmp_path.iterdir()) == []


def test_stl_warns_of_lost_digits(tmp_path: Path, result: Reconstruction) -> None:
    with pytest.warns(
        UserWarning, match=r"moves vertices by up to 0\.\d+ .*\.ply, \.obj and \.glb"
    ) as seen:
        neurbs.save(result.mesh, tmp_path / "far.stl")
    assert seen[0].filename == __file__
    mesh, _ = loaded(tmp_path / "far.stl")
    assert len(mesh.faces) == len(result.mesh.triangles)


def test_stl_near_the_origin_is_good_enough(
    tmp_path: Path, terrain_points: NDArray[np.float64]
) -> None:
    mesh = neurbs.reconstruct(terrain_points, grid=(6, 6)).mesh
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        neurbs.save(mesh, tmp_path / "near.stl")
    corners = mesh.vertices[mesh.triangles]
    read, _ = loaded(tmp_path / "near.stl")
    np.testing.assert_allclose(read.triangles, corners, rtol=1e-6)


def test_numbers_beyond_single_precision(tmp_path: Path) -> None:
    mesh = NurbsSurface(1e100 * np.array(plane().control_points)).tessellate()
    for suffix in (".stl", ".glb"):
        with pytest.raises(NeurbsError, match=r"coordinates reach .* change their unit"):
            neurbs.save(mesh, tmp_path / f"a{suffix}")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("suffix", [*SURFACES, *MESHES, ".STEP", ".Obj"])
def test_a_surface_and_a_result_go_into_every_file(
    tmp_path: Path, suffix: str, result: Reconstruction
) -> None:
    neurbs.save(plane(), tmp_path / f"surface{suffix}")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        result.save(str(tmp_path / f"result{suffix}"))
    sizes = {path.name: path.stat().st_size for path in tmp_path.iterdir()}
    assert set(sizes) == {f"surface{suffix}", f"result{suffix}"}
    assert min(sizes.values()) > 400


def test_a_surface_is_tessellated_with_its_defaults(tmp_path: Path) -> None:
    neurbs.save(plane(), tmp_path / "plane.ply")
    np.testing.assert_array_equal(
        neurbs.read_points(tmp_path / "plane.ply"), plane().tessellate().vertices
    )


@pytest.mark.parametrize(
    ("thing", "suffix", "message"),
    [
        (
            plane().tessellate(),
            ".step",
            "surface or a shell, got a TriangleMesh: .* as .obj .ply",
        ),
        (plane().tessellate(), ".png", "picture, got a TriangleMesh"),
        (
            plane(),
            ".png",
            "picture, got a NurbsSurface: .* as .step .stp .igs .iges .3dm .json .obj",
        ),
        (POINTS, ".obj", "surface or a shell or a mesh, got a PointCloud: .* as .ply .csv"),
        (np.zeros((3, 3)), ".stl", "mesh, got a ndarray: it can be written as nothing"),
    ],
)
def test_a_thing_in_the_wrong_file(tmp_path: Path, thing: Any, suffix: str, message: str) -> None:
    with pytest.raises(NeurbsError, match=f"a{suffix}: the content must be a {message}"):
        neurbs.save(thing, tmp_path / f"a{suffix}")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("check", [check_target, lambda path: neurbs.save(plane(), path)])
def test_places_where_nothing_can_be_written(tmp_path: Path, check: Any) -> None:
    with pytest.raises(NeurbsError, match=r"\.step \.stp .*\.png .*\.html, got the suffix '\.foo'"):
        check(tmp_path / "a.foo")
    with pytest.raises(NeurbsError, match="got no suffix"):
        check(tmp_path / "a")
    with pytest.raises(FileNotFoundError, match=r"no such folder.*missing"):
        check(tmp_path / "missing" / "a.step")
    with pytest.raises(IsADirectoryError, match=re.escape(str(tmp_path))):
        check(tmp_path)
    with pytest.raises(NotADirectoryError, match=r"p\.xyz"):
        check(existing(tmp_path / "p.xyz") / "a.step")
    assert [path.name for path in tmp_path.iterdir()] == ["p.xyz"]


def test_places_that_are_protected(tmp_path: Path) -> None:
    path = existing(tmp_path / "a.step")
    path.chmod(0o400)
    if os.access(path, os.W_OK):
        pytest.skip("this user may write everywhere")
    with pytest.raises(PermissionError, match=r"this file must not be replaced.*a\.step"):
        check_target(path)
    tmp_path.chmod(0o500)
    with pytest.raises(PermissionError, match="this folder must not be written to"):
        check_target(tmp_path / "b.step")
    tmp_path.chmod(0o700)


def test_a_picture_needs_matplotlib(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(NeurbsError, match=r"pip install 'neurbs\[plot\]'"):
        check_target(tmp_path / "a.png")


@pytest.fixture
def umask() -> Iterator[None]:
    before = os.umask(0o027)
    yield
    os.umask(before)


@pytest.mark.usefixtures("umask")
@pytest.mark.skipif(os.name == "nt", reason="permissions are those of POSIX")
@pytest.mark.parametrize("suffix", [".step", ".ply", ".glb", ".3dm", ".csv", ".png"])
def test_permissions_are_those_of_any_new_file(
    tmp_path: Path, result: Reconstruction, suffix: str
) -> None:
    path = tmp_path / f"a{suffix}"
    result.save(path)
    assert path.stat().st_mode & 0o777 == 0o640


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_a_failure_leaves_what_was_there(tmp_path: Path, error: type[BaseException]) -> None:
    path = existing(tmp_path / "a.txt")
    with pytest.raises(error), atomic_write(path) as new:  # noqa: PT012
        Path(new).write_text("half")
        raise error
    assert path.read_text() == "before"
    assert list(tmp_path.iterdir()) == [path]


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    target = existing(tmp_path / "target.step")
    link = tmp_path / "link.step"
    link.symlink_to(target.name)
    neurbs.save(plane(), link)
    assert link.is_symlink()
    assert target.read_text().startswith("ISO-10303-21")


def test_a_link_in_a_circle_is_replaced(tmp_path: Path) -> None:
    link = tmp_path / "link.step"
    link.symlink_to(link.name)
    neurbs.save(plane(), link)
    assert link.is_file()


def test_the_longest_name(tmp_path: Path) -> None:
    path = tmp_path / ("a" * 250 + ".step")
    neurbs.save(plane(), path)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.skipif(os.name == "nt", reason="file sizes are limited by POSIX")
@pytest.mark.parametrize("suffix", [".step", ".igs", ".3dm", ".json", ".csv", *MESHES, ".png"])
def test_a_full_disk_leaves_what_was_there(tmp_path: Path, suffix: str) -> None:
    path = existing(tmp_path / f"a{suffix}")
    code = f"""
        import resource, warnings
        import numpy as np
        import neurbs
        x, y = np.random.default_rng(0).random((2, 100))
        result = neurbs.reconstruct(np.column_stack([x, y, x * y]), grid=(8, 8))
        import matplotlib.font_manager  # which writes its cache of fonts before there is a limit
        resource.setrlimit(resource.RLIMIT_FSIZE, (3000, 3000))
        try:
            result.save({str(path)!r})
        except OSError as error:
            print(error.filename, error.strerror)
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True, check=True
    )
    # Rhino's library hides the error of the system.
    reasons = {".3dm": "Rhino's library cannot write this file"}
    assert done.stdout.strip() == f"{path} {reasons.get(suffix, 'File too large')}"
    assert path.read_text() == "before"
    assert list(tmp_path.iterdir()) == [path]


def test_importing_neurbs_is_light() -> None:
    heavy = {"OCP", "laspy", "matplotlib", "pydantic", "pye57", "rasterio", "rhino3dm"}
    heavy |= {"rich", "trimesh", "typer", "vtkmodules"}
    code = f"import sys, neurbs; print({heavy} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
@pytest.mark.parametrize("suffix", MESHES)
def test_ctrl_c_is_answered_while_a_large_mesh_is_written(
    suffix: str, unanswered: Callable[..., float], tmp_path: Path
) -> None:
    before = """
        surface = neurbs.NurbsSurface(np.random.default_rng(0).random((4, 4, 3)))
        mesh = surface.tessellate(shape=(3000, 3000))
    """
    call = f"neurbs.save(mesh, {str(tmp_path / f'a{suffix}')!r})"
    assert any(unanswered(before, call, 0.1) < 0.2 for _ in range(3))
    assert not any(tmp_path.iterdir())


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_ctrl_c_is_not_lost_in_a_library(unanswered: Callable[..., float], tmp_path: Path) -> None:
    """Interrupt the import of trimesh, which catches all exceptions."""
    path = tmp_path / "a.stl"
    neurbs.save(plane().tessellate(), path)
    assert unanswered("", f"neurbs.read_points({str(path)!r})", 0.03) > 0


@pytest.mark.skipif(os.name == "nt", reason="modes of POSIX")
def test_a_replaced_file_keeps_its_mode(result: neurbs.Reconstruction, tmp_path: Path) -> None:
    path = tmp_path / "private.step"
    path.touch(0o600)
    result.save(path)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="root gives files away")
def test_a_replaced_file_keeps_its_owner(result: neurbs.Reconstruction, tmp_path: Path) -> None:
    path = tmp_path / "theirs.step"
    path.touch(0o640)
    os.chown(path, 12345, 54321)
    result.save(path)
    now = path.stat()
    assert (now.st_uid, now.st_gid, stat.S_IMODE(now.st_mode)) == (12345, 54321, 0o640)


@pytest.mark.skipif(os.name == "nt", reason="pipes of POSIX")
def test_a_pipe_is_not_replaced(result: neurbs.Reconstruction, tmp_path: Path) -> None:
    path = tmp_path / "pipe.step"
    os.mkfifo(path)
    with pytest.raises(NeurbsError, match="a device or a pipe"):
        result.save(path)
    assert path.is_fifo()
    points = tmp_path / "pipe.xyz"
    os.mkfifo(points)
    with pytest.raises(NeurbsError, match="a device or a pipe"):
        neurbs.read_points(points)
