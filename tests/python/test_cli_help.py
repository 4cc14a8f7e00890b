"""The help at 80 columns, the completion of values, and options of one number for two."""

import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import typer

from neurbs.cli import app, options
from neurbs.cli.help import GROUPS

Command = Callable[..., Any]
COMMANDS = [each.callback.__name__.replace("_", "-") for each in app.registered_commands]  # type: ignore[union-attr]


@pytest.mark.parametrize("name", COMMANDS)
def test_the_help_fits_80_columns(
    name: str, command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    shown = command(name, "--help").out
    assert max(map(len, shown.splitlines())) <= 80
    # No word is cut, also not at a hyphen.
    words = " ".join(shown.split())
    made: Any = typer.main.get_command(app)
    for parameter in made.commands[name].params:
        assert " ".join(parameter.help.split()) in words, parameter.name
        assert all(option in words for option in parameter.opts if option.startswith("-"))


def test_the_list_of_commands_has_whole_sentences(
    command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    _, _, commands = command("--help").out.partition("Commands:\n")
    lines = commands.splitlines()
    assert len(lines) == len(COMMANDS)
    assert all(line.endswith(".") and not line.endswith("...") for line in lines), lines


def test_options_of_one_kind_are_together(
    command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    shown = command("reconstruct", "--help").out
    groups = re.findall(r"^(\w+):\n((?:  .*\n)+)", shown, re.M)
    titles = [title for title, _ in groups if title in GROUPS]
    assert titles == [group for group in GROUPS if group in titles]
    words = {title: re.findall(r"--[a-z-]+(?=[ \n])", text) for title, text in groups}
    for title, some in {
        "Files": {"--output", "--suffix", "--columns", "--nan", "--unit"},
        "Surface": {"--tolerance", "--kind", "--grid", "--degree"},
        "Fit": {"--clean", "--robust", "--fairness", "--seed"},
        "General": {"--config", "--json", "--quiet", "--help"},
    }.items():
        assert some <= set(words[title]), title


# Completion


def completed(*words: str) -> list[str]:
    """Return what the shell offers for the last word."""
    environment = {
        **os.environ,
        "_NEURBS_COMPLETE": "complete_bash",
        "COMP_WORDS": " ".join(["neurbs", *words]),
        "COMP_CWORD": str(len(words)),
    }
    run = subprocess.run(
        [sys.executable, "-m", "neurbs"],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert run.stderr == ""
    return run.stdout.split()


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        (["reconstruct", "--kind", "t"], ["tube", "torus"]),
        (["reconstruct", "--unit", "m"], ["mm", "m"]),
        (["reconstruct", "--suffix", "ht"], ["html"]),
        (["reconstruct", "a.xyz", "--nan", "d"], ["drop"]),
        (["reconstruct", "a.xyz", "-o", "out/part.st"], ["step", "stp", "stl"]),
        (["tessellate", "a.step", "-o", "part.g"], ["glb"]),
        (["convert", "a.step", "part.3"], ["3dm"]),
        (["convert", "a.step", "--from-unit", "i"], ["in"]),
        (["train", "--topology", "s"], ["sheet"]),
        (["view", "--color", "z"], ["zebra"]),
        (["compare", "a.step", "b.ply", "-o", "d.c"], ["csv"]),
        # Names without a suffix are completed by the shell, as files.
        (["convert", "a.step", "part"], []),
    ],
)
def test_values_are_completed(words: list[str], offered: list[str]) -> None:
    stem, dot, _ = words[-1].rpartition(".")
    assert completed(*words) == [f"{stem}{dot}{word}" for word in offered]


# One number for two


def test_one_number_stands_for_a_pair(points_file: Path, tmp_path: Path, command: Command) -> None:
    target, config = tmp_path / "a.json", tmp_path / "settings.toml"
    config.write_text("[reconstruct]\ngrid = 7\naspect = 'fixed'\n")
    fixed = ["--aspect", "fixed", "--json"]
    for words in (
        ["reconstruct", "--grid", "7", points_file, "-o", target, *fixed],
        ["reconstruct", points_file, "-o", target, "--grid", "7", *fixed],
        ["reconstruct", points_file, "-o", target, "--grid=7", *fixed],
        ["reconstruct", points_file, "-o", target, *fixed, "--grid", "7", "7"],
        ["reconstruct", points_file, "-o", target, "--config", config, "--json"],
    ):
        done = command(*words)
        assert (done.code, done.json()["report"]["grid"]) == (0, [7, 7]), words
    done = command("tessellate", target, "-o", tmp_path / "a.obj", "--shape", "5", "--json")
    assert done.json()["vertices"] == 25


def test_options_of_other_widths_stay() -> None:
    class Option:
        def __init__(self, nargs: int, *opts: str) -> None:
            self.nargs, self.opts = nargs, opts

    parameters = [Option(2, "--grid"), Option(3, "--axis-scale"), Option(1, "--seed")]
    for words, expected in {
        "--seed 3 a.xyz": "--seed 3 a.xyz",
        "--axis-scale 1 2 3 --seed 4": "--axis-scale 1 2 3 --seed 4",
        "--grid 3 a.xyz": "--grid 3 3 a.xyz",
        "--grid 3 4 a.xyz": "--grid 3 4 a.xyz",
        "--grid": "--grid",
        "--grid a 4": "--grid a 4",
        # The function says what is wrong with it.
        "--grid a --seed 4": "--grid a a --seed 4",
    }.items():
        assert options.with_pairs(parameters, words.split()) == expected.split()
