"""Windows of PyVista that notebooks show."""

from __future__ import annotations

import io

import pyvista


class ShownPlotter(pyvista.Plotter):  # type: ignore[misc]  # PyVista is checked without types.
    """A plotter whose picture shows itself as the last line of a notebook cell.

    Its method `show` opens the window, or a scene that is turned with the mouse.
    """

    def _repr_png_(self) -> bytes | None:
        """Return the picture, for notebooks; None where `show` opens a window on the screen."""
        if not self.off_screen:
            return None
        png = io.BytesIO()
        self.screenshot(png, return_img=False)
        return png.getvalue()
