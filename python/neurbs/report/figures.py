"""The figures of the report as data for plotly.js."""

from __future__ import annotations

import base64
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs.deviation import Deviation
from neurbs.plot.axes_box import INK, PALE, AxesBox, sample
from neurbs.plot.coloring import NO_DATA, SIDES, Coloring, coloring
from neurbs.plot.matplotlib_scene import NET

if TYPE_CHECKING:
    from neurbs import Reconstruction

_FACETS = 160
"""Facets along each side of the surface."""

_LINE_STEP = 8
"""Facets between two isoparametric lines."""

_OFFSET = 0.002
"""Distance of the isoparametric lines from both sides of the surface, which would hide them. Unit:
diagonal of the box."""

MAX_POINTS = 60_000
"""Most points in the page, which take 1.3 MB."""

_BARS = 60
"""Bars of the histogram."""

_FONT = {"family": "system-ui, sans-serif", "size": 13, "color": INK}


def scene(
    result: Reconstruction, deviation: Deviation, tolerance: float | None, unit: str
) -> dict[str, Any]:
    """Return the 3D figure: surface, points, isoparametric lines and control net.

    The checkboxes of the page select traces by their `meta`.
    """
    surface = result.surface
    u, v = (np.linspace(*ends, _FACETS + 1) for ends in surface.domain)
    grid, normals = surface.normals_grid(u, v)
    points = result.points[result.inliers]
    box = AxesBox.around(points, grid.reshape(-1, 3))
    # Browsers draw in single precision, so coordinates are relative to an origin near the box.
    origin = np.array([box.origin(axis) for axis in range(3)])
    scale = coloring(
        surface, u, v, "deviation", deviation=deviation, tolerance=tolerance, unit=unit
    )
    chosen = sample(len(points), MAX_POINTS)
    traces = [
        *_surfaces(grid - origin, scale),
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
        _lines("isolines", _isolines(grid, normals, box) - origin, INK, 1.0, visible=True),
        _lines("net", _net(surface.control_points) - origin, NET, 2.0, visible=False),
    ]
    axes = {
        f"{'xyz'[axis]}axis": {
            "title": {"text": box.label(axis)},
            "range": (np.array([box.low[axis], box.high[axis]]) - origin[axis]).tolist(),
            "backgroundcolor": "white",
            "gridcolor": PALE,
            "zeroline": False,
            "nticks": int(2 + 4 * box.drawn[axis] / box.drawn.max()),
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
            "camera": {"eye": {"x": 0.85, "y": -1.25, "z": 0.95}, "center": {"z": -0.12}},
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
    marks = [
        {
            "type": "line",
            "x0": place,
            "x1": place,
            "yref": "paper",
            "y0": 0,
            "y1": 1,
            "line": {"color": INK, "width": 1, "dash": "dot"},
        }
        for place in ([] if tolerance is None else [-tolerance, tolerance])
    ]
    layout = _layout(f"signed distance, {unit or 'in the unit of the points'}", "% of the points")
    return {"data": [bars], "layout": layout | {"shapes": marks, "bargap": 0}}


def convergence(result: Reconstruction, unit: str) -> dict[str, Any]:
    """Return the figure of the error by step, with a curve for each stage."""
    stages = list(dict.fromkeys(stage for stage, _, _ in result.history))
    traces = []
    for stage in stages:
        steps, errors = zip(
            *(entry[1:] for entry in result.history if entry[0] == stage), strict=True
        )
        traces.append(
            {
                "type": "scatter",
                "mode": "lines+markers",
                "name": stage,
                "x": _packed(steps),
                "y": _packed(errors),
                "line": {"width": 2},
                "marker": {"size": 4},
                "hovertemplate": "step %{x:,}: %{y:.4g}<extra></extra>",
            }
        )
    layout = _layout("steps", f"mean distance to the map, {unit or 'in the unit of the points'}")
    every = [error for *_, error in result.history]
    falls_far = every and max(every) > 10 * min(every) > 0
    layout["yaxis"] |= {"type": "log", "dtick": "D2"} if falls_far else {"rangemode": "tozero"}
    layout["colorway"] = [NET, "#e2572b", "#2c6e63"]
    return {"data": traces, "layout": layout}


def _surfaces(grid: NDArray[np.float64], scale: Coloring) -> list[dict[str, Any]]:
    """Return the colored surface, and a gray one for places without points near."""
    missing = np.isnan(scale.values)
    # A facet is left out if one of its corners is, so the gray part extends by one corner.
    around = np.pad(missing, 1)
    for axis in (0, 1):
        around = around | np.roll(around, 1, axis) | np.roll(around, -1, axis)
    x, y, z = np.moveaxis(grid, 2, 0)
    common = {
        "type": "surface",
        "meta": "surface",
        "x": _packed(x),
        "y": _packed(y),
        "contours": {axis: {"highlight": False} for axis in "xyz"},
        "lighting": {"ambient": 0.6, "diffuse": 0.45, "specular": 0.05, "roughness": 0.8},
    }
    colored = common | {
        "z": _packed(np.where(missing, np.nan, z)),
        "surfacecolor": _packed(np.nan_to_num(scale.values)),
        **_scale(scale, "c"),
        "colorbar": {
            "title": {"text": scale.label, "side": "right"},
            "thickness": 16,
            "len": 0.7,
            "outlinewidth": 0,
        },
        "hovertemplate": "%{surfacecolor:.4g}<extra>surface</extra>",
    }
    gray = common | {
        "z": _packed(np.where(around[1:-1, 1:-1], z, np.nan)),
        "colorscale": [[0, NO_DATA], [1, NO_DATA]],
        "showscale": False,
        "hovertemplate": "no points near<extra></extra>",
    }
    return [colored, gray] if missing.any() else [colored]


def _scale(scale: Coloring, prefix: str) -> dict[str, Any]:
    limits = {f"{prefix}min": scale.low, f"{prefix}max": scale.high}
    return limits | {"colorscale": _colorscale(scale.palette)}


def _colorscale(palette: tuple[str, ...]) -> list[list[Any]]:
    places = np.linspace(0, 1, len(palette))
    return [[place, color] for place, color in zip(places, palette, strict=True)]


def _lines(
    name: str, points: NDArray[np.float64], color: str, width: float, *, visible: bool
) -> dict[str, Any]:
    return {
        "type": "scatter3d",
        "meta": name,
        "mode": "lines",
        **_coordinates(points),
        "line": {"color": color, "width": width},
        "opacity": 0.55,
        "hoverinfo": "skip",
        "visible": visible,
    }


def _net(net: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.concatenate([_joined(net), _joined(net.swapaxes(0, 1))])


def _isolines(
    grid: NDArray[np.float64], normals: NDArray[np.float64], box: AxesBox
) -> NDArray[np.float64]:
    """Return isoparametric lines on both sides of the surface, along its drawn normals."""
    drawn = normals / box.factor
    drawn /= np.linalg.norm(drawn, axis=2, keepdims=True)
    offset = _OFFSET * np.linalg.norm(box.drawn) * drawn / box.factor
    sides = (grid + offset, grid - offset)
    along_v = [_joined(side[::_LINE_STEP]) for side in sides]
    along_u = [_joined(side[:, ::_LINE_STEP].swapaxes(0, 1)) for side in sides]
    return np.concatenate(along_v + along_u)


def _joined(lines: NDArray[np.float64]) -> NDArray[np.float64]:
    """Join lines to one array, with NaN between two lines."""
    return np.pad(lines, ((0, 0), (0, 1), (0, 0)), constant_values=np.nan).reshape(-1, 3)


def _coordinates(points: NDArray[np.float64]) -> dict[str, Any]:
    return {name: _packed(column) for name, column in zip("xyz", points.T, strict=True)}


def _packed(values: ArrayLike) -> dict[str, str]:
    """Return numbers as a typed array of plotly.js: single precision in base64."""
    array = np.ascontiguousarray(values, dtype="<f4")
    packed = {"dtype": "f4", "bdata": base64.b64encode(array.tobytes()).decode()}
    return packed | ({"shape": ", ".join(map(str, array.shape))} if array.ndim > 1 else {})


def _layout(x: str, y: str) -> dict[str, Any]:
    axis = {"gridcolor": "#eceff1", "linecolor": PALE, "zeroline": False}
    return {
        "font": _FONT,
        "margin": {"l": 60, "r": 16, "t": 12, "b": 48},
        "plot_bgcolor": "white",
        "paper_bgcolor": "white",
        "xaxis": axis | {"title": {"text": x}},
        "yaxis": axis | {"title": {"text": y}},
    }
