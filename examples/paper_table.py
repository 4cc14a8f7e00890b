"""Print the table of the paper's section 4.3: special against original presentation, 100 runs each.

    python examples/paper_table.py [--runs N]

The paper does not give the number of points, the scales q and s, the distance at which a point is
on the grid, or the condition of failure. About thirty choices were tried; this one resembles the
paper most: points of a wavy sheet, the paper's 4 n nodes, a start around the centroid, `REACH` of
the diagonal, s such that the radius is less than one edge at `T0`, `GAIN_SCALE` for q, and failure
after `MAX_STEPS`.
"""

import argparse
from typing import Any

import numpy as np

import neurbs

POINTS = 100
REACH = 0.01
T0 = 2000
GAIN_SCALE = 6000.0
MAX_STEPS = 12_000
PAPER = {"special": (3265, 328, 0), "original": (6821, 1747, 13)}


def main() -> None:
    """Print the table of neurbs beside that of the paper."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=100)
    runs: int = parser.parse_args().runs
    rows = [
        f"| {runs} runs each | special, ours | original, ours | special, paper | original, paper |"
    ]
    rows.append("| --- | --- | --- | --- | --- |")
    columns = [row("skip-reached", runs), row("random", runs), *PAPER.values()]
    names = ("mean number of steps", "standard deviation", "failed")
    for name, values in zip(names, zip(*columns, strict=True), strict=True):
        rows.append(f"| {name} | " + " | ".join(f"{value:.0f}" for value in values) + " |")
    print("\n".join(rows))


def row(presentation: str, runs: int) -> tuple[float, float, int]:
    """Return mean and deviation of the steps of the runs that did not fail, and how many did."""
    results = [train(presentation, seed) for seed in range(runs)]
    steps = [som.n_iter_ for som in results if som.stopped_by_ == "reached"]
    return float(np.mean(steps)), float(np.std(steps)), runs - len(steps)


def train(presentation: str, seed: int, **options: Any) -> neurbs.SelfOrganizingMap:
    """Train by the paper's section 4."""
    x, y = np.random.default_rng(0).random((2, POINTS))
    points = np.column_stack([x, y, 0.3 * np.sin(3 * x) * np.cos(2 * y)])
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    som = neurbs.SelfOrganizingMap.paper(points, presentation=presentation, seed=seed)
    # The radius starts at half the number of points and falls below one edge at T0.
    edges = som.rows + som.cols - 2
    scale = T0 / np.sqrt(2 * np.log(min(POINTS / 2, edges)))
    som.set_params(
        radius=("gaussian", None, float(scale)),
        gain=("gaussian", None, GAIN_SCALE),
        max_steps=MAX_STEPS,
        reach=REACH * diagonal,
        # A run ends when all points are reached, not when the lattice stops moving.
        min_change=1e-12 * diagonal,
        **options,
    )
    return som.fit(points)


if __name__ == "__main__":
    main()
