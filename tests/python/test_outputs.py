"""Outputs of commands: they replace no input and have different names."""

import os
from pathlib import Path

import numpy as np
import pytest

import neurbs
from neurbs import cli


def refused(capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> str:
    """Return the message of a command that is refused before it starts."""
    with pytest.raises(SystemExit) as exit:
        cli.main(list(map(str, arguments)))
    assert exit.value.code == 2
    return " ".join(capsys.readouterr().err.split())


@pytest.fixture
def cloud(tmp_path: Path, rng: np.random.Generator) -> Path:
    path = tmp_path / "two-1.csv"
    np.savetxt(path, rng.random((60, 3)), delimiter=",")
    return path


def test_a_map_does_not_replace_its_points(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, rng: np.random.Generator
) -> None:
    path = tmp_path / "pts.npz"
    np.savez(path, points=rng.random((60, 3)))
    before = path.read_bytes()
    message = refused(capsys, "train", path, "-o", tmp_path / "." / "pts.npz")
    assert message.count("pts.npz") >= 2
    assert path.read_bytes() == before


def test_a_link_to_the_input_is_the_input(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, cloud: Path
) -> None:
    link = tmp_path / "other.csv"
    try:
        os.link(cloud, link)
    except OSError:
        pytest.skip("this file system has no links")
    before = cloud.read_bytes()
    assert "must not be overwritten" in refused(capsys, "reconstruct", cloud, "-o", link)
    assert cloud.read_bytes() == before


def test_a_numbered_result_does_not_replace_the_input(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, cloud: Path
) -> None:
    before = cloud.read_bytes()
    target = tmp_path / "two.csv"
    message = refused(capsys, "reconstruct", cloud, "-o", target, "--component", "each")
    assert "two.csv" in message
    assert "two-1.csv" in message
    assert cloud.read_bytes() == before


@pytest.mark.parametrize("names", [("a/scan.xyz", "b/scan.xyz"), ("a/scan.csv", "a/scan.xyz")])
def test_two_results_do_not_get_one_name(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    rng: np.random.Generator,
    names: tuple[str, str],
) -> None:
    files = [tmp_path / name for name in names]
    for file in files:
        file.parent.mkdir(exist_ok=True)
        np.savetxt(file, rng.random((60, 3)))
    (tmp_path / "out").mkdir()
    message = refused(capsys, "reconstruct", *files, "-o", tmp_path / "out")
    assert all(str(file) in message for file in files)
    assert not list((tmp_path / "out").iterdir())


def test_one_output_is_not_given_twice(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, cloud: Path
) -> None:
    one, other = tmp_path / "a.step", tmp_path / "." / "a.step"
    assert "one file" in refused(capsys, "reconstruct", cloud, "-o", one, "-o", other)


@pytest.mark.parametrize(
    "words",
    [
        ("tessellate", "a.obj", "-o", "./a.obj"),
        ("convert", "a.obj", "./a.obj"),
        ("compare", "p.csv", "a.obj", "-o", "./p.csv"),
        ("reconstruct-paper", "p.ply", "-o", "./p.ply"),
    ],
)
def test_no_command_replaces_its_input(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    rng: np.random.Generator,
    words: tuple[str, ...],
) -> None:
    monkeypatch.chdir(tmp_path)
    neurbs.save(neurbs.NurbsSurface(rng.random((4, 4, 3))), "a.obj")
    for name in ("p.csv", "p.ply"):
        neurbs.save(neurbs.PointCloud(rng.random((60, 3))), name)
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    assert "must not be overwritten" in refused(capsys, *words)
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before
