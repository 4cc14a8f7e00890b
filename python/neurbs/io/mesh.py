"""Triangle meshes in formats that store single precision, written by trimesh."""

from __future__ import annotations

import signal
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError

if TYPE_CHECKING:
    from neurbs import TriangleMesh

_VISIBLE_ROUNDING = 1e-6
"""Share of a mesh's diagonal by which single precision may move a vertex without a warning.

It moves those of a mesh around the origin by less than a tenth of that.
"""


@contextmanager
def _interrupts_kept() -> Iterator[None]:
    """Keep Ctrl-C until the end: trimesh swallows what is raised while it imports its parts."""
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


@_interrupts_kept()
def write_stl(mesh: TriangleMesh, path: str) -> None:
    """Write a binary STL file, as it stands: the format has no place for an offset."""
    content = _trimesh(mesh, mesh.vertices, "STL").export(file_type="stl")
    Path(path).write_bytes(content)


@_interrupts_kept()
def write_glb(mesh: TriangleMesh, path: str) -> None:
    """Write a binary glTF file: vertices about their centre, and the centre as the node's place.

    The format stores vertices in single precision but the place of a node in text, so that
    coordinates far from the origin keep their digits.
    """
    import trimesh

    # Halved first: the sum of two large coordinates may overflow.
    centre = mesh.vertices.min(axis=0) / 2 + mesh.vertices.max(axis=0) / 2
    geometry = _trimesh(mesh, mesh.vertices - centre, "GLB")
    # A surface is seen from both sides; without a material, viewers draw one.
    geometry.visual = trimesh.visual.TextureVisuals(
        material=trimesh.visual.material.PBRMaterial(metallicFactor=0.0, doubleSided=True)
    )
    scene = trimesh.Scene()
    scene.add_geometry(
        geometry,
        node_name="surface",
        geom_name="surface",
        transform=trimesh.transformations.translation_matrix(centre),
    )
    content = scene.export(file_type="glb", include_normals=True)
    Path(path).write_bytes(content)


def _trimesh(mesh: TriangleMesh, vertices: NDArray[np.float64], name: str) -> Any:
    """Make trimesh's mesh, and say so where single precision does not suffice."""
    import trimesh

    if np.abs(vertices).max() > np.finfo(np.float32).max:
        raise NeurbsError(
            f"{name} stores single precision, but coordinates reach {np.abs(vertices).max():.2g}: "
            "change their unit, or write .ply or .obj"
        )
    moved = np.linalg.norm(vertices.astype(np.float32) - vertices, axis=1).max()
    diagonal = np.linalg.norm(np.ptp(vertices, axis=0))
    if moved > _VISIBLE_ROUNDING * diagonal:
        warnings.warn(
            f"{name} stores single precision, which moves vertices by up to {moved:.2g} "
            f"(the mesh's diagonal is {diagonal:.4g}): .ply, .obj and .glb keep the digits",
            UserWarning,
            # To who called `save`, three calls above this module's writers.
            stacklevel=5,
        )
    return trimesh.Trimesh(vertices, mesh.triangles, vertex_normals=mesh.normals, process=False)
