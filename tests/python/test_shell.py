"""Faces and shells: construction, measures, queries and triangles, from Python."""

import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs
from neurbs import Face, NurbsCurve, NurbsSurface, Shell


def circle(u: float, v: float, radius: float, start: float = 0.0) -> NurbsCurve:
    """Return a circle in (u, v)."""
    x, y = radius * np.cos(start), radius * np.sin(start)
    return NurbsCurve.arc([u, v, 0], [x, y, 0], [-y, x, 0])


def polygon(*corners: tuple[float, float]) -> list[NurbsCurve]:
    """Return the closed chain of lines through corners in (u, v)."""
    ends = zip(corners, (*corners[1:], corners[0]), strict=True)
    return [NurbsCurve(pair, degree=1) for pair in ends]


def square() -> list[NurbsCurve]:
    """Return the border of the unit square."""
    return polygon((0, 0), (1, 0), (1, 1), (0, 1))


def plane(side: float = 1.0, z: float = 0.0) -> NurbsSurface:
    """Return a square with parameters from 0 to 1."""
    return NurbsSurface.plane([0, 0, z], [side, 0, 0], [0, side, 0])


def hills() -> NurbsSurface:
    """Return a curved surface over the unit square."""
    x, y = np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 9), indexing="ij")
    z = 0.2 * np.sin(5 * x) * np.cos(4 * y)
    return NurbsSurface.interpolate(np.stack([x, y, z], axis=-1))


def can(radius: float = 1.0, height: float = 2.0) -> Shell:
    """Return a tube closed by two trimmed caps; the circles begin elsewhere."""
    side = 4 * radius

    def cap(z: float) -> Face:
        surface = NurbsSurface.plane([-side / 2, -side / 2, z], [side, 0, 0], [0, side, 0])
        return Face(surface, [[circle(0.5, 0.5, 0.25, start=1.0)]])

    tube = NurbsSurface.cylinder([0, 0, 0], [0, 0, height], radius)
    return Shell([tube, cap(0).reversed(), cap(height)])


NUMBER: Any = 3
INCH: Any = "inch"
LOOPS: Any = [circle(0.5, 0.5, 0.1)]

SHAPES = {
    "disc with two holes": [
        [circle(0.5, 0.5, 0.45)],
        [circle(0.35, 0.5, 0.1)],
        [circle(0.7, 0.5, 0.15)],
    ],
    "L": [polygon((0.1, 0.1), (0.9, 0.1), (0.9, 0.5), (0.5, 0.5), (0.5, 0.9), (0.1, 0.9))],
    "plate with 20 holes": [
        square(),
        *([circle(0.1 + 0.2 * i, 0.125 + 0.25 * j, 0.06)] for i in range(5) for j in range(4)),
    ],
}


