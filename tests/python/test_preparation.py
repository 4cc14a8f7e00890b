"""What is done with points before anything is learned from them."""

import os
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs

Points = NDArray[np.float64]

FOLDER = os.environ.get("NEURBS_DATA")
needs_data = pytest.mark.skipif(not FOLDER, reason="NEURBS_DATA names no folder of point clouds")


def real(name: str) -> Points:
    """Read one of the clouds that are not part of this repository."""
    assert FOLDER is not None
    points: Points = np.load(Path(FOLDER, "npy", f"{name}.npy"))
    return points


def wave(rng: np.random.Generator, count: int, noise: float = 0.0) -> Points:
    """Scatter points over a wavy sheet, with noise as a share of its diagonal."""
    x, y = rng.random((2, count))
    points = np.column_stack([x, y, np.sin(3 * x) * np.cos(2 * y)])
    return points + noise * 1.9 * rng.standard_normal(points.shape)


def rolled(rng: np.random.Generator, count: int, share: float, noise: float = 0.0) -> Points:
    """Scatter points over this share of a cylinder of radius 1 and height 2."""
    turn, z = rng.random((2, count))
    angle = 2 * np.pi * share * turn
    points = np.column_stack([np.cos(angle), np.sin(angle), 2 * z])
    return points + noise * 3.5 * rng.standard_normal(points.shape)


def torus(rng: np.random.Generator, count: int, thin: float, noise: float = 0.0) -> Points:
    """Scatter points evenly over a torus with a ring of radius 1."""
    u, v, chance = rng.random((3, 4 * count))
    even = chance < (1 + thin * np.cos(2 * np.pi * v)) / (1 + thin)
    u, v = 2 * np.pi * u[even][:count], 2 * np.pi * v[even][:count]
    ring = 1 + thin * np.cos(v)
    points = np.column_stack([ring * np.cos(u), ring * np.sin(u), thin * np.sin(v)])
    return points + noise * 3.0 * rng.standard_normal(points.shape)


def with_outliers(rng: np.random.Generator, points: Points, share: float) -> Points:
    """Replace a share of the points, the first ones, by uniform scatter in a larger box."""
    low, size = points.min(axis=0), np.ptp(points, axis=0)
    points = points.copy()
    count = int(share * len(points))
    points[:count] = low - 0.1 * size + 1.2 * size * rng.random((count, 3))
    return points


def test_most_gross_outliers_go_and_the_surface_stays(rng: np.random.Generator) -> None:
    points = with_outliers(rng, wave(rng, 20_000, 0.005), 0.2)
    outliers = neurbs.clean(points).outliers
    assert (outliers < 4000).sum() > 0.85 * 4000
    assert (outliers >= 4000).sum() <= 0.001 * 16_000


def test_duplicates_become_weights(rng: np.random.Generator) -> None:
    points = wave(rng, 500)
    shuffled = rng.permutation(np.repeat(points, 7, axis=0))
    cleaning = neurbs.clean(shuffled)
    assert len(cleaning.kept) == 500
    assert len(cleaning.duplicates) == 3000
    np.testing.assert_array_equal(cleaning.weights, 7)
    np.testing.assert_allclose(cleaning.spacing, neurbs.clean(points).spacing)


def test_a_cleaned_cloud_does_not_depend_on_the_order(rng: np.random.Generator) -> None:
    points = with_outliers(rng, rolled(rng, 3000, 0.7, 0.002), 0.1)
    order = rng.permutation(len(points))
    kept = neurbs.clean(points).kept
    again = np.sort(order[neurbs.clean(points[order]).kept])
    np.testing.assert_array_equal(kept, again)


@pytest.mark.parametrize("noise", [0.0, 0.005, 0.02])
@pytest.mark.parametrize("share", [2 / 3, 0.9])
def test_a_cylinder_that_does_not_close_is_a_sheet(
    rng: np.random.Generator, share: float, noise: float
) -> None:
    assert neurbs.detect_topology(rolled(rng, 3000, share, noise)).kind == "sheet"


@pytest.mark.parametrize("noise", [0.0, 0.005, 0.02])
def test_a_tube_is_told_and_charted(rng: np.random.Generator, noise: float) -> None:
    topology = neurbs.detect_topology(rolled(rng, 3000, 1.0, noise))
    assert topology.kind == "tube"
    assert topology.lengths is not None
    # Ways from point to point are longer than the surface, the more so with noise.
    np.testing.assert_allclose(topology.lengths, [2 * np.pi, 2], rtol=0.15 + 8 * noise)
    lattice = topology.lattice(16, 8)
    assert lattice is not None
    assert lattice.shape == (16, 8, 3)
    angle = np.unwrap(np.arctan2(lattice[..., 1], lattice[..., 0]), axis=0)
    steps = np.diff(angle, axis=0)
    # Row by row around the axis, in one direction, in even steps; column by column along it.
    assert abs(steps.sum(axis=0) / (2 * np.pi) * 16 / 15).min() > 0.9
    assert (np.abs(steps) > 0.5 * 2 * np.pi / 16).all()
    assert (
        np.diff(lattice[..., 2], axis=1) * np.sign(lattice[0, -1, 2] - lattice[0, 0, 2])
    ).min() > 0


