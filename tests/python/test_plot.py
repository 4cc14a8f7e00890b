"""Pictures: size, content, proportions; animations; notebooks."""

import re
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.image import imread
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
from numpy.typing import NDArray

import neurbs
from neurbs import NeurbsError, Reconstruction
from neurbs.choices import SurfaceColor, ViewChoice
from neurbs.deviation import Deviation
from neurbs.plot import plot_points, plot_shell, plot_surface, save_picture
from neurbs.plot.axes_box import AxesBox
from neurbs.plot.coloring import coloring
from neurbs.plot.drawn_shell import DrawnShell
from neurbs.plot.matplotlib_scene import draw_net


def labels(figure: Figure) -> list[str]:
    (_, panel) = figure.axes
    return [getattr(panel, f"get_{axis}label")() for axis in "xyz"]


def figure_of(result: Reconstruction) -> Figure:
    figure = result.plot()
    assert isinstance(figure, Figure)
    return figure


def reconstructed(points: NDArray[np.float64]) -> Reconstruction:
    return neurbs.reconstruct(points, grid=(5, 6))


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


@pytest.mark.parametrize(("axis", "extent"), [(0, 0.005), (1, 0.005), (2, 0.025)])
def test_what_is_too_flat_is_exaggerated_and_says_so(
    square: NDArray[np.float64], axis: int, extent: float
) -> None:
    scale = np.ones(3)
    scale[axis] = extent
    figure = plot_points(square * scale)
    (panel,) = figure.axes
    expected = ["x", "y", "z"]
    expected[axis] += r" × [\d.]+"
    assert all(map(re.fullmatch, expected, [getattr(panel, f"get_{x}label")() for x in "xyz"]))
    # The drawn side is a quarter of the longer ones, plus the border of the points.
    share = panel._box_aspect
    assert share.min() / share.max() == pytest.approx(0.25, rel=0.02)


@pytest.mark.parametrize(
    ("extents", "unit"), [((1, 1, 0.06), ""), ((1, 0.02, 1), ""), ((1, 1, 0.02), "mm")]
)
def test_parts_are_drawn_to_scale(
    square: NDArray[np.float64], extents: tuple[float, ...], unit: str
) -> None:
    points = square * extents
    (panel,) = plot_points(points, unit=unit).axes
    assert [getattr(panel, f"get_{x}label")() for x in "xyz"] == ["x", "y", "z"]
    extent = np.ptp(points, axis=0)
    aspect = panel._box_aspect
    np.testing.assert_allclose(aspect / aspect.max(), extent / extent.max(), rtol=1e-9)


def test_heights_are_exaggerated_by_a_given_factor(square: NDArray[np.float64]) -> None:
    (panel,) = plot_points(square * [1, 1, 0.02], exaggeration=7).axes
    assert panel.get_zlabel() == "z × 7"
    with pytest.raises(NeurbsError, match="exaggeration must be positive and finite, got 0"):
        plot_points(square, exaggeration=0)


def test_coordinates_far_away_are_labeled_from_near(result: Reconstruction) -> None:
    assert labels(figure_of(result)) == ["x − 5,000,000", "y − 7,500,000", "z"]


@pytest.mark.parametrize(
    ("low", "high"), [([0, 0, 0], [0.3, 0.3, 80_000]), ([-0.1, 0, 0], [0.2, 1, 1e-15])]
)
def test_ticks_are_short(low: list[float], high: list[float]) -> None:
    box = AxesBox.around(np.array([low, high]))
    for axis in range(3):
        ticks = [box.tick(axis, v) for v in np.linspace(low[axis], high[axis], 4) + 3.55e-17]
        assert all(len(tick) <= 12 for tick in ticks), ticks
    assert AxesBox.around(np.array([[-1, -1, -1], [1, 1, 1]])).tick(0, 3.55e-15) == "0"
    assert AxesBox.around(np.array([[-1, -1, -1], [1, 1, 1]])).tick(0, -3.55e-15) == "0"


