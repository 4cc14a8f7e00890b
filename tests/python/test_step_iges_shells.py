"""Surfaces and shells in STEP and IGES files, as OpenCASCADE reads them."""

import os
import re
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeSolid
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.GProp import GProp_GProps
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.IGESControl import IGESControl_Reader
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import (
    TopAbs_EDGE,
    TopAbs_FACE,
    TopAbs_REVERSED,
    TopAbs_SHELL,
    TopAbs_SOLID,
    TopAbs_WIRE,
)
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

import neurbs
from neurbs import NurbsCurve, NurbsSurface

SUFFIXES = (".step", ".igs")

FAR = (1e7, -2e7, 3e6)

Points = NDArray[np.float64]


def cast(shape: Any, kind: str) -> Any:
    """Cast a shape; the functions were renamed between versions 7 and 8 of the bindings."""
    return (getattr(TopoDS, f"{kind}_s", None) or getattr(TopoDS, kind))(shape)


class Read:
    """A file as OpenCASCADE reads it."""

    def __init__(self, path: Path) -> None:
        reader = STEPControl_Reader() if path.suffix == ".step" else IGESControl_Reader()
        assert reader.ReadFile(str(path)) == IFSelect_ReturnStatus.IFSelect_RetDone
        reader.TransferRoots()
        self.shape = reader.OneShape()
        assert BRepCheck_Analyzer(self.shape).IsValid()

    def parts(self, kind: Any) -> list[Any]:
        """Return the faces, edges or other parts."""
        explorer, found = TopExp_Explorer(self.shape, kind), []
        while explorer.More():
            found.append(explorer.Current())
            explorer.Next()
        return found

    @property
    def counts(self) -> tuple[int, int]:
        """The numbers of faces and of wires."""
        return len(self.parts(TopAbs_FACE)), len(self.parts(TopAbs_WIRE))

    def area(self) -> float:
        """Return the area of all faces."""
        properties = GProp_GProps()
        BRepGProp.SurfaceProperties_s(self.shape, properties, 1e-10)
        return float(properties.Mass())

    def volume(self) -> float:
        """Return the volume of the solid in the file, or of the one that its shell makes."""
        solids = self.parts(TopAbs_SOLID)
        if not solids:
            (shell,) = self.parts(TopAbs_SHELL)
            solids = [BRepBuilderAPI_MakeSolid(cast(shell, "Shell")).Solid()]
        (solid,) = solids
        assert BRepCheck_Analyzer(solid).IsValid()
        properties = GProp_GProps()
        BRepGProp.VolumeProperties_s(solid, properties, 1e-10, False, False)
        return float(properties.Mass())

    def is_closed(self) -> bool:
        """Return whether all shells are closed."""
        return all(BRep_Tool.IsClosed_s(shell) for shell in self.parts(TopAbs_SHELL))

    def edge_tolerance(self) -> float:
        """Return the largest distance between curves of an edge that OpenCASCADE found."""
        edges = self.parts(TopAbs_EDGE)
        return max(float(BRep_Tool.Tolerance_s(cast(edge, "Edge"))) for edge in edges)

    def mesh_counts(self, size: float) -> tuple[int, int, int]:
        """Return numbers of border edges, of wrong ones, and the Euler characteristic.

        Vertices within 1e-7 of the diagonal are merged. An edge is wrong if it is in more than two
        triangles, or in two that are oriented differently.
        """
        BRepMesh_IncrementalMesh(self.shape, 1e-3 * size, False, 0.3, False)
        all_points: list[Points] = []
        all_triangles, count = [], 0
        for face in self.parts(TopAbs_FACE):
            mesh = BRep_Tool.Triangulation_s(cast(face, "Face"), TopLoc_Location())
            assert mesh is not None
            points = np.array([mesh.Node(i).Coord() for i in range(1, mesh.NbNodes() + 1)])
            ids = range(1, mesh.NbTriangles() + 1)
            triangles = np.array([mesh.Triangle(i).Get() for i in ids]) - 1
            turned = face.Orientation() == TopAbs_REVERSED
            all_triangles.append((triangles[:, ::-1] if turned else triangles) + count)
            all_points.append(points)
            count += len(points)
        points = np.concatenate(all_points)
        diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
        a, b = cKDTree(points).query_pairs(1e-7 * diagonal, output_type="ndarray").T
        _, merged = connected_components(coo_matrix((np.ones(len(a)), (a, b)), shape=(count,) * 2))
        triangles = merged[np.concatenate(all_triangles)]
        distinct = (np.diff(np.sort(triangles, axis=1), axis=1) > 0).all(axis=1)
        triangles = triangles[distinct]
        sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
        edges, uses = np.unique(np.sort(sides, axis=1), axis=0, return_counts=True)
        wrong = int((uses > 2).sum()) + len(sides) - len(np.unique(sides, axis=0))
        euler = len(np.unique(triangles)) - len(edges) + len(triangles)
        return int((uses == 1).sum()), wrong, euler


