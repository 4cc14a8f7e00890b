"""Pictures: size, content, proportions; animations; notebooks."""

import re
import shutil
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
from numpy.typing import NDArray

import neurbs
from neurbs import NeurbsError, Reconstruction
from neurbs.choices import SurfaceColor
from neurbs.deviation import Deviation
from neurbs.plot import plot_surface
from neurbs.plot.coloring import coloring


def labels(figure: Figure) -> list[str]:
    (_, panel) = figure.axes
    return [getattr(panel, f"get_{axis}label")() for axis in "xyz"]


def figure_of(result: Reconstruction) -> Figure:
    figure = result.plot()
    assert isinstance(figure, Figure)
    return figure


def reconstructed(points: NDArray[np.float64]) -> Reconstruction:
    return neurbs.reconstruct(points, grid=(5, 6))


@pytest.fixture
def square(rng: np.random.Generator) -> NDArray[np.float64]:
    x, y = rng.random((2, 200))
    return np.column_stack([x, y, x * y])


def test_the_file_is_a_figure_of(result: Reconstruction, tmp_path: Path) -> None:
    result.save(tmp_path / "a.png")
    image = imread(tmp_path / "a.png")[:, :, :3]
    assert image.shape[1:] == (1600, 3)
    # The hills are flat, so the picture is low.
    assert 600 < len(image) < 700
    for panel in np.split(image, 2, axis=1):
        white = (panel == 1).all(axis=2)
        assert 0.5 < white.mean() < 0.95
        # Nothing is cut off: the margins are white.
        assert white[:, :4].all()
        assert white[[0, -1]].all()
    # A lit surface has many shades.
    numbers = (image * 255).astype(int) @ [1, 256, 65536]
    left, right = (len(np.unique(half)) for half in np.split(numbers, 2, axis=1))
    assert right > 2 * left > 200


def test_the_same_result_gives_the_same_file(result: Reconstruction, tmp_path: Path) -> None:
    for name in ("a.png", "b.png"):
        result.save(tmp_path / name)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_titles_name_the_content(result: Reconstruction) -> None:
    titles = [text.get_text() for text in figure_of(result).texts]
    assert titles == ["400 points, 9 × 7 lattice", "NURBS surface, 9 × 7 control points, degree 3"]


def test_true_proportions_are_not_mentioned(square: NDArray[np.float64]) -> None:
    assert labels(figure_of(reconstructed(square))) == ["x", "y", "z"]


@pytest.mark.parametrize("axis", range(3))
def test_a_short_axis_is_exaggerated_and_says_so(square: NDArray[np.float64], axis: int) -> None:
    scale = np.ones(3)
    scale[axis] = 0.025
    figure = figure_of(reconstructed(square * scale))
    expected = ["x", "y", "z"]
    # The drawn side is a quarter of the longer ones, plus the border of the surface.
    expected[axis] += r" × [\d.]+"
    assert all(map(re.fullmatch, expected, labels(figure)))
    shares = np.array([panel._box_aspect for panel in figure.axes])  # type: ignore[attr-defined]
    np.testing.assert_allclose(shares.min(axis=1) / shares.max(axis=1), 0.25, rtol=0.02)


def test_coordinates_far_away_are_labeled_from_near(result: Reconstruction) -> None:
    x, y, z = labels(figure_of(result))
    assert (x, y) == ("x − 5,000,000", "y − 7,500,000")
    assert z.startswith("z × ")


def test_a_flat_surface_has_a_figure_of(square: NDArray[np.float64]) -> None:
    figure = figure_of(reconstructed(square * [1, 1, 0]))
    assert labels(figure) == ["x", "y", "z"]


def test_many_points_are_thinned(result: Reconstruction, rng: np.random.Generator) -> None:
    crowd = replace(result, points=rng.permutation(np.repeat(result.points, 50, axis=0)))
    figure = figure_of(crowd)
    assert figure.texts[0].get_text().startswith("20,000 points")
    (dots,) = (c for c in figure.axes[0].collections if hasattr(c, "_offsets3d"))
    assert len(dots._offsets3d[0]) == 5000


def test_pyplot_is_left_alone(result: Reconstruction) -> None:
    import matplotlib.pyplot as plt

    figure_of(result)
    assert plt.get_fignums() == []


# Colors and legends


def legend(figure: Figure) -> str:
    return figure.axes[-1].get_ylabel()


@pytest.fixture(scope="session")
def dome() -> neurbs.NurbsSurface:
    """Make the upper half of a sphere of radius 2."""
    sphere = neurbs.NurbsSurface.sphere([0, 0, 0], 2)
    return sphere.sub_surface(v=(0.5, 1))


