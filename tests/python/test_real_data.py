"""Real point clouds that are not part of this repository, read from the folder NEURBS_DATA."""

import os
from pathlib import Path

import numpy as np
import pytest

import neurbs

FOLDER = os.environ.get("NEURBS_DATA")

CLOUDS = sorted(Path(FOLDER, "npy").glob("*.npy")) if FOLDER else []

pytestmark = pytest.mark.skipif(not CLOUDS, reason="NEURBS_DATA names no folder of point clouds")


@pytest.mark.parametrize("path", CLOUDS, ids=lambda path: path.stem)
def test_the_lattice_spreads_over_the_points(path: Path) -> None:
    points = neurbs.read_points(path)
    result = neurbs.reconstruct_paper(points, grid=(20, 20))
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


def test_stacked_horizons_are_components() -> None:
    points = neurbs.read_points(Path(FOLDER or "", "npy", "claudius_all4.npy"))
    labels = neurbs.components(points).labels
    horizons = [neurbs.read_points(path) for path in CLOUDS if path.stem.startswith("claudius_h")]
    # The lower two horizons are within two spacings of each other, so they are one component.
    expected = sorted([len(horizons[0]), len(horizons[1]), len(horizons[2]) + len(horizons[3])])
    sizes = np.bincount(labels[labels >= 0])
    np.testing.assert_allclose(sorted(sizes)[-3:], expected, rtol=0.02)
    for component in range(len(sizes)):
        found = {*map(tuple, points[labels == component])}
        among = [bool(found & {*map(tuple, horizon)}) for horizon in horizons]
        assert sum(among) == (2 if len(found) == max(sizes) else 1)
