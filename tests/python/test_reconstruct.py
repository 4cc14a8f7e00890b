"""The whole job from Python: options, errors, progress, Ctrl-C."""

import inspect
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

import neurbs
from neurbs import ConvergenceWarning, NeurbsError, Progress, Reconstruction, _core

Points = NDArray[np.float64]
JACKSBORO = Path(__file__).parents[2] / "examples" / "jacksboro.xyz"


def test_terrain_becomes_a_surface() -> None:
    points = neurbs.read_points(JACKSBORO)
    assert len(points) == 4000
    result = neurbs.reconstruct(points, method="paper")
    assert result.report.converged
    assert result.report.stopped_by == "settled"
    assert result.som.codebook_.shape == result.surface.control_points.shape == (28, 29, 3)
    np.testing.assert_array_equal(result.som.codebook_, result.surface.control_points)
    assert result.report.quantization_error < 0.01 * result.report.diagonal
    vertices = result.mesh.vertices
    assert (vertices.min(axis=0) >= points.min(axis=0)).all()
    assert (vertices.max(axis=0) <= points.max(axis=0)).all()
    assert len(np.unique(np.sign(result.mesh.normals[:, 2]))) == 1


@pytest.mark.parametrize("steep", [False, True])
def test_a_tolerance_that_is_kept_unasked_is_kept_when_asked_for(steep: bool) -> None:
    points = neurbs.read_points(JACKSBORO)
    if steep:
        u, v = np.random.default_rng(1).random((2, 2000))
        points = np.column_stack([u, v, 0.3 * np.sin(8 * u) * np.cos(6 * v)])
    tolerance = 1.05 * neurbs.reconstruct(points).report.max
    result = neurbs.reconstruct(points, tolerance)
    # The terrain's net stopped at a control point for four points, as if they held no more; steep
    # heights, which are farther from points than the surface is, were said to miss "0 points".
    assert result.report.ended_by == "tolerance"
    assert result.report.converged
    assert not result.report.warnings
    assert result.distances.max() <= tolerance


@pytest.mark.parametrize("kind", ["arch", "ground"])
def test_points_of_a_surface_with_the_same_net_give_it_back(kind: str) -> None:
    u, v = np.meshgrid(np.linspace(0, 1, 8), np.linspace(0, 1, 7), indexing="ij")
    if kind == "arch":
        bumps = 0.04 * np.random.default_rng(5).standard_normal((8, 7, 3))
        net = np.stack([np.cos(3.4 * u), 1.2 * v, np.sin(3.4 * u)], axis=-1) + bumps
    else:
        # Heights over a plane, but not evenly over it: what z = f(x, y) with this net is not.
        net = np.stack([u, v, 0.15 * np.sin(5 * u) * np.cos(4 * v)], axis=-1)
    truth = neurbs.NurbsSurface(net)
    points = truth.evaluate(np.random.default_rng(0).uniform(size=(2000, 2)))
    result = neurbs.reconstruct(points, grid=(8, 7), aspect="fixed")
    others = truth.evaluate(np.random.default_rng(1).uniform(size=(500, 2)))
    distances = result.surface.closest_points(others).distances
    assert distances.max() < 1e-6 * result.report.diagonal
    assert (result.report.ended_by, result.report.topology) == ("exact", "sheet")
    if kind == "ground":
        heights = neurbs.reconstruct(points, grid=(8, 7), aspect="fixed", topology="height")
        assert (heights.report.ended_by, heights.report.topology) == ("grid", "height")


