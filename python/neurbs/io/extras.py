"""Libraries that only some files need: imported when such a file comes."""

from __future__ import annotations

import importlib
import importlib.util
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from neurbs._core import NeurbsError

EXTRAS = {
    "OCP": ("cadquery-ocp-novtk", "cad"),
    "laspy": ("laspy[lazrs]", "io"),
    "lzf": ("python-neo-lzf", "io"),
    "matplotlib": ("matplotlib", "plot"),
    "plotly": ("plotly", "report"),
    "pye57": ("pye57", "io"),
    "pyproj": ("pyproj", "io"),
    "pyvista": ("pyvista", "view"),
    "rasterio": ("rasterio", "io"),
    "rhino3dm": ("rhino3dm", "cad"),
    "vtkmodules": ("vtk", "vtk"),
}
"""Of each library that is an extra: the package it comes in, and the extra of neurbs."""


def imported(path: Path, module: str) -> Any:
    """Import a module for a file, or say what has to be installed.

    Ctrl-C is kept until the import has ended, because some libraries swallow what is raised
    while they import their parts.
    """
    with _interrupts_kept():
        try:
            return importlib.import_module(module)
        except ModuleNotFoundError as error:
            library = module.partition(".")[0]
            if library not in EXTRAS or (error.name or "").partition(".")[0] != library:
                raise
            raise _missing(path, library) from None


def check_installed(path: Path, library: str) -> None:
    """Check, without importing it, that a library is there."""
    try:
        found = importlib.util.find_spec(library)
    except ModuleNotFoundError:
        found = None
    if found is None:
        raise _missing(path, library)


def _missing(path: Path, library: str) -> NeurbsError:
    package, extra = EXTRAS[library]
    return NeurbsError(
        f"{path}: {path.suffix.lower()} files need {package}: pip install 'neurbs[{extra}]'"
    )


@contextmanager
def _interrupts_kept() -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    kept = False

    def keep(_number: int, _frame: object) -> None:
        nonlocal kept
        kept = True

    before = signal.signal(signal.SIGINT, keep)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before or signal.default_int_handler)
    if kept:
        raise KeyboardInterrupt