def declared(path: Path) -> float:
    """Return the uncertainty that a file declares."""
    if path.suffix == ".step":
        found = re.search(r"LENGTH_MEASURE\(([^)]+)\)", path.read_text())
    else:
        lines = path.read_text().splitlines()
        text = "".join(line[:72].rstrip() for line in lines if line[72] == "G")
        found = re.search(r"19700101\.000000,([^,]+),0\.0", text)
    assert found is not None
    return float(found.group(1).replace("D", "e"))


def partials(surface: NurbsSurface, uv: Points) -> tuple[Points, Points]:
    """Return points and the cross products of both derivatives."""
    found = surface.derivatives(uv, 1)
    return found[:, 0, 0], np.cross(found[:, 1, 0], found[:, 0, 1])


def nodes(surface: NurbsSurface) -> Iterator[tuple[Points, Points]]:
    """Yield parameters and weights of Gauss rules on all patches."""
    x, w = np.polynomial.legendre.leggauss(20)
    knots = zip(surface.knots, surface.domain, strict=True)
    spans = [np.unique(k[(k >= a) & (k <= b)]) for k, (a, b) in knots]
    for u0, u1 in pairwise(spans[0]):
        for v0, v1 in pairwise(spans[1]):
            u, v = np.meshgrid((u0 + u1 + (u1 - u0) * x) / 2, (v0 + v1 + (v1 - v0) * x) / 2)
            weights = np.outer(w, w) * (u1 - u0) * (v1 - v0) / 4
            yield np.column_stack([u.ravel(), v.ravel()]), weights.ravel()


def measured(surface: NurbsSurface) -> tuple[float, float]:
    """Return the area of a surface and the volume inside, if it is closed, by quadrature."""
    area, volume = 0.0, 0.0
    middle = surface.control_points.reshape(-1, 3).mean(axis=0)
    for uv, weights in nodes(surface):
        points, crosses = partials(surface, uv)
        area += float(weights @ np.linalg.norm(crosses, axis=1))
        volume += float(weights @ np.einsum("ij,ij->i", points - middle, crosses)) / 3
    return area, abs(volume)


def cloud(kind: str) -> Points:
    """Return points on a bent tube, or on a torus."""
    s, t = np.random.default_rng(5).uniform(0, 1, (2, 3000))
    turn = 2 * np.pi * t
    if kind == "tube":
        radius = 1 + 0.1 * np.sin(5 * s)
        return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), 6 * s])
    around = 2 * np.pi * s
    out = 3 + np.cos(turn)
    return np.column_stack([out * np.cos(around), out * np.sin(around), np.sin(turn)])


def revolved() -> NurbsSurface:
    profile = NurbsCurve([[0, 0, 0], [2, 0, 1], [1, 0, 2], [0, 0, 3]])
    return NurbsSurface.revolved(profile, (0, 0, 0), (0, 0, 1))


def strip() -> NurbsSurface:
    start = NurbsCurve([[0, 0, 0], [1, 1, 0], [2, -1, 1], [3, 0, 0]])
    end = NurbsCurve([[0, 2, 0], [1, 2, 1], [2, 3, 0], [3, 2, 1]])
    return NurbsSurface.ruled(start, end)


def sphere(center: tuple[float, ...] = (0, 0, 0), radius: float = 1) -> NurbsSurface:
    return NurbsSurface.sphere(center, radius)


