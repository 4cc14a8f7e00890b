"""Colors of a surface: by height, deviation or curvature, or as zebra stripes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neurbs.errors import argument_error
from neurbs.plot.axes_box import INK, number
from neurbs.plot.drawn_shell import DrawnShell
from neurbs.plot.panel import LEGEND
from neurbs.plot.standard_view import VIEWS, View

if TYPE_CHECKING:
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure

    from neurbs.deviation import Deviation

COLORS = ("height", "deviation", "mean", "gaussian", "zebra")
"""Quantities that the colors of a surface show."""

HEIGHTS = ("#2c6e63", "#5e9b74", "#a9bd80", "#e0d09c", "#d0a274", "#f3ede3")
SIDES = ("#123f7a", "#3f83bd", "#a9cde2", "#f4f3ee", "#f3bd92", "#d76a3c", "#8f1d14")
"""Palettes from low to high; `SIDES`, for signed values, is pale in the middle."""

NO_DATA = "#c3c8cc"
"""Color of places without points near."""

_STRIPES = 9
"""Dark zebra stripes between a reflection straight up and straight down."""

_LIMIT_PERCENTILE = 99.0
"""Percentile of the absolute values at the ends of a scale."""


@dataclass(frozen=True, eq=False)
class Coloring:
    """Values on a surface, and the scale that maps them to colors."""

    values: NDArray[np.float64]
    low: float
    high: float
    palette: tuple[str, ...]
    label: str
    """Title of the legend; empty for no legend."""
    is_lit: bool = True
    """Whether facets toward the light are brighter."""

    @property
    def colormap(self) -> Colormap:
        """The palette as a colormap of Matplotlib."""
        from matplotlib.colors import LinearSegmentedColormap

        return LinearSegmentedColormap.from_list("neurbs", self.palette).with_extremes(bad=NO_DATA)

    def rgba(self, corners: NDArray[np.int64] | None = None) -> NDArray[np.float64]:
        """Return the colors of the values, or of their means at corners of facets: (..., 4)."""
        values = self.values if corners is None else self.values[corners].mean(axis=1)
        share = np.clip((values - self.low) / (self.high - self.low), 0, 1)
        stops = np.array([_rgb(color) for color in self.palette]).T
        places = np.linspace(0, 1, len(self.palette))
        colors = np.ones((*values.shape, 4))
        colors[..., :3] = np.stack([np.interp(share, places, stop) for stop in stops], axis=-1)
        colors[np.isnan(values), :3] = _rgb(NO_DATA)
        return colors

    def add_legend(self, figure: Figure, left: float) -> None:
        """Draw the scale as a bar at the right of a panel, if it has a label."""
        from matplotlib.cm import ScalarMappable
        from matplotlib.ticker import FuncFormatter

        if not self.label:
            return
        values = self.values[np.isfinite(self.values)]
        beyond = (bool((values < self.low).any()), bool((values > self.high).any()))
        extend = ("neither", "max", "min", "both")[2 * beyond[0] + beyond[1]]
        strip = 1 - left
        scale = float(np.clip(strip * figure.get_figwidth() / LEGEND, 0.4, 1.6))
        axes: Any = figure.add_axes((left, 0.2, 0.12 * strip, 0.6))
        bar = figure.colorbar(
            ScalarMappable(self._norm(), self.colormap),
            axes,
            extend=extend,
            format=FuncFormatter(_tick),
        )
        bar.ax.tick_params(labelsize=11 * scale, labelcolor=INK, color=INK)
        # The unit may be any text of a file, with a $ too.
        bar.set_label(self.label, size=12 * scale, color=INK, labelpad=8 * scale, parse_math=False)
        bar.outline.set_visible(False)
        # Long numbers get smaller letters.
        figure.draw_without_rendering()
        drawn, room = axes.get_tightbbox(), 0.97 * strip * figure.bbox.width
        smaller = min(1.0, room / drawn.width, 0.96 * figure.bbox.height / drawn.height)
        bar.ax.tick_params(labelsize=11 * scale * smaller)
        bar.ax.yaxis.label.set_fontsize(12 * scale * smaller)

    def _norm(self) -> Any:
        from matplotlib.colors import Normalize

        return Normalize(self.low, self.high)


def coloring(
    drawn: DrawnShell,
    color: str,
    *,
    view: View = VIEWS["iso"],
    deviation: Deviation | None = None,
    tolerance: float | None = None,
    unit: str = "",
) -> Coloring:
    """Compute the colors of a shell at the vertices of its triangles.

    Parameters
    ----------
    drawn : DrawnShell
        The triangles.
    color : {"height", "deviation", "mean", "gaussian", "zebra"}
        The quantity that the colors show.
    view : View
        The direction of the viewer, for the color ``"zebra"``.
    deviation : Deviation, optional
        The deviation of points, for the color ``"deviation"``.
    tolerance : float, optional
        The deviation at the ends of the scale; by default the 99th percentile of the shown values.
    unit : str, default ""
        Name of the points' unit.

    Raises
    ------
    NeurbsError
        If `color` is unknown, `tolerance` is not positive, or `deviation` is missing.
    """
    if tolerance is not None and not 0 < tolerance < np.inf:
        raise argument_error("tolerance", f"must be positive and finite, got {tolerance}")
    if color == "height":
        z = drawn.vertices[:, 2]
        return Coloring(z, z.min(), max(z.max(), z.min() + 1e-300), HEIGHTS, "")
    if color == "zebra":
        return Coloring(
            _stripes(drawn.normals(), view), 0.0, 1.0, ("#15191d", "#fbfbf8"), "", is_lit=False
        )
    values = np.empty(len(drawn.vertices))
    if color == "deviation":
        if deviation is None:
            raise argument_error("color", "must not be 'deviation' without points")
        for index, (face, on_face) in enumerate(drawn.by_face()):
            values[on_face] = deviation.over_surface(face.surface, drawn.uv[on_face], index)
        limit = tolerance or _limit(values)
        rms, largest = (number(float(f"{x:.3g}")) for x in (deviation.rms, deviation.max))
        measures = f"rms {rms}, max {largest}"
        label = f"deviation, {unit or 'in the unit of the points'} (local mean)\n{measures}"
        return Coloring(values, -limit, limit, SIDES, label)
    if color in ("mean", "gaussian"):
        for face, on_face in drawn.by_face():
            # The mean curvature has the sign of the side of the normal.
            sign = -1.0 if face.is_reversed and color == "mean" else 1.0
            values[on_face] = sign * getattr(face.surface.curvatures(drawn.uv[on_face]), color)
        limit, power = _limit(values), "²" if color == "gaussian" else ""
        label = f"{'Gaussian' if power else 'mean'} curvature, 1/{unit or 'unit'}{power}"
        return Coloring(values, -limit, limit, SIDES, label)
    raise argument_error("color", f"must be one of {', '.join(COLORS)}, got {color!r}")


def _tick(value: float, _place: int) -> str:
    """Return the text at a tick of a legend."""
    return number(value)


def _rgb(color: str) -> list[float]:
    """Return red, green and blue, from 0 to 1, of a color such as ``"#c3c8cc"``."""
    return [int(color[start : start + 2], 16) / 255 for start in (1, 3, 5)]


def _limit(values: NDArray[np.float64]) -> float:
    """Return a high percentile of the absolute values, or 1 if it is 0."""
    finite = np.abs(values[np.isfinite(values)])
    limit = float(np.percentile(finite, _LIMIT_PERCENTILE)) if len(finite) else 0.0
    return limit or 1.0


def _stripes(normals: NDArray[np.float64], view: View) -> NDArray[np.float64]:
    """Return zebra stripes: reflected lamps, which have a kink where the tangent plane has one."""
    _, up, toward = view.axes
    mirrored = 2 * (normals @ toward)[..., None] * normals - toward
    angle = np.arccos(np.clip(mirrored @ up, -1, 1))
    # A clipped sine instead of a step gives smooth edges of the stripes.
    stripes: NDArray[np.float64] = np.clip(0.5 + 4 * np.sin(2 * _STRIPES * angle), 0, 1)
    return stripes
