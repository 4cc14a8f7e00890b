"""The files of the command line: many at once, tables, settings."""

import gzip
import os
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs

QUICK = ["--grid", "6", "5", "--aspect", "fixed"]
Command = Callable[..., Any]


@pytest.fixture
def scans(tmp_path: Path, terrain_points: NDArray[np.float64]) -> Path:
    """Write a folder of two scans and a damaged file, and a folder for surfaces."""
    folder = tmp_path / "scans"
    folder.mkdir()
    for name in ("a", "c"):
        np.savetxt(folder / f"{name}.xyz", terrain_points)
    (folder / "b.xyz").write_text("1 2 three\n")
    (tmp_path / "out").mkdir()
    return folder


def test_a_failed_file_does_not_stop_the_others(
    scans: Path, tmp_path: Path, command: Command
) -> None:
    files = sorted(scans.iterdir())
    out = tmp_path / "out"
    done = command("reconstruct", *files, "-o", out, "--json", *QUICK)
    assert done.code == 1
    first, second, third = done.json()["results"]
    assert first["files"] == [str(out / "a.step")]
    assert third["files"] == [str(out / "c.step")]
    assert second["error"]["type"] == "NeurbsError"
    assert done.err.count("b.xyz") == 1
    assert done.err.endswith("neurbs: 1 of 3 files failed\n")
    assert {path.name for path in out.iterdir()} == {"a.step", "c.step"}


def test_patterns_are_expanded_and_suffixes_chosen(
    scans: Path, tmp_path: Path, command: Command
) -> None:
    (scans / "b.xyz").unlink()
    out = tmp_path / "out"
    words = ["--suffix", ".ply", "--suffix", "json", *QUICK]
    done = command("reconstruct", scans / "*.xyz", "-o", out, *words)
    assert done.code == 0
    assert done.out.count("written") == 2
    assert {path.name for path in out.iterdir()} == {"a.json", "a.ply", "c.json", "c.ply"}


@pytest.mark.parametrize(
    ("output", "code", "message"),
    [("a.step", 2, "must be a folder"), ("nowhere", 1, "there is no such folder")],
)
def test_many_files_need_a_folder(
    output: str, code: int, message: str, scans: Path, command: Command
) -> None:
    done = command("reconstruct", *scans.iterdir(), "-o", scans / output, *QUICK)
    assert done.code == code
    assert message in done.err


@pytest.mark.parametrize("ending", ["/", os.sep])
def test_one_file_may_go_into_a_folder(
    ending: str, points_file: Path, tmp_path: Path, command: Command
) -> None:
    folder = tmp_path / "made"
    words: list[str | Path] = ["reconstruct", points_file, "-o", f"{folder}{ending}", *QUICK]
    done = command(*words)
    assert done.code == 1
    assert "there is no such folder" in done.err
    folder.mkdir()
    assert command(*words).code == 0
    assert [file.name for file in folder.iterdir()] == [f"{points_file.stem}.step"]


def test_results_of_a_folder_have_names_without_suffixes(
    points_file: Path, tmp_path: Path, command: Command
) -> None:
    packed, pts = tmp_path / "a.xyz.gz", tmp_path / "b.v2.pts"
    packed.write_bytes(gzip.compress(points_file.read_bytes()))
    shutil.copy(points_file, pts)
    folder = tmp_path / "made"
    folder.mkdir()
    assert command("reconstruct", packed, pts, "-o", folder, *QUICK).code == 0
    assert {file.name for file in folder.iterdir()} == {"a.step", "b.v2.step"}
    names = ("A.XYZ.GZ", "a.copc.laz", "a.gz", "a", "-")
    assert [neurbs.io.stem_of(name) for name in names] == ["A", "a", "a", "a", "standard-input"]


def test_columns_are_chosen_and_points_dropped(tmp_path: Path, command: Command) -> None:
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
            done = command(*words, *reading)
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
    command: Command,
) -> None:
    done = command("info", points_file, *words)
    assert done.code == code
    assert message in done.err


