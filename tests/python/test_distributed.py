"""Reconstruction and training on workers of Dask: real processes, and those of one process."""

import ast
import os
import signal
import threading
import time
import warnings
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import dask
import dask.array as da
import laspy
import numpy as np
import pytest
from distributed import Client, LocalCluster
from numpy.typing import NDArray

import neurbs
from neurbs import _core, distributed
from neurbs.choices import KindChoice
from neurbs.distributed.residuals import Histogram

Floats = NDArray[np.float64]

SAMPLE = 4000
"""Points of the even samples here."""


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    """Two workers with one thread each."""
    with (
        LocalCluster(
            n_workers=2, threads_per_worker=1, memory_limit="1GB", dashboard_address=":0"
        ) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        yield client


def terrain(count: int, noise: float = 0.001) -> Floats:
    """Points of rough hills far from the origin, with noise and a few outliers."""
    rng = np.random.default_rng(0)
    x, y = rng.random((2, count))
    z = 0.1 * np.sin(9 * x) * np.cos(7 * y) + 0.02 * np.sin(31 * x + 23 * y)
    z += noise * rng.standard_normal(count)
    z[:: count // 20] += 0.3
    return np.column_stack([500 * x + 4e5, 500 * y + 5e6, 500 * z])


def tube(count: int) -> Floats:
    turns, height = np.random.default_rng(1).random((2, count))
    angle, radius = 2 * np.pi * turns, 1 + 0.2 * np.sin(4 * height)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 3 * height])


