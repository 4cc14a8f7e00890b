"""Reading in a process of its own: whatever a library does to it, there is an error, in time.

A library that misbehaves stands in for Rhino's.
"""

import importlib
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import laspy
import numpy as np
import pytest

import neurbs
from neurbs.io import isolation, worker

pytestmark = pytest.mark.skipif(os.name == "nt", reason="the limits are those of POSIX")

LIBRARY = """
import os, signal, time

class File3dm:
    @staticmethod
    def Read(path):
        {deed}
"""


@pytest.fixture
def damaged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a file whose library does what `misbehave` says."""
    monkeypatch.syspath_prepend(tmp_path)
    isolation._end_all()
    path = tmp_path / "a.3dm"
    path.write_bytes(b"3D")
    return path


def misbehave(folder: Path, deed: str) -> None:
    (folder / "rhino3dm.py").write_text(LIBRARY.format(deed=deed))
    importlib.invalidate_caches()


@pytest.mark.parametrize(
    ("deed", "message"),
    [
        ("os.kill(os.getpid(), signal.SIGSEGV)", "its reader ended with status -11"),
        ("os._exit(0)", "its reader ended with status 0"),
        ("time.sleep(1000)", "its reader did not come to an end"),
        ("for _ in iter(int, 1): pass", "its reader did not come to an end"),
        ("bytearray(3 << 30)", "to read it takes more than 1073 MB"),
        ("raise KeyError('chunk')", "must be a whole .3dm file, but is damaged: 'chunk'"),
        ("raise OSError(22, 'Invalid argument')", "must be a whole .3dm file, but is damaged"),
        ("raise type('PanicException', (BaseException,), {})('index')", "is damaged: index"),
        ("print('noise', flush=True)\n        os.write(2, b'noise')", "damaged or cut short"),
    ],
)
def test_what_a_library_does_is_an_error_of_neurbs(
    deed: str, message: str, damaged: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    misbehave(damaged.parent, deed)
    start = time.monotonic()
    with pytest.raises(neurbs.NeurbsError) as caught:
        neurbs.load_surfaces(damaged)
    assert time.monotonic() - start < 10
    assert str(caught.value).startswith(f"{damaged}: ")
    assert message in str(caught.value)
    assert capfd.readouterr() == ("", "")


def test_the_timer_runs_even_if_its_signal_is_ignored(damaged: Path) -> None:
    misbehave(damaged.parent, "time.sleep(1000)")
    before = signal.signal(signal.SIGALRM, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGALRM})
    try:
        with pytest.raises(neurbs.NeurbsError, match="did not come to an end"):
            neurbs.load_surfaces(damaged)
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGALRM})
        signal.signal(signal.SIGALRM, before)


def test_ctrl_c_ends_the_reading(damaged: Path) -> None:
    misbehave(damaged.parent, "time.sleep(1000)")
    timer = threading.Timer(2, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        neurbs.load_surfaces(damaged)
    assert 1.5 < time.monotonic() - start < 2.5


def test_the_timer_stops_while_the_caller_works(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Points in chunks, more of them than a pipe has room for, taken slowly."""
    points = np.arange(3.0 * 400_000).reshape(-1, 3)
    header = laspy.LasHeader(point_format=0, version="1.2")
    header.scales = np.full(3, 0.5)
    data = laspy.LasData(header)
    data.x, data.y, data.z = points.T
    path = tmp_path / "a.las"
    data.write(path)
    monkeypatch.syspath_prepend(tmp_path)
    # In the worker the timer runs so fast that it ends within a second.
    (tmp_path / "sitecustomize.py").write_text(
        "import signal\ntimer = signal.setitimer\n"
        "signal.setitimer = lambda which, s: (500 * timer(which, s / 500)[0], 0)\n"
    )
    isolation._end_all()
    found = []
    for chunk in neurbs.read_points(path, chunks=100_000):
        time.sleep(1)
        found.append(chunk)
    np.testing.assert_array_equal(np.concatenate(found), points)


def test_a_large_file_has_more_time() -> None:
    # A hundred megabytes take less than an hour and a half of wall time, and more than a minute.
    assert 60 < worker.WALL_SECONDS + 1e8 / worker.BYTES_PER_WALL_SECOND < 5400
    assert worker.BYTES_PER_WALL_SECOND <= worker.BYTES_PER_SECOND


