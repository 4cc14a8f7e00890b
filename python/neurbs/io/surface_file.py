"""The content of a file of surfaces."""

from __future__ import annotations

from dataclasses import dataclass

from neurbs._core import NurbsSurface


@dataclass(frozen=True)
class SurfaceFile:
    """The surfaces of a file, with its unit.

    Attributes
    ----------
    surfaces : list of NurbsSurface
        The surfaces, in the order of the file.
    trimmed : int
        Number of surfaces that belong to trimmed faces.
    unit : str, optional
        The unit of the coordinates, one of `LENGTH_UNITS`; None if the file has no or another unit.
    """

    surfaces: list[NurbsSurface]
    trimmed: int = 0
    unit: str | None = None
