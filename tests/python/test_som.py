"""The map: estimator interface, comparison with SciPy, errors, saving and resuming."""

import copy
import inspect
import pickle
import signal
import threading
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import cKDTree

import neurbs
from neurbs import Lattice, SelfOrganizingMap, _core

Points = NDArray[np.float64]


def sheet(count: int = 2000, seed: int = 0) -> Points:
    x, y = np.random.default_rng(seed).random((2, count))
    return np.column_stack([x, y, 0.2 * np.sin(4 * x) * np.cos(3 * y)])


def test_options_have_the_core_s_names_and_defaults() -> None:
    signature = inspect.signature(SelfOrganizingMap.__init__).parameters
    own = {"self", "rows", "cols", "topology", "lattice"}
    options = {name: p.default for name, p in signature.items() if name not in own}
    assert options == _core.som_options(paper=False)
    paper = SelfOrganizingMap.paper(sheet(13)).get_params()
    assert {name: paper[name] for name in options} == _core.som_options(paper=True)


def test_batch_training_is_the_reference_to_the_last_digits() -> None:
    points, (rows, cols), epochs = sheet(), (9, 7), 4
    start = SelfOrganizingMap(rows, cols, epochs=1).fit(points).codebook_
    som = SelfOrganizingMap(
        rows, cols, init=start, kernel="mean", radius=("linear", 3.0, 1.0), epochs=epochs
    ).fit(points)
    nodes, row, col = start.reshape(-1, 3), np.arange(rows), np.arange(cols)
    for epoch in range(epochs):
        radius = 3.0 - 2.0 * epoch / (epochs - 1)
        winners = cKDTree(nodes).query(points)[1]
        along_u = np.exp(-((row[:, None] - row) ** 2) / (2 * radius**2))
        along_v = np.exp(-((col[:, None] - col) ** 2) / (2 * radius**2))
        weights = np.einsum("ac,bd->abcd", along_u, along_v).reshape(rows * cols, -1)[:, winners]
        nodes = weights @ points / weights.sum(axis=1, keepdims=True)
    np.testing.assert_allclose(som.codebook_.reshape(-1, 3), nodes, rtol=0, atol=1e-13)


def test_measures_agree_with_scipy() -> None:
    points = sheet()
    som = SelfOrganizingMap(10, 12).fit(points)
    nodes = som.codebook_.reshape(-1, 3)
    distances, order = cKDTree(nodes).query(points, k=2)
    np.testing.assert_array_equal(som.predict(points), order[:, 0])
    np.testing.assert_allclose(som.quantization_error(points), distances[:, 0].mean(), rtol=1e-14)
    row, col = np.divmod(order, 12)
    torn = np.maximum(abs(np.diff(row)), abs(np.diff(col))) > 1
    assert som.topographic_error(points) == torn.mean()
    hits = np.bincount(order[:, 0], minlength=120)
    np.testing.assert_array_equal(som.hits(points), hits.reshape(10, 12))
    np.testing.assert_array_equal(som.unused_nodes(points), np.flatnonzero(hits == 0))
    grid = som.codebook_
    inner = [grid[4, 5], grid[6, 5], grid[5, 4], grid[5, 6]]
    expected = np.mean([np.linalg.norm(grid[5, 5] - other) for other in inner])
    np.testing.assert_allclose(som.u_matrix()[5, 5], expected, rtol=1e-14)


