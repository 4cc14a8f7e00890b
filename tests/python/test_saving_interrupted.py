"""Saving that is killed, has no room, must not write, or happens twice at once."""

import inspect
import os
import random
import re
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path
from typing import IO, TypeAlias

import numpy as np
import pytest

import neurbs
from neurbs.io.atomic_write import atomic_write

pytestmark = pytest.mark.skipif(os.name == "nt", reason="signals and limits are those of POSIX")

TEMPORARY = re.compile(r"\.neurbs-.*\.tmp")
"""Names of files that are not finished."""

Thing: TypeAlias = neurbs.NurbsSurface | neurbs.TriangleMesh


def thing(height: float, path: str) -> Thing:
    """Return a surface, or where the file holds a mesh that, of some 100 kB in any format."""
    x, y = np.meshgrid(np.arange(60.0), np.arange(60.0), indexing="ij")
    surface = neurbs.NurbsSurface(np.stack([x, y, height + np.sin(x * y)], axis=-1))
    is_mesh = path.endswith((".ply", ".glb", ".stl", ".vtp", ".off"))
    return surface.tessellate(shape=(60, 60)) if is_mesh else surface


COMMON = f"""
import os, resource, signal, sys
from typing import TypeAlias
import numpy as np
import neurbs

Thing: TypeAlias = object
{inspect.getsource(thing)}
"""


