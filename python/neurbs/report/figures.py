"""The figures of the report as data for plotly.js."""

from __future__ import annotations

import base64
from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs.deviation import Deviation
from neurbs.plot.axes_box import PALE, AxesBox, number, sample
from neurbs.plot.coloring import SIDES, Coloring, coloring
from neurbs.plot.drawn_shell import DrawnShell
from neurbs.plot.matplotlib_scene import NET, lit

if TYPE_CHECKING:
    from neurbs import Reconstruction

_FACETS = 90
"""Triangles along the longest side of the view."""

_ISOLINES = 20
"""Isoparametric lines across the longer direction."""

_OFFSET = 0.002
"""Distance of the isoparametric lines from both sides of a face, which would hide them. Unit:
diagonal of the box."""

MAX_POINTS = 60_000
"""Most points in the page, which take 1.3 MB."""

_BARS = 60
"""Bars of the histogram."""

_FONT = {"family": "system-ui, sans-serif", "size": 13}

EDGE = "#7a8894"
"""Color of edges and marks: visible in a light and in a dark theme."""

CURVE = "#3f83bd"
"""Color of curves, visible in both."""

UNKNOWN = "in the unit of the points"


def box_of(result: Reconstruction, unit: str) -> AxesBox:
    """Return the box of the 3D figure."""
    points = result.points[result.inliers]
    return AxesBox.around(points, np.array(result.shell.bounding_box()), unit=unit)


def scene(
    result: Reconstruction, deviation: Deviation, tolerance: float | None, unit: str
) -> dict[str, Any]:
    """Return the 3D figure: faces, edges, points, isoparametric lines and control net.

    The checkboxes of the page select traces by their `meta`.
    """
    shell, points = result.shell, result.points[result.inliers]
    box = box_of(result, unit)
    drawn = DrawnShell.of(shell, box, _FACETS, _ISOLINES)
    # Browsers draw in single precision, so coordinates are relative to an origin near the box.
    origin = np.array([box.origin(axis) for axis in range(3)])
    scale = coloring(drawn, "deviation", deviation=deviation, tolerance=tolerance, unit=unit)
    median = float(np.median(deviation.distances))
    if tolerance is None and median > scale.high:
        # Where local means are much smaller than the noise, half of the points have pale colors.
        scale = replace(scale, low=-median, high=median)
    chosen = sample(len(points), MAX_POINTS)
    edges = _joined([line for line, _ in drawn.edges])
    net = result.surface.control_points
    traces = [
        _faces(drawn, scale, box, origin),
        _legend(scale),
        {
            "type": "scatter3d",
            "meta": "points",
            "mode": "markers",
            **_coordinates(points[chosen] - origin),
            "marker": {
                "size": 1.8,
                "color": _packed(deviation.signed[chosen]),
                **_scale(scale, "c"),
            },
            "hovertemplate": "%{marker.color:.4g}<extra>point</extra>",
        },
        _lines("surface", edges - origin, EDGE, 3.0, opacity=1.0),
        _lines("isolines", _isolines(drawn, box) - origin, EDGE, 1.0),
        _lines("net", _joined([*net, *net.swapaxes(0, 1)]) - origin, NET, 2.0, visible=False),
    ]
    axes = {
        f"{'xyz'[axis]}axis": {
            "title": {"text": box.label(axis)},
            "range": (np.array([box.low[axis], box.high[axis]]) - origin[axis]).tolist(),
            "zeroline": False,
            "exponentformat": "none",
            "separatethousands": True,
            "nticks": max(1, int(1.5 + 4.5 * box.drawn[axis] / box.drawn.max())),
        }
        for axis in range(3)
    }
    layout = {
        "font": _FONT,
        "margin": {"l": 0, "r": 0, "t": 0, "b": 0},
        "showlegend": False,
        "scene": {
            **axes,
            "aspectmode": "manual",
            "aspectratio": dict(zip("xyz", (box.drawn / box.drawn.max()).tolist(), strict=True)),
            # The direction only: the page moves the camera until the box fills the view.
            "camera": {"eye": {"x": 0.85, "y": -1.25, "z": 1.07}},
        },
    }
    return {"data": traces, "layout": layout}


