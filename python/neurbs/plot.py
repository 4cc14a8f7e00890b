"""The picture of a result, like the paper's Figure 1: points and lattice, and the surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from neurbs import NurbsSurface, Reconstruction

_SIZE, _DPI = (16.0, 8.0), 100.0
"""Inches, and dots an inch: 1600 × 800 pixels."""

_MOST_POINTS = 5_000
"""Points shown with the lattice: more would be a solid mass."""

_FEW_POINTS = 300
"""Points shown on the surface: enough to see how near it passes."""

_FACETS = 140
"""Facets shown along each side of the surface: a few pixels each."""

_ISOLINES = 20
"""Isoparametric lines shown across the longer direction of the surface."""

_FLATTEST = 0.25
"""Share of the longest axis that any other is drawn at: a shorter one is exaggerated."""

_FAR = 20.0
"""Coordinates larger than this many extents are labelled from a nearer origin."""

_ELEVATION, _AZIMUTH = np.radians([35.0, -60.0])
"""Where the viewer stands."""

_LIGHT = np.array([-0.62, -0.18, 0.76])
"""Direction towards the light: from the viewer's left, and from above."""

_INK, _PALE, _NET, _POINT = "#22313f", "#d5dade", "#1d5b86", "#e2572b"
_HEIGHTS = ("#2c6e63", "#5e9b74", "#a9bd80", "#e0d09c", "#d0a274", "#f3ede3")


