"""The picture: its size, what it shows, and that proportions are told."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread
from numpy.typing import NDArray

import neurbs
from neurbs import Reconstruction
from neurbs.plot import picture


def labels(figure: Figure) -> list[str]:
    (_, panel) = figure.axes
    return [getattr(panel, f"get_{axis}label")() for axis in "xyz"]


def reconstructed(points: NDArray[np.float64]) -> Reconstruction:
    return neurbs.reconstruct(points, grid=(5, 6))


@pytest.fixture
def square(rng: np.random.Generator) -> NDArray[np.float64]:
    x, y = rng.random((2, 200))
    return np.column_stack([x, y, x * y])


def test_the_file_is_a_picture(result: Reconstruction, tmp_path: Path) -> None:
    result.save(tmp_path / "a.png")
    image = imread(tmp_path / "a.png")[:, :, :3]
    assert image.shape == (800, 1600, 3)
    for panel in np.split(image, 2, axis=1):
        white = (panel == 1).all(axis=2)
        assert 0.5 < white.mean() < 0.95
        # Nothing is cut off: the margins are white.
        assert white[:, :4].all()
        assert white[[0, -1]].all()
    # Shades of a lit surface, against a few colours and their mixtures.
    numbers = (image * 255).astype(int) @ [1, 256, 65536]
    left, right = (len(np.unique(half)) for half in np.split(numbers, 2, axis=1))
    assert right > 2 * left > 200


def test_the_same_result_gives_the_same_file(result: Reconstruction, tmp_path: Path) -> None:
    for name in ("a.png", "b.png"):
        result.save(tmp_path / name)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_titles_tell_what_is_shown(result: Reconstruction) -> None:
    titles = [text.get_text() for text in picture(result).texts]
    assert titles == ["400 points, 9 × 7 lattice", "NURBS surface, 9 × 7 control points, degree 3"]


def test_true_proportions_are_not_mentioned(square: NDArray[np.float64]) -> None:
    assert labels(picture(reconstructed(square))) == ["x", "y", "z"]


@pytest.mark.parametrize("axis", range(3))
def test_a_short_axis_is_exaggerated_and_says_so(square: NDArray[np.float64], axis: int) -> None:
    scale = np.ones(3)
    scale[axis] = 0.025
    figure = picture(reconstructed(square * scale))
    expected = ["x", "y", "z"]
    expected[axis] += r" × 1[01]"
    assert all(map(re.fullmatch, expected, labels(figure)))
    shares = np.array([panel._box_aspect for panel in figure.axes])  # type: ignore[attr-defined]
    np.testing.assert_allclose(shares.min(axis=1) / shares.max(axis=1), 0.25, rtol=0.02)


def test_coordinates_far_away_are_labelled_from_near(result: Reconstruction) -> None:
    x, y, z = labels(picture(result))
    assert (x, y) == ("x − 5,000,000", "y − 7,500,000")
    assert z.startswith("z × ")


def test_a_flat_surface_has_a_picture(square: NDArray[np.float64]) -> None:
    figure = picture(reconstructed(square * [1, 1, 0]))
    assert labels(figure) == ["x", "y", "z"]


def test_many_points_are_thinned(result: Reconstruction, rng: np.random.Generator) -> None:
    crowd = replace(result, points=rng.permutation(np.repeat(result.points, 50, axis=0)))
    figure = picture(crowd)
    assert figure.texts[0].get_text().startswith("20,000 points")
    (dots,) = (c for c in figure.axes[0].collections if hasattr(c, "_offsets3d"))
    assert len(dots._offsets3d[0]) == 5000


def test_pyplot_is_left_alone(result: Reconstruction) -> None:
    import matplotlib.pyplot as plt

    picture(result)
    assert plt.get_fignums() == []
