"""Faces that end where points end, from Python."""

import numpy as np
import pytest
from numpy.typing import NDArray

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
