"""Options of the command line: one for each argument, named in errors and warnings."""

import inspect
import re
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs
from neurbs import plot
from neurbs.cli import options
from neurbs.errors import argument_error

Command = Callable[..., Any]


def module(name: str) -> ModuleType:
    """Return a module of `neurbs.cli`; the package's attributes of these names are commands."""
    import importlib

    return importlib.import_module(f"neurbs.cli.{name}")


@pytest.mark.parametrize(
    ("name", "table", "function", "without_option"),
    [
        ("reconstruct", "RECONSTRUCT_OPTIONS", neurbs.reconstruct, {"weights", "unit", "progress"}),
        ("reconstruct", "PAPER_OPTIONS", neurbs.reconstruct_paper, {"unit", "progress"}),
        ("train", "OPTIONS", neurbs.SelfOrganizingMap, set()),
        ("tessellate", "OPTIONS", neurbs.NurbsSurface.tessellate, {"self", "progress"}),
        ("view", "OPTIONS", plot.plot_surface, {"surface", "unit", "backend"}),
    ],
)
def test_each_argument_that_words_can_give_has_an_option(
    name: str, table: str, function: Callable[..., Any], without_option: set[str]
) -> None:
    # A command reads a file in a unit.
    arguments = set(inspect.signature(function).parameters) - {"points"} - without_option
    assert {option.name for option in getattr(module(name), table)} == arguments


def test_arguments_without_an_option_are_arrays_and_callables() -> None:
    for function in (neurbs.reconstruct, neurbs.reconstruct_paper):
        parameters = inspect.signature(function).parameters
        for name in {"weights", "progress"} & set(parameters):
            annotation = parameters[name].annotation
            assert annotation.startswith(("ArrayLike", "Callable")), name


def test_choices_are_those_of_the_functions(points_file: Path, command: Command) -> None:
    (kind,) = (o for o in module("reconstruct").RECONSTRUCT_OPTIONS if o.name == "kind")
    for word in kind.choices[1:]:
        words = ["-o", points_file.with_suffix(".obj"), "--kind", word, "--grid", "4", "5", "-q"]
        assert command("reconstruct", points_file, *words).code == 0, word


def test_help_shows_choices_and_the_default_of_the_function() -> None:
    def function(*, shape: str = "round", size: int | None = None, solid: bool = True) -> None: ...

    table = (
        options.Option("shape", "Shape", choices=("round", "square")),
        options.Option("size", "Size", "N N", default="as large as the points"),
        options.Option("solid", "Fill it", ""),
    )

    @options.options_of(function, table, "Fit")
    def made(path: str, *, quiet: bool = False, **options: Any) -> None: ...

    parameters = inspect.signature(made).parameters
    assert list(parameters) == ["path", "shape", "size", "solid", "quiet"]
    shown = {
        name: parameters[name].annotation.__metadata__[0] for name in ("shape", "size", "solid")
    }
    assert shown["shape"].help == "Shape (round|square, default: round)"
    assert shown["size"].help == "Size (default: as large as the points)"
    assert shown["solid"].help == "Fill it (default: on)"


# Errors


def test_an_error_about_an_argument_has_its_name(terrain_points: NDArray[np.float64]) -> None:
    calls: list[tuple[str, Callable[[], object]]] = [
        ("grid", lambda: neurbs.reconstruct(terrain_points, grid=(1, 8))),
        ("tolerance", lambda: neurbs.reconstruct(terrain_points, tolerance=0)),
        ("fairness", lambda: neurbs.reconstruct(terrain_points, fairness="much")),  # type: ignore[call-overload]
        ("component", lambda: neurbs.reconstruct(terrain_points, component="all")),  # type: ignore[call-overload]
        ("points", lambda: neurbs.reconstruct("cloud.xyz")),
        ("init", lambda: neurbs.SelfOrganizingMap(init="magic").fit(terrain_points)),  # type: ignore[arg-type]
        ("backend", lambda: plot.plot_points(terrain_points, backend="paper")),  # type: ignore[arg-type]
    ]
    for argument, call in calls:
        with pytest.raises(neurbs.NeurbsError, match=rf"^{argument} must ") as caught:
            call()
        assert caught.value.argument == argument


def test_other_errors_have_no_argument() -> None:
    assert neurbs.NeurbsError("bad").argument is None
    with pytest.raises(neurbs.NeurbsError) as caught:
        neurbs.reconstruct(np.zeros((5, 3)))
    assert caught.value.argument is None


