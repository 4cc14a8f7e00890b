"""The libraries of `nurbs_peers.py`, each with its calls for the cases that it can do."""

import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, NdBSpline, make_interp_spline
from scipy.spatial import cKDTree

import neurbs

Array = NDArray[np.float64]
Cases = dict[str, Callable[..., Any]]
# Vertices, triangles and the vertices' parameters.
Triangles = tuple[Array, NDArray[Any], Array]


class Surface:
    """A random rational bicubic surface, and its evaluation in plain NumPy."""

    def __init__(self, net: int, seed: int = 7) -> None:
        rng = np.random.default_rng(seed)
        self.knots = np.r_[np.zeros(3), np.linspace(0, 1, net - 2), np.ones(3)]
        grid = np.linspace(0, 10, net)
        self.points = np.empty((net, net, 3))
        self.points[..., 0], self.points[..., 1] = np.meshgrid(grid, grid, indexing="ij")
        self.points[..., :2] += rng.uniform(-0.1, 0.1, (net, net, 2)) * 10 / (net - 1)
        noise = rng.uniform(-0.1, 0.1, (net, net)) * min(1, 20 / (net - 1))
        x, y = self.points[..., 0], self.points[..., 1]
        self.points[..., 2] = np.sin(1.3 * x) * np.cos(1.1 * y) + noise
        self.weights = rng.uniform(0.5, 2, (net, net))
        lifted = [self.points * self.weights[..., None], self.weights[..., None]]
        self.homogeneous = np.concatenate(lifted, axis=-1)
        self.size = float(np.linalg.norm(np.ptp(self.points.reshape(-1, 3), axis=0)))

    def basis(self, x: Array, order: int) -> tuple[NDArray[np.intp], Array]:
        """Spans, and cubic basis functions with derivatives, of shape (order + 1, n, 4)."""
        span = np.clip(np.searchsorted(self.knots, x, "right") - 1, 3, len(self.knots) - 5)
        rows = []
        for derivative in range(order + 1):
            values = np.ones((len(x), 1))
            for degree in range(1, 4):
                new = np.zeros((len(x), degree + 1))
                for i in range(degree):
                    low, high = self.knots[span - degree + 1 + i], self.knots[span + 1 + i]
                    share = values[:, i] / (high - low)
                    if degree > 3 - derivative:
                        new[:, i] -= degree * share
                        new[:, i + 1] += degree * share
                    else:
                        new[:, i] += (high - x) * share
                        new[:, i + 1] += (x - low) * share
                values = new
            rows.append(values)
        return span - 3, np.stack(rows)

    def derivatives(self, uv: Array, order: int) -> dict[tuple[int, int], Array]:
        """Differentiate up to a total order, by the quotient rule."""
        (first_u, rows), (first_v, columns) = (
            self.basis(uv[:, 0], order),
            self.basis(uv[:, 1], order),
        )
        four = np.arange(4)
        net = self.homogeneous[
            (first_u[:, None] + four)[:, :, None], (first_v[:, None] + four)[:, None, :]
        ]
        result: dict[tuple[int, int], Array] = {}
        weights: dict[tuple[int, int], Array] = {}
        for k in range(order + 1):
            for m in range(order + 1 - k):
                value = np.einsum("ni,nj,nijc->nc", rows[k], columns[m], net)
                weights[k, m], sums = value[:, 3:], value[:, :3]
                for i in range(k + 1):
                    for j in range(m + 1):
                        if i or j:
                            factor = math.comb(k, i) * math.comb(m, j)
                            sums = sums - factor * weights[i, j] * result[k - i, m - j]
                result[k, m] = sums / weights[0, 0]
        return result

    def closest(self, points: Array, start: Array) -> Array:
        """Newton's method from given parameters, clamped to the domain."""
        uv, todo = start.copy(), np.arange(len(points))
        for _ in range(30):
            d = self.derivatives(uv[todo], 2)
            away = d[0, 0] - points[todo]
            su, sv = d[1, 0], d[0, 1]

            def dot(a: Array, b: Array) -> Array:
                return np.asarray((a * b).sum(1))

            gu, gv = dot(su, away), dot(sv, away)
            a = dot(su, su) + dot(away, d[2, 0])
            b = dot(su, sv) + dot(away, d[1, 1])
            c = dot(sv, sv) + dot(away, d[0, 2])
            bad = (a * c - b * b <= 0) | (a <= 0)
            a[bad], b[bad], c[bad] = dot(su, su)[bad], dot(su, sv)[bad], dot(sv, sv)[bad]
            det = a * c - b * b
            step = np.column_stack([gv * b - gu * c, gu * b - gv * a]) / det[:, None]
            new = np.clip(uv[todo] + step, 0, 1)
            moved = np.abs(new - uv[todo]).max(1)
            uv[todo] = new
            todo = todo[moved > 1e-13]
            if not len(todo):
                break
        return uv


