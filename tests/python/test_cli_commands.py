"""The commands train, tessellate, convert, compare, info and view."""

import importlib
import json
import re
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs

QUICK = ["--grid", "6", "5", "--aspect", "fixed"]
Command = Callable[..., Any]


def test_a_map_is_trained(points_file: Path, tmp_path: Path, command: Command) -> None:
    target, picture = tmp_path / "map.npz", tmp_path / "map.png"
    words: list[str | Path] = ["-o", target, "-o", picture, "--rows", "6", "--cols", "5", "--json"]
    done = command("train", points_file, *words)
    assert done.code == 0
    measures = done.json()["map"]
    assert measures["nodes"] == 30
    som = neurbs.SelfOrganizingMap.load(target)
    assert som.codebook_.shape == (6, 5, 3)
    points = neurbs.read_points(points_file)
    np.testing.assert_array_equal(
        som.codebook_, neurbs.SelfOrganizingMap(6, 5).fit(points).codebook_
    )
    assert measures["quantization_error"] == som.quantization_error(points)
    assert picture.read_bytes().startswith(b"\x89PNG")
    done = command("info", target)
    assert "6, 5" in done.out


def test_a_map_by_the_paper_with_a_schedule(
    points_file: Path, tmp_path: Path, command: Command
) -> None:
    target = tmp_path / "map.npz"
    words = ["--paper", "--rows", "5", "--cols", "4", "--radius", "gaussian,3,100", "--seed", "4"]
    assert command("train", points_file, "-o", target, "-q", *words).code == 0
    som = neurbs.SelfOrganizingMap.load(target)
    assert (som.training, som.radius, som.seed) == ("online", ("gaussian", 3, 100), 4)


def test_a_map_is_drawn_in_its_unit(points_file: Path, tmp_path: Path, command: Command) -> None:
    table, svg, pdf = (tmp_path / name for name in ("a.csv", "a.svg", "a.PDF"))
    points = neurbs.read_points(points_file)
    neurbs.save(neurbs.PointCloud(points, unit="in"), table)
    words: list[str | Path] = ["-o", svg, "-o", pdf, "-o", tmp_path / "a.npz", "--rows", "4"]
    assert command("train", table, *words, "--cols", "4", "--unit", "mm", "-q").code == 0
    assert "<svg" in svg.read_text()
    assert pdf.read_bytes().startswith(b"%PDF")
    nodes = neurbs.SelfOrganizingMap.load(tmp_path / "a.npz").codebook_
    assert np.ptp(nodes[..., 0]) > 10 * np.ptp(points[:, 0])


def test_a_map_in_a_folder_that_is_missing_is_refused_first(
    points_file: Path, tmp_path: Path, command: Command
) -> None:
    for name in ("no/a.npz", "no/a.gif"):
        done = command("train", points_file, "-o", tmp_path / name)
        assert (done.code, "there is no such folder, make it first" in done.err) == (1, True)


def test_an_animation_is_written(points_file: Path, tmp_path: Path, command: Command) -> None:
    animation = tmp_path / "a.gif"
    words: list[str | Path] = ["-o", animation, "--rows", "4", "--cols", "4", "-q"]
    assert command("train", points_file, *words).code == 0
    assert animation.read_bytes().startswith(b"GIF89a")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ["-o", "a.step"],
            "'--output': a.step: must have the suffix of .*\\.npz; a picture: .*, got",
        ),
        (["-o", "a.gif", "-o", "a.mp4"], "there must be at most one animation, got 2"),
        (["-o", "a.npz", "--rows", "1"], "--rows|rows"),
        (["-o", "a.npz", "--init", "magic"], "'--init': must be .*, got 'magic'"),
    ],
)
def test_a_wrong_training(
    words: list[str],
    message: str,
    points_file: Path,
    monkeypatch: pytest.MonkeyPatch,
    command: Command,
) -> None:
    monkeypatch.chdir(points_file.parent)
    done = command("train", points_file, *words)
    assert done.code in (1, 2)
    assert re.search(message, done.err)
    assert [path.name for path in Path().iterdir()] == [points_file.name]


@pytest.fixture
def surface_file(tmp_path: Path, terrain_points: NDArray[np.float64]) -> Path:
    """Write a surface over `terrain_points`."""
    path = tmp_path / "surface.json"
    neurbs.reconstruct(terrain_points, grid=(8, 8)).save(path)
    return path


def test_a_surface_is_tessellated(surface_file: Path, tmp_path: Path, command: Command) -> None:
    mesh = tmp_path / "mesh.obj"
    done = command("tessellate", surface_file, "-o", mesh, "--shape", "4", "6", "--json")
    assert done.code == 0
    assert done.json()["triangles"] == 2 * 3 * 5
    assert mesh.read_text().count("\nf ") == 30


