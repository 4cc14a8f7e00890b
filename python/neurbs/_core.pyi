"""The compiled core of neurbs."""

import os
from collections.abc import Callable, Sequence
from typing import Any, Literal, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "ClosestPoints",
    "Curvatures",
    "NeurbsError",
    "NurbsCurve",
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
class Curvatures:
    """How a surface bends, at scattered parameters or on a grid."""

    @property
    def points(self) -> NDArray[np.float64]: ...
    @property
    def normals(self) -> NDArray[np.float64]: ...
    @property
    def gaussian(self) -> NDArray[np.float64]: ...
    @property
    def mean(self) -> NDArray[np.float64]: ...
    @property
    def principal(self) -> NDArray[np.float64]: ...
    @property
    def directions(self) -> NDArray[np.float64]: ...

@final
class ClosestPoints:
    """The feet of points on a surface."""

    @property
    def uv(self) -> NDArray[np.float64]: ...
    @property
    def points(self) -> NDArray[np.float64]: ...
    @property
    def distances(self) -> NDArray[np.float64]: ...
    @property
    def converged(self) -> NDArray[np.bool_]: ...

@final
class NurbsCurve:
    """A NURBS curve in space."""

    def __new__(
        cls,
        control_points: ArrayLike,
        weights: ArrayLike | None = None,
        degree: int = 3,
        knots: ArrayLike | None = None,
    ) -> NurbsCurve: ...
    @staticmethod
    def interpolate(
        points: ArrayLike,
        degree: int = 3,
        *,
        parametrization: Literal["chord", "uniform", "centripetal"] = "chord",
        closed: bool = False,
    ) -> NurbsCurve: ...
    @staticmethod
    def arc(
        centre: ArrayLike, x: ArrayLike, y: ArrayLike, angle: float = 6.283185307179586
    ) -> NurbsCurve: ...
    @staticmethod
    def from_dict(data: dict[str, Any]) -> NurbsCurve: ...
    @property
    def control_points(self) -> NDArray[np.float64]: ...
    @property
    def weights(self) -> NDArray[np.float64] | None: ...
    @property
    def degree(self) -> int: ...
    @property
    def knots(self) -> NDArray[np.float64]: ...
    @property
    def domain(self) -> tuple[float, float]: ...
    @property
    def closed(self) -> bool: ...
    def evaluate(
        self, u: ArrayLike, *, extrapolate: bool = False, out: NDArray[np.float64] | None = None
    ) -> NDArray[np.float64]: ...
    def derivatives(
        self,
        u: ArrayLike,
        order: int = 1,
        *,
        extrapolate: bool = False,
        out: NDArray[np.float64] | None = None,
    ) -> NDArray[np.float64]: ...
    def insert_knots(self, knots: ArrayLike) -> NurbsCurve: ...
    def remove_knots(self, knots: ArrayLike | None = None, *, tolerance: float) -> NurbsCurve: ...
    def elevate_degree(self, times: int = 1) -> NurbsCurve: ...
    def split(self, u: float) -> tuple[NurbsCurve, NurbsCurve]: ...
    def reversed(self) -> NurbsCurve: ...
    def transformed(self, matrix: ArrayLike) -> NurbsCurve: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class NurbsSurface:
    """A tensor-product NURBS surface."""

    def __new__(
        cls,
        control_points: ArrayLike,
        weights: ArrayLike | None = None,
        degree: int | tuple[int, int] = 3,
        knots: tuple[ArrayLike, ArrayLike] | None = None,
        *,
        closed: bool | tuple[bool, bool] = False,
    ) -> NurbsSurface: ...
    @staticmethod
    def interpolate(
        grid: ArrayLike,
        degree: int | tuple[int, int] = 3,
        *,
        parametrization: Literal["chord", "uniform", "centripetal"] = "chord",
        closed: bool | tuple[bool, bool] = False,
    ) -> NurbsSurface: ...
    @staticmethod
    def grid_parameters(
        grid: ArrayLike,
        degree: int | tuple[int, int] = 3,
        *,
        parametrization: Literal["chord", "uniform", "centripetal"] = "chord",
        closed: bool | tuple[bool, bool] = False,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
    @staticmethod
    def approximate(
        grid: ArrayLike,
        net: tuple[int, int],
        degree: int | tuple[int, int] = 3,
        *,
        parametrization: Literal["chord", "uniform", "centripetal"] = "chord",
        closed: bool | tuple[bool, bool] = False,
    ) -> NurbsSurface: ...
    @staticmethod
    def fit(
        points: ArrayLike,
        uv: ArrayLike,
        *,
        net: tuple[int, int] | None = None,
        degree: int | tuple[int, int] = 3,
        knots: tuple[ArrayLike, ArrayLike] | None = None,
        weights: ArrayLike | None = None,
        fairness: float = 1e-6,
        closed: bool | tuple[bool, bool] = False,
    ) -> NurbsSurface: ...
    @staticmethod
    def bezier(net: ArrayLike, weights: ArrayLike | None = None) -> NurbsSurface: ...
    @staticmethod
    def ruled(start: NurbsCurve, end: NurbsCurve) -> NurbsSurface: ...
    @staticmethod
    def lofted(
        curves: Sequence[NurbsCurve],
        degree: int = 3,
        *,
        parametrization: Literal["chord", "uniform", "centripetal"] = "chord",
    ) -> NurbsSurface: ...
    @staticmethod
    def revolved(
        profile: NurbsCurve,
        origin: ArrayLike,
        axis: ArrayLike,
        angle: float = 6.283185307179586,
    ) -> NurbsSurface: ...
    @staticmethod
    def plane(origin: ArrayLike, u: ArrayLike, v: ArrayLike) -> NurbsSurface: ...
    @staticmethod
    def cylinder(base: ArrayLike, axis: ArrayLike, radius: float) -> NurbsSurface: ...
    @staticmethod
    def cone(
        base: ArrayLike, axis: ArrayLike, radius: float, top_radius: float = 0.0
    ) -> NurbsSurface: ...
    @staticmethod
    def sphere(centre: ArrayLike, radius: float) -> NurbsSurface: ...
    @staticmethod
    def torus(centre: ArrayLike, major: float, minor: float) -> NurbsSurface: ...
    @staticmethod
    def from_dict(data: dict[str, Any]) -> NurbsSurface: ...
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
    @property
    def closed(self) -> tuple[bool, bool]: ...
    def evaluate(
        self, uv: ArrayLike, *, extrapolate: bool = False, out: NDArray[np.float64] | None = None
    ) -> NDArray[np.float64]: ...
    def evaluate_grid(
        self,
        u: ArrayLike,
        v: ArrayLike,
        *,
        extrapolate: bool = False,
        out: NDArray[np.float64] | None = None,
    ) -> NDArray[np.float64]: ...
    def normals(
        self, uv: ArrayLike, *, extrapolate: bool = False, out: NDArray[np.float64] | None = None
    ) -> NDArray[np.float64]: ...
    def normals_grid(
        self,
        u: ArrayLike,
        v: ArrayLike,
        *,
        extrapolate: bool = False,
        out: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
    def derivatives(
        self,
        uv: ArrayLike,
        order: int = 1,
        *,
        extrapolate: bool = False,
        out: NDArray[np.float64] | None = None,
    ) -> NDArray[np.float64]: ...
    def curvatures(
        self, uv: ArrayLike, *, extrapolate: bool = False, out: Curvatures | None = None
    ) -> Curvatures: ...
    def curvatures_grid(
        self,
        u: ArrayLike,
        v: ArrayLike,
        *,
        extrapolate: bool = False,
        out: Curvatures | None = None,
    ) -> Curvatures: ...
    def fundamental_forms(
        self,
        uv: ArrayLike,
        *,
        extrapolate: bool = False,
        out: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
    def closest_points(
        self, points: ArrayLike, *, out: ClosestPoints | None = None
    ) -> ClosestPoints: ...
    def insert_knots(
        self, u: ArrayLike | None = None, v: ArrayLike | None = None
    ) -> NurbsSurface: ...
    def remove_knots(
        self, u: ArrayLike | None = None, v: ArrayLike | None = None, *, tolerance: float
    ) -> NurbsSurface: ...
    def elevate_degree(self, u: int = 0, v: int = 0) -> NurbsSurface: ...
    def reduce_degree(self, u: int = 0, v: int = 0, *, tolerance: float) -> NurbsSurface: ...
    def clamped(self) -> NurbsSurface: ...
    def split(
        self, *, u: float | None = None, v: float | None = None
    ) -> tuple[NurbsSurface, NurbsSurface]: ...
    def sub_surface(
        self, *, u: tuple[float, float] | None = None, v: tuple[float, float] | None = None
    ) -> NurbsSurface: ...
    def bezier_patches(self) -> list[list[NurbsSurface]]: ...
    def isocurve(self, *, u: float | None = None, v: float | None = None) -> NurbsCurve: ...
    def reversed(self, u: bool = False, v: bool = False) -> NurbsSurface: ...
    def transposed(self) -> NurbsSurface: ...
    def transformed(self, matrix: ArrayLike) -> NurbsSurface: ...
    def with_domain(
        self, *, u: tuple[float, float] | None = None, v: tuple[float, float] | None = None
    ) -> NurbsSurface: ...
    def joined(
        self,
        other: NurbsSurface,
        direction: Literal["u", "v"] = "u",
        *,
        tolerance: float = 0.0,
    ) -> NurbsSurface: ...
    def bounding_box(
        self, *, tight: bool = True
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
    def area(self, *, accuracy: float = 1e-9) -> float: ...
    def tessellate(self, *, shape: tuple[int, int] | None = None) -> TriangleMesh: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

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
