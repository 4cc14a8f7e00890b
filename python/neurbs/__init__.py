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
    ClosestPoints,
    Curvatures,
    Epoch,
    Lattice,
    NeurbsError,
    NurbsCurve,
    NurbsSurface,
    Progress,
    TriangleMesh,
    __version__,
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
    "ClosestPoints",
    "ConvergenceWarning",
    "Curvatures",
    "Epoch",
    "Lattice",
    "NeurbsError",
    "NurbsCurve",
    "NurbsSurface",
    "PointCloud",
    "Progress",
    "Reconstruction",
    "Report",
    "SelfOrganizingMap",
    "TriangleMesh",
    "__version__",
    "from_geomdl",
    "from_opencascade",
    "from_splipy",
    "load_surface",
    "load_surfaces",
    "read_point_cloud",
    "read_points",
    "reconstruct",
    "save",
    "tessellate",
    "to_geomdl",
    "to_opencascade",
    "to_splipy",
]
