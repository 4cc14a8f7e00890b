"""Two walks of users, from their data to their files: an engineer's and a developer's."""

from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.image import imread
from numpy.typing import NDArray
from OCP.Bnd import Bnd_Box
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.STEPControl import STEPControl_Reader

import neurbs

Points = NDArray[np.float64]


def scan(count: int = 20_000) -> Points:
    """Return a scan in millimeters of a bent sheet with a round hole, with noise of 0.02."""
    rng = np.random.default_rng(0)
    x, y = rng.uniform((-60, -40), (60, 40), (count, 2)).T
    kept = np.hypot(x - 20, y) > 12
    x, y = x[kept], y[kept]
    return np.column_stack([x, y, 0.004 * x**2 + 2 * np.sin(y / 15)]) + rng.normal(
        0, 0.02, (len(x), 3)
    )


def test_an_engineer_gets_a_part_from_a_scan(tmp_path: Path, command: Callable[..., Any]) -> None:
    cloud, part, picture = (tmp_path / name for name in ("scan.ply", "part.step", "part.png"))
    neurbs.save(neurbs.PointCloud(scan(), unit="mm"), cloud)
    shown = command("info", cloud, "--json").json()
    assert shown["unit"] == "mm"
    done = command("reconstruct", cloud, "-o", part, "-o", picture, "--tolerance", 0.1, "--strict")
    assert done.code == 0, done.err
    reader = STEPControl_Reader()
    reader.ReadFile(str(part))
    reader.TransferRoots()
    shape = reader.OneShape()
    assert BRepCheck_Analyzer(shape).IsValid()
    box = Bnd_Box()
    BRepBndLib.AddOptimal_s(shape, box, False, False)
    sides = np.subtract(box.CornerMax().Coord(), box.CornerMin().Coord())
    np.testing.assert_allclose(sides[:2], [120, 80], atol=1.5)
    (face,) = neurbs.load_shell(part).faces
    assert len(face.inner) == 1
    compared = command("compare", part, cloud, "--json").json()
    assert compared["unit"] == "mm"
    assert compared["deviation"]["rms"] < 0.1
    colors = imread(picture)
    assert min(colors.shape[:2]) > 300
    assert colors.std() > 0.05


def fitted(points: Points) -> neurbs.Reconstruction:
    return neurbs.reconstruct(points, grid=(8, 8))


def test_a_program_fits_clouds_in_processes_and_maps_in_pipelines() -> None:
    pandas = pytest.importorskip("pandas", reason="pandas is not installed")
    pipeline = pytest.importorskip("sklearn.pipeline")
    preprocessing = pytest.importorskip("sklearn.preprocessing")
    x, y = np.random.default_rng(1).random((2, 900))
    table = pandas.DataFrame({"x": x, "y": y, "z": x * y, "part": np.arange(900) % 3})
    clouds = [group[["x", "y", "z"]] for _, group in table.groupby("part")]
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        results = list(pool.map(fitted, clouds))
    for cloud, result in zip(clouds, results, strict=True):
        assert result.report.rms < 1e-3
        again = fitted(cloud)
        np.testing.assert_array_equal(result.surface.control_points, again.surface.control_points)
        height = result.z(0.5, 0.5)
        assert height == pytest.approx(0.25, abs=1e-3)
    steps = pipeline.make_pipeline(preprocessing.StandardScaler(), neurbs.SelfOrganizingMap(6, 5))
    assert steps.fit_transform(table[["x", "y", "z"]]).shape[0] == 900


def test_a_program_shows_faces_in_pyvista() -> None:
    pyvista = pytest.importorskip("pyvista")
    result = neurbs.reconstruct(scan(4000))
    drawn = result.mesh.to_pyvista()
    assert isinstance(drawn, pyvista.PolyData)
    assert drawn.area == pytest.approx(result.face.area(), rel=1e-3)
