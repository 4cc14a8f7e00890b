"""Clouds of the scoreboard: points of known surfaces, and real scans.

A synthetic cloud is named family/points/noise/seed, and its name fixes every bit of it. Noise is
the root mean square length of the displacements, as a share of the diagonal. Points are drawn
evenly by area. Families with a pose are scaled by 20, rotated at random and moved to (100, 100,
100). A real cloud is named real:STEM after its file STEM.npy in the folder NEURBS_DATA/npy.
"""

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy import cos, sin
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

TAU = 2 * np.pi
STEPS = 1e-5 * np.eye(2)
"""Steps along u and v, for difference quotients."""
SIDE = 70
"""Samples along each side of the grid on which surfaces are compared by their normals."""
CASES = ((40, 0), (300, 0), (300, 0.01), (3000, 0), (3000, 0.01), (3000, 0.03))
"""Number of points and noise of the clouds of a family."""
HEIGHTS = frozenset({"hills", "steep", "coast", "tracks", "sparse"})
"""Families of height fields along z, all axes in one unit."""


@dataclass(frozen=True)
class Family:
    """Surface over the unit square, and how points are drawn from it."""

    surface: Callable[[Array, Array], Array]
    kinds: frozenset[str]
    """Kinds that are right."""
    posed: bool
    keep: Callable[[Array, Array], Mask] | None
    """Where the surface has points at all."""
    density: Callable[[Array, Array], Array] | None
    """Share of the points that is kept; the truth is sampled everywhere."""

    def at(self, uv: Array) -> Array:
        """Return places of the surface."""
        return self.surface(uv[:, 0], uv[:, 1])

    def draw(self, number: int, rng: np.random.Generator, thinned: bool) -> Array:
        """Return points drawn evenly by area."""
        parts = [self._try(3 * number, rng, thinned)]
        while sum(map(len, parts)) < number:
            parts.append(self._try(3 * number, rng, thinned))
        return np.concatenate(parts)[:number]

    def _try(self, number: int, rng: np.random.Generator, thinned: bool) -> Array:
        """Draw parameters evenly, and keep each with a probability that grows with the area."""
        uv = rng.random((number, 2))
        x = self.at(uv)
        along, across = (self.at(uv + step) - x for step in STEPS)
        area = np.linalg.norm(np.cross(along, across), axis=1)
        kept = area > rng.random(number) * np.quantile(area, 0.995)
        if self.keep is not None:
            kept &= self.keep(uv[:, 0], uv[:, 1])
        if self.density is not None and thinned:
            kept &= self.density(uv[:, 0], uv[:, 1]) > rng.random(number)
        return x[kept]


@dataclass(frozen=True)
class Cloud:
    """Points with the surface that they come from, if it is known."""

    points: Array
    truth: Array | None = None
    """Dense samples of the true surface."""
    grid: tuple[Array, Array] | None = None
    """Places and normals of the true surface on a grid of `SIDE` × `SIDE` parameters."""


FAMILIES: dict[str, Family] = {}


def family(
    *kinds: str,
    posed: bool = True,
    keep: Callable[[Array, Array], Mask] | None = None,
    density: Callable[[Array, Array], Array] | None = None,
) -> Callable[[Callable[[Array, Array], Array]], Callable[[Array, Array], Array]]:
    """Register a function of (u, v) as the surface of a family of clouds."""

    def register(surface: Callable[[Array, Array], Array]) -> Callable[[Array, Array], Array]:
        FAMILIES[surface.__name__] = Family(surface, frozenset(kinds), posed, keep, density)
        return surface

    return register


def xyz(x: Array, y: Array, z: Array) -> Array:
    return np.stack(np.broadcast_arrays(x, y, z), -1)


@family("height", "sheet", posed=False)
def hills(u: Array, v: Array) -> Array:
    return xyz(u, v, 0.15 * sin(6 * u) * cos(5 * v))


@family("height", "sheet", posed=False)
def steep(u: Array, v: Array) -> Array:
    return xyz(u, v, 0.5 * sin(7 * u) * cos(6 * v))


