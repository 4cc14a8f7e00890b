"""The header of a text table: names and units of its columns."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from neurbs._core import LENGTH_UNITS, NeurbsError
from neurbs.io.point_cloud import Columns
from neurbs.io.units import symbol

_AXES = (
    ("x", "easting", "east", "lon", "longitude"),
    ("y", "northing", "north", "lat", "latitude"),
    ("z", "height", "elevation", "elev", "altitude"),
)
_NORMALS = (("nx", "normal_x"), ("ny", "normal_y"), ("nz", "normal_z"))
_COLORS = (("red", "r"), ("green", "g"), ("blue", "b"))
"""Names of the columns of coordinates, normals and colors."""

_NAME = re.compile(r"(.*?)\s*(?:[(\[](.*)[)\]])?")
"""A name, optionally with a unit in brackets."""


@dataclass(frozen=True)
class Header:
    """Names of columns in lower case, with their units; without names there is no header."""

    names: tuple[str, ...] = ()
    units: tuple[str | None, ...] = ()
    line: int = 0

    @classmethod
    def of(cls, fields: list[str], line: int) -> Header:
        """Make a header from the fields of a line."""
        matches = [_NAME.fullmatch(field.strip().strip("\"'").lower()) for field in fields]
        pairs = [("", None) if match is None else match.groups() for match in matches]
        return cls(tuple(name for name, _ in pairs), tuple(unit for _, unit in pairs), line)

    @property
    def has_axes(self) -> bool:
        """Whether all three coordinates have names."""
        return len(self._found(_AXES)) == 3

    @property
    def normals(self) -> tuple[int, ...]:
        """The columns of the normals, if they have names."""
        return self._all_found(_NORMALS)

    @property
    def colors(self) -> tuple[int, ...]:
        """The columns of the colors, if they have names."""
        return self._all_found(_COLORS)

    def coordinates(self, path: Path, line: int, width: int) -> tuple[int, ...]:
        """Return the columns of the coordinates, or () if no axis, or only x and y, have names.

        A row of the table, in line `line`, has `width` columns.
        """
        axes = self._found(_AXES)
        if len(axes) == 3 and len(self.names) != width:
            raise NeurbsError(
                f"{path}: line {line} must have {len(self.names)} columns, "
                f"as the header in line {self.line}, got {width}"
            )
        if len(axes) < 3 and tuple(axes) != (0, 1)[: len(axes)]:
            raise NeurbsError(
                f"{path}: the header in line {self.line} must name x, y and z, got "
                f"{', '.join(map(repr, self.names))}: choose the coordinates with `columns`"
            )
        return tuple(axes) if len(axes) == 3 else ()

    def chosen(self, path: Path, columns: Columns, width: int) -> tuple[int, ...]:
        """Return the columns that are given by names or numbers."""
        known = {name: i for i, name in reversed(list(enumerate(self.names)))}
        found = [
            known.get(column.strip().lower()) if isinstance(column, str) else column
            for column in columns
        ]
        indices = tuple(index for index in found if index is not None and 0 <= index < width)
        if len(indices) < len(columns):
            names = f" or of {', '.join(map(repr, self.names))}" if self.names else ""
            raise NeurbsError(
                f"{path}: columns must be from 0 to {width - 1}{names}, got {columns}"
            )
        return indices

    def unit_of(self, columns: tuple[int, ...]) -> str | None:
        """Return the unit of columns, or None if they have different units or none."""
        units = {self.units[column] for column in columns if column < len(self.units)}
        symbols = {None if unit is None else symbol(unit) for unit in units}
        return symbols.pop() if len(symbols) == 1 else None

    def check_units(self, path: Path, columns: tuple[int, ...]) -> None:
        """Check that coordinates have the same unit; z may differ if x and y are no lengths."""
        units = [self.units[c] if c < len(self.units) else None for c in columns]
        known = [symbol(unit) for unit in units if unit is not None]
        lengths = {unit for unit in known if unit in LENGTH_UNITS}
        flat = {symbol(unit) for unit in units[:2] if unit is not None}
        if len(lengths) > 1 or len(flat) > 1:
            raise NeurbsError(
                f"{path}: coordinates must have the same unit, but the header in line {self.line} "
                f"has {', '.join(known)}: convert them"
            )

    def _found(self, columns: tuple[tuple[str, ...], ...]) -> list[int]:
        """Return the indices of columns by one of their names, without the missing ones."""
        indices = (
            next((self.names.index(name) for name in names if name in self.names), None)
            for names in columns
        )
        return [index for index in indices if index is not None]

    def _all_found(self, columns: tuple[tuple[str, ...], ...]) -> tuple[int, ...]:
        found = self._found(columns)
        return tuple(found) if len(found) == len(columns) else ()
