"""The 3D axes of Matplotlib: bounding box, proportions, labels and view."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neurbs.extras import require

if TYPE_CHECKING:
    from matplotlib.figure import Figure

INK, PALE = "#22313f", "#d5dade"
"""Colors of text and of lines around the picture."""

_MIN_RATIO = 0.25
"""Smallest ratio of a drawn side to the longest; a shorter side is drawn longer."""

_FAR = 20.0
"""Coordinates larger than this many extents have labels relative to an origin near the box."""

_FILLED, _MAX_WIDTH, _MAX_HEIGHT = 0.92, 0.9, 0.78
"""Share of a square panel for the view, and largest shares of the view for the box."""

_MARGINS = 0.21
"""Height for title and labels above and below the box, as a share of the panel's width."""

_ELEVATION, _AZIMUTH = np.radians([35.0, -60.0])
"""Direction of the viewer, in radians."""


@dataclass(frozen=True)
class AxesBox:
    """A bounding box with the factor by which each of its axes is drawn longer."""

    low: NDArray[np.float64]
    high: NDArray[np.float64]
    factor: NDArray[np.float64]

    @classmethod
    def around(cls, *points: NDArray[np.float64]) -> AxesBox:
        """AxesBox all these points."""
        low = np.min([p.min(axis=0) for p in points], axis=0)
        high = np.max([p.max(axis=0) for p in points], axis=0)
        extent = high - low
        least = _MIN_RATIO * extent.max()
        # A flat axis is not drawn longer, but the box needs some extent.
        flat = extent < 1e-9 * extent.max()
        room = np.where(flat, least / 2, 0.02 * extent)
        factor = np.where(flat, 1.0, np.maximum(least / np.where(flat, 1.0, extent), 1.0))
        return cls(low - room, high + room, factor)

    @property
    def drawn(self) -> NDArray[np.float64]:
        """Lengths of the drawn sides of the box."""
        return (self.high - self.low) * self.factor

    @property
    def seen(self) -> tuple[float, float]:
        """Width and height of the box in the view, as shares of its diagonal."""
        across, upwards, _ = np.abs(view()) @ self.drawn / np.linalg.norm(self.drawn)
        return float(across), float(upwards)

    @property
    def height(self) -> float:
        """Height of a panel without empty space, as a share of its width."""
        across, upwards = self.seen
        share = _FILLED * min(_MAX_WIDTH * upwards / across, _MAX_HEIGHT) + _MARGINS
        # In hundredths, so that the number of pixels is an integer.
        return min(float(np.ceil(100 * share)) / 100, 1.0)

    def origin(self, axis: int) -> float:
        """Return the origin of the labels of an axis: 0, or a round number if the box is far."""
        low, high = self.low[axis], self.high[axis]
        if max(abs(low), abs(high)) <= _FAR * (high - low):
            return 0.0
        unit = 10.0 ** np.ceil(np.log10(high - low))
        return float(np.round((low + high) / 2 / unit) * unit)

    def label(self, axis: int) -> str:
        """Return the label of an axis with origin and factor: ``(z − 5,000) × 3``."""
        label, origin, factor = "xyz"[axis], self.origin(axis), self.factor[axis]
        if origin:
            label += f" {'−' if origin > 0 else '+'} {number(abs(origin))}"
        if factor > 1:
            label = f"({label}) × {factor:.2g}" if origin else f"{label} × {factor:.2g}"
        return label


def number(value: float) -> str:
    """Format a number with thousands separators."""
    return f"{value:,.10g}".replace("-", "−")


def sample(count: int, size: int) -> NDArray[np.int64]:
    """Return the indices of at most `size` of `count` points, random but always the same."""
    if count <= size:
        return np.arange(count)
    return np.random.default_rng(0).choice(count, size, replace=False, shuffle=False)


def view() -> NDArray[np.float64]:
    """Return the unit vectors to the right, up and toward the viewer, as rows."""
    sin_e, cos_e = np.sin(_ELEVATION), np.cos(_ELEVATION)
    sin_a, cos_a = np.sin(_AZIMUTH), np.cos(_AZIMUTH)
    right = [-sin_a, cos_a, 0.0]
    up = [-sin_e * cos_a, -sin_e * sin_a, cos_e]
    return np.array([right, up, [cos_e * cos_a, cos_e * sin_a, sin_e]])


def new_figure(width: float, height: float, dpi: float = 100.0) -> Figure:
    """Make a figure, in inches, without pyplot: it needs no display and no call to close it."""
    require("matplotlib", "pictures")
    from neurbs.plot.shown_figure import ShownFigure

    return ShownFigure(figsize=(width, height), dpi=dpi, facecolor="white")


def add_panel(
    figure: Figure, box: AxesBox, title: str, left: float = 0.0, width: float = 1.0
) -> Any:
    """Add 3D axes for the box between `left` and `left + width` of the figure."""
    height = figure.get_figheight()
    # Wider than its share and shifted to the left, as the labels of z are at the right.
    wide = 1.06 * width
    side = min(height / box.height, wide * figure.get_figwidth()) / height
    # Below the middle, as the title is above. The part outside the figure is empty.
    rectangle = (
        left - 0.06 * width,
        0.5 - 0.03 * side - 0.5 * _FILLED * side,
        wide,
        _FILLED * side,
    )
    axes: Any = figure.add_axes(rectangle, projection="3d", computed_zorder=False)
    axes.set_proj_type("ortho")
    axes.view_init(np.degrees(_ELEVATION), np.degrees(_AZIMUTH))
    # The largest zoom with room for labels, relative to Matplotlib's default.
    across, upwards = box.seen
    axes.set_box_aspect(box.drawn, zoom=min(_MAX_WIDTH / across, _MAX_HEIGHT / upwards))
    axes.set(**{f"{x}lim": limits for x, *limits in zip("xyz", box.low, box.high, strict=True)})
    for index, axis in enumerate((axes.xaxis, axes.yaxis, axes.zaxis)):
        _label(axis, box, index)
    figure.text(left + 0.48 * width, 1 - 0.07 * side, title, ha="center", size=17, color=INK)
    return axes


def _label(axis: Any, box: AxesBox, index: int) -> None:
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    origin = box.origin(index)
    axis.set_label_text(box.label(index), size=13, color=INK)
    axis.labelpad = 4 if index == 2 else 9
    ticks = 2 + 3 * box.drawn[index] / box.drawn.max()
    axis.set_major_locator(MaxNLocator(int(ticks), steps=[1, 2, 5, 10]))
    axis.set_major_formatter(FuncFormatter(lambda value, _: number(value - origin)))
    axis.set_tick_params(labelsize=11, labelcolor=INK, color=PALE, pad=2)
    axis.set_pane_color("white")
    axis.pane.set_edgecolor(PALE)
    axis.line.set_color(PALE)
    # Matplotlib has no public function for the grid color of a 3D axis.
    axis._axinfo["grid"].update(color="#eceff1", linewidth=0.8)
