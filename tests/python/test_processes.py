"""Every way to start a process or a thread gives the same numbers, in time, with few resources.

The file is also the program that the tests start: ``python test_processes.py TASK`` does one of
the tasks below in a process of its own, which can be ended if it does not end by itself.
"""

import hashlib
import importlib
import importlib.util
import multiprocessing
import operator
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import warnings
from collections.abc import Callable, Iterable
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs

SECONDS = 120
"""After which a process has failed, and is killed."""

SUBINTERPRETERS = [
    name
    for name in ("_interpreters", "_xxsubinterpreters")
    if importlib.util.find_spec(name) is not None
]
"""The module of Python's own that makes subinterpreters."""

Call = Callable[[], object]


# The calls


def bumpy(points: int) -> NDArray[np.float64]:
    x, y = np.random.default_rng(0).random((2, points))
    return np.column_stack([x, y, 0.2 * np.sin(5 * x) * np.cos(4 * y)])


def surface() -> neurbs.NurbsSurface:
    rng = np.random.default_rng(1)
    x, y = np.meshgrid(np.linspace(0, 1, 20), np.linspace(0, 1, 20), indexing="ij")
    net = np.stack([x, y, 0.1 * rng.random((20, 20))], axis=-1)
    return neurbs.NurbsSurface(net, rng.uniform(0.5, 2, (20, 20)))


