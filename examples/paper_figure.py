"""Draw figure 1 of the paper: scattered points, the grid that has learned them, and the surface.

python examples/paper_figure.py [PICTURE]
"""

import sys

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np

import neurbs


def main(path: str) -> None:
    """Draw the grid and the surface side by side."""
    x, y = np.random.default_rng(1).random((2, 60))
    points = np.column_stack([x, y, 0.35 * np.sin(3.5 * x) * np.cos(2.5 * y)])
    # A slower fall of the radius than the default leaves fewer folds.
    som = neurbs.SelfOrganizingMap.paper(
        points, presentation="skip-reached", radius=("gaussian", None, 32_370.0)
    ).fit(points)
    grid = som.codebook_
    surface = neurbs.NurbsSurface(grid)
    u = v = np.linspace(0, 1, 40)
    drawn = surface.evaluate_grid(u, v)
    figure = plt.figure(figsize=(10, 4.2))
    for place, (title, net) in enumerate(
        [(f"Grid of {grid.shape[0]} × {grid.shape[1]} nodes", grid), ("NURBS surface", drawn)], 1
    ):
        axes = figure.add_subplot(1, 2, place, projection="3d")
        axes.scatter(*points.T, color="tab:red", s=12, depthshade=False)
        axes.plot_wireframe(*np.moveaxis(net, 2, 0), color="tab:blue", linewidth=0.6)
        axes.set(title=title, box_aspect=(1, 1, 0.5), xticks=[], yticks=[], zticks=[])
        axes.view_init(35, -60)
    figure.tight_layout()
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "paper_figure.png")