@pytest.mark.filterwarnings("ignore:the surface runs")
@pytest.mark.parametrize("powers", [(1.6, 0.7), (1.0, 1.7), (1.6, 1.6), (0.7, 0.7)])
def test_nets_that_are_finer_at_one_end_come_back(powers: tuple[float, float]) -> None:
    u, v = np.meshgrid(np.linspace(0, 1, 12), np.linspace(0, 1, 12), indexing="ij")
    u, v = u ** powers[0], v ** powers[1]
    net = np.stack([u, v, 0.2 * np.sin(5 * u + 1) * np.sin(6 * v + 2)], axis=-1)
    truth = neurbs.NurbsSurface(net + 0.005 * np.random.default_rng(0).standard_normal(net.shape))
    # As many by area: the more, the faster both parameters are.
    uv = np.random.default_rng(1).random((12_000, 2))
    derivatives = truth.derivatives(uv, 1)
    areas = np.linalg.norm(np.cross(derivatives[:, 1, 0], derivatives[:, 0, 1]), axis=1)
    chosen = np.random.default_rng(2).choice(len(uv), 2000, replace=False, p=areas / areas.sum())
    for places in (uv[:2000], uv[chosen]):
        points = truth.evaluate(places)
        result = neurbs.reconstruct(points, grid=(12, 12), aspect="fixed", topology="sheet")
        # Between the points: where a patch has none nothing tells where it is.
        neighbours = places[cKDTree(places).query(places, k=2)[1][:, 1]]
        others = truth.evaluate(0.6 * places + 0.4 * neighbours)
        distances = result.surface.closest_points(others).distances
        assert distances.max() < 1e-6 * result.report.diagonal


@pytest.mark.parametrize(
    ("net", "seed", "several", "rolled"),
    [
        # Slides off the ends of its domain by 5e-4, which hardly shows in distances along normals.
        ((5, 6), 8, 2000, True),
        # No step leads on where a part of it lies otherwise; and it folds over in a corner.
        ((12, 12), 4, 1500, False),
        ((12, 12), 4, 1000, True),
        # Only the order of a larger net leads there.
        ((4, 4), 4, 1000, True),
        ((4, 4), 18, 5000, True),
        ((6, 6), 17, 2000, True),
        ((7, 10), 16, 1000, True),
        ((7, 10), 13, 2000, False),
    ],
)
def test_nets_come_back_where_most_searches_end_beside_them(
    net: tuple[int, int], seed: int, several: int, rolled: bool
) -> None:
    rng = np.random.default_rng([seed, *net])
    u, v = np.meshgrid(np.linspace(0, 1, net[0]), np.linspace(0, 1, net[1]), indexing="ij")
    angle = rng.uniform(*((4, 6) if rolled else (1, 3.5))) * u
    radius = 0.3 + 0.05 * angle if rolled else 1
    arc = np.stack([radius * np.cos(angle), rng.uniform(1, 2) * v, radius * np.sin(angle)], axis=-1)
    bumps = (0.05 if rolled else 0.3) / min(max(net) - 1, 8) * rng.standard_normal(arc.shape)
    truth = neurbs.NurbsSurface(arc + bumps)
    uv = rng.random((several, 2))
    result = neurbs.reconstruct(truth.evaluate(uv), grid=net, aspect="fixed", topology="sheet")
    assert result.report.ended_by == "exact"
    assert not result.report.warnings
    others = truth.evaluate(rng.uniform(uv.min(axis=0), uv.max(axis=0), (400, 2)))
    distances = result.surface.closest_points(others).distances
    assert distances.max() < 1e-6 * result.report.diagonal


@pytest.mark.parametrize("seed", range(3))
def test_points_that_were_left_out_but_lie_on_a_net_that_came_back_are_inliers(seed: int) -> None:
    u, v = np.meshgrid(np.linspace(0, 1, 4), np.linspace(0, 1, 4), indexing="ij")
    radius = 0.3 + 0.25 * u
    net = np.stack([radius * np.cos(5 * u), 1.5 * v, radius * np.sin(5 * u)], axis=-1)
    points = neurbs.NurbsSurface(net).evaluate(np.random.default_rng(seed).random((2000, 2)))
    off = np.array([0.2, 0.7, 0.8])
    result = neurbs.reconstruct(np.vstack([points, off]), grid=(4, 4), aspect="fixed")
    assert result.report.ended_by == "exact"
    assert np.flatnonzero(~result.inliers) == [2000]
    assert result.distances[:2000].max() < 1e-7 * result.report.diagonal


