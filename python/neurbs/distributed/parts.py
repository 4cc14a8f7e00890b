"""The parts of a cloud: files or blocks of arrays, each read by one task in chunks."""

from __future__ import annotations

import os
import tempfile
import warnings
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from neurbs import _core, io
from neurbs.diagnostics import CATEGORIES
from neurbs.errors import argument_error
from neurbs.extras import is_dask_array
from neurbs.io.point_files import PointFiles, ReadFile
from neurbs.io.point_readers import point_files, warn_dropped
from neurbs.io.units import check_unit
from neurbs.reconstruction_chunks import CHUNK, slices


@dataclass(frozen=True)
class Reading:
    """The options for reading parts, which go to the workers.

    Attributes
    ----------
    options : dict of str to object
        Keyword arguments of `neurbs.read_points` for files.
    skip : bool
        Whether a part that cannot be read is skipped.
    reference : bool
        Whether the units of files are read, which takes some milliseconds for each.
    """

    options: dict[str, Any] = field(default_factory=dict)
    skip: bool = False
    reference: bool = True


@dataclass(frozen=True, eq=False)
class Parts:
    """The parts of a cloud, in order.

    Attributes
    ----------
    names : list of str
        Their names, for errors.
    sources : list
        Paths, or delayed arrays of shape (n, 3) or (n, 2).
    reading : Reading
        The options.
    largest : int or None
        Most points of a block of an array that is in memory as a whole; None for files.
    folder : TemporaryDirectory or None
        Where the chunks of an iterator are, which live as long as the parts.
    """

    names: list[str]
    sources: list[Any]
    reading: Reading
    largest: int | None = None
    folder: tempfile.TemporaryDirectory[str] | None = None

    def __len__(self) -> int:
        """Return the number of parts."""
        return len(self.names)

    def without(self, skipped: set[int]) -> Parts:
        """Return the parts without those that cannot be read, after all have been read once.

        From now on all must be readable, and their units are known.
        """
        kept = [number for number in range(len(self)) if number not in skipped]
        names, sources = [[of[number] for number in kept] for of in (self.names, self.sources)]
        reading = replace(self.reading, skip=False, reference=False)
        return Parts(names, sources, reading, self.largest, self.folder)


def parts_of(
    points: Any,
    *,
    columns: Sequence[str | int] | None = None,
    nan: Literal["error", "drop"] = "error",
    unit: str | None = None,
    bounds: ArrayLike | None = None,
    cell: float | None = None,
    las_classes: Sequence[int] | None = None,
    errors: Literal["raise", "skip"] = "raise",
) -> Parts:
    """Return the parts of a dask array, of files, or of an iterator of chunks.

    Raises
    ------
    NeurbsError
        If the points are none of these, or an option is out of its range.
    """
    if errors not in ("raise", "skip"):
        raise argument_error("errors", f"must be 'raise' or 'skip', got {errors!r}")
    check_unit(unit)
    given = {
        "columns": columns,
        "nan": None if nan == "error" else nan,
        "bounds": bounds,
        "cell": cell,
        "las_classes": las_classes,
    }
    options = {name: value for name, value in given.items() if value is not None}
    # Other points have no unit that could be converted.
    reading = Reading(options if unit is None else {**options, "unit": unit}, errors == "skip")
    if is_dask_array(points):
        _refuse(options)
        return _of_array(points, reading)
    if isinstance(points, str | os.PathLike):
        return _of_files([points], reading)
    if isinstance(points, Sequence) and all(isinstance(p, str | os.PathLike) for p in points):
        return _of_files(points, reading)
    if isinstance(points, Iterator):
        _refuse(options)
        return _spooled(points, reading)
    raise argument_error(
        "points",
        "must be a dask array, a list of files or an iterator of chunks, "
        f"got {type(points).__name__}: `neurbs.reconstruct` takes arrays",
    )