def test_a_wrong_tessellation(surface_file: Path, tmp_path: Path, command: Command) -> None:
    done = command("tessellate", surface_file, "-o", tmp_path / "a.obj", "--shape", "x", "1")
    assert done.code == 2
    assert "'--shape': must be " in done.err


def test_surfaces_and_points_are_converted(
    surface_file: Path, points_file: Path, tmp_path: Path, command: Command
) -> None:
    target = tmp_path / "surface.step"
    assert command("convert", surface_file, target).code == 0
    assert target.read_text().startswith("ISO-10303-21;")
    assert command("convert", points_file, tmp_path / "points.ply", "-q").code == 0
    np.testing.assert_array_equal(
        neurbs.read_points(tmp_path / "points.ply"), neurbs.read_points(points_file)
    )


def test_converting_points_to_a_surface_points_to_reconstruct(
    tmp_path: Path, terrain_points: NDArray[np.float64], command: Command
) -> None:
    cup, target = tmp_path / "my cup.ply", tmp_path / "cup.step"
    neurbs.save(neurbs.PointCloud(terrain_points), cup)
    done = command("convert", cup, target, "--unit", "mm", "--nan", "drop")
    assert done.code == 1
    assert "has points, and .step files are made from a surface" in done.err
    # The command in the message works as it is.
    (shown,) = re.findall("`(.*)`", done.err)
    assert shown == f"neurbs reconstruct '{cup}' -o {target} --nan drop --unit mm"
    assert command(*shlex.split(shown)[1:], *QUICK).code == 0
    assert neurbs.load_shell(target).unit == "mm"
    assert "cup.step" in command("convert", cup, target.with_suffix(".stl")).err.replace(
        ".stl", ".step"
    )


def test_points_are_compared(
    surface_file: Path, points_file: Path, tmp_path: Path, command: Command
) -> None:
    target = tmp_path / "deviations.ply"
    done = command("compare", surface_file, points_file, "-o", target, "--json")
    assert done.code == 0
    measures = done.json()["deviation"]
    surface, points = neurbs.load_surface(surface_file), neurbs.read_points(points_file)
    distances = surface.closest_points(points).distances
    assert measures["rms"] == pytest.approx(np.sqrt(np.mean(distances**2)), rel=1e-12)
    assert measures["max"] == pytest.approx(distances.max(), rel=1e-12)
    assert measures["percentiles"]["95"] == pytest.approx(np.percentile(distances, 95), rel=1e-12)
    assert b"distance" in target.read_bytes()[:1000]


def test_compare_exits_with_3_outside_the_tolerance(
    surface_file: Path, points_file: Path, command: Command
) -> None:
    words: list[str | Path] = ["compare", surface_file, points_file, "--tolerance"]
    median = np.median(
        neurbs.load_surface(surface_file).closest_points(neurbs.read_points(points_file)).distances
    )
    assert command(*words, "1e6").code == 0
    failed = command(*words, str(median))
    assert failed.code == 3
    assert "50.000 % within, failed" in failed.out
    assert command(*words, str(median), "--share", "0.4", "-q").code == 0
    assert "'--tolerance': must be a number that is positive" in command(*words, "0").err
    assert command(*words, "1", "--share", "2").code == 2


def test_info_describes_a_file(surface_file: Path, points_file: Path, command: Command) -> None:
    of_surface = command("info", surface_file, "--json").json()
    assert of_surface["kind"] == "surface"
    assert of_surface["net"] == [8, 8]
    of_points = command("info", points_file, "--json").json()
    assert (of_points["kind"], of_points["points"]) == ("points", 400)
    assert "400" in command("info", points_file).out
    assert "missing.step: No such file" in command("info", "missing.step").err


