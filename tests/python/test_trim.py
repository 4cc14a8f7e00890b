"""Faces that end where points end, from Python."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.STEPControl import STEPControl_Reader

import neurbs


def places(count: int, seed: int = 0) -> NDArray[np.float64]:
    """Return places in a disc with two holes."""
    uv = np.random.default_rng(seed).random((count, 2))
    away = [np.linalg.norm(uv - middle, axis=1) for middle in ((0.5, 0.5), (0.35, 0.5), (0.7, 0.6))]
    kept: NDArray[np.float64] = uv[(away[0] < 0.45) & (away[1] > 0.1) & (away[2] > 0.14)]
    return kept


def plane(side: float = 1.0) -> neurbs.NurbsSurface:
    """Return a square."""
    return neurbs.NurbsSurface.plane([0, 0, 0], [side, 0, 0], [0, side, 0])


AREA = np.pi * (0.45**2 - 0.1**2 - 0.14**2)


def test_a_disc_with_two_holes_is_found() -> None:
    shell = neurbs.trim(plane(), places(6000))
    (face,) = shell.faces
    assert len(face.inner) == 2
    assert face.area() == pytest.approx(AREA, rel=0.02)
    assert shell.tessellate().euler_characteristic() == -1
    (closed,) = neurbs.trim(plane(), places(6000), holes=False).faces
    assert closed.inner == []
    assert closed.area() == pytest.approx(np.pi * 0.45**2, rel=0.02)


def test_the_border_moves_out_as_asked() -> None:
    inner, outer = (neurbs.trim(plane(), places(6000), border=k).area() for k in (0.0, 2.0))
    assert inner < AREA < outer


def test_two_regions_are_two_faces() -> None:
    uv = np.random.default_rng(0).random((6000, 2))
    uv = uv[abs(uv[:, 0] - 0.5) > 0.1]
    assert len(neurbs.trim(plane(), uv).faces) == 2


def test_few_points_leave_the_surface_whole_with_a_warning() -> None:
    with pytest.warns(UserWarning, match="not trimmed: .* distinct places are needed, got 3"):
        shell = neurbs.trim(plane(), [[0.1, 0.1], [0.5, 0.5], [0.9, 0.1]])
    assert not shell.faces[0].is_trimmed


def test_wrong_arguments_are_refused() -> None:
    with pytest.raises(neurbs.NeurbsError, match="border must be between 0 and 4"):
        neurbs.trim(plane(), places(500), border=9)
    with pytest.raises(neurbs.NeurbsError, match="domain"):
        neurbs.trim(plane(), [[2.0, 0.5]] * 50)


def closed_parts() -> Iterator[tuple[str, neurbs.NurbsSurface, NDArray[np.float64], int]]:
    """Yield parts of closed surfaces: name, surface, parameters, Euler characteristic."""
    tube = neurbs.NurbsSurface.cylinder([0, 0, -0.5], [0, 0, 4], 1)
    torus = neurbs.NurbsSurface.torus([0, 0, 0], 2, 0.8)
    for name, surface, euler in (("tube", tube, -1), ("torus", torus, -1), ("open", tube, 1)):
        uv = np.random.default_rng(0).random((20_000, 2))
        by_v, by_u = surface.derivatives(uv, 1)[:, [0, 1], [1, 0]].swapaxes(0, 1)
        area = np.linalg.norm(np.cross(by_u, by_v), axis=1)
        uv = uv[np.random.default_rng(1).random(len(uv)) < area / area.max()]
        points = surface.evaluate(uv)
        seam = surface.evaluate([[0.0, 0.5]])[0]
        if name == "open":
            kept = (points @ (seam * (1, 1, 0)) > -0.3) & (abs(points[:, 2] - 1.5) < 1.5)
        else:
            kept = np.linalg.norm(points - seam, axis=1) > 0.5
        yield name, surface, uv[kept], euler


@pytest.mark.parametrize("part", list(closed_parts()), ids=lambda part: part[0])
def test_faces_at_seams_are_written_and_read(part: Any, tmp_path: Path) -> None:
    _, surface, uv, euler = part
    shell = neurbs.trim(surface, uv)
    assert len(shell.faces) == 1
    path = tmp_path / "part.step"
    shell.save(path)
    reader = STEPControl_Reader()
    assert reader.ReadFile(str(path)) == IFSelect_ReturnStatus.IFSelect_RetDone
    reader.TransferRoots()
    shape, properties = reader.OneShape(), GProp_GProps()
    assert BRepCheck_Analyzer(shape).IsValid()
    BRepGProp.SurfaceProperties_s(shape, properties, 1e-8)
    assert abs(properties.Mass()) == pytest.approx(shell.area(), rel=1e-4)
    assert neurbs.load_shell(path).area() == pytest.approx(shell.area(), rel=1e-6)
    mesh = shell.tessellate()
    assert mesh.euler_characteristic() == euler
    triangles = np.asarray(mesh.triangles)
    sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert np.unique(sides, axis=0, return_counts=True)[1].max() == 2