def histogram(deviation: Deviation, tolerance: float | None, unit: str) -> dict[str, Any]:
    """Return the histogram of the signed distances."""
    limit = float(np.percentile(deviation.distances, 99.5)) or 1.0
    limit = max(limit, 1.1 * (tolerance or 0.0))
    edges = np.linspace(-limit, limit, _BARS + 1)
    # Points outside of the limits are in the bins at the ends.
    counts, _ = np.histogram(np.clip(deviation.signed, -limit, limit), edges)
    centers = (edges[1:] + edges[:-1]) / 2
    bars = {
        "type": "bar",
        "x": _packed(centers),
        "y": _packed(100 * counts / len(deviation.signed)),
        "width": edges[1] - edges[0],
        "marker": {
            "color": _packed(centers),
            "colorscale": _colorscale(SIDES),
            "cmid": 0,
            "line": {"width": 0.5, "color": PALE},
        },
        "hovertemplate": "%{x:.3g}: %{y:.2f} %<extra></extra>",
    }
    marks = [] if tolerance is None else [_mark(-tolerance), _mark(tolerance)]
    layout = _layout(f"signed distance, {unit or UNKNOWN}", "% of the points")
    return {"data": [bars], "layout": layout | {"shapes": marks, "bargap": 0}}


def convergence(result: Reconstruction, unit: str) -> dict[str, Any]:
    """Return the chart of the error by step of the training, with a curve for each stage."""
    stages = list(dict.fromkeys(stage for stage, _, _ in result.history))
    traces = []
    for stage in stages:
        steps, errors = zip(
            *(entry[1:] for entry in result.history if entry[0] == stage), strict=True
        )
        curve = {"type": "scatter", "mode": "lines+markers", "name": stage, "marker": {"size": 4}}
        axes = {"x": _packed(steps), "y": _packed(errors)}
        traces.append(curve | axes | {"hovertemplate": "step %{x:,}: %{y:.4g}<extra></extra>"})
    layout = _layout("steps", "mean distance to the map" + (f", {unit}" if unit else ""))
    every = [error for *_, error in result.history]
    falls_far = every and max(every) > 10 * min(every) > 0
    layout["yaxis"] |= _logarithmic(min(every), max(every)) if falls_far else _FROM_ZERO
    layout["xaxis"] |= {"exponentformat": "none", "separatethousands": True}
    layout["colorway"] = [CURVE, "#e2572b", "#2c6e63"]
    return {"data": traces, "layout": layout}


_FROM_ZERO: dict[str, Any] = {"rangemode": "tozero"}


def _logarithmic(low: float, high: float) -> dict[str, Any]:
    """Return a logarithmic axis with ticks at 1, 2 and 5 times each power of ten."""
    powers = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    factors = (1, 2, 5) if len(powers) <= 4 else (1,)
    ticks = [float(f"{factor}e{power}") for power in powers for factor in factors]
    return {"type": "log", "tickvals": ticks, "ticktext": [number(tick) for tick in ticks]}


def shares(deviation: Deviation, tolerance: float | None, unit: str) -> dict[str, Any]:
    """Return the chart of the share of points within a distance: what a fit has achieved."""
    percents = np.concatenate([np.linspace(0, 99, 100), np.linspace(99.1, 100, 10)])
    distances = np.percentile(deviation.distances, percents)
    curve = {
        "type": "scatter",
        "mode": "lines",
        "x": _packed(distances),
        "y": _packed(percents),
        "line": {"width": 2, "color": CURVE},
        "hovertemplate": "%{y:.4g} % within %{x:.4g}<extra></extra>",
    }
    layout = _layout(f"distance, {unit or UNKNOWN}", "% of the points within it")
    layout["yaxis"] |= {"range": [0, 103]}
    # A few points far away would press the curve to the left.
    end = max(float(np.percentile(deviation.distances, 99.5)), 1.1 * (tolerance or 0.0))
    layout["xaxis"] |= {"range": [0, 1.05 * end or 1.0]}
    marks = [] if tolerance is None else [_mark(tolerance)]
    return {"data": [curve], "layout": layout | {"shapes": marks}}


def _mark(place: float) -> dict[str, Any]:
    """Return a dotted line at a tolerance."""
    line = {"color": EDGE, "width": 1, "dash": "dot"}
    ends = {"x0": place, "x1": place, "y0": 0, "y1": 1}
    return {"type": "line", "yref": "paper", "line": line, **ends}