def child(code: str, *arguments: str) -> subprocess.Popen[str]:
    """Start a process that runs code after `COMMON`."""
    return subprocess.Popen(
        [sys.executable, "-W", "ignore", "-c", COMMON + textwrap.dedent(code), *arguments],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def ended(process: subprocess.Popen[str]) -> str:
    """Wait for a process; return what it printed."""
    try:
        out, err = process.communicate(timeout=120)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        pytest.fail("no end within 120 s")
    assert process.returncode == 0, err
    return out.strip()


def answer(stream: IO[str] | None) -> str:
    """Read a line of a child."""
    assert stream is not None
    return stream.readline().strip()


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


# Killed


@pytest.mark.parametrize("suffix", [".step", ".json", ".ply"])
def test_a_killed_save_leaves_the_old_file_or_the_new_one(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    whole = set()
    for height in (1, 2):
        neurbs.save(thing(height, suffix), path)
        whole.add(path.read_bytes())
    rng = random.Random(0)
    kills = 17  # 51 with the three formats.
    for _ in range(kills):
        process = child(
            """
            things = [thing(height, sys.argv[1]) for height in (1, 2)]
            for number in range(100_000):
                if number == 2:
                    print("running", flush=True)
                neurbs.save(things[number % 2], sys.argv[1])
            """,
            str(path),
        )
        assert answer(process.stdout) == "running"
        time.sleep(rng.uniform(0, 0.05))
        process.send_signal(signal.SIGKILL)
        process.communicate()
        assert path.read_bytes() in whole
        left = [name for name in names(tmp_path) if name != path.name]
        assert len(left) <= 1, "earlier kills have left files behind"
        assert all(map(TEMPORARY.fullmatch, left))
    neurbs.save(thing(1, suffix), path)
    assert names(tmp_path) == [path.name]


def test_a_save_removes_what_killed_saves_have_left(tmp_path: Path) -> None:
    """The next save to the folder does so, even under another name; other files stay."""
    other = tmp_path / ".neurbs-notes.txt"
    other.write_text("mine")
    for _ in range(3):
        process = child(
            """
            from pathlib import Path
            from neurbs.io.atomic_write import atomic_write
            with atomic_write(Path(sys.argv[1])) as new:
                Path(new).write_text("half")
                print("running", flush=True)
                os.kill(os.getpid(), signal.SIGKILL)
            """,
            str(tmp_path / "a.step"),
        )
        assert answer(process.stdout) == "running"
        process.communicate()
    assert not (tmp_path / "a.step").exists()
    assert len(names(tmp_path)) >= 2
    neurbs.save(thing(1, ".json"), tmp_path / "b.json")
    assert names(tmp_path) == [other.name, "b.json"]


def test_a_save_leaves_the_temporary_file_of_a_running_process(tmp_path: Path) -> None:
    process = child(
        """
        from pathlib import Path
        from neurbs.io.atomic_write import atomic_write
        with atomic_write(Path(sys.argv[1])) as new:
            Path(new).write_text("all of it")
            print("running", flush=True)
            sys.stdin.readline()
        """,
        str(tmp_path / "a.step"),
    )
    assert answer(process.stdout) == "running"
    neurbs.save(thing(1, ".json"), tmp_path / "b.json")
    assert len(names(tmp_path)) == 2
    ended(process)
    assert (tmp_path / "a.step").read_text() == "all of it"
    assert names(tmp_path) == ["a.step", "b.json"]


def test_a_save_leaves_the_temporary_files_of_other_hosts(tmp_path: Path) -> None:
    with atomic_write(tmp_path / "a.txt") as new:
        mine = Path(new).name
        Path(new).write_text("whole")
    end = subprocess.Popen([sys.executable, "-c", ""])
    end.wait()
    other = [mine.replace(str(os.getpid()), str(end.pid)).replace("-", "-x", 1)]
    other.append(mine.replace(".tmp", ".tmp2").replace(str(os.getpid()), str(end.pid)))
    for name in other:
        (tmp_path / name).write_text("half")
    gone = tmp_path / mine.replace(str(os.getpid()), str(end.pid))
    gone.write_text("half")
    neurbs.save(thing(1, ".json"), tmp_path / "b.json")
    assert not gone.exists()
    assert names(tmp_path) == sorted(["a.txt", "b.json", *other])


# No room, no permission

EVERY = [".step", ".igs", ".3dm", ".json", ".obj", ".ply", ".glb", ".stl", ".vtp", ".off"]


@pytest.mark.parametrize("suffix", EVERY)
@pytest.mark.parametrize("exists", [False, True])
def test_a_full_disk_is_an_error_and_leaves_nothing(
    tmp_path: Path, suffix: str, exists: bool
) -> None:
    path = tmp_path / f"a{suffix}"
    if exists:
        path.write_text("before")
    process = child(
        """
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        result = thing(1, sys.argv[1])
        for limit in (0, 1, 3000, 20_000):
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
            try:
                neurbs.save(result, sys.argv[1])
                print("saved", end=" ")
            except OSError as error:
                print(error.filename == sys.argv[1], end=" ")
        """,
        str(path),
    )
    assert ended(process) == "True True True True"
    assert names(tmp_path) == ([path.name] if exists else [])
    if exists:
        assert path.read_text() == "before"


@pytest.mark.parametrize("suffix", EVERY)
def test_a_folder_that_is_read_only_is_an_error(tmp_path: Path, suffix: str) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    path = folder / f"a{suffix}"
    path.write_text("before")
    path.chmod(0o666)
    folder.chmod(0o555)
    # A user that is not root must reach the folder, which pytest keeps to its owner.
    modes = {each: each.stat().st_mode for each in (tmp_path, *tmp_path.parents[:2])}
    try:
        if os.geteuid() == 0:
            for each, mode in modes.items():
                each.chmod(mode | 0o055)
        process = child(
            """
            result = thing(1, sys.argv[1])
            # Imported while everything may be read.
            import neurbs.io, rhino3dm
            if os.geteuid() == 0:
                os.setgroups([])
                os.setgid(65534)
                os.setuid(65534)
            for path in (sys.argv[1], os.path.join(os.path.dirname(sys.argv[1]), "b.step")):
                try:
                    neurbs.save(result, path)
                    print("saved", end=" ")
                except PermissionError as error:
                    print(error.filename is not None, end=" ")
            """,
            str(path),
        )
        assert ended(process) == "True True"
    finally:
        for each, mode in modes.items():
            each.chmod(mode)
        folder.chmod(0o755)
    assert path.read_text() == "before"
    assert names(folder) == [path.name]


# Twice at once


@pytest.mark.parametrize("suffix", [".step", ".json"])
def test_two_processes_save_the_same_file_at_once(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    whole = set()
    for height in (1, 2):
        neurbs.save(thing(height, suffix), path)
        whole.add(path.read_bytes())
    path.unlink()
    code = """
        result = thing(int(sys.argv[2]), sys.argv[1])
        print("ready", flush=True)
        for line in sys.stdin:
            neurbs.save(result, sys.argv[1])
            print("saved", flush=True)
    """
    children = [child(code, str(path), height) for height in ("1", "2")]
    for process in children:
        assert answer(process.stdout) == "ready"
    for _ in range(100):  # 200 rounds with both formats.
        for process in children:
            assert process.stdin is not None
            process.stdin.write("go\n")
            process.stdin.flush()
        assert [answer(process.stdout) for process in children] == ["saved", "saved"]
        assert path.read_bytes() in whole
        assert names(tmp_path) == [path.name]
    for process in children:
        ended(process)
