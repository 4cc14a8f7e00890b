"""The command line: results, exit codes and messages of `reconstruct`."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import neurbs

QUICK = ["--grid", "6", "5", "--aspect", "fixed"]
Command = Callable[..., Any]


def test_the_same_as_in_python(points_file: Path, tmp_path: Path, command: Command) -> None:
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
    done = command("reconstruct-paper", points_file, "--output", target, *options)
    assert done.code == 0
    assert entities(tmp_path / "command.step") == entities(tmp_path / "python.step")


def entities(path: Path) -> str:
    """Read the data of a STEP file without its header, which has names and times."""
    return path.read_text().partition("DATA;")[2]


def test_json_is_one_document(points_file: Path, tmp_path: Path, command: Command) -> None:
    target = tmp_path / "a.step"
    done = command("reconstruct", points_file, "-o", target, "--json", *QUICK)
    assert done.code == 0
    assert done.err == ""
    document = done.json()
    assert document["input"] == str(points_file)
    assert document["files"] == [str(target)]
    assert document["report"]["points"] == 400
    assert document["report"]["grid"] == [6, 5]


def test_json_has_no_infinite_numbers(points_file: Path, tmp_path: Path, command: Command) -> None:
    done = command(
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
    assert done.json()["report"]["converged"] is False


def test_strict_exits_with_4_for_a_missed_tolerance(
    points_file: Path, tmp_path: Path, command: Command
) -> None:
    target = tmp_path / "a.step"
    words: list[str | Path]
    words = ["reconstruct", points_file, "-o", target, "--json", "--tolerance", "1e-6"]
    words += ["--max-control-points", "50"]
    assert command(*words).code == 0
    target.unlink()
    done = command(*words, "--strict")
    assert done.code == 4
    assert done.err.startswith("neurbs: warning: Tolerance 1e-6 not reached")
    assert target.exists()
    report = done.json()["report"]
    assert (report["converged"], report["valid"]) == (False, True)
    (missed,) = report["diagnostics"]
    assert missed["code"] == "tolerance-missed"
    assert missed["data"]["cause"] == "max_control_points"
    assert command("reconstruct", points_file, "-o", target, "--strict", *QUICK).code == 0


def test_components_have_files_of_their_own(
    tmp_path: Path, command: Command, rng: np.random.Generator
) -> None:
    x, y = rng.random((2, 500))
    points = np.column_stack([x, y + 3 * (x > 0.7), 0.1 * x * y])
    np.savetxt(tmp_path / "two.xyz", points)
    words = ["-o", str(tmp_path / "a.step"), "--component", "each", "--json", *QUICK]
    done = command("reconstruct", tmp_path / "two.xyz", *words)
    assert done.code == 0
    files = [result["files"] for result in done.json()["results"]]
    assert files == [[str(tmp_path / "a-1.step")], [str(tmp_path / "a-2.step")]]


def test_quiet_is_silent(points_file: Path, tmp_path: Path, command: Command) -> None:
    done = command("reconstruct", points_file, "-o", tmp_path / "a.obj", "-q", *QUICK)
    assert (done.code, done.out, done.err) == (0, "", "")


def test_a_loss_of_digits_is_a_warning(tmp_path: Path, command: Command) -> None:
    x, y = np.random.default_rng(0).random((2, 200))
    np.save(tmp_path / "far.npy", np.column_stack([x + 5e6, y, x * y]))
    done = command("reconstruct", tmp_path / "far.npy", "-o", tmp_path / "a.stl", "-q", *QUICK)
    assert done.code == 0
    assert re.fullmatch(r"neurbs: warning: STL stores single precision.*\n", done.err)


def test_version(command: Command) -> None:
    done = command("--version")
    assert (done.code, done.out) == (0, f"neurbs {neurbs.__version__}\n")


@pytest.mark.parametrize("option", ["--help", "-h"])
def test_help_has_an_example_and_the_defaults(
    option: str, command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    assert "reconstruct" in command(option).out
    done = command("reconstruct", option)
    assert done.code == 0
    assert "neurbs reconstruct scan.xyz -o scan.step" in done.out
    assert "(default: 40000)" in done.out
    for word in ("--max-control-points", "--strict", "N|each", "X Y Z", ".iges", ".csv", ".png"):
        assert word in done.out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("", "Missing command"),
        ("rebuild", "No such command 'rebuild'"),
        ("reconstruct", "Missing argument 'POINTS'"),
        ("reconstruct P", "Missing option '--output' / '-o'"),
        ("reconstruct P -o a.step --speed 1", "No such option: --speed"),
        ("reconstruct P -o a.step --tolerance 0", "'--tolerance': must be .*, got 0"),
        ("reconstruct P -o a.step --grid", "Option '--grid' requires 2 arguments"),
        ("reconstruct P -o a.step --axis-scale 3", "Option '--axis-scale' requires 3 arguments"),
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
    command: Command,
) -> None:
    monkeypatch.chdir(points_file.parent)
    Path("points.dwg").touch()
    arguments = words.replace("P", points_file.name, 1).split() if " P" in words else words.split()
    done = command(*arguments)
    assert done.code == 2
    assert done.out == ""
    assert re.fullmatch(rf"neurbs: error: .*{message}.* \(see 'neurbs.* --help'\)\n", done.err)
    assert {path.name for path in Path().iterdir()} == {points_file.name, "points.dwg"}


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "must have at least one point"),
        (b"1 2 3\n4 abc 6\n", "line 2, column 2 must be a finite number, got 'abc'"),
        (b"1 2 3\n4 5 nan\n", "line 2, column 3 must be a finite number, got 'nan'"),
        (b"1\n2\n", "must have columns x, y and z"),
        (b"1 1 1\n" * 9, "all 9 are"),
        (b"0 0 0\n1 1 1\n2 2 2\n3 3 3\n", "all 4 lie on one line"),
        (b"0 0 0\n1 0 0\n0 1 0\n", "at least 4 distinct points"),
    ],
)
def test_bad_points(content: bytes, message: str, tmp_path: Path, command: Command) -> None:
    path = tmp_path / "p.xyz"
    path.write_bytes(content)
    done = command("reconstruct", path, "-o", tmp_path / "a.step", "--json")
    assert done.code == 1
    assert re.fullmatch(rf"neurbs: error: .*{message}.*\n", done.err)
    error = done.json()["error"]
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
    command: Command,
) -> None:
    monkeypatch.chdir(tmp_path)
    done = command("reconstruct", points, "-o", output, "--json")
    assert done.code == 1
    assert message in done.err
    assert "Errno" not in done.err
    assert done.err.count("\n") == 1
    assert done.json()["error"]["type"] == kind


def test_a_wrong_command_line_as_json(command: Command) -> None:
    done = command("reconstruct", "--json", "--speed", "1")
    assert done.code == 2
    assert done.json()["error"]["type"] == "UsageError"


def test_points_are_not_overwritten(tmp_path: Path, command: Command) -> None:
    path = tmp_path / "p.obj"
    path.write_text("v 1 2 3\n")
    done = command("reconstruct", path, "-o", path)
    assert done.code == 2
    assert "the input must not be overwritten" in done.err
    assert path.read_text() == "v 1 2 3\n"


def test_an_internal_error_is_one_message(
    points_file: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    command: Command,
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise ZeroDivisionError("no reason")

    monkeypatch.setattr(neurbs, "reconstruct", fail)
    done = command("reconstruct", points_file, "-o", tmp_path / "a.step")
    assert done.code == 1
    assert re.fullmatch(r"neurbs: error: ZeroDivisionError: no reason \(.*\)\n", done.err)
