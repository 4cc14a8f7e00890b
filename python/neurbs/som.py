"""The Kohonen network as an estimator."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs import _core
from neurbs.errors import argument_error
from neurbs.som_chunks import ChunkLearner
from neurbs.som_estimator import Estimator
from neurbs.som_trained import TrainedMap

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Lattice = _core.Lattice

Schedule: TypeAlias = float | tuple[Any, ...] | Callable[[float], float]
"""How gain or radius change in time; see `SelfOrganizingMap`."""


class SelfOrganizingMap(Estimator, ChunkLearner, TrainedMap):
    """A lattice of nodes that learns scattered points.

    A point moves the node nearest to it, its winner, and the winner's neighbours on the lattice,
    so that nodes come to the points and stay in order. Training is either Kohonen's batch map,
    which looks at all points in each epoch, or online, one point at a time, as in the paper
    (`SelfOrganizingMap.paper` sets all of that).

    Parameters
    ----------
    rows, cols : int, default 20
        Nodes along the two sides of the lattice, at least 2 each (3 where it is closed).
    topology : {"sheet", "tube", "torus"}, default "sheet"
        Whether rows, or rows and columns, are closed to rings.
    lattice : {"quad", "triangular"} or Lattice, default "quad"
        Whether inner nodes have four or six neighbours; a `Lattice` (as from `Lattice.graph`)
        overrides `rows`, `cols` and `topology`.
    training : {"batch", "online"}, default "batch"
        How nodes learn.
    init : str or array_like, default "pca"
        Where the nodes are before: in order on the principal plane (``"pca"``; closed lattices by
        angles about the principal axes), in order by distances along the surface
        (``"geodesic"``), whichever of these two suits the points better (``"auto"``: layers that
        touch mislead distances along the surface), small random values around the centroid
        (``"centroid"``), the densest cluster (``"densest-cluster"``) or the origin
        (``"random"``); or an array of positions.
    neighborhood : {"gaussian", "bubble"}, default "gaussian"
        How much neighbours follow the winner: ``exp(-(d / radius)² / 2)`` at a distance of d
        cells, or fully as far as `radius` edges reach.
    kernel : {"mean", "linear"}, optional
        What a node makes of the points around it in batch training: their weighted mean, or the
        value of a line fitted to them, which does not shrink the lattice at its border. By default
        linear where it can be: with Gaussian neighbourhoods on quadrilateral grids.
    presentation : {"random", "skip-reached", "shuffled"}, default "random"
        Which points are presented in online training: any; once the radius is zero, none that the
        lattice has reached; or all in each epoch, in random order.
    gain, radius : number, tuple or callable, optional
        The share of their way that nodes move in online training, and how far on the lattice the
        neighbourhood reaches, in cells. A number is constant; ``("linear", start, end)``,
        ``("exponential", start, end)`` and ``("table", values)`` go from the first step to the
        last; ``("gaussian", start, scale)`` is the paper's, with its scale q or s in steps, where
        parts left out or None are calculated. A callable gets the share of the training that is
        done, from 0 to 1; it is asked at 4097 places beforehand. By default the gain is the
        paper's, and the radius falls exponentially from a quarter of the longer side (at most a
        sixth of a closed one) to 0.7, or as the paper's if the neighbourhood is a bubble.
    epochs : int, optional
        Passes over the points, by default 20 in batch training and as `max_steps` says online.
    max_steps : int, optional
        Steps after which training ends in any case: epochs of batch training, presentations of
        online training; for the latter by default 500 for each node.
    reach : float, optional
        A point is on the lattice when a node is at most this far, in the points' unit; by default
        0.001 of the diagonal of their bounding box. When all are, training ends.
    min_change : float, optional
        Training ends when no node has moved farther than this during an epoch (online: as many
        steps as there are points, but at most five for each node) after the radius has become zero
        or ceased to change, in the points' unit; by default 0.05 of the lattice's mean spacing,
        which is the diagonal divided by the square root of the number of nodes.
    seed : int, default 0
        The same seed gives the same bits, on any number of threads.

    Attributes
    ----------
    codebook_ : ndarray of shape (rows, cols, 3), or (nodes, 3) for a graph
        The nodes' positions, read-only.
    n_iter_ : int
        Steps made.
    converged_ : bool
        Whether training ended by itself, not because its steps were over.
    stopped_by_ : str
        What ended it: ``"reached"`` (all points are on the lattice), ``"settled"`` (the lattice
        does not move any more), ``"max_steps"``, or ``"unfinished"``: it was interrupted or is
        fed chunk by chunk.
    ordered_at_ : int
        The paper's t₀: the step from which on the radius is less than an edge.
    reached_ : int
        How many points are on the lattice.
    change_ : float or None
        Largest move of a node during the last epoch, in the points' unit; None if not even one was
        finished.
    error_ : float or None
        Mean distance from points to their winners during the last epoch, in the points' unit.

    References
    ----------
    M. Hoffmann and L. Várady, Free-form Surfaces for Scattered Data by Neural Networks, Journal
    for Geometry and Graphics 2 (1998). T. Kohonen, Self-Organizing Maps, 3rd edition (2001).

    Examples
    --------
    >>> import numpy as np
    >>> import neurbs
    >>> x, y = np.random.default_rng(0).random((2, 5000))
    >>> points = np.column_stack([x, y, x * y])
    >>> som = neurbs.SelfOrganizingMap(rows=12, cols=10).fit(points)
    >>> som.codebook_.shape, som.n_iter_
    ((12, 10, 3), 20)
    >>> bool(som.quantization_error(points) < 0.05), som.fold_overs()
    (True, 0)
    >>> uv = som.parametrize(points)
    >>> uv.shape
    (5000, 2)
    """

    def __init__(
        self,
        rows: int = 20,
        cols: int = 20,
        *,
        topology: str = "sheet",
        lattice: str | Lattice = "quad",
        training: str = "batch",
        init: str | ArrayLike = "pca",
        neighborhood: str = "gaussian",
        kernel: str | None = None,
        presentation: str = "random",
        gain: Schedule | None = None,
        radius: Schedule | None = None,
        epochs: int | None = None,
        max_steps: int | None = None,
        reach: float | None = None,
        min_change: float | None = None,
        seed: int = 0,
    ) -> None:
        self.rows = rows
        self.cols = cols
        self.topology = topology
        self.lattice = lattice
        self.training = training
        self.init = init
        self.neighborhood = neighborhood
        self.kernel = kernel
        self.presentation = presentation
        self.gain = gain
        self.radius = radius
        self.epochs = epochs
        self.max_steps = max_steps
        self.reach = reach
        self.min_change = min_change
        self.seed = seed

    @classmethod
    def paper(cls, points: ArrayLike, **parameters: Any) -> SelfOrganizingMap:
        """Return a map with all the paper's settings for these points, not yet trained.

        Online training with a bubble, both radius and gain Gaussians of time, a start around the
        centroid, random presentation; four nodes for each of few points, and a convenient number
        (at least 400, at most 2500) for many.

        Parameters
        ----------
        points : array_like of shape (n, 3) or (n, 2)
            The points that it will learn; only their number counts here.
        **parameters
            What shall be otherwise, as the constructor has it.

        Examples
        --------
        >>> import numpy as np
        >>> import neurbs
        >>> points = np.random.default_rng(0).random((13, 3))
        >>> som = neurbs.SelfOrganizingMap.paper(points).fit(points)
        >>> som.codebook_.shape, som.stopped_by_, som.reached_
        ((7, 8, 3), 'reached', 13)
        """
        count = len(_core.as_points(points))
        rows, cols = _core.lattice_for_points(count)
        return cls(**({"rows": rows, "cols": cols} | _core.som_options(paper=True) | parameters))

    def fit(
        self,
        points: ArrayLike,
        y: object = None,
        *,
        progress: Callable[[_core.Progress], object] | None = None,
        observer: Callable[[_core.Epoch], object] | None = None,
        checkpoint: str | os.PathLike[str] | None = None,
        checkpoint_seconds: float = 60.0,
    ) -> SelfOrganizingMap:
        """Learn the points, forgetting what was learned before.

        An epoch of batch training costs O(n log m + m (rows + cols)) for n points and m nodes of a
        grid, a step of online training O(m).

        Parameters
        ----------
        points : array_like of shape (n, 3) or (n, 2)
            At least four distinct points, not all on one line; two columns lie in z = 0.
        y : object
            Not used; scikit-learn's pipelines pass it.
        progress : callable, optional
            Called some 25 times a second with a `Progress`. An exception that it raises ends the
            training.
        observer : callable, optional
            Called at the end of each epoch with an `Epoch`, which has its error, radius and
            lattice. An exception that it raises ends the training.
        checkpoint : path, optional
            A file to which the map is saved every `checkpoint_seconds` and at the end; `load` it
            and `resume` the training with the same result as without an interruption.
        checkpoint_seconds : float, default 60
            Seconds between two saves.

        Returns
        -------
        SelfOrganizingMap
            The map itself.

        Raises
        ------
        NeurbsError
            If the points cannot be a surface, or a parameter is out of its range.
        KeyboardInterrupt
            On Ctrl-C, at once. What was learned so far is kept, and `resume` goes on from there.
        """
        points = _core.as_points(points)
        return self.start(points).resume(
            points,
            progress=progress,
            observer=observer,
            checkpoint=checkpoint,
            checkpoint_seconds=checkpoint_seconds,
        )

    def start(self, points: ArrayLike) -> SelfOrganizingMap:
        """Lay the lattice out before any training, forgetting what was learned.

        What is learned is the start then, and `resume` trains it: `fit` is the two of them.
        """
        self._map = _core.Map(_core.as_points(points), self._lattice(), self._options())
        return self

    def resume(
        self,
        points: ArrayLike,
        *,
        progress: Callable[[_core.Progress], object] | None = None,
        observer: Callable[[_core.Epoch], object] | None = None,
        checkpoint: str | os.PathLike[str] | None = None,
        checkpoint_seconds: float = 60.0,
    ) -> SelfOrganizingMap:
        """Go on with an interrupted or loaded training, to the same result as without a break.

        Parameters are those of `fit`; the points must be the same too.
        """
        points = _core.as_points(points)
        seconds = None if checkpoint is None else checkpoint_seconds
        ended = False
        while not ended:
            ended = self._learned().train(
                points, progress=progress, observer=observer, seconds=seconds
            )
            if checkpoint is not None:
                self.save(checkpoint)
        return self

    def fit_predict(self, points: ArrayLike, y: object = None) -> NDArray[np.int64]:
        """Learn the points and return the number of each one's nearest node."""
        return self.fit(points).predict(points)

    def fit_transform(self, points: ArrayLike, y: object = None) -> NDArray[np.float64]:
        """Learn the points and return each one's place on the lattice, as `transform` does."""
        return self.fit(points).transform(points)

    def animate(
        self, points: ArrayLike, path: str | os.PathLike[str], *, seconds: float = 6.0
    ) -> SelfOrganizingMap:
        """Learn the points as `fit` does, and write a film of it: see `neurbs.plot.animate`."""
        from neurbs.plot import animate

        return animate(self, points, path, seconds=seconds)

    def plot(self, points: ArrayLike | None = None, *, color: str | None = None) -> Figure:
        """Draw the map, with the points if they are given: see `neurbs.plot.plot_map`."""
        from neurbs.plot import plot_map

        return plot_map(self, points, color=color)

    def _repr_html_(self) -> str:
        from neurbs.plot import map_html

        return map_html(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the map, with its training, to a NumPy archive (.npz).

        The archive holds `codebook`, `parameters` (JSON) and the state from which `load` makes the
        map again, to the last bit, with what `partial_fit` has seen of an epoch. A callable
        schedule is kept as the table of its values.
        """
        from neurbs.som_archive import write_archive

        learned = self._learned()
        write_archive(path, self.get_params(), learned, self._pending, self._drawn)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> SelfOrganizingMap:
        """Return the map that `save` has written.

        Raises
        ------
        NeurbsError
            If the file is not such an archive.
        OSError
            If it cannot be read.
        """
        from neurbs.som_archive import read_archive

        parameters, learned, pending, drawn = read_archive(path)
        som = cls(**parameters)
        som._map, som._pending, som._drawn = learned, pending, drawn
        return som

    def _start(self, points: NDArray[np.float64], *, chunks: bool = False) -> None:
        """Forget what was learned, and lay the nodes out for these points."""
        self._map = _core.Map(points, self._lattice(), self._options(), chunks=chunks)
        self._pending = self._drawn = None

    def _lattice(self) -> Lattice:
        if isinstance(self.lattice, Lattice):
            return self.lattice
        if not isinstance(self.lattice, str) or self.lattice not in ("quad", "triangular"):
            raise argument_error(
                "lattice", f"must be 'quad', 'triangular' or a Lattice, got {self.lattice!r}"
            )
        if self.topology is None:
            raise argument_error("topology", "must be 'sheet', 'tube' or 'torus', got None")
        return Lattice.grid(self.rows, self.cols, cells=self.lattice, topology=self.topology)

    def _options(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in _core.som_options(paper=False)}

    @classmethod
    def _of_core(cls, trained: _core.Map, **parameters: Any) -> SelfOrganizingMap:
        """Wrap a map that the core has trained by the paper's method."""
        rows, cols = trained.lattice.shape
        settings = _core.som_options(paper=True)
        som = cls(**({"rows": rows, "cols": cols} | settings | parameters))
        som._map = trained
        return som
