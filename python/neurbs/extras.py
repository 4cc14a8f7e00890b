"""Optional libraries, which the extras of the package install."""

from __future__ import annotations

import importlib
import importlib.util
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

from neurbs._core import NeurbsError

_EXTRAS = {
    "backports": ("backports.zstd", "io"),
    "collada": ("pycollada", "io"),
    "OCP": ("cadquery-ocp-novtk", "cad"),
    "dask": ("dask[array]", "dask"),
    "distributed": ("distributed", "dask"),
    "laspy": ("laspy[lazrs]", "io"),
    "lxml": ("lxml", "io"),
    "lzf": ("python-neo-lzf", "io"),
    "networkx": ("networkx", "io"),
    "matplotlib": ("matplotlib", "plot"),
    "plotly": ("plotly", "report"),
    "pye57": ("pye57", "io"),
    "pyproj": ("pyproj", "io"),
    "pyvista": ("pyvista", "view"),
    "rasterio": ("rasterio", "io"),
    "rhino3dm": ("rhino3dm", "cad"),
    "vtkmodules": ("vtk", "vtk"),
}
"""For each optional library its package and the extra of neurbs that installs it."""


def require(module: str, purpose: str) -> ModuleType:
    """Import a module of an optional library, or raise with the command that installs it.

    Parameters
    ----------
    module : str
        Name of the module.
    purpose : str
        The things that need it, as a plural: "pictures".

    Examples
    --------
    >>> from neurbs.extras import require
    >>> require("matplotlib", "pictures").__name__
    'matplotlib'
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if not _is_missing(module, error):
            raise
        raise _not_installed(purpose, module) from None


def is_dask_array(points: object) -> bool:
    """Whether points are a `dask.array`, which is not imported for this."""
    return type(points).__module__.partition(".")[0] == "dask" and hasattr(points, "dask")


def require_for_file(path: Path, module: str) -> Any:
    """Import a module that reads or writes a file, or raise with the command that installs it.

    Ctrl-C is delayed until the import ends, because some libraries catch KeyboardInterrupt while
    they import their own parts.
    """
    with _interrupts_delayed():
        try:
            return importlib.import_module(module)
        except ModuleNotFoundError as error:
            if not _is_missing(module, error):
                raise
            raise _not_installed(_files(path), module) from None


def check_installed(path: Path, library: str) -> None:
    """Raise if the library that a file needs is not installed; it is not imported."""
    try:
        found = importlib.util.find_spec(library)
    except ModuleNotFoundError:
        found = None
    if found is None:
        raise _not_installed(_files(path), library)


def _is_missing(module: str, error: ModuleNotFoundError) -> bool:
    """Whether an import failed because the optional library itself is not installed."""
    library = module.partition(".")[0]
    return library in _EXTRAS and (error.name or "").partition(".")[0] == library


def _files(path: Path) -> str:
    return f"{path}: {path.suffix.lower()} files"


def _not_installed(purpose: str, module: str) -> NeurbsError:
    package, extra = _EXTRAS[module.partition(".")[0]]
    return NeurbsError(f"{purpose} need {package}: pip install 'neurbs[{extra}]'")


@contextmanager
def _interrupts_delayed() -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    interrupted = False

    def note(_number: int, _frame: object) -> None:
        nonlocal interrupted
        interrupted = True

    before = signal.signal(signal.SIGINT, note)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before or signal.default_int_handler)
    if interrupted:
        raise KeyboardInterrupt