def picture(result: Reconstruction) -> Figure:
    """Draw the points with the trained lattice over them, and beside them the surface.

    Proportions are true, except that an axis shorter than a quarter of the longest, as the
    height of terrain is, is drawn as long as that quarter and labelled with the factor.

    Parameters
    ----------
    result : Reconstruction
        What `neurbs.reconstruct` returned.

    Returns
    -------
    matplotlib.figure.Figure
        16 by 8 inches. It is free of pyplot: it needs no display, and nothing keeps it open.

    Examples
    --------
    >>> import numpy as np
    >>> import neurbs
    >>> from neurbs.plot import picture
    >>> x, y = np.random.default_rng(0).random((2, 200))
    >>> result = neurbs.reconstruct(np.column_stack([x, y, x * y]), grid=(6, 6))
    >>> [panel.get_zlabel() for panel in picture(result).axes]
    ['z', 'z']
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=_SIZE, dpi=_DPI, facecolor="white")
    FigureCanvasAgg(figure)
    frame = _Frame.around(result.points, result.mesh.vertices)
    if result.som is None:
        lattice = result.points.reshape(*result.report.grid, 3)
    else:
        lattice = result.som.codebook_
    title = f"{len(result.points):,} points, {_size(lattice)} lattice"
    _draw_lattice(_panel(figure, 0, frame, title), lattice, result.points)
    surface = result.surface
    u, v = surface.degree
    degree = f"degree {u}" if u == v else f"degrees {u} and {v}"
    title = f"NURBS surface, {_size(surface.control_points)} control points, {degree}"
    _draw_surface(_panel(figure, 1, frame, title), frame, surface, result.points)
    return figure


def write_png(result: Reconstruction, path: str) -> None:
    """Write the `picture` of a result as an image of 1600 × 800 pixels."""
    picture(result).savefig(path, format="png", dpi=_DPI)


@dataclass(frozen=True)
class _Frame:
    """The box that is drawn, and how: true to scale but for the factor of each axis."""

    low: NDArray[np.float64]
    high: NDArray[np.float64]
    factor: NDArray[np.float64]

    @classmethod
    def around(cls, *points: NDArray[np.float64]) -> _Frame:
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


def _size(grid: NDArray[np.float64]) -> str:
    return " × ".join(map(str, grid.shape[:2]))


def _number(value: float) -> str:
    return f"{value:,.10g}".replace("-", "−")


def _sample(points: NDArray[np.float64], most: int) -> NDArray[np.float64]:
    """Choose points evenly from all of them, the same ones each time."""
    if len(points) <= most:
        return points
    return np.random.default_rng(0).choice(points, most, replace=False, shuffle=False)


def _view() -> NDArray[np.float64]:
    """Find the unit vectors to the right, up, and towards the viewer, as rows."""
    sin_e, cos_e = np.sin(_ELEVATION), np.cos(_ELEVATION)
    sin_a, cos_a = np.sin(_AZIMUTH), np.cos(_AZIMUTH)
    right = [-sin_a, cos_a, 0.0]
    up = [-sin_e * cos_a, -sin_e * sin_a, cos_e]
    return np.array([right, up, [cos_e * cos_a, cos_e * sin_a, sin_e]])


def _panel(figure: Figure, place: int, frame: _Frame, title: str) -> Any:
    # Wider than half the figure and shifted to the left: labels of z stand at the right.
    left = 0.5 * place
    axes: Any = figure.add_axes(
        (left - 0.03, 0.01, 0.53, 0.92), projection="3d", computed_zorder=False
    )
    axes.set_proj_type("ortho")
    axes.view_init(np.degrees(_ELEVATION), np.degrees(_AZIMUTH))
    # As large as the panel allows with room for labels, in units of Matplotlib's default.
    width, height, _ = np.abs(_view()) @ frame.drawn / np.linalg.norm(frame.drawn)
    axes.set_box_aspect(frame.drawn, zoom=min(0.9 / width, 0.78 / height))
    axes.set(**{f"{x}lim": limits for x, *limits in zip("xyz", frame.low, frame.high, strict=True)})
    for index, axis in enumerate((axes.xaxis, axes.yaxis, axes.zaxis)):
        _label(axis, frame, index)
    figure.text(left + 0.24, 0.93, title, ha="center", size=17, color=_INK)
    return axes


def _label(axis: Any, frame: _Frame, index: int) -> None:
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    low, high, factor = frame.low[index], frame.high[index], frame.factor[index]
    label, origin = "xyz"[index], 0.0
    if max(abs(low), abs(high)) > _FAR * (high - low):
        unit = 10.0 ** np.ceil(np.log10(high - low))
        origin = float(np.round((low + high) / 2 / unit) * unit)
        label += f" {'−' if origin > 0 else '+'} {_number(abs(origin))}"
    if factor > 1:
        label = f"({label}) × {factor:.2g}" if origin else f"{label} × {factor:.2g}"
    axis.set_label_text(label, size=13, color=_INK)
    axis.labelpad = 4 if index == 2 else 9
    ticks = 2 + 3 * frame.drawn[index] / frame.drawn.max()
    axis.set_major_locator(MaxNLocator(int(ticks), steps=[1, 2, 5, 10]))
    axis.set_major_formatter(FuncFormatter(lambda value, _: _number(value - origin)))
    axis.set_tick_params(labelsize=11, labelcolor=_INK, color=_PALE, pad=2)
    axis.set_pane_color("white")
    axis.pane.set_edgecolor(_PALE)
    axis.line.set_color(_PALE)
    # Matplotlib has no public way to colour the grid of one 3D axis.
    axis._axinfo["grid"].update(color="#eceff1", linewidth=0.8)


def _draw_lattice(axes: Any, lattice: NDArray[np.float64], points: NDArray[np.float64]) -> None:
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    shown = _sample(points, _MOST_POINTS)
    size = np.clip(6_000 / len(shown), 2, 24)
    axes.scatter(*shown.T, s=size, c=_POINT, linewidths=0, depthshade=False, zorder=1)
    width = np.clip(24 / max(lattice.shape[:2]), 0.3, 1.1)
    for lines in (lattice, lattice.swapaxes(0, 1)):
        axes.add_collection3d(Line3DCollection(lines, colors=_NET, linewidths=width, zorder=2))


def _draw_surface(
    axes: Any, frame: _Frame, surface: NurbsSurface, points: NDArray[np.float64]
) -> None:
    """Draw facets, lines and points as one collection of quadrilaterals.

    Matplotlib sorts the members of a collection by depth, but not those of several: a fold in
    front must hide what lies behind it.
    """
    from matplotlib.colors import to_rgba
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    u, v = (np.linspace(*ends, _FACETS + 1) for ends in surface.domain)
    grid = surface.evaluate_grid(u, v)
    corners = (grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:])
    facets = np.stack(corners, axis=2).reshape(-1, 4, 3)
    lines = _isolines(surface, grid, frame)
    dots = _diamonds(_sample(points, _FEW_POINTS), frame)
    # Lines and dots are drawn a facet's width before the surface that they lie on.
    width = np.median(np.ptp(facets * frame.factor, axis=1), axis=0).max()
    towards = width * _view()[2] / frame.factor
    colours = _shaded(facets, frame)
    counts = (len(lines), len(dots))
    fills = np.repeat([to_rgba(_INK, 0.0), to_rgba(_POINT)], counts, axis=0)
    strokes = np.repeat([to_rgba(_INK, 0.3), to_rgba(_POINT)], counts, axis=0)
    axes.add_collection3d(
        Poly3DCollection(
            np.concatenate([facets, lines + towards, dots + 2 * towards]),
            facecolors=np.concatenate([colours, fills]),
            # Edges of a facet's own colour close the seams between facets.
            edgecolors=np.concatenate([colours, strokes]),
            linewidths=0.6,
        )
    )


def _isolines(
    surface: NurbsSurface, grid: NDArray[np.float64], frame: _Frame
) -> NDArray[np.float64]:
    """Segments of isoparametric lines, about equally far apart in u and v."""
    steps = [np.diff(grid, axis=axis) * frame.factor for axis in (0, 1)]
    lengths = [np.linalg.norm(s, axis=2).sum(axis=axis).mean() for axis, s in enumerate(steps)]
    share = np.array(lengths) / max(lengths)
    u, v = (np.linspace(*ends, _FACETS + 1) for ends in surface.domain)
    few_u, few_v = (
        np.linspace(*ends, max(2, round(_ISOLINES * s)))
        for ends, s in zip(surface.domain, share, strict=True)
    )
    bundles = (surface.evaluate_grid(few_u, v), surface.evaluate_grid(u, few_v).swapaxes(0, 1))
    segments = [np.stack([b[:, :-1], b[:, 1:]], axis=2).reshape(-1, 2, 3) for b in bundles]
    return np.concatenate(segments)[:, [0, 1, 1, 0]]


def _diamonds(points: NDArray[np.float64], frame: _Frame) -> NDArray[np.float64]:
    """Dots that face the viewer."""
    right, up, _ = _view() * 0.0025 * np.linalg.norm(frame.drawn) / frame.factor
    corners: NDArray[np.float64] = np.stack([right, up, -right, -up])
    return points[:, None] + corners


def _shaded(facets: NDArray[np.float64], frame: _Frame) -> NDArray[np.float64]:
    """Colours by height, lit from one side."""
    from matplotlib.colors import LinearSegmentedColormap

    drawn = facets * frame.factor
    normals = np.cross(drawn[:, 2] - drawn[:, 0], drawn[:, 3] - drawn[:, 1])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
    # A surface is lit on the side that is seen.
    normals *= np.where(normals @ _view()[2] < 0, -1.0, 1.0)[:, None]
    light = 0.5 + 0.6 * np.clip(normals @ _LIGHT, 0, None)
    height = (facets.mean(axis=1) - frame.low)[:, 2] / (frame.high - frame.low)[2]
    heights = LinearSegmentedColormap.from_list("heights", _HEIGHTS)
    colours: NDArray[np.float64] = heights(height)
    colours[:, :3] = np.clip(colours[:, :3] * light[:, None], 0, 1)
    return colours
