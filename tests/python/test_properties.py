"""Properties that hold for any surface: its shape is kept, files bring it back, motion moves it."""

import importlib.util
import warnings
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import neurbs
from neurbs import NurbsSurface

Array = NDArray[np.float64]

EXACT = 1e-9
"""Share of the size by which points may move where the shape is kept."""

GRID = np.linspace(0, 1, 41)


def examples(number: int) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Try so many examples, the same in each run."""
    return settings(
        derandomize=True,
        deadline=None,
        max_examples=number,
        database=None,
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
    )


# Strategies

shares = st.floats(0, 1, allow_subnormal=False)
magnitudes = st.sampled_from([1e-3, 1e-2, 0.3, 1.0, 7.0, 1e3, 1e6])


@st.composite
def knot_vectors(draw: st.DrawFn, degree: int, count: int) -> list[float]:
    """Draw clamped knots on [0, 1], inner ones repeated at most as often as the degree."""
    inner: list[float] = []
    while len(inner) < count - degree - 1:
        knot = draw(st.integers(1, 15)) / 16
        inner += [knot] * (inner.count(knot) < degree)
    return [0.0] * (degree + 1) + sorted(inner) + [1.0] * (degree + 1)


@st.composite
def surfaces(draw: st.DrawFn, *, closed: bool | None = None) -> NurbsSurface:
    """Draw degrees 1 to 4, nets of up to 7 x 7, weights or none, directions that are closed."""
    degree = draw(st.integers(1, 4)), draw(st.integers(1, 4))
    is_closed = [draw(st.booleans()) if closed is None else closed for _ in range(2)]
    rows, cols = (
        draw(st.integers(max(p + 1, 3) if c else p + 1, 7))
        for p, c in zip(degree, is_closed, strict=True)
    )
    # A grid, or what goes around where it is closed, and shifts of up to two cells.
    i, j = np.indices((rows, cols), float)
    u, v = 2 * np.pi * i / rows, 2 * np.pi * j / cols
    width = 9 + np.cos(v) if is_closed[1] else 9 + j
    x, y = (width * np.cos(u), width * np.sin(u)) if is_closed[0] else (i, width)
    net = np.stack([x, y, 2 * np.sin(v) if is_closed[1] else j], axis=-1)
    shift = st.integers(-16, 16).map(lambda n: n / 8)
    count = rows * cols
    net += np.reshape(draw(st.lists(shift, min_size=3 * count, max_size=3 * count)), net.shape)
    net *= draw(magnitudes)
    net += draw(st.sampled_from([0.0, 1.0, 100.0])) * np.abs(net).max()
    weights = None
    if draw(st.booleans()):
        each = st.sampled_from([0.1, 0.5, 1.0, 2.0, 10.0])
        weights = np.reshape(draw(st.lists(each, min_size=count, max_size=count)), (rows, cols))
    knots = None
    if not any(is_closed) and draw(st.booleans()):
        knots = draw(knot_vectors(degree[0], rows)), draw(knot_vectors(degree[1], cols))
    return NurbsSurface(net, weights, degree, knots, closed=(is_closed[0], is_closed[1]))


@st.composite
def parameters(draw: st.DrawFn) -> Array:
    """Draw places of the unit square, its corners among them."""
    drawn = draw(st.lists(st.tuples(shares, shares), min_size=1, max_size=8))
    return np.array([*drawn, (0.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.5, 0.5)])


@st.composite
def motions(draw: st.DrawFn) -> tuple[Array, float]:
    """Draw a rotation, a scale and a move; return their matrix, and the scale."""
    quaternion = np.array(draw(st.tuples(*[st.integers(-8, 8)] * 4).filter(any)), float)
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    scale = draw(magnitudes)
    matrix = np.eye(4)
    matrix[:3, :3] = scale * (np.eye(3) + 2 * w * cross + 2 * cross @ cross)
    matrix[:3, 3] = [scale * draw(st.integers(-50, 50)) for _ in range(3)]
    return matrix, scale


# Helpers


def size(surface: NurbsSurface) -> float:
    """Return the largest coordinate, of which digits are left over."""
    return float(np.abs(surface.control_points).max())


def at(surface: NurbsSurface, uv: Array) -> Array:
    """Turn shares of the domain into parameters."""
    low, high = np.array(surface.domain).T
    # A weighted mean may be larger than both by rounding.
    result: Array = np.clip((1 - uv) * low + uv * high, low, high)
    return result


def assert_near(actual: Any, expected: Any, scale: float) -> None:
    np.testing.assert_allclose(actual, expected, rtol=0, atol=EXACT * scale)


def moved(points: Array, matrix: Array) -> Array:
    result: Array = points @ matrix[:3, :3].T + matrix[:3, 3]
    return result


# The shape is kept


@examples(60)
@given(
    surface=surfaces(),
    uv=parameters(),
    new=st.tuples(*[st.lists(st.integers(1, 30), max_size=4, unique=True)] * 2),
)
def test_knot_insertion_keeps_the_shape(
    surface: NurbsSurface, uv: Array, new: tuple[list[int], list[int]]
) -> None:
    # Places where no knot stands yet.
    u, v = (
        at(surface, np.repeat(np.array(places, float)[:, None] / 31, 2, axis=1))[:, axis]
        for axis, places in enumerate(new)
    )
    finer = surface.insert_knots(u=u, v=v)
    rows, cols = surface.control_points.shape[:2]
    assert finer.control_points.shape[:2] == (rows + len(u), cols + len(v))
    places = at(surface, uv)
    assert_near(finer.evaluate(places), surface.evaluate(places), size(surface))


@examples(60)
@given(surface=surfaces(), uv=parameters(), times=st.tuples(*[st.integers(0, 3)] * 2))
def test_degree_elevation_keeps_the_shape(
    surface: NurbsSurface, uv: Array, times: tuple[int, int]
) -> None:
    higher = surface.elevate_degree(*times)
    assert higher.degree == (surface.degree[0] + times[0], surface.degree[1] + times[1])
    places = at(surface, uv)
    assert_near(higher.evaluate(places), surface.evaluate(places), size(surface))


@examples(60)
@given(surface=surfaces(), uv=parameters(), share=st.integers(1, 63), axis=st.integers(0, 1))
def test_the_parts_of_a_split_are_the_surface(
    surface: NurbsSurface, uv: Array, share: int, axis: int
) -> None:
    cut = float(at(surface, np.full((1, 2), share / 64))[0, axis])
    parts = surface.split(u=cut) if axis == 0 else surface.split(v=cut)
    assert parts[0].domain[axis][1] == parts[1].domain[axis][0] == cut
    for part in parts:
        places = at(part, uv)
        assert_near(part.evaluate(places), surface.evaluate(places), size(surface))


@examples(40)
@given(surface=surfaces(), uv=parameters(), first=st.integers(-9, 9), length=st.integers(1, 999))
def test_another_domain_keeps_the_shape(
    surface: NurbsSurface, uv: Array, first: int, length: int
) -> None:
    other = surface.with_domain(u=(first, first + length), v=(-length, first + 1e3))
    assert other.domain == ((first, first + length), (-length, first + 1e3))
    assert_near(other.evaluate(at(other, uv)), surface.evaluate(at(surface, uv)), size(surface))


@examples(40)
@given(surface=surfaces(), uv=parameters())
def test_other_forms_keep_the_shape(surface: NurbsSurface, uv: Array) -> None:
    points = surface.evaluate(at(surface, uv))
    clamped = surface.clamped()
    assert_near(clamped.evaluate(at(clamped, uv)), points, size(surface))
    across = surface.transposed()
    assert_near(across.evaluate(at(across, uv[:, ::-1])), points, size(surface))
    back = surface.reversed(u=True, v=True)
    assert_near(back.evaluate(at(back, 1 - uv)), points, size(surface))
    assert NurbsSurface.from_dict(surface.to_dict()) == surface
    for row in surface.bezier_patches():
        for patch in row:
            places = at(patch, uv)
            assert_near(patch.evaluate(places), surface.evaluate(places), size(surface))


# Round trips

OPENCASCADE = [
    pytest.param(
        suffix,
        marks=pytest.mark.skipif(
            importlib.util.find_spec("OCP.collections") is None,
            reason="OpenCASCADE 8 needs Python 3.11",
        ),
    )
    for suffix in (".step", ".iges")
]


@pytest.mark.parametrize("suffix", OPENCASCADE)
@pytest.mark.parametrize("place", [1e7, 1e9])
def test_a_surface_far_from_the_origin_is_read_at_once(
    suffix: str, place: float, tmp_path: Path
) -> None:
    """A conversion of its edges once took longer than the limit of the reader."""
    rng = np.random.default_rng(3)
    net = np.stack([*np.indices((6, 6), float), rng.random((6, 6))], axis=-1)
    surface = NurbsSurface(net + place, rng.uniform(0.1, 10, (6, 6)))
    neurbs.save(surface, tmp_path / f"a{suffix}")
    read = neurbs.load_surface(tmp_path / f"a{suffix}")
    np.testing.assert_allclose(read.control_points, surface.control_points, rtol=1e-15)


@pytest.mark.parametrize("suffix", [".step", ".iges"])
def test_a_surface_that_is_too_small_for_cad_is_refused(suffix: str, tmp_path: Path) -> None:
    ball = NurbsSurface.sphere([0, 0, 0], 1e-8)
    with pytest.raises(neurbs.NeurbsError, match=r"must be larger than 1e-05 mm, got 3\.\de-08 mm"):
        neurbs.save(ball, tmp_path / f"a{suffix}")
    assert not list(tmp_path.iterdir())
    neurbs.save(ball, tmp_path / f"a{suffix}", unit="m")
    neurbs.save(ball, tmp_path / "a.json")


@pytest.mark.parametrize("suffix", [".json", ".3dm", *OPENCASCADE])
@examples(40)
@given(surface=surfaces())
def test_a_surface_comes_back_from_its_file(suffix: str, surface: NurbsSurface) -> None:
    with TemporaryDirectory() as folder, warnings.catch_warnings():
        # That a face is trimmed, which none is.
        warnings.simplefilter("error")
        path = Path(folder, f"a{suffix}")
        neurbs.save(surface, path)
        read = neurbs.load_surface(path)
    if suffix == ".json":
        assert read == surface
        return
    # Faces have clamped knots.
    ours = surface.clamped()
    assert read.degree == ours.degree
    for theirs, knots in zip(read.knots, ours.knots, strict=True):
        np.testing.assert_array_equal(theirs, knots)
    net = ours.control_points
    # Weights are multiplied in and divided out again.
    np.testing.assert_allclose(read.control_points, net, rtol=0, atol=4 * np.spacing(size(ours)))
    weights = [np.ones(net.shape[:2]) if s.weights is None else s.weights for s in (read, ours)]
    np.testing.assert_allclose(weights[0], weights[1], rtol=1e-15)


@pytest.mark.parametrize("suffix", OPENCASCADE)
@pytest.mark.parametrize("scale", [5e-6, 1e-4, 1e-2, 1.0, 1e4])
def test_a_whole_quadric_is_not_said_to_be_trimmed(
    suffix: str, scale: float, tmp_path: Path
) -> None:
    for surface in (
        NurbsSurface.sphere([1, 2, 3], 6.0),
        NurbsSurface.cylinder([1, 2, 3], [0, 0, 5], 2.0),
        NurbsSurface.torus([1, 2, 3], 5.0, 2.0),
        NurbsSurface.cone([1, 2, 3], [0, 0, 5], 2.0),
    ):
        matrix = np.diag([scale, scale, scale, 1.0])
        neurbs.save(surface.transformed(matrix), tmp_path / f"a{suffix}")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            neurbs.load_surface(tmp_path / f"a{suffix}")


@pytest.mark.parametrize("suffix", OPENCASCADE)
@pytest.mark.parametrize("place", [1e6, 1e9, 1e12])
def test_a_whole_cone_far_from_the_origin_is_not_said_to_be_trimmed(
    suffix: str, place: float, tmp_path: Path
) -> None:
    cone = NurbsSurface.cone([place, place, place], [0, 0, 5], 2.0)
    neurbs.save(cone, tmp_path / f"a{suffix}")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        neurbs.load_surface(tmp_path / f"a{suffix}")


@pytest.mark.parametrize("suffix", OPENCASCADE)
def test_a_whole_surface_with_kinks_is_not_said_to_be_trimmed(suffix: str, tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    for _ in range(10):
        net = np.stack([*np.indices((4, 7), float), np.zeros((4, 7))], axis=-1)
        surface = NurbsSurface(net + rng.uniform(-2, 2, net.shape), degree=1)
        neurbs.save(surface, tmp_path / f"a{suffix}")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            neurbs.load_surface(tmp_path / f"a{suffix}")


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".off", ".vtp", ".glb", ".stl"])
@examples(15)
@given(surface=surfaces(), shape=st.tuples(*[st.integers(2, 5)] * 2))
def test_vertices_come_back_from_their_file(
    suffix: str, surface: NurbsSurface, shape: tuple[int, int]
) -> None:
    mesh = surface.tessellate(shape=shape)
    with TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        path = Path(folder, f"a{suffix}")
        neurbs.save(mesh, path)
        read = neurbs.read_points(path)
    vertices = mesh.vertices
    single = float(np.finfo(np.float32).eps)
    if suffix == ".stl":
        # In any order, each once: what is nearest to each must be near, both ways.
        apart = np.abs(vertices[:, None] - read[None]).max(axis=-1)
        near = single * np.abs(vertices).max()
        assert apart.min(axis=1)[np.unique(mesh.triangles)].max() <= near
        assert apart.min(axis=0).max() <= near
    elif suffix == ".glb":
        # Counted in single precision from their center, which has all digits.
        near = single * np.ptp(vertices, axis=0).max() + 4 * np.spacing(np.abs(vertices).max())
        np.testing.assert_allclose(read, vertices, rtol=0, atol=near)
    else:
        np.testing.assert_array_equal(read, vertices)


@pytest.mark.parametrize("suffix", [".ply", ".csv"])
@examples(40)
@given(
    points=st.lists(
        st.tuples(*[st.floats(-1e300, 1e300, allow_subnormal=False)] * 3), min_size=1, max_size=30
    ),
    has_normals=st.booleans(),
    has_colors=st.booleans(),
)
def test_points_come_back_from_their_file(
    suffix: str, points: list[tuple[float, float, float]], has_normals: bool, has_colors: bool
) -> None:
    count = len(points)
    normals = np.tile([0.0, 0.0, -1.0], (count, 1)) if has_normals else None
    colors = (np.arange(3 * count).reshape(-1, 3) % 256).astype(np.uint8) if has_colors else None
    cloud = neurbs.PointCloud(np.array(points), normals, colors)
    with TemporaryDirectory() as folder:
        path = Path(folder, f"a{suffix}")
        neurbs.save(cloud, path)
        read = neurbs.read_point_cloud(path)
    for name in ("points", "normals", "colors"):
        np.testing.assert_array_equal(getattr(read, name), getattr(cloud, name))


# Closest points


@examples(30)
@given(
    surface=surfaces(),
    places=st.lists(st.tuples(*[st.integers(-12, 12)] * 3), min_size=1, max_size=6),
)
def test_no_sample_is_closer_than_the_closest_point(
    surface: NurbsSurface, places: list[tuple[int, int, int]]
) -> None:
    low, high = surface.bounding_box(tight=False)
    extent = float(np.linalg.norm(high - low))
    points = (low + high) / 2 + extent * np.array(places) / 10
    found = surface.closest_points(points)
    assert_near(surface.evaluate(found.uv), found.points, size(surface))
    assert_near(np.linalg.norm(points - found.points, axis=1), found.distances, size(surface))
    sample = surface.evaluate_grid(*(at(surface, np.column_stack([GRID, GRID])).T))
    apart = np.linalg.norm(points[:, None] - sample.reshape(1, -1, 3), axis=-1)
    assert (found.distances <= apart.min(axis=1) + EXACT * size(surface)).all()


# Motions


@examples(40)
@given(surface=surfaces(), uv=parameters(), motion=motions())
def test_evaluation_follows_a_motion(
    surface: NurbsSurface, uv: Array, motion: tuple[Array, float]
) -> None:
    matrix, _ = motion
    places = at(surface, uv)
    other = surface.transformed(matrix)
    assert_near(other.evaluate(places), moved(surface.evaluate(places), matrix), size(other))


@examples(25)
@given(
    surface=surfaces(),
    motion=motions(),
    places=st.lists(st.tuples(*[st.integers(-12, 12)] * 3), min_size=1, max_size=6),
)
def test_distances_follow_a_motion(
    surface: NurbsSurface, motion: tuple[Array, float], places: list[tuple[int, int, int]]
) -> None:
    matrix, scale = motion
    low, high = surface.bounding_box(tight=False)
    points = (low + high) / 2 + np.linalg.norm(high - low) * np.array(places) / 10
    other = surface.transformed(matrix)
    found, again = surface.closest_points(points), other.closest_points(moved(points, matrix))
    # Digits are left over from the larger of the sizes, the move's included.
    largest = max(size(other), scale * size(surface))
    assert_near(again.distances, scale * found.distances, largest)


@examples(25)
@given(surface=surfaces(), motion=motions())
def test_the_area_follows_a_motion(surface: NurbsSurface, motion: tuple[Array, float]) -> None:
    matrix, scale = motion
    area, other = surface.area(), surface.transformed(matrix)
    # Each may be wrong by its accuracy; rounded coordinates add a share of their size.
    rounding = 1e-13 * max(size(other), scale * size(surface)) * scale * np.sqrt(area)
    assert abs(other.area() - scale**2 * area) <= 3e-9 * scale**2 * area + rounding


@examples(25)
@given(surface=surfaces(), motion=motions(), power=st.integers(-20, 20))
def test_the_deviation_of_a_mesh_follows_a_motion(
    surface: NurbsSurface, motion: tuple[Array, float], power: int
) -> None:
    low, high = surface.bounding_box()
    tolerance = 0.02 * float(np.linalg.norm(high - low))
    mesh = surface.tessellate(tolerance)
    assert mesh.max_deviation is not None
    # No digit changes when all numbers are multiplied by a power of two.
    larger = NurbsSurface(
        2.0**power * surface.control_points, surface.weights, surface.degree, surface.knots
    ).tessellate(2.0**power * tolerance)
    assert larger.max_deviation == 2.0**power * mesh.max_deviation
    np.testing.assert_array_equal(larger.triangles, mesh.triangles)
    # The bound depends on the axes a little, so that a turned surface may get other triangles.
    matrix, scale = motion
    other = surface.transformed(matrix)
    turned = other.tessellate(scale * tolerance)
    assert turned.max_deviation is not None
    sample = other.evaluate_grid(*(at(other, np.column_stack([GRID, GRID])).T))
    apart = turned.deviation(sample.reshape(-1, 3)).max()
    assert apart <= turned.max_deviation + EXACT * size(other)
    assert turned.max_deviation <= scale * tolerance
