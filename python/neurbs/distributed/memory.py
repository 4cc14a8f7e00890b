"""The memory that a job over parts takes, checked before it starts."""

from __future__ import annotations

from math import isqrt

from neurbs import _core
from neurbs.distributed.engine import ARITY, Engine
from neurbs.distributed.parts import Parts
from neurbs.reconstruction_chunks import CHUNK

_PROCESS = 250 << 20
"""Bytes of a worker process with its libraries, and of the process that reads files for it."""

_PER_POINT = 400
"""Bytes for each point of a chunk: coordinates, projection, weight, and their sorted copies."""

_PER_SAMPLED = 160
"""Bytes for each point of a sample while samples are merged."""

_BLOCK_POINT = 24
"""Bytes of a point in an array."""

_TILE = 64
"""Side of the tiles of a wide band matrix."""


def of_net(shape: tuple[int, int], degree: tuple[int, int]) -> tuple[int, int]:
    """Return the bytes of a net's band matrix, and of its sums as they are sent."""
    (rows, cols), (by_row, by_col) = shape, degree
    width = min(by_row * cols + by_col, by_col * rows + by_row)
    band = 8 * rows * cols * (width + 2 * _TILE)
    return band, 8 * rows * cols * (2 * by_row * by_col + by_row + by_col + 4)


def of_task(parts: Parts, sample: int, shape: tuple[int, int], degree: tuple[int, int]) -> int:
    """Return the bytes that a task takes at most."""
    band, sent = of_net(shape, degree)
    block = 2 * _BLOCK_POINT * (parts.largest or 0)
    chunk = _PER_POINT * min(CHUNK, parts.largest or CHUNK)
    # Two halves are summed, one after the other; several results wait to be merged.
    fitting = block + chunk + band + 2 * (ARITY + 2) * sent
    sampling = block + chunk + sample * _PER_SAMPLED + ARITY * sample * 32
    return max(fitting, sampling)


def check_workers(
    engine: Engine, parts: Parts, sample: int, shape: tuple[int, int], degree: tuple[int, int]
) -> None:
    """Raise if a worker has a memory limit below what its tasks take.

    Raises
    ------
    NeurbsMemoryError
        With the memory that a worker needs.
    """
    task = of_task(parts, sample, shape, degree)
    for address, worker in engine.workers().items():
        limit, threads = worker.get("memory_limit") or 0, worker.get("nthreads", 1)
        needed = _PROCESS + threads * task
        if 0 < limit < needed:
            raise _core.NeurbsMemoryError(
                f"a worker with {threads} threads must have at least {_mega(needed)} of memory for "
                f"a net of {shape[0]} × {shape[1]} and parts of this size, got {_mega(limit)} at "
                f"{address}: raise its memory limit, or choose smaller blocks, fewer threads, a "
                "smaller `grid` or `max_sample`"
            )


def check_client(shape: tuple[int, int], degree: tuple[int, int]) -> None:
    """Raise if this process has too little memory to solve for a net.

    Raises
    ------
    NeurbsMemoryError
        With the largest square net that fits.
    """
    needed, available = _of_solution(shape, degree), _available()
    if available is None or needed <= available:
        return
    side = isqrt(shape[0] * shape[1])
    while side > 2 and _of_solution((side, side), degree) > available:
        side -= max(side // 50, 1)
    raise _core.NeurbsMemoryError(
        f"grid must be a net whose equations fit into the {_mega(available)} of memory that are "
        f"free here, at most some {side} × {side}, got {shape[0]} × {shape[1]}, which takes "
        f"{_mega(needed)}"
    )


def _of_solution(shape: tuple[int, int], degree: tuple[int, int]) -> int:
    """Return the bytes of a solution: equations, energy, and the factor of their sum."""
    band, sent = of_net(shape, degree)
    return 3 * band + 6 * sent


def _available() -> int | None:
    """Return the free bytes of this machine; None if they are unknown."""
    try:
        import psutil
    except ImportError:
        return None
    return int(psutil.virtual_memory().available)


def _mega(size: int) -> str:
    return f"{size / 1e6:,.0f} MB"
