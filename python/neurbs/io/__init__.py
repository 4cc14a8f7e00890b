"""Files in and out: points and surfaces are read, these and meshes and pictures are written.

The suffix of a path picks the format, in any case of its letters. Heavy libraries are imported
where they are used, so that importing this package costs nothing.
"""

from neurbs.io.point_cloud import PointCloud
from neurbs.io.point_readers import READABLE, check_source, read_point_cloud, read_points
from neurbs.io.surface_readers import LOADABLE, load_surface, load_surfaces
from neurbs.io.writers import WRITABLE, check_target, save

__all__ = [
    "LOADABLE",
    "READABLE",
    "WRITABLE",
    "PointCloud",
    "check_source",
    "check_target",
    "load_surface",
    "load_surfaces",
    "read_point_cloud",
    "read_points",
    "save",
]
