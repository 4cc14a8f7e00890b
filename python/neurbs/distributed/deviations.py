"""Points, parameters, deviations and inliers of a cloud in parts, as arrays of Dask."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from neurbs.distributed.parts import OpenPart, Parts, Reading
from neurbs.distributed.residuals import Floats
from neurbs.distributed.rounds import Round


@dataclass(frozen=True)
class PointArrays:
    """Arrays over all points, computed when they are used.

    Attributes
    ----------
    points : dask array of shape (n, 3)
    uv : dask array of shape (n, 2)
    deviations : dask array of shape (n,)
    inliers : dask array of bool, shape (n,)
    """

    points: Any
    uv: Any
    deviations: Any
    inliers: Any

    @classmethod
    def of(cls, parts: Parts, counts: dict[int, int], work: Round) -> PointArrays:
        """Return the arrays for parts with these numbers of points."""
        import dask.array as da
        from dask import delayed

        read, measured = delayed(_points, pure=False), delayed(_measured, nout=3, pure=False)
        shared = delayed(work)
        blocks: list[list[Any]] = [[], [], [], []]
        for number, source in enumerate(parts.sources):
            points = read(source, parts.reading)
            found = [points, *measured(shared, points)]
            for block, one, width, kind in zip(blocks, found, _WIDTHS, _KINDS, strict=True):
                shape = (counts[number], *width)
                block.append(da.from_delayed(one, shape, dtype=kind))
        return cls(*map(da.concatenate, blocks))


_WIDTHS = ((3,), (2,), (), ())
_KINDS = (np.float64, np.float64, np.float64, np.bool_)


def _points(source: Any, reading: Reading) -> Floats:
    """Read a part as a whole."""
    chunks = list(OpenPart(source, reading).chunks)
    return np.concatenate(chunks) if chunks else np.empty((0, 3))


def _measured(work: Round, points: Floats) -> tuple[Floats, Floats, Any]:
    """Return parameters, deviations and inliers of a part."""
    uv, distances, weights = work.projected(points - np.asarray(work.origin))
    return uv, distances, weights > 0