@family("height", posed=False)
def units(u: Array, v: Array) -> Array:
    return xyz(u, v, 1000 * (0.5 * sin(5 * u) + v**2))


def _on_land(u: Array, v: Array) -> Mask:
    return (v < 0.55 + 0.3 * sin(7 * u)) & (np.hypot(u - 0.3, v - 0.3) > 0.12)


@family("height", "sheet", posed=False, keep=_on_land)
def coast(u: Array, v: Array) -> Array:
    return xyz(u, v, 0.2 * sin(4 * u + 3 * v))


@family("height", "sheet", posed=False, keep=lambda u, v: np.abs((v * 12) % 1 - 0.5) < 0.04)
def tracks(u: Array, v: Array) -> Array:
    return xyz(u, v, 0.1 * sin(9 * u) * sin(4 * v))


@family("height", "sheet")
def wave(u: Array, v: Array) -> Array:
    return xyz(u, v, 0.2 * sin(6 * u) * cos(4 * v))


@family("sheet")
def arc(u: Array, v: Array) -> Array:
    return xyz(cos(4.6 * u), sin(4.6 * u), 2 * v)


@family("sheet")
def fold(u: Array, v: Array) -> Array:
    angle = 3 * np.pi * (u - 0.5)
    return xyz(sin(angle), 2 * v, np.sign(u - 0.5) * (cos(angle) - 1))


@family("sheet")
def roll(u: Array, v: Array) -> Array:
    return xyz((0.4 + u) * cos(11 * u), (0.4 + u) * sin(11 * u), 2 * v)


@family("sheet")
def hairpin(u: Array, v: Array) -> Array:
    """Return two parallel layers, 0.3 apart, that half a circle joins."""
    length = u * (4 + 0.15 * np.pi)
    angle = (length - 2) / 0.15
    bend = np.clip(angle, 0, np.pi)
    after = np.where(angle > np.pi, length - 2 - 0.15 * np.pi, -0.15 * sin(bend))
    x = np.where(length < 2, 2 - length, after)
    return xyz(x, 0.15 * cos(bend) + 0.1 * sin(6 * v), 1.5 * v)


@family("sheet", "height")
def dome(u: Array, v: Array) -> Array:
    return xyz(sin(1.4 * u) * cos(TAU * v), sin(1.4 * u) * sin(TAU * v), cos(1.4 * u))


@family("sheet", "height", "tube")
def cone(u: Array, v: Array) -> Array:
    return xyz(u * cos(TAU * v), u * sin(TAU * v), 1.6 * u)


@family("sheet")
def helicoid(u: Array, v: Array) -> Array:
    return xyz((2 * u - 1) * cos(5 * v), (2 * u - 1) * sin(5 * v), 2 * v)


@family("sheet", "height")
def leaf(u: Array, v: Array) -> Array:
    width = 0.9 * (v - 0.5) * sin(np.pi * u) ** 0.7
    return xyz(2 * u, width, 0.25 * sin(3 * u) + 0.3 * (v - 0.5) ** 2)


@family("sheet", "tube", "height")
def ring(u: Array, v: Array) -> Array:
    radius = 0.45 + 0.55 * u
    return xyz(radius * cos(TAU * v), radius * sin(TAU * v), 0.2 * sin(3 * TAU * v) * u)


def _outside_holes(u: Array, v: Array) -> Mask:
    centers = ((0.25, 0.3), (0.7, 0.5), (0.3, 0.75))
    return np.all([np.hypot(2.4 * (u - a), 2 * (v - b)) > 0.25 for a, b in centers], axis=0)


@family("sheet", "height", keep=_outside_holes)
def holes(u: Array, v: Array) -> Array:
    return xyz(cos(2.4 * u), sin(2.4 * u), 2 * v)


@family("tube")
def pipe(u: Array, v: Array) -> Array:
    return xyz((1 + 0.12 * sin(TAU * v)) * cos(TAU * u), sin(TAU * u), 4 * v)


