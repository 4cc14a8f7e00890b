"""Height fields against SciPy, and weights of control points."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import LSQBivariateSpline

import neurbs

Points = NDArray[np.float64]


def heights(rng: np.random.Generator, count: int, noise: float = 0.0) -> Points:
    x, y = rng.random((2, count))
    z = np.sin(3 * x) * np.cos(2 * y) + noise * rng.standard_normal(count)
    return np.column_stack([x, y, z])


def domain(surface: neurbs.NurbsSurface) -> Points:
    """Return the lowest and the highest corner of the rectangle that heights are over."""
    corners: Points = surface.evaluate([(0.0, 0.0), (1.0, 1.0)])[:, :2]
    return corners


def test_exact_heights_are_met_as_by_scipy(rng: np.random.Generator) -> None:
    points = heights(rng, 2000)
    found = neurbs.fit_heights(points, (12, 12))
    x, y, z = points.T
    knots = np.linspace(0, 1, 10)[1:-1]
    low, high = domain(found.surface)
    span = (low[0], high[0], low[1], high[1])
    inner = [start + knots * (end - start) for start, end in (span[:2], span[2:])]
    spline = LSQBivariateSpline(x, y, z, *inner, bbox=span, kx=3, ky=3)
    rms = np.sqrt(np.mean((spline.ev(x, y) - z) ** 2))
    assert np.sqrt(np.mean(found.residuals**2)) < 1.02 * rms
    inside = 0.05 + 0.9 * rng.random((500, 2))
    uv = (inside - low) / (high - low)
    ours = found.surface.evaluate(uv)
    # The plane's coordinates are those of the parameters, to the last digits.
    np.testing.assert_allclose(ours[:, :2], inside, atol=1e-14)
    np.testing.assert_allclose(ours[:, 2], spline.ev(*inside.T), atol=3 * rms)


def test_the_ground_ends_where_rows_do_and_beyond_scattered_points(
    rng: np.random.Generator,
) -> None:
    scattered = heights(rng, 400)
    low, high = domain(neurbs.fit_heights(scattered, (8, 8)).surface)
    size = np.ptp(scattered[:, :2], axis=0)
    np.testing.assert_allclose(low, scattered[:, :2].min(axis=0) - size / 200, atol=1e-14)
    np.testing.assert_allclose(high, scattered[:, :2].max(axis=0) + size / 200, atol=1e-14)
    x, y = np.meshgrid(np.linspace(0, 3, 20), np.linspace(-1, 1, 15))
    grid = np.column_stack([x.ravel(), y.ravel(), np.sin(x.ravel()) * y.ravel()])
    low, high = domain(neurbs.fit_heights(grid, (8, 8)).surface)
    np.testing.assert_array_equal([low, high], [(0, -1), (3, 1)])


def test_noisy_heights_are_met_better_than_by_scipy(rng: np.random.Generator) -> None:
    points = heights(rng, 400, 0.01)
    surface = neurbs.fit_heights(points, (12, 12)).surface
    x, y, z = points.T
    inner = np.linspace(0, 1, 10)[1:-1]
    spline = LSQBivariateSpline(x, y, z, inner, inner, bbox=(0, 1, 0, 1), kx=3, ky=3)
    truth = heights(rng, 2000)
    inside = truth[np.abs(truth[:, :2] - 0.5).max(axis=1) < 0.45]
    low, high = domain(surface)
    feet = (inside[:, :2] - low) / (high - low)
    own = np.sqrt(np.mean((surface.evaluate(feet)[:, 2] - inside[:, 2]) ** 2))
    other = np.sqrt(np.mean((spline.ev(inside[:, 0], inside[:, 1]) - inside[:, 2]) ** 2))
    assert own < 0.7 * other
    assert own < 0.006


def test_a_missing_quarter_is_spanned(rng: np.random.Generator) -> None:
    points = heights(rng, 3000)
    points = points[(points[:, :2] < 0.6).any(axis=1)]
    surface = neurbs.fit_heights(points, (14, 14)).surface
    z = surface.evaluate_grid(np.linspace(0, 1, 50), np.linspace(0, 1, 50))[..., 2]
    assert z.min() > points[:, 2].min() - 0.3
    assert z.max() < points[:, 2].max() + 0.3


def test_weights_let_points_go(rng: np.random.Generator) -> None:
    points = heights(rng, 1000)
    spoilt = points.copy()
    spoilt[:100, 2] += 3
    weights = np.r_[np.zeros(100), np.ones(900)]
    found = neurbs.fit_heights(spoilt, (8, 8), weights=weights)
    assert np.abs(found.residuals[100:]).max() < 2e-3


def test_any_direction_will_do(rng: np.random.Generator) -> None:
    points = heights(rng, 1500)[:, [2, 0, 1]]
    found = neurbs.fit_heights(points, (10, 10), up=(5, 0, 0))
    assert np.abs(found.residuals).max() < 1e-3
    feet = found.surface.evaluate(found.uv)
    np.testing.assert_allclose(feet[:, 1:], points[:, 1:], atol=1e-13)


@pytest.mark.parametrize("count", [60, 300, 2000])
@pytest.mark.parametrize("leaning", [False, True])
def test_heights_over_a_rectangle_are_found_however_it_lies(count: int, leaning: bool) -> None:
    rng = np.random.default_rng(count)
    x, y = rng.random((2, count)) * [[1.5], [1.0]]
    truth = np.column_stack([x, y, 0.08 * np.sin(4 * x) * np.cos(3 * y)])
    # By 35 degrees about z, and then by 50 about x.
    turn = rotation(2, 35)
    if leaning:
        turn = rotation(0, 50) @ turn
    result = neurbs.reconstruct(truth @ turn.T)
    assert result.report.topology == "height"
    assert ("(0.00, 0.00, 1.00)" in str(result.report.topology_reason)) == (not leaning)
    back = result.surface.evaluate_grid(np.linspace(0, 1, 41), np.linspace(0, 1, 41)) @ turn
    low, high = back.min(axis=(0, 1)), back.max(axis=(0, 1))
    # Over the rectangle along x and y it would cover half as much again.
    assert (low[:2] > -0.08).all()
    assert (high[:2] < [1.58, 1.08]).all()
    inner = back[4:-4, 4:-4].reshape(-1, 3)
    off = inner[:, 2] - 0.08 * np.sin(4 * inner[:, 0]) * np.cos(3 * inner[:, 1])
    assert np.abs(off).max() < 0.01


@pytest.mark.parametrize("seed", range(3))
def test_steep_heights_are_found_in_any_position(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, y = rng.random((2, 2000))
    truth = np.column_stack([x, y, steep(x, y)])
    turn = rotation(1 + seed % 2, 100) @ rotation(1, 50) @ rotation(0, 40)
    normal = np.linalg.svd(truth - truth.mean(axis=0))[2][2]
    assert abs(normal[2]) < np.cos(np.radians(15)), "they scatter least along z"
    result = neurbs.reconstruct(truth @ turn.T)
    assert result.report.topology == "height"
    places = np.linspace(0.02, 0.98, 41)
    back = (result.surface.evaluate_grid(places, places) @ turn).reshape(-1, 3)
    assert np.abs(back[:, 2] - steep(back[:, 0], back[:, 1])).max() < 0.01
    corners = result.surface.evaluate_grid([0.0, 1.0], [0.0, 1.0]).reshape(-1, 3) @ turn
    assert (np.abs(np.sort(corners[:, 0]) - [0, 0, 1, 1]) < 0.05).all()


def steep(x: Points, y: Points) -> Points:
    return 0.9 * y + 0.15 * np.sin(6 * x) * np.cos(5 * y)


def rotation(axis: int, degrees: float) -> Points:
    """Return the matrix that turns about an axis."""
    turn = np.eye(3)
    first, second = (axis + 1) % 3, (axis + 2) % 3
    cos, sin = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn[[first, second], [first, second]] = cos
    turn[first, second], turn[second, first] = -sin, sin
    return turn


@pytest.mark.parametrize("ground", ["cliff", "waves"])
def test_a_sheet_has_more_room_for_what_is_steep(ground: str) -> None:
    rng = np.random.default_rng(1)
    x, y = rng.random((2, 1000))
    if ground == "cliff":
        z = 0.2 * np.tanh(10 * (x + 0.2 * np.sin(3 * y) - 0.5))
    else:
        z = 0.25 * np.sin(6 * x) * np.cos(5 * y)
    points = np.column_stack([x, y, z + 0.001 * rng.standard_normal(1000)])
    told = neurbs.reconstruct(points, grid=(10, 10), topology="height").report
    found = neurbs.reconstruct(points, grid=(10, 10)).report
    if ground == "cliff":
        assert found.topology == "sheet"
        assert found.rms < 0.4 * told.rms
        assert "but a sheet comes nearer" in str(found.topology_reason)
    else:
        assert found.topology == "height"
        assert found.rms == told.rms


def test_heights_told_so_keep_x_and_y(rng: np.random.Generator) -> None:
    points = heights(rng, 400) @ rotation(2, 35).T
    low, high = domain(neurbs.reconstruct(points, topology="height").surface)
    assert (low < points[:, :2].min(axis=0)).all()
    assert (high > points[:, :2].max(axis=0)).all()


@pytest.mark.parametrize(("kind", "advice"), [("pipe", "ask for a tube"), ("ball", "cut it")])
def test_heights_of_what_lies_around_something_are_told_of(
    rng: np.random.Generator, kind: str, advice: str
) -> None:
    a, z = 2 * np.pi * rng.random(1000), rng.random(1000)
    points = np.column_stack([np.cos(a), np.sin(a), 4 * z])
    if kind == "ball":
        wide = 2 * np.sqrt(z - z**2)
        points = np.column_stack([wide * np.cos(a), wide * np.sin(a), 2 * z - 1])
    with pytest.warns(neurbs.ConvergenceWarning, match="lies above one another: .*" + advice):
        found = neurbs.reconstruct(points, topology="height").report
    assert found.topology == "height"
    half = points[points[:, 0 if kind == "pipe" else 2] > 0.3]
    assert neurbs.reconstruct(half, topology="height").report.warnings == ()


def test_bad_arguments_are_refused(rng: np.random.Generator) -> None:
    points = heights(rng, 50)
    for keywords, message in [
        ({"up": (0, 0, 0)}, "length 1"),
        ({"up": (0, 1)}, r"shape \(3,\)"),
        ({"weights": [1.0]}, "as many"),
        ({"fairness": -1.0}, "at least 0"),
    ]:
        with pytest.raises(neurbs.NeurbsError, match=message):
            neurbs.fit_heights(points, (5, 5), **keywords)  # type: ignore[arg-type]


def rms(surface: neurbs.NurbsSurface, points: Points) -> float:
    return float(np.sqrt(np.mean(surface.closest_points(points).distances ** 2)))


def test_round_things_are_met_by_few_control_points(rng: np.random.Generator) -> None:
    uv = rng.random((2000, 2))
    longitude, latitude = 1.2 * uv[:, 0], 1.2 * uv[:, 1] - 0.6
    plane = np.cos(latitude)
    sphere = np.column_stack(
        [plane * np.cos(longitude), plane * np.sin(longitude), np.sin(latitude)]
    )
    polynomial = neurbs.NurbsSurface.fit(sphere, uv, net=(4, 4))
    rational = neurbs.free_weights(polynomial, sphere)
    assert rational.weights is not None
    assert rms(rational, sphere) < 0.01 * rms(polynomial, sphere)


def test_free_weights_are_never_worse(rng: np.random.Generator) -> None:
    uv = rng.random((800, 2))
    wavy = np.column_stack([uv, np.sin(7 * uv[:, 0]) * uv[:, 1]])
    for noise in (0.0, 0.01):
        points = wavy + noise * rng.standard_normal(wavy.shape)
        for net in ((4, 4), (6, 5)):
            polynomial = neurbs.NurbsSurface.fit(points, uv, net=net)
            freed = neurbs.free_weights(polynomial, points)
            assert rms(freed, points) <= rms(polynomial, points)


@pytest.mark.parametrize("seed", range(3))
def test_few_heights_are_nearly_what_they_were_taken_from(seed: int) -> None:
    x, y = np.random.default_rng(seed).random((2, 60))
    result = neurbs.reconstruct(np.column_stack([x, y, bump(x, y)]))
    assert result.report.topology == "height"
    # Away from the corners, which no point may be near.
    u, v = np.meshgrid(*(np.linspace(*ends, 40)[4:-4] for ends in result.surface.domain))
    places = result.surface.evaluate(np.column_stack([u.ravel(), v.ravel()]))
    error = places[:, 2] - bump(places[:, 0], places[:, 1])
    assert np.sqrt(np.mean(error**2)) < 0.01


def test_tracks_far_apart_are_heights(rng: np.random.Generator) -> None:
    along, track = np.tile(np.linspace(0, 2, 400), 5), np.repeat(np.arange(5), 400)
    across = 0.4 * track + 0.02 * np.sin(3 * along + track)
    height = 0.2 * np.sin(2 * along) * np.cos(2 * across) + 0.001 * rng.standard_normal(2000)
    result = neurbs.reconstruct(np.column_stack([along, across, height]))
    assert result.report.topology == "height"
    assert result.report.rms < 0.002


def bump(x: Points, y: Points) -> Points:
    height: Points = 0.3 * np.sin(4 * x) * np.cos(3 * y)
    return height


def test_soundings_along_tracks_are_heights_in_their_own_unit(rng: np.random.Generator) -> None:
    """Depths in metres over degrees, along tracks in a triangle of the sea; the rest is land."""
    ends = rng.random((60, 2, 2))
    along = np.linspace(0, 1, 200)[:, None]
    places = np.concatenate([start + along * (end - start) for start, end in ends])
    places = places[places.sum(axis=1) < 1]
    waves = 0.1 * np.sin(9 * places[:, 0]) * np.cos(7 * places[:, 1])
    depths = -8000 * (1 - places.sum(axis=1) + waves)
    points = np.column_stack([8 * places[:, 0] - 118, 6 * places[:, 1] + 22, depths])
    with pytest.warns(neurbs.ConvergenceWarning, match="different units: the fit counts 1/"):
        result = neurbs.reconstruct(points)
    assert result.report.topology == "height"
    assert result.inliers.mean() > 0.95
    below = result.surface.evaluate(result.uv)[result.inliers]
    np.testing.assert_allclose(below[:, :2], points[result.inliers, :2], rtol=0, atol=1e-9)
    off = np.abs(below[:, 2] - depths[result.inliers])
    np.testing.assert_allclose(result.distances[result.inliers], off, rtol=0, atol=1e-9)
    assert np.sqrt((off**2).mean()) < 40
    u, v = np.meshgrid(np.linspace(0, 1, 60), np.linspace(0, 1, 60))
    everywhere = result.surface.evaluate(np.column_stack([u.ravel(), v.ravel()]))
    columns = [np.ones(len(points)), points[:, 0], points[:, 1]]
    plane, *_ = np.linalg.lstsq(np.column_stack(columns), depths, rcond=None)
    over = depths - np.column_stack(columns) @ plane
    far = everywhere[:, 2] - plane[0] - everywhere[:, :2] @ plane[1:]
    beyond = 0.55 * np.ptp(over)
    assert over.min() - beyond < far.min()
    assert far.max() < over.max() + beyond


def test_given_fairness_counts_as_much_whatever_tells_slopes(rng: np.random.Generator) -> None:
    points = heights(rng, 30_000, 0.01)
    result = neurbs.reconstruct(points, grid=(8, 8), topology="height", fairness=0.1)
    assert result.report.fairness == pytest.approx(0.1, rel=1e-12)


def scan(rng: np.random.Generator) -> tuple[Points, NDArray[np.bool_]]:
    """Scan a ground with houses and trees from the air; say which points lie on it."""
    x, y = 100 * rng.random((2, 12_000))
    z = relief(x, y) + 0.03 * rng.standard_normal(x.size)
    bare = np.ones(x.size, dtype=bool)
    for place in 100 * rng.random((40, 2)):
        crown = (np.hypot(*(np.column_stack([x, y]) - place).T) < 5) & (rng.random(x.size) < 0.7)
        z[crown & bare] += rng.uniform(3, 15, np.count_nonzero(crown & bare))
        bare &= ~crown
    for place in [(20, 30), (60, 70), (75, 15)]:
        roof = (np.abs(np.column_stack([x, y]) - place) < (6, 4)).all(axis=1)
        z[roof] = relief(*np.array(place, dtype=float)) + 6
        bare &= ~roof
    return np.column_stack([x, y, z]), bare


def relief(x: Points, y: Points) -> Points:
    """Return how high the ground of the scan is."""
    high: Points = 3 * np.sin(x / 30) + 2 * np.cos(y / 25)
    return high


@pytest.mark.parametrize("strays", [0, 12])
def test_trees_and_houses_stand_on_a_ground(rng: np.random.Generator, strays: int) -> None:
    points, bare = scan(rng)
    birds = rng.choice(len(points), strays, replace=False)
    points[birds, 2] += rng.uniform(20, 60, strays)
    result = neurbs.reconstruct(points)
    assert result.report.topology == "height"
    assert "a ground over x and y" in str(result.report.topology_reason)
    assert any("things stand on the ground" in warning for warning in result.report.warnings)
    # Nothing that there is to choose among.
    assert not any("layers" in warning or "pieces" in warning for warning in result.report.warnings)
    # The surface is on the ground where there is no more than that.
    alone = np.setdiff1d(np.flatnonzero(bare), birds)
    assert np.median(result.distances[alone]) < 0.3
    assert result.inliers[alone].mean() > 0.99


def test_a_cloth_that_folds_over_is_no_ground(rng: np.random.Generator) -> None:
    s, y = rng.random((2, 6000)) * [[1.4], [1.0]]
    x = np.where(s < 0.6, s, np.where(s < 0.8, 1.2 - s, s - 0.4))
    layer = np.digitize(s, [0.6, 0.8])
    for gap, noise in [(0.02, 0.0), (0.03, 0.002), (0.1, 0.002)]:
        z = gap * layer + noise * rng.standard_normal(s.size)
        found = neurbs.detect_topology(np.column_stack([x, y, z]))
        assert "ground" not in found.reason