@pytest.mark.parametrize("size", [None, (3, 3), (12, 4)])
@pytest.mark.parametrize("view", ["iso", "top", "front", "side"])
def test_no_label_is_clipped(
    view: ViewChoice, size: tuple[float, float] | None, rng: np.random.Generator
) -> None:
    # Longitude, latitude and depth: long names of axes and long numbers.
    points = rng.random((200, 3)) * [0.3, 0.3, -80_000] + [-84, 36, 0]
    figure = plot_points(points, view=view, size=size)
    figure.draw_without_rendering()
    (panel,) = figure.axes
    whole = figure.bbox
    texts = [text for axis in (panel.xaxis, panel.yaxis, panel.zaxis) for text in shown(axis)]
    assert len(texts) > 4
    for text in [*texts, *figure.texts]:
        extent = text.get_window_extent()
        assert whole.x0 <= extent.x0 < extent.x1 <= whole.x1, text
        assert whole.y0 <= extent.y0 < extent.y1 <= whole.y1, text


@pytest.mark.parametrize("size", [None, (3, 3), (4, 5), (9, 4)])
@pytest.mark.parametrize("view", ["top", "front", "side"])
def test_texts_of_axes_are_outside_of_the_box(
    view: ViewChoice, size: tuple[float, float] | None, rng: np.random.Generator
) -> None:
    figure = plot_points(rng.random((200, 3)) * [3000, 5000, 900], view=view, size=size)
    figure.draw_without_rendering()
    (panel,) = figure.axes
    axes = (panel.xaxis, panel.yaxis, panel.zaxis)
    corners = np.concatenate(
        [axis.line.get_transform().transform(axis.line.get_xydata()) for axis in axes]
    )
    (left, bottom), (right, top) = corners.min(axis=0), corners.max(axis=0)
    texts = [text for axis in axes for text in shown(axis)]
    assert len(texts) > 4
    for text in texts:
        box = text.get_window_extent()
        x, y = (box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2
        assert not (left < x < right and bottom < y < top), text
    # The name of an axis is farther out than its ticks.
    for axis in axes:
        *ticks, name = (text.get_window_extent() for text in shown(axis)) if shown(axis) else [None]
        if name is not None:
            assert not any(name.overlaps(tick) for tick in ticks), axis


@pytest.mark.parametrize("extent", [[40, 40, 60], [100, 100, 200], [30_000, 30_000, 800]])
def test_no_tick_reaches_over_that_of_another_axis(
    extent: list[float], rng: np.random.Generator
) -> None:
    # The last tick of x and the first of y are at one corner of the box.
    for low in (0, -0.5):
        figure = plot_points((rng.random((200, 3)) + low) * extent)
        figure.draw_without_rendering()
        (panel,) = figure.axes
        axes = (panel.xaxis, panel.yaxis, panel.zaxis)
        boxes = [[text.get_window_extent() for text in shown(axis)] for axis in axes]
        for k, others in enumerate(boxes):
            for box in [box for axis in boxes[:k] for box in axis]:
                assert not any(box.overlaps(other) for other in others)


def test_a_lattice_ends_at_the_box(square: NDArray[np.float64]) -> None:
    figure = plot_points(square)
    (panel,) = figure.axes
    x, y = np.meshgrid([0.2, 0.5, 0.8], [0.2, 0.5, 0.8], indexing="ij")
    net = np.stack([x, y, np.full((3, 3), 0.5)], axis=-1)
    net[0, 0] = [0.2, 0.2, 9]
    draw_net(panel, net)
    nets = [each for each in panel.collections if isinstance(each, Line3DCollection)]
    ends = np.concatenate([np.concatenate(each._segments3d) for each in nets])
    assert len(ends) == 2 * 12
    (low, high) = panel.get_zlim()
    assert ((ends[:, 2] >= low) & (ends[:, 2] <= high + 1e-12)).all()
    # The two lines to the node outside end at the top of the box, on their way.
    tops = ends[np.isclose(ends[:, 2], high)]
    share = (high - 0.5) / 8.5
    expected = [[0.2, 0.5 - 0.3 * share, high], [0.5 - 0.3 * share, 0.2, high]]
    np.testing.assert_allclose(tops[np.argsort(tops[:, 0])], expected)


def shown(axis: Any) -> list[Any]:
    """Return the texts of an axis that are drawn."""
    low, high = axis.get_view_interval()
    ticks = [tick.label1 for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
    return [text for text in [*ticks, axis.label] if text.get_text()]


def test_a_picture_has_the_size_and_the_view_that_are_given(
    square: NDArray[np.float64], tmp_path: Path
) -> None:
    figure = plot_points(square, view="top", size=(5, 3), dpi=120)
    save_picture(figure, tmp_path / "a.png")
    assert imread(tmp_path / "a.png").shape[:2] == (360, 600)
    (panel,) = figure.axes
    assert (panel.elev, panel.azim) == (90, -90)
    # The axis along the line of sight has no name.
    assert [panel.get_xlabel(), panel.get_ylabel(), panel.get_zlabel()] == ["x", "y", ""]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"view": "back"}, "view must be one of iso, top, front, side, got 'back'"),
        ({"size": (0, 3)}, r"size must be a width and a height from 1 to 100 inches, got \(0, 3\)"),
        ({"size": 3}, "size must be a width and a height .* got 3"),
        ({"dpi": 1}, "dpi must be from 10 to 2400, got 1"),
    ],
)
def test_wrong_sizes_and_views(
    options: dict[str, Any], message: str, square: NDArray[np.float64]
) -> None:
    with pytest.raises(NeurbsError, match=message):
        plot_points(square, **options)


