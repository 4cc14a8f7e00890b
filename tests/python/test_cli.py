"""The command line: exit codes, messages, files, the progress bar."""

import inspect
import json
import os
import re
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs
from neurbs import cli

COMMAND = [sys.executable, "-m", "neurbs"]
QUICK = ["--method", "paper", "--grid", "6", "5"]
ENDLESS = [
    "--method",
    "paper",
    "--grid",
    "50",
    "50",
    "--max-steps",
    str(10**12),
    "--min-change",
    "1e-300",
]
"""Options of a job that only Ctrl-C ends."""


def run(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """Run the command as users do."""
    command = [*COMMAND, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert "Traceback" not in done.stderr + done.stdout
    return done


class Outcome:
    """What the command did within this process, which is faster than `run`."""

    def __init__(self, capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> None:
        with pytest.raises(SystemExit) as exit:
            cli.main(list(map(str, arguments)))
        self.code = exit.value.code
        self.out, self.err = capsys.readouterr()


# What it does


def test_files_are_written_and_summed_up(points_file: Path, tmp_path: Path) -> None:
    files = [tmp_path / "a.step", tmp_path / "a.PLY", tmp_path / "a.png"]
    done = run("reconstruct", points_file, *(x for f in files for x in ("-o", f)), *QUICK)
    assert done.returncode == 0
    assert done.stderr == ""
    assert "400" in done.stdout
    assert "6 × 5" in done.stdout
    assert all(str(f) in done.stdout and f.stat().st_size > 1000 for f in files)


def test_the_same_as_in_python(
    points_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    result = neurbs.reconstruct(
        neurbs.read_points(points_file),
        method="paper",
        grid=(6, 5),
        degree=2,
        seed=3,
        max_steps=9000,
        reach=0.5,
        min_change=9.5,
    )
    result.save(tmp_path / "python.step")
    options = ["--method", "paper", "--grid", "6", "5", "--degree", "2", "--seed", "3"]
    options += ["--max-steps", "9000", "--reach", "0.5", "--min-change", "9.5"]
    target = tmp_path / "command.step"
    done = Outcome(capsys, "reconstruct", points_file, "--output", target, *options)
    assert done.code == 0
    assert entities(tmp_path / "command.step") == entities(tmp_path / "python.step")


def entities(path: Path) -> str:
    """Read the data of a STEP file without its header, which has names and times."""
    return path.read_text().partition("DATA;")[2]


def test_options_are_those_of_python() -> None:
    python = inspect.signature(neurbs.reconstruct).parameters.keys()
    command = inspect.signature(cli.reconstruct).parameters.keys()
    assert command - python == {"context", "output", "as_json", "quiet"}
    assert python - command == {"progress"}


def test_json_is_one_document(
    points_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "a.step"
    done = Outcome(capsys, "reconstruct", points_file, "-o", target, "--json", *QUICK)
    assert done.code == 0
    assert done.err == ""
    document = strict_json(done.out)
    assert document["input"] == str(points_file)
    assert document["files"] == [str(target)]
    assert document["report"]["points"] == 400
    assert document["report"]["grid"] == [6, 5]


def test_json_has_no_infinite_numbers(
    points_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done = Outcome(
        capsys,
        "reconstruct",
        points_file,
        "-o",
        tmp_path / "a.obj",
        "--json",
        *QUICK,
        "--max-steps",
        "1",
    )
    assert done.code == 0
    assert done.err.startswith("neurbs: warning: training ended after max_steps=1 steps")
    assert strict_json(done.out)["report"]["converged"] is False


def strict_json(text: str) -> Any:
    def refuse(name: str) -> None:
        pytest.fail(f"{name} is not JSON")

    return json.loads(text, parse_constant=refuse)


def test_quiet_is_silent(
    points_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done = Outcome(capsys, "reconstruct", points_file, "-o", tmp_path / "a.obj", "-q", *QUICK)
    assert (done.code, done.out, done.err) == (0, "", "")


def test_a_loss_of_digits_is_a_warning(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    x, y = np.random.default_rng(0).random((2, 200))
    np.save(tmp_path / "far.npy", np.column_stack([x + 5e6, y, x * y]))
    done = Outcome(
        capsys, "reconstruct", tmp_path / "far.npy", "-o", tmp_path / "a.stl", "-q", *QUICK
    )
    assert done.code == 0
    assert re.fullmatch(r"neurbs: warning: STL stores single precision.*\n", done.err)


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    done = Outcome(capsys, "--version")
    assert (done.code, done.out) == (0, f"neurbs {neurbs.__version__}\n")


@pytest.mark.parametrize("option", ["--help", "-h"])
def test_help_has_an_example_and_the_defaults(
    option: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    assert "reconstruct" in Outcome(capsys, option).out
    done = Outcome(capsys, "reconstruct", option)
    assert done.code == 0
    assert "neurbs reconstruct scan.xyz -o scan.step" in done.out
    assert "(default: 3)" in done.out
    for word in ("--max-steps", ".iges", ".csv", ".png"):
        assert word in done.out


# What it refuses


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("", "Missing command"),
        ("rebuild", "No such command 'rebuild'"),
        ("reconstruct", "Missing argument 'POINTS'"),
        ("reconstruct P", "Missing option '--output' / '-o'"),
        ("reconstruct P -o a.step --tolerance 1", "No such option: --tolerance"),
        ("reconstruct P -o a.step --grid 3", "Option '--grid' requires 2 arguments"),
        ("reconstruct P -o a.step --degree three", "'--degree': must be .*, got 'three'"),
        ("reconstruct P -o a.step --degree 2.5", "'--degree': must be .*, got 2.5"),
        ("reconstruct P -o a.step --reach far", "'--reach': must be a number, got 'far'"),
        ("reconstruct P -o a.step --grid a 8", r"'--grid': must be .*, got \('a', 8\)"),
        ("reconstruct P -o a.step --degree 0", "'--degree': must be .*, got 0"),
        ("reconstruct P -o a.step --grid 1 8", r"'--grid': must be .*, got \(1, 8\)"),
        ("reconstruct P -o a.step --seed -1", "'--seed': must be .*, got -1"),
        ("reconstruct P -o a.step --max-steps 0", "'--max-steps': must be .*, got 0"),
        ("reconstruct P -o a.step --reach -2", "'--reach': must be .*, got -2"),
        ("reconstruct P -o a.step --min-change nan", "'--min-change': must be .*, got NaN"),
        ("reconstruct P -o a.step --method magic", "'--method': must be 'paper', got 'magic'"),
        ("reconstruct P -o a.step -o a.dxf", r"'--output': a\.dxf: .*\.step .*, got the suffix"),
        ("reconstruct P -o a", "'--output': a: .* got no suffix"),
        ("reconstruct points.dwg -o a.step", "'POINTS': points.dwg: points must be in a file with"),
    ],
)
def test_a_wrong_command_line(
    words: str,
    message: str,
    points_file: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(points_file.parent)
    Path("points.dwg").touch()
    arguments = words.replace("P", points_file.name, 1).split() if " P" in words else words.split()
    done = Outcome(capsys, *arguments)
    assert done.code == 2
    assert done.out == ""
    assert re.fullmatch(rf"neurbs: error: .*{message}.* \(see 'neurbs.* --help'\)\n", done.err)
    assert {path.name for path in Path().iterdir()} == {points_file.name, "points.dwg"}


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "must hold at least one point"),
        (b"1 2 3\n4 abc 6\n", "line 2, column 2 must be a finite number, got 'abc'"),
        (b"1 2 3\n4 5 nan\n", "line 2, column 3 must be a finite number, got 'nan'"),
        (b"1\n2\n", "must have columns x, y and z"),
        (b"1 1 1\n" * 9, "all 9 are"),
        (b"0 0 0\n1 1 1\n2 2 2\n3 3 3\n", "all 4 lie on one line"),
        (b"0 0 0\n1 0 0\n0 1 0\n", "at least 4 distinct points"),
    ],
)
def test_bad_points(
    content: bytes, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "p.xyz"
    path.write_bytes(content)
    done = Outcome(capsys, "reconstruct", path, "-o", tmp_path / "a.step", "--json")
    assert done.code == 1
    assert re.fullmatch(rf"neurbs: error: .*{message}.*\n", done.err)
    error = strict_json(done.out)["error"]
    assert error["type"] == "NeurbsError"
    assert done.err == f"neurbs: error: {error['message']}\n"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("points", "output", "kind", "message"),
    [
        ("missing.xyz", "a.step", "FileNotFoundError", "missing.xyz: No such file or directory"),
        (".", "a.step", "IsADirectoryError", ".: points are read from a file, not a folder"),
        ("points.xyz", "no/a.step", "FileNotFoundError", "no: there is no such folder"),
        ("points.xyz", ".", "IsADirectoryError", ".: a result is a file, but this is a folder"),
        ("points.xyz", "points.xyz/a.obj", "NotADirectoryError", "this is not a folder"),
        # The target is checked before the points are read.
        ("missing.xyz", "no/a.step", "FileNotFoundError", "no: there is no such folder"),
    ],
)
@pytest.mark.usefixtures("points_file")
def test_files_that_are_not_there(
    points: str,
    output: str,
    kind: str,
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    done = Outcome(capsys, "reconstruct", points, "-o", output, "--json")
    assert done.code == 1
    assert message in done.err
    assert "Errno" not in done.err
    assert done.err.count("\n") == 1
    assert strict_json(done.out)["error"]["type"] == kind


def test_a_wrong_command_line_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    done = Outcome(capsys, "reconstruct", "--json", "--tolerance", "1")
    assert done.code == 2
    assert strict_json(done.out)["error"]["type"] == "UsageError"


def test_points_are_not_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "p.obj"
    path.write_text("v 1 2 3\n")
    done = Outcome(capsys, "reconstruct", path, "-o", path)
    assert done.code == 2
    assert "the points must not be overwritten" in done.err
    assert path.read_text() == "v 1 2 3\n"


def test_faults_of_its_own_are_one_message_too(
    points_file: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise ZeroDivisionError("no reason")

    monkeypatch.setattr(neurbs, "reconstruct", fail)
    done = Outcome(capsys, "reconstruct", points_file, "-o", tmp_path / "a.step")
    assert done.code == 1
    assert re.fullmatch(r"neurbs: error: ZeroDivisionError: no reason \(.*\)\n", done.err)


# How it behaves among other programs


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
    """Run the command with a terminal for stderr: its exit code, stdout, and what is drawn."""
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
    with suppress(OSError):  # So Linux says that the other side has closed.
        while chunk := os.read(ours, 65536):
            seen += chunk
            if interrupt and b"reached" in seen:
                process.send_signal(signal.SIGINT)
                interrupt = False
    os.close(ours)
    out, _ = process.communicate(timeout=60)
    assert b"Traceback" not in seen
    return process.returncode, out, seen.decode()


@posix
def test_a_terminal_has_a_bar(points_file: Path, tmp_path: Path) -> None:
    words = [
        "--method",
        "paper",
        "--grid",
        "60",
        "60",
        "--max-steps",
        "100000",
        "--min-change",
        "1e-300",
    ]
    code, out, err = on_terminal("reconstruct", points_file, "-o", tmp_path / "a.obj", *words)
    assert code == 0
    assert "60 × 60" in out
    assert re.search(r"training .* [\d,]+/100,000 moves [\d.e-]+, \d+/400 reached .*0:00:0\d", err)
    assert "neurbs: warning: training ended after max_steps=100000 steps" in err


@posix
def test_a_terminal_may_be_left_alone(points_file: Path, tmp_path: Path) -> None:
    target = tmp_path / "a.obj"
    done = on_terminal("reconstruct", points_file, "-o", target, "--quiet", *QUICK)
    assert done == (0, "", "")


@posix
def test_ctrl_c_ends_it(points_file: Path, tmp_path: Path) -> None:
    words = ["reconstruct", str(points_file), "-o", str(tmp_path / "a.step"), "--json", *ENDLESS]
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
    tmp_path: Path, terrain_points: NDArray[np.float64], capsys: pytest.CaptureFixture[str]
) -> None:
    np.savetxt(tmp_path / "p.csv", terrain_points, delimiter=",", header="x,y,z", comments="")
    np.save(tmp_path / "p.npy", terrain_points)
    for name in ("p.csv", "p.npy"):
        target = tmp_path / f"{name}.ply"
        assert Outcome(capsys, "reconstruct", tmp_path / name, "-o", target, *QUICK).code == 0
    assert (tmp_path / "p.csv.ply").read_bytes() == (tmp_path / "p.npy.ply").read_bytes()
