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
    """Return the lower and the upper corner of the base rectangle of heights."""
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
    # The parameters are linear in x and y, up to rounding.
    np.testing.assert_allclose(ours[:, :2], inside, atol=1e-14)
    np.testing.assert_allclose(ours[:, 2], spline.ev(*inside.T), atol=3 * rms)


def test_the_base_domain_ends_with_rows_and_extends_beyond_scattered_points(
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
    uv = (inside[:, :2] - low) / (high - low)
    own = np.sqrt(np.mean((surface.evaluate(uv)[:, 2] - inside[:, 2]) ** 2))
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


def test_points_with_weight_0_are_ignored(rng: np.random.Generator) -> None:
    points = heights(rng, 1000)
    shifted = points.copy()
    shifted[:100, 2] += 3
    weights = np.r_[np.zeros(100), np.ones(900)]
    found = neurbs.fit_heights(shifted, (8, 8), weights=weights)
    assert np.abs(found.residuals[100:]).max() < 2e-3


def test_heights_along_any_direction(rng: np.random.Generator) -> None:
    points = heights(rng, 1500)[:, [2, 0, 1]]
    found = neurbs.fit_heights(points, (10, 10), up=(5, 0, 0))
    assert np.abs(found.residuals).max() < 1e-3
    fitted = found.surface.evaluate(found.uv)
    np.testing.assert_allclose(fitted[:, 1:], points[:, 1:], atol=1e-13)


def rotation(axis: int, degrees: float) -> Points:
    """Return the matrix that turns about an axis."""
    turn = np.eye(3)
    first, second = (axis + 1) % 3, (axis + 2) % 3
    cos, sin = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn[[first, second], [first, second]] = cos
    turn[first, second], turn[second, first] = -sin, sin
    return turn


def test_kind_height_keeps_x_and_y(rng: np.random.Generator) -> None:
    points = heights(rng, 400) @ rotation(2, 35).T
    result = neurbs.reconstruct(points, kind="height")
    assert result.report.direction == (0, 0, 1)
    # The rectangle is rotated with the points; the net is uniform over it, so nothing overhangs.
    knots = result.surface.knots
    u, v = (np.array([k[i + 1 : i + 4].mean() for i in range(len(k) - 4)]) for k in knots)
    flat = result.surface.control_points[..., :2]
    corner, along, across = flat[0, 0], flat[-1, 0] - flat[0, 0], flat[0, -1] - flat[0, 0]
    expected = corner + u[:, None, None] * along + v[:, None] * across
    np.testing.assert_allclose(flat, expected, atol=1e-12)
    assert abs(along @ across) < 1e-12


def test_bad_arguments_are_refused(rng: np.random.Generator) -> None:
    points = heights(rng, 50)
    for keywords, message in [
        ({"up": (0, 0, 0)}, "length 1"),
        ({"up": (0, 1)}, r"shape \(3,\)"),
        ({"weights": [1.0]}, "as many"),
        ({"fairness": -1.0}, "fairness must be from 0 to 1e12"),
    ]:
        with pytest.raises(neurbs.NeurbsError, match=message):
            neurbs.fit_heights(points, (5, 5), **keywords)  # type: ignore[arg-type]


def rms(surface: neurbs.NurbsSurface, points: Points) -> float:
    return float(np.sqrt(np.mean(surface.closest_points(points).distances ** 2)))


def test_round_shapes_need_few_control_points(rng: np.random.Generator) -> None:
    uv = rng.random((2000, 2))
    longitude, latitude = 1.2 * uv[:, 0], 1.2 * uv[:, 1] - 0.6
    plane = np.cos(latitude)
    sphere = np.column_stack(
        [plane * np.cos(longitude), plane * np.sin(longitude), np.sin(latitude)]
    )
    polynomial = neurbs.NurbsSurface.fit(sphere, uv, net=(4, 4))
    rational = neurbs.fit_weights(polynomial, sphere)
    assert rational.weights is not None
    assert rms(rational, sphere) < 0.01 * rms(polynomial, sphere)


def test_fitted_weights_are_never_worse(rng: np.random.Generator) -> None:
    uv = rng.random((800, 2))
    wavy = np.column_stack([uv, np.sin(7 * uv[:, 0]) * uv[:, 1]])
    for noise in (0.0, 0.01):
        points = wavy + noise * rng.standard_normal(wavy.shape)
        for net in ((4, 4), (6, 5)):
            polynomial = neurbs.NurbsSurface.fit(points, uv, net=net)
            freed = neurbs.fit_weights(polynomial, points)
            assert rms(freed, points) <= rms(polynomial, points)


def test_fairness_has_the_same_effect_for_any_slope_data(rng: np.random.Generator) -> None:
    points = heights(rng, 30_000, 0.01)
    result = neurbs.reconstruct(points, grid=(8, 8), kind="height", fairness=0.1)
    assert result.report.fairness == pytest.approx(0.1, rel=1e-12)