def test_a_fit_tells_how_good_it_is(terrain_points: Points) -> None:
    result = neurbs.reconstruct(terrain_points, tolerance=2.0)
    report = result.report
    assert report.ended_by == "tolerance"
    assert report.within == 1.0
    assert result.distances.max() == report.max <= 2.0
    assert report.percentiles[50] == np.sort(result.distances)[len(terrain_points) // 2 - 1]
    places = result.surface.evaluate(result.uv)
    distances = np.linalg.norm(places - terrain_points, axis=1)
    np.testing.assert_allclose(distances, result.distances, atol=1e-9)
    nearest = result.surface.closest_points(terrain_points).distances
    assert (nearest <= result.distances + 1e-9).all()
    for words in ("rms", "control points", "100 % within the tolerance", "fitting"):
        assert words in str(report)


def test_what_cannot_be_held_is_a_warning(terrain_points: Points) -> None:
    with pytest.warns(ConvergenceWarning, match=r"points lie farther than the tolerance 1e-6"):
        result = neurbs.reconstruct(terrain_points, tolerance=1e-6, max_control_points=50)
    assert not result.report.converged
    assert result.report.ended_by == "max_control_points"
    assert result.report.warnings


@pytest.mark.parametrize("topology", ["sheet", "tube", "torus"])
def test_topologies_close_what_they_should(topology: str, rng: np.random.Generator) -> None:
    u, v = rng.random((2, 900))
    a, b = 2 * np.pi * u, 2 * np.pi * v
    r = 1 + 0.3 * np.cos(b)
    points = {
        "sheet": np.column_stack([u, v, u * v]),
        "tube": np.column_stack([np.cos(a), np.sin(a), 3 * v]),
        "torus": np.column_stack([r * np.cos(a), r * np.sin(a), 0.3 * np.sin(b)]),
    }[topology]
    result = neurbs.reconstruct(points, topology=topology, grid=(12, 12))
    assert result.surface.closed == (topology != "sheet", topology == "torus")
    assert result.report.rms < 1e-3


def test_defaults_are_those_of_the_core() -> None:
    ours = inspect.signature(neurbs.reconstruct).parameters
    options = {name: p.default for name, p in ours.items() if name not in ("points", "progress")}
    assert options == _core.default_options()


def test_equal_seeds_give_equal_bits(terrain_points: Points) -> None:
    def net(seed: int) -> Points:
        result = neurbs.reconstruct(terrain_points, method="paper", grid=(6, 7), seed=seed)
        return result.surface.control_points

    np.testing.assert_array_equal(net(5), net(5))
    assert not np.array_equal(net(5), net(6))


def test_the_report_is_plain(result: Reconstruction) -> None:
    report = result.report.to_dict()
    rows, cols = result.report.grid
    assert report["grid"] == [rows, cols]
    assert report["points"] == len(result.points)
    assert report["converged"] is True
    stages = ["cleaning", "topology", "ordering", "training", "fitting", "measuring"]
    assert list(report["seconds"]) == stages
    assert report["percentiles"][50] <= report["rms"] <= report["max"]


def test_a_path_is_no_points() -> None:
    with pytest.raises(
        NeurbsError, match=r"got the path 'scan\.xyz': read it with neurbs\.read_points"
    ):
        neurbs.reconstruct("scan.xyz")


FEW = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 1]]


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([*FEW, [np.nan, 0, 0]], r"points must be finite, but point 4 is \(NaN, 0, 0\)"),
        ([*FEW, [0, -np.inf, 0]], r"point 4 is \(0, -inf, 0\)"),
        (np.empty((0, 3)), "at least 4 distinct points, got 0"),
        (FEW[:3], "at least 4 distinct points, got 3"),
        (FEW[:3] * 5, r"at least 4 distinct points, got 3 \(of 15 given\)"),
        ([[1.5, 2, 3]] * 9, r"points must differ, but all 9 are \(1.5, 2, 3\)"),
        (np.outer(range(9), [1.0, 2, 3]), "all 9 lie on one line"),
        (np.array(FEW) * 1e200, "must extend between .* but extend 1e200"),
        (np.array(FEW) * 1e-200, "must extend between .* but extend 1e-200"),
    ],
    ids=["nan", "inf", "empty", "three", "repeated", "equal", "line", "huge", "tiny"],
)
def test_points_that_are_no_surface_are_refused(points: ArrayLike, message: str) -> None:
    with pytest.raises(NeurbsError, match=message) as error:
        neurbs.reconstruct(points)
    assert isinstance(error.value, ValueError)
    with pytest.raises(NeurbsError, match=message):
        neurbs.SelfOrganizingMap(4, 4).fit(points)


