"""Readers of points and surfaces; writers of points, surfaces, meshes, pictures and reports.

The suffix of a path selects the format, in upper or lower case. Large libraries are imported when
they are used.
"""

from neurbs.io.point_cloud import PointCloud
from neurbs.io.point_formats import READABLE, check_source, stem_of
from neurbs.io.point_readers import read_point_cloud, read_points
from neurbs.io.shell_readers import load_shell
from neurbs.io.surface_readers import LOADABLE, load_surface, load_surfaces
from neurbs.io.writers import WRITABLE, check_target, save

__all__ = [
    "LOADABLE",
    "READABLE",
    "WRITABLE",
    "PointCloud",
    "check_source",
    "check_target",
    "load_shell",
    "load_surface",
    "load_surfaces",
    "read_point_cloud",
    "read_points",
    "save",
    "stem_of",
]
