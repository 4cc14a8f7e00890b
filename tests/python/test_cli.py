"""The command line: exit codes, messages, files, the progress bar."""

import inspect
import json
import os
import re
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs
from neurbs import cli

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
COMMON = {"context", "output", "config", "as_json", "quiet"}
"""Options that most commands have."""


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
    result = neurbs.reconstruct_paper(
        neurbs.read_points(points_file),
        grid=(6, 5),
        degree=2,
        seed=3,
        max_steps=9000,
        reach=0.5,
        min_change=9.5,
    )
    result.save(tmp_path / "python.step")
    options = ["--grid", "6", "5", "--degree", "2", "--seed", "3"]
    options += ["--max-steps", "9000", "--reach", "0.5", "--min-change", "9.5"]
    target = tmp_path / "command.step"
    done = Outcome(capsys, "reconstruct-paper", points_file, "--output", target, *options)
    assert done.code == 0
    assert entities(tmp_path / "command.step") == entities(tmp_path / "python.step")


def entities(path: Path) -> str:
    """Read the data of a STEP file without its header, which has names and times."""
    return path.read_text().partition("DATA;")[2]


def test_options_are_those_of_python() -> None:
    rows: list[tuple[Any, Any, set[str], set[str]]] = [
        (
            cli.reconstruct,
            neurbs.reconstruct,
            {"points", "suffix", "unit", "columns", "nan", "strict"},
            {"points", "progress", "weights"},
        ),
        (
            cli.reconstruct_paper,
            neurbs.reconstruct_paper,
            {"points", "suffix", "unit", "columns", "nan", "strict"},
            {"points", "progress"},
        ),
        (cli.train, neurbs.SelfOrganizingMap, {"points", "paper", "columns", "nan"}, set()),
        (cli.tessellate, neurbs.NurbsSurface.tessellate, {"surface", "unit"}, {"self", "progress"}),
    ]
    for command, function, own, left_out in rows:
        python = inspect.signature(function).parameters.keys()
        words = inspect.signature(command).parameters.keys()
        assert words - python | own == own | COMMON
        assert python - words <= left_out


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
        "reconstruct-paper",
        points_file,
        "-o",
        tmp_path / "a.obj",
        "--json",
        "--max-steps",
        "1",
    )
    assert done.code == 0
    assert done.err.startswith("neurbs: warning: Training ended after 1 steps")
    assert strict_json(done.out)["report"]["converged"] is False


def test_strict_tells_a_missed_tolerance_by_its_exit_code(
    points_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "a.step"
    words: list[str | Path]
    words = ["reconstruct", points_file, "-o", target, "--json", "--tolerance", "1e-6"]
    words += ["--max-control-points", "50"]
    assert Outcome(capsys, *words).code == 0
    target.unlink()
    done = Outcome(capsys, *words, "--strict")
    assert done.code == 4
    assert done.err.startswith("neurbs: warning: Tolerance 1.000e-6 not reached")
    assert target.exists()
    report = strict_json(done.out)["report"]
    assert (report["converged"], report["valid"]) == (False, True)
    (missed,) = report["diagnostics"]
    assert missed["code"] == "tolerance-missed"
    assert missed["data"]["cause"] == "max_control_points"
    assert Outcome(capsys, "reconstruct", points_file, "-o", target, "--strict", *QUICK).code == 0


def test_components_have_files_of_their_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], rng: np.random.Generator
) -> None:
    x, y = rng.random((2, 500))
    points = np.column_stack([x, y + 3 * (x > 0.7), 0.1 * x * y])
    np.savetxt(tmp_path / "two.xyz", points)
    words = ["-o", str(tmp_path / "a.step"), "--component", "each", "--json", *QUICK]
    done = Outcome(capsys, "reconstruct", tmp_path / "two.xyz", *words)
    assert done.code == 0
    files = [result["files"] for result in strict_json(done.out)["results"]]
    assert files == [[str(tmp_path / "a-1.step")], [str(tmp_path / "a-2.step")]]


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
    for word in ("--max-control-points", "--strict", "N|each", "X Y Z", ".iges", ".csv", ".png"):
        assert word in done.out


