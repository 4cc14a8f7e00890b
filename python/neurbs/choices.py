"""Types of arguments with a few allowed values, for type checkers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, TypeAlias

from numpy.typing import NDArray

KindChoice: TypeAlias = Literal["auto", "sheet", "height", "tube", "torus"]
"""A kind of surface, or the automatic choice."""

LengthUnit: TypeAlias = Literal["mm", "cm", "m", "in", "ft"]
"""A unit of shells and CAD files."""

TrimChoice: TypeAlias = bool | Literal["auto", "outer"]
"""Where faces end."""

SurfaceColor: TypeAlias = Literal["height", "deviation", "mean", "gaussian", "zebra"]
"""A quantity that the colors of a surface show."""

ViewChoice: TypeAlias = Literal["iso", "top", "front", "side"]
"""A direction of the viewer."""

Backend: TypeAlias = Literal["matplotlib", "pyvista"]
"""A library that draws."""

Positions: TypeAlias = (
    NDArray[Any] | Sequence[Sequence[float]] | Sequence[Sequence[Sequence[float]]]
)
"""Positions of nodes; narrower than ``ArrayLike``, which includes any text."""
