"""Parameters of points on a map for surface fits, and the time scales of the paper's settings."""

import numpy as np

from neurbs import NurbsSurface, SelfOrganizingMap


def test_a_map_s_parameters_fit_a_surface() -> None:
    x, y = np.random.default_rng(0).random((2, 3000))
    points = np.column_stack([x, y, np.sin(3 * x) * y])
    for topology, closed in (("sheet", False), ("tube", (True, False))):
        if topology == "tube":
            points = np.column_stack([np.cos(6.2831853 * x), np.sin(6.2831853 * x), 3 * y])
        som = SelfOrganizingMap(16, 12, topology="tube" if topology == "tube" else "sheet").fit(
            points
        )
        uv = som.parametrize(points)
        assert uv.min() >= 0
        assert uv.max() <= 1
        surface = NurbsSurface.fit(points, uv, net=(16, 12), closed=closed)
        assert surface.closest_points(points).distances.max() < 0.03
        assert som.parametrize(points, extrapolation=0).min() == 0


def test_the_special_presentation_takes_two_thirds_of_the_steps() -> None:
    steps = {"skip-reached": 0, "random": 0}
    for seed in range(5):
        x, y = np.random.default_rng(seed).random((2, 40))
        points = np.column_stack([x, y, 0.5 * np.sin(3 * x) * y])
        special = SelfOrganizingMap.paper(points, presentation="skip-reached", seed=seed)
        original = SelfOrganizingMap.paper(points, seed=seed)
        steps["skip-reached"] += special.fit(points).n_iter_
        steps["random"] += original.fit(points).n_iter_
        assert special.stopped_by_ == "reached"
        assert special.reached_ >= 38
    assert steps["skip-reached"] <= 2 / 3 * steps["random"]
