"""Real point clouds that are not part of this repository, read from the folder NEURBS_DATA."""

import os
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import neurbs

FOLDER = os.environ.get("NEURBS_DATA")
CLOUDS = sorted(Path(FOLDER, "npy").glob("*.npy")) if FOLDER else []

pytestmark = pytest.mark.skipif(not CLOUDS, reason="NEURBS_DATA names no folder of point clouds")


@pytest.mark.parametrize("path", CLOUDS, ids=lambda path: path.stem)
def test_the_lattice_spreads_over_the_points(path: Path) -> None:
    points = neurbs.read_points(path)
    result = neurbs.reconstruct(points, method="paper", grid=(20, 20))
    report = result.report
    assert report.points == len(points)
    assert report.converged
    # A sheet of 20 × 20 cells has a node within half a cell of most points; folded and closed
    # shapes take more of the box's diagonal than a flat one.
    assert report.quantization_error < 0.03 * report.diagonal
    vertices = result.mesh.vertices
    rounding = 1e-12 * report.diagonal + 1e-15 * np.abs(points).max()
    assert (vertices.min(axis=0) >= points.min(axis=0) - rounding).all()
    assert (vertices.max(axis=0) <= points.max(axis=0) + rounding).all()
    lengths = np.linalg.norm(result.mesh.normals, axis=1)
    np.testing.assert_allclose(lengths, 1, atol=1e-12)


def test_stacked_horizons_are_pieces_that_no_surface_folds_through() -> None:
    points = neurbs.read_points(Path(FOLDER or "", "npy", "claudius_all4.npy"))
    pieces = neurbs.pieces(points)
    horizons = [neurbs.read_points(path) for path in CLOUDS if path.stem.startswith("claudius_h")]
    for piece in range(4):
        found = points[pieces.labels == piece]
        # Eleven points of a horizon lie too far from the others of it.
        nearest = min(horizons, key=lambda horizon: abs(horizon[:, 2].mean() - found[:, 2].mean()))
        assert len(nearest) - len(found) in (0, 11)
        assert {*map(tuple, found)} <= {*map(tuple, nearest)}
    with pytest.warns(neurbs.ConvergenceWarning, match="pieces") as caught:
        result = neurbs.reconstruct(points[::2], grid=(20, 20))
    assert len(caught) == 1
    assert result.report.topology == "height"


def test_rough_terrain_is_found_in_any_unit() -> None:
    points = neurbs.read_points(Path(FOLDER or "", "npy", "jacksboro_dem.npy"))[::28]
    own = neurbs.reconstruct(points)
    with pytest.warns(neurbs.ConvergenceWarning, match="counts 1/.* of z"):
        tall = neurbs.reconstruct(points * [1, 1, 1000])
    assert own.report.topology == tall.report.topology == "height"
    at = np.linspace(0, 1, 50)
    low, high = own.surface.evaluate_grid(at, at), tall.surface.evaluate_grid(at, at)
    np.testing.assert_allclose(high[..., :2], low[..., :2], atol=1e-3 * own.report.diagonal)
    off = high[..., 2] / 1000 - low[..., 2]
    assert np.sqrt((off**2).mean()) < 0.02 * np.ptp(points[:, 2])


def test_outliers_around_a_body_leave_its_surface_near_the_points() -> None:
    points = neurbs.read_points(Path(FOLDER or "", "npy", "owl_photogrammetry.npy"))
    size, kept = np.ptp(points, axis=0).max(), []
    for seed in (1, 2, 3):
        strays = np.random.default_rng(seed).uniform(-2, 2, (len(points) // 50, 3)) * size
        with pytest.warns(neurbs.ConvergenceWarning, match="closed, or nearly so"):
            result = neurbs.reconstruct(np.concatenate([points, points.mean(axis=0) + strays]))
        assert not any("folds over" in warning for warning in result.report.warnings), seed
        assert not result.inliers[len(points) :].any()
        assert result.report.rms < 1e-3 * np.linalg.norm(np.ptp(points, axis=0))
        kept.append(result.inliers[: len(points)].mean())
    assert np.mean(kept) > 0.999, kept


def test_few_points_out_of_order_leave_a_face_its_map() -> None:
    points = neurbs.read_points(Path(FOLDER or "", "npy", "mediapipe_face.npy"))
    result = neurbs.reconstruct(points)
    # Four of its 468 points; a map from the principal plane has none, and is twice as far off.
    assert 0 < result.som.topographic_error(points) < 0.01
    assert result.report.rms < 2.5e-3 * result.report.diagonal


@pytest.mark.filterwarnings("ignore::neurbs.ConvergenceWarning")
def test_what_rounding_moves_leaves_a_face_near_its_points() -> None:
    points = neurbs.read_points(Path(FOLDER or "", "npy", "mediapipe_face.npy"))
    errors = []
    for seed in range(24):
        moved = np.random.default_rng(seed).normal(0, 1e-11, points.shape) * np.ptp(points)
        report = neurbs.reconstruct(points + moved).report
        errors.append(1e4 * report.rms / report.diagonal)
    # The net folds over and is flattened; what does not come back from there stays at 20 and more.
    assert np.median(errors) < 11, errors
    assert sum(error > 16 for error in errors) <= 1, errors


# Root mean square distances in 1e-4 of the diagonal that are met by a tenth or more.
DISTANCES = {
    "am_wave_sheet": 14,
    "bmx_hill_2010": 24,
    "bmx_hill_2023": 9,
    "claudius_h000": 0.7,
    "claudius_h060": 0.9,
    "claudius_h250": 1.5,
    "claudius_h330": 5,
    "mediapipe_face": 13,
    "milk_carton": 15,
    "soybean_leaf": 34,
    "teapot_body": 0.25,
    "teapot_patch05": 0.05,
    "valve_leaflet1": 93,
    "valve_leaflet2": 110,
    "valve_leaflet3": 55,
    "valve_tube": 60,
    # With some points left out it folds over at the stem, until it is turned: up to 0.3 then.
    "yacht_hull": 0.06,
}


@pytest.mark.parametrize("name", DISTANCES)
@pytest.mark.filterwarnings("ignore::neurbs.ConvergenceWarning")
def test_without_arguments_surfaces_come_near_the_points(name: str) -> None:
    report = neurbs.reconstruct(neurbs.read_points(Path(FOLDER or "", "npy", f"{name}.npy"))).report
    assert report.rms < 1e-4 * DISTANCES[name] * report.diagonal
    assert not any("units" in warning for warning in report.warnings)


@pytest.mark.parametrize(
    "name", ["mediapipe_face", "teapot_body", "valve_leaflet3", "yacht_hull", "soybean_leaf"]
)
@pytest.mark.filterwarnings("ignore::neurbs.ConvergenceWarning")
def test_motion_scale_and_order_change_nothing(name: str) -> None:
    points = neurbs.read_points(Path(FOLDER or "", "npy", f"{name}.npy"))
    turn = Rotation.random(random_state=3).as_matrix()
    order = np.random.default_rng(4).permutation(len(points))
    first = neurbs.reconstruct(points)
    second = neurbs.reconstruct(3.7 * (points @ turn.T)[order] + [10, -20, 5])
    assert first.report.grid == second.report.grid
    moved = 3.7 * first.surface.control_points @ turn.T + [10, -20, 5]
    difference = second.surface.control_points - moved
    assert np.abs(difference).max() < 1e-9 * second.report.diagonal
    np.testing.assert_allclose(second.distances, 3.7 * first.distances[order], atol=1e-9)
    np.testing.assert_array_equal(second.inliers, first.inliers[order])
