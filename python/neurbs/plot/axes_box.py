"""The box that is drawn: its proportions, its axes, and where the viewer stands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neurbs.extras import require

if TYPE_CHECKING:
    from matplotlib.figure import Figure

INK, PALE = "#22313f", "#d5dade"
"""Colours of text, and of what frames the picture."""

_FLATTEST = 0.25
"""Share of the longest axis that any other is drawn at: a shorter one is exaggerated."""

_FAR = 20.0
"""Coordinates larger than this many extents are labelled from a nearer origin."""

_FILLED, _ACROSS, _UPWARDS = 0.92, 0.9, 0.78
"""Share of a square panel that its view fills, and shares of the view that the box may fill."""

_MARGINS = 0.21
"""Room for title and labels above and below the box, as a share of the panel's width."""

_ELEVATION, _AZIMUTH = np.radians([35.0, -60.0])
"""Where the viewer stands."""


@dataclass(frozen=True)
class AxesBox:
    """The box that is drawn, and how: true to scale but for the factor of each axis."""

    low: NDArray[np.float64]
    high: NDArray[np.float64]
    factor: NDArray[np.float64]

    @classmethod
    def around(cls, *points: NDArray[np.float64]) -> AxesBox:
        """AxesBox all these points."""
        low = np.min([p.min(axis=0) for p in points], axis=0)
        high = np.max([p.max(axis=0) for p in points], axis=0)
        extent = high - low
        least = _FLATTEST * extent.max()
        # A flat axis has nothing to exaggerate, but its box must have room for it.
        flat = extent < 1e-9 * extent.max()
        room = np.where(flat, least / 2, 0.02 * extent)
        factor = np.where(flat, 1.0, np.maximum(least / np.where(flat, 1.0, extent), 1.0))
        return cls(low - room, high + room, factor)

    @property
    def drawn(self) -> NDArray[np.float64]:
        """Lengths of the box's sides as they are drawn."""
        return (self.high - self.low) * self.factor

    @property
    def seen(self) -> tuple[float, float]:
        """Width and height of the box as it is seen, as shares of its diagonal."""
        across, upwards, _ = np.abs(view()) @ self.drawn / np.linalg.norm(self.drawn)
        return float(across), float(upwards)

    @property
    def height(self) -> float:
        """Height of a panel that has no empty bands, as a share of its width."""
        across, upwards = self.seen
        share = _FILLED * min(_ACROSS * upwards / across, _UPWARDS) + _MARGINS
        # In hundredths, so that pixels are whole.
        return min(float(np.ceil(100 * share)) / 100, 1.0)

    def origin(self, axis: int) -> float:
        """Return the round number that labels of an axis count from: 0 unless it is far away."""
        low, high = self.low[axis], self.high[axis]
        if max(abs(low), abs(high)) <= _FAR * (high - low):
            return 0.0
        unit = 10.0 ** np.ceil(np.log10(high - low))
        return float(np.round((low + high) / 2 / unit) * unit)

    def label(self, axis: int) -> str:
        """Name an axis, with its origin and its exaggeration: ``(z − 5,000) × 3``."""
        label, origin, factor = "xyz"[axis], self.origin(axis), self.factor[axis]
        if origin:
            label += f" {'−' if origin > 0 else '+'} {number(abs(origin))}"
        if factor > 1:
            label = f"({label}) × {factor:.2g}" if origin else f"{label} × {factor:.2g}"
        return label


def number(value: float) -> str:
    """Write a number with its thousands apart."""
    return f"{value:,.10g}".replace("-", "−")


def sample(count: int, most: int) -> NDArray[np.int64]:
    """Choose which of `count` points to show, evenly from all, the same ones each time."""
    if count <= most:
        return np.arange(count)
    return np.random.default_rng(0).choice(count, most, replace=False, shuffle=False)


def view() -> NDArray[np.float64]:
    """Find the unit vectors to the right, up, and towards the viewer, as rows."""
    sin_e, cos_e = np.sin(_ELEVATION), np.cos(_ELEVATION)
    sin_a, cos_a = np.sin(_AZIMUTH), np.cos(_AZIMUTH)
    right = [-sin_a, cos_a, 0.0]
    up = [-sin_e * cos_a, -sin_e * sin_a, cos_e]
    return np.array([right, up, [cos_e * cos_a, cos_e * sin_a, sin_e]])


def new_figure(width: float, height: float, dpi: float = 100.0) -> Figure:
    """Make a figure, in inches, that is free of pyplot: no display needed, nothing kept open."""
    require("matplotlib", "pictures")
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=dpi, facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def add_panel(
    figure: Figure, box: AxesBox, title: str, left: float = 0.0, width: float = 1.0
) -> Any:
    """Add a 3D view of the box between `left` and `left + width` of the figure."""
    height = figure.get_figheight()
    # Wider than its share and shifted to the left: labels of z stand at the right.
    wide = 1.06 * width
    side = min(height / box.height, wide * figure.get_figwidth()) / height
    # Lower than the middle: the title stands above. Where it leaves the figure, it is empty.
    rectangle = (
        left - 0.06 * width,
        0.5 - 0.03 * side - 0.5 * _FILLED * side,
        wide,
        _FILLED * side,
    )
    axes: Any = figure.add_axes(rectangle, projection="3d", computed_zorder=False)
    axes.set_proj_type("ortho")
    axes.view_init(np.degrees(_ELEVATION), np.degrees(_AZIMUTH))
    # As large as the panel allows with room for labels, in units of Matplotlib's default.
    across, upwards = box.seen
    axes.set_box_aspect(box.drawn, zoom=min(_ACROSS / across, _UPWARDS / upwards))
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
    # Matplotlib has no public way to colour the grid of one 3D axis.
    axis._axinfo["grid"].update(color="#eceff1", linewidth=0.8)
