"""Scattered 3D points in, a standard NURBS surface out.

>>> import numpy as np
>>> import neurbs
>>> x, y = np.random.default_rng(0).random((2, 500))
>>> result = neurbs.reconstruct(np.column_stack([x, y, np.sin(3 * x) * y]), grid=(9, 7))
>>> result.surface
NurbsSurface(net 9 × 7, degree (3, 3), domain [0, 1] × [0, 1], polynomial, open)
>>> result.mesh.max_deviation < 0.002
True
"""

import importlib
import os
import sys
import threading


def _check_interpreter() -> None:
    """Refuse a subinterpreter: NumPy and the extension keep data that interpreters would share."""
    # The name up to Python 3.12 and the name since.
    for name in ("_xxsubinterpreters", "_interpreters"):
        try:
            interpreters = importlib.import_module(name)
        except ImportError:
            continue
        if interpreters.get_current() != interpreters.get_main():
            raise ImportError(
                "neurbs must be imported in the main interpreter, but this is a subinterpreter: "
                "use a process instead (with mod_wsgi, set WSGIApplicationGroup %{GLOBAL})",
                name="neurbs",
            )


_check_interpreter()

TYPE_CHECKING = False
if TYPE_CHECKING:
    from neurbs._core import (
        BatchSums,
        Cleaning,
        ClosestPoints,
        Components,
        Curvatures,
        CurvePoints,
        Edge,
        Epoch,
        EvenSample,
        Face,
        FacePoints,
        HeightFit,
        Lattice,
        NeurbsError,
        NeurbsMemoryError,
        NurbsCurve,
        NurbsSurface,
        PartialSums,
        Progress,
        Shell,
        TriangleMesh,
        __version__,
        clean,
        components,
        fit_heights,
        fit_weights,
        num_threads,
        recover_net,
        set_num_threads,
        tessellate,
        trim,
    )
    from neurbs.candidate import (
        Candidate,
        candidates,
    )
    from neurbs.diagnostics import (
        ClosedBodyWarning,
        ColumnsGuessedWarning,
        ComponentsWarning,
        ControlPointsWarning,
        ConvergenceWarning,
        CrsUnknownWarning,
        Diagnostic,
        FoldedWarning,
        KindDoubtfulWarning,
        LeftOutWarning,
        MixedUnitsWarning,
        NeurbsWarning,
        NoDataWarning,
        OvershootWarning,
        PointsDroppedWarning,
        RegionsWarning,
        ThickWarning,
        ToleranceMissedWarning,
        TornWarning,
        TrimDoubtfulWarning,
        TwoLayersWarning,
        UncoveredWarning,
        UntrimmedWarning,
        validate,
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
        load_shell,
        load_surface,
        load_surfaces,
        read_point_cloud,
        read_points,
        save,
    )
    from neurbs.reconstruction import (
        Reconstruction,
    )
    from neurbs.reconstruction_fit import (
        reconstruct,
    )
    from neurbs.reconstruction_paper import (
        reconstruct_paper,
    )
    from neurbs.reconstruction_report import (
        Report,
        TrimReport,
    )
    from neurbs.som import (
        SelfOrganizingMap,
    )
    from neurbs.versions import (
        show_versions,
    )

