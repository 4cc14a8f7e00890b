"""Colors of a surface: by height, deviation or curvature, or as zebra stripes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neurbs.errors import argument_error
from neurbs.plot.axes_box import INK, number, view

if TYPE_CHECKING:
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure

    from neurbs import NurbsSurface
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

    @property
    def colormap(self) -> Colormap:
        """The palette as a colormap of Matplotlib."""
        from matplotlib.colors import LinearSegmentedColormap

        return LinearSegmentedColormap.from_list("neurbs", self.palette).with_extremes(bad=NO_DATA)

    def rgba(self) -> NDArray[np.float64]:
        """Return the colors, of shape (..., 4)."""
        colors: NDArray[np.float64] = self.colormap(self._norm()(np.ma.masked_invalid(self.values)))
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
        axes: Any = figure.add_axes((left, 0.2, 0.18 / figure.get_figwidth(), 0.5))
        bar = figure.colorbar(
            ScalarMappable(self._norm(), self.colormap),
            axes,
            extend=extend,
            format=FuncFormatter(lambda value, _: number(value)),
        )
        # The unit may be any text of a file, with a $ too.
        bar.set_label(self.label, size=12, color=INK, labelpad=8, parse_math=False)
        bar.ax.tick_params(labelsize=11, labelcolor=INK, color=INK)
        bar.outline.set_visible(False)

    def _norm(self) -> Any:
        from matplotlib.colors import Normalize

        return Normalize(self.low, self.high)


def coloring(
    surface: NurbsSurface,
    u: NDArray[np.float64],
    v: NDArray[np.float64],
    color: str,
    *,
    deviation: Deviation | None = None,
    tolerance: float | None = None,
    unit: str = "",
) -> Coloring:
    """Compute the colors of a surface on a grid of parameters.

    Parameters
    ----------
    surface : NurbsSurface
        The surface.
    u, v : ndarray of shape (n_u,) and (n_v,)
        Parameters.
    color : {"height", "deviation", "mean", "gaussian", "zebra"}
        The quantity that the colors show.
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
        z = surface.evaluate_grid(u, v)[..., 2]
        return Coloring(z, z.min(), max(z.max(), z.min() + 1e-300), HEIGHTS, "")
    if color == "zebra":
        return Coloring(_stripes(surface, u, v), 0.0, 1.0, ("#15191d", "#fbfbf8"), "")
    if color == "deviation":
        if deviation is None:
            raise argument_error("color", "must not be 'deviation' without points")
        values = deviation.over_surface(surface, u, v)
        limit = tolerance or _limit(values)
        label = f"deviation, {unit or 'in the unit of the points'} (local mean)"
        return Coloring(values, -limit, limit, SIDES, label)
    if color in ("mean", "gaussian"):
        values = getattr(surface.curvatures_grid(u, v), color)
        limit, power = _limit(values), "²" if color == "gaussian" else ""
        label = f"{'Gaussian' if power else 'mean'} curvature, 1/{unit or 'unit'}{power}"
        return Coloring(values, -limit, limit, SIDES, label)
    raise argument_error("color", f"must be one of {', '.join(COLORS)}, got {color!r}")


def _limit(values: NDArray[np.float64]) -> float:
    """Return a high percentile of the absolute values, or 1 if it is 0."""
    finite = np.abs(values[np.isfinite(values)])
    limit = float(np.percentile(finite, _LIMIT_PERCENTILE)) if len(finite) else 0.0
    return limit or 1.0


def _stripes(
    surface: NurbsSurface, u: NDArray[np.float64], v: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return zebra stripes: reflected lamps, which have a kink where the tangent plane has one."""
    _, normals = surface.normals_grid(u, v)
    toward = view()[2]
    mirrored = 2 * (normals @ toward)[..., None] * normals - toward
    angle = np.arccos(np.clip(mirrored @ view()[1], -1, 1))
    # A clipped sine instead of a step gives smooth edges of the stripes.
    stripes: NDArray[np.float64] = np.clip(0.5 + 4 * np.sin(2 * _STRIPES * angle), 0, 1)
    return stripes