SURFACES: dict[str, tuple[Callable[[], NurbsSurface], bool, int]] = {
    "sphere": (sphere, True, 2),
    "half sphere": (lambda: sphere().split(v=0.5)[0], False, 1),
    "lune": (lambda: sphere().split(u=0.3)[0], False, 1),
    "torus": (lambda: NurbsSurface.torus((0, 0, 0), 3, 1), True, 0),
    "tube": (lambda: NurbsSurface.cylinder((0, 0, 0), (0, 0, 2), 1), False, 0),
    "cone": (lambda: NurbsSurface.cone((0, 0, 0), (0, 0, 1), 1), False, 1),
    "cone without apex": (lambda: NurbsSurface.cone((0, 0, 0), (0, 0, 1), 1, 0.5), False, 0),
    "from pole to pole": (revolved, True, 2),
    "inside out": (lambda: revolved().reversed(u=True), True, 2),
    "plane": (lambda: NurbsSurface.plane((0, 0, 0), (1, 0, 0), (0, 2, 0)), False, 1),
    "ruled strip": (strip, False, 1),
    "tiny sphere": (lambda: sphere((0, 0, 0), 1e-4), True, 2),
    "far sphere": (lambda: sphere(FAR, 1), True, 2),
    "tiny torus": (lambda: NurbsSurface.torus((0, 0, 0), 3e-4, 1e-4), True, 0),
    "far torus": (lambda: NurbsSurface.torus(FAR, 3, 1), True, 0),
    "reconstructed tube": (
        lambda: neurbs.reconstruct(cloud("tube"), kind="tube").surface,
        False,
        0,
    ),
    "reconstructed torus": (
        lambda: neurbs.reconstruct(cloud("torus"), kind="torus").surface,
        True,
        0,
    ),
}
"""For each surface: whether it is closed, and its Euler characteristic."""


@pytest.mark.parametrize("name", SURFACES)
def test_surfaces_are_one_valid_face_with_seams_and_poles(name: str, tmp_path: Path) -> None:
    make, closed, euler = SURFACES[name]
    surface = make()
    area, volume = measured(surface)
    for suffix in SUFFIXES:
        path = tmp_path / f"a{suffix}"
        neurbs.save(surface, path)
        read = Read(path)
        assert read.counts == (1, 1)
        assert read.area() == pytest.approx(area, rel=1e-6, abs=0)
        if closed:
            assert read.is_closed()
            assert read.volume() == pytest.approx(volume, rel=1e-6, abs=0)
        border, wrong, characteristic = read.mesh_counts(np.sqrt(area))
        assert (border == 0, wrong, characteristic) == (closed, 0, euler)


def check_solid(items: list[Any], volume: float, path: Path, accuracy: float = 1e-9) -> None:
    """Check that faces make one solid of that volume, with a watertight mesh."""
    shell = neurbs.Shell(items)
    for suffix in SUFFIXES:
        neurbs.save(shell, path.with_suffix(suffix))
        read = Read(path.with_suffix(suffix))
        assert len(read.parts(TopAbs_SOLID)) == 1
        assert read.counts == (len(items), len(items))
        assert read.is_closed()
        assert read.volume() == pytest.approx(volume, rel=accuracy, abs=0)
        assert read.mesh_counts(np.cbrt(volume))[:2] == (0, 0)
        assert read.edge_tolerance() <= declared(path.with_suffix(suffix))


def test_six_planes_are_a_solid(tmp_path: Path) -> None:
    axes = np.diag([1.0, 2.0, 3.0])
    faces = []
    for k in range(3):
        a, b, c = axes[k], axes[(k + 1) % 3], axes[(k + 2) % 3]
        faces += [NurbsSurface.plane((0, 0, 0), b, a), NurbsSurface.plane(c, a, b)]
    check_solid(faces, 6, tmp_path / "box")


def circle(u: float, v: float, radius: float, start: float = 0) -> list[NurbsCurve]:
    def turned(angle: float) -> list[float]:
        return [radius * np.cos(angle), radius * np.sin(angle), 0]

    return [NurbsCurve.arc((u, v, 0), turned(start), turned(start + np.pi / 2))]


def polygon(*corners: tuple[float, float]) -> list[NurbsCurve]:
    points = [(u, v, 0.0) for u, v in corners]
    ends = zip(points, [*points[1:], points[0]], strict=True)
    return [NurbsCurve([start, end], degree=1) for start, end in ends]


def test_a_tube_and_two_trimmed_caps_are_a_solid(tmp_path: Path) -> None:
    """The circles of the caps have another start and another parameter than the tube's rims."""
    tube = NurbsSurface.cylinder((0, 0, 0), (0, 0, 2), 1)
    top = NurbsSurface.plane((-2, -2, 2), (4, 0, 0), (0, 4, 0))
    bottom = NurbsSurface.plane((-2, -2, 0), (0, 4, 0), (4, 0, 0))
    caps = [neurbs.Face(plane, [circle(0.5, 0.5, 0.25, 1)]) for plane in (bottom, top)]
    check_solid([tube, *caps], 2 * np.pi, tmp_path / "capped")
    check_solid([*caps, tube], 2 * np.pi, tmp_path / "capped")