def test_parametrize_gives_the_projection_onto_the_lattice() -> None:
    points = sheet()
    som = SelfOrganizingMap(10, 12).fit(points)
    out = np.empty((len(points), 2))
    uv = som.parametrize(points, out=out)
    assert uv is out
    assert uv.min() >= 0
    assert uv.max() <= 1
    border = 0.75 / np.array([9 + 1.5, 11 + 1.5])
    inside = np.all((uv > border) & (uv < 1 - border), axis=1)
    place = uv[inside] * [9 + 1.5, 11 + 1.5] - 0.75
    cell = np.minimum(place.astype(int), [8, 10])
    s, t = (place - cell).T[:, :, None]
    g, (i, j) = som.codebook_, cell.T
    projection = (1 - s) * ((1 - t) * g[i, j] + t * g[i, j + 1]) + s * (
        (1 - t) * g[i + 1, j] + t * g[i + 1, j + 1]
    )
    nearest = cKDTree(g.reshape(-1, 3)).query(points[inside])[0]
    distances = np.linalg.norm(projection - points[inside], axis=1)
    assert (distances <= nearest + 1e-12).all()
    assert distances.mean() < 0.2 * nearest.mean()
    with pytest.raises(neurbs.NeurbsError, match="extrapolation must be from 0 to 1"):
        som.parametrize(points, extrapolation=1.5)
    with pytest.raises(neurbs.NeurbsError, match="extrapolation must be a number, got True"):
        som.parametrize(points, extrapolation=True)


def test_the_map_is_an_estimator() -> None:
    base = pytest.importorskip("sklearn.base")
    array = np.zeros((4, 4, 3))
    som = SelfOrganizingMap(4, 4, init=array, gain=("linear", 0.5, 0.0), seed=3)
    assert som.init is array
    assert not hasattr(som, "codebook_")
    twin = base.clone(som)
    assert twin.get_params()["gain"] == ("linear", 0.5, 0.0)
    assert som.set_params(rows=5, init="pca") is som
    assert som.get_params()["rows"] == 5
    assert som.get_params()["init"] == "pca"
    with pytest.raises(neurbs.NeurbsError, match="a parameter must be one of rows, cols"):
        som.set_params(row=5)
    points = sheet(300)
    assert som.fit(points) is som
    first = som.codebook_
    som.fit(points[:100])
    np.testing.assert_array_equal(som.fit(points).codebook_, first)
    assert repr(SelfOrganizingMap(3, 4)) == "SelfOrganizingMap(rows=3, cols=4)"
    assert not first.flags.writeable
    with pytest.raises(AttributeError, match="is not trained yet: call fit"):
        SelfOrganizingMap().predict(points)


def test_copies_pickles_and_files_are_the_same_map(tmp_path: Path) -> None:
    points = sheet(300)
    ring = neurbs.Lattice.graph(12, [(i, (i + 1) % 12) for i in range(12)])
    soms = [
        SelfOrganizingMap(5, 6, seed=2),
        SelfOrganizingMap(lattice=ring, training="online", max_steps=500),
        SelfOrganizingMap(5, 6, topology="torus", radius=lambda share: 2.0 - share, epochs=3),
        SelfOrganizingMap(2, 2, init=points[:4], epochs=2, gain=0.5),
    ]
    for som in soms:
        som.fit(points)
        som.save(tmp_path / "map.npz")
        loaded = SelfOrganizingMap.load(tmp_path / "map.npz")
        np.testing.assert_array_equal(loaded.codebook_, som.codebook_)
        np.testing.assert_array_equal(loaded.fit(points).codebook_, som.codebook_)
        assert (loaded.n_iter_, loaded.stopped_by_) == (som.n_iter_, som.stopped_by_)
        np.testing.assert_array_equal(copy.deepcopy(som).codebook_, som.codebook_)
        if not callable(som.radius):
            again = pickle.loads(pickle.dumps(som))
            np.testing.assert_array_equal(again.codebook_, som.codebook_)
    (tmp_path / "other.npz").write_bytes(b"no archive")
    with pytest.raises(neurbs.NeurbsError, match="must be a map that"):
        SelfOrganizingMap.load(tmp_path / "other.npz")
    with pytest.raises(FileNotFoundError):
        SelfOrganizingMap.load(tmp_path / "missing.npz")


def test_checkpoint_seconds_are_not_negative(tmp_path: Path) -> None:
    cases: list[tuple[Any, str]] = [(-1.0, "at least 0, got -1"), ("x", "a number, got 'x'")]
    for seconds, message in cases:
        with pytest.raises(neurbs.NeurbsError, match=f"checkpoint_seconds must be {message}"):
            SelfOrganizingMap(4, 4).fit(
                sheet(50), checkpoint=tmp_path / "map.npz", checkpoint_seconds=seconds
            )


