"""The NURBS kernel beside its peers, on the same work, in one run.

    python benches/nurbs_peers.py                      # all cases, 20 × 20 net
    python benches/nurbs_peers.py --case a b --net 100
    python benches/nurbs_peers.py --peer neurbs scipy

The surface is bicubic and rational, over a net of 20 × 20 with weights from 0.5 to 2.

 a  points on a 1000 × 1000 grid           b  points and unit normals, 500 × 500
 c  points at 1,000,000 random (u, v)      d  triangles within 1e-3 of the size
 e  interpolation of a 100 × 100 grid      f  closest points of 10,000 points at up to 1 % of the
                                              size from the surface

Each figure is the best of several runs, alternating between peers, so that what else the machine
does hits all alike; preparations that a user makes once for a surface are not counted. Every result
is compared with plain NumPy's before it is timed: the largest error as a share of the size, in case
d the largest distance between triangles and surface as a share of the tolerance. A peer that is not
installed, or has not got what a case needs, is left out and named. What would take a peer longer
than `--budget` seconds is done on a part of the work, and its time multiplied (marked ~).

The extra `test` installs SciPy, geomdl, Splipy and OpenCASCADE; splinepy is timed where it is
installed.
"""

import argparse
import functools
import math
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
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

TITLES = {
    "a": "points, 1000 × 1000 grid",
    "b": "points and normals, 500 × 500 grid",
    "c": "points, 1,000,000 random (u, v)",
    "d": "triangles within 1e-3 of the size",
    "e": "interpolation, 100 × 100 points",
    "f": "closest points of 10,000 points",
}


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


def work(case: str, surface: Surface) -> tuple[Any, ...]:
    """Make the arguments of a case."""
    rng = np.random.default_rng(3)
    if case in "ab":
        t = np.linspace(0, 1, 1000 if case == "a" else 500)
        return t, t
    if case == "c":
        return (rng.random((1_000_000, 2)),)
    if case == "d":
        return (1e-3 * surface.size,)
    if case == "e":
        s = np.linspace(0, 10, 100)
        x, y = np.meshgrid(s, s, indexing="ij")
        z = np.sin(1.3 * x) * np.cos(1.1 * y)
        return (np.stack([x + 0.1 * np.sin(y), y + 0.1 * np.cos(x), z], axis=-1),)
    uv = rng.uniform(0.03, 0.97, (10_000, 2))
    d = surface.derivatives(uv, 1)
    normals = np.cross(d[1, 0], d[0, 1])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return (d[0, 0] + rng.uniform(-0.01, 0.01, (10_000, 1)) * surface.size * normals,)