def calls(size: int) -> dict[str, Call]:
    """Name calls over the whole API: with several threads at size 100, quick ones at size 1."""
    s, cloud = surface(), bumpy(200 * size)
    few = cloud[: 50 * size]
    uv = np.random.default_rng(2).random((1000 * size, 2))
    near = s.evaluate(uv[: 50 * size]) + 0.01
    side = 8 + 2 * size
    grid = s.evaluate_grid(np.linspace(0, 1, side), np.linspace(0, 1, side))
    curve = s.isocurve(u=0.5)
    low = neurbs.NurbsSurface(s.control_points[::4, ::4])
    on_low = low.evaluate(np.random.default_rng(3).random((1000, 2)))
    net = (5 + size // 4, 5 + size // 4)

    def reread(
        thing: neurbs.NurbsSurface | neurbs.PointCloud, suffix: str, read: Callable[[Path], object]
    ) -> object:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, f"a{suffix}")
            neurbs.save(thing, path)
            return read(path)

    def trained() -> object:
        som = neurbs.SelfOrganizingMap(4 + size // 4, 4 + size // 4, epochs=3)
        return som.fit(cloud).codebook_

    def painted() -> object:
        result = neurbs.reconstruct_paper(cloud[:200], max_steps=2000, grid=(6, 6))
        return result.surface

    return {
        "evaluate": lambda: s.evaluate(uv),
        "evaluate_grid": lambda: s.evaluate_grid(uv[: 5 * size, 0], uv[: 5 * size, 1]),
        "normals": lambda: s.normals(uv),
        "curvatures": lambda: s.curvatures(uv).principal,
        "closest_points": lambda: s.closest_points(near).distances,
        "tessellate": lambda: s.tessellate(0.02 / size),
        "tessellate several": lambda: neurbs.tessellate([s, s.transposed()], 0.02 / size),
        "deviation": lambda: s.tessellate(0.01).deviation(near),
        "area": s.area,
        "length": curve.length,
        "insert_knots": lambda: s.insert_knots(u=np.linspace(0.01, 0.99, size)),
        "elevate_degree": lambda: s.elevate_degree(1, 1),
        "interpolate": lambda: neurbs.NurbsSurface.interpolate(grid),
        "approximate": lambda: neurbs.NurbsSurface.approximate(grid, net),
        "fit": lambda: neurbs.NurbsSurface.fit(cloud, cloud[:, :2], net=net),
        "fit_heights": lambda: neurbs.fit_heights(cloud, net).residuals,
        "fit_weights": lambda: neurbs.fit_weights(low, on_low[: 10 * size]),
        "clean": lambda: neurbs.clean(cloud).kept,
        "components": lambda: neurbs.components(cloud).labels,
        "candidates": lambda: [each.score for each in neurbs.candidates(few)],
        "validate": lambda: [each.code for each in neurbs.validate(s, near)],
        "reconstruct": lambda: neurbs.reconstruct(few, grid=(6, 6)).surface,
        "reconstruct_paper": painted,
        "recover_net": lambda: neurbs.recover_net(on_low, (5, 5)),
        "SelfOrganizingMap": trained,
        "step": lambda: reread(s, ".step", neurbs.load_surface),
        "json": lambda: reread(s, ".json", neurbs.load_surface),
        "read_points": lambda: reread(neurbs.PointCloud(cloud), ".csv", neurbs.read_points),
    }


SLOW = ("recover_net", "reconstruct_paper", "reconstruct", "candidates", "fit_weights", "step")
"""Calls that take long at any size."""


def digest(value: object) -> str:
    """Return a hash of all numbers of a result."""
    match value:
        case list():
            parts = [digest(part).encode() for part in value]
        case neurbs.NurbsSurface():
            arrays = [value.control_points, value.weights, *value.knots]
            parts = [b"" if array is None else array.tobytes() for array in arrays]
        case neurbs.TriangleMesh():
            parts = [value.vertices.tobytes(), value.triangles.tobytes()]
        case np.ndarray():
            parts = [value.tobytes()]
        case _:
            parts = [repr(value).encode()]
    return hashlib.sha256(b"|".join(parts)).hexdigest()


def results(names: Iterable[str] | None = None, size: int = 100) -> dict[str, str]:
    """Make calls; return a hash of each result, and name each call on standard error before."""
    found = {}
    all_calls = calls(size)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for name in names or all_calls:
            print(f"{os.getpid()}: {name}", file=sys.stderr, flush=True)
            found[name] = digest(all_calls[name]())
    return found


def compare(expected: dict[str, str], found: Iterable[dict[str, str]]) -> None:
    """Print the names of results that differ, or "same"."""
    differing = {n for each in found for n, value in each.items() if value != expected[n]}
    print(" ".join(sorted(differing)) or "same")


# The tasks


def task_processes(method: str) -> None:
    expected = results()
    # Two at once, and each does all: the second call of a worker differs from the first.
    context = multiprocessing.get_context(method)
    with ProcessPoolExecutor(2, mp_context=context) as pool:
        compare(expected, pool.map(results, [None, None, ["evaluate", "fit"]]))


def task_joblib(backend: str) -> None:
    from joblib import Parallel, delayed

    expected = results()
    compare(expected, Parallel(n_jobs=2, backend=backend)(delayed(results)() for _ in range(2)))


def task_threads() -> None:
    expected = results()
    names = list(expected)
    few = [[names[i % len(names)], names[(7 * i + 3) % len(names)]] for i in range(32)]
    pool: Executor
    with ThreadPoolExecutor(32) as pool:
        compare(expected, pool.map(results, few))


def task_first_touch(seed: str) -> None:
    names = random.Random(int(seed)).sample(neurbs.__all__, 32)
    barrier, errors = threading.Barrier(32), []

    def touch(name: str) -> None:
        barrier.wait()
        try:
            getattr(neurbs, name)
        except BaseException as error:
            errors.append(f"{name}: {error!r}")

    threads = [threading.Thread(target=touch, args=(name,)) for name in names]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    print(errors or "same")


def task_subinterpreter() -> None:
    expected = results()
    interpreters = importlib.import_module(SUBINTERPRETERS[0])
    code = """if True:
        for name in ("neurbs", "neurbs.io", "neurbs._core", "neurbs"):
            try:
                __import__(name)
                print("imported", flush=True)
            except ImportError as error:
                print(error.name, error, flush=True)
    """
    for _ in range(3):
        interpreter = interpreters.create()
        interpreters.run_string(interpreter, code)
        interpreters.destroy(interpreter)
    compare(expected, [results()])


def task_count_threads() -> None:
    results()
    print(threads_now())


def task_set_threads() -> None:
    expected = results()
    operator.methodcaller("set_num_threads", 2)(neurbs)
    compare(expected, [results()])


def task_many_calls() -> None:
    quick = {name: call for name, call in calls(1).items() if name not in SLOW}
    slow = {name: call for name, call in calls(1).items() if name in SLOW}
    for number in range(1, 3001):
        # One of fifty is slow.
        chosen = list((quick if number % 50 else slow).values())
        chosen[(number if number % 50 else number // 50) % len(chosen)]()
        if number in (1000, 3000):
            status = Path("/proc/self/status").read_text()
            resident = re.search(r"VmRSS:\s*(\d+)", status)
            assert resident is not None
            print(resident.group(1), len(os.listdir("/proc/self/fd")), threads_now())


def threads_now() -> int:
    """Count the threads of this process, once those that are ending have ended."""
    time.sleep(0.2)
    return len(os.listdir("/proc/self/task"))


# The tests

linux = pytest.mark.skipif(sys.platform != "linux", reason="reads /proc, forks")


def started(task: str, *arguments: str, **environment: str) -> str:
    """Return what a task prints, in a process with its own group, which is killed if it hangs."""
    process = subprocess.Popen(
        [sys.executable, "-W", "ignore", __file__, task, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, **environment},
        start_new_session=True,
    )
    try:
        out, err = process.communicate(timeout=SECONDS)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        _, err = process.communicate()
        last = {line.partition(":")[0]: line for line in err.splitlines()}
        pytest.fail(f"no end within {SECONDS} s; last calls: {list(last.values())}")
    assert process.returncode == 0, err[-2000:]
    return out.strip()


@linux
@pytest.mark.parametrize("method", ["fork", "spawn", "forkserver"])
def test_child_processes_return_the_same_numbers(method: str) -> None:
    assert started("processes", method) == "same"


@linux
@pytest.mark.parametrize("backend", ["loky", "threading"])
def test_joblib_returns_the_same_numbers(backend: str) -> None:
    assert started("joblib", backend) == "same"


@linux
def test_32_threads_return_the_same_numbers() -> None:
    assert started("threads") == "same"


@linux
def test_32_threads_may_touch_names_for_the_first_time() -> None:
    for seed in range(10):
        assert started("first_touch", str(seed)) == "same"


@linux
@pytest.mark.skipif(not SUBINTERPRETERS, reason="this Python makes no subinterpreters")
def test_a_subinterpreter_gets_an_import_error_and_the_parent_goes_on() -> None:
    *errors, last = started("subinterpreter").splitlines()
    assert len(errors) == 12
    for error in errors:
        assert error.startswith("neurbs neurbs must be imported in the main interpreter, but this")
        assert "use a process" in error
    assert last == "same"


ALONE = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
"""Libraries other than neurbs start no threads."""


@linux
@pytest.mark.parametrize(("threads", "most"), [("1", 3), ("100000", 260)])
def test_the_number_of_threads_is_limited(threads: str, most: int) -> None:
    limits = {"NEURBS_NUM_THREADS": threads} | ({"RAYON_NUM_THREADS": "1000"} if most < 9 else {})
    assert int(started("count_threads", **limits, **ALONE)) <= most


@linux
def test_the_number_of_threads_changes_no_result() -> None:
    assert started("set_threads") == "same"


@linux
def test_thousands_of_calls_leave_nothing_behind() -> None:
    early, late = (
        [int(word) for word in line.split()] for line in started("many_calls").splitlines()
    )
    # Kilobytes: memory that allocators keep moves by some megabytes.
    assert late[0] - early[0] < 16_000
    assert late[1:] == early[1:]


if __name__ == "__main__":
    globals()[f"task_{sys.argv[1]}"](*sys.argv[2:])