def test_a_flat_surface_has_a_figure_of(square: NDArray[np.float64]) -> None:
    figure = figure_of(reconstructed(square * [1, 1, 0]))
    assert labels(figure) == ["x", "y", "z"]


def test_many_points_are_thinned(result: Reconstruction, rng: np.random.Generator) -> None:
    many = rng.permutation(np.repeat(result.points, 50, axis=0))
    crowd = replace(result, points=many, inliers=np.ones(len(many), bool))
    figure = figure_of(crowd)
    assert figure.texts[0].get_text().startswith("20,000 points")
    (dots,) = (c for c in figure.axes[0].collections if hasattr(c, "_offsets3d"))
    assert len(dots._offsets3d[0]) == 5000


def test_points_that_were_left_out_do_not_spoil_the_picture(result: Reconstruction) -> None:
    far = np.vstack([result.points, [[5e6, 7.5e6, -9999]]])
    figure = figure_of(replace(result, points=far, inliers=np.append(result.inliers, False)))
    assert figure.texts[0].get_text() == "400 points (1 left out), 9 × 7 lattice"
    assert figure.axes[0].get_zlim()[0] > 100  # type: ignore[attr-defined]


def test_a_surface_that_runs_away_is_drawn(square: NDArray[np.float64]) -> None:
    result = reconstructed(square)
    net = result.surface.control_points.copy()
    net[0, 0] = [1e9, -1e9, 1e9]
    wild = neurbs.NurbsSurface(net)
    assert len(facets(plot_shell(neurbs.trim(wild, result.uv[:50]), color="height"))) > 0


def test_pyplot_is_left_alone(result: Reconstruction) -> None:
    import matplotlib.pyplot as plt

    figure_of(result)
    assert plt.get_fignums() == []


# Faces


def polygons(figure: Figure) -> NDArray[np.float64]:
    """Return the corners of the drawn polygons, shape (n, 4, 3)."""
    (drawn,) = (c for c in figure.axes[-1].collections if isinstance(c, Poly3DCollection))
    return np.asarray(drawn._faces)[..., :3]


def test_a_picture_ends_where_the_face_ends(disc: Reconstruction) -> None:
    assert len(disc.face.inner) == 1
    for figure in (disc.plot(color="height"), plot_shell(disc.shell, isolines=20)):
        centers = polygons(figure).mean(axis=1)
        # Triangles, edges and isoparametric lines end within a facet of the border.
        assert np.hypot(*centers[:, :2].T).max() < 52
        assert np.hypot(centers[:, 0] - 15, centers[:, 1]).min() > 16
    title = disc.plot().texts[1].get_text()
    assert title.startswith("NURBS face with 1 hole, 6 × 6 control points")


