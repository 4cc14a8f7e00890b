"""Pictures of points, maps and surfaces.

`Reconstruction.plot`, `NurbsSurface.plot` and `SelfOrganizingMap.plot` draw with Matplotlib, or
with PyVista in a window that is turned with the mouse. Both libraries are imported when something
is drawn: ``pip install 'neurbs[plot,view]'``.
"""

from neurbs.plot.animation import animate
from neurbs.plot.figures import (
    plot_points,
    plot_reconstruction,
    plot_surface,
    save_picture,
)
from neurbs.plot.maps import plot_map
from neurbs.plot.notebook import map_html, reconstruction_html, surface_html
from neurbs.plot.shells import plot_shell

__all__ = [
    "animate",
    "map_html",
    "plot_map",
    "plot_points",
    "plot_reconstruction",
    "plot_shell",
    "plot_surface",
    "reconstruction_html",
    "save_picture",
    "surface_html",
]


def __dir__() -> list[str]:
    """Return the public names, without the modules behind them."""
    return sorted({*__all__, "__doc__", "__file__", "__name__", "__path__", "__spec__"})
