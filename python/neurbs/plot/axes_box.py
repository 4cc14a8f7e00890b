"""The box of 3D axes: bounds, proportions, labels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from neurbs.errors import argument_error
from neurbs.plot.standard_view import VIEWS, View

INK, PALE = "#22313f", "#d5dade"
"""Colors of text and of lines around the picture."""

_DRAWN_RATIO = 0.25
"""Ratio to the longest side at which a side is drawn that would be too short."""

_FLAT_RATIO = 0.05
"""Smallest ratio at which heights are drawn to scale: those of most terrain are flatter."""

_THIN_RATIO = 0.01
"""Smallest ratio at which any side is drawn to scale: below, the axes have different units."""

_PART_UNITS = ("mm", "cm", "in")
"""Units of parts, whose heights are always to scale."""

_FAR = 20.0
"""Coordinates larger than this many extents have labels relative to an origin near the box."""

_DIGITS = 6
"""Digits of an axis' extent to which ticks are rounded; they have fewer."""


@dataclass(frozen=True)
class AxesBox:
    """A bounding box with the factor by which each of its axes is drawn longer, and a view."""

    low: NDArray[np.float64]
    high: NDArray[np.float64]
    factor: NDArray[np.float64]
    view: View = VIEWS["iso"]

    @classmethod
    def around(
        cls,
        *points: NDArray[np.float64],
        view: View = VIEWS["iso"],
        exaggeration: float | None = None,
        unit: str = "",
    ) -> AxesBox:
        """Box all these points.

        Parameters
        ----------
        *points : ndarray of shape (n, 3)
            The points.
        view : View
            The direction of the viewer.
        exaggeration : float, optional
            The factor of z; by default heights are to scale unless they would hardly be seen.
        unit : str, default ""
            The unit of the points: those of parts are drawn to scale.
        """
        if exaggeration is not None and not 0 < exaggeration < np.inf:
            raise argument_error("exaggeration", f"must be positive and finite, got {exaggeration}")
        low = np.min([p.min(axis=0) for p in points], axis=0)
        high = np.max([p.max(axis=0) for p in points], axis=0)
        extent = high - low
        longest = extent.max() or 1.0
        flat = extent < 1e-9 * longest
        limit = np.full(3, _THIN_RATIO)
        if unit not in _PART_UNITS:
            limit[2] = _FLAT_RATIO
        longer = _DRAWN_RATIO * longest / np.where(flat, 1.0, extent)
        # A flat axis is not drawn longer, but the box needs some extent.
        factor = np.where(flat | (extent >= limit * longest), 1.0, longer)
        if exaggeration is not None:
            factor[2] = exaggeration
        room = np.where(flat, _DRAWN_RATIO * longest / 2, 0.02 * extent)
        return cls(low - room, high + room, factor, view)

    @property
    def drawn(self) -> NDArray[np.float64]:
        """Lengths of the drawn sides of the box."""
        return (self.high - self.low) * self.factor

    @property
    def seen(self) -> tuple[float, float]:
        """Width and height of the box in the view, as shares of its diagonal."""
        across, upwards, _ = np.abs(self.view.axes) @ self.drawn / np.linalg.norm(self.drawn)
        return float(across), float(upwards)

    @property
    def toward(self) -> NDArray[np.float64]:
        """The vector toward the viewer whose drawn length is the longest drawn side."""
        vector: NDArray[np.float64] = self.view.axes[2] * self.drawn.max() / self.factor
        return vector

    def origin(self, axis: int) -> float:
        """Return the origin of the labels of an axis: 0, or a round number if the box is far."""
        low, high = self.low[axis], self.high[axis]
        if max(abs(low), abs(high)) <= _FAR * (high - low):
            return 0.0
        unit = 10.0 ** np.ceil(np.log10(high - low))
        return float(np.round((low + high) / 2 / unit) * unit)

    def label(self, axis: int) -> str:
        """Return the label of an axis with origin and factor: ``(z − 5,000) × 3``."""
        label, origin, factor = "xyz"[axis], self.origin(axis), self.factor[axis]
        if origin:
            label += f" {'−' if origin > 0 else '+'} {number(abs(origin))}"
        if factor != 1:
            label = f"({label})" if origin else label
            label += f" × {number(float(f'{factor:.2g}'))}"
        return label

    def tick(self, axis: int, value: float) -> str:
        """Return the text at a place of an axis, relative to the origin of its labels."""
        digits = _DIGITS - int(np.floor(np.log10(self.high[axis] - self.low[axis])))
        # Rounding removes the error of the subtraction; + 0.0 removes the sign of −0.
        return number(round(float(value - self.origin(axis)), digits) + 0.0)


def number(value: float) -> str:
    """Format a number with thousands separators."""
    return f"{value:,.10g}".replace("-", "−")


def sample(count: int, size: int) -> NDArray[np.int64]:
    """Return the indices of at most `size` of `count` points, random but always the same."""
    if count <= size:
        return np.arange(count)
    return np.random.default_rng(0).choice(count, size, replace=False, shuffle=False)