@pytest.mark.parametrize(
    ("option", "value", "message"),
    [
        ("method", "best", "method must be 'fit' or 'paper', got 'best'"),
        ("method", 3, "method must be 'fit' or 'paper', got 3"),
        ("tolerance", 0.1, "tolerance must be left out unless method is 'fit', got method 'paper'"),
        ("grid", (1, 5), r"grid must be \(rows, cols\) of at least \(2, 2\)"),
        ("grid", (10**6, 10**6), "nodes in all, got .1000000, 1000000., about 512000 GB of memory"),
        ("grid", (2**40, 2**40), "at most 16777216 nodes in all"),
        ("grid", (200_000, 200_000), "about 20480 GB of memory"),
        ("surface", "mesh", "surface must be 'control-net' or 'interpolate' or 'bezier', got"),
        ("grid", 5, "grid must be two integers from 0, got 5"),
        ("grid", (-4, 5), r"grid must be two integers from 0, got \(-4, 5\)"),
        ("grid", (4, 5, 6), "grid must be two integers from 0"),
        ("progress", 5, "progress must be callable, got 5"),
        ("degree", 0, "degree must be between 1 and 9, got 0"),
        ("degree", 2.5, "degree must be an integer from 0 .*, got 2.5"),
        ("seed", -1, "seed must be an integer from 0 .*, got -1"),
        ("seed", 2**64, "seed must be an integer from 0"),
        ("max_steps", 0, "max_steps must be at least 1, got 0"),
        ("max_steps", "many", "max_steps must be an integer from 0 .*, got 'many'"),
        ("reach", 0, "reach must be positive and finite, got 0"),
        ("reach", "far", "reach must be a number, got 'far'"),
        ("min_change", np.inf, "min_change must be positive and finite, got inf"),
    ],
)
def test_options_out_of_range_are_refused(option: str, value: object, message: str) -> None:
    with pytest.raises(NeurbsError, match=message):
        neurbs.reconstruct(FEW, **{"method": "paper", option: value})  # type: ignore[call-overload]


def test_the_lattice_is_interpolated_or_a_bezier_net(terrain_points: Points) -> None:
    through = neurbs.reconstruct(
        terrain_points, method="paper", surface="interpolate", grid=(12, 9)
    )
    lattice = through.som.codebook_
    distances = through.surface.closest_points(lattice.reshape(-1, 3)).distances
    assert distances.max() < 1e-9 * through.report.diagonal
    bezier = neurbs.reconstruct(terrain_points, method="paper", surface="bezier", grid=(8, 10))
    assert bezier.surface.degree == bezier.report.degree == (7, 9)
    np.testing.assert_array_equal(bezier.surface.control_points, bezier.som.codebook_)
    derived = neurbs.reconstruct(terrain_points, method="paper", surface="bezier")
    assert derived.report.grid == (10, 10)
    with pytest.raises(NeurbsError, match=r"grid must be from 2 to 10 rows and columns .*11, 4"):
        neurbs.reconstruct(terrain_points, method="paper", surface="bezier", grid=(11, 4))