def chord_parameters(grid: Array) -> tuple[Array, Array]:
    def one(grid: Array) -> Array:
        steps = np.linalg.norm(np.diff(grid, axis=0), axis=2)
        return np.r_[0, np.cumsum(steps / steps.sum(0), axis=0).mean(1)[:-1], 1]

    return one(grid), one(grid.transpose(1, 0, 2))


def numpy_peer(surface: Surface) -> Cases:
    t = np.linspace(0, 1, 4 * len(surface.points))
    samples = np.column_stack([x.ravel() for x in np.meshgrid(t, t, indexing="ij")])

    def closest(points: Array) -> Array:
        tree = cKDTree(surface.derivatives(samples, 0)[0, 0])
        return surface.closest(points, samples[tree.query(points)[1]])

    return {"c": lambda uv: surface.derivatives(uv, 0)[0, 0], "f": closest}


def uniform(points: Array, t: Array) -> Triangles:
    """Make the triangles of an even grid."""
    n = len(t)
    first = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    corners = [[first, first + n, first + n + 1], [first, first + n + 1, first + 1]]
    return (
        points.reshape(-1, 3),
        np.concatenate([np.stack(c, axis=1) for c in corners]),
        pairs(t, t),
    )


@functools.cache
def uniform_side(surface: Surface, tolerance: float) -> int:
    """Find the smallest even grid that holds a tolerance, in steps of a tenth."""

    def holds(n: int) -> bool:
        t = np.linspace(0, 1, n)
        points = surface.derivatives(pairs(t, t), 0)[0, 0]
        return deviation(surface, uniform(points, t)) <= tolerance

    side = len(surface.points)
    while not holds(side):
        side += -(-side // 10)
    return side


def scipy_peer(surface: Surface) -> Cases:
    scattered = NdBSpline((surface.knots, surface.knots), surface.homogeneous, 3)

    def grid(u: Array, v: Array, du: int = 0, dv: int = 0) -> Array:
        rows = BSpline(surface.knots, surface.homogeneous, 3)(u, du)
        return np.asarray(
            BSpline(surface.knots, rows.transpose(1, 0, 2), 3)(v, dv).transpose(1, 0, 2)
        )

    def project(h: Array) -> Array:
        return np.asarray(h[..., :3] / h[..., 3:])

    def normals(u: Array, v: Array) -> tuple[Array, Array]:
        h, hu, hv = grid(u, v), grid(u, v, 1), grid(u, v, 0, 1)
        points = project(h)
        cross = np.cross(hu[..., :3] - points * hu[..., 3:], hv[..., :3] - points * hv[..., 3:])
        return points, cross / np.sqrt((cross * cross).sum(-1))[..., None]

    def interpolate(points: Array) -> Array:
        u, v = chord_parameters(points)

        def knots(t: Array) -> Array:
            inner = [t[j : j + 3].mean() for j in range(1, len(t) - 3)]
            return np.r_[np.zeros(4), inner, np.ones(4)]

        rows = make_interp_spline(u, points, 3, t=knots(u)).c
        return np.asarray(make_interp_spline(v, rows.transpose(1, 0, 2), 3, t=knots(v)).c)

    def triangles(tolerance: float) -> Triangles:
        t = np.linspace(0, 1, uniform_side(surface, tolerance))
        return uniform(project(grid(t, t)), t)

    return {
        "a": lambda u, v: project(grid(u, v)),
        "b": normals,
        "c": lambda uv: project(scattered(uv)),
        "d": triangles,
        "e": lambda points: interpolate(points).transpose(1, 0, 2),
    }


def splipy_peer(surface: Surface) -> Cases:
    import splipy

    basis = splipy.BSplineBasis(4, surface.knots)
    net = surface.homogeneous.transpose(1, 0, 2).reshape(-1, 4)
    spline = splipy.Surface(basis, basis, net, rational=True, raw=False)
    return {
        "a": lambda u, v: np.asarray(spline(u, v)),
        "b": lambda u, v: (np.asarray(spline(u, v)), np.asarray(spline.normal(u, v))),
    }


def geomdl_peer(surface: Surface) -> Cases:
    from geomdl import fitting, operations

    spline = neurbs.to_geomdl(neurbs_surface(surface))

    def normals(u: Array, v: Array) -> tuple[Array, Array]:
        both = np.array(operations.normal(spline, pairs(u, v).tolist()))
        return both[:, 0], both[:, 1]

    def interpolate(points: Array) -> Array:
        flat = points.reshape(-1, 3).tolist()
        result = fitting.interpolate_surface(flat, *points.shape[:2], 3, 3)
        return np.array(result.ctrlpts).reshape(points.shape)

    return {
        "a": lambda u, v: np.array(spline.evaluate_list(pairs(u, v).tolist())),
        "b": normals,
        "c": lambda uv: np.array(spline.evaluate_list(uv.tolist())),
        "e": interpolate,
    }


def splinepy_peer(surface: Surface) -> Cases:
    import splinepy

    flat = surface.points.transpose(1, 0, 2).reshape(-1, 3).copy()
    weights = surface.weights.T.reshape(-1, 1).copy()
    spline = splinepy.NURBS([3, 3], [surface.knots, surface.knots], flat, weights)

    def normals(u: Array, v: Array) -> tuple[Array, Array]:
        jacobian = spline.jacobian(pairs(u, v), nthreads=2)
        cross = np.cross(jacobian[..., 0], jacobian[..., 1])
        return spline.evaluate(pairs(u, v), nthreads=2), cross / np.linalg.norm(
            cross, axis=1, keepdims=True
        )

    return {
        # It samples evenly, with u fastest.
        "a": lambda u, v: (
            spline.sample([len(u), len(v)], nthreads=2)
            .reshape(len(v), len(u), 3)
            .transpose(1, 0, 2)
        ),
        "b": normals,
        "c": lambda uv: spline.evaluate(uv, nthreads=2),
        "f": lambda points: spline.proximities(points, nthreads=2),
    }


def opencascade_peer(surface: Surface) -> Cases:
    from OCP.BRep import BRep_Tool
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.collections import Array2_gp_Pnt
    from OCP.GeomAPI import GeomAPI_PointsToBSplineSurface
    from OCP.gp import gp_Pnt, gp_Vec
    from OCP.ShapeAnalysis import ShapeAnalysis_Surface
    from OCP.TopLoc import TopLoc_Location

    spline = neurbs.to_opencascade(neurbs_surface(surface))
    point, by_u, by_v = gp_Pnt(), gp_Vec(), gp_Vec()

    def points(uv: Array) -> Array:
        result = np.empty((len(uv), 3))
        for i, (u, v) in enumerate(uv.tolist()):
            spline.D0(u, v, point)
            result[i] = point.Coord()
        return result

    def normals(u: Array, v: Array) -> tuple[Array, Array]:
        uv = pairs(u, v)
        result = np.empty((3, len(uv), 3))
        for i, (u_, v_) in enumerate(uv.tolist()):
            spline.D1(u_, v_, point, by_u, by_v)
            result[:, i] = point.Coord(), by_u.Coord(), by_v.Coord()
        cross = np.cross(result[1], result[2])
        return result[0], cross / np.linalg.norm(cross, axis=1, keepdims=True)

    def triangles(tolerance: float) -> Triangles:
        face = BRepBuilderAPI_MakeFace(spline, 1e-6).Face()
        BRepMesh_IncrementalMesh(face, tolerance, False, 3.0, True)
        mesh = BRep_Tool.Triangulation_s(face, TopLoc_Location())
        nodes = range(1, mesh.NbNodes() + 1)
        corners = [mesh.Triangle(i).Get() for i in range(1, mesh.NbTriangles() + 1)]
        uv = np.array([mesh.UVNode(i).Coord() for i in nodes])
        return np.array([mesh.Node(i).Coord() for i in nodes]), np.array(corners) - 1, uv

    def interpolate(grid: Array) -> None:
        array = Array2_gp_Pnt(1, grid.shape[0], 1, grid.shape[1])
        for i, row in enumerate(grid.tolist()):
            for j, place in enumerate(row):
                array.SetValue(i + 1, j + 1, gp_Pnt(*place))
        GeomAPI_PointsToBSplineSurface().Interpolate(array, False)

    def closest(points: Array) -> Array:
        search = ShapeAnalysis_Surface(spline)
        feet = (search.ValueOfUV(gp_Pnt(*place), 1e-9) for place in points.tolist())
        return np.array([(foot.X(), foot.Y()) for foot in feet])

    return {
        "a": lambda u, v: points(pairs(u, v)),
        "b": normals,
        "c": points,
        "d": triangles,
        "e": interpolate,
        "f": closest,
    }


def neurbs_surface(surface: Surface) -> neurbs.NurbsSurface:
    knots = (surface.knots, surface.knots)
    return neurbs.NurbsSurface(surface.points, surface.weights, knots=knots)


def neurbs_peer(surface: Surface) -> Cases:
    spline = neurbs_surface(surface)

    def triangles(tolerance: float) -> Triangles:
        mesh = spline.tessellate(tolerance=tolerance)
        return mesh.vertices, mesh.triangles, mesh.uv

    return {
        "a": spline.evaluate_grid,
        "b": spline.normals_grid,
        "c": spline.evaluate,
        "d": triangles,
        "e": lambda points: neurbs.NurbsSurface.interpolate(points).control_points,
        "f": lambda points: spline.closest_points(points).uv,
    }


def neurbs_reusing(surface: Surface) -> Cases:
    spline = neurbs_surface(surface)
    grid, pair = np.empty((1000, 1000, 3)), (np.empty((500, 500, 3)), np.empty((500, 500, 3)))
    many = np.empty((1_000_000, 3))
    return {
        "a": lambda u, v: spline.evaluate_grid(u, v, out=fitting(grid, u, v)),
        "b": lambda u, v: spline.normals_grid(u, v, out=tuple(fitting(a, u, v) for a in pair)),
        "c": lambda uv: spline.evaluate(uv, out=many[: len(uv)]),
    }


def fitting(array: Array, u: Array, v: Array) -> Array:
    """Take the part of an array that a grid fills."""
    return array.reshape(-1, 3)[: len(u) * len(v)].reshape(len(u), len(v), 3)


def pairs(u: Array, v: Array) -> Array:
    """List all pairs of parameters, v fastest."""
    return np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2)


