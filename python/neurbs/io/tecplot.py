"""Points in text files of Tecplot: the nodes of all zones.

A zone has its numbers by points, or in a block for each variable. Binary files are not read.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.io.point_cloud import BLOCK, Block, PointSource, Request
from neurbs.io.reading import damaged
from neurbs.io.table import numbered_lines, shown
from neurbs.io.table_columns import choose, doubts
from neurbs.io.table_header import Header
from neurbs.io.table_layout import is_number, without_fortran
from neurbs.io.table_sample import Sample

_RECORD = re.compile(
    r"\s*(title|variables|filetype|zone|text|geometry|customlabels|datasetauxdata|varauxdata)\b",
    re.IGNORECASE,
)
"""The start of a record."""

_DRAWN = ("text", "geometry")
"""Records of drawings, whose numbers are no points."""

_NAME = re.compile(r'"([^"]*)"|([^\s,="]+)')
"""A name of a variable."""

_SETTING = re.compile(r'(\w+)\s*=\s*("[^"]*"|\([^)]*\)|[^\s,]+)')
"""A setting of a zone."""

_LIST = re.compile(r"\[([\d,\s-]*)\](?:\s*=\s*(\w+))?")
"""Numbers of variables in brackets, with the setting that they have."""

_REPEATED = re.compile(r"(\d{1,18})\*(\S+)")
"""Several equal numbers: ``3*1.5``."""

_MOST_LINES, _LINES = 1000, 4096
"""Most lines above the first zone, and lines whose numbers are converted together."""

_MOST_GROWN = 100
"""Most numbers for each byte of a file, because a few bytes may repeat a number."""


def is_tecplot(path: Path) -> bool:
    """Whether a text file has records of variables and zones above its first number."""
    records: list[str] = []
    for _, line in islice(numbered_lines(path), _MOST_LINES):
        record = _RECORD.match(line)
        if record is not None:
            records.append(record[1].lower())
        elif not line.strip() or line.lstrip().startswith("#"):
            continue
        elif not records or (_is_data(line) and records[-1] not in _DRAWN):
            break
        if {"variables", "zone"} <= {*records}:
            return True
    return False


def read_tecplot(path: Path, request: Request) -> PointSource:
    """Read the nodes of all zones.

    Raises
    ------
    NeurbsError
        If a zone has another number of values than its header says, or shares some variables.
    """
    zones = _zones(path)
    first = next(zones)
    header = Header.of(first.names, first.line)
    # All variables are real numbers.
    sample = Sample(first.first, [["0.5"] * len(first.names)])
    choice = choose(path, header, sample, request.columns)

    def blocks() -> Iterator[Block]:
        yield from first.blocks(path, choice.points)
        for zone in zones:
            if zone.names != first.names:
                raise NeurbsError(f"{path}: line {zone.line}: all zones must have one set of names")
            yield from zone.blocks(path, choice.points)

    described = f"{choice.described(header)}; the points start in line {first.first}"
    return PointSource(
        blocks(),
        unit=header.unit_of(path, choice.points, request.unit),
        doubts=doubts(choice.described(header), [choice.guess]),
        columns=described,
    )


def _zones(path: Path) -> Iterator[_Zone]:
    """Yield the zones that have numbers.

    Raises
    ------
    NeurbsError
        If there is none.
    """
    names: tuple[str, ...] = ()
    record, found = "", False
    zone: _Zone | None = None
    for number, line in numbered_lines(path):
        if _is_data(line):
            if zone is not None:
                zone.add(path, number, line)
            continue
        start = _RECORD.match(line)
        if start is not None:
            if zone is not None and zone.first:
                found = True
                yield zone
            record, line = start[1].lower(), line[start.end() :]
            names = () if record == "variables" else names
            zone = _Zone(names, number) if record == "zone" else None
        if zone is not None:
            zone.header += line
        elif record == "variables" and not line.lstrip().startswith("#"):
            names += tuple(quoted or plain for quoted, plain in _NAME.findall(line))
    if zone is not None and zone.first:
        found = True
        yield zone
    if not found:
        raise NeurbsError(f"{path}: must have a zone with numbers, but there is none")


def _is_data(line: str) -> bool:
    """Whether a line begins with a number."""
    words = line.replace(",", " ").split(maxsplit=1)
    return bool(words) and is_number(without_fortran(_REPEATED.sub(r"\2", words[0])))


@dataclass
class _Zone:
    """A zone: the names of its variables, the text of its header, and its numbers."""

    names: tuple[str, ...]
    line: int
    header: str = ""
    first: int = 0
    """The line of the first number, 0 if there is none."""
    _width: int = 0
    """The numbers in that line."""
    _count: int = 0
    _lines: list[str] = field(default_factory=list)
    _parts: list[NDArray[np.float64]] = field(default_factory=list)

    def add(self, path: Path, number: int, line: str) -> None:
        """Add a line of numbers."""
        text = line.split("#")[0].replace(",", " ")
        if not self.first:
            self.first, self._width = number, len(text.split())
        self._lines.append(text)
        if len(self._lines) == _LINES:
            self._convert(path)

    def blocks(self, path: Path, columns: Sequence[int]) -> Iterator[Block]:
        """Yield some variables of the nodes."""
        nodes = self._nodes(path, columns)
        for start in range(0, len(nodes), BLOCK):
            yield Block(nodes[start : start + BLOCK])

    def _nodes(self, path: Path, columns: Sequence[int]) -> NDArray[np.float64]:
        self._convert(path)
        settings = self._settings
        shared = self._variables("VARSHARELIST")
        if {*columns} <= shared:
            # These nodes are those of an earlier zone.
            return np.empty((0, len(columns)))
        if shared or "PASSIVEVARLIST" in settings:
            raise self._wrong(path, "must have all variables, but shares some with other zones")
        values = np.concatenate(self._parts)
        packing = settings.get("DATAPACKING", settings.get("F", ""))
        centered = self._variables("VARLOCATION", "CELLCENTERED")
        by_blocks = packing.endswith("BLOCK") or bool(centered)
        by_blocks = by_blocks or (not packing and self._width != len(self.names))
        sides = [self._number(path, key) for key in ("I", "J", "K")]
        nodes = self._number(path, "NODES", "N") or math.prod(side or 1 for side in sides)
        if not by_blocks:
            count = nodes if any(sides) or nodes > 1 else len(values) // len(self.names)
            self._check_count(path, len(values), count * len(self.names))
            return values[: count * len(self.names)].reshape(count, -1)[:, list(columns)]
        if centered & {*columns}:
            raise self._wrong(path, "must have its coordinates at nodes, not in cells")
        cells = self._number(path, "ELEMENTS", "E")
        cells = cells or math.prod(max(side - 1, 1) for side in sides if side)
        sizes = [cells if i in centered else nodes for i in range(len(self.names))]
        self._check_count(path, len(values), sum(sizes))
        starts = [sum(sizes[:column]) for column in columns]
        return np.column_stack([values[start : start + nodes] for start in starts])

    @property
    def _settings(self) -> dict[str, str]:
        return {key.upper(): value.upper() for key, value in _SETTING.findall(self.header)}

    @property
    def _has_elements(self) -> bool:
        """Whether numbers of nodes follow the values."""
        kinds = (self._settings.get(key, "") for key in ("ZONETYPE", "F"))
        return any(kind.startswith("FE") for kind in kinds)

    def _number(self, path: Path, *keys: str) -> int:
        """Return the first of some settings that is there, 0 if none is."""
        text = next((self._settings[key] for key in keys if key in self._settings), "0")
        if not text.isdecimal():
            raise self._wrong(path, f"must have a number as {keys[0]}, got {shown(text)}")
        return int(text)

    def _variables(self, setting: str, value: str = "") -> set[int]:
        """Return the variables, from 0, that have a setting, such as a location."""
        text, found = self._settings.get(setting, ""), set()
        for numbers, their in _LIST.findall(text):
            for part in numbers.replace(",", " ").split() if value in ("", their) else ():
                first, _, last = part.partition("-")
                if first.isdecimal() and (last or first).isdecimal():
                    end = min(int(last or first), len(self.names))
                    found |= {*range(int(first) - 1, end)}
        if "[" not in text:
            places = text.strip("()").replace(",", " ").split()
            found |= {i for i, place in enumerate(places) if place == value}
        return found

    def _check_count(self, path: Path, got: int, count: int) -> None:
        if got < count or (got > count and not self._has_elements):
            but = "is cut short after" if got < count else "has"
            raise self._wrong(path, f"must have {count} values by its header, but {but} {got}")

    def _wrong(self, path: Path, message: str) -> NeurbsError:
        return NeurbsError(f"{path}: the zone in line {self.line} {message}")

    def _convert(self, path: Path) -> None:
        """Convert the lines since the last call to numbers."""
        text = " ".join(self._lines)
        self._lines.clear()
        repeated = sum(int(count) for count, _ in _REPEATED.findall(text))
        if self._count + repeated > _MOST_GROWN * path.stat().st_size:
            raise damaged(path, "it repeats numbers too often")
        text = without_fortran(_REPEATED.sub(lambda m: f"{m[2]} " * int(m[1]), text))
        words = text.split()
        try:
            values = np.array(words, np.float64)
        except ValueError:
            word = next(word for word in words if not is_number(word))
            raise self._wrong(path, f"must have numbers, got {shown(word)}") from None
        self._count += len(values)
        self._parts.append(values)