def test_a_stopped_training_resumes_to_the_same_bits(tmp_path: Path) -> None:
    points = sheet(500)
    for options in ({}, {"training": "online", "presentation": "shuffled", "max_steps": 20_000}):
        settings: dict[str, Any] = {"rows": 6, "cols": 6, "epochs": None, **options}
        expected = SelfOrganizingMap(**settings).fit(points)
        calls = 0

        def stop(epoch: neurbs.Epoch) -> None:
            nonlocal calls
            calls += 1
            if calls == 3:
                raise RuntimeError("enough")

        som = SelfOrganizingMap(**settings)
        with pytest.raises(RuntimeError, match="enough"):
            som.fit(points, observer=stop)
        assert 0 < som.n_iter_ < expected.n_iter_
        assert som.stopped_by_ == "unfinished"
        som.save(tmp_path / "map.npz")
        resumed = SelfOrganizingMap.load(tmp_path / "map.npz").resume(points)
        np.testing.assert_array_equal(resumed.codebook_, expected.codebook_)
        checked = SelfOrganizingMap(**settings).fit(
            points, checkpoint=tmp_path / "check.npz", checkpoint_seconds=0.0
        )
        np.testing.assert_array_equal(checked.codebook_, expected.codebook_)
        kept = SelfOrganizingMap.load(tmp_path / "check.npz")
        np.testing.assert_array_equal(kept.codebook_, expected.codebook_)


def test_ctrl_c_keeps_the_trained_steps() -> None:
    som = SelfOrganizingMap(30, 30, training="online", max_steps=10**9, min_change=1e-300)
    threading.Timer(0.3, lambda: signal.raise_signal(signal.SIGINT)).start()
    start = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        som.fit(sheet(5000))
    assert time.perf_counter() - start < 10.0
    assert som.n_iter_ > 0
    assert som.stopped_by_ == "unfinished"
    assert som.quantization_error(sheet(5000)) < 0.2


@pytest.mark.parametrize(
    ("options", "count"),
    [
        ({"init": "geodesic", "rows": 50, "cols": 50}, 1_000_000),
        ({"lattice": "triangular", "rows": 150, "cols": 150}, 100_000),
        ({"lattice": "triangular", "rows": 150, "cols": 150, "training": "online"}, 100_000),
        # With a large radius all nodes move to the middle, at equal distances from the points.
        ({"neighborhood": "bubble", "rows": 150, "cols": 150}, 200_000),
        # Points in the middle of a ring are at equal distances from its nodes.
        ({"lattice": Lattice.graph(9000, [(i, (i + 1) % 9000) for i in range(9000)])}, 100_000),
    ],
)
def test_ctrl_c_is_answered_at_once(
    options: dict[str, Any], count: int, answers_ctrl_c: Callable[..., bool]
) -> None:
    points = sheet(count)
    for after in (0.1, 0.5):
        assert answers_ctrl_c(lambda: SelfOrganizingMap(**options).fit(points), after)


def test_the_observer_sees_error_radius_and_lattice() -> None:
    seen: list[neurbs.Epoch] = []
    points = sheet(500)
    som = SelfOrganizingMap(5, 6, epochs=4, radius=("exponential", 4.0, 0.5))
    som.fit(points, observer=seen.append)
    assert [epoch.step for epoch in seen] == [1, 2, 3, 4]
    np.testing.assert_allclose([epoch.radius for epoch in seen], [4.0, 2.0, 1.0, 0.5])
    np.testing.assert_array_equal(seen[-1].lattice, som.codebook_.reshape(-1, 3))
    before = cKDTree(seen[-2].lattice).query(points)[0].mean()
    np.testing.assert_allclose(seen[-1].error, before, rtol=1e-12)


@pytest.mark.parametrize("training", ["batch", "online"])
def test_a_callable_schedule_equals_the_formula(training: str) -> None:
    points = sheet(300)
    options: dict[str, Any] = {"training": training, "epochs": 5}
    named = SelfOrganizingMap(5, 5, radius=("linear", 3.0, 1.0), gain=0.2, **options)
    called = SelfOrganizingMap(5, 5, radius=lambda t: 3 - 2 * t, gain=lambda t: 0.2, **options)
    np.testing.assert_allclose(
        called.fit(points).codebook_, named.fit(points).codebook_, rtol=0, atol=1e-12
    )


