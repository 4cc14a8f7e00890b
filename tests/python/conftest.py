"""Fixtures that several test files use."""

import inspect
import json
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs
from neurbs import cli

# Tests that a shell starts in the background ignore Ctrl-C, and so do the processes they start.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


MAX_SECONDS = 0.2
"""Longest time from Ctrl-C to KeyboardInterrupt, in seconds."""

TRIES = 3
"""Number of tries, of which the fastest is used, as shared machines lose time."""


@pytest.fixture(scope="session")
def revealed() -> Callable[[Path], str]:
    """Return a function that checks the types of a program, and returns the lines of mypy."""
    pytest.importorskip("mypy")
    # An installed package is found by itself.
    place = Path(neurbs.__file__).parents[1]
    path = {} if place.name.endswith("-packages") else {"MYPYPATH": str(place)}

    def check(program: Path) -> str:
        run = [sys.executable, "-m", "mypy", "--strict", program.name]
        environment = os.environ | path
        done = subprocess.run(
            run, cwd=program.parent, env=environment, capture_output=True, text=True
        )
        return done.stdout

    return check


def worked() -> float:
    """Return the processor time of this process in seconds, per processor."""
    return time.process_time() / (os.cpu_count() or 1)


@pytest.fixture
def answers_ctrl_c() -> Callable[..., bool]:
    """Return a function that checks whether a job handles a Ctrl-C in time."""

    def repeat(job: Callable[[], object]) -> None:
        # Repeated, as a fast machine may finish the job before Ctrl-C.
        while True:
            job()

    def delay(job: Callable[[], object], after: float) -> float:
        sent = []

        def interrupt() -> None:
            sent.append(worked())
            os.kill(os.getpid(), signal.SIGINT)

        timer = threading.Timer(after, interrupt)
        timer.start()
        try:
            with pytest.raises(KeyboardInterrupt):
                repeat(job)
            return worked() - sent[0]
        finally:
            timer.join()

    def answers(job: Callable[[], object], after: float = 0.1) -> bool:
        return any(delay(job, after) < MAX_SECONDS for _ in range(TRIES))

    return answers


INTERRUPTED = """
import os, signal, threading, time
import numpy as np
import neurbs

{worked}
{before}
def interrupt():
    time.sleep({delay})
    sent.append(worked())
    os.kill(os.getpid(), signal.SIGINT)

sent = []
threading.Thread(target=interrupt).start()
try:
    {job}
    print("finished")
except KeyboardInterrupt:
    print(worked() - sent[0])
"""


@pytest.fixture
def unanswered() -> Callable[..., float]:
    """Return a function that measures how long a job in another process runs after Ctrl-C."""

    def seconds(before: str, job: str, delay: float) -> float:
        script = INTERRUPTED.format(
            worked=inspect.getsource(worked), before=textwrap.dedent(before), job=job, delay=delay
        )
        run = subprocess.run(
            [sys.executable, "-c", script], capture_output=True, text=True, timeout=120, check=False
        )
        assert run.returncode == 0, run.stderr
        return float(run.stdout)

    return seconds


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(0)


@pytest.fixture
def terrain_points() -> NDArray[np.float64]:
    """Scatter 400 points over a hilly square kilometer, in meters."""
    x, y = np.random.default_rng(1).uniform(0, 1000, (2, 400))
    z = 200 + 60 * np.sin(x / 170) * np.cos(y / 230) + 0.05 * x
    return np.column_stack([x, y, z])


@pytest.fixture(scope="session")
def result() -> neurbs.Reconstruction:
    """Reconstruct a small surface with large coordinates, as in surveys."""
    x, y = np.random.default_rng(2).uniform(0, 100, (2, 400))
    points = np.column_stack([x + 5e6, y + 7.5e6, 120 + 10 * np.sin(x / 17) * np.cos(y / 23)])
    return neurbs.reconstruct(points, grid=(9, 7))