def test_a_view_is_written(
    surface_file: Path, points_file: Path, tmp_path: Path, command: Command
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
    done = command("view", surface_file, "-o", pictures[0], *words)
    assert done.code == 0
    assert command("view", points_file, "-o", pictures[1]).code == 0
    assert all(picture.read_bytes().startswith(b"\x89PNG") for picture in pictures)
    done = command("view", surface_file, "-o", pictures[0], "--color", "red")
    assert done.code == 2
    assert "'--color': must be one of height" in done.err


def test_a_map_is_viewed(points_file: Path, tmp_path: Path, command: Command) -> None:
    map_file, picture = tmp_path / "map.npz", tmp_path / "a.png"
    assert command("train", points_file, "-o", map_file, "--rows", "5", "--cols", "4").code == 0
    done = command("view", map_file, "--points", points_file, "-o", picture, "--view", "top")
    assert done.code == 0
    assert picture.read_bytes().startswith(b"\x89PNG")
    done = command("view", map_file, "-o", picture, "--color", "zebra")
    assert done.code == 1
    assert "--color must be left out: the file has a map" in done.err
    done = command("view", map_file)
    assert (done.code, done.out) == (1, "")
    assert "with -o" in done.err


def test_a_view_has_the_unit_of_the_file(
    tmp_path: Path, command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    units: list[str] = []
    view = importlib.import_module("neurbs.cli.view")
    drawn = view.plot_surface

    def seen(*things: Any, unit: str, **options: Any) -> Any:
        units.append(unit)
        return drawn(*things, unit=unit, **options)

    monkeypatch.setattr(view, "plot_surface", seen)
    part = tmp_path / "part.step"
    plane = neurbs.NurbsSurface.plane([0, 0, 0], [9, 0, 0], [0, 9, 0.1])
    neurbs.save(plane, part, unit="in")
    for words in ([], ["--unit", "mm"]):
        done = command("view", part, "-o", tmp_path / "a.png", *words)
        assert done.code == 0, done.err
    assert units == ["in", "mm"]


def test_views_of_all_contents_have_the_size_that_is_given(
    surface_file: Path, points_file: Path, tmp_path: Path, command: Command
) -> None:
    from matplotlib.image import imread

    surface = neurbs.load_surface(surface_file)
    half = surface.domain[0][1] / 2
    uv = np.random.default_rng(0).random((900, 2)) * [half, surface.domain[1][1]]
    neurbs.save(neurbs.trim(surface, uv), tmp_path / "shell.json")
    words = ["--view", "top", "--size", "4", "3", "--dpi", "50", "--exaggeration", "2"]
    for name in (surface_file, points_file, tmp_path / "shell.json"):
        picture = tmp_path / "picture.png"
        assert command("view", name, "-o", picture, *words).code == 0
        assert imread(picture).shape[:2] == (150, 200)
    color = ["--points", points_file, "--color", "deviation", "--tolerance", "5"]
    done = command("view", tmp_path / "shell.json", "-o", tmp_path / "a.svg", *color)
    assert done.code == 0
    assert (tmp_path / "a.svg").read_text().startswith("<?xml")
    for name, option in ((points_file, "--isolines=3"), (tmp_path / "shell.json", "--control-net")):
        done = command("view", name, "-o", tmp_path / "b.png", option)
        assert done.code == 1
        assert f"{option.split('=')[0]} must be left out" in done.err
    done = command("view", surface_file, "-o", tmp_path / "a.gif")
    assert "must have the suffix .png, .svg, .pdf" in done.err


def test_a_window_needs_a_screen(
    surface_file: Path, monkeypatch: pytest.MonkeyPatch, command: Command
) -> None:
    monkeypatch.setattr("sys.platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    done = command("view", surface_file)
    assert done.code == 1
    assert "write a picture with -o" in done.err


def test_each_command_has_an_example(command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    for name in ("reconstruct", "train", "tessellate", "compare", "info", "convert", "view"):
        text = " ".join(command(name, "--help").out.split())
        assert re.search(rf"Examples?: neurbs {name} ", text)


def test_the_report_is_written(points_file: Path, tmp_path: Path, command: Command) -> None:
    pytest.importorskip("plotly", reason="plotly is not installed")
    page = tmp_path / "report.html"
    done = command("reconstruct", points_file, "-o", page, "--unit", "m", *QUICK)
    assert done.code == 0
    text = page.read_text(encoding="utf-8")
    # The whole command, with the options that are no settings of the fit.
    words = " ".join(QUICK)
    assert f"<pre>neurbs reconstruct {points_file} -o {page} --unit m {words}</pre>" in text


def test_a_shell_is_described_converted_and_tessellated(tmp_path: Path, command: Command) -> None:
    tube = neurbs.NurbsSurface.cylinder([0, 0, 0], [0, 0, 2], 1)
    caps = [neurbs.NurbsSurface.ruled(tube.isocurve(v=v), point(v)) for v in (0.0, 1.0)]
    shell = neurbs.Shell([tube, neurbs.Face(caps[0]), neurbs.Face(caps[1], reversed=True)])
    assert shell.is_closed
    file, free_form = tmp_path / "can.json", tmp_path / "can.obj"
    neurbs.save(neurbs.Shell(shell.faces, unit="mm"), file)
    assert command("convert", file, free_form).code == 0
    for source in (file, free_form):
        facts = json.loads(command("info", source, "--json").out)
        assert (facts["kind"], facts["faces"], facts["closed"]) == ("shell", 3, True)
        assert facts["volume"] == pytest.approx(2 * np.pi, rel=1e-6)
    mesh = tmp_path / "can.stl"
    assert command("tessellate", free_form, "-o", mesh, "-q").code == 0
    assert mesh.stat().st_size > 1000
    done = command("tessellate", file, "-o", mesh, "--shape", "3", "4")
    assert (done.code, "--shape must be left out" in done.err) == (1, True)


def point(v: float) -> neurbs.NurbsCurve:
    """Return a curve that stays at the middle of a circle of the tube."""
    return neurbs.NurbsCurve([[0, 0, 2 * v]] * 2, degree=1)
