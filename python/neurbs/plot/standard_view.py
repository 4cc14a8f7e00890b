"""The directions from which pictures show things."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from neurbs.errors import argument_error


@dataclass(frozen=True)
class View:
    """The direction toward the viewer, as angles in degrees."""

    elevation: float
    azimuth: float
    light: tuple[float, float, float]
    """Direction toward the light: to the right, up and toward the viewer."""

    @property
    def axes(self) -> NDArray[np.float64]:
        """The unit vectors to the right, up and toward the viewer, as rows."""
        elevation, azimuth = np.radians([self.elevation, self.azimuth])
        sin_e, cos_e = np.sin(elevation), np.cos(elevation)
        sin_a, cos_a = np.sin(azimuth), np.cos(azimuth)
        right = [-sin_a, cos_a, 0.0]
        up = [-sin_e * cos_a, -sin_e * sin_a, cos_e]
        return np.array([right, up, [cos_e * cos_a, cos_e * sin_a, sin_e]])

    @property
    def depth_axis(self) -> int | None:
        """The coordinate axis along the line of sight, if there is one."""
        along = np.abs(self.axes[2])
        return int(along.argmax()) if along.max() > 1 - 1e-12 else None


_AHEAD = (-0.4, 0.4, 0.82)
"""Light of a view along an axis: what faces the viewer is bright."""

VIEWS = {
    "iso": View(35.0, -60.0, (-0.63, 0.71, 0.31)),
    "top": View(90.0, -90.0, _AHEAD),
    "front": View(0.0, -90.0, _AHEAD),
    "side": View(0.0, 0.0, _AHEAD),
}
"""At an angle from above, along z, along y and along x. X is to the right in ``"top"`` and
``"front"``, y in ``"side"``."""


def view_of(name: str) -> View:
    """Return the view of a name; raise for a name of no view."""
    if name not in VIEWS:
        raise argument_error("view", f"must be one of {', '.join(VIEWS)}, got {name!r}")
    return VIEWS[name]
