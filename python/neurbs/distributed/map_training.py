"""Batch training of a self-organizing map with points in parts."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neurbs import _core
from neurbs.distributed.engine import Engine
from neurbs.distributed.parts import Parts, no_points, parts_of
from neurbs.distributed.residuals import Floats
from neurbs.errors import argument_error
from neurbs.extras import require

if TYPE_CHECKING:
    from neurbs.som import SelfOrganizingMap


@dataclass(frozen=True)
class _Bounds:
    """The bounds of some points."""

    low: Floats
    high: Floats

    def __add__(self, other: _Bounds) -> _Bounds:
        return _Bounds(np.minimum(self.low, other.low), np.maximum(self.high, other.high))


@dataclass(frozen=True)
class _Rows:
    """Rows of the cloud, in its order."""

    points: Floats

    def __add__(self, other: _Rows) -> _Rows:
        return _Rows(np.concatenate([self.points, other.points]))


def fit_map(
    som: SelfOrganizingMap,
    points: Any,
    *,
    scheduler: Any = None,
    progress: Callable[[Any], object] | None = None,
    observer: Callable[[_core.Epoch], object] | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    checkpoint_seconds: float = 60.0,
    **reading: Any,
) -> SelfOrganizingMap:
    """Train a map with points in parts, on the workers of Dask.

    The map has the same bits as by ``som.fit`` with all points in one array, whatever the parts.
    ``som.fit(dask_array)`` calls this function. Each epoch reads all parts once.

    Parameters
    ----------
    som : SelfOrganizingMap
        A map with batch training. It is changed.
    points : dask array, files, or iterator of arrays
        As for `reconstruct`.
    scheduler, progress
        As for `reconstruct`.
    observer, checkpoint, checkpoint_seconds
        As for `neurbs.SelfOrganizingMap.fit`.
    **reading
        The options of `reconstruct` for reading files.

    Returns
    -------
    SelfOrganizingMap
        The map itself.

    Raises
    ------
    NeurbsError
        If training is online, or a part cannot be read.

    Examples
    --------
    >>> import dask.array as da
    >>> import numpy as np
    >>> import neurbs
    >>> points = np.random.default_rng(0).random((3000, 3))
    >>> som = neurbs.SelfOrganizingMap(6, 6).fit(da.from_array(points, chunks=(700, 3)))
    >>> bool((som.codebook_ == neurbs.SelfOrganizingMap(6, 6).fit(points).codebook_).all())
    True
    """
    require("dask.array", "points in parts")
    if som.training != "batch":
        raise argument_error(
            "training", f"must be 'batch' for points in parts, got {som.training!r}"
        )
    engine = Engine(scheduler, progress)
    parts = parts_of(points, **reading)
    parts = _start(som, engine, parts)
    return _train(som, engine, parts, observer, checkpoint, checkpoint_seconds)


def resume_map(
    som: SelfOrganizingMap,
    points: Any,
    *,
    progress: Callable[[Any], object] | None = None,
    observer: Callable[[_core.Epoch], object] | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    checkpoint_seconds: float = 60.0,
) -> SelfOrganizingMap:
    """Continue an interrupted `fit_map` with the same points."""
    engine = Engine(None, progress)
    return _train(som, engine, parts_of(points), observer, checkpoint, checkpoint_seconds)


def _start(som: SelfOrganizingMap, engine: Engine, parts: Parts) -> Parts:
    """Place the nodes as for all points in one array; return the parts that can be read."""
    outcome = engine.summed(parts, _bounds, None, stage="sampling")
    if outcome.value is None:
        raise no_points({parts.names[n]: why for n, why in outcome.skipped.items()}, parts)
    outcome.notes.unit()  # Refuses several.
    parts = parts.without(set(outcome.skipped))
    counts = [outcome.counts[number] for number in sorted(outcome.counts)]
    ends = np.cumsum(counts)
    indices = _core.start_indices(int(ends[-1]))
    cuts = np.searchsorted(indices, ends)
    own = [
        part - (end - count)
        for part, end, count in zip(np.split(indices, cuts[:-1]), ends, counts, strict=True)
    ]
    rows = engine.summed(parts, _rows, None, stage="sampling", own=own).value
    bounds = outcome.value
    whole = (bounds.low.tolist(), bounds.high.tolist(), int(ends[-1]))
    som._start(rows.points, whole=whole)
    return parts


def _train(
    som: SelfOrganizingMap,
    engine: Engine,
    parts: Parts,
    observer: Callable[[_core.Epoch], object] | None,
    checkpoint: str | os.PathLike[str] | None,
    checkpoint_seconds: float,
) -> SelfOrganizingMap:
    trained = som._trained()
    saved = time.monotonic()
    ended = trained.stopped_by != "unfinished"
    while not ended:
        outcome = engine.summed(parts, _sums, trained, stage="training", error=trained.error)
        ended = trained.train_epoch(outcome.value, observer=observer)
        due = time.monotonic() - saved >= checkpoint_seconds
        if checkpoint is not None and (due or ended):
            som.save(checkpoint)
            saved = time.monotonic()
    return som


def _bounds(_state: None, points: Floats, _start: int, _own: object) -> _Bounds:
    _core.EvenSample(1).extend(points)  # Refuses points that are not finite.
    return _Bounds(points.min(axis=0), points.max(axis=0))


def _rows(_state: None, points: Floats, start: int, own: NDArray[np.int64]) -> _Rows:
    here = own[(own >= start) & (own < start + len(points))] - start
    return _Rows(points[here])


def _sums(trained: _core.Map, points: Floats, _start: int, _own: object) -> _core.BatchSums:
    return trained.sums(points)