def blocks(points: Floats, parts: int) -> Any:
    return da.from_array(points, chunks=(-(-len(points) // parts), 3))


@pytest.fixture(scope="module")
def tiles(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Six tiles of the terrain as LAZ files."""
    folder = tmp_path_factory.mktemp("tiles")
    points = terrain(30_000)
    points = points[np.argsort(points[:, 0])]
    paths = []
    for number, tile in enumerate(np.array_split(points, 6)):
        header = laspy.LasHeader(point_format=6, version="1.4")
        header.scales, header.offsets = np.full(3, 1e-4), np.floor(tile.min(axis=0))
        file = laspy.LasData(header)
        file.x, file.y, file.z = tile.T
        paths.append(folder / f"tile{number}.laz")
        file.write(paths[-1])
    return paths


@pytest.fixture(autouse=True)
def _no_warnings() -> Iterator[None]:
    """Outliers, which some clouds have, cause warnings."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", neurbs.NeurbsWarning)
        yield


def fit(points: Any, scheduler: Any = "synchronous", **options: Any) -> Any:
    given: dict[str, Any] = {"max_sample": SAMPLE, "grid": (20, 20), **options}
    return distributed.reconstruct(points, scheduler=scheduler, **given)


def far(one: Any, other: Any) -> float:
    """Return the largest distance of two nets' control points, in diagonals."""
    apart = one.surface.control_points - other.surface.control_points
    return float(np.linalg.norm(apart, axis=-1).max() / one.report.diagonal)


@pytest.mark.parametrize("parts", [1, 7, 60])
def test_maps_have_the_same_bits_whatever_the_parts(client: Client, parts: int) -> None:
    # More points than a start is computed from.
    points = terrain(70_000)
    whole = neurbs.SelfOrganizingMap(12, 15, epochs=6).fit(points)
    for scheduler in ("synchronous", client):
        som = neurbs.SelfOrganizingMap(12, 15, epochs=6)
        distributed.fit_map(som, blocks(points, parts), scheduler=scheduler)
        assert som._map.to_bytes() == whole._map.to_bytes()
        if parts == 60:
            break


@pytest.mark.parametrize(
    "options",
    [{"init": "geodesic"}, {"init": "densest-cluster"}, {"topology": "tube"}, {"reach": 1e3}],
)
def test_every_start_of_a_map_has_the_same_bits(options: dict[str, Any]) -> None:
    points = terrain(70_000)
    whole = neurbs.SelfOrganizingMap(8, 9, epochs=3, **options).fit(points)
    with dask.config.set(scheduler="synchronous"):
        som = neurbs.SelfOrganizingMap(8, 9, epochs=3, **options).fit(blocks(points, 9))
    assert som._map.to_bytes() == whole._map.to_bytes()
    assert som.stopped_by_ == whole.stopped_by_


def test_a_map_in_parts_continues_after_an_interruption(tmp_path: Path) -> None:
    points = blocks(terrain(20_000), 4)
    with dask.config.set(scheduler="synchronous"):
        whole = neurbs.SelfOrganizingMap(8, 9, epochs=5).fit(points)
        som = neurbs.SelfOrganizingMap(8, 9, epochs=5)

        def stop(epoch: neurbs.Epoch) -> None:
            if epoch.step == 2:
                raise RuntimeError("stop")

        with pytest.raises(RuntimeError, match="stop"):
            som.fit(points, observer=stop)
        assert som.n_iter_ == 2
        som.resume(points, checkpoint=tmp_path / "map.npz")
    assert som._map.to_bytes() == whole._map.to_bytes()
    assert neurbs.SelfOrganizingMap.load(tmp_path / "map.npz").n_iter_ == 5


def test_training_in_parts_must_be_batch() -> None:
    with pytest.raises(neurbs.NeurbsError, match="training must be 'batch'"):
        neurbs.SelfOrganizingMap(8, 9, training="online").fit(blocks(terrain(5000), 2))


def test_surfaces_agree_whatever_the_parts(client: Client) -> None:
    points = terrain(40_000)
    whole = fit(blocks(points, 1))
    for parts, scheduler in ((7, "synchronous"), (60, "synchronous"), (7, client)):
        found = fit(blocks(points, parts), scheduler)
        assert far(found, whole) < 1e-9
        # The sample does not depend on the parts, nor do the counts.
        np.testing.assert_array_equal(found.sample.points, whole.sample.points)
        assert found.report.inliers == whole.report.inliers
        assert found.report.percentiles == pytest.approx(whole.report.percentiles, rel=1e-6)
    assert found.report.workers == 2
    assert found.report.bytes_moved > 1e5


@pytest.mark.parametrize("kind", ["tube", "sheet", "height"])
def test_all_points_improve_the_surface_of_the_sample(kind: KindChoice) -> None:
    points = tube(30_000)
    if kind != "tube":
        points[:, :2] = np.random.default_rng(4).random((30_000, 2)) + np.array([5e3, 7e3])
        points[:, 2] = 0.2 * np.sin(3 * (points[:, 0] - 5e3)) * (points[:, 1] - 7e3)
    noise = 0.01
    noisy = points + noise * np.random.default_rng(2).standard_normal(points.shape)
    grid = (14, 14)
    found = fit(blocks(noisy, 5), kind=kind, grid=grid, max_sample=2000)
    sampled = neurbs.reconstruct(found.sample.points, kind=kind, grid=grid)
    assert found.report.kind == kind
    assert found.report.valid

    def error(surface: neurbs.NurbsSurface) -> float:
        truth = surface.closest_points(points[::7]).distances
        return float(np.sqrt(np.median(truth**2)))

    assert error(found.surface) < 0.75 * error(sampled.surface)
    assert found.surface.closed == sampled.surface.closed


def test_outliers_lose_their_weight() -> None:
    points = terrain(30_000)
    found = fit(blocks(points, 4))
    inliers = found.inliers.compute()
    assert not inliers[::1500].any()
    assert inliers.mean() > 0.99
    assert found.report.inliers == inliers.sum()


def test_nets_grow_while_points_gain_by_it() -> None:
    points = terrain(60_000, noise=0.00005)
    found = fit(blocks(points, 4), grid=None, max_sample=1000)
    sampled = neurbs.reconstruct(found.sample.points)
    assert np.prod(found.report.grid) > np.prod(sampled.report.grid)
    deviations = sampled.surface.closest_points(points).distances
    assert np.median(found.deviations.compute()) < 0.5 * np.median(deviations)
    assert found.report.ended_by in ("noise", "max_control_points", "points")
    limited = fit(blocks(points, 4), grid=None, max_sample=1000, max_control_points=400)
    assert np.prod(limited.report.grid) <= 400


def test_a_tolerance_is_followed_over_all_points() -> None:
    rng = np.random.default_rng(3)
    x, y = rng.random((2, 40_000))
    points = np.column_stack([x, y, 0.1 * np.sin(12 * x) * np.sin(11 * y)])
    found = fit(blocks(points, 4), grid=None, tolerance=0.0005, max_sample=1000)
    assert found.report.converged
    assert found.report.within == 1.0
    assert float(found.deviations.max().compute()) <= 0.0005


def test_deviations_are_lazy_and_those_of_the_surface(client: Client) -> None:
    points = terrain(25_000)
    found = fit(blocks(points, 5), client)
    assert isinstance(found.deviations, da.Array)
    assert found.points.chunks[0] == (5_000,) * 5
    with client.as_current():
        uv, deviations, inliers = dask.compute(found.uv, found.deviations, found.inliers)
    closest = found.surface.closest_points(points)
    np.testing.assert_allclose(deviations, closest.distances, atol=1e-8)
    np.testing.assert_allclose(uv, closest.uv, atol=1e-6)
    report = found.report
    assert report.max == deviations[inliers].max()
    assert report.percentiles[95] == pytest.approx(np.quantile(deviations[inliers], 0.95), rel=2e-3)
    assert "rounds" in str(report)


def test_a_sample_of_all_points_gives_the_result_of_one_process() -> None:
    points = terrain(3000)
    found = fit(blocks(points, 4), grid=(12, 10))
    whole = neurbs.reconstruct(points, grid=(12, 10))
    assert found.surface == whole.surface
    assert found.report.rounds == ()
    np.testing.assert_array_equal(found.deviations.compute(), whole.deviations)


def test_files_and_iterators_give_the_same_surface(client: Client, tiles: list[Path]) -> None:
    points = [neurbs.read_points(tile) for tile in tiles]
    whole = fit(da.from_array(np.concatenate(points), chunks=(-1, 3)))
    assert far(fit(tiles, client), whole) < 1e-9
    assert far(fit(iter(points), "threads"), whole) < 1e-9
    # Lazy arrays read the files again.
    found = fit(tiles, bounds=(4e5, 5e6, 4e5 + 300, 5e6 + 500))
    inside = np.concatenate(points)
    assert found.report.points == np.sum(inside[:, 0] <= 4e5 + 300) == len(found.points.compute())


def test_threads_parse_headers_of_arrays_one_at_a_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In two threads at a time, `ast` of some versions of Python fails now and then."""
    np.save(tmp_path / "points.npy", terrain(100))
    parse, running, most = ast.literal_eval, 0, 0

    def slow(text: Any) -> Any:
        nonlocal running, most
        running += 1
        most = max(most, running)
        time.sleep(0.01)
        running -= 1
        return parse(text)

    monkeypatch.setattr(ast, "literal_eval", slow)
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(neurbs.read_points, [tmp_path / "points.npy"] * 8))
    assert len(found) == 8
    assert most == 1


def test_faces_are_those_of_the_sample_on_the_last_surface() -> None:
    points = terrain(60_000)
    place = (points - points.min(axis=0)) / np.ptp(points, axis=0)
    in_hole = np.linalg.norm(place[:, :2] - 0.5, axis=1) < 0.2
    found = fit(blocks(points[~in_hole], 6), kind="height")
    assert found.report.rounds
    trim = found.report.trim
    assert len(trim.holes) == 1
    assert trim.area == pytest.approx(found.shell.area(), rel=1e-6)
    assert trim.surface_area == pytest.approx(neurbs.Shell([found.surface]).area(), rel=1e-6)
    assert found.face.surface == found.surface
    # The faces of one process are the same, up to the scatter of the sample.
    whole = neurbs.reconstruct(points[~in_hole], grid=(20, 20), kind="height")
    assert whole.report.trim is not None
    assert trim.area == pytest.approx(whole.report.trim.area, rel=0.03)
    assert trim.holes == pytest.approx(whole.report.trim.holes, rel=0.2)
    untrimmed = fit(blocks(points[~in_hole], 6), kind="height", trim=False)
    assert untrimmed.report.trim is None
    assert not untrimmed.face.is_trimmed


def test_results_have_the_members_of_a_reconstruction(tmp_path: Path) -> None:
    found = fit(blocks(terrain(20_000), 3), kind="height")
    missing = {name for name in dir(found.sample) if not name.startswith("_")} - set(dir(found))
    assert not missing
    assert found.z(*found.surface(0.5, 0.5)[:2]) == pytest.approx(found.surface(0.5, 0.5)[2])
    neurbs.save(found, tmp_path / "surface.step", unit="ft")
    assert neurbs.load_shell(tmp_path / "surface.step").unit == "ft"
    found.save(tmp_path / "report.html")


def test_units_of_files_are_kept_or_converted(tmp_path: Path) -> None:
    points = terrain(9000) - [4e5, 5e6, 0]
    paths = [tmp_path / f"{number}.csv" for number in range(3)]
    for path, tile in zip(paths, np.split(points, 3), strict=True):
        np.savetxt(path, tile, "%.6f", ",", header="x [m],y [m],z [m]", comments="")
    whole = fit(paths)
    assert (whole.unit, whole.shell.unit) == ("m", "m")
    in_mm = fit(paths, unit="mm")
    assert (in_mm.unit, in_mm.shell.unit) == ("mm", "mm")
    assert in_mm.report.rms == pytest.approx(1000 * whole.report.rms, rel=0.01)
    in_array = fit(blocks(points, 3), unit="mm")
    assert (in_array.unit, in_array.shell.unit) == ("mm", "mm")
    assert in_array.report.rms == pytest.approx(whole.report.rms, rel=0.01)
    paths[1].write_text(paths[1].read_text().replace("[m]", "[ft]"))
    with pytest.raises(neurbs.NeurbsError, match=r"got 'm' in .*0\.csv and 'ft' in .*1\.csv"):
        fit(paths)


def test_doubts_about_files_are_warned_of_once(tmp_path: Path) -> None:
    points = terrain(9000) - [4e5, 5e6, 0]
    points[::1000, 2] = np.nan
    paths = [tmp_path / f"{number}.csv" for number in range(3)]
    for path, tile in zip(paths, np.split(points, 3), strict=True):
        rows = np.column_stack([np.arange(1, 3001), tile])
        np.savetxt(path, rows, ["%d", "%.6f", "%.6f", "%.6f"], ",")
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        assert fit(paths, nan="drop").report.points == 8991
    messages = {one.category.code: str(one.message) for one in found}  # type: ignore[attr-defined]
    assert "9 of 9000 points are not finite" in messages["points-dropped"]
    assert "0.csv" in messages["columns-guessed"]
    assert "2 more of this kind" in messages["columns-guessed"]
    assert len(found) == len(messages)


def test_a_killed_worker_costs_time_only(client: Client) -> None:
    points = blocks(terrain(40_000), 20)
    whole = fit(points)
    before = client.run(os.getpid)
    killed = threading.Event()

    def kill(state: distributed.Progress) -> None:
        if state.stage == "fitting" and state.step > 3 and not killed.is_set():
            killed.set()
            os.kill(next(iter(before.values())), signal.SIGKILL)

    found = fit(points, client, progress=kill)
    assert killed.is_set()
    assert far(found, whole) < 1e-9
    client.wait_for_workers(2, timeout=20)
    assert set(client.run(os.getpid).values()) != set(before.values())


def test_an_exception_of_the_callback_cancels_the_job(client: Client) -> None:
    def stop(state: distributed.Progress) -> None:
        if state.stage == "fitting":
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        fit(blocks(terrain(40_000), 20), client, progress=stop)
    deadline = time.monotonic() + 10
    while any(client.processing().values()) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not any(client.processing().values())


def test_ctrl_c_ends_the_job(client: Client) -> None:
    def interrupt(state: distributed.Progress) -> None:
        if state.stage == "fitting":
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        fit(blocks(terrain(40_000), 20), client, progress=interrupt)


def test_a_damaged_file_is_named_or_skipped(
    client: Client, tiles: list[Path], tmp_path: Path
) -> None:
    damaged = tmp_path / "broken.laz"
    damaged.write_bytes(tiles[2].read_bytes()[:20_000])
    files = [*tiles[:2], damaged, *tiles[3:]]
    with pytest.raises(neurbs.NeurbsError, match=r"broken\.laz.*damaged|broken\.laz.*cut short"):
        fit(files, client)
    found = fit(files, client, errors="skip")
    assert found.report.points == 25_000
    assert list(found.report.skipped or {}) == [str(damaged)]
    others = fit([*tiles[:2], *tiles[3:]])
    assert far(found, others) < 1e-9
    missing = tmp_path / "missing.laz"
    with pytest.raises(FileNotFoundError, match=r"missing\.laz"):
        fit([tiles[0], missing])


def test_a_block_that_is_not_finite_is_named() -> None:
    points = terrain(5000)
    points[3210, 1] = np.nan
    with pytest.raises(neurbs.NeurbsError, match="block 3 of the array: points must be finite"):
        fit(blocks(points, 5))


def test_too_little_memory_is_an_error_before_the_work(client: Client) -> None:
    with pytest.raises(neurbs.NeurbsMemoryError, match=r"must have at least .* MB of memory"):
        fit(blocks(terrain(20_000), 2), client, grid=(400, 400))
    with pytest.raises(neurbs.NeurbsMemoryError, match=r"grid must be a net .* at most some"):
        fit(blocks(terrain(20_000), 2), grid=(4000, 4000))


@pytest.mark.parametrize(
    ("points", "options", "message"),
    [
        (terrain(100), {}, "points must be a dask array, a list of files or an iterator"),
        ([], {}, "points must be at least one file"),
        (iter([]), {}, "points must have at least one chunk"),
        (blocks(terrain(100), 1), {"weights": [1.0]}, "weights must be left out"),
        (blocks(terrain(100), 1), {"component": 0}, "component must be left out"),
        (blocks(terrain(100), 1), {"bounds": (0, 0, 1, 1)}, "bounds must be left out"),
        (blocks(terrain(100), 1), {"errors": "hide"}, "errors must be 'raise' or 'skip'"),
        (blocks(terrain(100), 1), {"max_sample": 1}, "max_sample must be an integer from 4"),
        (["a.docx"], {}, "suffix"),
        (blocks(terrain(100), 1), {"grid": 9}, "grid must be two integers"),
        (blocks(terrain(100), 1), {"grid": (1, 9)}, "grid must be"),
        (blocks(terrain(100), 1), {"degree": (2, 3)}, "degree must be an integer"),
        (blocks(terrain(100), 1), {"tolerance": -1.0}, "tolerance must be positive"),
        (blocks(terrain(100), 1), {"trim": "half"}, "trim must be"),
    ],
)
def test_wrong_arguments_are_refused(points: Any, options: dict[str, Any], message: str) -> None:
    with pytest.raises(neurbs.NeurbsError, match=message):
        fit(points, **options)


def test_options_are_checked_before_points_are_read(tmp_path: Path) -> None:
    def points() -> Iterator[Floats]:
        raise AssertionError("read")
        yield terrain(9)

    with pytest.raises(neurbs.NeurbsError, match="fairness must be"):
        fit(points(), fairness=-1.0)
    with pytest.raises(TypeError, match="unexpected keyword argument 'knots'"):
        fit(points(), knots=3)


def test_histograms_are_exact_and_quantiles_near() -> None:
    distances = np.abs(np.random.default_rng(0).standard_normal(30_001)) ** 3
    whole = Histogram.of(distances)
    parts = [Histogram.of(part) for part in np.array_split(distances, 7)]
    merged = sum(parts[1:], parts[0])
    np.testing.assert_array_equal(merged.bins, whole.bins)
    np.testing.assert_array_equal(merged.counts, whole.counts)
    for share in (0.1, 0.5, 0.99):
        assert whole.quantile(share) == pytest.approx(np.quantile(distances, share), rel=2e-3)
    assert Histogram.of(np.zeros(5)).quantile(0.5) < 1e-300


def test_samples_of_parts_merge_to_the_sample_of_all() -> None:
    points = terrain(30_000)
    whole = neurbs.EvenSample(1000)
    whole.extend(points)
    merged = neurbs.EvenSample(1000)
    for part in np.array_split(points, 13):
        sample = neurbs.EvenSample(1000)
        sample.extend(part)
        merged.merge(_core.EvenSample.from_bytes(sample.to_bytes()))
    np.testing.assert_array_equal(merged.points, whole.points)
    np.testing.assert_array_equal(merged.indices, whole.indices)
    assert merged.seen == 30_000
    with pytest.raises(neurbs.NeurbsError, match="sample must be of 1000 points"):
        merged.merge(neurbs.EvenSample(999))
