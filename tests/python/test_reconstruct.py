"""`neurbs.reconstruct`: arguments, errors, progress, Ctrl-C."""

import dataclasses
import inspect
import os
import re
import signal
import subprocess
import sys
import textwrap
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

import neurbs
from neurbs import NeurbsError, Progress, Reconstruction, _core

Points = NDArray[np.float64]
JACKSBORO = Path(__file__).parents[2] / "examples" / "jacksboro.xyz"


@pytest.mark.parametrize("steep", [False, True])
def test_a_tolerance_that_already_holds_changes_nothing(steep: bool) -> None:
    points = neurbs.read_points(JACKSBORO)
    if steep:
        u, v = np.random.default_rng(1).random((2, 2000))
        points = np.column_stack([u, v, 0.3 * np.sin(8 * u) * np.cos(6 * v)])
    tolerance = 1.05 * neurbs.reconstruct(points).report.max
    result = neurbs.reconstruct(points, tolerance)
    assert result.report.ended_by == "tolerance"
    assert result.report.converged
    assert not result.report.diagnostics
    assert result.deviations.max() <= tolerance


def test_the_report_measures_the_fit(terrain_points: Points) -> None:
    result = neurbs.reconstruct(terrain_points, tolerance=2.0)
    report = result.report
    assert report.ended_by == "tolerance"
    assert report.within == 1.0
    assert result.deviations.max() == report.max <= 2.0
    assert report.percentiles[50] == np.sort(result.deviations)[len(terrain_points) // 2 - 1]
    places = result.surface.evaluate(result.uv)
    distances = np.linalg.norm(places - terrain_points, axis=1)
    np.testing.assert_allclose(distances, result.deviations, atol=1e-10 * report.diagonal)
    nearest = result.surface.closest_points(terrain_points).distances
    assert (nearest <= result.deviations + 1e-10 * report.diagonal).all()
    for words in ("rms", "control points", "100 % within the tolerance", "refine"):
        assert words in str(report)


def test_the_report_says_that_the_size_of_the_net_was_given(terrain_points: Points) -> None:
    # A height field and a sheet are grown by different means.
    for kind in ("height", "sheet"):
        report = neurbs.reconstruct(terrain_points, kind=kind, grid=(7, 6)).report
        assert report.ended_by == "grid"
        assert "the size of the net was given" in str(report)
    grown = neurbs.reconstruct(terrain_points).report
    assert grown.ended_by != "grid"


def test_each_end_of_growth_has_words(terrain_points: Points) -> None:
    report = neurbs.reconstruct(terrain_points, grid=(5, 5)).report
    assert neurbs.Report.__doc__
    described = neurbs.Report.__doc__.split("ended_by : str")[1].split("fairness : ")[0]
    names = re.findall(r'``"(\w+)"``', described)
    assert len(names) == 7
    for name in names:
        lines = dataclasses.replace(report, ended_by=name).lines()
        assert lines["fit"].startswith("1 iteration: ")


def test_a_missed_tolerance_is_a_warning(terrain_points: Points) -> None:
    message = r"Tolerance 1e-6 not reached: \d+ of"
    with pytest.warns(neurbs.ToleranceMissedWarning, match=message):
        result = neurbs.reconstruct(terrain_points, tolerance=1e-6, max_control_points=50)
    assert not result.report.converged
    assert result.report.ended_by == "max_control_points"
    (missed,) = (f for f in result.report.diagnostics if f.code == "tolerance-missed")
    assert missed.data["cause"] == "max_control_points"
    assert "raise `max_control_points`" in missed.message


@pytest.mark.parametrize("kind", ["sheet", "tube", "torus"])
def test_each_kind_closes_its_directions(
    kind: Literal["sheet", "tube", "torus"], rng: np.random.Generator
) -> None:
    u, v = rng.random((2, 900))
    a, b = 2 * np.pi * u, 2 * np.pi * v
    r = 1 + 0.3 * np.cos(b)
    points = {
        "sheet": np.column_stack([u, v, u * v]),
        "tube": np.column_stack([np.cos(a), np.sin(a), 3 * v]),
        "torus": np.column_stack([r * np.cos(a), r * np.sin(a), 0.3 * np.sin(b)]),
    }[kind]
    result = neurbs.reconstruct(points, kind=kind, grid=(12, 12))
    assert result.surface.closed == (kind != "sheet", kind == "torus")
    assert result.report.rms < 1e-3


def test_defaults_are_those_of_the_core() -> None:
    ours = inspect.signature(neurbs.reconstruct).parameters
    options = {
        name: p.default for name, p in ours.items() if name not in ("points", "unit", "progress")
    }
    assert options == _core.default_options()


def test_the_report_is_plain(result: Reconstruction) -> None:
    report = result.report.to_dict()
    rows, cols = result.report.grid
    assert report["grid"] == [rows, cols]
    assert report["points"] == len(result.points)
    assert report["converged"] is True
    assert {"prepare", "observe", "rank", "refine", "measure", "python"} <= report["seconds"].keys()
    assert report["percentiles"][50] <= report["rms"] <= report["max"]


def test_a_path_is_no_points() -> None:
    with pytest.raises(
        NeurbsError, match=r"got the path 'scan\.xyz': read it with neurbs\.read_points"
    ):
        neurbs.reconstruct("scan.xyz")


def test_the_stages_account_for_all_of_the_time(terrain_points: Points) -> None:
    start = time.perf_counter()
    report = neurbs.reconstruct(terrain_points, grid=(12, 12)).report
    elapsed = time.perf_counter() - start
    assert 0.9 * elapsed < sum(report.seconds.values()) <= elapsed


def test_an_ordered_grid_belongs_to_the_surface() -> None:
    message = r"got an ordered grid of shape \(4, 5, 3\): use NurbsSurface.interpolate or"
    for function in (neurbs.reconstruct, neurbs.reconstruct_paper):
        with pytest.raises(NeurbsError, match=message):
            function(np.zeros((4, 5, 3)))


def test_a_net_is_recovered_from_points_of_its_surface(rng: np.random.Generator) -> None:
    u, v = np.meshgrid(np.linspace(0, 1, 8), np.linspace(0, 1, 7), indexing="ij")
    net = np.stack([u, v, 0.15 * np.sin(5 * u) * np.cos(4 * v)], axis=-1)
    truth = neurbs.NurbsSurface(net)
    points = truth.evaluate(rng.random((2000, 2)))
    found = neurbs.recover_net(points, (8, 7))
    others = truth.evaluate(rng.random((500, 2)))
    assert found.control_points.shape == (8, 7, 3)
    assert found.closest_points(others).distances.max() < 1e-6
    noisy = points + 1e-3 * rng.standard_normal(points.shape)
    with pytest.raises(NeurbsError, match="points must be on a surface with a net of 8 × 7"):
        neurbs.recover_net(noisy, (8, 7))


def test_the_scale_of_axes_is_the_users(rng: np.random.Generator) -> None:
    x, y = rng.random((2, 600))
    points = np.column_stack([x, y, 1e4 * np.sin(3 * x) * y])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        report = neurbs.reconstruct(points, grid=(8, 8), axis_scale=(1, 1, 1e4)).report
    assert report.axis_scale == (1, 1, 1e4)
    assert "z divided by 10000" in str(report)


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
        (
            "kind",
            "cone",
            "'auto' or 'sheet' or 'height' or 'tube' or 'torus', got 'cone'",
        ),
        ("kind", "body", "kind must be .* .bodies are not supported yet., got 'body'"),
        ("tolerance", 0, "tolerance must be positive and finite, got 0"),
        ("component", "all", "component must be a number or 'each', got 'all'"),
        ("axis_scale", (1, 0, 1), "axis_scale must be positive and finite, got"),
        ("axis_scale", 3, "axis_scale must be three positive numbers"),
        ("grid", (1, 5), r"grid must be \(rows, cols\) of at least \(2, 2\)"),
        ("grid", (2**40, 2**40), "at most 16777216 nodes in all"),
        ("grid", 5, "grid must be two integers from 0, got 5"),
        ("grid", (-4, 5), r"grid must be two integers from 0, got \(-4, 5\)"),
        ("grid", (4, 5, 6), "grid must be two integers from 0"),
        ("progress", 5, "progress must be callable, got 5"),
        ("degree", 0, "degree must be between 1 and 25, got 0"),
        ("degree", 2.5, "degree must be an integer from 0, got 2.5"),
        ("seed", -1, "seed must be an integer from 0, got -1"),
        ("seed", 2**64, "seed must be an integer from 0"),
        ("fairness", 1e300, "fairness must be from 0 to 1e12, got 1e300"),
        ("fairness", -1.0, "fairness must be from 0 to 1e12, got -1"),
        ("weights", [0, 0, 0, 0], "weights must be positive for some point, got all 0"),
        ("weights", [1, 1, 1, 1e308], "of 1e12 of each other, got 1 to 1e308"),
        ("weights", [1, 1, 1, 0.123456789e20], "of 1e12 of each other, got 1 to 1.235e19"),
        ("weights", [1, 1, 1, -1 / 3], "finite and at least 0, got -0.3333 at index 3"),
        ("tolerance", -1 / 3, "tolerance must be positive and finite, got -0.3333"),
    ],
)
def test_options_out_of_range_are_refused(option: str, value: object, message: str) -> None:
    with pytest.raises(NeurbsError, match=message):
        neurbs.reconstruct(FEW, **{option: value})  # type: ignore[call-overload]