def element(uv: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the area element of the curved surface."""
    derivatives = hills().derivatives(uv.reshape(-1, 2), order=1)
    normals = np.cross(derivatives[:, 1, 0], derivatives[:, 0, 1])
    lengths: NDArray[np.float64] = np.linalg.norm(normals, axis=1).reshape(uv.shape[:-1])
    return lengths


def gauss(low: float, high: float, pieces: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return places and weights of Gauss-Legendre quadrature on equal pieces of an interval."""
    places, weights = np.polynomial.legendre.leggauss(8)
    ends = np.linspace(low, high, pieces + 1)
    half = np.diff(ends)[:, None] / 2
    middles = (ends[1:, None] + ends[:-1, None]) / 2
    return (middles + half * places).ravel(), (half * weights).ravel()


def rectangle_area(u: tuple[float, float], v: tuple[float, float]) -> float:
    """Return the area of the curved surface over a rectangle."""
    (places_u, weights_u), (places_v, weights_v) = gauss(*u, 60), gauss(*v, 60)
    grid = np.stack(np.meshgrid(places_u, places_v, indexing="ij"), axis=-1)
    return float(weights_u @ element(grid) @ weights_v)


def disc_area(u: float, v: float, radius: float) -> float:
    """Return the area of the curved surface over a disc, in polar coordinates."""
    (radii, weights), (angles, around) = gauss(0, radius, 30), gauss(0, 2 * np.pi, 40)
    turns = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    places = [u, v] + radii[:, None, None] * turns
    return float((weights * radii) @ element(places) @ around)


def hole_areas() -> float:
    """Return the area of the curved surface over the holes of the plate."""
    middles = [(0.1 + 0.2 * i, 0.125 + 0.25 * j) for i in range(5) for j in range(4)]
    return sum(disc_area(u, v, 0.06) for u, v in middles)


AREAS: dict[str, Callable[[], float]] = {
    "disc with two holes": lambda: (
        disc_area(0.5, 0.5, 0.45) - disc_area(0.35, 0.5, 0.1) - disc_area(0.7, 0.5, 0.15)
    ),
    "L": lambda: rectangle_area((0.1, 0.9), (0.1, 0.5)) + rectangle_area((0.1, 0.5), (0.5, 0.9)),
    "plate with 20 holes": lambda: rectangle_area((0, 1), (0, 1)) - hole_areas(),
}


def inside(loops: list[list[NurbsCurve]], uv: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return whether places lie in fine polygons, by even and odd crossings."""
    within = np.zeros(len(uv), dtype=bool)
    for curves in loops:
        rows = [curve.evaluate(np.linspace(*curve.domain, 400))[:-1, :2] for curve in curves]
        corners = np.concatenate(rows)
        for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            crosses = (y0 <= uv[:, 1]) != (y1 <= uv[:, 1])
            if y0 != y1:
                right = x0 + (uv[:, 1] - y0) / (y1 - y0) * (x1 - x0) > uv[:, 0]
                within ^= crosses & right
    return within


@pytest.mark.parametrize("name", SHAPES)
def test_a_trimmed_face_on_a_curved_surface(name: str) -> None:
    loops = SHAPES[name]
    face = Face(hills(), loops)
    rng = np.random.default_rng(0)
    uv = rng.random((10_000, 2))
    expected = inside(loops, uv)
    # The polygons differ from the circles by their sags, 1e-5 of the radius.
    assert np.count_nonzero(face.contains(uv) != expected) <= 3

    assert face.area() == pytest.approx(AREAS[name](), rel=1e-6)

    mesh = face.tessellate(1e-3)
    assert mesh.max_deviation is not None
    assert mesh.max_deviation <= 1e-3
    assert mesh.euler_characteristic() == 1 - len(face.inner)
    assert mesh.area() == pytest.approx(face.area(), rel=1e-2)

    points = rng.random((300, 3)) * [1.4, 1.4, 1] - [0.2, 0.2, 0.5]
    found = face.closest_points(points)
    samples = face.surface.evaluate(uv[expected])
    nearest = np.linalg.norm(points[:, None] - samples, axis=2).min(axis=1)
    assert (found.distances <= nearest + 1e-12).all()
    assert face.contains(found.uv).all()
    np.testing.assert_allclose(face.surface.evaluate(found.uv), found.points, atol=1e-9)


def test_the_area_of_plane_faces_is_exact() -> None:
    disc = Face(plane(4.0), [[circle(0.5, 0.5, 0.25)], [circle(0.5, 0.5, 0.1)]])
    assert disc.area() == pytest.approx(np.pi * 16 * (0.25**2 - 0.1**2), rel=1e-12)
    low, high = disc.bounding_box()
    np.testing.assert_allclose([low, high], [[1, 1, 0], [3, 3, 0]], atol=1e-6)


def test_a_can_is_a_solid() -> None:
    shell = can(2.0, 5.0)
    assert shell.is_closed
    assert shell.euler_characteristic == 2
    assert shell.volume() == pytest.approx(np.pi * 4 * 5, rel=1e-9)
    assert shell.area() == pytest.approx(2 * np.pi * 2 * 5 + 2 * np.pi * 4, rel=1e-9)
    mesh = shell.tessellate(0.01)
    assert mesh.euler_characteristic() == 2
    assert mesh.boundary_loops() == []
    assert mesh.volume() == pytest.approx(shell.volume(), rel=2e-2)
    assert mesh.face_index is not None
    assert set(mesh.face_index.tolist()) == {0, 1, 2}


def test_a_hundred_faces_of_a_split_surface() -> None:
    sphere = NurbsSurface.sphere([1, 2, 3], 2.0)
    cuts = np.linspace(0, 1, 11)
    pieces = [
        sphere.sub_surface(u=(cuts[i], cuts[i + 1]), v=(cuts[j], cuts[j + 1]))
        for i in range(10)
        for j in range(10)
    ]
    shell = Shell(pieces)
    assert shell.is_closed
    assert shell.euler_characteristic == 2
    assert shell.volume() == pytest.approx(32 / 3 * np.pi, rel=1e-9)
    mesh = shell.tessellate(1e-3, relative=True)
    assert mesh.euler_characteristic() == 2
    assert mesh.boundary_loops() == []
    radii = np.linalg.norm(mesh.vertices[mesh.triangles].mean(axis=1) - [1, 2, 3], axis=1)
    assert mesh.max_deviation is not None
    assert np.abs(radii - 2).max() <= mesh.max_deviation


def test_closest_points_know_their_face() -> None:
    shell = can()
    found = shell.closest_points([[0, 0, 3], [0, 0, -1], [3, 0, 1]])
    assert found.face_index.tolist() == [2, 1, 0]
    np.testing.assert_allclose(found.distances, [1, 1, 2], atol=1e-9)


def test_faces_and_shells_survive_pickle_dicts_and_transforms() -> None:
    face = Face(hills(), SHAPES["L"], name="L", color=(1, 0.5, 0))
    assert pickle.loads(pickle.dumps(face)) == face
    assert Face.from_dict(face.to_dict()) == face
    for shell in (can(), Shell(face, unit="m"), Shell(NurbsSurface.torus([0, 0, 0], 3, 1))):
        assert pickle.loads(pickle.dumps(shell)) == shell
    mirrored = can().transformed(np.diag([1, 1, -2, 1]))
    assert mirrored.volume() == pytest.approx(2 * can().volume(), rel=1e-9)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Face(NUMBER), "surface must be a NurbsSurface"),
        (lambda: Face(plane(), LOOPS), "loops must be a list of lists"),
        (lambda: Face(plane(), []), "loops must be at least one"),
        (lambda: Face(plane(), [[circle(0.5, 0.5, 0.6)]]), "stay inside the surface's rectangle"),
        (lambda: Face(plane(), [square()[:3]]), "be closed"),
        (
            lambda: Face(plane(), [[circle(0.5, 0.5, 0.4)], [circle(0.8, 0.5, 0.2)]]),
            "neither cross",
        ),
        (lambda: Face(plane(), color=(2, 0, 0)), "red, green and blue between 0 and 1"),
        (lambda: Shell([]), "faces must be at least one"),
        (lambda: Shell([NUMBER]), "items must be faces or surfaces"),
        (lambda: Shell(plane(), unit=INCH), "unit must be 'mm'"),
        (lambda: Shell(plane(), tolerance=-1), "tolerance must be positive"),
        (lambda: Shell([plane(), plane()]), "normals agree across each edge"),
        (lambda: Shell(plane()).volume(), "be closed to have a volume"),
        (lambda: Shell(plane()).area(accuracy=2), "accuracy must be between"),
        (lambda: Shell(plane()).closest_points([[np.nan, 0, 0]]), "must be finite"),
        (lambda: Shell(plane()).tessellate(-1), "tolerance must be positive"),
        (lambda: Shell(plane()).transformed([[1]]), "matrix must be"),
        (lambda: Face(plane()).contains([[np.inf, 0]]), "finite"),
        (lambda: Face.from_dict({}), "data must be a dict"),
        (lambda: Shell.from_dict({"faces": 1}), "data must be a dict"),
    ],
)
def test_wrong_input_is_refused(call: object, message: str) -> None:
    with pytest.raises(neurbs.NeurbsError, match=message):
        call()  # type: ignore[operator]


@pytest.mark.parametrize("suffix", [".step", ".igs", ".json", ".obj"])
def test_shells_come_back_from_files(suffix: str, tmp_path: Path) -> None:
    if suffix in (".step", ".igs"):
        pytest.importorskip("OCP", reason="needs the extra cad")
    path = tmp_path / f"can{suffix}"
    neurbs.save(can(), path)
    back = neurbs.load_shell(path)
    assert len(back.faces) == 3
    assert back.is_closed
    assert back.volume() == pytest.approx(can().volume(), rel=1e-6)


def test_meshes_of_shells_are_written(tmp_path: Path) -> None:
    for suffix in (".stl", ".ply", ".glb"):
        neurbs.save(can(), tmp_path / f"can{suffix}")
        assert (tmp_path / f"can{suffix}").stat().st_size > 1000
    Shell(plane()).save(tmp_path / "plane.step", unit="m")
    assert "METRE" in (tmp_path / "plane.step").read_text()
