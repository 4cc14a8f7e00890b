"""The vertices of Wavefront OBJ files."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from neurbs._core import NeurbsError
from neurbs.io.point_cloud import Doubt, PointSource, Request
from neurbs.io.preamble import data_rows
from neurbs.io.table import read_blocks
from neurbs.io.table_layout import Layout

_WITH_COLORS = 7
"""Columns of a vertex line with colors: 'v', x, y, z, red, green, blue."""

_FREE_FORM = "cstype"
"""The statement before free-form curves and surfaces."""

_DOUBT = Doubt(
    "control-points",
    "vertices are control points of free-form surfaces: read these with load_shell",
)


def is_free_form(path: Path) -> bool:
    """Return whether an OBJ file has free-form curves or surfaces."""
    return any(text.split(None, 1)[0] == _FREE_FORM for _, text in data_rows(path))


def read_obj(path: Path, request: Request) -> PointSource:
    """Read all vertices (``v`` lines) in their order."""
    doubts: list[Doubt] = []

    def rows() -> Iterator[tuple[int, str]]:
        for number, text in data_rows(path):
            keyword = text.split(None, 1)[0]
            if keyword == "v":
                yield number, text
            elif keyword == _FREE_FORM and _DOUBT not in doubts:
                doubts.append(_DOUBT)

    first = next(rows(), None)
    if first is None:
        raise NeurbsError(f"{path}: must have at least one point, but has no 'v' line")
    # Column 0 is the 'v' itself. A weight or a color may follow the coordinates.
    colored = request.attributes and len(first[1].split()) == _WITH_COLORS
    colors = (4, 5, 6) if colored else ()
    layout = Layout((1, 2, 3), colors=colors, allow_missing=request.nan == "drop")
    return PointSource(read_blocks(path, rows, layout), doubts=doubts)
