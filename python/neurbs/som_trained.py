"""Attributes, projection and quality measures of a trained map."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs import _core
from neurbs.som_estimator import not_fitted


class TrainedMap:
    """The attributes and methods of a trained `neurbs.SelfOrganizingMap`."""

    _map: _core.Map

    @property
    def codebook_(self) -> NDArray[np.float64]:
        """The positions of the nodes, read-only."""
        return self._trained().codebook

    @property
    def lattice_(self) -> _core.Lattice:
        """The lattice: its nodes and edges."""
        return self._trained().lattice

    @property
    def n_iter_(self) -> int:
        """Number of steps."""
        return self._trained().steps

    @property
    def converged_(self) -> bool:
        """Whether training ended before `max_steps`."""
        return self._trained().converged

    @property
    def stopped_by_(self) -> str:
        """Reason for the end of training."""
        return self._trained().stopped_by

    @property
    def ordered_at_(self) -> int:
        """The paper's t₀: the first step at which the radius was less than one edge."""
        return self._trained().ordered_at

    @property
    def reached_(self) -> int:
        """Number of points on the lattice."""
        return self._trained().reached

    @property
    def change_(self) -> float | None:
        """Largest move of a node during the last epoch, in the points' unit."""
        return self._trained().change

    @property
    def error_(self) -> float | None:
        """Mean distance from points to their winners during the last epoch."""
        return self._trained().error

    def predict(
        self, points: ArrayLike, *, out: NDArray[np.int64] | None = None
    ) -> NDArray[np.int64]:
        """Return the number of each point's nearest node; of equally near ones the lowest.

        Nodes are numbered row by row: ``divmod(number, cols)`` is (row, column). The result is
        written to `out` of shape (n,) if it is given.
        """
        return self._trained().predict(points, out)

    def transform(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return each point's place on the lattice: `parametrize` under scikit-learn's name."""
        return self.parametrize(points)

    def parametrize(
        self,
        points: ArrayLike,
        *,
        extrapolation: float = 0.75,
        out: NDArray[np.float64] | None = None,
    ) -> NDArray[np.float64]:
        """Return each point's parameters on the lattice, for `NurbsSurface.fit`.

        Each point is projected onto the nearest bilinear cell around its nearest node.

        Parameters
        ----------
        points : array_like of shape (n, 3) or (n, 2)
            The points.
        extrapolation : float, default 0.75
            Extension of the lattice beyond its border in cells, from 0 to 1.
        out : ndarray of shape (n, 2), optional
            Array for the result.

        Returns
        -------
        ndarray of shape (n, 2)
            (u, v) along rows and columns, in [0, 1]². In an open direction 0 and 1 are the ends of
            the extended lattice, without extrapolation the outermost nodes. The period of a closed
            direction is 1.
        """
        return self._trained().parametrize(points, extrapolation, out)

    def quantization_error(self, points: ArrayLike) -> float:
        """Return the mean distance from a point to its nearest node, in the points' unit.

        NaN if there are no points.
        """
        return self._trained().quantization_error(points)

    def topographic_error(self, points: ArrayLike) -> float:
        """Return the share of points whose two nearest nodes share neither an edge nor a cell.

        NaN if there are no points.
        """
        return self._trained().topographic_error(points)

    def hits(self, points: ArrayLike) -> NDArray[np.int64]:
        """Return the number of points nearest to each node, shape (rows, cols) or (nodes,)."""
        return self._trained().hits(points)

    def unused_nodes(self, points: ArrayLike) -> NDArray[np.int64]:
        """Return the numbers of the nodes that are nearest to no point."""
        return np.flatnonzero(self.hits(points).ravel() == 0)

    def u_matrix(self) -> NDArray[np.float64]:
        """Return each node's mean distance to its neighbors, shape (rows, cols) or (nodes,)."""
        return self._trained().u_matrix()

    def fold_overs(self) -> int | None:
        """Return the number of neighboring cells that fold over each other; None for a graph."""
        return self._trained().fold_overs()

    def mesh(self) -> _core.TriangleMesh:
        """Return the lattice as triangles, two to a cell; vertex k is node k.

        Returns
        -------
        TriangleMesh
            Closed where the lattice is closed; its `uv` run from 0 to 1 along rows and columns.

        Raises
        ------
        NeurbsError
            If the lattice is a graph: graphs have no cells.
        """
        lattice = self._trained().lattice
        if lattice.cells is None:
            raise _core.NeurbsError("lattice must have cells to become a mesh, got a graph")
        closed = (lattice.topology in ("tube", "torus"), lattice.topology == "torus")
        bilinear = _core.NurbsSurface(self.codebook_, degree=1, closed=closed)
        # Knots of degree 1 are creases, which become edges: a large tolerance adds no vertices.
        return bilinear.tessellate(10.0, relative=True)

    def _trained(self) -> _core.Map:
        if not hasattr(self, "_map"):
            raise not_fitted("this SelfOrganizingMap is not trained yet: call fit first")
        return self._map
