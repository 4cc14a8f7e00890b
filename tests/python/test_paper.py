"""The paper's method from Python."""

import inspect
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs
from neurbs import ConvergenceWarning, NeurbsError, Progress

Points = NDArray[np.float64]
JACKSBORO = Path(__file__).parents[2] / "examples" / "jacksboro.xyz"


def test_terrain_becomes_a_surface() -> None:
    points = neurbs.read_points(JACKSBORO)
    assert len(points) == 4000
    result = neurbs.reconstruct_paper(points)
    assert result.report.converged
    assert result.report.stopped_by == "settled"
    assert result.som.codebook_.shape == result.surface.control_points.shape == (28, 29, 3)
    np.testing.assert_array_equal(result.som.codebook_, result.surface.control_points)
    assert result.report.quantization_error < 0.01 * result.report.diagonal
    vertices = result.mesh.vertices
    assert (vertices.min(axis=0) >= points.min(axis=0)).all()
    assert (vertices.max(axis=0) <= points.max(axis=0)).all()
    assert len(np.unique(np.sign(result.mesh.normals[:, 2]))) == 1


def test_equal_seeds_give_equal_bits(terrain_points: Points) -> None:
    def net(seed: int) -> Points:
        result = neurbs.reconstruct_paper(terrain_points, grid=(6, 7), seed=seed)
        return result.surface.control_points

    np.testing.assert_array_equal(net(5), net(5))
    assert not np.array_equal(net(5), net(6))


def test_the_lattice_is_interpolated_or_a_bezier_net(terrain_points: Points) -> None:
    through = neurbs.reconstruct_paper(terrain_points, surface="interpolate", grid=(12, 9))
    lattice = through.som.codebook_
    distances = through.surface.closest_points(lattice.reshape(-1, 3)).distances
    assert distances.max() < 1e-9 * through.report.diagonal
    bezier = neurbs.reconstruct_paper(terrain_points, surface="bezier", grid=(8, 10))
    assert bezier.surface.degree == bezier.report.degree == (7, 9)
    np.testing.assert_array_equal(bezier.surface.control_points, bezier.som.codebook_)
    derived = neurbs.reconstruct_paper(terrain_points, surface="bezier")
    assert derived.report.grid == (10, 10)
    with pytest.raises(NeurbsError, match=r"grid must be from 2 to 26 rows and columns .*27, 4"):
        neurbs.reconstruct_paper(terrain_points, surface="bezier", grid=(27, 4))


def test_too_few_steps_are_a_warning(terrain_points: Points) -> None:
    with pytest.warns(ConvergenceWarning, match="after 500 steps, while the lattice still"):
        result = neurbs.reconstruct_paper(terrain_points, grid=(6, 6), max_steps=500)
    assert not result.report.converged
    assert not result.som.converged_


def test_progress_is_reported() -> None:
    seen: list[Progress] = []
    points = np.random.default_rng(0).random((5000, 3))
    neurbs.reconstruct_paper(points, grid=(30, 30), progress=seen.append)
    assert [s.stage for s in seen[:1]] == ["checking"]
    assert {s.stage for s in seen} == {"checking", "training", "measuring", "tessellation"}
    assert all(0 <= s.step <= s.total for s in seen)
    training = [s for s in seen if s.stage == "training"]
    assert all(s.points == len(points) for s in training)
    assert training[-1].change is not None


def test_other_threads_run_meanwhile() -> None:
    points = np.random.default_rng(0).random((5000, 3))
    calls = 0
    done = threading.Event()

    def count() -> None:
        nonlocal calls
        while not done.is_set():
            calls += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    neurbs.reconstruct_paper(points, grid=(30, 30), max_steps=200_000)
    done.set()
    thread.join()
    # If the GIL were held there would be only the first and the last call.
    assert calls > 20


FEW = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 1]]


@pytest.mark.parametrize(
    ("option", "value", "message"),
    [
        ("grid", (10**6, 10**6), "nodes in all, got .1000000, 1000000., about 512000 GB of memory"),
        ("grid", (200_000, 200_000), "about 20480 GB of memory"),
        ("surface", "mesh", "surface must be 'control-net' or 'interpolate' or 'bezier', got"),
        ("degree", 26, "degree must be between 1 and 25, got 26"),
        ("max_steps", 0, "max_steps must be at least 1, got 0"),
        ("max_steps", "many", "max_steps must be an integer from 0, got 'many'"),
        ("reach", 0, "reach must be positive and finite, got 0"),
        ("reach", "far", "reach must be a number, got 'far'"),
        ("min_change", np.inf, "min_change must be positive and finite, got inf"),
    ],
)
def test_options_out_of_range_are_refused(option: str, value: object, message: str) -> None:
    with pytest.raises(NeurbsError, match=message):
        neurbs.reconstruct_paper(FEW, **{option: value})  # type: ignore[arg-type]


def test_options_of_the_fit_are_unknown() -> None:
    known = inspect.signature(neurbs.reconstruct_paper).parameters
    own = {
        "grid",
        "degree",
        "surface",
        "max_steps",
        "reach",
        "min_change",
        "seed",
        "unit",
        "progress",
    }
    assert set(known) == {"points"} | own
