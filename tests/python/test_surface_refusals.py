"""Bad arguments of curves and surfaces, and the messages of their errors."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from neurbs import NeurbsError, NurbsCurve, NurbsSurface

RNG = np.random.default_rng(0)
SURFACE = NurbsSurface(RNG.random((5, 6, 3)))
CURVE = SURFACE.isocurve(u=0.3)
POINTS, UV = RNG.random((30, 3)), RNG.random((30, 2))
GRID = np.stack([*np.mgrid[0:6, 0:7], RNG.random((6, 7))], axis=-1)

REFUSALS: list[tuple[Callable[[Any], object], Any, str]] = [
    (SURFACE.insert_knots, [0.5] * 4, "0.5 has multiplicity 5"),
    (SURFACE.insert_knots, [np.nan], "in the domain"),
    (SURFACE.insert_knots, "x", "u must be real numbers"),
    (SURFACE.elevate_degree, 2**64 - 1, "at most 25 after elevation"),
    (SURFACE.elevate_degree, -1, "u must be an integer from 0"),
    (SURFACE.elevate_degree, 1.5, "u must be an integer from 0"),
    (lambda x: SURFACE.reduce_degree(x, tolerance=1), 3, "less than the degree, 3, got 3"),
    (lambda x: SURFACE.reduce_degree(1, tolerance=x), np.nan, "tolerance must be a finite"),
    (lambda x: SURFACE.reduce_degree(1, tolerance=x), 1e-9, "tolerance must be at least"),
    (lambda x: SURFACE.remove_knots(tolerance=x), -1, "tolerance must be a finite distance"),
    (lambda x: SURFACE.split(u=x), 1, "strictly inside the domain"),
    (lambda x: SURFACE.split(u=x), None, "one of u and v must be given"),
    (lambda x: SURFACE.isocurve(v=x), 1.5, "inside the domain"),
    (lambda x: SURFACE.sub_surface(u=x), (0.5, 0.5), "an increasing pair inside the domain"),
    (lambda x: SURFACE.sub_surface(u=x), 0.5, "u must be two numbers, the first and the last"),
    (lambda x: SURFACE.with_domain(v=x), [0, np.inf], "v|knot"),
    (lambda x: SURFACE.joined(SURFACE, x), "w", "direction must be 'u' or 'v'"),
    (SURFACE.joined, SURFACE, "the distance between the edges"),
    (SURFACE.transformed, np.eye(3), "matrix must be real numbers of shape"),
    (SURFACE.transformed, np.full((3, 4), np.nan), "finite"),
    (SURFACE.transformed, np.ones((4, 4)), r"matrix must end in \[0, 0, 0, 1\]"),
    (lambda x: SURFACE.area(accuracy=x), 0, "accuracy must be between"),
    (SURFACE.closest_points, [[np.nan, 0, 0]], "must be finite"),
    (SURFACE.evaluate, [[0.5]], "uv must be real numbers of shape"),
    (lambda x: SURFACE.derivatives(UV, x), 19, "order must be at most 18, got 19"),
    (CURVE.elevate_degree, -1, "times must be an integer from 0"),
    (lambda x: CURVE.derivatives([0.5], x), 10**30, "order must be an integer from 0"),
    (lambda x: CURVE.length(accuracy=x), 2, "accuracy must be between"),
    (lambda x: NurbsCurve(POINTS, degree=x), -3, "degree must be an integer from 0"),
    (lambda x: NurbsCurve(POINTS, x), np.full(30, 1e-320), "no subnormal weights"),
    (
        lambda x: NurbsCurve(x, np.full(4, 1e200)),
        np.full((4, 3), 1e200),
        "finite products of points and weights",
    ),
    (NurbsCurve, np.empty((0, 3)), "more than the degree, 3, got 0"),
    (NurbsCurve.interpolate, np.empty((0, 3)), "more than the degree, 3, got 0"),
    (NurbsCurve.interpolate, np.ones((5, 3)), "different from their neighbou?rs"),
    (lambda x: NurbsCurve.arc([0, 0, 0], [1, 0, 0], [0, 1, 0], x), 7, "a full turn"),
    (NurbsCurve.from_dict, {}, "a dict with control_points"),
    (NurbsSurface.from_dict, 7, "a dict with control_points"),
    (NurbsSurface, np.empty((0, 0, 3)), "more than the degree, 3, got 0"),
    (lambda x: NurbsSurface(GRID, knots=x), (range(10), [0] * 11), "begins and ends at 0"),
    (lambda x: NurbsSurface(GRID, degree=(1, 1), knots=x), ([0, 0, 1], [0, 1]), "4 knots|knots"),
    (lambda x: NurbsSurface(GRID, closed=True, degree=x), 6, "more than the degree, 6, got 6"),
    (lambda x: NurbsSurface.interpolate(GRID, parametrization=x), "arc", "'chord' or 'uniform'"),
    (NurbsSurface.interpolate, np.empty((0, 0, 3)), "points, at least 2 × 2"),
    (NurbsSurface.interpolate, GRID * np.nan, "grid must be finite"),
    (lambda x: NurbsSurface.approximate(GRID, x), (7, 4), "at most as large as the grid"),
    (lambda x: NurbsSurface.approximate(GRID, x), 4, "net must be two integers"),
    (lambda x: NurbsSurface.fit(POINTS, UV, net=x), (2**40, 2**40), "at most 1048576 control"),
    (lambda x: NurbsSurface.fit(POINTS, UV, net=x), (10**5, 10**5), "at most 1048576 control"),
    (lambda x: NurbsSurface.fit(POINTS, UV, net=x), None, "one of net and knots must be given"),
    (lambda x: NurbsSurface.fit(POINTS, x, net=(4, 4)), UV[:5], "as many as the points, 30, got 5"),
    (lambda x: NurbsSurface.fit(POINTS, x, net=(4, 4)), UV + 1, "uv must be inside the domain"),
    (lambda x: NurbsSurface.fit(x, UV, net=(4, 4)), POINTS * np.nan, "points must be finite"),
    (lambda x: NurbsSurface.fit(POINTS[:0], UV[:0], net=x), (4, 4), "at least one, got 0"),
    (lambda x: NurbsSurface.fit(POINTS, UV, net=(4, 4), weights=x), -np.ones(30), "at least 0"),
    (lambda x: NurbsSurface.fit(POINTS, UV, net=(4, 4), fairness=x), -1, "fairness must be"),
    (NurbsSurface.bezier, np.ones((27, 3, 3)), "degree must be between 1 and 25, got 26"),
    (NurbsSurface.lofted, [CURVE], "at least two, got 1"),
    (lambda x: NurbsSurface.ruled(CURVE, x), CURVE.with_domain(0, 2), "domain must be"),
    (
        lambda x: NurbsSurface.revolved(CURVE, [0, 0, 0], x),
        [0, 0, 0],
        "axis must be a finite vector of positive length",
    ),
    (
        lambda x: NurbsSurface.plane([0, 0, 0], x, x),
        [1, 0, 0],
        "u × v must be a finite vector of positive length",
    ),
    (lambda x: NurbsSurface.sphere([0, 0, 0], x), np.inf, "radius must be a positive length"),
]


@pytest.mark.parametrize(("call", "argument", "message"), REFUSALS, ids=lambda x: str(x)[:40])
def test_bad_arguments_are_refused(
    call: Callable[[Any], object], argument: Any, message: str
) -> None:
    with pytest.raises(NeurbsError, match=message):
        call(argument)


def test_empty_batches_have_empty_results() -> None:
    none = np.empty((0, 2))
    assert SURFACE.evaluate(none).shape == (0, 3)
    assert SURFACE.derivatives(none, 2).shape == (0, 3, 3, 3)
    assert SURFACE.curvatures(none).directions.shape == (0, 2, 3)
    assert SURFACE.normals_grid([], [0.5])[1].shape == (0, 1, 3)
    assert SURFACE.curvatures_grid([0.5], []).mean.shape == (1, 0)
    assert SURFACE.closest_points(np.empty((0, 3))).uv.shape == (0, 2)
    assert CURVE.evaluate([]).shape == (0, 3)
    assert SURFACE.insert_knots(u=[]) == SURFACE
    assert isinstance(SURFACE.elevate_degree(), NurbsSurface)


def test_arguments_of_the_wrong_kind_are_named() -> None:
    sphere = NurbsSurface.sphere([0, 0, 0], 1)
    wrong: Any = "x"
    refused: dict[str, Callable[[], object]] = {
        "u must be a number, got 'x'": lambda: sphere.split(u=wrong),
        "v must be a number, got 'x'": lambda: sphere.isocurve(v=wrong),
        "order must be an integer from 0": lambda: sphere.derivatives([[0, 0]], order=-1),
        "tolerance must be a number": lambda: sphere.remove_knots(tolerance=wrong),
        "accuracy must be a number": lambda: sphere.area(accuracy=wrong),
        "radius must be a number": lambda: NurbsSurface.sphere([0, 0, 0], wrong),
    }
    for message, call in refused.items():
        with pytest.raises(NeurbsError, match=message):
            call()


def test_knots_for_too_large_a_net_are_refused_before_memory_runs_out() -> None:
    knots = np.r_[0, np.linspace(0, 1, 2000), 1]
    with pytest.raises(NeurbsError, match="at most 1048576 control points"):
        NurbsSurface.fit([[0, 0, 0]], [[0, 0]], knots=(knots, knots), degree=1)


@pytest.mark.parametrize(
    ("make", "arguments"),
    [
        (NurbsSurface.sphere, {"radius": 1}),
        (NurbsSurface.torus, {"major": 3, "minor": 1}),
        (NurbsCurve.arc, {"x": [1, 0, 0], "y": [0, 1, 0]}),
    ],
)
def test_the_old_spelling_of_center_is_refused_with_the_new_one(
    make: Callable[..., object], arguments: dict[str, Any]
) -> None:
    make(center=[0, 0, 0], **arguments)
    with pytest.raises(TypeError, match="'center'"):
        make(centre=[0, 0, 0], **arguments)
    with pytest.raises(TypeError, match="'centre': it is now 'center'"):
        make([0, 0, 0], centre=[0, 0, 0], **arguments)
