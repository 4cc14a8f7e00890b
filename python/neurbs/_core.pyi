"""The compiled core of neurbs."""

import os
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Literal, TypeAlias, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "DIAGNOSTIC_CODES",
    "LENGTH_UNITS",
    "BatchSums",
    "Cleaning",
    "ClosestPoints",
    "Components",
    "Curvatures",
    "Epoch",
    "EvenSample",
    "HeightFit",
    "Lattice",
    "Map",
    "NeurbsError",
    "NeurbsMemoryError",
    "NurbsCurve",
    "NurbsSurface",
    "Progress",
    "TriangleMesh",
    "__version__",
    "as_points",
    "candidates",
    "clean",
    "components",
    "default_options",
    "fit_heights",
    "fit_weights",
    "lattice_for_points",
    "num_threads",
    "reconstruct",
    "reconstruct_paper",
    "recover_net",
    "set_num_threads",
    "som_options",
    "tessellate",
    "validate",
    "write_iges",
    "write_obj",
    "write_obj_surface",
    "write_step",
]

DIAGNOSTIC_CODES: list[tuple[str, str]]
"""Codes of diagnostics, each with its meaning in one line."""

LENGTH_UNITS: dict[str, float]
"""The symbols of the length units, each with its length in millimeters."""

__version__: str

class NeurbsError(ValueError):
    """Invalid input. The message gives the requirement, the value received, and what to do."""

    argument: str | None
    """The argument that the error is about, None if it is not about the value of one."""

class NeurbsMemoryError(NeurbsError, MemoryError):
    """A call needs more memory than is available: the message says how much."""

@final
class Progress:
    """The current state of a long job."""

    @property
    def stage(self) -> str: ...
    @property
    def step(self) -> int: ...
    @property
    def total(self) -> int: ...
    @property
    def change(self) -> float | None: ...
    @property
    def error(self) -> float | None: ...
    @property
    def radius(self) -> float | None: ...
    @property
    def reached(self) -> int: ...
    @property
    def points(self) -> int: ...
    @property
    def share(self) -> float | None: ...

@final
class Curvatures:
    """Curvatures of a surface, at scattered parameters or on a grid."""

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
    """The projections of points onto a surface."""

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
    """A NURBS curve in space: an isocurve, a boundary, a profile."""

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
        center: ArrayLike, x: ArrayLike, y: ArrayLike, angle: float = 6.283185307179586
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
    def reduce_degree(self, times: int = 1, *, tolerance: float) -> NurbsCurve: ...
    def clamped(self) -> NurbsCurve: ...
    def split(self, u: float) -> tuple[NurbsCurve, NurbsCurve]: ...
    def sub_curve(self, first: float, last: float) -> NurbsCurve: ...
    def with_domain(self, first: float, last: float) -> NurbsCurve: ...
    def joined(self, other: NurbsCurve, *, tolerance: float = 0.0) -> NurbsCurve: ...
    def length(self, *, accuracy: float = 1e-9) -> float: ...
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
        out: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None,
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
    def sphere(center: ArrayLike, radius: float) -> NurbsSurface: ...
    @staticmethod
    def torus(center: ArrayLike, major: float, minor: float) -> NurbsSurface: ...
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
        self,
        *,
        tight: bool = True,
        out: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
    def area(self, *, accuracy: float = 1e-9) -> float: ...
    def tessellate(
        self,
        tolerance: float | None = None,
        *,
        shape: tuple[int, int] | None = None,
        relative: bool = False,
        max_angle: float | None = None,
        max_edge: float | None = None,
        max_aspect: float | None = None,
        split_seams: bool = False,
        max_triangles: int = 100_000_000,
        progress: Callable[[Progress], object] | None = None,
    ) -> TriangleMesh: ...
    def plot(
        self,
        points: ArrayLike | None = None,
        *,
        color: Literal["height", "deviation", "mean", "gaussian", "zebra"] | None = None,
        tolerance: float | None = None,
        unit: str = "",
        isolines: int = 20,
        control_net: bool = False,
        backend: Literal["matplotlib", "pyvista"] = "matplotlib",
    ) -> Any: ...
    def to_dict(self) -> dict[str, Any]: ...
    def _repr_html_(self) -> str: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class TriangleMesh:
    """A triangle mesh of a surface, with a normal and surface parameters at each vertex."""

    @property
    def vertices(self) -> NDArray[np.float64]: ...
    @property
    def triangles(self) -> NDArray[np.uint32]: ...
    @property
    def normals(self) -> NDArray[np.float64]: ...
    @property
    def uv(self) -> NDArray[np.float64]: ...
    @property
    def max_deviation(self) -> float | None: ...
    @property
    def shape(self) -> tuple[int, int] | None: ...
    @property
    def quads(self) -> NDArray[np.uint32] | None: ...
    def area(self) -> float: ...
    def volume(self) -> float | None: ...
    def euler_characteristic(self) -> int: ...
    def boundary_loops(self) -> list[NDArray[np.uint32]]: ...
    def deviation(
        self, points: ArrayLike, *, out: NDArray[np.float64] | None = None
    ) -> NDArray[np.float64]: ...
    def save(self, path: str | os.PathLike[str]) -> None: ...
    def to_trimesh(self) -> Any: ...
    def to_pyvista(self) -> Any: ...

