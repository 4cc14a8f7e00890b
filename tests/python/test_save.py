"""Results to files: read back by other readers, whole or not there."""

import os
import re
import stat
import subprocess
import sys
import textwrap
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

import neurbs
from neurbs import NeurbsError, NurbsSurface, Reconstruction
from neurbs.io import check_target
from neurbs.io.replacement import replacement

MESHES = (".obj", ".ply", ".glb", ".stl")
SURFACES = (".step", ".stp", ".igs", ".iges")


def plane() -> NurbsSurface:
    x, y = np.meshgrid(np.arange(5.0), np.arange(4.0), indexing="ij")
    return NurbsSurface(np.stack([x, y, x * y], axis=-1))


def existing(path: Path) -> Path:
    path.write_text("before")
    return path


def loaded(path: Path) -> tuple[Any, NDArray[np.float64]]:
    """Read a mesh as others do, and where its vertices are placed in the scene."""
    scene = trimesh.load(path, force="scene", process=False)
    (node,) = scene.graph.nodes_geometry
    transform, name = scene.graph[node]
    mesh = scene.geometry[name]
    return mesh, trimesh.transform_points(mesh.vertices, transform)


@pytest.mark.parametrize(("suffix", "lost"), [(".obj", 0), (".ply", 0), (".glb", 1e-5)])
def test_meshes_keep_their_digits(
    tmp_path: Path, result: Reconstruction, suffix: str, lost: float
) -> None:
    path = tmp_path / f"mesh{suffix}"
    neurbs.save(result.mesh, path)
    mesh, placed = loaded(path)
    np.testing.assert_array_equal(mesh.faces, result.mesh.triangles)
    np.testing.assert_allclose(placed, result.mesh.vertices, rtol=0, atol=lost)
    np.testing.assert_allclose(mesh.vertex_normals, result.mesh.normals, rtol=0, atol=1e-6)
    if suffix in (".obj", ".ply"):
        np.testing.assert_array_equal(neurbs.read_points(path), result.mesh.vertices)


def test_stl_says_what_it_loses(tmp_path: Path, result: Reconstruction) -> None:
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
        (plane().tessellate(), ".step", "surface, which a TriangleMesh has not: .* as .obj .ply"),
        (plane().tessellate(), ".png", "picture, which a TriangleMesh has not"),
        (
            plane(),
            ".png",
            "picture, which a NurbsSurface has not: .* as .step .stp .igs .iges .obj",
        ),
        (np.zeros((3, 3)), ".obj", "mesh, which a ndarray has not: it can be written as nothing"),
    ],
)
def test_a_thing_in_the_wrong_file(tmp_path: Path, thing: Any, suffix: str, message: str) -> None:
    with pytest.raises(NeurbsError, match=f"a{suffix}: this file holds a {message}"):
        neurbs.save(thing, tmp_path / f"a{suffix}")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("check", [check_target, lambda path: neurbs.save(plane(), path)])
def test_places_where_nothing_can_be_written(tmp_path: Path, check: Any) -> None:
    with pytest.raises(NeurbsError, match=r"\.step \.stp .*\.png, got the suffix '\.foo'"):
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
@pytest.mark.parametrize("suffix", [".step", ".ply", ".glb", ".png"])
def test_permissions_are_those_of_any_new_file(
    tmp_path: Path, result: Reconstruction, suffix: str
) -> None:
    path = tmp_path / f"a{suffix}"
    result.save(path)
    assert path.stat().st_mode & 0o777 == 0o640


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_a_failure_leaves_what_was_there(tmp_path: Path, error: type[BaseException]) -> None:
    path = existing(tmp_path / "a.txt")
    with pytest.raises(error), replacement(path) as new:  # noqa: PT012
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
@pytest.mark.parametrize("suffix", [*SURFACES[:1], *SURFACES[2:3], *MESHES, ".png"])
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
    assert done.stdout.strip() == f"{path} File too large"
    assert path.read_text() == "before"
    assert list(tmp_path.iterdir()) == [path]


def test_importing_neurbs_is_light() -> None:
    heavy = {"matplotlib", "pydantic", "rich", "trimesh", "typer"}
    code = f"import sys, neurbs; print({heavy} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
@pytest.mark.parametrize("suffix", [".glb", ".stl"])
def test_ctrl_c_is_not_lost_in_a_library(suffix: str, tmp_path: Path) -> None:
    """Interrupt in a process that has not imported trimesh yet, where it used to be swallowed."""
    path = tmp_path / f"a{suffix}"
    script = f"""
        import os, signal, threading
        import numpy as np
        import neurbs

        mesh = neurbs.NurbsSurface(np.random.default_rng(0).random((4, 4, 3))).tessellate()
        threading.Timer(0.03, os.kill, (os.getpid(), signal.SIGINT)).start()
        try:
            neurbs.save(mesh, {str(path)!r})
            print("written")
        except KeyboardInterrupt:
            print("interrupted")
    """
    run = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script)], capture_output=True, text=True, timeout=60
    )
    assert run.stdout == "interrupted\n", run.stderr
    assert not any(tmp_path.iterdir())


@pytest.mark.skipif(os.name == "nt", reason="modes of POSIX")
def test_a_replaced_file_keeps_its_mode(result: neurbs.Reconstruction, tmp_path: Path) -> None:
    path = tmp_path / "private.step"
    path.touch(0o600)
    result.save(path)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


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
