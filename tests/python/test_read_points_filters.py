"""Filters of `neurbs.read_points`: several files, boxes, cells and classes."""

from pathlib import Path
from typing import Any

import laspy
import numpy as np
import pyproj
import pytest
from numpy.typing import NDArray

import neurbs

Floats = NDArray[np.float64]


def write_tile(
    path: Path, points: Floats, classes: NDArray[Any] | None = None, crs: int | None = None
) -> None:
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.scales, header.offsets = np.full(3, 0.001), np.floor(points.min(axis=0))
    if crs is not None:
        header.add_crs(pyproj.CRS.from_epsg(crs))
    file = laspy.LasData(header)
    file.x, file.y, file.z = points.T
    if classes is not None:
        file.classification = classes
    file.write(path)


@pytest.fixture
def tiles(tmp_path: Path) -> list[Path]:
    """Four tiles of a square of 20 × 20, in rows."""
    paths = []
    for number in range(4):
        low = np.array([10 * (number % 2), 10 * (number // 2), 0])
        points = np.random.default_rng(number).random((3000, 3)) * [10, 10, 1] + low
        paths.append(tmp_path / f"tile{number}.laz")
        write_tile(paths[-1], points, np.arange(3000) % 4)
    return paths


def test_several_files_are_read_as_one(tiles: list[Path]) -> None:
    whole = neurbs.read_points(tiles)
    assert whole.shape == (12_000, 3)
    np.testing.assert_array_equal(whole[3000:6000], neurbs.read_points(tiles[1]))
    chunks = list(neurbs.read_points(tiles, chunks=5000))
    assert [len(chunk) for chunk in chunks] == [5000, 5000, 2000]
    np.testing.assert_array_equal(np.concatenate(chunks), whole)


@pytest.mark.parametrize("bounds", [(2, 3, 12, 9), ((2, 3, 0.2), (12, 9, 0.7))])
def test_a_box_keeps_the_points_in_it(tiles: list[Path], bounds: tuple[float, ...]) -> None:
    whole = neurbs.read_points(tiles)
    low, high = np.reshape(bounds, (2, -1))
    columns = whole[:, : len(low)]
    inside = ((columns >= low) & (columns <= high)).all(axis=1)
    assert 0 < inside.sum() < len(whole)
    np.testing.assert_array_equal(neurbs.read_points(tiles, bounds=bounds), whole[inside])


def test_a_tile_with_other_bounds_is_not_opened(tiles: list[Path]) -> None:
    points = neurbs.read_points(tiles[0], bounds=(0, 0, 5, 5))
    # Cut short behind its header: it can only be read because its bounds are elsewhere.
    tiles[3].write_bytes(tiles[3].read_bytes()[:1000])
    found = neurbs.read_points([tiles[0], tiles[3]], bounds=(0, 0, 5, 5))
    np.testing.assert_array_equal(found, points)
    with pytest.raises(neurbs.NeurbsError, match=r"tile3\.laz"):
        neurbs.read_points([tiles[0], tiles[3]], bounds=(0, 0, 15, 15))


def test_a_file_that_is_no_las_is_not_skipped(tmp_path: Path, tiles: list[Path]) -> None:
    other = tmp_path / "other.las"
    other.write_bytes(b"x" * 1000)
    with pytest.raises(neurbs.NeurbsError, match=r"other\.las"):
        neurbs.read_points([tiles[0], other], bounds=(0, 0, 5, 5))


FEET, METERS = 2227, 32633
"""Reference systems in US survey feet and in meters."""


def test_units_are_converted_before_filters(tmp_path: Path) -> None:
    points = np.random.default_rng(0).random((2000, 3)) * 100
    path = tmp_path / "feet.las"
    write_tile(path, points, crs=FEET)
    stored = neurbs.read_points(path)
    in_meters = stored * (1200 / 3937)
    np.testing.assert_allclose(neurbs.read_points(path, unit="m"), in_meters, rtol=1e-12)
    # The box is in meters: by the header, in feet, it would lie outside of the file.
    moved = tmp_path / "moved.las"
    write_tile(moved, points + np.array([1000, 1000, 0]), crs=FEET)
    found = neurbs.read_points(moved, unit="m", bounds=(305, 305, 320, 320))
    whole = neurbs.read_points(moved, unit="m")
    inside = ((whole[:, :2] >= 305) & (whole[:, :2] <= 320)).all(axis=1)
    assert 0 < inside.sum() < len(whole)
    np.testing.assert_array_equal(found, whole[inside])
    thinned = neurbs.read_points(path, unit="m", cell=5.0)
    first = np.unique(np.floor(in_meters / 5), axis=0, return_index=True)[1]
    np.testing.assert_allclose(thinned, in_meters[np.sort(first)], rtol=1e-12)


def test_files_with_several_units_must_be_converted(tmp_path: Path) -> None:
    names = {"a.csv": "m", "b.csv": "m", "c.csv": "mm"}
    paths = [tmp_path / name for name in names]
    for path, unit in zip(paths, names.values(), strict=True):
        path.write_text(f"x [{unit}],y [{unit}],z [{unit}]\n1,2,3\n4,5,6\n")
    assert len(neurbs.read_points(paths[:2])) == 4
    with pytest.raises(neurbs.NeurbsError, match=r"c\.csv: files must have one unit, got 'm'"):
        neurbs.read_points(paths)
    found = neurbs.read_points(paths, unit="mm")
    np.testing.assert_allclose(found[[0, 4]], [[1000, 2000, 3000], [1, 2, 3]])


def test_clouds_keep_their_attributes_through_filters(tmp_path: Path) -> None:
    path = tmp_path / "scan.csv"
    path.write_text("x [m],y [m],z [m],r,g,b\n1,1,0,10,0,0\n5,5,0,20,0,0\nnan,1,1,30,0,0\n")
    cloud = neurbs.read_point_cloud(path, nan="drop", bounds=(4, 4, 6, 6))
    assert (cloud.points.tolist(), cloud.unit) == ([[5, 5, 0]], "m")
    assert cloud.colors is not None
    assert cloud.colors.tolist() == [[20, 0, 0]]
    # Only points that are not finite count as dropped.
    assert (cloud.dropped, cloud.no_data) == (1, 0)


def test_warnings_come_from_every_file(tmp_path: Path) -> None:
    paths = [tmp_path / f"{name}.csv" for name in "ab"]
    for path in paths:
        path.write_text("x,y,z\n1,2,3\nnan,5,6\n")
    with pytest.warns(neurbs.PointsDroppedWarning) as found:
        assert len(neurbs.read_points(paths, nan="drop")) == 2
    assert [Path(one.filename).name for one in found] == [Path(__file__).name] * 2
    messages = [str(one.message) for one in found]
    assert "a.csv: 1 of 2" in messages[0]
    assert "b.csv: 1 of 2" in messages[1]


@pytest.mark.parametrize("chunks", [1, 700, 100_000])
def test_a_cell_keeps_its_first_point_whatever_the_chunks(tiles: list[Path], chunks: int) -> None:
    whole = neurbs.read_points(tiles)
    cells, first = np.unique(np.floor(whole / 0.5), axis=0, return_index=True)
    assert 1000 < len(cells) < len(whole)
    thinned = np.concatenate(list(neurbs.read_points(tiles, cell=0.5, chunks=chunks)))
    np.testing.assert_array_equal(thinned, whole[np.sort(first)])


def test_classes_are_chosen(tiles: list[Path]) -> None:
    whole = neurbs.read_points(tiles[0])
    ground = neurbs.read_points(tiles[0], las_classes=[2])
    np.testing.assert_array_equal(ground, whole[2::4])
    two = neurbs.read_points(tiles[0], las_classes=[1, 3])
    np.testing.assert_array_equal(two, whole[1::2])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"bounds": (0, 0, 1)}, "bounds must be the lowest and the highest"),
        ({"bounds": (1, 0, 0, 1)}, "bounds must be the lowest and the highest"),
        ({"bounds": "here"}, "bounds must be the lowest and the highest"),
        ({"cell": 0}, "cell must be a number above 0, got 0"),
        ({"cell": 1e-7}, "cell must be at least"),
        ({"las_classes": [300]}, "las_classes must be integers from 0 to 255"),
        ({"las_classes": [17]}, "must leave at least one point"),
        ({"bounds": (50, 50, 60, 60)}, "must leave at least one point"),
        ({"bounds": (50, 50, 60, 60), "unit": "m"}, "must leave at least one point"),
    ],
)
def test_wrong_filters_are_refused(
    tiles: list[Path], options: dict[str, object], message: str
) -> None:
    with pytest.raises(neurbs.NeurbsError, match=message):
        neurbs.read_points(tiles, **options)  # type: ignore[call-overload]


def test_classes_of_other_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.xyz"
    path.write_text("1 2 3\n4 5 6\n")
    with pytest.raises(neurbs.NeurbsError, match="las_classes must be left out"):
        neurbs.read_points(path, las_classes=[2])
    with pytest.raises(neurbs.NeurbsError, match="path must be at least one file"):
        neurbs.read_points([])