def test_edges_are_drawn_and_the_border_of_a_shell_is_red(disc: Reconstruction) -> None:
    ink, red = to_rgba("#22313f"), to_rgba("#b3261e")
    assert (facets(disc.plot(isolines=0), panel=1) == ink).all(axis=1).sum() > 100
    assert (facets(plot_shell(disc.shell)) == red).all(axis=1).sum() > 100
    assert not (facets(plot_shell(disc.shell)) == ink).all(axis=1).any()


def test_a_shell_is_colored_by_the_deviation_from_each_face() -> None:
    floor = neurbs.NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0])
    wall = neurbs.NurbsSurface.plane([0, 0, 0], [0, 1, 0], [0, 0, 1])
    x, y = np.random.default_rng(0).uniform(0.2, 0.9, (2, 2000))
    points = np.vstack(
        [np.column_stack([x, y, 0 * x + 0.1]), np.column_stack([0 * x - 0.05, y, x])]
    )
    shell = neurbs.Shell([floor, wall])
    figure = plot_shell(shell, points, color="deviation", tolerance=0.2, unit="mm")
    assert legend(figure) == "deviation, mm (local mean)\nrms 0.0791, max 0.1"
    colors = facets(figure)
    assert (colors[:, 0] > colors[:, 2] + 0.1).sum() > 1000
    assert (colors[:, 2] > colors[:, 0] + 0.1).sum() > 1000


# Files


@pytest.mark.parametrize(("suffix", "start"), [(".svg", b"<?xml"), (".pdf", b"%PDF")])
def test_pictures_of_vectors_have_an_image_of_the_facets_only(
    suffix: str, start: bytes, result: Reconstruction, tmp_path: Path
) -> None:
    for name in ("a", "b"):
        result.save(tmp_path / f"{name}{suffix}")
    written = (tmp_path / f"a{suffix}").read_bytes()
    assert written.startswith(start)
    assert written == (tmp_path / f"b{suffix}").read_bytes()
    assert len(written) < 1_500_000


def test_a_picture_of_another_kind_is_refused(result: Reconstruction, tmp_path: Path) -> None:
    with pytest.raises(NeurbsError, match=r"must have the suffix .png, .svg, .pdf, got .* '.gif'"):
        save_picture(result.plot(), tmp_path / "a.gif")
    assert not any(tmp_path.iterdir())


# Colors and legends


def legend(figure: Figure) -> str:
    return figure.axes[-1].get_ylabel()


@pytest.fixture(scope="session")
def dome() -> neurbs.NurbsSurface:
    """Make the upper half of a sphere of radius 2."""
    sphere = neurbs.NurbsSurface.sphere([0, 0, 0], 2)
    return sphere.sub_surface(v=(0.5, 1))


def facets(figure: Figure, panel: int = 0) -> NDArray[np.float64]:
    """Return the colors of the drawn facets."""
    (drawn,) = (c for c in figure.axes[panel].collections if isinstance(c, Poly3DCollection))
    return np.asarray(drawn._facecolor3d)


@pytest.mark.parametrize(
    ("color", "label"),
    [
        ("mean", "mean curvature, 1/mm"),
        ("gaussian", "Gaussian curvature, 1/mm²"),
        ("deviation", "deviation, mm (local mean)\nrms 0.5, max 0.5"),
    ],
)
def test_legends_have_the_unit(color: SurfaceColor, label: str, dome: neurbs.NurbsSurface) -> None:
    u, v = np.random.default_rng(0).random((2, 500))
    points = 1.25 * dome.evaluate(np.column_stack([u, 0.5 + v / 2]))
    assert legend(plot_surface(dome, points, color=color, unit="mm")) == label


