"""Training of a map with chunks of points or a distribution, in constant memory."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from neurbs import _core
from neurbs.errors import argument_error
from neurbs.som_stream import PointStream, Source

if TYPE_CHECKING:
    from typing_extensions import Self

_START_POINTS = 4096
"""Points of a distribution that the start of the nodes is computed from, as in the core."""


class ChunkLearner:
    """The training of `neurbs.SelfOrganizingMap` with points that are not in memory at once."""

    training: str
    seed: int
    _map: _core.Map
    # Sums of the unfinished epoch of `partial_fit`, and the state of the stream of a distribution.
    _pending: _core.BatchSums | None = None
    _stream_state: dict[str, Any] | None = None

    if TYPE_CHECKING:

        def _start(
            self,
            points: NDArray[np.float64],
            *,
            chunks: bool = False,
            whole: tuple[list[float], list[float], int] | None = None,
        ) -> None: ...
        def _trained(self) -> _core.Map: ...

    def partial_fit(self, points: ArrayLike, y: object = None, *, end_epoch: bool = True) -> Self:
        """Continue the training with a chunk of points.

        Online training presents each point once. In batch training the chunk is part of an epoch:
        any split of the same points into chunks gives the same bits. Gain and radius continue to
        fall from call to call.

        Parameters
        ----------
        points : array_like of shape (n, 3) or (n, 2)
            The chunk. The start of the nodes is computed from the first one, which should cover the
            whole cloud.
        y : object
            Not used.
        end_epoch : bool, default True
            Whether to end the epoch of batch training after this chunk and move the lattice.

        Examples
        --------
        >>> import numpy as np
        >>> import neurbs
        >>> points = np.random.default_rng(0).random((3000, 3))
        >>> som = neurbs.SelfOrganizingMap(6, 6)
        >>> for _ in range(3):
        ...     for chunk in np.split(points, 10):
        ...         _ = som.partial_fit(chunk, end_epoch=False)
        ...     _ = som.end_epoch()
        >>> som.n_iter_
        3
        """
        points = _core.as_points(points)
        if not hasattr(self, "_map"):
            self._start(points, chunks=True)
        if self.training == "online":
            self._map.present(points)
            return self
        sums = self._map.sums(points)
        self._pending = sums if self._pending is None else self._pending + sums
        return self.end_epoch() if end_epoch else self

    def end_epoch(self) -> Self:
        """End the epoch of batch training that `partial_fit` has started, and move the lattice."""
        if self._pending is None:
            raise _core.NeurbsError("end_epoch must be called after partial_fit, got no points yet")
        self._trained().learn(self._pending)
        self._pending = None
        return self

    def fit_distribution(
        self,
        source: Source,
        *,
        progress: Callable[[_core.Progress], object] | None = None,
        observer: Callable[[_core.Epoch], object] | None = None,
    ) -> Self:
        """Train with a distribution of any length in constant memory, from a new start.

        The start of the nodes is computed from the first 4096 points. An epoch has 32 points for
        each node, at least 4096. Training ends when the lattice has settled or after `max_steps`.

        Parameters
        ----------
        source : callable or iterable of arrays
            A callable ``source(count, rng)`` that returns points of shape (count, 3), with a NumPy
            Generator of the map's seed; or chunks with as many points as the training needs.
        progress, observer : callable, optional
            As for `fit`.

        Raises
        ------
        NeurbsError
            If a callable does not return `count` finite points, or the chunks end before the
            training. The finished epochs are kept.

        Examples
        --------
        >>> import neurbs
        >>> def square(count, rng):
        ...     return rng.random((count, 2))
        >>> som = neurbs.SelfOrganizingMap(10, 10).fit_distribution(square)
        >>> som.codebook_.shape
        (10, 10, 3)
        """
        stream = PointStream(source, self.seed)
        first = _core.as_points(stream(_START_POINTS))
        if len(first) != _START_POINTS:
            raise argument_error(
                "source",
                f"must return as many points as requested, {_START_POINTS}, got {len(first)}",
            )
        self._start(first, chunks=True)
        return self._train_on(stream, progress, observer)

    def resume_distribution(
        self,
        source: Source,
        *,
        progress: Callable[[_core.Progress], object] | None = None,
        observer: Callable[[_core.Epoch], object] | None = None,
    ) -> Self:
        """Continue an interrupted or loaded `fit_distribution`, with the same bits as without.

        A callable gets the same random numbers as without a break. Chunks must start from the
        first one again: those of finished epochs are skipped.
        """
        if self._stream_state is None:
            raise _core.NeurbsError(
                "resume_distribution must be called after fit_distribution, which was not called"
            )
        stream = PointStream(source, self.seed)
        stream.restore(self._stream_state)
        return self._train_on(stream, progress, observer)

    def _train_on(
        self,
        stream: PointStream,
        progress: Callable[[_core.Progress], object] | None,
        observer: Callable[[_core.Epoch], object] | None,
    ) -> Self:
        def note(epoch: _core.Epoch) -> None:
            self._stream_state = stream.state
            if observer is not None:
                observer(epoch)

        self._stream_state = stream.state
        self._trained().train_on_distribution(stream, progress=progress, observer=note)
        return self