def test_any_split_into_chunks_gives_the_same_bits() -> None:
    points = sheet(3000)
    start = SelfOrganizingMap(6, 6, epochs=1).fit(points).codebook_
    codebooks = []
    for cuts in ([], [1000], [10, 20, 2999]):
        som = SelfOrganizingMap(6, 6, init=start)
        som.partial_fit(points, end_epoch=False)
        som.end_epoch()
        for _ in range(3):
            for chunk in np.split(points, cuts):
                som.partial_fit(chunk, end_epoch=False)
            som.end_epoch()
        codebooks.append(som.codebook_)
    np.testing.assert_array_equal(codebooks[0], codebooks[1])
    np.testing.assert_array_equal(codebooks[0], codebooks[2])
    with pytest.raises(neurbs.NeurbsError, match="end_epoch must be called after partial_fit"):
        som.end_epoch()


def test_an_unfinished_epoch_is_saved_and_continued(tmp_path: Path) -> None:
    points = sheet(3000)
    expected = SelfOrganizingMap(6, 6)
    som = SelfOrganizingMap(6, 6)
    for chunk in np.split(points, 3):
        expected.partial_fit(chunk, end_epoch=False)
    for chunk in np.split(points, 3):
        som.partial_fit(chunk, end_epoch=False)
        som.save(tmp_path / "half.npz")
        som = pickle.loads(pickle.dumps(SelfOrganizingMap.load(tmp_path / "half.npz")))
    assert som.n_iter_ == 0
    np.testing.assert_array_equal(som.end_epoch().codebook_, expected.end_epoch().codebook_)


@pytest.mark.parametrize("training", ["batch", "online"])
def test_an_interrupted_distribution_continues_to_the_same_bits(
    training: Literal["batch", "online"], tmp_path: Path
) -> None:
    def chunks() -> Any:
        return (sheet(777, seed) for seed in range(10_000))

    def square(count: int, rng: np.random.Generator) -> Points:
        return rng.random((count, 3))

    for source in (lambda: square, chunks):
        expected = SelfOrganizingMap(8, 8, training=training, epochs=8)
        expected.fit_distribution(source())
        calls = 0

        def broken(count: int, rng: np.random.Generator) -> Points:
            nonlocal calls
            calls += 1
            if calls == 4:
                raise OSError("the sensor is gone")
            return draws(count, rng)  # noqa: B023

        draws = source()
        som = SelfOrganizingMap(8, 8, training=training, epochs=8)
        if callable(draws):
            with pytest.raises(OSError, match="sensor"):
                som.fit_distribution(broken)
        else:
            with pytest.raises(neurbs.NeurbsError, match="chunks must have"):
                som.fit_distribution(sheet(777, seed) for seed in range(20))
        assert 0 < som.n_iter_ < expected.n_iter_
        som.save(tmp_path / "map.npz")
        som = SelfOrganizingMap.load(tmp_path / "map.npz").resume_distribution(source())
        np.testing.assert_array_equal(som.codebook_, expected.codebook_)
    with pytest.raises(neurbs.NeurbsError, match="resume_distribution must be called after"):
        SelfOrganizingMap().resume_distribution(square)


def test_winners_and_parameters_are_written_to_out() -> None:
    points = sheet()
    som = SelfOrganizingMap(6, 7, init="auto").fit(points)
    out = np.empty(len(points), dtype=np.int64)
    assert som.predict(points, out=out) is out
    np.testing.assert_array_equal(out, som.predict(points))
    with pytest.raises(neurbs.NeurbsError, match="out must be a writeable, C-contiguous int64"):
        som.predict(points, out=np.empty(3, dtype=np.int64))
    np.testing.assert_array_equal(som.transform(points), som.parametrize(points))
    np.testing.assert_array_equal(
        SelfOrganizingMap(6, 7, init="auto").fit_transform(points), som.transform(points)
    )


