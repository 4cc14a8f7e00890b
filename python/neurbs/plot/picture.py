"""The options that all pictures have."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from neurbs.errors import argument_error
from neurbs.plot.axes_box import AxesBox
from neurbs.plot.standard_view import view_of

if TYPE_CHECKING:
    from collections.abc import Sequence

_SIDES, _DOTS = (1.0, 100.0), (10.0, 2400.0)
"""Smallest and largest side of a figure in inches, and dots per inch."""


@dataclass(frozen=True)
class Picture:
    """The view of a picture, its size and its proportions.

    Attributes
    ----------
    view : {"iso", "top", "front", "side"}
        The direction from which things are seen.
    size : (float, float) or None
        Width and height in inches; None for a size without empty space.
    dpi : float
        Dots per inch.
    exaggeration : float or None
        The factor of heights; None for 1, unless the heights would hardly be seen.
    unit : str
        Name of the points' unit.

    Raises
    ------
    NeurbsError
        If an attribute is wrong.
    """

    view: str = "iso"
    size: Sequence[float] | None = None
    dpi: float = 100.0
    exaggeration: float | None = None
    unit: str = ""

    def __post_init__(self) -> None:
        """Check the attributes."""
        view_of(self.view)
        least, most = _DOTS
        if not least <= self.dpi <= most:
            raise argument_error("dpi", f"must be from {least:g} to {most:g}, got {self.dpi}")
        least, most = _SIDES
        sides = np.ravel([] if self.size is None else self.size)
        if self.size is not None and not (
            len(sides) == 2 and (sides >= least).all() and (sides <= most).all()
        ):
            raise argument_error(
                "size",
                f"must be a width and a height from {least:g} to {most:g} inches, got {self.size}",
            )

    def box(self, *points: NDArray[np.float64]) -> AxesBox:
        """Return the box around all these points."""
        return AxesBox.around(
            *points, view=view_of(self.view), exaggeration=self.exaggeration, unit=self.unit
        )