@pytest.fixture(scope="session")
def disc() -> neurbs.Reconstruction:
    """Reconstruct a disc with a hole."""
    u, v = np.random.default_rng(3).uniform(-1, 1, (2, 3000))
    kept = (np.hypot(u, v) < 1) & (np.hypot(u - 0.3, v) > 0.35)
    x, y = 50 * u[kept], 50 * v[kept]
    return neurbs.reconstruct(np.column_stack([x, y, 0.002 * x * y]), grid=(6, 6))


@pytest.fixture
def square(rng: np.random.Generator) -> NDArray[np.float64]:
    """Make points over the unit square."""
    x, y = rng.random((2, 200))
    return np.column_stack([x, y, x * y])


@pytest.fixture
def points_file(tmp_path: Path, terrain_points: NDArray[np.float64]) -> Path:
    """Write `terrain_points` to a text file."""
    path = tmp_path / "points.xyz"
    np.savetxt(path, terrain_points, fmt="%.17g")
    return path


SurfaceMaker = Callable[[tuple[int, int], int], neurbs.NurbsSurface]


@pytest.fixture(scope="session")
def random_surface() -> SurfaceMaker:
    """Make surfaces of a degree, from a seed: inner knots repeated, weights from 0.1 to 10."""

    def make(degree: tuple[int, int], seed: int) -> neurbs.NurbsSurface:
        rng = np.random.default_rng([seed, *degree])

        def knots(degree: int) -> NDArray[np.float64]:
            places = np.sort(rng.choice(np.arange(1, 20), 4, replace=False)) / 20
            inner = np.repeat(places, [1, degree, *rng.integers(1, degree + 1, 2)])
            return np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])

        vectors = knots(degree[0]), knots(degree[1])
        shape = tuple(len(k) - p - 1 for k, p in zip(vectors, degree, strict=True))
        weights = 10 ** rng.uniform(-1, 1, shape)
        return neurbs.NurbsSurface(rng.uniform(-1, 1, (*shape, 3)), weights, degree, vectors)

    return make


class Outcome:
    """Exit code and output of a command that ran within this process."""

    def __init__(self, code: object, out: str, err: str) -> None:
        self.code, self.out, self.err = code, out, err

    def json(self) -> Any:
        """Return the one JSON document on stdout; NaN and infinities are not JSON."""

        def refuse(name: str) -> None:
            pytest.fail(f"{name} is not JSON")

        return json.loads(self.out, parse_constant=refuse)


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str]) -> Callable[..., Outcome]:
    """Return a function that runs a command line within this process, faster than a new one."""

    def run(*arguments: str | Path) -> Outcome:
        with pytest.raises(SystemExit) as leaving:
            cli.main(list(map(str, arguments)))
        return Outcome(leaving.value.code, *capsys.readouterr())

    return run


@pytest.fixture
def inner_point() -> Callable[[neurbs.Face], tuple[Any, Any]]:
    """Return a function for a point of a face close to its outer loop, and the normal there."""

    def inner_point(face: neurbs.Face) -> tuple[Any, Any]:
        curve = face.outer[0]
        middle = 0.5 * (curve.domain[0] + curve.domain[1])
        place, tangent = curve.derivatives([middle], 1)[0][:2]
        (u0, u1), (v0, v1) = face.surface.domain
        # The face is on the left.
        left = np.array([-tangent[1], tangent[0]])
        step = 1e-3 / np.linalg.norm(left / [u1 - u0, v1 - v0])
        at = (place[:2] + step * left)[None]
        normal = face.surface.normals(at)[0]
        return face.surface.evaluate(at)[0], -normal if face.is_reversed else normal

    return inner_point


@pytest.fixture
def refuse_cuts() -> Callable[[Path], None]:
    """Return a function that cuts a file of a shell, and asserts that each part is refused."""

    def refuse_cuts(path: Path) -> None:
        whole = path.read_bytes().rstrip()
        expected = neurbs.load_shell(path)
        # Each hundredth of the length, and a byte before the end.
        for share in [*np.linspace(0, 1, 100, endpoint=False), 1.0]:
            path.write_bytes(whole[: int(share * len(whole)) - (share == 1)])
            try:
                shell = neurbs.load_shell(path)
            except neurbs.NeurbsError:
                continue
            # Only the end of the last line is missing.
            assert share > 0.98
            assert shell == expected

    return refuse_cuts