def test_a_map_is_a_step_of_a_pipeline() -> None:
    pipeline = pytest.importorskip("sklearn.pipeline")
    preprocessing = pytest.importorskip("sklearn.preprocessing")
    points = sheet()
    steps = pipeline.make_pipeline(preprocessing.StandardScaler(), SelfOrganizingMap(6, 6))
    winners = steps.fit_predict(points)
    scaled = (points - points.mean(axis=0)) / points.std(axis=0)
    expected = SelfOrganizingMap(6, 6).fit(scaled)
    assert (winners == expected.predict(scaled)).mean() > 0.999
    assert steps.transform(points).shape == (len(points), 2)
    steps.set_params(selforganizingmap__rows=4)
    assert steps.fit(points)[-1].codebook_.shape == (4, 6, 3)


def test_check_estimator_fails_only_for_tables_that_are_no_points() -> None:
    checks = pytest.importorskip("sklearn.utils.estimator_checks")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        results = checks.check_estimator(SelfOrganizingMap(4, 4, epochs=3), on_fail=None)
    failed = {r["check_name"]: str(r["exception"]) for r in results if r["status"] == "failed"}
    assert sum(r["status"] == "passed" for r in results) >= 30
    # The map takes two or three columns only, and its messages differ from scikit-learn's.
    width = {
        "check_n_features_in",
        "check_n_features_in_after_fitting",
        "check_transformer_general",
        "check_positive_only_tag_during_fit",
        "check_estimators_dtypes",
        "check_dtype_object",
    }
    words = {
        "check_complex_data",
        "check_estimators_empty_data_messages",
        "check_fit2d_1sample",
        "check_fit2d_1feature",
        "check_fit2d_predict1d",
    }
    assert set(failed) <= width | words, failed


def test_distributions_from_samplers_and_chunks() -> None:
    def sampler(count: int, rng: np.random.Generator) -> Points:
        return sheet(count, int(rng.integers(1 << 30)))

    for training in ("batch", "online"):
        som = SelfOrganizingMap(8, 8, training=training).fit_distribution(sampler)
        again = SelfOrganizingMap(8, 8, training=training).fit_distribution(sampler)
        np.testing.assert_array_equal(som.codebook_, again.codebook_)
        assert som.quantization_error(sheet()) < 0.06
    chunks = (sheet(777, seed) for seed in range(10_000))
    som = SelfOrganizingMap(8, 8, epochs=10).fit_distribution(chunks)
    assert som.quantization_error(sheet()) < 0.06
    with pytest.raises(neurbs.NeurbsError, match=r"chunks must have at least \d+ points"):
        SelfOrganizingMap(8, 8, epochs=10).fit_distribution(sheet(777, s) for s in range(20))


@pytest.mark.parametrize(
    ("source", "message"),
    [
        (lambda count, rng: sheet(count - 1), "source must return as many points as requested"),
        (lambda count, rng: sheet(count) * np.nan, "points must be finite"),
        (lambda count, rng: "rubbish", "points must be real numbers"),
        (lambda count, rng: np.zeros((count, 3)), "points must differ"),
        (5, "source must be a callable or an iterable of arrays, got 5"),
    ],
)
def test_bad_samplers_are_refused(source: Any, message: str) -> None:
    with pytest.raises(neurbs.NeurbsError, match=message):
        SelfOrganizingMap(5, 5).fit_distribution(source)


