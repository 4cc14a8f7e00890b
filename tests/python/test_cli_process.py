"""The command line as a process: streams, terminals and Ctrl-C."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

COMMAND = [sys.executable, "-m", "neurbs"]
QUICK = ["--grid", "6", "5", "--aspect", "fixed"]
ENDLESS = [
    "--grid",
    "50",
    "50",
    "--max-steps",
    str(10**12),
    "--min-change",
    "1e-300",
]
"""Options of a job that only Ctrl-C ends."""
Command = Callable[..., Any]


def run(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """Run the command in a process."""
    command = [*COMMAND, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert "Traceback" not in done.stderr + done.stdout
    return done


def test_files_are_written_and_summed_up(points_file: Path, tmp_path: Path) -> None:
    files = [tmp_path / "a.step", tmp_path / "a.PLY", tmp_path / "a.png"]
    done = run("reconstruct", points_file, *(x for f in files for x in ("-o", f)), *QUICK)
    assert done.returncode == 0
    assert done.stderr == ""
    assert "400" in done.stdout
    assert "6 × 5" in done.stdout
    assert all(str(f) in done.stdout and f.stat().st_size > 1000 for f in files)


def test_options_and_help_do_not_need_docstrings(points_file: Path, tmp_path: Path) -> None:
    environment = os.environ | {"PYTHONOPTIMIZE": "2", "COLUMNS": "120"}

    def optimized(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
        command = [*COMMAND, *map(str, arguments)]
        return subprocess.run(
            command, env=environment, capture_output=True, text=True, check=False, timeout=60
        )

    shown = optimized("reconstruct", "--help").stdout
    for word in ("Fit a surface", "neurbs reconstruct scan.xyz", "--fairness", "--no-clean"):
        assert word in shown
    target = tmp_path / "a.step"
    done = optimized("reconstruct", points_file, "-o", target, "--degree", "2", "--json", *QUICK)
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout)["report"]["degree"] == [2, 2]
    assert target.exists()


def test_bad_input_through_the_shell(tmp_path: Path) -> None:
    done = run("reconstruct", tmp_path / "missing.xyz", "-o", tmp_path / "a.step")
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr == f"neurbs: error: {tmp_path}/missing.xyz: No such file or directory\n"
    assert run("--grid").returncode == 2


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")
def test_an_output_that_is_full(points_file: Path, tmp_path: Path) -> None:
    command = [*COMMAND, "reconstruct", str(points_file), "-o", str(tmp_path / "a.obj"), *QUICK]
    with open("/dev/full", "w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr == "neurbs: error: No space left on device\n"


posix = pytest.mark.skipif(os.name == "nt", reason="there are no pseudo terminals")


def on_terminal(*arguments: str | Path, interrupt: bool = False) -> tuple[int, str, str]:
    """Run the command with a terminal as stderr; return exit code, stdout and stderr."""
    import pty

    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        [*COMMAND, *map(str, arguments)],
        stderr=theirs,
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | {"COLUMNS": "100", "TERM": "xterm"},
    )
    os.close(theirs)
    seen = b""
    with suppress(OSError):  # Linux raises this when the other side has closed.
        while chunk := os.read(ours, 65536):
            seen += chunk
            if interrupt and b"error" in seen:
                process.send_signal(signal.SIGINT)
                interrupt = False
    os.close(ours)
    out, _ = process.communicate(timeout=60)
    assert b"Traceback" not in seen
    return process.returncode, out, seen.decode()


@posix
def test_a_terminal_has_a_bar(points_file: Path, tmp_path: Path) -> None:
    words = [
        "--grid",
        "60",
        "60",
        "--max-steps",
        "100000",
        "--min-change",
        "1e-300",
    ]
    code, out, err = on_terminal("reconstruct-paper", points_file, "-o", tmp_path / "a.obj", *words)
    assert code == 0
    assert "60 × 60" in out
    plain = re.sub(r"\x1b\[[\d;?]*[a-zA-Z]", "", err)
    assert re.search(r" \d+% training, error [\d.]+ .*0:00:0\d of ", plain), plain
    assert "neurbs: warning: Training ended after 100000 steps" in err


@posix
def test_quiet_draws_no_bar(points_file: Path, tmp_path: Path) -> None:
    target = tmp_path / "a.obj"
    done = on_terminal("reconstruct", points_file, "-o", target, "--quiet", *QUICK)
    assert done == (0, "", "")


@posix
def test_ctrl_c_ends_it(points_file: Path, tmp_path: Path) -> None:
    words = [
        "reconstruct-paper",
        str(points_file),
        "-o",
        str(tmp_path / "a.step"),
        "--json",
        *ENDLESS,
    ]
    code, out, err = on_terminal(*words, interrupt=True)
    assert code == 130
    assert json.loads(out)["error"] == {"type": "KeyboardInterrupt", "message": "interrupted"}
    assert err.endswith("interrupted\r\n")
    assert "\x1b[?25h" in err  # The cursor is back.
    assert list(tmp_path.iterdir()) == [points_file]


def test_completion_is_offered() -> None:
    environment = os.environ | {"_NEURBS_COMPLETE": "source_bash"}
    done = subprocess.run(
        COMMAND, env=environment, capture_output=True, text=True, check=False, timeout=60
    )
    assert "complete" in done.stdout
    assert "neurbs" in done.stdout


def test_points_come_in_every_format(
    tmp_path: Path, terrain_points: NDArray[np.float64], command: Command
) -> None:
    np.savetxt(tmp_path / "p.csv", terrain_points, delimiter=",", header="x,y,z", comments="")
    np.save(tmp_path / "p.npy", terrain_points)
    for name in ("p.csv", "p.npy"):
        target = tmp_path / f"{name}.ply"
        assert command("reconstruct", tmp_path / name, "-o", target, *QUICK).code == 0
    assert (tmp_path / "p.csv.ply").read_bytes() == (tmp_path / "p.npy.ply").read_bytes()


@posix
@pytest.mark.parametrize("seen", ["numpy", "typer", "neurbs.cli"])
def test_ctrl_c_while_libraries_are_loaded(seen: str) -> None:
    # Python prints each module after its import, so the test can interrupt in between.
    command = [sys.executable, "-X", "importtime", "-m", "neurbs", "--help"]
    process = subprocess.Popen(
        command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
    )
    assert process.stderr is not None
    lines = []
    for line in process.stderr:
        lines.append(line)
        if f" {seen}" in line:
            process.send_signal(signal.SIGINT)
            break
    _, rest = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Traceback" not in "".join(lines) + rest
    assert "interrupted" in rest


@posix
def test_ctrl_c_at_any_moment_of_the_start(points_file: Path, tmp_path: Path) -> None:
    words = ["reconstruct-paper", str(points_file), "-o", str(tmp_path / "a.step"), *ENDLESS]
    for tenth in range(1, 8):
        process = subprocess.Popen([*COMMAND, *words], stderr=subprocess.PIPE, text=True)
        # Before that, Python itself handles Ctrl-C.
        wait_for_the_program(process)
        time.sleep(tenth / 20)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
        assert (process.returncode, err) == (130, "interrupted\n")


def wait_for_the_program(process: subprocess.Popen[str]) -> None:
    """Wait until the process has loaded NumPy and handles SIGINT itself."""
    status = Path(f"/proc/{process.pid}/maps")
    if not status.exists():
        time.sleep(0.2)
        return
    while "_multiarray_umath" not in status.read_text() and process.poll() is None:
        time.sleep(0.002)
