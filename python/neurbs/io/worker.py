"""The process that reads files with libraries which a damaged file can crash or hang.

`neurbs.io.isolation` starts it as ``python -m neurbs.io.worker``. A request is a line of JSON on
standard input. An answer is a sequence of frames on standard output: a line of JSON each, then the
bytes of its arrays. The process ends when standard input does.
"""

from __future__ import annotations

import importlib
import json
import os
import signal
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.extras import require_for_file
from neurbs.io.face_frames import frames
from neurbs.io.point_cloud import Request
from neurbs.io.reading import reading

READERS = {
    ".step": ("OCP", "neurbs.io.cad", "read_cad"),
    ".stp": ("OCP", "neurbs.io.cad", "read_cad"),
    ".igs": ("OCP", "neurbs.io.cad", "read_cad"),
    ".iges": ("OCP", "neurbs.io.cad", "read_cad"),
    ".3dm": ("rhino3dm", "neurbs.io.rhino", "read_3dm"),
    ".vtk": ("vtkmodules", "neurbs.io.vtk", "read_vtk"),
    ".vtp": ("vtkmodules", "neurbs.io.vtk", "read_vtk"),
    ".vtu": ("vtkmodules", "neurbs.io.vtk", "read_vtk"),
    ".vti": ("vtkmodules", "neurbs.io.vtk", "read_vtk"),
    ".vts": ("vtkmodules", "neurbs.io.vtk", "read_vtk"),
    ".vtr": ("vtkmodules", "neurbs.io.vtk", "read_vtk"),
    ".gltf": ("trimesh", "neurbs.io.mesh_vertices", "read_vertices"),
    ".dae": ("collada", "neurbs.io.mesh_vertices", "read_vertices"),
    ".3mf": ("lxml", "neurbs.io.mesh_vertices", "read_vertices"),
    ".las": ("laspy", "neurbs.io.las", "read_las"),
    ".laz": ("laspy", "neurbs.io.las", "read_las"),
}
"""By suffix: the library, and module and name of the function that reads with it."""

FOR_REFERENCE = {".las": "pyproj", ".laz": "pyproj"}
"""By suffix: another library, with which the reference system is read."""

MEMORY = 1 << 30
"""Bytes that reading may take, for a small file."""

MEMORY_PER_BYTE = 64
"""Bytes of memory that reading may take for each byte of the file."""

SECONDS = 6
"""Seconds of processor time that reading may take, for a small file."""

BYTES_PER_SECOND = 100_000
"""Bytes of a file for which one more second of processor time is granted."""

WALL_SECONDS = 7
"""Seconds of wall time that reading may take, for a small file."""

BYTES_PER_WALL_SECOND = 20_000
"""Bytes of a file for which one more second of wall time is granted."""

_HAS_TIMER = hasattr(signal, "setitimer")


def main() -> None:
    """Answer requests until there are no more."""
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb", buffering=0)
    # The libraries print what they think of a file.
    with open(os.devnull, "wb") as nowhere:
        os.dup2(nowhere.fileno(), 1)
        os.dup2(nowhere.fileno(), 2)
    warnings.simplefilter("ignore")
    if _HAS_TIMER:
        # The process that starts this one may ignore or block the signal of the timer.
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGALRM})
    for line in sys.stdin.buffer:
        _answer(json.loads(line), answers)
        _set_timer(0)


def _answer(request: dict[str, Any], answers: BinaryIO) -> None:
    try:
        if request["folder"]:
            os.chdir(request["folder"])
        path = Path(request["path"])
        with reading(path):
            read = reader(path)
            _limit(path.stat().st_size)
            if request["what"] == "faces":
                for head, arrays in frames(read(path)):
                    _send(answers, head, arrays)
            else:
                columns = request["columns"]
                classes = request["las_classes"]
                asked = Request(
                    columns and tuple(columns),
                    request["nan"],
                    request["attributes"],
                    las_classes=None if classes is None else tuple(classes),
                    reference=request["reference"],
                )
                _send_points(read(path, asked), answers)
        _send(answers, {"end": True})
    except MemoryError:
        _send(answers, {"error": "MemoryError"})
    except OSError as error:
        _send(answers, {"error": "OSError", "errno": error.errno})
    except (NeurbsError, ImportError) as error:
        _send(answers, {"error": type(error).__name__, "message": str(error)})


def reader(path: Path) -> Callable[..., Any]:
    """Return the function that reads a file, with its library imported."""
    library, module, name = READERS[path.suffix.lower()]
    require_for_file(path, library)
    read: Callable[..., Any] = getattr(importlib.import_module(module), name)
    return read


def _limit(size: int) -> None:
    """Bound memory and time for reading a file of so many bytes, where the system can."""
    _set_timer(WALL_SECONDS + size / BYTES_PER_WALL_SECOND)
    with suppress(ImportError, OSError, ValueError):
        import resource

        def lower(which: int, bound: int) -> None:
            hard = resource.getrlimit(which)[1]
            if hard != resource.RLIM_INFINITY:
                bound = min(bound, hard)
            resource.setrlimit(which, (bound, hard))

        resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))
        spent = int(sum(os.times()[:2])) + 1
        lower(resource.RLIMIT_CPU, spent + SECONDS + size // BYTES_PER_SECOND)
        status = Path("/proc/self/status").read_text()
        taken = int(status.partition("VmData:")[2].split()[0]) * 1024
        lower(resource.RLIMIT_DATA, taken + MEMORY + MEMORY_PER_BYTE * size)


def _set_timer(seconds: float) -> float:
    """End this process after some seconds, or never for 0; return the seconds that were left."""
    return signal.setitimer(signal.ITIMER_REAL, seconds)[0] if _HAS_TIMER else 0


@contextmanager
def _timer_stopped() -> Iterator[None]:
    """Do not count the time in which the other process does something else."""
    left = _set_timer(0)
    try:
        yield
    finally:
        _set_timer(left)


def _send_points(source: Any, answers: BinaryIO) -> None:
    names = ("count", "unit", "crs", "offset")
    doubts = [(doubt.code, doubt.message) for doubt in source.doubts]
    _send(answers, {**{name: getattr(source, name) for name in names}, "doubts": doubts})
    for block in source.blocks:
        arrays = (block.points, block.normals, block.colors)
        _send(answers, {"dropped": block.dropped, "left_out": block.left_out}, arrays)


def _send(
    answers: BinaryIO, head: dict[str, Any], arrays: Sequence[NDArray[Any] | None] = ()
) -> None:
    whole = [None if array is None else np.ascontiguousarray(array) for array in arrays]
    head["arrays"] = [None if array is None else [array.dtype.str, array.shape] for array in whole]
    with _timer_stopped():
        _write(answers, json.dumps(head).encode() + b"\n")
        for array in whole:
            if array is not None:
                _write(answers, array.reshape(-1).view(np.uint8))


def _write(answers: BinaryIO, data: Any) -> None:
    left = memoryview(data)
    while left:
        left = left[answers.write(left) :]


if __name__ == "__main__":
    main()
