"""Sums over the parts of a cloud, by any scheduler of Dask."""

from __future__ import annotations

import contextlib
import pickle
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neurbs import _core
from neurbs._core import NeurbsError
from neurbs.distributed.parts import Notes, OpenPart, Parts, Reading
from neurbs.errors import printable

ARITY = 8
"""Results that a task merges at a time, in the order of the parts."""

_POLL = 0.05
"""Seconds between two looks at a running computation."""


Step = Callable[[Any, NDArray[np.float64], int, Any], Any]
"""A function of the state that all tasks share, of a chunk, of the number of points before it in
its part, and of an argument that each part has for itself. It returns a sum that is
added to others by `+`, which changes neither; behind the first chunk of a part also what the sum's
method `absorb` takes."""


@dataclass(frozen=True)
class Outcome:
    """The sum of results over parts, with what they took.

    Attributes
    ----------
    value : object
        The sum; None without points.
    counts : dict of int to int
        Number of points of each part.
    skipped : dict of int to str
        For each part that could not be read, the reason.
    bytes : int
        Size of the results of all parts, which processes may exchange.
    reading, computing : float
        Seconds of all tasks together.
    notes : Notes
        What was found in files beside the points.
    """

    value: Any
    counts: dict[int, int]
    skipped: dict[int, str]
    bytes: int = 0
    reading: float = 0.0
    computing: float = 0.0
    notes: Notes = field(default_factory=Notes)

    def __add__(self, other: Outcome) -> Outcome:
        """Return the outcome over the parts of both."""
        values = [value for value in (self.value, other.value) if value is not None]
        return Outcome(
            values[0] + values[1] if len(values) == 2 else next(iter(values), None),
            self.counts | other.counts,
            self.skipped | other.skipped,
            self.bytes + other.bytes,
            self.reading + other.reading,
            self.computing + other.computing,
            self.notes + other.notes,
        )


@dataclass(frozen=True)
class Progress:
    """The state of a job over parts, for a callback that also takes `neurbs.Progress`.

    Attributes
    ----------
    stage : str
        The stage of the job: ``"sampling"``, ``"training"``, ``"fitting"`` or ``"measuring"``.
    step, total : int
        Tasks done in this stage, and all of them.
    share : float or None
        Share of the stage that is done.
    error : float or None
        The last error in the points' unit.
    """

    stage: str
    step: int
    total: int
    share: float | None = None
    error: float | None = None
    change: float | None = None
    radius: float | None = None
    reached: int = 0
    points: int = 0


@dataclass
class Engine:
    """A scheduler of Dask and a callback.

    Attributes
    ----------
    scheduler : str, Client or None
        As for `dask.compute`: the current client, or else threads.
    progress : callable or None
        Called with a `Progress`. An exception that it raises cancels the computation.
    """

    scheduler: Any = None
    progress: Callable[[Any], object] | None = None

    def client(self) -> Any:
        """Return the distributed client that computes, if there is one."""
        from dask.base import get_scheduler

        get = get_scheduler(scheduler=self.scheduler)
        owner = getattr(get, "__self__", None)
        return owner if hasattr(owner, "scheduler_info") else None

    def workers(self) -> dict[str, Any]:
        """Return what the scheduler knows of its workers; {} without a client."""
        client = self.client()
        if client is None:
            return {}
        found: dict[str, Any] = client.scheduler_info(n_workers=-1)["workers"]
        return found

    def summed(
        self,
        parts: Parts,
        step: Step,
        state: object,
        *,
        stage: str,
        own: list[Any] | None = None,
        error: float | None = None,
    ) -> Outcome:
        """Return the sum of a step's results over all chunks of all parts.

        Results are merged in the order of the parts, as a tree. Nothing but the state, the own
        arguments and the results is sent.

        Raises
        ------
        NeurbsError
            If a part cannot be read, with its name, or workers end again and again.
        """
        from dask import delayed

        # One task holds the state, so that each worker gets it once.
        shared = delayed(_same, pure=False)(pickle.dumps(state))
        mapped = delayed(_mapped, pure=False)
        outcomes = [
            mapped(step, shared, source, number, name, parts.reading, own and own[number])
            for number, (name, source) in enumerate(zip(parts.names, parts.sources, strict=True))
        ]
        merged = delayed(_merged, pure=False)
        while len(outcomes) > 1:
            groups = [outcomes[i : i + ARITY] for i in range(0, len(outcomes), ARITY)]
            outcomes = [merged(group) if len(group) > 1 else group[0] for group in groups]
        outcome: Outcome = self.computed(outcomes[0], stage, error)
        return outcome

    def computed(self, root: Any, stage: str, error: float | None = None) -> Any:
        """Compute a delayed value, with progress; an interruption cancels its tasks."""
        client = self.client()
        if client is None:
            return self._computed_here(root, stage, error)
        from distributed import CancelledError, KilledWorker

        future = client.compute(root)
        try:
            with _counter(client, future, self.progress is not None) as counter:
                while not future.done():
                    time.sleep(_POLL)
                    if self.progress is not None:
                        self.progress(_state(stage, *counter(), error))
            return future.result()
        except KilledWorker as killed:
            raise NeurbsError(
                f"workers must not end, but {killed.allowed_failures + 1} of them ended in "
                f"{printable(str(killed.task))}: give each worker more memory, or make the parts "
                "smaller"
            ) from killed
        except CancelledError as cancelled:
            raise NeurbsError(
                "the computation was canceled, or its client was closed"
            ) from cancelled
        except BaseException:
            client.cancel([future], force=True)
            raise

    def _computed_here(self, root: Any, stage: str, error: float | None) -> Any:
        import dask
        from dask.callbacks import Callback

        done, total = 0, len(root.dask)

        def note(*_: object) -> None:
            nonlocal done
            done += 1
            if self.progress is not None:
                self.progress(_state(stage, min(done, total), total, error))

        with Callback(posttask=note):
            return dask.compute(root, scheduler=self.scheduler)[0]


