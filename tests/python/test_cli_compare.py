"""The command compare: clouds, surfaces and shells, each with each."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs
from neurbs.deviation import Deviation, sampled

Command = Callable[..., Any]


def saved(path: Path, thing: Any, unit: str | None = None) -> Path:
    """Write a thing and return the path."""
    neurbs.save(thing, path, unit=unit)
    return path


@pytest.fixture
def clouds(tmp_path: Path) -> tuple[Path, Path, NDArray[np.float64], NDArray[np.float64]]:
    """Write two clouds of different sizes."""
    rng = np.random.default_rng(3)
    first, second = rng.random((700, 3)), rng.random((400, 3)) + np.array([0, 0, 0.3])
    files = [
        saved(tmp_path / f"{k}.ply", neurbs.PointCloud(each))
        for k, each in enumerate((first, second))
    ]
    return files[0], files[1], first, second


def test_two_clouds_are_compared(
    clouds: tuple[Path, Path, NDArray[np.float64], NDArray[np.float64]],
    tmp_path: Path,
    command: Command,
) -> None:
    a, b, first, second = clouds
    target = tmp_path / "distances.csv"
    done = command("compare", a, b, "-o", target, "--json")
    assert done.code == 0
    pairs = np.linalg.norm(second[:, None] - first, axis=-1)
    there, back = pairs.min(axis=1), pairs.min(axis=0)
    measures = done.json()["deviation"]
    assert (measures["points"], measures["signed"]) == (400, False)
    assert measures["max"] == pytest.approx(there.max(), rel=1e-12)
    assert measures["rms"] == pytest.approx(np.sqrt(np.mean(there**2)), rel=1e-12)
    assert measures["mean"] == pytest.approx(there.mean(), rel=1e-12)
    assert measures["back"]["max"] == pytest.approx(back.max(), rel=1e-12)
    assert measures["back"]["points"] == 700
    written = np.loadtxt(target, delimiter=",", skiprows=1)
    np.testing.assert_allclose(written[:, 3], there, rtol=1e-12)
    words = ["compare", a, b, "--tolerance", str(np.median(there))]
    assert command(*words).code == 3
    assert command(*words, "--share", "0.4").code == 0
    assert "signed" not in command(*words).out


def test_two_surfaces_are_compared(tmp_path: Path, command: Command) -> None:
    inner = saved(tmp_path / "a.json", neurbs.NurbsSurface.sphere([0, 0, 0], 1.0), "m")
    outer = saved(tmp_path / "b.json", neurbs.NurbsSurface.sphere([0, 0, 0], 1.25), "m")
    measures = command("compare", inner, outer, "--json").json()["deviation"]
    assert measures["mean"] == pytest.approx(0.25, abs=1e-9)
    assert measures["max"] == pytest.approx(0.25, abs=1e-9)
    assert measures["back"]["max"] == pytest.approx(0.25, abs=1e-9)
    assert command("compare", outer, inner, "--json").json()["deviation"]["mean"] < 0
    # Of a sheet and its half, the half lies on the sheet, and not the other way round.
    whole = saved(tmp_path / "c.json", neurbs.NurbsSurface.plane([0, 0, 0], [4, 0, 0], [0, 1, 0]))
    half = saved(tmp_path / "d.json", neurbs.NurbsSurface.plane([0, 0, 0], [2, 0, 0], [0, 1, 0]))
    done = command("compare", whole, half)
    assert done.code == 0
    assert "back" in done.out
    measures = command("compare", whole, half, "--json").json()["deviation"]
    assert measures["max"] < 1e-12
    assert measures["back"]["max"] == pytest.approx(2, rel=0.01)
    # Half of the area is on the half; the rest is as far as 2, evenly.
    assert measures["back"]["rms"] == pytest.approx(np.sqrt(0.5 * 4 / 3), rel=0.01)


def test_points_and_a_surface_change_places(
    clouds: tuple[Path, Path, NDArray[np.float64], NDArray[np.float64]],
    tmp_path: Path,
    command: Command,
) -> None:
    cloud, _, points, _ = clouds
    plane = neurbs.NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0])
    surface = saved(tmp_path / "plane.json", plane)
    one, other = (
        command("compare", *files, "--json").json()
        for files in ((surface, cloud), (cloud, surface))
    )
    assert one == other
    assert one["reference"] == str(surface)
    assert one["deviation"]["mean"] == pytest.approx(points[:, 2].mean(), rel=1e-12)
    assert "back" not in one["deviation"]


def test_files_without_distances_are_refused(tmp_path: Path, command: Command) -> None:
    points = saved(tmp_path / "a.ply", neurbs.PointCloud(np.eye(3)))
    (tmp_path / "b.docx").touch()
    done = command("compare", points, tmp_path / "b.docx")
    assert done.code == 2
    assert "points must be in a file with a suffix of" in done.err
    assert command("compare", points, tmp_path / "missing.ply").code == 1


def test_samples_are_even(tmp_path: Path) -> None:
    """Of a cone, the height over the area grows linearly toward the tip."""
    cone = neurbs.NurbsSurface.cone([0, 0, 0], [0, 0, 1], 1.0)
    z = sampled(neurbs.Shell(cone))[:, 2]
    shares = np.histogram(z, bins=10, range=(0, 1))[0] / len(z)
    expected = np.diff(1 - (1 - np.linspace(0, 1, 11)) ** 2)
    np.testing.assert_allclose(shares, expected, atol=0.005)


def test_distances_from_a_cloud(rng: np.random.Generator) -> None:
    cloud, points = rng.random((2000, 3)), rng.random((3000, 3))
    expected = np.array([np.linalg.norm(cloud - point, axis=1).min() for point in points])
    found = Deviation.of(neurbs.PointCloud(cloud), points)
    np.testing.assert_allclose(found.signed, expected, rtol=1e-14)
    before = neurbs.num_threads()
    try:
        for count in (1, 2, 7):
            neurbs.set_num_threads(count)
            again = Deviation.of(neurbs.PointCloud(cloud), points)
            np.testing.assert_array_equal(again.signed, found.signed)
    finally:
        neurbs.set_num_threads(before)
    with pytest.raises(neurbs.NeurbsError, match="finite"):
        Deviation.of(neurbs.PointCloud(cloud), [[0, 0, np.nan]])
