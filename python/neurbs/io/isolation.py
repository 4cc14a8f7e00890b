"""Reading in a worker process, so that a damaged file cannot end or block this process."""

from __future__ import annotations

import atexit
import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from io import BufferedReader
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.extras import check_installed
from neurbs.io.face_file import FaceFile
from neurbs.io.face_frames import face_of, file_of
from neurbs.io.point_cloud import Block, Doubt, PointSource, Request
from neurbs.io.reading import damaged
from neurbs.io.worker import FOR_REFERENCE, MEMORY, MEMORY_PER_BYTE, READERS, reader

_KEPT = 2
"""Idle workers that are kept."""

_PIPE = 1 << 20
"""Bytes that a worker can be ahead, where the system allows it."""

_LIMITS = [getattr(signal, name, None) for name in ("SIGXCPU", "SIGALRM")]
"""Signals that end a worker which takes too much time."""

_idle: list[_Worker] = []
"""Workers of this process that wait for a file."""


def read_faces(path: Path) -> FaceFile:
    """Read a file of faces in a worker.

    Raises
    ------
    NeurbsError
        If the library is not installed, or the file is damaged, crashes the library, or takes too
        much time or memory.
    """
    if not _can_start():
        file: FaceFile = reader(path)(path)
        return file
    frames = _frames(path, {"what": "faces"})
    head, _ = next(frames)
    faces = [face_of(part, arrays) for part, arrays in frames]
    if len(faces) != head["count"]:
        raise damaged(path, "its reader ended early")
    return file_of(head, faces)


def read_points(path: Path, request: Request) -> PointSource:
    """Read a file of points in a worker; the same errors as for `read_faces`."""
    if not _can_start():
        source: PointSource = reader(path)(path, request)
        return source
    what = {
        "what": "points",
        "columns": request.columns,
        "las_classes": request.las_classes,
        "nan": request.nan,
        "attributes": request.attributes,
        "reference": request.needs_reference,
    }
    frames = _frames(path, what)
    head, _ = next(frames)
    blocks = (
        Block(points, normals, colors, part["dropped"], left_out=part["left_out"])
        for part, (points, normals, colors) in frames
    )
    offset = head["offset"] and tuple(head["offset"])
    doubts = [Doubt(*doubt) for doubt in head["doubts"]]
    return PointSource(blocks, head["count"], head["unit"], head["crs"], offset, doubts)


def _can_start() -> bool:
    """Whether `sys.executable` is Python: in a frozen program it is the program itself."""
    return bool(sys.executable) and not getattr(sys, "frozen", False)


Frame = tuple[dict[str, Any], list[Any]]


def _frames(path: Path, request: dict[str, Any]) -> Iterator[Frame]:
    """Ask a worker, and give its frames until the last.

    A worker is killed if its answer is not read to the end, for instance after Ctrl-C.
    """
    suffix = path.suffix.lower()
    check_installed(path, READERS[suffix][0])
    if suffix in FOR_REFERENCE and request.get("reference"):
        check_installed(path, FOR_REFERENCE[suffix])
    worker = _Worker.idle()
    finished = False
    try:
        folder = None if path.is_absolute() else os.getcwd()
        worker.ask({**request, "path": os.fspath(path), "folder": folder})
        while True:
            frame = worker.frame()
            if frame is None:
                raise damaged(path, worker.end())
            head, _ = frame
            if "error" in head or "end" in head:
                finished = True
                if "error" in head:
                    raise _error(path, head)
                return
            yield frame
    finally:
        worker.release(reusable=finished)


def _error(path: Path, head: dict[str, Any]) -> Exception:
    match head["error"]:
        case "NeurbsError":
            return NeurbsError(head["message"])
        case "OSError":
            return OSError(head["errno"], os.strerror(head["errno"]), str(path))
        case "MemoryError":
            size = MEMORY + MEMORY_PER_BYTE * path.stat().st_size
            return damaged(path, f"to read it takes more than {size // 10**6} MB")
    return ImportError(head["message"])


class _Worker:
    """A process that reads."""

    def __init__(self) -> None:
        self._owner = os.getpid()
        # The worker finds what this process finds. Its own folder is not searched for modules.
        search = os.pathsep.join(place for place in sys.path if place)
        self._process = subprocess.Popen(
            [sys.executable, "-m", "neurbs.io.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": search, "PYTHONSAFEPATH": "1"},
            cwd=Path(__file__).parents[2],
            # Ctrl-C is for this process, which then kills the worker.
            start_new_session=True,
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._requests = self._process.stdin
        self._answers = cast(BufferedReader, self._process.stdout)
        with suppress(ImportError, AttributeError, OSError):
            import fcntl

            fcntl.fcntl(self._answers, fcntl.F_SETPIPE_SZ, _PIPE)

    @classmethod
    def idle(cls) -> _Worker:
        """Return a worker that waits, a new one if there is none."""
        while _idle:
            with suppress(IndexError):  # Another thread may have taken the last.
                worker = _idle.pop()
                if worker._process.poll() is None:
                    return worker
                worker.kill()
        return cls()

    def ask(self, request: dict[str, Any]) -> None:
        """Send a request."""
        with suppress(BrokenPipeError):  # A missing answer shows that it has ended.
            self._requests.write(json.dumps(request).encode() + b"\n")
            self._requests.flush()

    def frame(self) -> Frame | None:
        """Return the next frame; None if the worker has ended."""
        line = self._answers.readline()
        if not line.endswith(b"\n"):
            return None
        head = json.loads(line)
        arrays: list[NDArray[Any] | None] = []
        for described in head["arrays"]:
            if described is None:
                arrays.append(None)
                continue
            array = np.empty(tuple(described[1]), described[0])
            if self._answers.readinto(array.reshape(-1).view(np.uint8).data) < array.nbytes:
                return None
            arrays.append(array)
        return head, arrays

    def end(self) -> str:
        """Say how a worker has ended."""
        status = self._process.wait()
        if -status in _LIMITS:
            return "its reader did not come to an end"
        return f"its reader ended with status {status}"

    def release(self, *, reusable: bool) -> None:
        """Keep the worker for another file, or end it."""
        if reusable and len(_idle) < _KEPT:
            _idle.append(self)
        else:
            self.kill()

    def kill(self) -> None:
        """End the worker at once, if it is one of this process and not of its parent."""
        if self._owner == os.getpid():
            self._process.kill()
            self._process.wait()
        self.forget()

    def forget(self) -> None:
        """Close this process's ends of the pipes."""
        for pipe in (self._requests, self._answers):
            with suppress(OSError):
                pipe.close()


@atexit.register
def _end_all() -> None:
    while _idle:
        _idle.pop().kill()


def _forget_all() -> None:
    """After a fork: the workers belong to the parent."""
    while _idle:
        _idle.pop().forget()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_all)