def test_a_bent_tube_is_told(rng: np.random.Generator) -> None:
    along, turn = np.pi * rng.random(4000), 2 * np.pi * rng.random(4000)
    ring = 1 + 0.25 * np.cos(turn)
    bent = np.column_stack([ring * np.cos(along), ring * np.sin(along), 0.25 * np.sin(turn)])
    topology = neurbs.detect_topology(bent)
    assert topology.kind == "tube"
    assert topology.uv is not None
    # v goes along the bend.
    assert topology.points is not None
    x, y = topology.points[:, 0], topology.points[:, 1]
    assert abs(np.corrcoef(topology.uv[:, 1], np.arctan2(y, x))[0, 1]) > 0.98


def around(
    rng: np.random.Generator, count: int, share: float, holes: list[tuple[float, float, float]]
) -> Points:
    """Scatter points over a share of a cylinder of height 2 but for holes.

    Their places and radii are shares of the angle and of the height.
    """
    u, v = rng.random((2, 4 * count))
    kept = np.ones(4 * count, bool)
    for along, up, radius in holes:
        kept &= np.hypot((u - along + 0.5) % 1 - 0.5, v - up) > radius
    u, v = u[kept][:count], v[kept][:count]
    angle = 2 * np.pi * share * u
    return np.column_stack([np.cos(angle), np.sin(angle), 2 * v])


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_holes_make_no_tube_of_a_bent_sheet(seed: int, noise: float) -> None:
    rng = np.random.default_rng(seed)
    points = around(rng, 1000, 0.57, [(0.3, 0.3, 0.12), (0.7, 0.6, 0.15), (0.25, 0.8, 0.08)])
    points += noise * rng.standard_normal(points.shape)
    assert neurbs.detect_topology(points).kind == "sheet"


@pytest.mark.parametrize("seed", range(4))
def test_windows_leave_a_tube_a_tube(seed: int) -> None:
    windows = [(0.15, 0.3, 0.1), (0.5, 0.5, 0.12), (0.8, 0.7, 0.08)]
    points = around(np.random.default_rng(seed), 3000, 1, windows)
    topology = neurbs.detect_topology(points)
    assert topology.kind == "tube"
    assert topology.uv is not None
    assert topology.points is not None
    # u is the angle around the axis, but for some degrees and where it begins.
    x, y = topology.points[:, 0], topology.points[:, 1]
    turn = np.exp(2j * np.pi * topology.uv[:, 0])
    likeness = [abs(np.mean(turn * (x + sense * 1j * y))) for sense in (1, -1)]
    assert max(likeness) > 0.95


@pytest.mark.parametrize("seed", range(4))
def test_a_narrow_slit_in_many_points_is_seen(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rolled(rng, 20_000, 0.95, 0.0) * [1, 1, 1.5]
    assert neurbs.detect_topology(points).kind == "sheet"


@pytest.mark.parametrize("thin", [0.2, 0.4, 0.6])
@pytest.mark.parametrize("noise", [0.0, 0.005])
def test_a_torus_is_told(rng: np.random.Generator, thin: float, noise: float) -> None:
    topology = neurbs.detect_topology(torus(rng, 3000, thin, noise))
    assert topology.kind == "torus"


def test_height_fields_are_told_with_holes_lines_and_strips(rng: np.random.Generator) -> None:
    points = wave(rng, 4000) * [1, 1, 0.3]
    hole = np.hypot(points[:, 0] - 0.5, points[:, 1] - 0.4) > 0.2
    lines = points.copy()
    lines[:, 0] = np.round(lines[:, 0] * 20) / 20
    lines[:, 2] = 0.3 * np.sin(3 * lines[:, 0]) * np.cos(2 * lines[:, 1])
    for cloud in (points, points[hole], lines, points * [1000, 1000, 1]):
        topology = neurbs.detect_topology(cloud)
        assert topology.kind == "height", topology.reason
        np.testing.assert_array_equal(topology.up, [0, 0, 1])


def test_a_closed_body_is_a_sheet_with_a_warning(rng: np.random.Generator) -> None:
    sphere = rng.standard_normal((4000, 3))
    sphere /= np.linalg.norm(sphere, axis=1)[:, None]
    topology = neurbs.detect_topology(sphere)
    assert topology.kind == "sheet"
    assert topology.warning is not None
    assert "closed" in topology.warning
    dome = sphere[sphere[:, 2] > 0]
    assert neurbs.detect_topology(dome).warning is None


def test_a_sheet_asked_for_around_a_torus_says_what_it_is(rng: np.random.Generator) -> None:
    along, around = 2 * np.pi * rng.random((2, 2000))
    radius = 1 + 0.4 * np.cos(around)
    torus = np.column_stack([radius * np.cos(along), radius * np.sin(along), 0.4 * np.sin(around)])
    with pytest.warns(neurbs.ConvergenceWarning, match="closed, .* two ways, .* ask for a torus"):
        result = neurbs.reconstruct(torus, topology="sheet")
    assert result.report.topology == "sheet"


@needs_data
@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("jacksboro_dem", "height"),
        ("claudius_h000", "height"),
        ("claudius_h060", "height"),
        ("claudius_h250", "height"),
        ("claudius_h330", "height"),
        ("am_wave_sheet", "height"),
        ("bmx_hill_2010", "height"),
        ("bmx_hill_2023", "height"),
        ("teapot_patch05", "height"),
        ("soybean_leaf", "sheet"),
        ("mediapipe_face", "sheet"),
        ("valve_leaflet1", "sheet"),
        ("valve_leaflet2", "sheet"),
        ("valve_leaflet3", "sheet"),
        ("owl_photogrammetry", "sheet"),
        ("valve_tube", "tube"),
        ("teapot_body", "tube"),
    ],
)
def test_the_kind_of_real_clouds(name: str, kind: str) -> None:
    topology = neurbs.detect_topology(real(name))
    assert topology.kind == kind, topology.reason