# What it refuses


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("", "Missing command"),
        ("rebuild", "No such command 'rebuild'"),
        ("reconstruct", "Missing argument 'POINTS'"),
        ("reconstruct P", "Missing option '--output' / '-o'"),
        ("reconstruct P -o a.step --speed 1", "No such option: --speed"),
        ("reconstruct P -o a.step --tolerance 0", "'--tolerance': must be .*, got 0"),
        ("reconstruct P -o a.step --grid 3", "Option '--grid' requires 2 arguments"),
        ("reconstruct P -o a.step --degree three", "'--degree': must be .*, got 'three'"),
        ("reconstruct P -o a.step --degree 2.5", "'--degree': must be .*, got 2.5"),
        ("reconstruct-paper P -o a.step --reach far", "'--reach': must be a number, got 'far'"),
        ("reconstruct P -o a.step --grid a 8", r"'--grid': must be .*, got \('a', 8\)"),
        ("reconstruct P -o a.step --degree 0", "'--degree': must be .*, got 0"),
        ("reconstruct P -o a.step --grid 1 8", r"'--grid': must be .*, got \(1, 8\)"),
        ("reconstruct P -o a.step --seed -1", "'--seed': must be .*, got -1"),
        ("reconstruct-paper P -o a.obj --max-steps 0", "'--max-steps': must be .*, got 0"),
        ("reconstruct-paper P -o a.obj --reach -2", "'--reach': must be .*, got -2"),
        ("reconstruct-paper P -o a.obj --min-change nan", "'--min-change': .*, got NaN"),
        (
            "reconstruct P -o a.step --kind body",
            "'--kind': must be .* not supported yet., got 'body'",
        ),
        ("reconstruct P -o a.step --component all", "'--component': must be a number or 'each'"),
        ("reconstruct P -o a.step --axis-scale 1 0 1", "'--axis-scale': must be positive"),
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
    done = Outcome(capsys, "reconstruct", "--json", "--speed", "1")
    assert done.code == 2
    assert strict_json(done.out)["error"]["type"] == "UsageError"


def test_points_are_not_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "p.obj"
    path.write_text("v 1 2 3\n")
    done = Outcome(capsys, "reconstruct", path, "-o", path)
    assert done.code == 2
    assert "the input must not be overwritten" in done.err
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
def test_a_terminal_may_be_left_alone(points_file: Path, tmp_path: Path) -> None:
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
    tmp_path: Path, terrain_points: NDArray[np.float64], capsys: pytest.CaptureFixture[str]
) -> None:
    np.savetxt(tmp_path / "p.csv", terrain_points, delimiter=",", header="x,y,z", comments="")
    np.save(tmp_path / "p.npy", terrain_points)
    for name in ("p.csv", "p.npy"):
        target = tmp_path / f"{name}.ply"
        assert Outcome(capsys, "reconstruct", tmp_path / name, "-o", target, *QUICK).code == 0
    assert (tmp_path / "p.csv.ply").read_bytes() == (tmp_path / "p.npy.ply").read_bytes()


# Many files at once


@pytest.fixture
def scans(tmp_path: Path, terrain_points: NDArray[np.float64]) -> Path:
    """Write a folder of two scans and a file that is none, and a folder for their surfaces."""
    folder = tmp_path / "scans"
    folder.mkdir()
    for name in ("a", "c"):
        np.savetxt(folder / f"{name}.xyz", terrain_points)
    (folder / "b.xyz").write_text("1 2 three\n")
    (tmp_path / "out").mkdir()
    return folder


