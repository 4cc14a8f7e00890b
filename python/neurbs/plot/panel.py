"""Figures of Matplotlib and the panels in them, with 3D axes as large as their labels allow."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neurbs.extras import require
from neurbs.plot.axes_box import INK, PALE, AxesBox

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from neurbs.plot.picture import Picture

WIDTH, LEGEND = 8.0, 1.5
"""Widths of a panel and of a legend in inches, in a figure of the default size."""

_FILLED = 0.74
"""Share of the width of a panel for the box, if the height does not limit it."""

_MARGINS = 0.24
"""Height for title and labels above and below the box, as a share of the panel's width."""

_TITLE = 0.09
"""Height for the title, as a share of the panel's smaller side."""

_ROUNDS = 5
"""Measurements of the labels; each moves them less."""

_SMALLEST = 0.6
"""Smallest factor of the letters of long names."""

_PAD, _NAME_PAD = 8.0, 21.0
"""Distances that Matplotlib adds to those of the texts at ticks and of the name of an axis."""

_GAP = 0.35
"""Distance between texts, as a share of the size of letters."""

_BETWEEN = 0.15
"""Least distance of the texts at ticks of two axes, as a share of the size of letters."""

_EDGE = 6.0
"""Free pixels at the border of a panel."""


def new_figure(width: float, height: float, dpi: float = 100.0) -> Figure:
    """Make a figure, in inches, without pyplot: it needs no display and no call to close it."""
    require("matplotlib", "pictures")
    from neurbs.plot.shown_figure import ShownFigure

    return ShownFigure(figsize=(width, height), dpi=dpi, facecolor="white")


def figure_of_panels(
    box: AxesBox, count: int, picture: Picture, *, legend: bool
) -> tuple[Figure, float]:
    """Make a figure for panels side by side, with room for a legend at the right.

    Parameters
    ----------
    box : AxesBox
        The box of the panels.
    count : int
        Number of panels.
    picture : Picture
        The size; without one, panels have `WIDTH` and no empty space.
    legend : bool
        Whether there is a legend.

    Returns
    -------
    Figure, float
        The figure and the width of a panel, as a share of that of the figure.
    """
    parts = count * WIDTH + legend * LEGEND
    width, height = picture.size or (parts, _height(box) * WIDTH)
    return new_figure(width, height, picture.dpi), WIDTH / parts


def _height(box: AxesBox) -> float:
    """Return the height of a panel without empty space, as a share of its width."""
    across, upwards = box.seen
    # In hundredths, so that the number of pixels is an integer.
    return float(np.clip(np.ceil(100 * (_FILLED * upwards / across + _MARGINS)) / 100, 0.35, 1.0))


def panel_scale(figure: Figure, width: float = 1.0) -> float:
    """Return the scale of letters and lines in a panel; `width` is its share of the figure."""
    across, upwards = width * figure.get_figwidth(), figure.get_figheight()
    return float(np.clip(min(across, 1.6 * upwards) / WIDTH, 0.4, 1.6))


def add_panel(
    figure: Figure, box: AxesBox, title: str, left: float = 0.0, width: float = 1.0
) -> Any:
    """Add 3D axes for the box between `left` and `left + width` of the figure."""
    across, upwards = width * figure.get_figwidth(), figure.get_figheight()
    scale = panel_scale(figure, width)
    axes: Any = figure.add_axes((left, 0.0, width, 1.0), projection="3d", computed_zorder=False)
    # The axes of a panel reach behind those beside it.
    axes.patch.set_visible(False)
    axes.set_proj_type("ortho")
    axes.view_init(box.view.elevation, box.view.azimuth)
    axes.set(**{f"{x}lim": limits for x, *limits in zip("xyz", box.low, box.high, strict=True)})
    for index, axis in enumerate(_axes_of(axes)):
        _label(axis, box, index, scale)
    top = _TITLE * min(across, upwards)
    text = figure.text(
        left + width / 2,
        1 - 0.55 * top / upwards,
        title,
        ha="center",
        va="center",
        size=17 * scale,
        color=INK,
    )
    _fit(figure, axes, box, (left, width, 1 - top / upwards))
    widest = 0.96 * width * figure.bbox.width / max(text.get_window_extent().width, 1.0)
    text.set_fontsize(17 * scale * min(1.0, widest))
    return axes


def _fit(figure: Figure, axes: Any, box: AxesBox, panel: tuple[float, float, float]) -> None:
    """Zoom and move empty axes until box and labels fill a panel, without clipped labels.

    The panel has a left side, a width and a height, as shares of the figure.
    """
    width, height = figure.bbox.size
    left, across, upwards = np.array(panel) * [width, width, height]
    room = np.array([across, upwards]) - 2 * _EDGE
    side, center, zoom = max(room), np.array([left + across / 2, upwards / 2]), 1.0
    place = center
    for _ in range(_ROUNDS):
        _place(axes, box, place, side, zoom)
        figure.draw_without_rendering()
        corners = _corners(axes, box)
        extent = np.ptp(corners.reshape(-1, 2), axis=0)
        low, high = _bounds(figure, axes, corners)
        margin = high - low - extent
        zoom *= float(np.min(np.maximum(room - margin, 0.2 * room) / np.maximum(extent, 1e-9)))
        place = place + center - (low + high) / 2
        for axis in _axes_of(axes):
            _clear(figure, axes, axis)
    _place(axes, box, place, side, zoom)
    _shorten(figure, axes, box)
    _separate(axes)