def test_ordered_points_need_no_network() -> None:
    x, y = np.meshgrid(np.linspace(0, 3, 7), np.linspace(0, 2, 6), indexing="ij")
    grid = np.stack([x, y, np.sin(x) * y], axis=-1)
    result = neurbs.reconstruct(grid)
    np.testing.assert_allclose(result.som.codebook_, grid, atol=1e-15)
    assert result.report.stopped_by == "ordered"
    assert result.report.converged
    assert result.report.grid == (7, 6)
    np.testing.assert_array_equal(result.surface.control_points, grid)
    np.testing.assert_array_equal(result.points, grid.reshape(-1, 3))
    through = neurbs.reconstruct(grid, surface="interpolate").surface
    assert through.closest_points(grid.reshape(-1, 3)).distances.max() < 1e-12
    assert neurbs.reconstruct(grid.tolist(), surface="bezier").surface.degree == (6, 5)
    for bad, message in [
        (np.zeros((4, 4, 3)), "points must differ"),
        (grid * np.nan, "points must be finite"),
        (grid[:1], "grid must be at least 2 rows and columns, got .1, 6."),
        (grid[..., :2], r"points must be real numbers of shape .*in order, \(r, c, 3\)"),
    ]:
        with pytest.raises(NeurbsError, match=message):
            neurbs.reconstruct(bad)


@pytest.mark.skipif(sys.platform != "linux", reason="limits of memory as Linux has them")
def test_too_little_memory_is_an_error_and_no_crash() -> None:
    script = """
        import resource
        import numpy as np
        import neurbs

        points = np.random.default_rng(0).random((1000, 3))
        neurbs.SelfOrganizingMap(5, 5).fit(points)
        limit = 4 << 30
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
        for job in (
            lambda: neurbs.reconstruct(points, method="paper", grid=(4000, 4000)),
            lambda: neurbs.SelfOrganizingMap(4000, 4000).fit(points),
            lambda: neurbs.SelfOrganizingMap(4000, 4000, lattice="triangular").fit(points),
        ):
            try:
                job()
            except MemoryError as error:
                print(error)
    """
    run = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script)], capture_output=True, text=True, timeout=120
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout.count("a lattice of 16000000 nodes takes about 8.2 GB of memory") == 3


def test_lists_and_arrays_do_as_well_as_tuples(terrain_points: Points) -> None:
    for grid in ([6, 7], np.array([6, 7])):
        result = neurbs.reconstruct(  # type: ignore[call-overload]
            terrain_points, grid=grid, aspect="fixed"
        )
        assert result.report.grid == (6, 7)


def test_other_exceptions_pass_through() -> None:
    class Interrupted:
        def __array__(self, *_: object) -> Points:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        neurbs.reconstruct(Interrupted())


def test_too_few_steps_are_a_warning(terrain_points: Points) -> None:
    with pytest.warns(ConvergenceWarning, match="max_steps=500 steps, while the lattice still"):
        result = neurbs.reconstruct(terrain_points, method="paper", grid=(6, 6), max_steps=500)
    assert not result.report.converged
    assert not result.som.converged_


def test_progress_is_told(terrain_points: Points) -> None:
    seen: list[Progress] = []
    neurbs.reconstruct(terrain_points, method="paper", grid=(20, 20), progress=seen.append)
    assert [s.stage for s in seen[:1]] == ["checking"]
    assert {s.stage for s in seen} == {"checking", "training", "measuring", "tessellation"}
    assert all(0 <= s.step <= s.total for s in seen)
    training = [s for s in seen if s.stage == "training"]
    assert all(s.points == len(terrain_points) for s in training)
    assert training[-1].change is not None


def test_an_exception_in_the_callback_ends_the_job(terrain_points: Points) -> None:
    def fail(_: Progress) -> None:
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        neurbs.reconstruct(terrain_points, progress=fail)