__all__ = [
    "BatchSums",
    "Candidate",
    "Cleaning",
    "ClosedBodyWarning",
    "ClosestPoints",
    "ColumnsGuessedWarning",
    "Components",
    "ComponentsWarning",
    "ControlPointsWarning",
    "ConvergenceWarning",
    "CrsUnknownWarning",
    "Curvatures",
    "CurvePoints",
    "Diagnostic",
    "Edge",
    "Epoch",
    "EvenSample",
    "Face",
    "FacePoints",
    "FoldedWarning",
    "HeightFit",
    "KindDoubtfulWarning",
    "Lattice",
    "LeftOutWarning",
    "MixedUnitsWarning",
    "NeurbsError",
    "NeurbsMemoryError",
    "NeurbsWarning",
    "NoDataWarning",
    "NurbsCurve",
    "NurbsSurface",
    "OvershootWarning",
    "PartialSums",
    "PointCloud",
    "PointsDroppedWarning",
    "Progress",
    "Reconstruction",
    "RegionsWarning",
    "Report",
    "SelfOrganizingMap",
    "Shell",
    "ThickWarning",
    "ToleranceMissedWarning",
    "TornWarning",
    "TriangleMesh",
    "TrimDoubtfulWarning",
    "TrimReport",
    "TwoLayersWarning",
    "UncoveredWarning",
    "UntrimmedWarning",
    "__version__",
    "candidates",
    "clean",
    "components",
    "fit_heights",
    "fit_weights",
    "from_geomdl",
    "from_opencascade",
    "from_splipy",
    "load_shell",
    "load_surface",
    "load_surfaces",
    "num_threads",
    "read_point_cloud",
    "read_points",
    "reconstruct",
    "reconstruct_paper",
    "recover_net",
    "save",
    "set_num_threads",
    "show_versions",
    "tessellate",
    "to_geomdl",
    "to_opencascade",
    "to_splipy",
    "trim",
    "validate",
]

_HOMES = {
    "candidate": (
        "Candidate",
        "candidates",
    ),
    "diagnostics": (
        "ClosedBodyWarning",
        "ColumnsGuessedWarning",
        "ComponentsWarning",
        "ControlPointsWarning",
        "ConvergenceWarning",
        "CrsUnknownWarning",
        "Diagnostic",
        "FoldedWarning",
        "KindDoubtfulWarning",
        "LeftOutWarning",
        "MixedUnitsWarning",
        "NeurbsWarning",
        "NoDataWarning",
        "OvershootWarning",
        "PointsDroppedWarning",
        "RegionsWarning",
        "ThickWarning",
        "ToleranceMissedWarning",
        "TornWarning",
        "TrimDoubtfulWarning",
        "TwoLayersWarning",
        "UncoveredWarning",
        "UntrimmedWarning",
        "validate",
    ),
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
        "load_shell",
        "load_surface",
        "load_surfaces",
        "read_point_cloud",
        "read_points",
        "save",
    ),
    "reconstruction": ("Reconstruction",),
    "reconstruction_fit": ("reconstruct",),
    "reconstruction_paper": ("reconstruct_paper",),
    "reconstruction_report": ("Report", "TrimReport"),
    "som": ("SelfOrganizingMap",),
    "versions": ("show_versions",),
}
"""For each module its public names; all others are in `_core`."""

_MODULES = ("distributed", "io", "plot", "report")
"""Public modules."""

_ATTRIBUTES = ("__doc__", "__file__", "__name__", "__path__", "__spec__")
"""Attributes of the module itself that tools look up; imports are not part of it."""


_importing = threading.RLock()
"""Held while a name is imported: modules that import each other must not meet in two threads."""


def _renew_lock() -> None:
    global _importing
    _importing = threading.RLock()


if hasattr(os, "register_at_fork"):
    # A fork may copy the lock while another thread has it.
    os.register_at_fork(after_in_child=_renew_lock)


if not TYPE_CHECKING:  # Type checkers must report misspelt names.

    def __getattr__(name: str) -> object:
        """Import a public name when it is first used (PEP 562).

        The command line can then answer Ctrl-C before NumPy is loaded, and unused modules cost no
        time.
        """
        if name in _MODULES:
            with _importing:
                return importlib.import_module(f"neurbs.{name}")
        if name not in __all__:
            from neurbs.renamed import missing_attribute

            raise missing_attribute("module 'neurbs'", name)
        home = next((home for home, names in _HOMES.items() if name in names), "_core")
        with _importing:
            value = getattr(importlib.import_module(f"neurbs.{home}"), name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted({*__all__, *_MODULES, *_ATTRIBUTES})


if "numpy" in sys.modules or any("neurbs." in option for option in sys.warnoptions):
    # A program that has loaded NumPy will soon call `reconstruct`: import it now, not then.
    # An option -W that names a warning of neurbs is applied by this import.
    importlib.import_module("neurbs.reconstruction_fit")
