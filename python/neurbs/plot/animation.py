"""The training of a map as an animation."""

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
from neurbs.plot.axes_box import INK, AxesBox, sample
from neurbs.plot.matplotlib_scene import draw_lines, draw_points
from neurbs.plot.panel import add_panel, new_figure

if TYPE_CHECKING:
    from neurbs import SelfOrganizingMap

_SIDE, _DPI = 6.4, 80.0
"""Side of a frame in inches, and dots per inch."""

_FRAMES_PER_SECOND = 15
_STILL_SECONDS = 1.5
"""Time for which the last frame is shown."""

_MAX_POINTS = 1_500
"""Most points in a frame."""

_TURN = 24.0
"""Rotation of the view during the animation, in degrees."""

_MAX_LATTICES = 400
"""Most lattices in memory; when there are more, every second one is removed."""


def animate(
    som: SelfOrganizingMap,
    points: ArrayLike,
    path: str | os.PathLike[str],
    *,
    seconds: float = 6.0,
) -> SelfOrganizingMap:
    """Train a map and write an animation of its lattice.

    `SelfOrganizingMap.animate` is this function.

    Parameters
    ----------
    som : SelfOrganizingMap
        The map, which is trained as by `fit`.
    points : array_like of shape (n, 3) or (n, 2)
        The points.
    path : path
        The animation: ``.gif``; ``.mp4``, which needs the program ffmpeg; or ``.html``, a page with
        buttons to stop and to step.
    seconds : float, default 6.0
        Duration of the animation.

    Returns
    -------
    SelfOrganizingMap
        The trained map.

    Raises
    ------
    NeurbsError
        If the suffix is unknown, the library for it is not installed, or `seconds` is not between 1
        and 60.
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
    ...     animation = Path(folder, "training.gif")
    ...     som = neurbs.SelfOrganizingMap(4, 4).animate(points, animation, seconds=1)
    ...     animation.read_bytes()[:6]
    b'GIF89a'
    """
    require("matplotlib", "animations")
    path = Path(path)
    if not 1 <= seconds <= 60:
        raise argument_error("seconds", f"must be between 1 and 60, got {seconds}")
    writer = _writer(path)
    points = _core.as_points(points)
    epochs, lattices = _train(som, points)
    edges = np.array(som.lattice_.edges)
    figure = new_figure(_SIDE, _SIDE, _DPI)
    box = AxesBox.around(points, *lattices)
    # The labels need room to turn.
    axes = add_panel(figure, box, "", 0.06, 0.88)
    draw_points(axes, points[sample(len(points), _MAX_POINTS)])
    lines = draw_lines(axes, lattices[0][edges], float(np.clip(24 / len(edges) ** 0.5, 0.4, 1.1)))
    caption = figure.text(0.5, 0.92, "", ha="center", size=13, color=INK)
    frames = _frames(lattices, round(seconds * _FRAMES_PER_SECOND))
    azimuth = axes.azim
    # The writers select the format by the suffix, which the path of `atomic_write` does not have.
    with TemporaryDirectory() as folder:
        animation = Path(folder, path.name)
        with writer.saving(figure, str(animation), _DPI):
            for index, (first, lattice) in enumerate(frames):
                lines.set_segments(lattice[edges])
                caption.set_text(f"epoch {epochs[first]:,} of {epochs[-1]:,}")
                axes.view_init(axes.elev, azimuth + _TURN * (index / len(frames) - 0.5))
                writer.grab_frame()
            # A page shows its last frame without copies of it.
            still = 0.0 if path.suffix.lower().startswith(".htm") else _STILL_SECONDS
            for _ in range(round(still * _FRAMES_PER_SECOND)):
                writer.grab_frame()
        with atomic_write(path) as new:
            shutil.copyfile(animation, new)
    return som


def _writer(path: Path) -> Any:
    from matplotlib import animation

    match path.suffix.lower():
        case ".gif":
            return animation.PillowWriter(fps=_FRAMES_PER_SECOND)
        case ".html" | ".htm":
            return animation.HTMLWriter(
                fps=_FRAMES_PER_SECOND, embed_frames=True, default_mode="once"
            )
        case ".mp4":
            if not animation.FFMpegWriter.isAvailable():
                raise NeurbsError(
                    f"{path}: .mp4 needs the program ffmpeg, which is not installed: "
                    "install it, or write .gif or .html"
                )
            return animation.FFMpegWriter(fps=_FRAMES_PER_SECOND)
    got = f"the suffix {path.suffix!r}" if path.suffix else "no suffix"
    raise NeurbsError(f"{path}: an animation must have the suffix .gif, .mp4 or .html, got {got}")


def _train(
    som: SelfOrganizingMap, points: NDArray[np.float64]
) -> tuple[list[int], list[NDArray[np.float64]]]:
    """Train, and return the numbers of epochs and the nodes after each, with the start as 0."""
    epochs, lattices = [0], [som.start(points).codebook_.reshape(-1, 3)]
    finished, every = 0, 1

    def keep(epoch: _core.Epoch) -> None:
        nonlocal finished, every
        finished += 1
        if finished % every == 0:
            epochs.append(finished)
            lattices.append(epoch.lattice.reshape(-1, 3))
        if len(lattices) > _MAX_LATTICES:
            del epochs[1::2], lattices[1::2]
            every *= 2

    som.resume(points, observer=keep)
    return [*epochs, finished], [*lattices, som.codebook_.reshape(-1, 3)]


def _frames(
    lattices: list[NDArray[np.float64]], count: int
) -> list[tuple[int, NDArray[np.float64]]]:
    """Interpolate a number of lattices, more of them where the nodes move more.

    Each has the index of the given lattice before it.
    """
    moves = [np.linalg.norm(b - a, axis=1).mean() for a, b in pairwise(lattices)]
    # The root, because the first moves are about a hundred times the last.
    path = np.concatenate([[0.0], np.cumsum(np.sqrt(moves))])
    places = np.interp(np.linspace(0, path[-1], count), path, np.arange(len(path)))
    frames = []
    for place in places:
        first = min(int(place), len(lattices) - 2)
        share = place - first
        # A share of 1 is the lattice after `first`.
        frames.append(
            (first + int(share == 1), (1 - share) * lattices[first] + share * lattices[first + 1])
        )
    return frames
