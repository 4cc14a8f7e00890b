"""The compiled core of neurbs."""

import os
from collections.abc import Callable
from typing import Any, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "NeurbsError",
    "NurbsSurface",
    "Progress",
    "TrainedMap",
    "TriangleMesh",
    "__version__",
    "as_points",
    "default_options",
    "reconstruct",
    "train",
    "write_iges",
    "write_obj",
    "write_step",
]

__version__: str

class NeurbsError(ValueError):
    """Bad input: the message says what must hold, what came, and what to do."""

@final
class Progress:
    """What a long job is doing at this moment."""

    @property
    def stage(self) -> str: ...
    @property
    def step(self) -> int: ...
    @property
    def total(self) -> int: ...
    @property
    def change(self) -> float | None: ...
    @property
    def reached(self) -> int: ...
    @property
    def points(self) -> int: ...

@final
class NurbsSurface:
    """A tensor-product NURBS surface."""

    def __new__(
        cls,
        control_points: ArrayLike,
        weights: ArrayLike | None = None,
        degree: int | tuple[int, int] = 3,
        knots: tuple[ArrayLike, ArrayLike] | None = None,
    ) -> NurbsSurface: ...
    @property
    def control_points(self) -> NDArray[np.float64]: ...
    @property
    def weights(self) -> NDArray[np.float64] | None: ...
    @property
    def degree(self) -> tuple[int, int]: ...
    @property
    def knots(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
    @property
    def domain(self) -> tuple[tuple[float, float], tuple[float, float]]: ...
    def evaluate(
        self, uv: ArrayLike, *, out: NDArray[np.float64] | None = None
    ) -> NDArray[np.float64]: ...
    def evaluate_grid(
        self, u: ArrayLike, v: ArrayLike, *, out: NDArray[np.float64] | None = None
    ) -> NDArray[np.float64]: ...
    def normals(
        self, uv: ArrayLike, *, out: NDArray[np.float64] | None = None
    ) -> NDArray[np.float64]: ...
    def tessellate(self, *, shape: tuple[int, int] | None = None) -> TriangleMesh: ...

@final
class TriangleMesh:
    """Triangles of a surface, with a normal and the surface's parameters at each vertex."""

    @property
    def vertices(self) -> NDArray[np.float64]: ...
    @property
    def triangles(self) -> NDArray[np.uint32]: ...
    @property
    def normals(self) -> NDArray[np.float64]: ...
    @property
    def uv(self) -> NDArray[np.float64]: ...
    @property
    def shape(self) -> tuple[int, int]: ...

@final
class TrainedMap:
    """A trained map: the lattice's nodes in space, and how the training went."""

    @property
    def codebook(self) -> NDArray[np.float64]: ...
    @property
    def steps(self) -> int: ...
    @property
    def ordered_at(self) -> int: ...
    @property
    def stopped_by(self) -> str: ...
    @property
    def reached(self) -> int: ...
    @property
    def change(self) -> float | None: ...

def as_points(points: ArrayLike) -> NDArray[np.float64]: ...
def default_options() -> dict[str, Any]: ...
def reconstruct(
    points: ArrayLike,
    *,
    method: str,
    grid: tuple[int, int] | None,
    degree: int,
    seed: int,
    max_steps: int | None,
    reach: float | None,
    min_change: float | None,
    progress: Callable[[Progress], object] | None,
) -> tuple[NurbsSurface, TriangleMesh, TrainedMap, dict[str, Any]]: ...
def train(
    points: ArrayLike,
    *,
    grid: tuple[int, int],
    gain_scale: float | None,
    radius_scale: float | None,
    max_steps: int | None,
    reach: float | None,
    min_change: float | None,
    seed: int,
    progress: Callable[[Progress], object] | None,
) -> TrainedMap: ...
def write_iges(surface: NurbsSurface, path: str | os.PathLike[str]) -> None: ...
def write_obj(mesh: TriangleMesh, path: str | os.PathLike[str]) -> None: ...
def write_step(surface: NurbsSurface, path: str | os.PathLike[str]) -> None: ...