@pytest.mark.parametrize(("offset", "accuracy"), [((0, 0, 0), 1e-9), (FAR, 1e-7)])
def test_a_hundred_faces_are_a_solid(
    offset: tuple[float, ...], accuracy: float, tmp_path: Path
) -> None:
    """Far from the origin, coordinates are rounded to 4e-9."""
    cuts = np.linspace(0, 1, 11)
    torus = NurbsSurface.torus(offset, 3, 1)
    faces = [
        torus.sub_surface(u=(u0, u1), v=(v0, v1))
        for u0, u1 in pairwise(cuts)
        for v0, v1 in pairwise(cuts)
    ]
    check_solid(faces, 6 * np.pi**2, tmp_path / "torus", accuracy)


def bumpy(scale: float = 1, offset: tuple[float, ...] = (0, 0, 0)) -> NurbsSurface:
    x, y = np.meshgrid(np.arange(7.0), np.arange(7.0), indexing="ij")
    net = np.stack([x, y, np.sin(1.3 * x) * np.cos(0.9 * y)], axis=2)
    return NurbsSurface(scale * net + offset)


def area_of_disc(surface: NurbsSurface, u: float, v: float, radius: float) -> float:
    """Return the area over a disc in (u, v), by Gauss' rule and equal angles."""
    x, w = np.polynomial.legendre.leggauss(60)
    distance = radius * (1 + x) / 2
    angles = 2 * np.pi * np.arange(240) / 240
    r, angle = np.meshgrid(distance, angles, indexing="ij")
    uv = np.column_stack([(u + r * np.cos(angle)).ravel(), (v + r * np.sin(angle)).ravel()])
    weights = np.repeat(w * distance * radius / 2 * 2 * np.pi / 240, 240)
    return float(weights @ np.linalg.norm(partials(surface, uv)[1], axis=1))


