"""What can be asked of a map that has learned."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs import _core
from neurbs.som_estimator import not_fitted


class TrainedMap:
    """The learned attributes and the measures of `neurbs.SelfOrganizingMap`."""

    _map: _core.Map

    @property
    def codebook_(self) -> NDArray[np.float64]:
        """The nodes' positions, read-only."""
        return self._learned().codebook

    @property
    def lattice_(self) -> _core.Lattice:
        """The lattice: its nodes and edges."""
        return self._learned().lattice

    @property
    def n_iter_(self) -> int:
        """Steps made."""
        return self._learned().steps

    @property
    def converged_(self) -> bool:
        """Whether training ended by itself."""
        return self._learned().converged

    @property
    def stopped_by_(self) -> str:
        """What ended the training."""
        return self._learned().stopped_by

    @property
    def ordered_at_(self) -> int:
        """The paper's t₀."""
        return self._learned().ordered_at

    @property
    def reached_(self) -> int:
        """How many points are on the lattice."""
        return self._learned().reached

    @property
    def change_(self) -> float | None:
        """Largest move of a node during the last epoch, in the points' unit."""
        return self._learned().change

    @property
    def error_(self) -> float | None:
        """Mean distance from points to their winners during the last epoch."""
        return self._learned().error

    def predict(
        self, points: ArrayLike, *, out: NDArray[np.int64] | None = None
    ) -> NDArray[np.int64]:
        """Return the number of each point's nearest node, the lowest among equals.

        Nodes are numbered row by row, ``divmod(number, cols)`` is row and column. `out`, of shape
        (n,), is where to write the result.
        """
        return self._learned().predict(points, out)

    def transform(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return each point's place on the lattice: `parametrize` as scikit-learn names it."""
        return self.parametrize(points)

    def parametrize(
        self,
        points: ArrayLike,
        *,
        extrapolation: float = 0.75,
        out: NDArray[np.float64] | None = None,
    ) -> NDArray[np.float64]:
        """Return each point's continuous place on the lattice.

        It is the foot of the point on the nearest bilinear cell around its nearest node.

        Parameters
        ----------
        points : array_like of shape (n, 3) or (n, 2)
            The points.
        extrapolation : float, default 0.75
            How many cells the lattice goes on beyond its border, from 0 to 1.
        out : ndarray of shape (n, 2), optional
            Where to write the result.

        Returns
        -------
        ndarray of shape (n, 2)
            (u, v) along rows and columns, in [0, 1]² on the lattice; closed directions have the
            period 1.
        """
        return self._learned().parametrize(points, extrapolation, out)

    def quantization_error(self, points: ArrayLike) -> float:
        """Return the mean distance from a point to its nearest node, in the points' unit.

        NaN of no points, as means are.
        """
        return self._learned().quantization_error(points)

    def topographic_error(self, points: ArrayLike) -> float:
        """Return the share of points whose two nearest nodes share neither an edge nor a cell.

        NaN of no points, as means are.
        """
        return self._learned().topographic_error(points)

    def hits(self, points: ArrayLike) -> NDArray[np.int64]:
        """Return how many points each node is the nearest of, shape (rows, cols) or (nodes,)."""
        return self._learned().hits(points)

    def unused_nodes(self, points: ArrayLike) -> NDArray[np.int64]:
        """Return the numbers of the nodes that are the nearest of no point."""
        return np.flatnonzero(self.hits(points).ravel() == 0)

    def u_matrix(self) -> NDArray[np.float64]:
        """Return each node's mean distance to its neighbours, shape (rows, cols) or (nodes,)."""
        return self._learned().u_matrix()

    def fold_overs(self) -> int | None:
        """Return how many pairs of neighbouring cells are folded over; None for a graph."""
        return self._learned().fold_overs()

    def mesh(self) -> _core.TriangleMesh:
        """Return the lattice as triangles, two to a cell; vertex k is node k.

        Returns
        -------
        TriangleMesh
            Closed where the lattice is; its `uv` run from 0 to 1 along rows and columns.

        Raises
        ------
        NeurbsError
            If the lattice is a graph, which has no cells.
        """
        lattice = self._learned().lattice
        if lattice.cells is None:
            raise _core.NeurbsError("lattice must have cells to become a mesh, got a graph")
        closed = (lattice.topology in ("tube", "torus"), lattice.topology == "torus")
        bilinear = _core.NurbsSurface(self.codebook_, degree=1, closed=closed)
        # Every knot of degree 1 is a crease: a tolerance of the size leaves the cells as they are.
        return bilinear.tessellate(10.0, relative=True)

    def _learned(self) -> _core.Map:
        if not hasattr(self, "_map"):
            raise not_fitted("this SelfOrganizingMap has not learned yet: call fit first")
        return self._map
