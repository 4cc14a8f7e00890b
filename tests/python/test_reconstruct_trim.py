"""Reconstructions whose faces end where the points end."""

import os
import pickle
import warnings
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs

Points = NDArray[np.float64]

FOLDER = os.environ.get("NEURBS_DATA")

HOLES = ((20.0, 0.0, 9.0), (-18.0, 10.0, 12.0))
"""Places and radii of the holes of the disc."""


def disc(count: int = 2000, noise: float = 0.05, seed: int = 0) -> Points:
    """Return noisy points on a flat disc of radius 50 with two holes."""
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(-50, 50, (2, 4 * count))
    kept = np.hypot(x, y) < 50
    for u, v, radius in HOLES:
        kept &= np.hypot(x - u, y - v) > radius
    x, y = x[kept][:count], y[kept][:count]
    return np.column_stack([x, y, 0 * x]) + rng.normal(0, noise, (count, 3))


AREA = np.pi * (50**2 - sum(radius**2 for *_, radius in HOLES))


def terrain(count: int = 2000) -> Points:
    """Return points on a rectangle."""
    x, y = np.random.default_rng(0).uniform(0, 10, (2, count))
    return np.column_stack([x, y, np.sin(x) * np.cos(y)])


def star() -> Points:
    """Return points in a star with ten corners."""
    x, y = np.random.default_rng(1).uniform(-1, 1, (2, 9000))
    turn = (np.arctan2(x, y) / (2 * np.pi) * 10) % 2
    ends = np.array([1.0, 0.46])[:, None] * np.array(
        [[0, 1], [np.sin(np.pi / 5), np.cos(np.pi / 5)]]
    )
    share = 1 - abs(1 - turn)
    angle = share * np.pi / 5
    along, across = np.hypot(x, y) * np.cos(angle), np.hypot(x, y) * np.sin(angle)
    (x0, y0), (x1, y1) = ends
    kept = (across - x0) * (y1 - y0) - (along - y0) * (x1 - x0) > 0
    points: Points = np.column_stack([x, y, 0 * x])[kept]
    return points[:3000]


def test_the_areas_of_discs_with_holes_are_right() -> None:
    # The area varies by half a percent from sample to sample.
    areas = [neurbs.reconstruct(disc(seed=seed)).face.area() / AREA for seed in range(10)]
    assert 0.99 < np.mean(areas) < 1.01
    assert sum(0.99 < area < 1.01 for area in areas) >= 8


def test_the_report_measures_faces_and_holes() -> None:
    result = neurbs.reconstruct(disc())
    assert len(result.face.inner) == 2
    assert result.surface.area() > 1.1 * AREA
    report = result.report.trim
    assert report is not None
    assert report.area == pytest.approx(result.shell.area(), rel=1e-6)
    assert report.surface_area == pytest.approx(result.surface.area(), rel=1e-5)
    filled = neurbs.Face(result.face.surface, [result.face.outer]).area()
    assert sum(report.holes) == pytest.approx(filled - report.area, rel=1e-5)
    np.testing.assert_allclose(report.holes, [np.pi * radius**2 for radius in (12, 9)], rtol=0.15)
    assert report.beyond is not None
    assert report.beyond_untrimmed is not None
    assert report.beyond < 0.01 < report.beyond_untrimmed
    assert "2 holes" in str(result.report)
    mesh = result.shell.tessellate(1e-4 * result.report.diagonal)
    assert mesh.euler_characteristic() == result.mesh.euler_characteristic() == -1
    assert mesh.area() == pytest.approx(report.area, rel=1e-3)


def test_the_rectangle_stays_to_the_same_bytes(tmp_path: Path) -> None:
    points = terrain()
    auto, whole = neurbs.reconstruct(points), neurbs.reconstruct(points, trim=False)
    assert not auto.face.is_trimmed
    for suffix in (".step", ".igs", ".json", ".obj", ".stl", ".glb"):
        # Some files hold their name.
        paths = [tmp_path / name / f"a{suffix}" for name in ("auto", "whole")]
        for path, result in zip(paths, (auto, whole), strict=True):
            path.parent.mkdir(exist_ok=True)
            result.save(path)
        first, second = (path.read_bytes() for path in paths)
        assert first == second, suffix
    assert whole.report.trim is None
    assert neurbs.reconstruct(points, trim=True).face.is_trimmed


def test_holes_can_be_covered() -> None:
    result = neurbs.reconstruct(disc(), trim="outer")
    assert result.face.inner == []
    assert result.face.area() == pytest.approx(np.pi * 50**2, rel=0.02)


def test_deviations_are_those_of_the_whole_surface() -> None:
    points = disc()
    trimmed, whole = neurbs.reconstruct(points), neurbs.reconstruct(points, trim=False)
    assert trimmed.surface == whole.surface
    np.testing.assert_array_equal(trimmed.deviations, whole.deviations)
    assert trimmed.report.rms == whole.report.rms


def test_several_regions_are_several_faces(tmp_path: Path) -> None:
    points = disc(4000)
    points = points[abs(points[:, 0]) > 6]
    with pytest.warns(neurbs.RegionsWarning, match="2 regions"):
        result = neurbs.reconstruct(points)
    assert len(result.shell.faces) == 2
    with pytest.raises(neurbs.NeurbsError, match=r"got 2 faces: use result\.shell\.faces"):
        _ = result.face
    result.save(tmp_path / "a.step")
    assert neurbs.load_shell(tmp_path / "a.step").area() == pytest.approx(result.shell.area())