def test_the_unit_of_the_points_is_that_of_the_surface(tmp_path: Path, command: Command) -> None:
    x, y = np.random.default_rng(6).random((2, 200))
    table = tmp_path / "table.csv"
    rows = "\n".join(f"{a},{b},{a * b}" for a, b in zip(x, y, strict=True))
    table.write_text(f"x [m],y [m],z [m]\n{rows}\n")
    surface = tmp_path / "a.step"
    assert command("reconstruct", table, "-o", surface, *QUICK).code == 0
    assert "SI_UNIT($,.METRE.)" in surface.read_text()
    assert command("reconstruct", table, "-o", surface, "--unit", "mm", *QUICK).code == 0
    assert "SI_UNIT(.MILLI.,.METRE.)" in surface.read_text()
    done = command("reconstruct", table, "-o", surface, "--unit", "furlong", *QUICK)
    assert done.code == 2
    assert "'--unit': must be 'mm'" in done.err


def test_options_are_read_from_a_file(points_file: Path, tmp_path: Path, command: Command) -> None:
    target = tmp_path / "a.step"
    config = tmp_path / "settings.toml"
    config.write_text(
        f"[reconstruct-paper]\noutput = ['{target}']\ngrid = [6, 5]\nmax-steps = 9000\n"
        "min_change = 9.5\njson = true\n[train]\nrows = 3\n"
    )
    done = command("reconstruct-paper", points_file, "--config", config, "--degree", "2")
    assert done.code == 0
    document = done.json()
    assert document["files"] == [str(target)]
    assert document["report"]["grid"] == [6, 5]
    assert document["report"]["degree"] == [2, 2]


def test_the_command_line_overrides_the_file(
    points_file: Path, tmp_path: Path, command: Command
) -> None:
    config = tmp_path / "settings.toml"
    config.write_text("[reconstruct]\ngrid = [9, 9]\njson = true\n")
    target = tmp_path / "a.step"
    done = command("reconstruct", points_file, "-o", target, "--config", config, *QUICK)
    assert done.json()["report"]["grid"] == [6, 5]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("[reconstruct]\ngird = [3, 3]\n", "unknown setting 'gird': did you mean 'grid'"),
        ("[reconstruct]\ngrid = 2026-01-01\n", "grid must be a string, a number"),
        ("reconstruct = 3\n", r"\[reconstruct\] must be a table, got 3"),
        ("[reconstuct]\ngrid = 3\n", "unknown table 'reconstuct': did you mean 'reconstruct'"),
        ("grid = 3\n", r"must be in a table of a command, as \[reconstruct\], got 'grid'"),
        ("[reconstruct]\nxyzzy = 3\n", "unknown setting 'xyzzy': it must be one of .*, tolerance"),
        ("[train]\nrow = 3\n", r"\[train\] has an unknown setting 'row': did you mean 'rows'"),
        ("[train]\ngrid = 3\n", r"\[train\] has an unknown setting 'grid'"),
        ("train = 3\n", r"\[train\] must be a table, got 3"),
        ("[reconstruct\n", "must be a TOML file, but: "),
        ("[reconstruct]\ngrid = [1, 8]\n", "'--grid': must be .*, got .1, 8."),
        ("[reconstruct]\nseed = 'x'\n", "'--seed': must be .*, got 'x'"),
    ],
)
def test_wrong_settings(
    content: str,
    message: str,
    points_file: Path,
    tmp_path: Path,
    command: Command,
) -> None:
    config = tmp_path / "settings.toml"
    config.write_text(content)
    done = command("reconstruct", points_file, "-o", tmp_path / "a.step", "--config", config)
    assert done.code == 2
    assert re.search(message, done.err)
    assert not (tmp_path / "a.step").exists()


def test_a_missing_settings_file(points_file: Path, command: Command) -> None:
    done = command("reconstruct", points_file, "-o", "a.step", "--config", "no.toml")
    assert done.code == 1
    assert done.err == "neurbs: error: no.toml: No such file or directory\n"