def test_other_threads_run_meanwhile() -> None:
    points = np.random.default_rng(0).random((5000, 3))
    counted = 0
    done = threading.Event()

    def count() -> None:
        nonlocal counted
        while not done.is_set():
            counted += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    neurbs.reconstruct(points, method="paper", grid=(30, 30), max_steps=200_000)
    done.set()
    thread.join()
    # With the GIL held there would be none but the first and the last.
    assert counted > 20


LONG_JOBS = {
    "reconstruct": "neurbs.reconstruct(points, method='paper', max_steps=10**12, min_change=1e-12)",
    "fit": "neurbs.SelfOrganizingMap(epochs=10**9, min_change=1e-300).fit(points)",
    "fit a large lattice": "neurbs.SelfOrganizingMap(1500, 1500, epochs=99).fit(points)",
    "check points": "[neurbs.reconstruct(line) for _ in range(100)]",
    "geodesic": "[neurbs.SelfOrganizingMap(init='geodesic').fit(points) for _ in range(100)]",
    "measure": "[som.topographic_error(cloud) for _ in range(100)]",
    "a large lattice": "neurbs.reconstruct(points, method='paper', grid=(2000, 2000))",
    "all points reached": (
        "neurbs.reconstruct(many, method='paper', reach=10.0, max_steps=10**12, grid=(300, 300))"
    ),
    "fit a surface": "neurbs.reconstruct(many, grid=(120, 120))",
    "more points than are fitted": "neurbs.reconstruct(rng.random((1_500_000, 3)))",
    "heights": "[neurbs.fit_heights(many, (90, 90)) for _ in range(100)]",
    "evaluate": "[surface.evaluate(uv) for _ in range(1000)]",
    "tessellate": "surface.tessellate(shape=(7000, 7000))",
    "tessellate within a tolerance": "surface.tessellate(1e-6, relative=True)",
    "write a mesh": "neurbs.save(mesh, path)",
    "write STEP": "neurbs.save(large, path.replace('.obj', '.step'))",
    "write IGES": "neurbs.save(large, path.replace('.obj', '.igs'))",
}


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
@pytest.mark.parametrize("job", LONG_JOBS)
def test_ctrl_c_is_answered(job: str, unanswered: Callable[..., float], tmp_path: Path) -> None:
    """Interrupt a long job in a process of its own, and measure how long the answer takes."""
    before = f"""
        rng = np.random.default_rng(0)
        points, many = rng.random((3000, 3)), rng.random((50_000, 3))
        path = {str(tmp_path / "big.obj")!r}
        surface = neurbs.NurbsSurface(rng.random((20, 20, 3)))
        uv = rng.random((4_000_000, 2))
        if {job!r} == "check points":
            # A line, refused only when all of it has been seen; then again.
            line = np.linspace(0, 1, 3_000_000)[:, None] * [[1.0, 2.0, 3.0]]
            check, neurbs.reconstruct = neurbs.reconstruct, lambda points: refused(points)
        if {job!r} == "measure":
            cloud = rng.random((3_000_000, 3))
            som = neurbs.SelfOrganizingMap(50, 50, epochs=1).fit(points)

        def refused(points):
            try:
                check(points)
            except neurbs.NeurbsError:
                pass

        mesh = surface.tessellate(shape=(2000, 2000)) if {job!r} == "write a mesh" else None
        if {job!r} in ("write STEP", "write IGES"):
            large = neurbs.NurbsSurface(rng.random((1500, 1500, 3)))
    """
    assert any(unanswered(before, LONG_JOBS[job], 0.4) < 0.2 for _ in range(3))
    assert not any(tmp_path.iterdir())


def test_ctrl_c_is_not_swallowed_by_a_callback(terrain_points: Points) -> None:
    def interrupt(_: Progress) -> None:
        signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        neurbs.reconstruct(terrain_points, progress=interrupt)
