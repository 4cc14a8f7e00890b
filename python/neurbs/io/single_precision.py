"""Loss of digits in formats that store single precision."""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.io.row_blocks import blocks_of, bounds

_VISIBLE_ROUNDING = 1e-6
"""A warning is issued if a vertex moves by more than this share of the mesh's diagonal.

In a mesh around the origin, vertices move by less than a tenth of it.
"""


def check_single_precision(
    vertices: NDArray[np.float64], origin: NDArray[np.float64], name: str, *, stacklevel: int
) -> None:
    """Warn if single precision moves vertices visibly.

    Parameters
    ----------
    vertices : ndarray of shape (n, 3)
        The vertices; the file gets their offsets from `origin`.
    origin : ndarray of shape (3,)
        The origin of the coordinates in the file.
    name : str
        The name of the format.
    stacklevel : int
        Number of calls from here to the caller that is warned.

    Raises
    ------
    NeurbsError
        If a coordinate is too large for single precision.

    Warns
    -----
    UserWarning
        If vertices move visibly.
    """
    low, high = bounds(vertices)
    largest = max(np.abs(low - origin).max(), np.abs(high - origin).max())
    if largest > np.finfo(np.float32).max:
        raise NeurbsError(
            f"{name} stores single precision, but coordinates reach {largest:.2g}: "
            "change their unit, or write .ply or .obj"
        )
    blocks = (block - origin for block in blocks_of(vertices))
    moved = max(np.linalg.norm(block.astype(np.float32) - block, axis=1).max() for block in blocks)
    diagonal = np.linalg.norm(high - low)
    if moved > _VISIBLE_ROUNDING * diagonal:
        warnings.warn(
            f"{name} stores single precision, which moves vertices by up to {moved:.2g} "
            f"(the mesh's diagonal is {diagonal:.4g}): .ply, .obj and .glb keep the digits",
            UserWarning,
            stacklevel=stacklevel,
        )