def test_two_clusters_far_apart_are_reported() -> None:
    rng = np.random.default_rng(0)
    x, y = rng.random((2, 1000))
    one = np.column_stack([x, y, 0.1 * np.sin(3 * x)])
    points = np.vstack([one, one + np.array([1e6, 0, 0])])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert "components" in [each.code for each in neurbs.reconstruct(points).report.diagnostics]
        assert neurbs.reconstruct(points, component=1).report.valid
    with pytest.raises(NeurbsError, match=r"with none near \d+ of the 144 control points"):
        neurbs.reconstruct(points, kind="height")


def test_one_point_far_away_is_an_outlier() -> None:
    points = np.random.default_rng(0).random((2000, 3))
    points[:, 2] = np.sin(3 * points[:, 0]) * points[:, 1]
    points[0] = 1e8
    result = neurbs.reconstruct(points)
    assert not result.inliers[0]
    assert result.inliers[1:].all()
    assert result.report.rms < 1e-4


@pytest.mark.skipif(sys.platform != "linux", reason="memory limits of Linux")
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
            lambda: neurbs.reconstruct_paper(points, grid=(4000, 4000)),
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
    assert run.stdout.count("a lattice of 4000 × 4000 nodes needs about 8.2 GB of memory") == 3


def test_lists_and_arrays_are_accepted_for_tuples(terrain_points: Points) -> None:
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


