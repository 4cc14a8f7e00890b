"""Free-form surfaces with trims in Wavefront OBJ files.

The statements are those of the format's specification (Advanced Visualizer, appendix B1): `v` and
`vp`, then `cstype bspline`, `deg`, `surf` and `curv2` with `parm`, `trim`, `hole` and `end`.
"""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from neurbs._core import NeurbsError, NurbsCurve, NurbsSurface
from neurbs.io import loop_curves
from neurbs.io.face_file import FaceData, FaceFile, label
from neurbs.io.reading import cause, read_whole

_MAX_BYTES = 1 << 29
"""Most bytes of a file, which is read as a whole."""

_WHOLE = 1e-9
"""Share of a curve's domain by which a trim may differ from it."""

_OTHERS = {"f": "polygon", "l": "polyline", "p": "point", "curv": "curve"}
"""Elements that are not faces."""

_BEFORE_SURFACES = ("o", "g", "v", "vp", "cstype", "deg", "curv2")
"""Statements for the elements that follow."""

_COUNT = re.compile(r"# (\d+) surfaces?\s")
"""A comment in the first line, with which a file that is cut between two surfaces is found."""

_NO_GROUP = "default"
"""The group of elements that are in no other."""


def read_obj(path: Path) -> FaceFile:
    """Read all free-form surfaces of a file."""
    text = read_whole(path, _MAX_BYTES).decode("utf-8", errors="replace")
    reader = _Reader(path)
    for number, words in _statements(text):
        reader.read(number, words)
    reader.check_end()
    count = _COUNT.match(text)
    found = len(reader.faces) + len(reader.left_out)
    if count is not None and int(count[1]) != found:
        raise NeurbsError(
            f"{path}: must have {count[1]} surfaces, as in its first line, but has {found}: "
            "it may be cut short"
        )
    return FaceFile(reader.faces, None, reader.left_out, reader.others)