@needs_data
def test_nothing_is_dropped_from_real_clouds_but_strays() -> None:
    for name, most in [
        ("jacksboro_dem", 0),
        ("claudius_h330", 0),
        ("mediapipe_face", 0),
        ("yacht_hull", 0),
        ("milk_carton", 0),
        ("soybean_leaf", 10),
    ]:
        assert len(neurbs.clean(real(name)).outliers) <= most, name
    assert neurbs.pieces(real("soybean_leaf")).sizes[0] > 5900
    assert neurbs.pieces(real("yacht_hull")).sizes == [1282]


def test_an_even_sample_depends_on_the_points_alone(rng: np.random.Generator) -> None:
    points = rng.standard_normal((50_000, 3))
    whole, chunks = neurbs.EvenSample(1000), neurbs.EvenSample(1000)
    whole.extend(points)
    for chunk in np.array_split(points, 17):
        chunks.extend(chunk)
    np.testing.assert_array_equal(whole.points, chunks.points)
    np.testing.assert_array_equal(points[whole.indices], whole.points)
    assert 250 <= len(whole.points) <= 1000


def test_what_could_be_wrong_is_said(rng: np.random.Generator) -> None:
    sheet = wave(rng, 1000) * [1, 1, 0.2]
    assert neurbs.inspect(sheet) == []
    assert "different units" in neurbs.inspect(sheet * [1, 1000, 1])[0]
    assert "2 pieces" in neurbs.inspect(np.vstack([sheet, sheet[:300] + np.array([0, 0, 3])]))[0]
    other = wave(rng, 1000) * [1, 1, 0.2] + [0, 0, 0.012]
    assert "two layers" in neurbs.inspect(np.vstack([sheet, other]))[0]


def test_wild_surfaces_are_named(rng: np.random.Generator) -> None:
    sheet = wave(rng, 1000) * [1, 1, 0.2]
    surface = neurbs.fit_heights(sheet, (8, 8)).surface
    assert neurbs.inspect(sheet, surface) == []
    net = surface.control_points.copy()
    net[3, 4, 2] += 5
    bulged = neurbs.NurbsSurface(net, degree=surface.degree, knots=surface.knots)
    assert any("farther than" in words for words in neurbs.inspect(sheet, bulged))
    net = surface.control_points.copy()
    net[3, :, 0] += 0.8
    folded = neurbs.NurbsSurface(net, degree=surface.degree, knots=surface.knots)
    assert any("folds over" in words for words in neurbs.inspect(sheet, folded))


@pytest.mark.parametrize(
    "stage", [neurbs.clean, neurbs.pieces, neurbs.detect_topology, neurbs.inspect]
)
def test_bad_points_are_refused(stage: object) -> None:
    assert callable(stage)
    with pytest.raises(neurbs.NeurbsError, match="must be finite"):
        stage([[0, 0, 0], [1, 0, 0], [0, 1, np.nan], [1, 1, 0]])
    with pytest.raises(neurbs.NeurbsError, match="distinct"):
        stage([[0, 0, 0], [1, 0, 0]])


def test_progress_can_stop_it(rng: np.random.Generator) -> None:
    def stop(progress: neurbs.Progress) -> None:
        raise RuntimeError(progress.stage)

    with pytest.raises(RuntimeError, match="checking"):
        neurbs.clean(wave(rng, 50_000), progress=stop)
