"""HTML of results for notebooks."""

from __future__ import annotations

import base64
import html
import importlib.util
import io
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from neurbs.plot.axes_box import number
from neurbs.plot.figures import plot_reconstruction, plot_surface
from neurbs.plot.maps import plot_map

if TYPE_CHECKING:
    from neurbs import NurbsSurface, Reconstruction, SelfOrganizingMap

_DPI = 50
"""Dots per inch of the picture."""


def reconstruction_html(result: Reconstruction) -> str:
    """Return a picture and the main figures of a result as HTML."""
    report = result.report
    rows = {
        "surface": repr(result.surface),
        **report.lines(),
    }
    return _card("Reconstruction", rows, lambda: plot_reconstruction(result))


def surface_html(surface: NurbsSurface) -> str:
    """Return a picture and the properties of a surface as HTML."""
    low, high = surface.bounding_box(tight=False)
    size = " × ".join(number(float(f"{side:.6g}")) for side in high - low)
    return _card(
        "NurbsSurface", {"surface": repr(surface), "size": size}, lambda: plot_surface(surface)
    )


def map_html(som: SelfOrganizingMap) -> str:
    """Return a picture and the training of a map as HTML; for an untrained map its settings."""
    rows = {"settings": repr(som)}
    if not som.__sklearn_is_fitted__():
        return _card("SelfOrganizingMap", rows, None)
    rows |= {"steps": f"{som.n_iter_:,}", "stopped by": som.stopped_by_}
    return _card("SelfOrganizingMap", rows, lambda: plot_map(som))


def _card(title: str, rows: Mapping[str, str], draw: Callable[[], Any] | None) -> str:
    cells = "".join(
        f"<tr><th style='text-align:left'>{html.escape(name)}</th>"
        f"<td style='text-align:left;white-space:pre-wrap'>{html.escape(value)}</td></tr>"
        for name, value in rows.items()
    )
    picture = ""
    if draw is not None and importlib.util.find_spec("matplotlib") is not None:
        png = io.BytesIO()
        draw().savefig(png, format="png", dpi=_DPI)
        data = base64.b64encode(png.getvalue()).decode()
        picture = f"<img alt='{title}' src='data:image/png;base64,{data}'>"
    return f"<div><b>{title}</b>{picture}<table>{cells}</table></div>"
