"""Draw each start and each topology of the self-organizing map.

The first row shows the starts. The second row shows the maps after training: batch training from
ordered starts, online training from random ones. The third row shows other topologies and kernels.
The title of a trained map has the number of cells that are folded over, if it has cells, and
the share of points whose two nearest nodes are not neighbors.

python examples/som_starts.py [PICTURE]
"""

import sys
from typing import Any, Literal

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


def zigzag(rows: int, cols: int) -> NDArray[np.float64]:
    """Return a net that follows the S roughly: straight from one of its turns to the next."""
    turns = np.linspace(0, 3 * np.pi, 7)
    x = np.where(turns < 1.5 * np.pi, np.sin(turns), -2 - np.sin(turns))
    along = np.linspace(0, 3 * np.pi, rows)
    u, v = np.meshgrid(along, np.linspace(0, 3, cols), indexing="ij")
    return np.stack([np.interp(u, turns, x), v, np.interp(u, turns, -np.cos(turns))], axis=-1)


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
    sheet = fold(3000)
    starts: list[tuple[str, Any]] = [
        (name, name)
        for name in ("geodesic", "auto", "pca", "centroid", "densest-cluster", "random")
    ]
    starts.insert(3, ("a net", zigzag(24, 8)))
    web = neurbs.Lattice.graph(61, _spider_web(5, 12))
    others: list[tuple[str, NDArray[np.float64], dict[str, Any]]] = [
        ("topology=tube", tube(3000), {"rows": 16, "cols": 12, "topology": "tube"}),
        ("topology=torus", torus(4000), {"rows": 24, "cols": 12, "topology": "torus"}),
        ("lattice=triangular", hill(3000), {"rows": 10, "cols": 12, "lattice": "triangular"}),
        (
            "triangular torus",
            torus(4000),
            {"rows": 24, "cols": 12, "lattice": "triangular", "topology": "torus"},
        ),
        ("lattice=graph", disc(3000), {"lattice": web}),
        ("kernel=linear", hill(3000), {"rows": 10, "cols": 12}),
        ("kernel=mean", hill(3000), {"rows": 10, "cols": 12, "kernel": "mean"}),
    ]
    figure = plt.figure(figsize=(17, 8))
    axes = [figure.add_subplot(3, 7, place, projection="3d") for place in range(1, 22)]
    for place, (name, init) in enumerate(starts):
        training: Literal["batch", "online"] = (
            "online" if name in ("centroid", "densest-cluster", "random") else "batch"
        )
        som = neurbs.SelfOrganizingMap(24, 8, init=init, training=training).start(sheet)
        _draw(axes[place], f"init={name}", sheet, som)
        som.resume(sheet)
        _draw(axes[7 + place], f"{training}: {_quality(som, sheet)}", sheet, som)
    for ax, (title, points, options) in zip(axes[14:], others, strict=True):
        som = neurbs.SelfOrganizingMap(**options).fit(points)
        _draw(ax, f"{title}\n{_quality(som, points)}", points, som)
    figure.tight_layout()
    figure.savefig(path, dpi=80)


def _draw(
    axes: Any, title: str, points: NDArray[np.float64], som: neurbs.SelfOrganizingMap
) -> None:
    axes.scatter(*points[::4].T, color="tab:red", s=0.5, alpha=0.5)
    nodes = som.codebook_.reshape(-1, 3)
    for edge in som.lattice_.edges:
        axes.plot(*nodes[list(edge)].T, color="tab:blue", linewidth=0.7)
    axes.set_title(title, fontsize=8)
    axes.set(xticks=[], yticks=[], zticks=[])
    axes.set_aspect("equal")


def _quality(som: neurbs.SelfOrganizingMap, points: NDArray[np.float64]) -> str:
    folds = som.fold_overs()
    torn = f"torn {som.topographic_error(points):.1%}"
    # A graph has no cells that could be folded.
    return torn if folds is None else f"{folds} folds, {torn}"


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