@final
class Lattice:
    """The nodes of a self-organizing map and their connections."""

    @staticmethod
    def grid(
        rows: int, cols: int, *, cells: str | None = None, topology: str | None = None
    ) -> Lattice: ...
    @staticmethod
    def graph(nodes: int, edges: Iterable[tuple[int, int]]) -> Lattice: ...
    @property
    def shape(self) -> tuple[int, int]: ...
    @property
    def nodes(self) -> int: ...
    @property
    def topology(self) -> str: ...
    @property
    def cells(self) -> str | None: ...
    @property
    def edges(self) -> list[tuple[int, int]]: ...
    def neighborhood(self, node: int, radius: int) -> list[int]: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __hash__(self, /) -> int: ...

@final
class BatchSums:
    """Sums over the points of each node of a map: a batch epoch or a part of it."""

    @property
    def points(self) -> int: ...
    @property
    def mean_distance(self) -> float: ...
    @property
    def hits(self) -> list[int]: ...
    def to_bytes(self) -> bytes: ...
    @staticmethod
    def from_bytes(state: bytes) -> BatchSums: ...
    def __add__(self, value: BatchSums, /) -> BatchSums: ...
    def __radd__(self, value: BatchSums, /) -> BatchSums: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self, /) -> int: ...

@final
class Epoch:
    """The state of a map after an epoch of training."""

    @property
    def step(self) -> int: ...
    @property
    def error(self) -> float: ...
    @property
    def radius(self) -> float: ...
    @property
    def change(self) -> float: ...
    @property
    def lattice(self) -> NDArray[np.float64]: ...

@final
class Map:
    """A map at any stage of its training; the public class is `neurbs.SelfOrganizingMap`."""

    def __new__(
        cls, points: ArrayLike, lattice: Lattice, options: dict[str, Any], *, chunks: bool = False
    ) -> Map: ...
    def train(
        self,
        points: ArrayLike,
        *,
        progress: Callable[[Progress], object] | None = None,
        observer: Callable[[Epoch], object] | None = None,
        seconds: float | None = None,
    ) -> bool: ...
    def present(self, points: ArrayLike) -> None: ...
    def sums(self, points: ArrayLike) -> BatchSums: ...
    def learn(self, sums: BatchSums) -> None: ...
    def train_on_distribution(
        self,
        sampler: Callable[[int], ArrayLike],
        *,
        progress: Callable[[Progress], object] | None = None,
        observer: Callable[[Epoch], object] | None = None,
    ) -> None: ...
    def predict(
        self, points: ArrayLike, out: NDArray[np.int64] | None = None
    ) -> NDArray[np.int64]: ...
    def quantization_error(self, points: ArrayLike) -> float: ...
    def topographic_error(self, points: ArrayLike) -> float: ...
    def hits(self, points: ArrayLike) -> NDArray[np.int64]: ...
    def u_matrix(self) -> NDArray[np.float64]: ...
    def fold_overs(self) -> int | None: ...
    def parametrize(
        self, points: ArrayLike, extrapolation: float, out: NDArray[np.float64] | None = None
    ) -> NDArray[np.float64]: ...
    @property
    def codebook(self) -> NDArray[np.float64]: ...
    @property
    def lattice(self) -> Lattice: ...
    @property
    def steps(self) -> int: ...
    @property
    def ordered_at(self) -> int: ...
    @property
    def stopped_by(self) -> str: ...
    @property
    def converged(self) -> bool: ...
    @property
    def reached(self) -> int: ...
    @property
    def change(self) -> float | None: ...
    @property
    def error(self) -> float | None: ...
    @property
    def radius(self) -> float: ...
    def to_bytes(self) -> bytes: ...
    @staticmethod
    def from_bytes(state: bytes) -> Map: ...