@dataclass(frozen=True)
class Notes:
    """What the readers of files found beside the points.

    Attributes
    ----------
    units : dict of str to str
        For each unit of files the first of them.
    not_finite : int
        Points that were dropped because they are not finite.
    doubts : dict of str to (str, int)
        For each code of a warning the first message, and the number of messages.
    """

    units: dict[str, str] = field(default_factory=dict)
    not_finite: int = 0
    doubts: dict[str, tuple[str, int]] = field(default_factory=dict)

    @classmethod
    def of(cls, file: ReadFile) -> Notes:
        """Return what was found in a file that has been read."""
        found = file.source
        counts = Counter(doubt.code for doubt in found.doubts)
        first = {doubt.code: doubt.message for doubt in reversed(found.doubts)}
        return cls(
            {} if found.unit is None else {found.unit: file.name},
            file.not_finite,
            {code: (f"{file.name}: {first[code]}", counts[code]) for code in counts},
        )

    def __add__(self, other: Notes) -> Notes:
        """Return the notes about the files of both."""
        doubts = dict(self.doubts)
        for code, (message, count) in other.doubts.items():
            first, before = doubts.get(code, (message, 0))
            doubts[code] = (first, before + count)
        return Notes(other.units | self.units, self.not_finite + other.not_finite, doubts)

    def unit(self) -> str | None:
        """Return the unit of all files.

        Raises
        ------
        NeurbsError
            If there are several.
        """
        if len(self.units) > 1:
            (one, first), (other, second), *_ = self.units.items()
            raise _core.NeurbsError(
                f"files must have one unit, got {one!r} in {first} and {other!r} in {second}: "
                "give `unit`, to which they are converted"
            )
        return next(iter(self.units), None)

    def warn(self, points: int, *, stacklevel: int) -> None:
        """Issue a warning for each code; `stacklevel` is relative to the caller."""
        for code, (message, count) in self.doubts.items():
            others = f" ({count - 1} more of this kind)" if count > 1 else ""
            warnings.warn(message + others, CATEGORIES[code], stacklevel=stacklevel + 1)
        warn_dropped("points", self.not_finite, points, stacklevel=stacklevel + 2)


class OpenPart:
    """A part that a task reads.

    Attributes
    ----------
    chunks : iterator of ndarray
        The points in chunks, once.
    """

    def __init__(self, source: Any, reading: Reading) -> None:
        self._files: PointFiles | None = None
        if isinstance(source, str):
            self._files = point_files(source, reference=reading.reference, **reading.options)
            self.chunks = self._files.chunks(CHUNK)
        else:
            self.chunks = (_core.as_points(source[part]) for part in slices(source))

    def notes(self) -> Notes:
        """Return what was found in the file, if it is one, beside the points read up to now."""
        files = self._files.read if self._files is not None else []
        return sum(map(Notes.of, files), Notes())


def no_points(skipped: dict[str, str], parts: Parts) -> _core.NeurbsError:
    """Return the error for parts without points, of which some may have been skipped."""
    why = next(iter(skipped.values()), "the parts are empty")
    if not skipped and {"bounds", "las_classes"} & parts.reading.options.keys():
        why = "bounds and las_classes leave none"
    return _core.NeurbsError(f"points must be at least one, got none: {why}")


def _refuse(options: dict[str, Any]) -> None:
    for name in options:
        raise argument_error(name, "must be left out, unless the points are files")


def _of_array(points: Any, reading: Reading) -> Parts:
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise argument_error(
            "points", f"must be of shape (n, 3) or (n, 2), got a dask array of {points.shape}"
        )
    blocks = points.rechunk({1: -1}) if points.numblocks[1] > 1 else points
    sources = list(blocks.to_delayed().ravel())
    names = [f"block {number} of the array" for number in range(len(sources))]
    sizes = [size for size in blocks.chunks[0] if size == size]  # Unknown sizes are NaN.
    return Parts(names, sources, reading, max(sizes, default=CHUNK))


def _of_files(files: Sequence[str | os.PathLike[str]], reading: Reading) -> Parts:
    paths = [os.path.abspath(file) for file in files]
    if not paths:
        raise argument_error("points", "must be at least one file, got none")
    for path in paths:
        io.check_source(path)
    return Parts(paths, list(paths), reading)


def _spooled(chunks: Iterable[ArrayLike], reading: Reading) -> Parts:
    """Write the chunks of an iterator to files, as each task needs its own several times."""
    folder = tempfile.TemporaryDirectory(prefix="neurbs-")
    paths = []
    for number, chunk in enumerate(chunks):
        path = str(Path(folder.name, f"{number:06}.npy"))
        np.save(path, _core.as_points(chunk))
        paths.append(path)
    if not paths:
        raise argument_error("points", "must have at least one chunk, got none")
    return Parts(
        [f"chunk {number}" for number in range(len(paths))], list(paths), reading, None, folder
    )
