"""Figures that notebooks show."""

from __future__ import annotations

import io
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure


class ShownFigure(Figure):
    """A Matplotlib figure that shows itself as the last line of a notebook cell.

    Notebooks show figures of pyplot only, which must be closed. This one needs no display.
    """

    def __init__(self, *args: Any, **keywords: Any) -> None:
        super().__init__(*args, **keywords)
        FigureCanvasAgg(self)

    def _repr_png_(self) -> bytes:
        """Return the picture, for notebooks."""
        png = io.BytesIO()
        self.savefig(png, format="png")
        return png.getvalue()