def test_a_deviation_has_its_sign_and_its_place(rng: np.random.Generator) -> None:
    plane = neurbs.NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0])
    x, y = rng.random((2, 3000))
    points = np.column_stack([x, y, np.where(x < 0.5, 0.2, -0.1)])
    uv = rng.random((500, 2))
    values = Deviation.of(plane, points).over_surface(plane, uv)
    np.testing.assert_allclose(values[uv[:, 0] < 0.35], 0.2)
    np.testing.assert_allclose(values[uv[:, 0] > 0.65], -0.1)
    colors = facets(plane.plot(points, isolines=0))
    red, blue = (colors[:, 0] > colors[:, 2]).mean(), (colors[:, 2] > colors[:, 0]).mean()
    assert red == pytest.approx(0.5, abs=0.05)
    assert blue == pytest.approx(0.5, abs=0.05)


def test_places_without_points_are_gray(rng: np.random.Generator) -> None:
    plane = neurbs.NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0])
    deviation = Deviation.of(plane, rng.random((3000, 3)) * [0.4, 1, 1])
    values = deviation.over_surface(plane, np.array([[0.1, 0.5], [0.9, 0.5]]))
    assert np.isfinite(values[0])
    assert np.isnan(values[1])


def test_the_scale_of_a_sphere_is_its_curvature(dome: neurbs.NurbsSurface) -> None:
    shell = neurbs.Shell(dome.sub_surface(v=(0.5, 0.9)))
    drawn = DrawnShell.of(shell, AxesBox.around(np.array(shell.bounding_box())), 20)
    scale = coloring(drawn, "gaussian")
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
    distances = result.deviations
    rms, largest = np.sqrt(np.mean(distances**2)), distances.max()
    measures = f"rms {rms:.3g}, max {largest:.3g}"
    assert legend(figure) == f"deviation, m (local mean)\n{measures}"
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


def test_pyvista_draws_it(result: Reconstruction, disc: Reconstruction) -> None:
    pyvista = pytest.importorskip("pyvista", reason="PyVista is not installed")
    pyvista.OFF_SCREEN = True
    drawn = (
        result.plot(color="deviation", backend="pyvista"),
        plot_shell(disc.shell, backend="pyvista"),
        plot_points(disc.points, view="top", backend="pyvista"),
    )
    for plotter in drawn:
        image = plotter.screenshot(return_img=True)
        plotter.close()
        assert len(np.unique(image.reshape(-1, 3), axis=0)) > 30


def test_a_window_shows_its_picture_in_notebooks(
    disc: Reconstruction, monkeypatch: pytest.MonkeyPatch
) -> None:
    pyvista = pytest.importorskip("pyvista", reason="PyVista is not installed")
    monkeypatch.setattr(pyvista, "OFF_SCREEN", False)
    on_screen = disc.plot(backend="pyvista")
    # A window would open; `show` does so.
    assert on_screen._repr_png_() is None
    on_screen.close()
    monkeypatch.setattr(pyvista.global_theme, "notebook", True)
    for plotter in (disc.plot(backend="pyvista"), plot_points(disc.points, backend="pyvista")):
        png = plotter._repr_png_()
        assert png.startswith(b"\x89PNG")
        assert plotter._repr_png_() == png
        image = plotter.screenshot(return_img=True)
        assert len(np.unique(image.reshape(-1, 3), axis=0)) > 30
        plotter.close()


def test_a_window_has_a_hole_and_the_size_that_is_given(disc: Reconstruction) -> None:
    pyvista = pytest.importorskip("pyvista", reason="PyVista is not installed")
    pyvista.OFF_SCREEN = True
    plotter = disc.plot(view="top", size=(4, 4), isolines=0, backend="pyvista")
    image = plotter.screenshot(return_img=True)
    plotter.close()
    assert image.shape[:2] == (400, 400)
    rows, cols = np.nonzero((image < 250).any(axis=2))
    middle, center = (rows.min() + rows.max()) // 2, (cols.min() + cols.max()) / 2
    # The center of the hole is at 0.3 of the radius to the right; the other side is filled.
    reach = 0.3 * np.ptp(cols) / 2
    assert (image[middle, round(center + reach)] == 255).all()
    assert (image[middle, round(center - reach)] < 250).any()


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