def test_one_that_fails_does_not_stop_the_others(
    scans: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = sorted(scans.iterdir())
    out = tmp_path / "out"
    done = Outcome(capsys, "reconstruct", *files, "-o", out, "--json", *QUICK)
    assert done.code == 1
    first, second, third = strict_json(done.out)["results"]
    assert first["files"] == [str(out / "a.step")]
    assert third["files"] == [str(out / "c.step")]
    assert second["error"]["type"] == "NeurbsError"
    assert done.err.count("b.xyz") == 1
    assert done.err.endswith("neurbs: 1 of 3 files failed\n")
    assert {path.name for path in out.iterdir()} == {"a.step", "c.step"}


def test_patterns_are_expanded_and_suffixes_chosen(
    scans: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (scans / "b.xyz").unlink()
    out = tmp_path / "out"
    words = ["--suffix", ".ply", "--suffix", "json", *QUICK]
    done = Outcome(capsys, "reconstruct", scans / "*.xyz", "-o", out, *words)
    assert done.code == 0
    assert done.out.count("written") == 2
    assert {path.name for path in out.iterdir()} == {"a.json", "a.ply", "c.json", "c.ply"}


@pytest.mark.parametrize(
    ("output", "code", "message"),
    [("a.step", 2, "must be a folder"), ("nowhere", 1, "there is no such folder")],
)
def test_many_files_need_a_folder(
    output: str, code: int, message: str, scans: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done = Outcome(capsys, "reconstruct", *scans.iterdir(), "-o", scans / output, *QUICK)
    assert done.code == code
    assert message in done.err


@pytest.mark.parametrize("ending", ["/", os.sep])
def test_one_file_may_go_into_a_folder(
    ending: str, points_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "made"
    words: list[str | Path] = ["reconstruct", points_file, "-o", f"{folder}{ending}", *QUICK]
    done = Outcome(capsys, *words)
    assert done.code == 1
    assert "there is no such folder" in done.err
    folder.mkdir()
    assert Outcome(capsys, *words).code == 0
    assert [file.name for file in folder.iterdir()] == [f"{points_file.stem}.step"]


# Points


def test_columns_are_chosen_and_points_dropped(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rng = np.random.default_rng(5)
    x, y = rng.random((2, 300))
    rows = [f"p{i};{x[i]};{x[i] * y[i]};{y[i]}" for i in range(300)]
    table = tmp_path / "table.csv"
    table.write_text("\n".join(["name;east;up;north", *rows, "last;1;nan;1", ""]))
    surface = tmp_path / "a.json"
    chosen = ["--columns", "east,north,up", "--nan", "drop"]
    numbers = ["--columns", "1, 3, 2", "--nan", "drop"]
    commands: list[list[str | Path]] = [
        ["reconstruct", table, "-o", surface],
        ["train", table, "-o", tmp_path / "a.npz", "--rows", "5", "--cols", "5"],
        ["compare", surface, table, "--tolerance", "0.01"],
        ["info", table],
        ["convert", table, tmp_path / "a.ply"],
        ["view", table, "-o", tmp_path / "a.png"],
    ]
    for words in commands:
        for reading in (chosen, numbers):
            done = Outcome(capsys, *words, *reading)
            assert done.code == 0, done.err
            assert done.err.count("1 of 301 points are not finite and were dropped") == 1
    points = neurbs.read_points(tmp_path / "a.ply")
    np.testing.assert_allclose(points, np.column_stack([x, y, x * y]))


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["--nan", "keep"], 2, "'--nan': must be 'error' or 'drop', got 'keep'"),
        (["--columns", "x"], 2, "'--columns': must be two or three names or numbers"),
        (["--columns", "x,y,depth"], 1, "depth"),
    ],
)
def test_wrong_columns(
    words: list[str],
    code: int,
    message: str,
    points_file: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    done = Outcome(capsys, "info", points_file, *words)
    assert done.code == code
    assert message in done.err


def test_the_unit_of_the_points_is_that_of_the_surface(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    x, y = np.random.default_rng(6).random((2, 200))
    table = tmp_path / "table.csv"
    rows = "\n".join(f"{a},{b},{a * b}" for a, b in zip(x, y, strict=True))
    table.write_text(f"x [m],y [m],z [m]\n{rows}\n")
    surface = tmp_path / "a.step"
    assert Outcome(capsys, "reconstruct", table, "-o", surface, *QUICK).code == 0
    assert "SI_UNIT($,.METRE.)" in surface.read_text()
    assert Outcome(capsys, "reconstruct", table, "-o", surface, "--unit", "mm", *QUICK).code == 0
    assert "SI_UNIT(.MILLI.,.METRE.)" in surface.read_text()
    done = Outcome(capsys, "reconstruct", table, "-o", surface, "--unit", "furlong", *QUICK)
    assert done.code == 2
    assert "'--unit': must be 'mm'" in done.err


# Settings in a file


def test_a_file_has_the_options(
    points_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "a.step"
    config = tmp_path / "settings.toml"
    config.write_text(
        f"[reconstruct-paper]\noutput = ['{target}']\ngrid = [6, 5]\nmax-steps = 9000\n"
        "min_change = 9.5\njson = true\n[train]\nrows = 3\n"
    )
    done = Outcome(capsys, "reconstruct-paper", points_file, "--config", config, "--degree", "2")
    assert done.code == 0
    document = strict_json(done.out)
    assert document["files"] == [str(target)]
    assert document["report"]["grid"] == [6, 5]
    assert document["report"]["degree"] == [2, 2]


def test_the_command_line_goes_before_the_file(
    points_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = tmp_path / "settings.toml"
    config.write_text("[reconstruct]\ngrid = [9, 9]\njson = true\n")
    target = tmp_path / "a.step"
    done = Outcome(capsys, "reconstruct", points_file, "-o", target, "--config", config, *QUICK)
    assert strict_json(done.out)["report"]["grid"] == [6, 5]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("[reconstruct]\ngird = [3, 3]\n", "a setting must be one of .*grid.*, got 'gird'"),
        ("[reconstruct]\ngrid = 2026-01-01\n", "grid must be a text, a number"),
        ("reconstruct = 3\n", r"\[reconstruct\] must be a table, got 3"),
        ("[reconstruct\n", "must be a file of TOML, but: "),
        ("[reconstruct]\ngrid = [1, 8]\n", "'--grid': must be .*, got .1, 8."),
        ("[reconstruct]\nseed = 'x'\n", "'--seed': must be .*, got 'x'"),
    ],
)
def test_wrong_settings(
    content: str,
    message: str,
    points_file: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    config = tmp_path / "settings.toml"
    config.write_text(content)
    done = Outcome(
        capsys, "reconstruct", points_file, "-o", tmp_path / "a.step", "--config", config
    )
    assert done.code == 2
    assert re.search(message, done.err)
    assert not (tmp_path / "a.step").exists()


def test_settings_that_are_not_there(points_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    done = Outcome(capsys, "reconstruct", points_file, "-o", "a.step", "--config", "no.toml")
    assert done.code == 1
    assert done.err == "neurbs: error: no.toml: No such file or directory\n"


# The other commands


def test_a_map_is_trained(
    points_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target, picture = tmp_path / "map.npz", tmp_path / "map.png"
    words: list[str | Path] = ["-o", target, "-o", picture, "--rows", "6", "--cols", "5", "--json"]
    done = Outcome(capsys, "train", points_file, *words)
    assert done.code == 0
    measures = strict_json(done.out)["map"]
    assert measures["nodes"] == 30
    som = neurbs.SelfOrganizingMap.load(target)
    assert som.codebook_.shape == (6, 5, 3)
    points = neurbs.read_points(points_file)
    np.testing.assert_array_equal(
        som.codebook_, neurbs.SelfOrganizingMap(6, 5).fit(points).codebook_
    )
    assert measures["quantization_error"] == som.quantization_error(points)
    assert picture.read_bytes().startswith(b"\x89PNG")
    done = Outcome(capsys, "info", target)
    assert "6, 5" in done.out


def test_a_map_by_the_paper_with_a_schedule(
    points_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "map.npz"
    words = ["--paper", "--rows", "5", "--cols", "4", "--radius", "gaussian,3,100", "--seed", "4"]
    assert Outcome(capsys, "train", points_file, "-o", target, "-q", *words).code == 0
    som = neurbs.SelfOrganizingMap.load(target)
    assert (som.training, som.radius, som.seed) == ("online", ("gaussian", 3, 100), 4)


def test_a_film_on_the_command_line(
    points_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    film = tmp_path / "a.gif"
    words: list[str | Path] = ["-o", film, "--rows", "4", "--cols", "4", "-q"]
    assert Outcome(capsys, "train", points_file, *words).code == 0
    assert film.read_bytes().startswith(b"GIF89a")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["-o", "a.step"], "'--output': a.step: a map is written as .npz .*, got the suffix"),
        (["-o", "a.gif", "-o", "a.mp4"], "there must be at most one film, got 2"),
        (["-o", "a.npz", "--rows", "1"], "--rows|rows"),
        (["-o", "a.npz", "--init", "magic"], "'--init': must be .*, got 'magic'"),
    ],
)
def test_a_wrong_training(
    words: list[str],
    message: str,
    points_file: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(points_file.parent)
    done = Outcome(capsys, "train", points_file, *words)
    assert done.code in (1, 2)
    assert re.search(message, done.err)
    assert [path.name for path in Path().iterdir()] == [points_file.name]


@pytest.fixture
def surface_file(tmp_path: Path, terrain_points: NDArray[np.float64]) -> Path:
    """Write a surface over `terrain_points`."""
    path = tmp_path / "surface.json"
    neurbs.reconstruct(terrain_points, grid=(8, 8)).save(path)
    return path


def test_a_surface_is_tessellated(
    surface_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mesh = tmp_path / "mesh.obj"
    done = Outcome(capsys, "tessellate", surface_file, "-o", mesh, "--shape", "4", "6", "--json")
    assert done.code == 0
    assert strict_json(done.out)["triangles"] == 2 * 3 * 5
    assert mesh.read_text().count("\nf ") == 30


def test_a_wrong_tessellation(
    surface_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done = Outcome(
        capsys, "tessellate", surface_file, "-o", tmp_path / "a.obj", "--shape", "1", "x"
    )
    assert done.code == 2
    assert "'--shape': must be " in done.err


def test_surfaces_and_points_are_converted(
    surface_file: Path, points_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "surface.step"
    assert Outcome(capsys, "convert", surface_file, target).code == 0
    assert target.read_text().startswith("ISO-10303-21;")
    assert Outcome(capsys, "convert", points_file, tmp_path / "points.ply", "-q").code == 0
    np.testing.assert_array_equal(
        neurbs.read_points(tmp_path / "points.ply"), neurbs.read_points(points_file)
    )
    done = Outcome(capsys, "convert", points_file, tmp_path / "points.step")
    assert done.code == 1
    assert "this file holds a surface, which a PointCloud has not" in done.err


def test_points_are_compared(
    surface_file: Path, points_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "deviations.ply"
    done = Outcome(capsys, "compare", surface_file, points_file, "-o", target, "--json")
    assert done.code == 0
    measures = strict_json(done.out)["deviation"]
    surface, points = neurbs.load_surface(surface_file), neurbs.read_points(points_file)
    distances = surface.closest_points(points).distances
    assert measures["rms"] == pytest.approx(np.sqrt(np.mean(distances**2)), rel=1e-12)
    assert measures["max"] == pytest.approx(distances.max(), rel=1e-12)
    assert measures["percentiles"]["95"] == pytest.approx(np.percentile(distances, 95), rel=1e-12)
    assert b"distance" in target.read_bytes()[:1000]


def test_the_gate_closes(
    surface_file: Path, points_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words: list[str | Path] = ["compare", surface_file, points_file, "--tolerance"]
    median = np.median(
        neurbs.load_surface(surface_file).closest_points(neurbs.read_points(points_file)).distances
    )
    assert Outcome(capsys, *words, "1e6").code == 0
    failed = Outcome(capsys, *words, str(median))
    assert failed.code == 3
    assert "50.000 % within, failed" in failed.out
    assert Outcome(capsys, *words, str(median), "--share", "0.4", "-q").code == 0
    assert "'--tolerance': must be a number that is positive" in Outcome(capsys, *words, "0").err
    assert Outcome(capsys, *words, "1", "--share", "2").code == 2


def test_info_says_what_a_file_holds(
    surface_file: Path, points_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    of_surface = strict_json(Outcome(capsys, "info", surface_file, "--json").out)
    assert of_surface["kind"] == "surface"
    assert of_surface["net"] == [8, 8]
    of_points = strict_json(Outcome(capsys, "info", points_file, "--json").out)
    assert (of_points["kind"], of_points["points"]) == ("points", 400)
    assert "400" in Outcome(capsys, "info", points_file).out
    assert "missing.step: No such file" in Outcome(capsys, "info", "missing.step").err


def test_a_view_is_written(
    surface_file: Path, points_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words: list[str | Path] = [
        "--points",
        points_file,
        "--color",
        "deviation",
        "--unit",
        "m",
        "--control-net",
    ]
    pictures = [tmp_path / "surface.png", tmp_path / "points.png"]
    done = Outcome(capsys, "view", surface_file, "-o", pictures[0], *words)
    assert done.code == 0
    assert Outcome(capsys, "view", points_file, "-o", pictures[1]).code == 0
    assert all(picture.read_bytes().startswith(b"\x89PNG") for picture in pictures)
    done = Outcome(capsys, "view", surface_file, "-o", pictures[0], "--color", "red")
    assert done.code == 2
    assert "'--color': must be one of height" in done.err


def test_a_window_needs_a_screen(
    surface_file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    done = Outcome(capsys, "view", surface_file)
    assert done.code == 1
    assert "write a picture with -o" in done.err


def test_each_command_has_an_example(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    for command in ("reconstruct", "train", "tessellate", "compare", "info", "convert", "view"):
        text = " ".join(Outcome(capsys, command, "--help").out.split())
        assert re.search(rf"Examples?: neurbs {command} ", text)


def test_the_report_is_written(
    points_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("plotly", reason="plotly is not installed")
    page = tmp_path / "report.html"
    done = Outcome(capsys, "reconstruct", points_file, "-o", page, "--unit", "m", *QUICK)
    assert done.code == 0
    text = page.read_text(encoding="utf-8")
    options = "--grid 6 5 --aspect fixed"
    assert f"neurbs reconstruct {points_file} -o out.step {options}" in text


# Ctrl-C while it starts


@posix
@pytest.mark.parametrize("seen", ["numpy", "typer", "neurbs.cli"])
def test_ctrl_c_while_libraries_are_loaded(seen: str) -> None:
    # Python tells each module that it has loaded: so the test knows that it is in the midst.
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
        # Before that it is Python alone, which answers in its own way.
        wait_for_the_program(process)
        time.sleep(tenth / 20)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
        assert (process.returncode, err) == (130, "interrupted\n")


def wait_for_the_program(process: subprocess.Popen[str]) -> None:
    """Wait until the process handles SIGINT in Python code of ours, as Linux tells."""
    status = Path(f"/proc/{process.pid}/maps")
    if not status.exists():
        time.sleep(0.2)
        return
    while "_multiarray_umath" not in status.read_text() and process.poll() is None:
        time.sleep(0.002)