def test_the_shell_has_the_unit_of_the_points(tmp_path: Path) -> None:
    result = neurbs.reconstruct(neurbs.PointCloud(disc() / 25.4, unit="in"))
    assert (result.unit, result.shell.unit) == ("in", "in")
    result.save(tmp_path / "a.step", unit="mm")
    again = neurbs.load_shell(tmp_path / "a.step")
    assert again.unit == "mm"
    assert again.area() == pytest.approx(25.4**2 * result.shell.area(), rel=1e-6)


def test_few_points_stay_untrimmed_and_say_so() -> None:
    with pytest.warns(neurbs.UntrimmedWarning, match="30 points .* are needed, got 20"):
        result = neurbs.reconstruct(terrain(20))
    assert not result.face.is_trimmed
    assert result.report.trim is not None
    assert result.report.trim.beyond is None
    with pytest.warns(neurbs.UntrimmedWarning):
        neurbs.reconstruct(terrain(20), trim=True)


def test_many_holes_are_doubtful() -> None:
    points = np.random.default_rng(0).uniform(0, 10, (40_000, 2))
    points = points[np.linalg.norm(points % 1 - 0.5, axis=1) > 0.25]
    with pytest.warns(neurbs.UntrimmedWarning, match="100 holes were found, more than 64"):
        auto = neurbs.reconstruct(points)
    assert not auto.face.is_trimmed
    with pytest.warns(neurbs.TrimDoubtfulWarning, match="100 holes"):
        forced = neurbs.reconstruct(points, trim=True)
    assert len(forced.face.inner) == 100


@pytest.mark.parametrize("wrong", ["yes", "inner", 2, None])
def test_another_choice_is_refused(wrong: object) -> None:
    with pytest.raises(neurbs.NeurbsError, match="trim must be 'auto', True, 'outer' or False"):
        neurbs.reconstruct(terrain(100), trim=wrong)  # type: ignore[call-overload]


def test_a_result_with_trims_is_pickled() -> None:
    result = neurbs.reconstruct(disc())
    again = pickle.loads(pickle.dumps(result))
    assert again.face == result.face
    assert again.report.trim == result.report.trim


def test_points_in_chunks_are_trimmed_alike() -> None:
    points = disc(4000)
    whole = neurbs.reconstruct(points)
    chunks = neurbs.reconstruct(iter(np.array_split(points, 7)))
    assert chunks.face == whole.face


def test_each_component_is_trimmed() -> None:
    far = disc(seed=1) + np.array([300, 0, 0])
    for result in neurbs.reconstruct(np.concatenate([disc(), far]), component="each"):
        assert len(result.face.inner) == 2


def test_an_outline_with_corners_keeps_its_area() -> None:
    result = neurbs.reconstruct(star())
    expected = 10 * 0.5 * 0.46 * np.sin(np.pi / 5)
    assert 0.97 < result.face.area() / expected < 1.01


CLOUDS = {
    "claudius_h000": {2, 3},
    "claudius_h060": {4},
    "claudius_h250": {0},
    "claudius_h330": {2, 3, 4},
    "mediapipe_face": {0},
    "am_wave_sheet": {0},
}
"""The numbers of holes of real clouds, each seen in a picture."""


@pytest.mark.skipif(not FOLDER, reason="NEURBS_DATA names no folder of point clouds")
@pytest.mark.parametrize("name", CLOUDS)
def test_real_clouds_have_their_holes(name: str) -> None:
    points = neurbs.read_points(Path(FOLDER or "", "npy", f"{name}.npy"))
    result = neurbs.reconstruct(points)
    face, report = result.face, result.report.trim
    assert report is not None
    assert len(face.inner) in CLOUDS[name]
    assert report.outside <= 0.01
    assert report.beyond is not None
    assert report.beyond <= 0.02
    mesh = result.mesh
    assert mesh.euler_characteristic() == 1 - len(face.inner)
    sides = np.sort(np.concatenate([mesh.triangles[:, [i, (i + 1) % 3]] for i in range(3)]), axis=1)
    assert np.unique(sides, axis=0, return_counts=True)[1].max() == 2
    # The accuracy of closest points on edges is that of the shell.
    distances = result.shell.closest_points(mesh.vertices).distances
    assert distances.max() < 1e-6 * result.report.diagonal


@pytest.mark.parametrize("given", [True, False])
@pytest.mark.parametrize("height", [300.0, 3000.0])
def test_faces_do_not_depend_on_the_units_of_the_axes(height: float, given: bool) -> None:
    # Degrees and meters: distances between points count as in the fit.
    x, y = np.random.default_rng(0).random((2, 4000))
    kept = np.hypot(x - 0.5, y - 0.4) > 0.15
    points = np.column_stack([x, y, np.sin(4 * x) * y])[kept]
    scale, origin = np.array([0.8, 0.5, height]), np.array([15, 46, 80_000])
    plain = neurbs.reconstruct(points)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", neurbs.MixedUnitsWarning)
        mixed = neurbs.reconstruct(
            points * scale + origin, axis_scale=(0.8, 0.5, height) if given else None
        )
    assert [found.code for found in mixed.report.diagnostics] == [] if given else ["mixed-units"]
    assert mixed.face.surface == mixed.surface
    for result in (plain, mixed):
        assert len(result.face.inner) == 1
        assert result.face.contains(result.uv).mean() > 0.98
    center = np.array([[0.5, 0.4, np.sin(2) * 0.4]]) * scale + origin
    assert not mixed.face.contains(mixed.surface.closest_points(center).uv).any()
    assert mixed.report.trim is not None
    assert plain.report.trim is not None
    assert mixed.report.trim.outside == pytest.approx(plain.report.trim.outside, abs=0.01)
