"""Scattered 3D points in, a standard NURBS surface out.

>>> import numpy as np
>>> import neurbs
>>> x, y = np.random.default_rng(0).random((2, 500))
>>> result = neurbs.reconstruct(np.column_stack([x, y, x * y]), grid=(8, 8))
>>> result.surface
NurbsSurface(net 8 × 8, degree (3, 3), domain [0, 1] × [0, 1], polynomial, open)
>>> result.mesh
TriangleMesh(1089 vertices, 2048 triangles)
"""

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
from neurbs.reconstruct import Reconstruction, Report, reconstruct
from neurbs.som import ConvergenceWarning, SelfOrganizingMap

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
    "tessellate",
    "to_geomdl",
    "to_opencascade",
    "to_splipy",
]