def _state(stage: str, done: int, total: int, error: float | None) -> Progress:
    return Progress(stage, done, total, done / max(total, 1), error)


@contextlib.contextmanager
def _counter(client: Any, future: Any, wanted: bool) -> Iterator[Callable[[], tuple[int, int]]]:
    """Yield a function that returns the numbers of finished tasks and of all."""
    if not wanted:
        yield lambda: (0, 1)
        return
    from distributed.diagnostics.progressbar import ProgressBar

    class Counter(ProgressBar):  # type: ignore[misc]
        last = (0, 1)

        def _draw_bar(self, remaining: int, all: int, **_: object) -> None:
            self.last = (all - remaining, max(all, 1))

    counter = Counter([future], client.scheduler.address, interval="100ms")
    client.loop.add_callback(counter.listen)
    yield lambda: counter.last


def _same(state: bytes) -> Any:
    """Return the state of a round, which is in one place of each worker."""
    return pickle.loads(state)


def _mapped(
    step: Step,
    state: Any,
    source: Any,
    number: int,
    name: str,
    reading: Reading,
    own: Any,
) -> Outcome:
    """Return the sum of a step's results over the chunks of a part: the task of a worker."""
    _use_threads_of_worker()
    value: Any = None
    count, read, computed = 0, 0.0, 0.0
    try:
        start = time.perf_counter()
        part = OpenPart(source, reading)
        while True:
            chunk = next(part.chunks, None)
            read += time.perf_counter() - start
            if chunk is None:
                break
            start = time.perf_counter()
            result = step(state, chunk, count, own)
            value = result if value is None else _with(value, result)
            count += len(chunk)
            computed += time.perf_counter() - start
            start = time.perf_counter()
    except (NeurbsError, OSError) as error:
        if isinstance(error, MemoryError):
            raise
        reason = printable(str(error))
        if reading.skip:
            return Outcome(None, {}, {number: reason}, reading=read)
        if name in reason:
            raise
        raise NeurbsError(f"{printable(name)}: {reason}") from error
    size = len(pickle.dumps(value, pickle.HIGHEST_PROTOCOL))
    return Outcome(value, {number: count}, {}, size, read, computed, part.notes())


def _merged(outcomes: list[Outcome]) -> Outcome:
    """Return the sum of outcomes, in their order."""
    # The first sum is new; inputs stay, as other tasks may need them again.
    total = outcomes[0] + outcomes[1]
    for outcome in outcomes[2:]:
        value = _with(total.value, outcome.value)
        total = replace(replace(total, value=None) + replace(outcome, value=None), value=value)
    return total


def _with(value: Any, other: Any) -> Any:
    """Return the sum of a value of this task and another, in place where that saves a copy."""
    if value is None or other is None:
        return other if value is None else value
    return value.absorb(other) if hasattr(value, "absorb") else value + other


def _use_threads_of_worker() -> None:
    """Give the core as many threads as a worker process has, as all its tasks share them."""
    import os

    with contextlib.suppress(ImportError, ValueError):
        from distributed import get_worker

        worker = get_worker()
        if worker.nanny is not None and "NEURBS_NUM_THREADS" not in os.environ:
            _core.set_num_threads(worker.state.nthreads)