def error(case: str, surface: Surface, result: Any, arguments: tuple[Any, ...]) -> float:
    """Measure the largest difference from plain NumPy's answer, as a share of the size."""
    if case in "abc":
        points = np.asarray(result[0] if case == "b" else result).reshape(-1, 3)
        chosen = np.random.default_rng(0).integers(0, len(points), 2000)
        if case == "c":
            uv = arguments[0][chosen]
        else:
            u, v = arguments
            uv = np.column_stack([u[chosen // len(v)], v[chosen % len(v)]])
        exact = surface.derivatives(uv, 1)
        wrong = np.abs(points[chosen] - exact[0, 0]).max() / surface.size
        if case == "b":
            normals = np.cross(exact[1, 0], exact[0, 1])
            normals /= np.linalg.norm(normals, axis=1)[:, None]
            wrong = max(wrong, np.abs(np.asarray(result[1]).reshape(-1, 3)[chosen] - normals).max())
        return float(wrong)
    if case == "d":
        return deviation(surface, result) / float(arguments[0])
    if case == "e":
        if result is None:
            return math.nan
        return float(np.abs(result - scipy_peer(surface)["e"](*arguments)).max() / 10)
    feet = surface.derivatives(np.asarray(result), 0)[0, 0]
    distances = np.linalg.norm(feet - arguments[0], axis=1)
    start = numpy_peer(surface)["f"](*arguments)
    best = np.linalg.norm(surface.derivatives(start, 0)[0, 0] - arguments[0], axis=1)
    return float((distances - best).max() / surface.size)


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


def smaller(case: str, arguments: tuple[Any, ...]) -> tuple[tuple[Any, ...], float]:
    """Take a hundredth of a case's work, and say how many times smaller it is."""
    if case in "ab":
        u, v = (np.linspace(t[0], t[-1], len(t) // 10) for t in arguments)
        return (u, v), arguments[0].size * arguments[1].size / (u.size * v.size)
    if case in "cf":
        return (arguments[0][::100],), 100.0
    return arguments, 1.0


def clock(f: Callable[..., Any], arguments: tuple[Any, ...]) -> float:
    start = time.perf_counter()
    f(*arguments)
    return time.perf_counter() - start


def floor(shape: tuple[int, ...]) -> float:
    """Time the filling of an array on two threads: what to write a result takes at least."""
    halves = np.array_split(np.empty(shape).reshape(-1), 2)
    with ThreadPoolExecutor(2) as pool:
        fill = functools.partial(pool.map, lambda half: half.fill(1.0), halves)
        return min(clock(lambda: list(fill()), ()) for _ in range(100))


def run(case: str, surface: Surface, peers: dict[str, Cases], repeat: int, budget: float) -> None:
    """Time a case and print its table."""
    whole = work(case, surface)
    part, times = smaller(case, whole)
    chosen, errors, notes = {}, {}, {}
    for name, cases in peers.items():
        if case not in cases:
            continue
        try:
            f = cases[case]
            # The first call also loads and prepares.
            slow = min(clock(f, part), clock(f, part)) * times > budget
            chosen[name] = (f, part if slow else whole, times if slow else 1.0)
            result = f(*chosen[name][1])
        except TypeError as missing:
            print(f"{name} is left out of {case}: {missing}")
            chosen.pop(name, None)
            continue
        errors[name] = error(case, surface, result, chosen[name][1])
        notes[name] = f"{len(result[1]):,} triangles" if case == "d" else ""
    best = dict.fromkeys(chosen, math.inf)
    for _ in range(repeat):
        for name, (f, arguments, factor) in chosen.items():
            best[name] = min(best[name], factor * clock(f, arguments))
    own = best.get("neurbs", math.nan)
    net = len(surface.points)
    print(f"\n{case}: {TITLES[case]}, net {net} × {net}\n")
    print("| peer | ms | times neurbs | largest error | |\n|---|---:|---:|---:|---|")
    for name in sorted(best, key=best.__getitem__):
        about = "~" if chosen[name][2] > 1 else ""
        row = f"{about}{best[name] * 1e3:.3g} | {best[name] / own:.1f} | {errors[name]:.1e}"
        print(f"| {name} | {row} | {notes[name]} |")
    if case == "a":
        shape = (len(whole[0]), len(whole[1]), 3)
        print(f"\nfilling {np.prod(shape) * 8 / 1e6:.0f} MB: {floor(shape) * 1e3:.2f} ms")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--case", nargs="*", default=list(TITLES), choices=list(TITLES))
    parser.add_argument("--peer", nargs="*", default=list(PEERS))
    parser.add_argument("--net", type=int, default=20)
    parser.add_argument("--repeat", type=int, default=9)
    parser.add_argument("--budget", type=float, default=3.0, help="seconds, else a part is timed")
    options = parser.parse_args()
    surface = Surface(options.net)
    peers: dict[str, Cases] = {}
    for name in options.peer:
        try:
            peers[name] = PEERS[name](surface)
        except ImportError as missing:
            print(f"{name} is left out: {missing}")
    for case in options.case:
        run(case, surface, peers, options.repeat, options.budget)


if __name__ == "__main__":
    main()