def test_an_error_names_the_option_on_the_command_line(
    points_file: Path, command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = ["reconstruct", points_file, "-o", points_file.with_suffix(".obj")]
    done = command(*words, "--max-control-points", "0")
    assert done.code == 2
    assert done.err.startswith("neurbs: error: Invalid value for '--max-control-points': must be ")

    def fail(*_: object, **__: object) -> None:
        raise argument_error("points", "must be rounder")

    monkeypatch.setattr(neurbs, "reconstruct", fail)
    done = command(*words)
    assert (done.code, done.err) == (1, "neurbs: error: points must be rounder\n")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--grid", "x"], "'--grid': must be two integers from 0, got ('x', 'x')"),
        (["--trim", "maybe"], "'--trim': must be 'auto', 'yes', 'outer' or 'no', got 'maybe'"),
        (["--trim", "False"], "'--trim': must be 'auto', 'yes', 'outer' or 'no', got 'False'"),
        (["--kind", "tub"], "'--kind': must be .* or 'torus', got 'tub'"),
    ],
)
def test_wrong_values_are_named_as_words_of_the_command_line(
    words: list[str], message: str, points_file: Path, command: Command
) -> None:
    done = command("reconstruct", points_file, "-o", points_file.with_suffix(".obj"), *words)
    assert done.code == 2
    pattern = message if ".*" in message else re.escape(message)
    assert re.search(f"Invalid value for {pattern} ", done.err)
    assert "(see 'neurbs reconstruct --help')" in done.err


def test_an_option_without_its_values_names_the_help_of_the_command(command: Command) -> None:
    done = command("reconstruct", "a.xyz", "-o", "a.obj", "--grid")
    assert done.code == 2
    assert "(see 'neurbs reconstruct --help')" in done.err


def test_an_argument_is_not_called_an_option(points_file: Path, command: Command) -> None:
    done = command("convert", points_file, points_file.with_suffix(".foo"))
    assert done.code == 2
    assert done.err.startswith("neurbs: error: Invalid value for 'OUT': ")


@pytest.mark.parametrize(("truth", "trimmed"), [("true", True), ("false", False)])
def test_settings_may_be_truth_values(
    truth: str, trimmed: bool, tmp_path: Path, command: Command
) -> None:
    x, y = np.random.default_rng(0).random((2, 900))
    disc = np.column_stack([x, y, x * y])[np.hypot(x - 0.5, y - 0.5) < 0.5]
    np.savetxt(tmp_path / "disc.xyz", disc)
    (tmp_path / "a.toml").write_text(f"[reconstruct]\ntrim = {truth}\nclean = false\n")
    target = tmp_path / "a.json"
    done = command(
        "reconstruct",
        tmp_path / "disc.xyz",
        "-o",
        target,
        "--config",
        tmp_path / "a.toml",
        "--json",
    )
    assert done.code == 0
    assert (done.json()["report"]["trim"] is not None) == trimmed
    assert neurbs.load_shell(target).faces[0].is_trimmed == trimmed


def test_a_wrong_option_stops_many_files_at_the_first(
    points_file: Path, tmp_path: Path, command: Command
) -> None:
    other = points_file.with_name("other.xyz")
    other.write_bytes(points_file.read_bytes())
    done = command("reconstruct", points_file, other, "-o", f"{tmp_path}/", "--degree", "0")
    assert done.code == 2
    assert done.err.count("\n") == 1


def test_advice_names_options(tmp_path: Path, command: Command) -> None:
    rng = np.random.default_rng(0)
    x, y = rng.random((2, 500))
    points = np.column_stack([x, y + 3 * (x > 0.7), 0.1 * x * y])
    np.savetxt(tmp_path / "two.xyz", points)
    words = [
        "reconstruct",
        tmp_path / "two.xyz",
        "-o",
        tmp_path / "a.obj",
        "-q",
        "--grid",
        "6",
        "5",
    ]
    done = command(*words)
    assert done.code == 0
    assert "Choose one with --component, or fit each: --component each." in done.err
    assert "Use --trim no to keep the surface whole." in done.err
    with pytest.warns(neurbs.ComponentsWarning, match="Choose one with `component`, or fit each"):
        neurbs.reconstruct(points, grid=(6, 5))
    (tmp_path / "holes.xyz").write_text("1 2 3\n4 5 nan\n")
    done = command("info", tmp_path / "holes.xyz")
    assert done.err.endswith("leave it out with --nan drop\n")


@pytest.mark.parametrize(("word", "loops"), [("auto", 2), ("yes", 2), ("outer", 1), ("no", 1)])
def test_faces_end_where_asked(word: str, loops: int, tmp_path: Path, command: Command) -> None:
    points = np.random.default_rng(0).uniform(-1, 1, (3000, 2))
    away = np.linalg.norm(points, axis=1)
    np.savetxt(tmp_path / "ring.xyz", np.pad(points, ((0, 0), (0, 1)))[(away < 1) & (away > 0.3)])
    done = command("reconstruct", tmp_path / "ring.xyz", "-o", tmp_path / "a.step", "--trim", word)
    assert done.code == 0, done.err
    (face,) = neurbs.load_shell(tmp_path / "a.step").faces
    assert 1 + len(face.inner) == loops
    assert face.is_trimmed == (word != "no")
