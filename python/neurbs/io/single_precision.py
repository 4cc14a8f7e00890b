"""What is lost in formats that store single precision."""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.io.row_blocks import blocks_of, bounds

_VISIBLE_ROUNDING = 1e-6
"""Share of a mesh's diagonal by which single precision may move a vertex without a warning.

It moves those of a mesh around the origin by less than a tenth of that.
"""


def check_single_precision(
    vertices: NDArray[np.float64], origin: NDArray[np.float64], name: str, *, stacklevel: int
) -> None:
    """Say so where single precision does not suffice.

    Parameters
    ----------
    vertices : ndarray of shape (n, 3)
        What will be written, counted from `origin`.
    origin : ndarray of shape (3,)
        A place.
    name : str
        The format.
    stacklevel : int
        Calls from here to who is warned.

    Raises
    ------
    NeurbsError
        If a number is too large.

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
