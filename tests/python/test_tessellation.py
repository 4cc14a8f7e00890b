"""Adaptive meshes and the methods of a mesh."""

import subprocess
import sys
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

import neurbs
from neurbs import NeurbsError, NurbsSurface, Progress

Array = NDArray[np.float64]


def waves(seed: int = 0) -> NurbsSurface:
    """Return a rational surface over a rough net."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(9.0), np.arange(7.0), indexing="ij")
    net = np.stack([x, y, rng.uniform(0, 2, x.shape)], axis=-1)
    return NurbsSurface(net, rng.uniform(0.5, 2, x.shape))


def diagonal(surface: NurbsSurface) -> float:
    return float(np.linalg.norm(np.ptp(surface.control_points.reshape(-1, 3), axis=0)))


@pytest.mark.parametrize("tolerance", [0.1, 0.01, 0.001])
def test_meshes_keep_their_tolerance(tolerance: float) -> None:
    surface = waves()
    mesh = surface.tessellate(tolerance)
    assert mesh.max_deviation is not None
    assert 0.5 * tolerance < mesh.max_deviation <= tolerance
    uv = np.random.default_rng(1).random((20_000, 2))
    assert mesh.deviation(surface.evaluate(uv)).max() <= mesh.max_deviation
    centers = mesh.vertices[mesh.triangles].mean(axis=1)
    assert surface.closest_points(centers).distances.max() <= mesh.max_deviation
    np.testing.assert_allclose(mesh.vertices, surface.evaluate(mesh.uv), atol=1e-13)
    np.testing.assert_allclose(mesh.normals, surface.normals(mesh.uv), atol=1e-12)


def test_tolerances_are_lengths_or_shares() -> None:
    surface = waves()
    default, relative = surface.tessellate(), surface.tessellate(1e-3, relative=True)
    absolute = surface.tessellate(1e-3 * diagonal(surface))
    for mesh in (relative, absolute):
        np.testing.assert_array_equal(mesh.triangles, default.triangles)
        np.testing.assert_array_equal(mesh.vertices, default.vertices)


def test_measures_of_a_mesh_agree_with_trimesh() -> None:
    mesh = NurbsSurface.torus([5, 5, 5], 3, 1).tessellate(0.001)
    other = mesh.to_trimesh()
    assert isinstance(other, trimesh.Trimesh)
    assert other.is_watertight
    assert other.is_winding_consistent
    assert mesh.volume() == pytest.approx(other.volume, rel=1e-12)
    assert mesh.area() == pytest.approx(other.area, rel=1e-12)
    assert mesh.euler_characteristic() == other.euler_number == 0
    assert mesh.boundary_loops() == []
    points = np.random.default_rng(0).uniform(0, 10, (200, 3))
    expected = trimesh.proximity.closest_point_naive(other, points)[1]
    np.testing.assert_allclose(mesh.deviation(points), expected, atol=1e-12)
    out = np.empty(200)
    assert mesh.deviation(points, out=out) is out


def test_sheets_have_one_border() -> None:
    mesh = waves().tessellate(0.05)
    (border,) = mesh.boundary_loops()
    assert mesh.volume() is None
    assert mesh.euler_characteristic() == 1
    ends = mesh.uv[border]
    assert (((ends == 0) | (ends == 1)).any(axis=1)).all()
    edges = set(zip(border.tolist(), np.roll(border, -1).tolist(), strict=True))
    sides = mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).tolist()
    assert edges <= {(a, b) for a, b in sides}


def test_poles_are_one_vertex_and_seams_may_be_split() -> None:
    sphere = NurbsSurface.sphere([0, 0, 0], 1)
    mesh = sphere.tessellate(0.001)
    assert mesh.euler_characteristic() == 2
    assert mesh.volume() == pytest.approx(4 / 3 * np.pi, rel=2e-3)
    assert (np.linalg.norm(mesh.vertices - [0, 0, 1], axis=1) < 1e-9).sum() == 1
    split = sphere.tessellate(0.001, split_seams=True)
    assert split.euler_characteristic() == 1
    assert len(split.triangles) == len(mesh.triangles)


def test_uniform_grids_have_quads() -> None:
    mesh = waves().tessellate(shape=(4, 6))
    assert mesh.max_deviation is None
    assert mesh.quads is not None
    assert mesh.quads.shape == (15, 4)
    assert mesh.quads.dtype == np.uint32
    np.testing.assert_array_equal(mesh.quads[:, :3], mesh.triangles[::2])
    assert waves().tessellate(0.1).quads is None
    assert waves().tessellate(0.1).shape is None


def test_limits_are_kept() -> None:
    surface = waves()
    short = surface.tessellate(max_edge=0.25)
    a, b, c = (short.vertices[corner] for corner in short.triangles.T)
    assert max(np.linalg.norm(x - y, axis=1).max() for x, y in ((a, b), (b, c), (c, a))) <= 0.25
    smooth = surface.tessellate(0.05, max_angle=0.1)
    a, b, c = (smooth.normals[corner] for corner in smooth.triangles.T)
    assert min((x * y).sum(1).min() for x, y in ((a, b), (b, c), (c, a))) >= np.cos(0.1) - 1e-12


def test_several_surfaces_share_one_tolerance() -> None:
    spheres = [NurbsSurface.sphere([0, 0, 0], radius) for radius in (1, 10)]
    small, large = neurbs.tessellate(iter(spheres))
    np.testing.assert_array_equal(large.triangles, spheres[1].tessellate().triangles)
    assert len(small.triangles) < len(spheres[0].tessellate().triangles)
    with pytest.raises(NeurbsError, match="surfaces must be an iterable of NurbsSurface"):
        neurbs.tessellate([1, 2])  # type: ignore[list-item]


@pytest.mark.parametrize("topology", ["sheet", "tube", "torus"])
def test_a_lattice_is_a_mesh(topology: Literal["sheet", "tube", "torus"]) -> None:
    points = np.random.default_rng(0).random((500, 3))
    som = neurbs.SelfOrganizingMap(5, 4, topology=topology, max_steps=500).fit(points)
    mesh = som.mesh()
    np.testing.assert_allclose(mesh.vertices, som.codebook_.reshape(-1, 3), atol=1e-15)
    assert mesh.euler_characteristic() == (1 if topology == "sheet" else 0)
    cells = {"sheet": 12, "tube": 15, "torus": 20}
    assert len(mesh.triangles) == 2 * cells[topology]


def test_a_graph_is_no_mesh() -> None:
    ring = neurbs.Lattice.graph(6, [(i, (i + 1) % 6) for i in range(6)])
    som = neurbs.SelfOrganizingMap(lattice=ring, init="random", max_steps=100)
    with pytest.raises(NeurbsError, match="lattice must have cells"):
        som.fit(np.random.default_rng(0).random((50, 3))).mesh()


def test_meshes_have_a_method_save(tmp_path: Path) -> None:
    mesh = waves().tessellate(0.1)
    mesh.save(tmp_path / "mesh.ply")
    loaded = trimesh.load(tmp_path / "mesh.ply", process=False)
    np.testing.assert_array_equal(loaded.faces, mesh.triangles)


def test_pyvista_gets_the_mesh() -> None:
    pyvista = pytest.importorskip("pyvista")
    mesh = waves().tessellate(0.1)
    other = mesh.to_pyvista()
    assert isinstance(other, pyvista.PolyData)
    assert other.n_cells == len(mesh.triangles)
    np.testing.assert_allclose(other.point_data["Normals"], mesh.normals)


def test_pyvista_and_trimesh_are_not_needed_for_meshes() -> None:
    script = """
        import sys
        import neurbs
        neurbs.NurbsSurface.sphere([0, 0, 0], 1).tessellate()
        print({"pyvista", "trimesh"} & set(sys.modules))
    """
    script = "\n".join(line.strip() for line in script.splitlines())
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert run.stdout.strip() == "set()", run.stderr


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"tolerance": 0.0}, "tolerance must be positive and finite, got 0"),
        ({"tolerance": -1.0}, "tolerance must be positive and finite, got -1"),
        ({"tolerance": np.nan}, "tolerance must be positive and finite, got NaN"),
        ({"tolerance": "fine"}, "tolerance must be a number, got 'fine'"),
        ({"tolerance": 1e-13}, "at most 100000000 triangles, got 1e-13, which would take about"),
        ({"max_triangles": 10}, "at most 10 triangles"),
        ({"max_aspect": 1.0}, "max_aspect must be finite and at least 4, got 1"),
        ({"max_edge": 0.0}, "max_edge must be positive and finite"),
        ({"shape": (4, 4), "tolerance": 0.1}, "shape must be None if a limit is given"),
    ],
    ids=str,
)
def test_impossible_limits_are_refused(keywords: dict[str, object], message: str) -> None:
    with pytest.raises(NeurbsError, match=message):
        waves().tessellate(**keywords)  # type: ignore[arg-type]


def test_progress_is_reported() -> None:
    seen: list[Progress] = []
    waves().tessellate(0.01, progress=seen.append)
    assert {progress.stage for progress in seen} == {"tessellation"}


@pytest.mark.parametrize("threads", [1, 2, 7])
def test_threads_change_no_bit(threads: int) -> None:
    script = """
        import hashlib
        import numpy as np
        import neurbs
        net = np.random.default_rng(0).random((9, 7, 3))
        mesh = neurbs.NurbsSurface(net).tessellate(1e-3)
        arrays = (mesh.vertices, mesh.triangles, mesh.normals, mesh.uv)
        print(hashlib.sha256(b"".join(a.tobytes() for a in arrays)).hexdigest())
    """
    script = "\n".join(line.strip() for line in script.splitlines())
    runs = [
        subprocess.run(
            [sys.executable, "-c", script],
            env={"RAYON_NUM_THREADS": str(count), "PYTHONPATH": ":".join(sys.path)},
            capture_output=True,
            text=True,
        ).stdout
        for count in (1, threads)
    ]
    assert runs[0] == runs[1] != ""