def _place(axes: Any, box: AxesBox, center: NDArray[np.float64], side: float, zoom: float) -> None:
    """Give axes a square around a place of the figure, in pixels, and a zoom."""
    low, (width, height) = center - side / 2, axes.figure.bbox.size
    axes.set_position((low[0] / width, low[1] / height, side / width, side / height))
    axes.set_box_aspect(box.drawn, zoom=zoom)


def _clear(figure: Figure, axes: Any, axis: Any) -> None:
    """Move texts of an axis away from it, so that none reaches into the box or over another."""
    low, high = axis.get_view_interval()
    ticks = [tick for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
    start, end = axes.transData.transform(np.transpose(axis.line.get_data()))
    length = np.linalg.norm(end - start)
    if not ticks or length < 1:
        return
    normal = np.array([start[1] - end[1], end[0] - start[0]]) / length
    sizes = [tick.label1.get_window_extent().size for tick in ticks]
    half = max(sizes @ np.abs(normal)) / 2
    gap = _GAP * axis.label.get_size() * figure.dpi / 72
    places = axes.transData.transform([tick.label1.get_position() for tick in ticks])
    pixels = np.abs((places - start) @ normal).mean() / (ticks[0].get_pad() + _PAD)
    axis.set_tick_params(pad=0)
    # The length of a tick or 0, by the version of Matplotlib.
    included = ticks[0].get_pad()
    axis.set_tick_params(pad=(half + gap) / pixels - _PAD - included)
    letters = axis.label.get_size() * figure.dpi / 72
    axis.labelpad = (2 * half + 2 * gap + letters / 2) / pixels - _NAME_PAD


def _shorten(figure: Figure, axes: Any, box: AxesBox) -> None:
    """Give names of axes smaller letters where they are longer than the axis."""
    figure.draw_without_rendering()
    corners = _corners(axes, box)
    for index, axis in enumerate(_axes_of(axes)):
        start, end = (np.take(corners, side, axis=index)[0, 0] for side in (0, 1))
        name = axis.label
        angle = name.get_rotation()
        name.set_rotation(0)
        length = name.get_window_extent().width
        name.set_rotation(angle)
        if length > 0:
            smaller = np.clip(np.linalg.norm(end - start) / length, _SMALLEST, 1.0)
            name.set_size(name.get_size() * smaller)


def _separate(axes: Any) -> None:
    """Leave out ticks whose texts reach over those of another axis, where two axes meet."""
    taken: list[Any] = []
    for axis in _axes_of(axes):
        low, high = axis.get_view_interval()
        boxes = []
        for tick in axis.get_major_ticks():
            place = tick.get_loc()
            if not low <= place <= high or not tick.label1.get_text():
                continue
            box = tick.label1.get_window_extent().padded(_BETWEEN * tick.label1.get_size())
            if any(box.overlaps(other) for other in taken):
                axis.get_major_formatter().func.hidden.add(place)
            else:
                boxes.append(box)
        taken += boxes


def _corners(axes: Any, box: AxesBox) -> NDArray[np.float64]:
    """Return the places of the corners in pixels, shape (2, 2, 2, 2): by side along x, y, z."""
    from mpl_toolkits.mplot3d.proj3d import proj_transform

    ends = zip(box.low, box.high, strict=True)
    corners = np.stack(np.meshgrid(*ends, indexing="ij"), axis=-1).reshape(-1, 3)
    seen = np.transpose(proj_transform(*corners.T, axes.get_proj())[:2])
    places: NDArray[np.float64] = axes.transData.transform(seen)
    return places.reshape(2, 2, 2, 2)


def _bounds(
    figure: Figure, axes: Any, corners: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the bounds of labels and of the corners of the box, in pixels."""
    renderer: Any = figure.canvas
    boxes = [axis.get_tightbbox(renderer.get_renderer()) for axis in _axes_of(axes)]
    around = [corners.reshape(-1, 2), *(box.get_points() for box in boxes if box is not None)]
    places = np.concatenate(around)
    return places.min(axis=0), places.max(axis=0)


def _axes_of(axes: Any) -> tuple[Any, Any, Any]:
    return axes.xaxis, axes.yaxis, axes.zaxis


class _TickText:
    """The texts at the ticks of an axis. Functions inside others could not be pickled."""

    def __init__(self, box: AxesBox, index: int) -> None:
        self.box, self.index = box, index
        self.hidden: set[float] = set()

    def __call__(self, value: float, _place: int | None) -> str:
        """Return the text at a tick."""
        return "" if value in self.hidden else self.box.tick(self.index, value)


def _label(axis: Any, box: AxesBox, index: int, scale: float) -> None:
    from matplotlib.ticker import FuncFormatter, MaxNLocator, NullLocator

    ticks = int(2 + 3 * box.drawn[index] / box.drawn.max())
    axis.set_major_locator(MaxNLocator(ticks, steps=[1, 2, 5, 10]))
    axis.set_major_formatter(FuncFormatter(_TickText(box, index)))
    axis.set_tick_params(labelsize=11 * scale, labelcolor=INK, color=PALE, width=0.8 * scale)
    axis.set_label_text(box.label(index), size=13 * scale, color=INK)
    axis.set_pane_color("white")
    axis.pane.set_edgecolor(PALE)
    axis.line.set(color=PALE, linewidth=0.8 * scale)
    # Matplotlib has no public function for the grid color of a 3D axis.
    axis._axinfo["grid"].update(color="#eceff1", linewidth=0.8 * scale)
    if index == box.view.depth_axis:
        # The axis is a point.
        axis.set_label_text("")
        axis.set_major_locator(NullLocator())
