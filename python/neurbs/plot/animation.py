"""The training as a film: how the lattice unfolds."""

from __future__ import annotations

import os
import shutil
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs import _core
from neurbs._core import NeurbsError
from neurbs.errors import argument_error
from neurbs.extras import require
from neurbs.io.atomic_write import atomic_write
from neurbs.plot.axes_box import INK, AxesBox, add_panel, new_figure, sample
from neurbs.plot.matplotlib_scene import draw_lines, draw_points

if TYPE_CHECKING:
    from neurbs import SelfOrganizingMap

_SIDE, _DPI = 6.4, 80.0
"""Inches, and dots an inch: 512 × 512 pixels."""

_FRAMES_A_SECOND = 15
_STILL = 1.5
"""Seconds for which the last frame stands."""

_MOST_POINTS = 1_500
"""Points shown: each of them is in each frame."""

_TURN = 24.0
"""Degrees by which the view turns, so that depth is seen."""

_MOST_KEPT = 400
"""Lattices kept at most; from a longer training, every other one is left out again and again."""


def animate(
    som: SelfOrganizingMap,
    points: ArrayLike,
    path: str | os.PathLike[str],
    *,
    seconds: float = 6.0,
) -> SelfOrganizingMap:
    """Train a map and write how its lattice unfolds; `SelfOrganizingMap.animate` is this function.

    Parameters
    ----------
    som : SelfOrganizingMap
        The map; it learns the points as `fit` does.
    points : array_like of shape (n, 3) or (n, 2)
        The points.
    path : path
        The film: ``.gif``; ``.mp4``, which needs the program ffmpeg; or ``.html``, a page with
        buttons to stop and to step.
    seconds : float, default 6.0
        How long the film is.

    Returns
    -------
    SelfOrganizingMap
        The trained map.

    Raises
    ------
    NeurbsError
        If the suffix is none of these, what writes it is not installed, or `seconds` is not
        between 1 and 60.
    OSError
        If the file cannot be written.

    Examples
    --------
    >>> import numpy as np
    >>> import neurbs
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> points = np.random.default_rng(0).random((100, 3))
    >>> with TemporaryDirectory() as folder:
    ...     film = Path(folder, "training.gif")
    ...     som = neurbs.SelfOrganizingMap(4, 4).animate(points, film, seconds=1)
    ...     film.read_bytes()[:6]
    b'GIF89a'
    """
    require("matplotlib", "films")
    path = Path(path)
    if not 1 <= seconds <= 60:
        raise argument_error("seconds", f"must be between 1 and 60, got {seconds}")
    writer = _writer(path)
    points = _core.as_points(points)
    epochs, lattices = _train(som, points)
    edges = np.array(som.lattice_.edges)
    figure = new_figure(_SIDE, _SIDE, _DPI)
    box = AxesBox.around(points, *lattices)
    axes = add_panel(figure, box, "", 0.0, 0.95)
    draw_points(axes, points[sample(len(points), _MOST_POINTS)])
    lines = draw_lines(axes, lattices[0][edges], float(np.clip(24 / len(edges) ** 0.5, 0.4, 1.1)))
    caption = figure.text(0.5, 0.92, "", ha="center", size=13, color=INK)
    frames = _frames(lattices, round(seconds * _FRAMES_A_SECOND))
    azimuth = axes.azim
    # The writers know their format by the suffix, which a file beside its place has not.
    with TemporaryDirectory() as folder:
        film = Path(folder, path.name)
        with writer.saving(figure, str(film), _DPI):
            for index, (first, lattice) in enumerate(frames):
                lines.set_segments(lattice[edges])
                caption.set_text(f"epoch {epochs[first]:,} of {epochs[-1]:,}")
                axes.view_init(axes.elev, azimuth + _TURN * (index / len(frames) - 0.5))
                writer.grab_frame()
            # A page stands still by itself, at the price of no frame.
            still = 0.0 if path.suffix.lower().startswith(".htm") else _STILL
            for _ in range(round(still * _FRAMES_A_SECOND)):
                writer.grab_frame()
        with atomic_write(path) as new:
            shutil.copyfile(film, new)
    return som


def _writer(path: Path) -> Any:
    from matplotlib import animation

    match path.suffix.lower():
        case ".gif":
            return animation.PillowWriter(fps=_FRAMES_A_SECOND)
        case ".html" | ".htm":
            return animation.HTMLWriter(
                fps=_FRAMES_A_SECOND, embed_frames=True, default_mode="once"
            )
        case ".mp4":
            if not animation.FFMpegWriter.isAvailable():
                raise NeurbsError(
                    f"{path}: .mp4 needs the program ffmpeg, which is not installed: "
                    "install it, or write .gif or .html"
                )
            return animation.FFMpegWriter(fps=_FRAMES_A_SECOND)
    got = f"the suffix {path.suffix!r}" if path.suffix else "no suffix"
    raise NeurbsError(f"{path}: a film is written as .gif .mp4 .html, got {got}")


def _train(
    som: SelfOrganizingMap, points: NDArray[np.float64]
) -> tuple[list[int], list[NDArray[np.float64]]]:
    """Train, and return the nodes before it and after epochs, with the epochs' numbers."""
    epochs, lattices = [0], [som.start(points).codebook_.reshape(-1, 3)]
    finished, every = 0, 1

    def keep(epoch: _core.Epoch) -> None:
        nonlocal finished, every
        finished += 1
        if finished % every == 0:
            epochs.append(finished)
            lattices.append(epoch.lattice.reshape(-1, 3))
        if len(lattices) > _MOST_KEPT:
            del epochs[1::2], lattices[1::2]
            every *= 2

    som.resume(points, observer=keep)
    return [*epochs, finished], [*lattices, som.codebook_.reshape(-1, 3)]


def _frames(
    lattices: list[NDArray[np.float64]], count: int
) -> list[tuple[int, NDArray[np.float64]]]:
    """Choose lattices between those that are known, slowly where much happens.

    Each comes with the number of the known one before it.
    """
    moves = [np.linalg.norm(b - a, axis=1).mean() for a, b in pairwise(lattices)]
    # The root: the first moves are a hundred times the last, which should be seen, too.
    way = np.concatenate([[0.0], np.cumsum(np.sqrt(moves))])
    places = np.interp(np.linspace(0, way[-1], count), way, np.arange(len(way)))
    frames = []
    for place in places:
        first = min(int(place), len(lattices) - 2)
        share = place - first
        # What is shown at the end is the last one.
        frames.append(
            (first + int(share == 1), (1 - share) * lattices[first] + share * lattices[first + 1])
        )
    return frames