def test_a_sampler_that_fails_later_keeps_the_trained_steps() -> None:
    calls = 0

    def failing(count: int, rng: np.random.Generator) -> Points:
        nonlocal calls
        calls += 1
        if calls == 5:
            raise OSError("the sensor is gone")
        return sheet(count, calls)

    som = SelfOrganizingMap(5, 5)
    with pytest.raises(OSError, match="the sensor is gone"):
        som.fit_distribution(failing)
    assert som.n_iter_ == 3


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"rows": 1}, r"grid must be \(rows, cols\) of at least \(2, 2\)"),
        ({"rows": 10**9, "cols": 10**9}, "at most 16777216 nodes in all, got .*GB of memory"),
        ({"rows": 2.5}, "rows must be an integer"),
        ({"rows": True}, "rows must be an integer from 0, got True"),
        ({"topology": None}, "topology must be 'sheet', 'tube' or 'torus', got None"),
        ({"lattice": np.zeros(3)}, "lattice must be 'quad', 'triangular' or a Lattice, got array"),
        ({"topology": "ring"}, "topology must be 'sheet' or 'tube' or 'torus', got 'ring'"),
        ({"lattice": "hex"}, "lattice must be 'quad', 'triangular' or a Lattice, got 'hex'"),
        ({"training": "fast"}, "training must be 'batch' or 'online', got 'fast'"),
        ({"init": "best"}, "init must be 'pca', 'geodesic', .* or an array"),
        ({"init": np.zeros((3, 3, 3))}, "init must be 400 positions"),
        ({"neighborhood": "wide"}, "neighborhood must be 'gaussian' or 'bubble'"),
        ({"kernel": "cubic"}, "kernel must be 'mean' or 'linear'"),
        ({"presentation": "all"}, "presentation must be 'random' or"),
        ({"gain": 2.0}, "gain must be from 0 to 1"),
        ({"gain": ("linear", 1.0)}, "gain must be a number, "),
        ({"gain": True}, "gain must be a number, .*, got True"),
        ({"radius": ("linear", True, 1.0)}, "radius must be a number, "),
        ({"radius": lambda t: "wide"}, "radius must be a callable that returns numbers"),
        ({"radius": -1.0}, "radius must be finite and at least 0"),
        ({"epochs": 0}, "epochs must be at least 1"),
        ({"epochs": True}, "epochs must be an integer from 0, got True"),
        ({"max_steps": -1}, "max_steps must be an integer from 0"),
        ({"reach": 0.0}, "reach must be positive and finite"),
        ({"reach": np.True_}, "reach must be a number, got np.True_"),
        ({"min_change": np.nan}, "min_change must be positive and finite"),
        ({"seed": "x"}, "seed must be an integer"),
        ({"seed": False}, "seed must be an integer from 0, got False"),
    ],
)
def test_each_parameter_out_of_its_range(options: dict[str, Any], message: str) -> None:
    with pytest.raises(neurbs.NeurbsError, match=message):
        SelfOrganizingMap(**options).fit(sheet(50))


@pytest.mark.parametrize(
    ("nodes", "edges", "message"),
    [
        (3, [(0, 1), (1, 3)], r"edges must be pairs of different nodes from 0 to 2, got \(1, 3\)"),
        (4, [(0, 1), (2, 3)], "got 2 of 4 nodes"),
        (3, [(0, 1, 2)], "edges must be a sequence of pairs"),
        (3, 5, "edges must be a sequence"),
        (True, [(0, 1)], "nodes must be an integer from 0, got True"),
        (1, [], "nodes must be from 2"),
    ],
)
def test_bad_graphs_are_refused(nodes: int, edges: Any, message: str) -> None:
    with pytest.raises(neurbs.NeurbsError, match=message):
        neurbs.Lattice.graph(nodes, edges)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.full((50, 3), 2.0), "points must differ"),
        (np.column_stack([np.arange(9.0)] * 3), "points must span a surface"),
        (np.where(np.arange(150).reshape(50, 3) == 4, np.nan, 1.0), "points must be finite"),
    ],
)
def test_points_that_are_no_surface(points: Points, message: str) -> None:
    with pytest.raises(neurbs.NeurbsError, match=message):
        SelfOrganizingMap(5, 5).fit(points)


def test_measures_refuse_points_too_far_for_their_squares() -> None:
    som = SelfOrganizingMap(4, 4).fit(sheet(50))
    assert som.predict(1e100 * sheet(50)).shape == (50,)
    with pytest.raises(neurbs.NeurbsError, match="points must be at most 1e150 from the center"):
        som.predict(1e200 * sheet(50))
    assert np.isnan(som.quantization_error(np.empty((0, 3))))


def test_points_may_coincide() -> None:
    points = np.repeat(sheet(50), 20, axis=0)
    som = SelfOrganizingMap(4, 4).fit(points)
    assert som.hits(points).sum() == 1000
