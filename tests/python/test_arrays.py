"""Arrays as arguments and results: conversion, memory and `out`."""

import sys
import tracemalloc
import types

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs
from neurbs import NeurbsError, NurbsSurface, _core

Points = NDArray[np.float64]

GRID = np.stack(np.meshgrid(range(4), range(5), indexing="ij"), axis=-1).reshape(-1, 2)
POINTS = np.column_stack([GRID, GRID[:, 0] * GRID[:, 1]]).astype(float)


def surface() -> NurbsSurface:
    return NurbsSurface(POINTS.reshape(4, 5, 3))


def test_points_of_the_right_kind_are_not_copied() -> None:
    points = np.ascontiguousarray(np.random.default_rng(0).random((1000, 3)))
    assert _core.as_points(points) is points
    part = points[100:900]
    assert np.shares_memory(_core.as_points(part), points)


def test_arrays_are_read_while_another_thread_loads_masked_arrays(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "numpy.ma", types.ModuleType("numpy.ma"))
    np.testing.assert_array_equal(_core.as_points(POINTS.tolist()), POINTS)


@pytest.mark.parametrize(
    "given",
    [
        POINTS.tolist(),
        [tuple(p) for p in POINTS.tolist()],
        POINTS.astype(np.float32),
        POINTS.astype(np.int16),
        POINTS.astype(">f8"),
        np.asfortranarray(POINTS),
        np.repeat(POINTS, 2, axis=0)[::2],
        np.hstack([POINTS, POINTS])[:, :3],
        np.ma.array(POINTS, mask=False),
    ],
    ids=[
        "lists",
        "tuples",
        "float32",
        "int16",
        "big-endian",
        "Fortran",
        "strided",
        "columns",
        "masked",
    ],
)
def test_anything_else_is_converted(given: object) -> None:
    converted = _core.as_points(given)  # type: ignore[arg-type]
    assert converted.flags.c_contiguous
    assert converted.dtype == np.float64
    np.testing.assert_array_equal(converted, POINTS)


def test_unaligned_memory_is_converted() -> None:
    raw = np.frombuffer(b"x" + POINTS.tobytes(), dtype=np.uint8)[1:]
    unaligned = raw.view(np.float64).reshape(-1, 3)
    assert not unaligned.flags.aligned
    np.testing.assert_array_equal(_core.as_points(unaligned), POINTS)


def test_two_columns_lie_in_the_plane() -> None:
    flat = _core.as_points(POINTS[:, :2].astype(np.float32))
    np.testing.assert_array_equal(flat, POINTS * [1, 1, 0])


def test_the_input_is_left_alone(terrain_points: Points) -> None:
    before = terrain_points.copy()
    result = neurbs.reconstruct(terrain_points, grid=(6, 6))
    np.testing.assert_array_equal(terrain_points, before)
    assert terrain_points.flags.writeable
    assert np.shares_memory(result.points, terrain_points)
    assert not result.points.flags.writeable


@pytest.mark.parametrize(
    ("given", "got"),
    [
        (np.zeros((5, 4)), "shape (5, 4)"),
        (np.zeros(3), "shape (3,)"),
        (np.zeros((2, 2, 4)), "shape (2, 2, 4)"),
        (1.5, "shape ()"),
        (POINTS.astype(complex), "dtype complex128"),
        (POINTS.astype(str), "dtype <U32"),
        (POINTS > 1, "dtype bool"),
        ([["a", "b", "c"]], "dtype <U1"),
        (None, "dtype object"),
        ([[1, 2, 3], [4, 5]], "inhomogeneous"),
        (np.ma.masked_greater(POINTS, 5), "masked"),
    ],
    ids=str,
)
def test_other_objects_are_refused_as_points(given: object, got: str) -> None:
    with pytest.raises(NeurbsError, match="points must be real numbers of shape") as error:
        neurbs.reconstruct(given)  # type: ignore[call-overload]
    assert got in str(error.value)


def test_properties_are_read_only_views() -> None:
    s = NurbsSurface(POINTS.reshape(4, 5, 3), weights=np.full((4, 5), 2.0))
    mesh = s.tessellate(shape=(3, 4))
    som = neurbs.SelfOrganizingMap(3, 3, max_steps=100).fit(POINTS)
    assert s.weights is not None
    of_mesh = (mesh.vertices, mesh.triangles, mesh.normals, mesh.uv)
    for array in (s.control_points, s.weights, *s.knots, som.codebook_, *of_mesh):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
        with pytest.raises(ValueError, match="WRITEABLE"):
            array.flags.writeable = True
    assert np.shares_memory(s.control_points, s.control_points)


def test_large_results_live_in_memory_of_numpy() -> None:
    # tracemalloc measures memory of NumPy, not of Rust.
    tracemalloc.start()
    try:
        mesh = surface().tessellate(shape=(600, 500))
        points = surface().evaluate(np.full((300_000, 2), 0.5))
        allocated = tracemalloc.get_traced_memory()[0]
    finally:
        tracemalloc.stop()
    arrays = (mesh.vertices, mesh.triangles, mesh.normals, mesh.uv, points)
    assert allocated >= sum(array.nbytes for array in arrays)


def test_results_are_written_to_out() -> None:
    s, uv = surface(), np.random.default_rng(0).random((50, 2))
    out = np.empty((50, 3))
    assert s.evaluate(uv, out=out) is out
    np.testing.assert_array_equal(out, s.evaluate(uv))
    assert s.normals(uv, out=out) is out
    np.testing.assert_array_equal(out, s.normals(uv))
    grid = np.empty((3, 2, 3))
    assert s.evaluate_grid([0, 0.5, 1], [0, 1], out=grid) is grid
    np.testing.assert_array_equal(grid, s.evaluate_grid([0, 0.5, 1], [0, 1]))


@pytest.mark.parametrize(
    "out",
    [
        np.empty((4, 3)),
        np.empty((5, 3), np.float32),
        np.empty((5, 3), order="F"),
        np.empty((10, 3))[::2],
        [[0.0] * 3] * 5,
    ],
    ids=["shape", "float32", "Fortran", "strided", "list"],
)
def test_an_out_that_does_not_fit_is_refused(out: object) -> None:
    with pytest.raises(NeurbsError, match="out must be a writeable, C-contiguous float64 array"):
        surface().evaluate(np.full((5, 2), 0.5), out=out)  # type: ignore[arg-type]


def test_an_out_that_cannot_be_written_is_refused() -> None:
    out = np.empty((5, 3))
    out.flags.writeable = False
    with pytest.raises(NeurbsError, match="out must be writeable"):
        surface().evaluate(np.full((5, 2), 0.5), out=out)
    shared = np.full((5, 3), 0.5)
    uv = shared.reshape(-1)[:10].reshape(5, 2)
    with pytest.raises(NeurbsError, match="share no memory"):
        surface().evaluate(uv, out=shared)
