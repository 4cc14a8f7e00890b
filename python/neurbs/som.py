"""The self-organizing map of Kohonen as an estimator in the style of scikit-learn."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs import _core
from neurbs.choices import Positions
from neurbs.errors import argument_error
from neurbs.extras import is_dask_array
from neurbs.som_chunks import ChunkLearner
from neurbs.som_estimator import Estimator
from neurbs.som_trained import TrainedMap

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Lattice = _core.Lattice

InitChoice: TypeAlias = Literal["pca", "geodesic", "auto", "centroid", "densest-cluster", "random"]
"""A named start of the nodes; see `SelfOrganizingMap`."""

Schedule: TypeAlias = float | tuple[Any, ...] | Callable[[float], float]
"""A gain or radius as a function of the step; see `SelfOrganizingMap`."""


class SelfOrganizingMap(Estimator, ChunkLearner, TrainedMap):
    """A lattice of nodes that is trained with scattered points.

    A point moves its nearest node, the winner, and the neighbors of the winner on the lattice. The
    nodes approach the points and stay in order. Training is either Kohonen's batch map, with all
    points in each epoch, or online, with one point at a time as in the paper. All settings of the
    paper: `SelfOrganizingMap.paper`.

    Parameters
    ----------
    rows, cols : int, default 20
        Rows and columns of the lattice, at least 2 each, and 3 in a closed direction.
    topology : {"sheet", "tube", "torus"}, default "sheet"
        Closed directions of the lattice: none, rows, or rows and columns.
    lattice : {"quad", "triangular"} or Lattice, default "quad"
        Neighbors of an inner node: four or six. A `Lattice`, as from `Lattice.graph`, overrides
        `rows`, `cols` and `topology`.
    training : {"batch", "online"}, default "batch"
        Training with all points in each epoch, or with one point in each step.
    init : str or array_like, default "pca"
        Start of the nodes: ``"pca"``, in order on the principal plane, closed lattices by angles
        about the principal axes; ``"geodesic"``, in order by distances along the surface;
        ``"auto"``, the better of these two, as touching layers distort distances along the
        surface; small random values around the centroid (``"centroid"``), the densest cluster
        (``"densest-cluster"``) or the origin (``"random"``); or an array of positions.
    neighborhood : {"gaussian", "bubble"}, default "gaussian"
        How far neighbors follow the winner: by the factor ``exp(-(d / radius)² / 2)`` at a distance
        of d cells, or fully within `radius` edges.
    kernel : {"mean", "linear"}, optional
        New position of a node in batch training: the weighted mean of the points around it, or the
        value of a line fitted to them, which does not shrink the lattice at its border. By default
        linear for Gaussian neighborhoods on quadrilateral grids, else the mean.
    presentation : {"random", "skip-reached", "shuffled"}, default "random"
        Points presented in online training: any at random; once the radius is zero, only those not
        yet on the lattice; or all in each epoch, in random order.
    gain, radius : number, tuple or callable, optional
        The gain is the share of the way to the point that nodes move in online training. The radius
        is the reach of the neighborhood on the lattice, in cells. A number is constant.
        ``("linear", start, end)``, ``("exponential", start, end)`` and ``("table", values)`` run
        from the first step to the last. ``("gaussian", start, scale)`` is the paper's schedule with
        its scale q or s in steps; parts that are None or left out are calculated. A callable takes
        the share of the training that is done, from 0 to 1; it is evaluated at 4097 places before
        the training. By default the gain is the paper's, and the radius falls exponentially from a
        quarter of the longer side (at most a sixth of a closed one) to 0.7, or is the paper's for a
        bubble. The paper's radius is zero after seven tenths of `max_steps`; with at most as many
        points as nodes, after 20 presentations of each.
    epochs : int, optional
        Passes over the points, by default 20 in batch training, and given by `max_steps` online.
    max_steps : int, optional
        Most steps of training: epochs of batch training, presentations of online training. The
        default for online training is 500 for each node.
    reach : float, optional
        A point is on the lattice when a node is within this distance, in the points' unit; by
        default 0.001 of the diagonal of their bounding box. Training ends when all points are.
    min_change : float, optional
        Training ends when no node has moved farther than this during an epoch, after the radius
        has become zero or constant; in the points' unit. An epoch of online training has as many
        steps as there are points, at most five for each node. The default is 0.05 of the lattice's
        mean spacing: the diagonal divided by the square root of the number of nodes. With the
        paper's radius and at most as many points as nodes, training ends when no node moves at all.
    seed : int, default 0
        Seed of all random numbers; the same seed gives the same bits, on any number of threads.

    Attributes
    ----------
    codebook_ : ndarray of shape (rows, cols, 3), or (nodes, 3) for a graph
        The positions of the nodes, read-only.
    n_iter_ : int
        Number of steps.
    converged_ : bool
        Whether training ended before `max_steps`.
    stopped_by_ : str
        Reason for the end of training: ``"reached"`` (all points are on the lattice),
        ``"settled"`` (no node moves farther than `min_change`), ``"max_steps"``, or
        ``"unfinished"`` (training was interrupted or is done in chunks).
    ordered_at_ : int
        The paper's t₀: the first step at which the radius was less than one edge.
    reached_ : int
        Number of points on the lattice.
    change_ : float or None
        Largest move of a node during the last epoch, in the points' unit; None if no epoch was
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
        topology: Literal["sheet", "tube", "torus"] = "sheet",
        lattice: Literal["quad", "triangular"] | Lattice = "quad",
        training: Literal["batch", "online"] = "batch",
        init: InitChoice | Positions = "pca",
        neighborhood: Literal["gaussian", "bubble"] = "gaussian",
        kernel: Literal["mean", "linear"] | None = None,
        presentation: Literal["random", "skip-reached", "shuffled"] = "random",
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
        """Return an untrained map with the paper's settings for these points.

        Training is online with a bubble. Radius and gain are Gaussian functions of the step, the
        start is around the centroid, and the presentation is random. There are four nodes for each
        point, at least 400 for many points and at most 2500.

        Parameters
        ----------
        points : array_like of shape (n, 3) or (n, 2)
            The points to train with; only their number is used here.
        **parameters
            Parameters of the constructor that replace the paper's settings.

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
        """Train with points, from a new start.

        For n points and m nodes of a grid, an epoch of batch training costs
        O(n log m + m (rows + cols)), and a step of online training O(m).

        Parameters
        ----------
        points : array_like of shape (n, 3) or (n, 2)
            At least four distinct points, not all on one line; two columns lie in z = 0. An array
            of Dask is trained on its workers, with the same bits, by batch training only; see
            `neurbs.distributed.fit_map`.
        y : object
            Not used; for pipelines of scikit-learn.
        progress : callable, optional
            Called some 25 times a second with a `Progress`. An exception that it raises ends the
            training.
        observer : callable, optional
            Called at the end of each epoch with an `Epoch`: its error, radius and lattice. An
            exception that it raises ends the training.
        checkpoint : path, optional
            A file to which the map is saved every `checkpoint_seconds` and at the end. With `load`
            and `resume` the training continues to the same result as without an interruption.
        checkpoint_seconds : float, default 60
            Seconds between two saves.

        Returns
        -------
        SelfOrganizingMap
            The map itself.

        Raises
        ------
        NeurbsError
            If there are fewer than four distinct points, all lie on one line, or a parameter is out
            of its range.
        KeyboardInterrupt
            On Ctrl-C, at once. The trained steps are kept, and `resume` continues from there.
        """
        options: dict[str, Any] = {
            "progress": progress,
            "observer": observer,
            "checkpoint": checkpoint,
            "checkpoint_seconds": checkpoint_seconds,
        }
        if is_dask_array(points):
            from neurbs.distributed import fit_map

            return fit_map(self, points, **options)
        points = _core.as_points(points)
        return self.start(points).resume(points, **options)

    def start(self, points: ArrayLike) -> SelfOrganizingMap:
        """Place the nodes for these points, without training.

        `fit` is `start` followed by `resume`.
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
        """Continue an interrupted or loaded training, with the same result as without a break.

        The parameters are those of `fit`; the points must be the same.
        """
        if is_dask_array(points):
            from neurbs.distributed.map_training import resume_map

            return resume_map(
                self,
                points,
                progress=progress,
                observer=observer,
                checkpoint=checkpoint,
                checkpoint_seconds=checkpoint_seconds,
            )
        points = _core.as_points(points)
        seconds = None if checkpoint is None else checkpoint_seconds
        ended = False
        while not ended:
            ended = self._trained().train(
                points, progress=progress, observer=observer, seconds=seconds
            )
            if checkpoint is not None:
                self.save(checkpoint)
        return self

    def fit_predict(self, points: ArrayLike, y: object = None) -> NDArray[np.int64]:
        """Train with points and return the number of each point's nearest node."""
        return self.fit(points).predict(points)

    def fit_transform(self, points: ArrayLike, y: object = None) -> NDArray[np.float64]:
        """Train with points and return each point's place on the lattice, as `transform` does."""
        return self.fit(points).transform(points)

    def animate(
        self, points: ArrayLike, path: str | os.PathLike[str], *, seconds: float = 6.0
    ) -> SelfOrganizingMap:
        """Train as `fit` does, and write an animation of it: see `neurbs.plot.animate`."""
        from neurbs.plot import animate

        return animate(self, points, path, seconds=seconds)

    def plot(
        self,
        points: ArrayLike | None = None,
        *,
        color: Literal["u-matrix", "hits"] | None = None,
    ) -> Figure:
        """Draw the map and optionally points: see `neurbs.plot.plot_map`."""
        from neurbs.plot import plot_map

        return plot_map(self, points, color=color)

    def _repr_html_(self) -> str:
        from neurbs.plot import map_html

        return map_html(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the map and the state of its training to a NumPy archive (.npz).

        The archive has the arrays `codebook` and `parameters` (JSON), and the state for `load`,
        which restores the map to the last bit, with the unfinished epoch of `partial_fit`. A
        callable schedule is saved as a table of its values.
        """
        from neurbs.som_archive import write_archive

        write_archive(path, self.get_params(), self._trained(), self._pending, self._stream_state)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> SelfOrganizingMap:
        """Return a map from an archive that `save` has written.

        Raises
        ------
        NeurbsError
            If the file is not an archive of a map.
        OSError
            If the file cannot be read.
        """
        from neurbs.som_archive import read_archive

        parameters, trained, pending, stream_state = read_archive(path)
        som = cls(**parameters)
        som._map, som._pending, som._stream_state = trained, pending, stream_state
        return som

    def _start(
        self,
        points: NDArray[np.float64],
        *,
        chunks: bool = False,
        whole: tuple[list[float], list[float], int] | None = None,
    ) -> None:
        """Place the nodes for these points and drop any unfinished training."""
        options = self._options()
        self._map = _core.Map(points, self._lattice(), options, chunks=chunks, whole=whole)
        self._pending = self._stream_state = None

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
    def _of_core(cls, trained: _core.Map, parameters: dict[str, Any]) -> SelfOrganizingMap:
        """Return a map that the core has trained with these parameters."""
        som = cls(**parameters)
        som._map = trained
        return som