def test_the_next_file_is_read_after_each_of_these(damaged: Path, tmp_path: Path) -> None:
    misbehave(damaged.parent, "os._exit(1)")
    surface = neurbs.NurbsSurface(np.random.default_rng(0).random((4, 4, 3)))
    neurbs.save(surface, tmp_path / "a.step")
    for _ in range(3):
        with pytest.raises(neurbs.NeurbsError):
            neurbs.load_surfaces(damaged)
        assert neurbs.load_surface(tmp_path / "a.step").degree == surface.degree


HEAD = b'<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian">'

POLY = (
    '<PolyData><Piece NumberOfPoints="{0}" NumberOfPolys="{1}"><Points>'
    '<DataArray type="Float32" NumberOfComponents="{2}" format="ascii">1 2 3</DataArray>'
    "</Points></Piece></PolyData></VTKFile>"
)


@pytest.mark.parametrize("count", [10**9, 10**18, 2**63])
@pytest.mark.parametrize("place", range(3))
def test_counts_of_a_vtk_file_are_bounded_by_its_size(
    place: int, count: int, tmp_path: Path
) -> None:
    counts = [1, 0, 3]
    counts[place] = count
    path = tmp_path / "a.vtp"
    path.write_bytes(HEAD + POLY.format(*counts).encode())
    with pytest.raises(neurbs.NeurbsError, match=f"must have {count} points or cells"):
        neurbs.read_points(path)


@pytest.mark.parametrize("suffix", [".vtp", ".vtu"])
def test_deep_xml_is_an_error(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"a{suffix}"
    path.write_bytes(HEAD + b"<a>" * 1_000_000 + b"</a>" * 1_000_000 + b"</VTKFile>")
    with pytest.raises(neurbs.NeurbsError, match="is damaged"):
        neurbs.read_points(path)


def scan(path: Path) -> bytearray:
    header = laspy.LasHeader(point_format=0, version="1.2")
    header.scales = np.full(3, 0.001)
    data = laspy.LasData(header)
    data.x, data.y, data.z = np.random.default_rng(0).random((3, 9))
    data.write(path)
    return bytearray(path.read_bytes())


def test_counts_of_a_scan_are_bounded(tmp_path: Path) -> None:
    for suffix in (".las", ".laz"):
        path = tmp_path / f"a{suffix}"
        content = scan(path)
        content[107:111] = (10**9).to_bytes(4, "little")
        path.write_bytes(content)
        start = time.monotonic()
        with pytest.raises(neurbs.NeurbsError):
            neurbs.read_points(path)
        assert time.monotonic() - start < 5


def test_a_compressed_scan_with_any_wrong_number_ends_nothing(tmp_path: Path) -> None:
    """Some of these numbers ask for much memory, or end the process of the reader."""
    path = tmp_path / "a.laz"
    content = scan(path)
    refused = 0
    for place in range(0, len(content) - 4, 5):
        path.write_bytes(content[:place] + b"\xff\xff\xff\x7f" + content[place + 4 :])
        try:
            neurbs.read_points(path)
        except neurbs.NeurbsError:
            refused += 1
    assert refused > 10


@pytest.mark.parametrize("suffix", [".step", ".igs", ".3dm", ".vtp", ".tif"])
def test_a_path_that_is_not_unicode_is_not_called_damaged(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / os.fsdecode(b"a\xff" + suffix.encode())
    try:
        path.touch()
    except OSError:
        pytest.skip("this file system has Unicode names only")
    surface = neurbs.NurbsSurface(np.random.default_rng(0).random((4, 4, 3)))
    if suffix != ".tif":
        neurbs.save(surface.tessellate() if suffix == ".vtp" else surface, path)
    read: Callable[[Path], object] = neurbs.read_points
    if suffix in neurbs.io.LOADABLE:
        read = neurbs.load_surface
    with pytest.raises(neurbs.NeurbsError, match=r"must have a path in UTF-8, .* rename it"):
        read(path)


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_an_idle_reader_ends_with_its_parent(tmp_path: Path) -> None:
    surface = neurbs.NurbsSurface(np.random.default_rng(0).random((4, 4, 3)))
    neurbs.save(surface, tmp_path / "a.step")
    code = (
        "import os, signal, sys, neurbs\nneurbs.load_surface(sys.argv[1])\n"
        "from neurbs.io import isolation\nprint(isolation._idle[0]._process.pid, flush=True)\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "a.step")], capture_output=True, timeout=60
    )
    left = Path("/proc", done.stdout.decode().strip())
    end = time.monotonic() + 10
    while left.exists() and time.monotonic() < end:
        time.sleep(0.05)
    assert not left.exists()