@family("tube")
def bend(u: Array, v: Array) -> Array:
    radius = 3 + cos(TAU * u)
    return xyz(radius * cos(2.6 * v), radius * sin(2.6 * v), sin(TAU * u))


@family("tube")
def vase(u: Array, v: Array) -> Array:
    radius = 0.5 + 0.3 * sin(5 * v)
    return xyz(radius * cos(TAU * u), radius * sin(TAU * u), 2 * v)


@family("sheet")
def halfpipe(u: Array, v: Array) -> Array:
    return xyz(cos(3.3 * u), sin(3.3 * u), 4 * v)


@family("height", "sheet", posed=False, density=lambda u, v: np.where(u < 0.3, 1, 0.02))
def sparse(u: Array, v: Array) -> Array:
    return xyz(u, v, 0.3 * sin(3 * u) * cos(2 * v))


@family("torus")
def torus(u: Array, v: Array) -> Array:
    radius = 2 + 0.7 * cos(TAU * u)
    return xyz(radius * cos(TAU * v), radius * sin(TAU * v), 0.7 * sin(TAU * u))


def is_right(name: str, kind: str) -> bool:
    """Return whether a kind is right for a synthetic cloud.

    Only many points with little noise show the narrow opening of the vase.
    """
    family_name, number, noise, _ = name.split("/")
    shown = int(number) >= 3000 and float(noise) < 0.03
    may_be_open = family_name == "vase" and not shown
    return kind in FAMILIES[family_name].kinds or (may_be_open and kind == "sheet")


def synthetic_names(seeds: int) -> list[str]:
    """Return the names of all synthetic clouds of some seeds."""
    return [
        f"{name}/{number}/{noise}/{seed}"
        for seed in range(seeds)
        for name in FAMILIES
        for number, noise in CASES
    ]


def folder() -> Path:
    """Return the folder of the real clouds."""
    return Path(os.environ.get("NEURBS_DATA", "."), "npy")


def real_names() -> list[str]:
    """Return the names of all real clouds."""
    return [f"real:{path.stem}" for path in sorted(folder().glob("*.npy"))]


def diagonal(points: Array) -> np.float64:
    return np.linalg.norm(np.ptp(points, axis=0))


def cloud(name: str) -> Cloud:
    """Return the cloud of a name."""
    if name.startswith("real:"):
        return Cloud(np.load(folder() / f"{name[5:]}.npy"))
    family_name, number, noise, seed = name.split("/")
    rng = np.random.default_rng(1000 * int(seed) + sum(map(ord, family_name + number + noise)))
    chosen = FAMILIES[family_name]
    points = chosen.draw(int(number), rng, thinned=True)
    truth = chosen.draw(8000, rng, thinned=False)
    # Axes of different units have noise of their own.
    extent = np.ptp(truth, axis=0) if family_name == "units" else diagonal(truth)
    points = points + float(noise) / np.sqrt(3) * extent * rng.standard_normal(points.shape)
    linear, offset = np.eye(3), 0
    if chosen.posed:
        rotation, _ = np.linalg.qr(rng.standard_normal((3, 3)))
        points, truth = (20 * points) @ rotation.T + 100, (20 * truth) @ rotation.T + 100
        linear, offset = 20 * rotation.T, 100

    def placed(uv: Array) -> Array:
        return chosen.at(uv) @ linear + offset

    uv = grid_parameters()
    along, across = (placed(uv + step) - placed(uv - step) for step in STEPS)
    normals = np.cross(along, across)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    return Cloud(points, truth, (placed(uv), normals))


def grid_parameters(low: tuple[float, float] = (0, 0), high: tuple[float, float] = (1, 1)) -> Array:
    """Return `SIDE` × `SIDE` parameters that keep off the ends of a rectangle."""
    at = np.linspace(0.003, 0.997, SIDE)
    u, v = (a + (b - a) * at for a, b in zip(low, high, strict=True))
    return np.stack(np.meshgrid(u, v, indexing="ij"), -1).reshape(-1, 2)
