"""Scattered 3D points in, a standard NURBS surface out.

>>> import numpy as np
>>> import neurbs
>>> x, y = np.random.default_rng(0).random((2, 500))
>>> result = neurbs.reconstruct(np.column_stack([x, y, np.sin(3 * x) * y]), grid=(8, 8))
>>> result.surface
NurbsSurface(net 8 × 8, degree (3, 3), domain [0, 1] × [0, 1], polynomial, open)
>>> result.mesh.max_deviation < 0.002
True
"""

import importlib
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from neurbs._core import (
        BatchSums,
        Cleaning,
        ClosestPoints,
        Curvatures,
        Epoch,
        EvenSample,
        HeightFit,
        Lattice,
        NeurbsError,
        NurbsCurve,
        NurbsSurface,
        Pieces,
        Progress,
        Topology,
        TriangleMesh,
        __version__,
        clean,
        detect_topology,
        fit_heights,
        free_weights,
        inspect,
        pieces,
        tessellate,
    )
    from neurbs.interop import (
        from_geomdl,
        from_opencascade,
        from_splipy,
        to_geomdl,
        to_opencascade,
        to_splipy,
    )
    from neurbs.io import (
        PointCloud,
        load_surface,
        load_surfaces,
        read_point_cloud,
        read_points,
        save,
    )
    from neurbs.reconstruction import Reconstruction, reconstruct
    from neurbs.reconstruction_report import Report
    from neurbs.som import ConvergenceWarning, SelfOrganizingMap
    from neurbs.versions import show_versions

__all__ = [
    "BatchSums",
    "Cleaning",
    "ClosestPoints",
    "ConvergenceWarning",
    "Curvatures",
    "Epoch",
    "EvenSample",
    "HeightFit",
    "Lattice",
    "NeurbsError",
    "NurbsCurve",
    "NurbsSurface",
    "Pieces",
    "PointCloud",
    "Progress",
    "Reconstruction",
    "Report",
    "SelfOrganizingMap",
    "Topology",
    "TriangleMesh",
    "__version__",
    "clean",
    "detect_topology",
    "fit_heights",
    "free_weights",
    "from_geomdl",
    "from_opencascade",
    "from_splipy",
    "inspect",
    "load_surface",
    "load_surfaces",
    "pieces",
    "read_point_cloud",
    "read_points",
    "reconstruct",
    "save",
    "show_versions",
    "tessellate",
    "to_geomdl",
    "to_opencascade",
    "to_splipy",
]

_HOMES = {
    "interop": (
        "from_geomdl",
        "from_opencascade",
        "from_splipy",
        "to_geomdl",
        "to_opencascade",
        "to_splipy",
    ),
    "io": (
        "PointCloud",
        "load_surface",
        "load_surfaces",
        "read_point_cloud",
        "read_points",
        "save",
    ),
    "reconstruction": ("Reconstruction", "reconstruct"),
    "reconstruction_report": ("Report",),
    "som": ("ConvergenceWarning", "SelfOrganizingMap"),
    "versions": ("show_versions",),
}
"""The modules that hold the public names; `_core` holds all others."""

_MODULES = ("io", "plot", "report")
"""Modules that users know by name."""


if not TYPE_CHECKING:  # A checker knows all names, and finds those that are misspelt.

    def __getattr__(name: str) -> object:
        """Import what is asked for when it is asked for first (PEP 562).

        So the command can answer Ctrl-C before NumPy is loaded, and nobody waits for what is not
        used.
        """
        if name in _MODULES:
            return importlib.import_module(f"neurbs.{name}")
        if name not in __all__:
            raise AttributeError(f"module 'neurbs' has no attribute {name!r}")
        home = next((home for home, names in _HOMES.items() if name in names), "_core")
        value = getattr(importlib.import_module(f"neurbs.{home}"), name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, *_MODULES})


if "numpy" in sys.modules:
    # Who has loaded NumPy has points, and the first call need not wait for what takes them.
    importlib.import_module("neurbs.reconstruction")
