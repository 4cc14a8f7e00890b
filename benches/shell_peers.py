"""Compare the tessellation of a shell of 100 faces with OpenCASCADE's.

    pip install '.[cad]'
    python benches/shell_peers.py

A wavy torus is split into 10 × 10 faces and written as STEP. Both read that file and mesh it at a
thousandth of its diagonal. The table has the milliseconds of the mesh alone (the fastest of several
runs) on one thread and on all, the triangles, and the largest distance of samples of the triangles
from the faces. OpenCASCADE uses one thread unless it is asked for more.
"""

import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

import neurbs

SIDE, RUNS = 10, 20


def shell() -> neurbs.Shell:
    """Return a closed shell of SIDE × SIDE faces."""
    angles = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    u, v = np.meshgrid(angles, angles, indexing="ij")
    small = 1 + 0.2 * np.sin(3 * u) * np.cos(2 * v)
    ring = 3 + small * np.cos(v)
    points = np.stack([ring * np.cos(u), ring * np.sin(u), small * np.sin(v)], axis=-1)
    whole = neurbs.NurbsSurface(points, closed=True)
    (u0, u1), (v0, v1) = whole.domain
    cuts_u, cuts_v = np.linspace(u0, u1, SIDE + 1), np.linspace(v0, v1, SIDE + 1)
    return neurbs.Shell(
        [
            whole.sub_surface(u=(cuts_u[i], cuts_u[i + 1]), v=(cuts_v[j], cuts_v[j + 1]))
            for i in range(SIDE)
            for j in range(SIDE)
        ]
    )


def fastest(call: Callable[[], object]) -> float:
    """Return the least seconds of some runs."""
    seconds = []
    for _ in range(RUNS):
        start = time.perf_counter()
        call()
        seconds.append(time.perf_counter() - start)
    return min(seconds)


def opencascade(path: Path, tolerance: float) -> tuple[list[float], NDArray[np.float64]]:
    """Return the seconds of BRepMesh on one and on all threads, and its triangles' corners."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.BRepTools import BRepTools
    from OCP.STEPControl import STEPControl_Reader
    from OCP.TopAbs import TopAbs_FACE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS

    reader = STEPControl_Reader()
    reader.ReadFile(str(path))
    reader.TransferRoots()
    shape = reader.OneShape()

    def mesh(parallel: bool) -> None:
        BRepTools.Clean_s(shape)
        # Not relative, and an angle that never limits.
        BRepMesh_IncrementalMesh(shape, tolerance, False, 3.0, parallel)

    seconds = [fastest(partial(mesh, parallel)) for parallel in (False, True)]
    corners = []
    faces = TopExp_Explorer(shape, TopAbs_FACE)
    while faces.More():
        triangles = BRep_Tool.Triangulation_s(TopoDS.Face(faces.Current()), TopLoc_Location())
        nodes = [triangles.Node(k + 1) for k in range(triangles.NbNodes())]
        places = np.array([(node.X(), node.Y(), node.Z()) for node in nodes])
        ids = [triangles.Triangle(k + 1).Get() for k in range(triangles.NbTriangles())]
        corners.append(places[np.array(ids) - 1])
        faces.Next()
    return seconds, np.concatenate(corners)


def deviation(shell: neurbs.Shell, corners: NDArray[np.float64]) -> float:
    """Return the largest distance of samples of the triangles from the shell."""
    weights = np.concatenate([[[1, 1, 1]], 3 * np.eye(3) + 1, 1 - np.eye(3)])
    weights = weights / weights.sum(axis=1, keepdims=True)
    samples = np.einsum("sk,tkd->std", weights, corners).reshape(-1, 3)
    return float(shell.closest_points(samples).distances.max())


def main() -> None:
    """Print the table."""
    with TemporaryDirectory() as folder:
        path = Path(folder, "shell.step")
        neurbs.save(shell(), path)
        ours = neurbs.load_shell(path)
        low, high = ours.bounding_box()
        tolerance = 1e-3 * float(np.linalg.norm(high - low))
        seconds = []
        for threads in (1, neurbs.num_threads()):
            neurbs.set_num_threads(threads)
            seconds.append(fastest(lambda: ours.tessellate(tolerance)))
        mesh = ours.tessellate(tolerance)
        their_seconds, their_corners = opencascade(path, tolerance)
    print(f"{len(ours.faces)} faces, closed: {ours.is_closed}, tolerance {tolerance:.4g}")
    print(f"{'':12} {'1 thread':>9} {'all':>7} {'triangles':>10} {'deviation / tolerance':>22}")
    corners = mesh.vertices[mesh.triangles]
    for name, times, triangles in (
        ("neurbs", seconds, corners),
        ("OpenCASCADE", their_seconds, their_corners),
    ):
        share = deviation(ours, triangles) / tolerance
        one, every = (1e3 * t for t in times)
        print(f"{name:12} {one:9.2f} {every:7.2f} {len(triangles):10,} {share:22.3f}")
    one, every = (theirs / own for theirs, own in zip(their_seconds, seconds, strict=True))
    print(f"ratio        {one:9.1f} {every:7.1f}")


if __name__ == "__main__":
    main()