def _statements(text: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the words of each statement with the number of its line."""
    pending: list[str] = []
    for number, line in enumerate(text.split("\n"), 1):
        words = line.split("#")[0].rstrip()
        if words.endswith("\\"):
            pending.append(words[:-1])
            continue
        whole = " ".join([*pending, words]).split()
        pending = []
        if whole:
            yield number, whole


class _Reader:
    """The state of the file at a statement."""

    def __init__(self, path: Path) -> None:
        self.faces: list[FaceData] = []
        self.left_out: list[str] = []
        self.others: Counter[str] = Counter()
        self._is_open = False
        self._is_unused = False
        self._path = path
        self._line = 0
        self._vertices: list[list[float]] = []
        self._places: list[list[float]] = []
        self._curves: list[NurbsCurve] = []
        self._kind: list[str] = []
        self._degree: list[int] = []
        self._object: str | None = None
        self._group: str | None = None
        self._element: list[str] = []
        self._parameters: dict[str, list[float]] = {}
        self._loops: list[tuple[str, list[str]]] = []

    def error(self, got: str) -> NeurbsError:
        return NeurbsError(f"{self._path}: line {self._line}: {got}")

    @property
    def _name(self) -> str | None:
        return self._group or self._object

    def check_end(self) -> None:
        """Raise if the file ends within a surface, or with points and curves that none uses."""
        if self._is_open:
            raise self.error("its last surface or curve has no `end`: it may be cut short")
        if self._is_unused:
            raise self.error("its last points and curves have no surface: it may be cut short")

    def read(self, line: int, words: list[str]) -> None:
        """Take a statement."""
        self._line = line
        keyword, *values = words
        if keyword in _BEFORE_SURFACES:
            self._is_unused = True
        elif keyword in ("surf", *_OTHERS):
            self._is_unused = False
        try:
            self._read(keyword, values)
        except (ValueError, IndexError) as error:
            if isinstance(error, NeurbsError):
                raise
            raise self.error(f"`{keyword}` must have the values of its kind: {error}") from None

    def _read(self, keyword: str, values: list[str]) -> None:
        match keyword:
            case "v":
                self._vertices.append([float(value) for value in values])
            case "vp":
                self._places.append([float(value) for value in values])
            case "o":
                self._object = " ".join(values) or None
            case "g":
                name = " ".join(values)
                self._group = None if name == _NO_GROUP else name or None
            case "cstype":
                self._kind = values
            case "deg":
                self._degree = [int(value) for value in values]
            case "surf" | "curv2" | "curv":
                self._element, self._is_open = [keyword, *values], True
                self._parameters, self._loops = {}, []
            case "parm":
                self._parameters[values[0]] = [float(value) for value in values[1:]]
            case "trim" | "hole":
                self._loops.append((keyword, values))
            case "end":
                self._end()
            case _ if keyword in _OTHERS:
                self.others[_OTHERS[keyword]] += 1

    def _end(self) -> None:
        if not self._is_open:
            raise self.error("`end` must follow `surf`, `curv` or `curv2`")
        self._is_open = False
        match self._element[0]:
            case "curv":
                self.others["curve"] += 1
            case "curv2":
                self._curves.append(self._curve())
            case _:
                self._surface()

    def _weighted(self, rows: Any, size: int) -> tuple[Any, Any]:
        """Return points of so many coordinates, and their weights if the kind is rational."""
        if "rat" not in self._kind:
            return np.array([row[:size] for row in rows]), None
        weights = np.array([row[size] if len(row) > size else 1.0 for row in rows])
        return np.array([row[:size] for row in rows]), weights

    def _check_kind(self) -> None:
        if "bspline" not in self._kind:
            got = " ".join(self._kind) or "none"
            raise NeurbsError(f"cstype must be bspline or rat bspline, got {got}")

    def _curve(self) -> NurbsCurve:
        self._check_kind()
        rows = [_item(self._places, word, "vp") for word in self._element[1:]]
        points, weights = self._weighted(rows, 2)
        return loop_curves.curve_in_plane(points, weights, self._degree[0], self._parameters["u"])

    def _surface(self) -> None:
        number = len(self.faces) + len(self.left_out) + 1
        try:
            self._check_kind()
            p, q = self._degree
            knots = (self._parameters["u"], self._parameters["v"])
            rows, cols = len(knots[0]) - p - 1, len(knots[1]) - q - 1
            # A vertex may have texture and normal after a slash; u runs fastest.
            words = [word.split("/")[0] for word in self._element[5:]]
            items = [_item(self._vertices, word, "v") for word in words]
            points, weights = self._weighted(items, 3)
            net = points.reshape(cols, rows, 3).transpose(1, 0, 2)
            if weights is not None:
                weights = weights.reshape(cols, rows).T
            surface = self._part(NurbsSurface(net, weights, (p, q), knots))
        except KeyError as error:
            raise self.error(
                f"a surface must have parm u and parm v, but {error} is missing"
            ) from None
        except NeurbsError as error:
            self.left_out.append(f"{label(number, self._name)}: {cause(error)}")
            return
        self.faces.append(self._face(number, surface))

    def _part(self, surface: NurbsSurface) -> NurbsSurface:
        """Return the part of a surface in the range of `surf`."""
        u0, u1, v0, v1 = (float(word) for word in self._element[1:5])
        if ((u0, u1), (v0, v1)) == surface.domain:
            return surface
        return surface.sub_surface(u=(u0, u1), v=(v0, v1))

    def _face(self, number: int, surface: NurbsSurface) -> FaceData:
        # The outer loop first, then the holes.
        loops = sorted(self._loops, key=lambda pair: pair[0] == "hole")
        try:
            curves = [self._loop(words) for _, words in loops]
            if curves and loops[0][0] == "hole":
                # The border of the surface is the outer loop.
                (u0, u1), (v0, v1) = surface.domain
                corners = [(u0, v0), (u1, v0), (u1, v1), (u0, v1), (u0, v0)]
                pairs = itertools.pairwise(corners)
                curves.insert(0, [loop_curves.line(start, end) for start, end in pairs])
        except NeurbsError as error:
            return FaceData(number, surface, is_trimmed=True, name=self._name, defect=str(error))
        if not curves:
            return FaceData(number, surface, name=self._name)
        whole = loop_curves.whole_or_trimmed(surface, curves, None)
        return FaceData(number, surface, *whole, name=self._name)

    def _loop(self, words: list[str]) -> list[NurbsCurve]:
        """Return the curves of a `trim` or `hole`: start, end and number of each."""
        if len(words) % 3:
            raise NeurbsError("trim and hole must have two parameters and a curve for each part")
        curves = []
        for k in range(0, len(words), 3):
            start, end = float(words[k]), float(words[k + 1])
            curve = _item(self._curves, words[k + 2], "curv2")
            first, last = curve.domain
            least = _WHOLE * (last - first)
            low, high = min(start, end), max(start, end)
            if low - first > least or last - high > least:
                curve = curve.sub_curve(low, high)
            curves.append(curve.reversed() if start > end else curve)
        return curves


def _item(items: list[Any], word: str, keyword: str) -> Any:
    """Return the item of a number, which is counted from 1, or from the end if it is negative."""
    number = int(word)
    if not (0 < number <= len(items) or 0 < -number <= len(items)):
        raise NeurbsError(f"{keyword} must have numbers from 1 to {len(items)}, got {number}")
    return items[number - 1 if number > 0 else number]