def facets(figure: Figure) -> NDArray[np.float64]:
    """Return the colors of the drawn facets."""
    (drawn,) = (c for c in figure.axes[0].collections if isinstance(c, Poly3DCollection))
    return np.asarray(drawn._facecolor3d)


@pytest.mark.parametrize(
    ("color", "label"),
    [
        ("mean", "mean curvature, 1/mm"),
        ("gaussian", "Gaussian curvature, 1/mm²"),
        ("deviation", "deviation, mm (local mean)"),
    ],
)
def test_legends_have_the_unit(color: SurfaceColor, label: str, dome: neurbs.NurbsSurface) -> None:
    u, v = np.random.default_rng(0).random((2, 500))
    points = dome.evaluate(np.column_stack([u, 0.5 + v / 2]))
    assert legend(plot_surface(dome, points, color=color, unit="mm")) == label


def test_a_deviation_has_its_sign_and_its_place(rng: np.random.Generator) -> None:
    plane = neurbs.NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0])
    x, y = rng.random((2, 3000))
    points = np.column_stack([x, y, np.where(x < 0.5, 0.2, -0.1)])
    t = np.linspace(0.05, 0.95, 10)
    values = Deviation.of(plane, points).over_surface(plane, t, t)
    np.testing.assert_allclose(values[:3], 0.2)
    np.testing.assert_allclose(values[-3:], -0.1)
    colors = facets(plane.plot(points, isolines=0))
    red, blue = (colors[:, 0] > colors[:, 2]).mean(), (colors[:, 2] > colors[:, 0]).mean()
    assert red == pytest.approx(0.5, abs=0.05)
    assert blue == pytest.approx(0.5, abs=0.05)


def test_places_without_points_are_gray(rng: np.random.Generator) -> None:
    plane = neurbs.NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0])
    deviation = Deviation.of(plane, rng.random((3000, 3)) * [0.4, 1, 1])
    values = deviation.over_surface(plane, np.array([0.1, 0.9]), np.array([0.5]))
    assert np.isfinite(values[0, 0])
    assert np.isnan(values[1, 0])


def test_the_scale_of_a_sphere_is_its_curvature(dome: neurbs.NurbsSurface) -> None:
    t = np.linspace(0.1, 0.9, 9)
    scale = coloring(dome, t, 0.5 + t / 2, "gaussian")
    np.testing.assert_allclose(scale.values, 0.25, rtol=1e-6)
    assert scale.high == pytest.approx(0.25)


def test_stripes_are_black_and_white(dome: neurbs.NurbsSurface) -> None:
    colors = facets(dome.plot(color="zebra", isolines=0))
    dark, bright = (colors[:, 0] < 0.2).mean(), (colors[:, 0] > 0.9).mean()
    assert dark > 0.2
    assert bright > 0.2


def test_the_control_net_is_drawn(dome: neurbs.NurbsSurface) -> None:
    without, with_net = (
        len(plot_surface(dome, control_net=wanted).axes[0].collections) for wanted in (False, True)
    )
    assert with_net == without + 2


def test_a_result_shows_its_deviation(result: Reconstruction) -> None:
    figure = result.plot(color="deviation", unit="m", tolerance=0.5)
    assert legend(figure) == "deviation, m (local mean)"
    assert figure.axes[-1].get_ylim() == (-0.5, 0.5)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"color": "red"}, "color must be one of height, deviation, .*, got 'red'"),
        ({"color": "deviation"}, "color must not be 'deviation' without points"),
        ({"tolerance": 0.0}, "tolerance must be positive and finite, got 0"),
        ({"tolerance": np.nan}, "tolerance must be positive and finite, got nan"),
        ({"backend": "vtk"}, "backend must be 'matplotlib' or 'pyvista', got 'vtk'"),
    ],
)
def test_wrong_options_of_a_picture(
    options: dict[str, Any], message: str, dome: neurbs.NurbsSurface
) -> None:
    with pytest.raises(NeurbsError, match=message):
        dome.plot(**options)


