"""The names of a table's columns, and what they say."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from neurbs._core import NeurbsError
from neurbs.io.point_cloud import Columns
from neurbs.io.units import symbol

_AXES = (
    ("x", "easting", "east", "lon", "longitude"),
    ("y", "northing", "north", "lat", "latitude"),
    ("z", "height", "elevation", "elev", "altitude"),
)
_NORMALS = (("nx", "normal_x"), ("ny", "normal_y"), ("nz", "normal_z"))
_COLORS = (("red", "r"), ("green", "g"), ("blue", "b"))
"""What the columns of coordinates, normals and colours are called."""

_NAME = re.compile(r"(.*?)\s*(?:[(\[](.*)[)\]])?")
"""A name, and its unit in brackets."""


@dataclass(frozen=True)
class Header:
    """Names of columns, in small letters, with their units.

    A header without names stands for none.
    """

    names: tuple[str, ...] = ()
    units: tuple[str | None, ...] = ()
    line: int = 0

    @classmethod
    def of(cls, fields: list[str], line: int) -> Header:
        """Make it of the fields of a line."""
        matches = [_NAME.fullmatch(field.strip().strip("\"'").lower()) for field in fields]
        pairs = [("", None) if match is None else match.groups() for match in matches]
        return cls(tuple(name for name, _ in pairs), tuple(unit for _, unit in pairs), line)

    @property
    def has_axes(self) -> bool:
        """Whether all three coordinates are named."""
        return len(self._found(_AXES)) == 3

    @property
    def normals(self) -> tuple[int, ...]:
        """The columns of the normals, if they are named."""
        return self._all_found(_NORMALS)

    @property
    def colors(self) -> tuple[int, ...]:
        """The columns of the colours, if they are named."""
        return self._all_found(_COLORS)

    def coordinates(self, path: Path, line: int, width: int) -> tuple[int, ...]:
        """Find the named coordinates of rows, of which one is in `line` and has `width` columns.

        There are none if no axis is named, or if x and y are the first two.
        """
        axes = self._found(_AXES)
        if len(axes) == 3 and len(self.names) != width:
            raise NeurbsError(
                f"{path}: line {line} must have {len(self.names)} columns, "
                f"as the header in line {self.line} has, got {width}"
            )
        if len(axes) < 3 and tuple(axes) != (0, 1)[: len(axes)]:
            raise NeurbsError(
                f"{path}: the header in line {self.line} must name x, y and z, got "
                f"{', '.join(map(repr, self.names))}: choose the coordinates with `columns`"
            )
        return tuple(axes) if len(axes) == 3 else ()

    def chosen(self, path: Path, columns: Columns, width: int) -> tuple[int, ...]:
        """Find the columns that somebody asks for by name or number."""
        known = {name: i for i, name in reversed(list(enumerate(self.names)))}
        found = [
            known.get(column.strip().lower()) if isinstance(column, str) else column
            for column in columns
        ]
        places = tuple(place for place in found if place is not None and 0 <= place < width)
        if len(places) < len(columns):
            names = f" or of {', '.join(map(repr, self.names))}" if self.names else ""
            raise NeurbsError(f"{path}: columns must be of 0 to {width - 1}{names}, got {columns}")
        return places

    def unit_of(self, columns: tuple[int, ...]) -> str | None:
        """Return the one unit of some columns."""
        units = {self.units[column] for column in columns if column < len(self.units)}
        unit = units.pop() if len(units) == 1 else None
        return None if unit is None else symbol(unit)

    def _found(self, wanted: tuple[tuple[str, ...], ...]) -> list[int]:
        """Find the first column of each of the wanted names that is there at all."""
        places = (
            next((self.names.index(name) for name in names if name in self.names), None)
            for names in wanted
        )
        return [place for place in places if place is not None]

    def _all_found(self, wanted: tuple[tuple[str, ...], ...]) -> tuple[int, ...]:
        found = self._found(wanted)
        return tuple(found) if len(found) == len(wanted) else ()
