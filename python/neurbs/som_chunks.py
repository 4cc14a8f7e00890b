"""Points that come in chunks, or from a distribution, in constant memory."""

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

_FIRST_POINTS = 4096
"""Points of a distribution that decide the start of the nodes, as the core's own sampler has it."""


class ChunkLearner:
    """How `neurbs.SelfOrganizingMap` learns points that are never there all at once."""

    training: str
    seed: int
    _map: _core.Map
    # Sums of an epoch that `partial_fit` has begun, and where a distribution's source stands.
    _pending: _core.BatchSums | None = None
    _drawn: dict[str, Any] | None = None

    if TYPE_CHECKING:

        def _start(self, points: NDArray[np.float64], *, chunks: bool = False) -> None: ...
        def _learned(self) -> _core.Map: ...

    def partial_fit(self, points: ArrayLike, y: object = None, *, end_epoch: bool = True) -> Self:
        """Learn a chunk of points, going on from what was learned before.

        Online training presents each of them once. Batch training takes the chunk as a part of an
        epoch: any split of the same points into chunks gives the same bits. Gain and radius go on
        falling from call to call.

        Parameters
        ----------
        points : array_like of shape (n, 3) or (n, 2)
            The chunk. The first one decides the start of the nodes: it should be spread over all.
        y : object
            Not used.
        end_epoch : bool, default True
            Whether batch training ends its epoch after this chunk, and moves the lattice.

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
        """End an epoch of batch training that `partial_fit` has begun, and move the lattice."""
        if self._pending is None:
            raise _core.NeurbsError("end_epoch must be called after partial_fit, got no points yet")
        self._learned().learn(self._pending)
        self._pending = None
        return self

    def fit_distribution(
        self,
        source: Source,
        *,
        progress: Callable[[_core.Progress], object] | None = None,
        observer: Callable[[_core.Epoch], object] | None = None,
    ) -> Self:
        """Learn a distribution of any length in constant memory, forgetting what was learned.

        The first 4096 points decide the start. An epoch is 32 points a node, at least 4096.
        Training ends when the lattice has settled or the steps are over.

        Parameters
        ----------
        source : callable or iterable of arrays
            ``source(count, rng)`` draws points of shape (count, 3), with `rng` a NumPy Generator
            of the map's seed; or chunks of points, as many as the training needs.
        progress, observer : callable, optional
            As for `fit`.

        Raises
        ------
        NeurbsError
            If the source draws anything but as many finite points as it was asked for, or its
            chunks end before the training. What was learned so far, in whole epochs, is kept.

        Examples
        --------
        >>> import neurbs
        >>> def square(count, rng):
        ...     return rng.random((count, 2))
        >>> som = neurbs.SelfOrganizingMap(10, 10).fit_distribution(square)
        >>> som.codebook_.shape
        (10, 10, 3)
        """
        draws = PointStream(source, self.seed)
        first = _core.as_points(draws(_FIRST_POINTS))
        if len(first) != _FIRST_POINTS:
            raise argument_error(
                "sampler",
                f"must return as many points as requested, {_FIRST_POINTS}, got {len(first)}",
            )
        self._start(first, chunks=True)
        return self._draw(draws, progress, observer)

    def resume_distribution(
        self,
        source: Source,
        *,
        progress: Callable[[_core.Progress], object] | None = None,
        observer: Callable[[_core.Epoch], object] | None = None,
    ) -> Self:
        """Go on with an interrupted or loaded `fit_distribution`, to the same bits as without.

        A sampler is given the same random numbers as if there had been no break. Chunks must come
        from their beginning: those already learned are skipped.
        """
        if self._drawn is None:
            raise _core.NeurbsError(
                "resume_distribution must be called after fit_distribution, got no distribution yet"
            )
        draws = PointStream(source, self.seed)
        draws.go_to(self._drawn)
        return self._draw(draws, progress, observer)

    def _draw(
        self,
        draws: PointStream,
        progress: Callable[[_core.Progress], object] | None,
        observer: Callable[[_core.Epoch], object] | None,
    ) -> Self:
        def note(epoch: _core.Epoch) -> None:
            self._drawn = draws.state
            if observer is not None:
                observer(epoch)

        self._drawn = draws.state
        self._learned().train_on_distribution(draws, progress=progress, observer=note)
        return self
