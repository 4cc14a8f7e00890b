"""What a file of surfaces holds."""

from __future__ import annotations

from dataclasses import dataclass

from neurbs._core import NurbsSurface


@dataclass(frozen=True)
class SurfaceFile:
    """Surfaces as they were read.

    Attributes
    ----------
    surfaces : list of NurbsSurface
        In the file's order.
    trimmed : int
        How many of them are only the ground of a smaller face.
    unit : str, optional
        That of the coordinates, one of `LENGTH_UNITS`; none if the file does not say it, or has
        another.
    """

    surfaces: list[NurbsSurface]
    trimmed: int = 0
    unit: str | None = None
