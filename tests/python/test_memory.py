"""Calls that need more memory than there is: an error that says how much, and no crash."""

import subprocess
import sys
import textwrap
from collections.abc import Callable

import numpy as np
import pytest

import neurbs

LIMIT = 4 << 30
"""Address space of a process, in bytes."""

SCRIPT = """
import resource
import numpy as np
import neurbs

resource.setrlimit(resource.RLIMIT_AS, ({limit}, {limit}))
rng = np.random.default_rng(0)
surface = neurbs.NurbsSurface(rng.random((4, 4, 3)))
many = np.linspace(0.001, 0.999, 100_000)
points = rng.random((3000, 3)) * [1, 1, 0.1]
try:
    {call}
except neurbs.NeurbsMemoryError as error:
    assert isinstance(error, MemoryError) and isinstance(error, neurbs.NeurbsError)
    print(error)
assert surface.evaluate([[0.5, 0.5]]).shape == (1, 3)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="memory limits of Linux")
@pytest.mark.parametrize(
    ("call", "what"),
    [
        ("surface.insert_knots(many, many)", "a net of 100004 × 100004 control points needs"),
        (
            "surface.tessellate(1e-12, max_triangles=2**63)",
            "a mesh of about 1.0e12 triangles needs",
        ),
        ("surface.tessellate(1e-9, max_triangles=10**10)", "a mesh of about 1.0e9 triangles needs"),
        ("neurbs.fit_heights(points, net=(1000, 1000))", "the fit of 1000 × 1000 control points"),
        (
            "neurbs.NurbsSurface.fit(points, points[:, :2], net=(1000, 1000))",
            "the fit of 1000 × 1000 control points",
        ),
        (
            "neurbs.reconstruct(points, grid=(1000, 1000), aspect='fixed')",
            "the fit of 1000 × 1000 control points",
        ),
        ("neurbs.SelfOrganizingMap(4000, 4000).fit(points)", "a lattice of 4000 × 4000 nodes"),
        ("surface.evaluate_grid(many, many)", "Unable to allocate"),
    ],
)
def test_too_little_memory_is_an_error(call: str, what: str) -> None:
    script = SCRIPT.format(limit=LIMIT, call=call)
    run = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=120
    )
    assert run.returncode == 0, run.stderr
    assert what in run.stdout


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda points: neurbs.SelfOrganizingMap(10**5, 10**5).fit(points),
            r"at most 16777216 nodes in all, got \(100000, 100000\), about 5120 GB of memory",
        ),
        (
            lambda points: neurbs.reconstruct(points, grid=(2000, 2000)),
            "net must be of at most 1048576 control points, got 2000 × 2000",
        ),
    ],
)
def test_sizes_beyond_every_memory_are_refused_at_once(
    call: Callable[[object], object], message: str
) -> None:
    points = np.random.default_rng(0).random((3000, 3)) * [1, 1, 0.1]
    with pytest.raises(neurbs.NeurbsError, match=message):
        call(points)


@pytest.mark.skipif(sys.platform != "linux", reason="memory limits of Linux")
def test_fits_that_pass_the_check_fit_into_the_memory() -> None:
    script = textwrap.dedent("""
        import resource
        import numpy as np
        import neurbs

        resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30))
        points = np.random.default_rng(0).random((2000, 3)) * [1, 1, 0.1]
        done = []
        for side in range(60, 180, 20):
            try:
                neurbs.fit_heights(points, net=(side, side))
                done.append(side)
            except neurbs.NeurbsMemoryError:
                break
        print(len(done) > 0, len(done) < 6)
    """)
    run = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=120
    )
    assert (run.returncode, run.stdout.strip()) == (0, "True True"), run.stderr


@pytest.mark.parametrize("tolerance", [None, 1e-3])
def test_a_surface_without_digits_is_not_tessellated(tolerance: float | None) -> None:
    far = np.diag([100.0, 100.0, 100.0, 1.0])
    far[:3, 3] = 1e15
    net = np.random.default_rng(0).random((4, 4, 3))
    surface = neurbs.NurbsSurface(net).transformed(far)
    with pytest.raises(neurbs.NeurbsError, match=r"tolerance must be at least .* move the surface"):
        surface.tessellate(tolerance)


def test_a_net_with_more_unknowns_than_points_is_refused_at_once() -> None:
    points = np.random.default_rng(0).random((3000, 3))
    with pytest.raises(neurbs.NeurbsError, match="at least 270000 for a net of 300 × 300"):
        neurbs.recover_net(points, (300, 300))