def _faces(
    drawn: DrawnShell, scale: Coloring, box: AxesBox, origin: NDArray[np.float64]
) -> dict[str, Any]:
    """Return the faces in the colors of a scale; places without points near are gray."""
    colors = scale.rgba()[:, :3]
    # The light of plotly.js falls on the faces as they are without exaggeration.
    colors *= lit(drawn.normals() / box.factor, box.view, legend=True)[:, None]
    texts = ["no points near" if np.isnan(v) else f"{v:.4g}" for v in scale.values]
    corners = zip("ijk", drawn.triangles.T, strict=True)
    return {
        "type": "mesh3d",
        "meta": "surface",
        **_coordinates(drawn.vertices - origin),
        **{name: _packed(column, "<i4") for name, column in corners},
        "vertexcolor": [f"#{r:02x}{g:02x}{b:02x}" for r, g, b in _bytes(colors)],
        "lighting": {"ambient": 1.0, "diffuse": 0.0, "specular": 0.0, "fresnel": 0.0},
        "hovertext": texts,
        "hovertemplate": "%{hovertext}<extra>surface</extra>",
    }


def _bytes(colors: NDArray[np.float64]) -> list[list[int]]:
    whole: list[list[int]] = np.rint(255 * np.clip(colors, 0, 1)).astype(int).tolist()
    return whole


def _legend(scale: Coloring) -> dict[str, Any]:
    """Return a trace without points that shows the scale."""
    colorbar = {
        "title": {"text": scale.label.replace("\n", "<br>"), "side": "right"},
        "thickness": 16,
        "len": 0.7,
        "outlinewidth": 0,
        # Powers are so wide that they reach into the title.
        "exponentformat": "e",
    }
    marker = {"color": [scale.low], "showscale": True, "colorbar": colorbar, **_scale(scale, "c")}
    nowhere = {axis: [None] for axis in "xyz"}
    return {"type": "scatter3d", "meta": "legend", "mode": "markers", **nowhere, "marker": marker}


def _scale(scale: Coloring, prefix: str) -> dict[str, Any]:
    limits = {f"{prefix}min": scale.low, f"{prefix}max": scale.high}
    return limits | {"colorscale": _colorscale(scale.palette)}


def _colorscale(palette: tuple[str, ...]) -> list[list[Any]]:
    places = np.linspace(0, 1, len(palette))
    return [[place, color] for place, color in zip(places, palette, strict=True)]


def _lines(
    name: str,
    points: NDArray[np.float64],
    color: str,
    width: float,
    *,
    opacity: float = 0.55,
    visible: bool = True,
) -> dict[str, Any]:
    return {
        "type": "scatter3d",
        "meta": name,
        "mode": "lines",
        **_coordinates(points),
        "line": {"color": color, "width": width},
        "opacity": opacity,
        "hoverinfo": "skip",
        "visible": visible,
    }


def _isolines(drawn: DrawnShell, box: AxesBox) -> NDArray[np.float64]:
    """Return isoparametric lines on both sides of the faces, along their drawn normals."""
    lines = []
    for line in drawn.isolines:
        normals = line[:, 3:] / box.factor
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        offset = _OFFSET * np.linalg.norm(box.drawn) * normals / box.factor
        lines += [line[:, :3] + offset, line[:, :3] - offset]
    return _joined(lines)


def _joined(lines: Iterable[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Join lines to one array, with NaN after each."""
    padded = [np.pad(line, ((0, 1), (0, 0)), constant_values=np.nan) for line in lines]
    return np.concatenate([np.empty((0, 3)), *padded])


def _coordinates(points: NDArray[np.float64]) -> dict[str, Any]:
    return {name: _packed(column) for name, column in zip("xyz", points.T, strict=True)}


def _packed(values: ArrayLike, dtype: str = "<f4") -> dict[str, str]:
    """Return numbers as a typed array of plotly.js in base64, by default in single precision."""
    array = np.ascontiguousarray(values, dtype=dtype)
    packed = {"dtype": dtype[1:], "bdata": base64.b64encode(array.tobytes()).decode()}
    return packed | ({"shape": ", ".join(map(str, array.shape))} if array.ndim > 1 else {})


def _layout(x: str, y: str) -> dict[str, Any]:
    # The script of the page adds the colors, which depend on the theme.
    axis = {"zeroline": False, "automargin": True, "exponentformat": "power"}
    return {
        "font": _FONT,
        "margin": {"l": 60, "r": 16, "t": 12, "b": 48},
        "xaxis": axis | {"title": {"text": x}},
        "yaxis": axis | {"title": {"text": y}},
    }