@final
class Cleaning:
    """The result of `clean`."""

    @property
    def kept(self) -> NDArray[np.int64]: ...
    @property
    def duplicates(self) -> NDArray[np.int64]: ...
    @property
    def outliers(self) -> NDArray[np.int64]: ...
    @property
    def weights(self) -> NDArray[np.float64]: ...
    @property
    def spacing(self) -> float: ...

@final
class Components:
    """The connected components of a cloud, returned by `components`."""

    @property
    def labels(self) -> NDArray[np.int64]: ...
    @property
    def sizes(self) -> list[int]: ...
    @property
    def gap(self) -> float: ...

@final
class EvenSample:
    """An even spatial subsample of a stream of points of any length."""

    def __new__(cls, most: int) -> EvenSample: ...
    def extend(self, points: ArrayLike) -> None: ...
    @property
    def points(self) -> NDArray[np.float64]: ...
    @property
    def indices(self) -> NDArray[np.int64]: ...

@final
class HeightFit:
    """The result of `fit_heights`."""

    @property
    def surface(self) -> NurbsSurface: ...
    @property
    def uv(self) -> NDArray[np.float64]: ...
    @property
    def residuals(self) -> NDArray[np.float64]: ...
    @property
    def fairness(self) -> float: ...

_Found: TypeAlias = tuple[
    NurbsSurface,
    Map,
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.bool_],
    dict[str, Any],
    list[tuple[str, int, float]],
]

def as_points(points: ArrayLike) -> NDArray[np.float64]: ...
def clean(
    points: ArrayLike, *, progress: Callable[[Progress], object] | None = None
) -> Cleaning: ...
def components(
    points: ArrayLike, *, progress: Callable[[Progress], object] | None = None
) -> Components: ...
def candidates(
    points: ArrayLike,
    kind: str,
    progress: Callable[[Progress], object] | None,
) -> tuple[dict[str, Any], ...]: ...
def validate(
    surface: NurbsSurface,
    points: ArrayLike,
    progress: Callable[[Progress], object] | None,
) -> tuple[tuple[str, str, dict[str, Any], bool], ...]: ...
def recover_net(
    points: ArrayLike,
    shape: tuple[int, int],
    *,
    progress: Callable[[Progress], object] | None = None,
) -> NurbsSurface: ...
def fit_heights(
    points: ArrayLike,
    net: tuple[int, int],
    *,
    up: ArrayLike = ...,
    degree: int | tuple[int, int] = 3,
    weights: ArrayLike | None = None,
    fairness: float | None = None,
) -> HeightFit: ...
def fit_weights(
    surface: NurbsSurface, points: ArrayLike, *, weights: ArrayLike | None = None
) -> NurbsSurface: ...
def default_options() -> dict[str, Any]: ...
def reconstruct(
    points: ArrayLike,
    options: dict[str, Any],
    progress: Callable[[Progress], object] | None,
) -> _Found: ...
def reconstruct_paper(
    points: ArrayLike,
    options: dict[str, Any],
    progress: Callable[[Progress], object] | None,
) -> _Found: ...
def lattice_for_points(points: int) -> tuple[int, int]: ...
def num_threads() -> int: ...
def set_num_threads(threads: int) -> None: ...
def som_options(paper: bool) -> dict[str, Any]: ...
def tessellate(
    surfaces: Iterable[NurbsSurface],
    tolerance: float | None = None,
    *,
    relative: bool = False,
    max_angle: float | None = None,
    max_edge: float | None = None,
    max_aspect: float | None = None,
    split_seams: bool = False,
    max_triangles: int = 100_000_000,
    progress: Callable[[Progress], object] | None = None,
) -> list[TriangleMesh]: ...
def write_iges(
    surface: NurbsSurface, path: str | os.PathLike[str], unit: str | None = None
) -> None: ...
def write_obj(mesh: TriangleMesh, path: str | os.PathLike[str]) -> None: ...
def write_obj_surface(surface: NurbsSurface, path: str | os.PathLike[str]) -> None: ...
def write_step(
    surface: NurbsSurface, path: str | os.PathLike[str], unit: str | None = None
) -> None: ...
