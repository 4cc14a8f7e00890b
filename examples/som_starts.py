"""A picture of each start and each topology of the self-organizing map.

python examples/som_starts.py [PICTURE]
"""

import sys
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

import neurbs


def fold(count: int) -> NDArray[np.float64]:
    """Return points on a sheet folded like an S."""
    angle, y = np.random.default_rng(0).random((2, count)) * [[3 * np.pi], [3.0]]
    x = np.where(angle < 1.5 * np.pi, np.sin(angle), -2 - np.sin(angle))
    return np.column_stack([x, y, -np.cos(angle)])


def tube(count: int) -> NDArray[np.float64]:
    """Return points on a bent tube."""
    a, t = np.random.default_rng(0).random((2, count)) * [[2 * np.pi], [3.0]]
    return np.column_stack([np.cos(a) + 0.3 * t**1.5, np.sin(a), t])


def torus(count: int) -> NDArray[np.float64]:
    """Return points on a torus."""
    a, b = np.random.default_rng(0).random((2, count)) * 2 * np.pi
    ring = 3 + np.cos(b)
    return np.column_stack([ring * np.cos(a), ring * np.sin(a), np.sin(b)])


def disc(count: int) -> NDArray[np.float64]:
    """Return points on a dome over a disc."""
    angle, square = np.random.default_rng(0).random((2, count)) * [[2 * np.pi], [1.0]]
    radius = np.sqrt(square)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), -0.7 * square])


def hill(count: int) -> NDArray[np.float64]:
    """Return points on a hill over a square."""
    x, y = np.random.default_rng(0).random((2, count)) * 2 - 1
    return np.column_stack([x, y, 0.6 * np.exp(-2 * (x**2 + y**2))])


def main(path: str) -> None:
    """Draw each map over its points."""
    web = neurbs.Lattice.graph(61, _spider_web(5, 12))
    cases: list[tuple[str, NDArray[np.float64], dict[str, Any]]] = [
        (f"init={init}", fold(3000), {"rows": 24, "cols": 8, "init": init})
        for init in ("geodesic", "pca", "centroid", "densest-cluster", "random")
    ]
    cases += [
        ("topology=tube", tube(3000), {"rows": 16, "cols": 12, "topology": "tube"}),
        ("topology=torus", torus(4000), {"rows": 24, "cols": 12, "topology": "torus"}),
        ("lattice=triangular", hill(3000), {"rows": 10, "cols": 12, "lattice": "triangular"}),
        ("lattice=graph", disc(3000), {"lattice": web}),
        ("kernel=mean", hill(3000), {"rows": 10, "cols": 12, "kernel": "mean"}),
    ]
    figure = plt.figure(figsize=(15, 6.5))
    for place, (title, points, options) in enumerate(cases, 1):
        som = neurbs.SelfOrganizingMap(**options).fit(points)
        axes = figure.add_subplot(2, 5, place, projection="3d")
        axes.scatter(*points[::4].T, color="tab:red", s=0.5, alpha=0.5)
        nodes = som.codebook_.reshape(-1, 3)
        for edge in som._lattice().edges:
            axes.plot(*nodes[list(edge)].T, color="tab:blue", linewidth=0.7)
        error = som.topographic_error(points)
        axes.set_title(f"{title}\n{som.fold_overs()} folds, torn {error:.1%}", fontsize=9)
        axes.set(xticks=[], yticks=[], zticks=[])
        axes.set_aspect("equal")
    figure.tight_layout()
    figure.savefig(path, dpi=80)


def _spider_web(rings: int, spokes: int) -> list[tuple[int, int]]:
    """Return the edges of a web: node 0 in the middle, then ring after ring."""
    edges = [(0, 1 + spoke) for spoke in range(spokes)]
    for ring in range(rings):
        for spoke in range(spokes):
            node = 1 + ring * spokes + spoke
            edges.append((node, 1 + ring * spokes + (spoke + 1) % spokes))
            if ring + 1 < rings:
                edges.append((node, node + spokes))
    return edges


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "som_starts.png")
