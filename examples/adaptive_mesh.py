"""Draw an adaptive mesh: large triangles where the surface is flat, small ones where it bends.

    python examples/adaptive_mesh.py out.png

The surface is a drop in water: ripples around a peak that fade outward. Matplotlib draws the
picture, triangle by triangle from back to front.
"""

from __future__ import annotations

import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import LinearSegmentedColormap

import neurbs

TOLERANCE = 5e-4
"""Distance between mesh and surface, as a share of the diagonal of the net."""

SIDE = 48
"""Interpolated points along a side."""


def drop() -> neurbs.NurbsSurface:
    """Interpolate ripples around a peak."""
    side = np.linspace(-1, 1, SIDE)
    x, y = np.meshgrid(side, side, indexing="ij")
    r = np.hypot(x, y)
    z = 0.22 * np.exp(-((r / 0.14) ** 2)) + 0.16 * np.cos(15 * r) * np.exp(-2.6 * r)
    return neurbs.NurbsSurface.interpolate(np.stack([x, y, z], axis=-1))


def draw(mesh: neurbs.TriangleMesh, path: str) -> None:
    """Draw a mesh in perspective, with light from the left."""
    eye, target = np.array([1.55, -2.1, 1.75]), np.array([0.0, 0.0, 0.0])
    ahead = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(ahead, [0, 0, 1])
    right /= np.linalg.norm(right)
    up = np.cross(right, ahead)
    seen = (mesh.vertices - eye) @ np.stack([right, up, ahead]).T
    flat = seen[:, :2] / seen[:, 2:]
    corners, depth = flat[mesh.triangles], seen[mesh.triangles][:, :, 2].mean(axis=1)
    a, b, c = (mesh.vertices[corner] for corner in mesh.triangles.T)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    light = np.array([-0.55, -0.35, 0.76])
    diffuse = np.clip(normals @ light, 0, 1)
    half = light - ahead
    shine = np.clip(normals @ (half / np.linalg.norm(half)), 0, 1) ** 40
    height = (a[:, 2] + b[:, 2] + c[:, 2]) / 3
    hue = np.clip((height + 0.13) / 0.36, 0, 1)
    water = LinearSegmentedColormap.from_list("water", ["#07364f", "#0f7c8c", "#9fd6cf", "#fff4dd"])
    base = water(hue)[:, :3]
    colors = np.clip(base * (0.45 + 0.65 * diffuse[:, None]) + 0.35 * shine[:, None], 0, 1)
    order = np.argsort(-depth)
    figure, axes = plt.subplots(figsize=(12, 7.4))
    lines = PolyCollection(
        corners[order],
        facecolors=colors[order],
        edgecolors=(0.02, 0.16, 0.24, 0.5),
        linewidths=0.35,
        joinstyle="round",
    )
    axes.add_collection(lines)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.margins(0.02)
    axes.axis("off")
    figure.savefig(path, dpi=130, bbox_inches="tight", pad_inches=0.05, facecolor="white")
    plt.close(figure)


if __name__ == "__main__":
    surface = drop()
    tessellation = surface.tessellate(TOLERANCE, relative=True)
    print(f"{tessellation}, within {tessellation.max_deviation:.2g}")
    draw(tessellation, sys.argv[1] if len(sys.argv) > 1 else "adaptive_mesh.png")
