"""Vertices of meshes in formats that trimesh reads: `.stl`, `.glb`, `.gltf`, `.dae`, `.3mf`."""

from __future__ import annotations

import json
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.extras import require_for_file
from neurbs.io.point_cloud import Block, PointSource, Request
from neurbs.io.reading import damaged
from neurbs.io.table import shown
from neurbs.io.units import of_length, symbol


def read_vertices(path: Path, request: Request) -> PointSource:
    """Read the vertices of all meshes and point clouds of a scene, in the frame of the scene."""
    suffix = path.suffix.lower()
    trimesh = require_for_file(path, "trimesh")
    content = path.read_bytes()
    if suffix == ".3mf":
        require_for_file(path, "networkx")
    if suffix == ".dae" and b"<!DOCTYPE" in content:
        raise damaged(path, "its XML must have no document type, which can name other files")
    if suffix == ".gltf":
        _check_embedded(path, content)
    # From bytes, because from a path the library would also read the files that the file names.
    scene = trimesh.load_scene(BytesIO(content), file_type=suffix.lstrip("."), process=False)
    parts = [_part(scene, node, request) for node in scene.graph.nodes_geometry]
    if not any(len(part.points) for part in parts):
        raise NeurbsError(f"{path}: must have at least one point, but has no vertices")
    if suffix == ".stl":
        parts = [Block(_distinct(part.points)) for part in parts]
    if any(part.colors is None for part in parts):
        parts = [Block(part.points) for part in parts]
    count = sum(len(part.points) for part in parts)
    return PointSource(iter(parts), count=count, unit=_unit(path, scene))


def _check_embedded(path: Path, content: bytes) -> None:
    """Check that a file in glTF names no other files."""
    for buffer in json.loads(content).get("buffers", []):
        name = str(buffer.get("uri", ""))
        if not name.startswith("data:"):
            raise NeurbsError(
                f"{path}: must have its data in itself, but they are in {shown(name)}: "
                "save it as .glb"
            )


def _unit(path: Path, scene: Any) -> str | None:
    """Return the unit of a scene. That of the glTF standard is the meter."""
    if path.suffix.lower() in (".glb", ".gltf"):
        return "m"
    units: set[str | None] = {geometry.units for geometry in scene.geometry.values()}
    unit = units.pop() if len(units) == 1 else None
    if unit is None:
        return None
    # The library gives any unit of Collada files as "0.0254 * meters".
    factor, _, name = unit.rpartition(" * ")
    return of_length(1000 * float(factor)) if factor else symbol(name)


def _part(scene: Any, node: str, request: Request) -> Block:
    """Return the vertices of one node of a scene, with their colors if there are any."""
    transform, name = scene.graph[node]
    geometry = scene.geometry[name]
    points = geometry.vertices @ transform[:3, :3].T + transform[:3, 3]
    visual = getattr(geometry, "visual", None)
    colors = visual.vertex_colors if visual is not None and visual.kind == "vertex" else None
    # A point cloud without colors has an empty array.
    colored = request.attributes and colors is not None and len(colors) == len(points)
    return Block(np.asarray(points), colors=np.asarray(colors)[:, :3] if colored else None)


def _distinct(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the points without repetitions, in their order."""
    _, first = np.unique(points, axis=0, return_index=True)
    return points[np.sort(first)]
