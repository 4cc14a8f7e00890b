"""The Kohonen network as an estimator."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs import _core


class ConvergenceWarning(UserWarning):
    """A training ended because its steps were over, not because the lattice had learned."""


class SelfOrganizingMap:
    """A quadrilateral lattice of nodes that learns scattered points.

    The training is the paper's (section 4): nodes start around the centroid of the points; each
    step presents one point, chosen at random, and moves the nearest node and its neighbours on the
    lattice towards it. The share of their way that they move, and how many edges away neighbours
    are, fall as Gaussians of time.

    Parameters
    ----------
    rows, cols : int, default 20
        Nodes along the two sides of the lattice, at least 2 each.
    gain_scale : float, optional
        Scale q of the gain on the time axis, in steps; by default a third of `max_steps`.
    radius_scale : float, optional
        Scale s of the radius on the time axis, in steps; by default such that the radius is zero
        after seven tenths of `max_steps`.
    max_steps : int, optional
        Steps after which training ends in any case; by default 500 for each node.
    reach : float, optional
        A point is on the lattice when a node is at most this far, in the points' unit; by default
        0.001 of the diagonal of their bounding box. When all are, training ends.
    min_change : float, optional
        Training ends when no node has moved farther than this during an epoch (as many steps as
        there are points, but at most five for each node) after the radius has become zero, in the
        points' unit; by default 0.05 of the lattice's mean spacing, which is the diagonal divided
        by the square root of the number of nodes.
    seed : int, default 0
        The same seed gives the same bits.

    Attributes
    ----------
    codebook_ : ndarray of shape (rows, cols, 3)
        The nodes' positions, read-only.
    n_iter_ : int
        Steps made.
    converged_ : bool
        Whether training ended by itself, not because its steps were over.
    stopped_by_ : str
        What ended it: ``"reached"`` (all points are on the lattice), ``"settled"`` (the lattice
        does not move any more) or ``"max_steps"``.
    ordered_at_ : int
        The paper's t₀: the step from which on the radius is zero.
    reached_ : int
        How many points are on the lattice.
    change_ : float or None
        Largest move of a node during the last epoch, in the points' unit; None if not even one was
        finished.

    Examples
    --------
    >>> import numpy as np
    >>> import neurbs
    >>> points = np.random.default_rng(0).random((13, 3))
    >>> som = neurbs.SelfOrganizingMap(rows=7, cols=8).fit(points)
    >>> som.stopped_by_, som.reached_
    ('reached', 13)
    >>> som.codebook_.shape
    (7, 8, 3)
    """

    codebook_: NDArray[np.float64]
    n_iter_: int
    converged_: bool
    stopped_by_: str
    ordered_at_: int
    reached_: int
    change_: float | None

    def __init__(
        self,
        rows: int = 20,
        cols: int = 20,
        *,
        gain_scale: float | None = None,
        radius_scale: float | None = None,
        max_steps: int | None = None,
        reach: float | None = None,
        min_change: float | None = None,
        seed: int = 0,
    ) -> None:
        self.rows = rows
        self.cols = cols
        self.gain_scale = gain_scale
        self.radius_scale = radius_scale
        self.max_steps = max_steps
        self.reach = reach
        self.min_change = min_change
        self.seed = seed

    def fit(
        self, points: ArrayLike, *, progress: Callable[[_core.Progress], object] | None = None
    ) -> SelfOrganizingMap:
        """Learn the points, forgetting what was learned before.

        Parameters
        ----------
        points : array_like of shape (n, 3) or (n, 2)
            At least four distinct points, not all on one line; two columns lie in z = 0.
        progress : callable, optional
            Called some 25 times a second with a `Progress`. An exception that it raises ends the
            training.

        Returns
        -------
        SelfOrganizingMap
            The map itself.

        Raises
        ------
        NeurbsError
            If the points cannot be a surface, or a parameter is out of its range.
        """
        trained = _core.train(
            points,
            grid=(self.rows, self.cols),
            gain_scale=self.gain_scale,
            radius_scale=self.radius_scale,
            max_steps=self.max_steps,
            reach=self.reach,
            min_change=self.min_change,
            seed=self.seed,
            progress=progress,
        )
        return self._learned(trained)

    def _learned(self, trained: _core.TrainedMap) -> SelfOrganizingMap:
        self.codebook_ = trained.codebook
        self.n_iter_ = trained.steps
        self.converged_ = trained.stopped_by != "max_steps"
        self.stopped_by_ = trained.stopped_by
        self.ordered_at_ = trained.ordered_at
        self.reached_ = trained.reached
        self.change_ = trained.change
        return self

    def __repr__(self) -> str:
        """Say what it is, and whether it has learned."""
        state = f", {self.stopped_by_}" if hasattr(self, "stopped_by_") else ""
        return f"SelfOrganizingMap(rows={self.rows}, cols={self.cols}{state})"