def test_an_exception_in_the_callback_ends_the_job(terrain_points: Points) -> None:
    def fail(_: Progress) -> None:
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        neurbs.reconstruct(terrain_points, progress=fail)


def test_progress_reports_the_share_of_the_whole_job(terrain_points: Points) -> None:
    shares = []
    neurbs.reconstruct(terrain_points, progress=lambda progress: shares.append(progress.share))
    assert all(share is not None for share in shares)
    assert shares == sorted(shares)
    assert 0 <= shares[0] < 0.1
    assert 0.5 < shares[-1] <= 1


LONG_JOBS = {
    "reconstruct": "neurbs.reconstruct_paper(points, max_steps=10**12, min_change=1e-12)",
    "fit": "neurbs.SelfOrganizingMap(epochs=10**9, min_change=1e-300).fit(points)",
    "fit a large lattice": "neurbs.SelfOrganizingMap(1500, 1500, epochs=99).fit(points)",
    "check points": "[neurbs.reconstruct(line) for _ in range(100)]",
    "geodesic": "[neurbs.SelfOrganizingMap(init='geodesic').fit(points) for _ in range(100)]",
    "measure": "[som.topographic_error(cloud) for _ in range(100)]",
    "a large lattice": "neurbs.reconstruct_paper(points, grid=(2000, 2000))",
    "all points reached": (
        "neurbs.reconstruct_paper(many, reach=10.0, max_steps=10**12, grid=(300, 300))"
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
    """Interrupt a long job in another process, and measure the time to its end."""
    before = f"""
        rng = np.random.default_rng(0)
        points, many = rng.random((3000, 3)), rng.random((50_000, 3))
        path = {str(tmp_path / "big.obj")!r}
        surface = neurbs.NurbsSurface(rng.random((20, 20, 3)))
        uv = rng.random((4_000_000, 2))
        if {job!r} == "check points":
            # Points on a line, which are refused after all have been read.
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