def deviation(surface: Surface, mesh: Triangles) -> float:
    """Measure the largest distance from 15 places of each triangle to the surface."""
    vertices, triangles, uv = mesh
    steps = [(i, j, 4 - i - j) for i in range(5) for j in range(5 - i)]
    shares = np.array(steps) / 4
    places = np.einsum("kb,tbc->tkc", shares, vertices[triangles]).reshape(-1, 3)
    starts = np.einsum("kb,tbc->tkc", shares, uv[triangles]).reshape(-1, 2)
    # At equal parameters the distance is an upper bound: only the worst need their feet.
    bounds = np.linalg.norm(surface.derivatives(starts, 0)[0, 0] - places, axis=1)
    worst = np.argsort(-bounds)[:20_000]
    feet = surface.derivatives(surface.closest(places[worst], starts[worst]), 0)[0, 0]
    return float(np.linalg.norm(feet - places[worst], axis=1).max())


PEERS: dict[str, Callable[[Surface], Cases]] = {
    "neurbs": neurbs_peer,
    "neurbs, out=": neurbs_reusing,
    "scipy": scipy_peer,
    "splipy": splipy_peer,
    "numpy": numpy_peer,
    "splinepy, 2 threads": splinepy_peer,
    "opencascade": opencascade_peer,
    "geomdl": geomdl_peer,
}