DISC = [(0.5, 0.5, 0.4), (0.35, 0.5, 0.1), (0.7, 0.5, 0.08)]
PLATE = [(0.1 + 0.2 * (k % 5), 0.1 + 0.25 * (k // 5), 0.03) for k in range(20)]
L = ((0.1, 0.1), (0.9, 0.1), (0.9, 0.5), (0.5, 0.5), (0.5, 0.9), (0.1, 0.9))


def trimmed(name: str, surface: NurbsSurface) -> tuple[list[list[NurbsCurve]], float]:
    """Return the loops of a face, and its area."""

    def part(u: tuple[float, float], v: tuple[float, float]) -> float:
        return measured(surface.sub_surface(u=u, v=v))[0]

    if name == "disc with two holes":
        areas = [area_of_disc(surface, *disc) for disc in DISC]
        return [circle(*disc) for disc in DISC], areas[0] - areas[1] - areas[2]
    if name == "L":
        return [polygon(*L)], part((0.1, 0.9), (0.1, 0.5)) + part((0.1, 0.5), (0.5, 0.9))
    outer = polygon((0, 0), (1, 0), (1, 1), (0, 1))
    holes = sum(area_of_disc(surface, *disc) for disc in PLATE)
    return [outer, *(circle(*disc) for disc in PLATE)], measured(surface)[0] - holes


@pytest.mark.parametrize("offset", [(0, 0, 0), FAR])
@pytest.mark.parametrize("name", ["disc with two holes", "L", "plate with 20 holes"])
def test_trimmed_faces_keep_their_loops(
    name: str, offset: tuple[float, ...], tmp_path: Path
) -> None:
    surface = bumpy(1, offset)
    loops, area = trimmed(name, surface)
    shell = neurbs.Shell([neurbs.Face(surface, loops)])
    for suffix in SUFFIXES:
        path = tmp_path / f"a{suffix}"
        neurbs.save(shell, path)
        read = Read(path)
        assert read.counts == (1, len(loops))
        assert read.area() == pytest.approx(area, rel=1e-6, abs=0)
        assert read.edge_tolerance() <= declared(path)
        border, wrong, euler = read.mesh_counts(np.sqrt(area))
        assert (border > 0, wrong, euler) == (True, 0, 2 - len(loops))


def test_tiny_trimmed_faces_are_valid(tmp_path: Path) -> None:
    """OpenCASCADE merges points within 1e-7 mm, 2e-4 of this face."""
    surface = bumpy(1e-4)
    loops, area = trimmed("disc with two holes", surface)
    for suffix in SUFFIXES:
        path = tmp_path / f"a{suffix}"
        neurbs.save(neurbs.Shell([neurbs.Face(surface, loops)]), path)
        read = Read(path)
        assert read.counts == (1, 3)
        assert read.area() == pytest.approx(area, rel=1e-4, abs=0)


def test_a_common_edge_with_two_parameters_joins_two_trimmed_faces(tmp_path: Path) -> None:
    """Both faces lie on one sphere, end at its poles and meet at its seam and at a wave."""
    ball = sphere()
    net = [[0, 0.5, 0], [0.3, 0.6, 0], [0.7, 0.4, 0], [1, 0.5, 0]]
    wave, other = NurbsCurve(net), NurbsCurve(net, weights=[1, 2, 4, 8])

    def lines(*corners: tuple[float, float]) -> list[NurbsCurve]:
        return polygon(*corners)[:-1]

    low = [*lines((0, 0.5), (0, 0), (1, 0), (1, 0.5)), wave.reversed()]
    high = [other, *lines((1, 0.5), (1, 1), (0, 1), (0, 0.5))]
    faces = [neurbs.Face(ball, [loop]) for loop in (low, high)]
    for order in (faces, faces[::-1]):
        for suffix in SUFFIXES:
            path = tmp_path / f"a{suffix}"
            neurbs.save(neurbs.Shell(order), path)
            read = Read(path)
            assert read.counts == (2, 2)
            assert read.is_closed()
            assert read.volume() == pytest.approx(4 / 3 * np.pi, rel=1e-6, abs=0)
            assert read.mesh_counts(1) == (0, 0, 2)
            assert read.edge_tolerance() <= declared(path)


def flat_disc(count: int) -> Points:
    """Return noisy points on a wavy disc of radius 50 with two holes."""
    rng = np.random.default_rng(3)
    x, y = rng.uniform(-50, 50, (2, 4 * count))
    holes = (np.hypot(x - 20, y) < 9) | (np.hypot(x + 18, y - 10) < 12)
    x, y = (axis[(np.hypot(x, y) < 50) & ~holes][:count] for axis in (x, y))
    return np.column_stack([x, y, 3 * np.sin(x / 20)]) + rng.normal(0, 0.05, (count, 3))


def tube_with_hole(ragged: bool) -> Points:
    """Return points on a tube with a round hole, and with wavy rims on request."""
    turn, z = np.random.default_rng(4).uniform((0, 0), (2 * np.pi, 6), (8000, 2)).T
    kept = np.hypot(np.angle(np.exp(1j * (turn - 2))), z - 3) > 0.7
    if ragged:
        kept &= (z > 0.5 + 0.3 * np.sin(3 * turn)) & (z < 5.5 + 0.3 * np.cos(2 * turn))
    turn, z = turn[kept], z[kept]
    return np.column_stack([np.cos(turn), np.sin(turn), z])


def real(name: str) -> Callable[[], Points]:
    folder = os.environ.get("NEURBS_DATA")
    if not folder:
        return lambda: pytest.skip("NEURBS_DATA names no folder of point clouds")
    return lambda: neurbs.read_points(Path(folder, "npy", f"{name}.npy"))


TRIMMED: dict[str, Callable[[], Points]] = {
    "disc": lambda: flat_disc(2000),
    "tube with a hole": lambda: tube_with_hole(ragged=False),
    "tube with wavy rims": lambda: tube_with_hole(ragged=True),
    **{
        name: real(name)
        for name in (
            "claudius_h000",
            "claudius_h060",
            "claudius_h250",
            "claudius_h330",
            "soybean_leaf",
            "mediapipe_face",
            "am_wave_sheet",
        )
    },
}
"""Points whose reconstructions are trimmed, most of them."""


@pytest.mark.parametrize("name", TRIMMED)
def test_reconstructed_faces_are_valid_in_all_files(name: str, tmp_path: Path) -> None:
    result = neurbs.reconstruct(TRIMMED[name]())
    faces = result.shell.faces
    loops = sum(1 + len(face.inner) for face in faces)
    area = result.shell.area()
    for suffix in (".step", ".igs", ".3dm", ".json", ".obj"):
        path = tmp_path / f"a{suffix}"
        result.shell.save(path) if suffix == ".obj" else result.save(path)
        if suffix in SUFFIXES:
            read = Read(path)
            assert read.counts == (len(faces), loops)
            assert read.area() == pytest.approx(area, rel=1e-4, abs=0)
        again = neurbs.load_shell(path)
        assert sum(1 + len(face.inner) for face in again.faces) == loops
        assert again.area() == pytest.approx(area, rel=1e-6, abs=0)
