"""Versions of the installed libraries, for bug reports."""

import platform
import sys
from importlib import metadata

_LIBRARIES = (
    "neurbs",
    "numpy",
    "typer",
    "rich",
    "trimesh",
    "matplotlib",
    "pyvista",
    "plotly",
    "laspy",
    "rhino3dm",
    "cadquery-ocp-novtk",
    "geomdl",
    "splipy",
)
"""neurbs, its dependencies and the libraries that it works with."""


def show_versions() -> None:
    """Print the versions of Python, the system, neurbs and the libraries that it works with.

    Examples
    --------
    >>> import neurbs
    >>> neurbs.show_versions()  # doctest: +ELLIPSIS
    python ...
    """
    rows = {
        "python": sys.version.split()[0],
        "executable": sys.executable,
        "system": platform.platform(),
        **{name: installed_version(name) or "not installed" for name in _LIBRARIES},
    }
    width = max(map(len, rows))
    print("\n".join(f"{name:<{width}}  {value}" for name, value in rows.items()))


def installed_version(distribution: str) -> str | None:
    """Return the version of a distribution, or None if it is not installed."""
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return None