def test_a_library_that_is_missing_is_named(
    dome: neurbs.NurbsSurface, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(NeurbsError, match=re.escape("pip install 'neurbs[view]'")):
        dome.plot(backend="pyvista")


def test_pyvista_draws_it(result: Reconstruction) -> None:
    pyvista = pytest.importorskip("pyvista", reason="PyVista is not installed")
    pyvista.OFF_SCREEN = True
    plotter = result.plot(color="deviation", backend="pyvista")
    image = plotter.screenshot(return_img=True)
    plotter.close()
    assert len(np.unique(image.reshape(-1, 3), axis=0)) > 100


# Maps


def test_a_map_is_drawn_with_its_edges(result: Reconstruction) -> None:
    figure = result.som.plot(result.points)
    (lines,) = (c for c in figure.axes[0].collections if isinstance(c, Line3DCollection))
    assert len(lines._segments3d) == 9 * 6 + 8 * 7


def test_cells_are_colored(result: Reconstruction) -> None:
    assert legend(result.som.plot(color="u-matrix")) == "mean distance to the neighbors"
    assert legend(result.som.plot(result.points, color="hits")) == "points nearest to a node"
    with pytest.raises(NeurbsError, match="color must not be 'hits' without points"):
        result.som.plot(color="hits")
    with pytest.raises(NeurbsError, match="color must be one of u-matrix, hits, got 'height'"):
        result.som.plot(color="height")  # type: ignore[arg-type]


def test_a_graph_is_drawn(square: NDArray[np.float64]) -> None:
    ring = neurbs.Lattice.graph(20, [(i, (i + 1) % 20) for i in range(20)])
    som = neurbs.SelfOrganizingMap(lattice=ring).fit(square)
    assert som.plot().texts[0].get_text() == "20 nodes"
    with pytest.raises(NeurbsError, match="color must be None for a graph"):
        som.plot(color="u-matrix")


# Animations


@pytest.mark.parametrize(
    ("suffix", "start"), [(".gif", b"GIF89a"), (".html", b"\n<link"), (".mp4", b"\0\0\0")]
)
def test_an_animation_is_written(
    suffix: str, start: bytes, square: NDArray[np.float64], tmp_path: Path
) -> None:
    if suffix == ".mp4" and shutil.which("ffmpeg") is None:
        pytest.skip("ffmpeg is not installed")
    animation = tmp_path / f"animation{suffix}"
    som = neurbs.SelfOrganizingMap(4, 3)
    assert som.animate(square, animation, seconds=1) is som
    assert animation.read_bytes().startswith(start)
    assert list(tmp_path.iterdir()) == [animation]
    np.testing.assert_array_equal(
        som.codebook_, neurbs.SelfOrganizingMap(4, 3).fit(square).codebook_
    )


def test_the_lattice_unfolds_in_the_animation(square: NDArray[np.float64], tmp_path: Path) -> None:
    from PIL import Image

    som = neurbs.SelfOrganizingMap(6, 6, init="centroid")
    som.animate(square, tmp_path / "a.gif", seconds=1)
    with Image.open(tmp_path / "a.gif") as animation:
        first = np.array(animation.convert("RGB"))
        animation.seek(14)
        last = np.array(animation.convert("RGB"))
        with pytest.raises(EOFError):
            animation.seek(15)  # The last frame is shown for longer instead.
        assert animation.size == (512, 512)

    def width(image: NDArray[np.uint8]) -> float:
        """Return the extent of the blue lattice."""
        red, _, blue = np.moveaxis(image.astype(int), 2, 0)
        return float(np.nonzero(blue - red > 60)[1].std())

    assert width(last) > 2 * width(first)


@pytest.mark.parametrize(
    ("name", "seconds", "message"),
    [
        (
            "a.avi",
            2,
            "an animation must have the suffix .gif, .* got the suffix '.avi'",
        ),
        ("a", 2, "got no suffix"),
        ("a.gif", 0, "seconds must be between 1 and 60, got 0"),
    ],
)
def test_animations_that_are_refused(
    name: str, seconds: float, message: str, square: NDArray[np.float64], tmp_path: Path
) -> None:
    with pytest.raises(NeurbsError, match=message):
        neurbs.SelfOrganizingMap(3, 3).animate(square, tmp_path / name, seconds=seconds)
    assert not any(tmp_path.iterdir())


def test_an_animation_without_ffmpeg(
    square: NDArray[np.float64], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("matplotlib.animation.FFMpegWriter.isAvailable", lambda: False)
    with pytest.raises(NeurbsError, match=r"\.mp4 needs the program ffmpeg"):
        neurbs.SelfOrganizingMap(3, 3).animate(square, tmp_path / "a.mp4")


# Notebooks


def test_results_have_html_for_notebooks(result: Reconstruction) -> None:
    shown: list[tuple[Any, list[str]]] = [
        (result, ["Reconstruction", "400", "control points"]),
        (result.surface, ["NurbsSurface", "net 9 × 7"]),
        (result.som, ["SelfOrganizingMap", "steps"]),
    ]
    for thing, words in shown:
        page = thing._repr_html_()
        assert all(word in page for word in words)
        assert "data:image/png;base64," in page
        assert len(page) < 400_000
    assert "data:" not in neurbs.SelfOrganizingMap(3, 3)._repr_html_()


def test_without_matplotlib_there_is_a_table(
    result: Reconstruction, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    assert "<table>" in result._repr_html_()
    assert "<img" not in result._repr_html_()
