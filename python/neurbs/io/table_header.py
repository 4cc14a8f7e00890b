"""The header of a text table: names and units of its columns."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from neurbs._core import LENGTH_UNITS, NeurbsError
from neurbs.io.point_cloud import Columns
from neurbs.io.units import of_heights, symbol

HORIZONTAL = (
    ("x", "y"),
    ("easting", "northing"),
    ("eastings", "northings"),
    ("east", "north"),
    ("e", "n"),
    ("longitude", "latitude"),
    ("lon", "lat"),
    ("long", "lat"),
    ("lng", "lat"),
    ("rechts", "hoch"),
    ("ost", "nord"),
    ("est", "nord"),
    ("este", "norte"),
    ("leste", "norte"),
    ("londd", "latdd"),
    ("points0", "points1"),
    ("px", "py"),
    ("x0", "y0"),
    ("x1", "x2"),
)
"""Pairs of names for x and y."""

VERTICAL = (
    "z", "height", "elevation", "elev", "ele", "altitude", "alt", "ellipsoidalheight",
    "orthometricheight", "msl", "hae", "h", "rl", "level", "höhe", "hoehe", "h\ufffdhe",
    "cota", "cote", "quota", "depth", "tiefe", "tvdss", "tvd", "bathymetry", "points2", "pz",
    "z0", "x3",
)  # fmt: skip
"""Names for z; one that comes first here is preferred."""

_NUMBERS = {
    "", "id", "fid", "objectid", "index", "no", "nr", "num", "number", "point", "pointno",
    "pointid", "pointnumber", "pt", "ptno", "ptid", "punkt", "punktnr", "name", "station", "line",
}  # fmt: skip
"""Names for the number or name of a point."""

_NORMALS = (
    ("nx", "normalx", "normals0"),
    ("ny", "normaly", "normals1"),
    ("nz", "normalz", "normals2"),
)
_COLORS = (("red", "r"), ("green", "g"), ("blue", "b"))
"""Names of the columns of normals and colors."""

_NAME = re.compile(r"(.*?)\s*(?:[(\[{](.*)[)\]}])?")
"""A name, optionally with a unit in brackets."""

_JOINED = re.compile(r"(.+?)(?:\s+in)?[\s_/,](\w+)")
"""A name and a unit behind a separator, or behind ``in``."""

_SEPARATORS = re.compile(r"[\s_.:,#/-]+")

_FILLERS = re.compile(
    "coordinates?|coords?|position|^points?(?=[xyz]$)|^pos|pos$|utm|wgs84|value$|wert$"
)
"""Parts of names without a meaning for the choice: ``UTM_X``, ``x-coordinate``, ``Rechtswert``."""

_VARIABLES = re.compile(r"\s*variables\s*=", re.IGNORECASE)
"""The start of the header line of Tecplot."""

_OTHER_UNITS = {"degree", "rad", "s", "ms", "-", ""}


@dataclass(frozen=True)
class Header:
    """Names of columns, with their units; without names there is no header.

    Attributes
    ----------
    labels : tuple of str
        The columns' texts in the file, with units.
    names : tuple of str
        The names in lower case, without units.
    units : tuple of (str or None)
        The units.
    line : int
        The line in the file.
    """

    labels: tuple[str, ...] = ()
    names: tuple[str, ...] = ()
    units: tuple[str | None, ...] = ()
    line: int = 0

    @classmethod
    def of(cls, fields: Iterable[str], line: int) -> Header:
        """Make a header from the fields of a line."""
        labels = tuple(field.strip().strip("\"'").strip() for field in fields)
        pairs = [_name_and_unit(label.lower()) for label in labels]
        return cls(labels, tuple(name for name, _ in pairs), tuple(unit for _, unit in pairs), line)

    @property
    def horizontal(self) -> tuple[int, int] | None:
        """The columns of x and y, if both have names."""
        keys = self.keys
        for x, y in HORIZONTAL:
            if x in keys and y in keys:
                return keys.index(x), keys.index(y)
        return None

    @property
    def vertical(self) -> int | None:
        """The column of z, if it has a name."""
        keys = self.keys
        return next((keys.index(name) for name in VERTICAL if name in keys), None)

    @property
    def axes(self) -> tuple[int, ...]:
        """The columns of x, y and z, or of x and y, if the table has no others; else none."""
        flat, z = self.horizontal, self.vertical
        if flat is None:
            return ()
        if z is not None:
            return (*flat, z)
        return flat if len(self.names) == 2 else ()

    @property
    def has_some_axes(self) -> bool:
        """Whether one of the coordinates has a name."""
        known = {name for pair in HORIZONTAL for name in pair} | {*VERTICAL}
        # Other letters are often names of something else.
        return any(key in known and (len(key) > 1 or key in "xyz") for key in self.keys if key)

    @property
    def is_units(self) -> bool:
        """Whether each field is a unit."""
        texts = [(label.strip("[](){} ").lower()) for label in self.labels]
        return any(texts) and all(symbol(text) in {*LENGTH_UNITS, *_OTHER_UNITS} for text in texts)

    @property
    def normals(self) -> tuple[int, ...]:
        """The columns of the normals, if they have names."""
        return self._all_found(_NORMALS)

    @property
    def colors(self) -> tuple[int, ...]:
        """The columns of the colors, if they have names."""
        return self._all_found(_COLORS)

    @property
    def numbers_points(self) -> bool:
        """Whether the first column's name is one for the number of a point."""
        return bool(self.names) and self.keys[0] in _NUMBERS

    def with_units(self, units: Header) -> Header:
        """Return the header with the units of another line, if it has none."""
        if len(units.labels) != len(self.names) or any(self.units):
            return self
        found = tuple(label.strip("[](){} ").lower() or None for label in units.labels)
        return replace(self, units=found)

    def chosen(self, path: Path, columns: Columns, width: int) -> tuple[int, ...]:
        """Return the columns that are given by names or numbers."""
        known: dict[str, int] = {}
        for texts in (self.names, tuple(label.lower() for label in self.labels)):
            for i, text in enumerate(texts):
                known.setdefault(text, i)
        found = [
            known.get(column.strip().lower()) if isinstance(column, str) else column
            for column in columns
        ]
        indices = tuple(index for index in found if index is not None and 0 <= index < width)
        if len(indices) < len(columns):
            names = f" or of {', '.join(map(repr, self.labels))}" if self.names else ""
            raise NeurbsError(
                f"{path}: columns must be from 0 to {width - 1}{names}, got {columns}"
            )
        return indices

    def unit_of(self, path: Path, columns: tuple[int, ...], wanted: str | None) -> str | None:
        """Return the unit of coordinates, of which z may have another one.

        It is unknown if a column has none. Such columns can only be read in the unit of the others.

        Raises
        ------
        NeurbsError
            If x and y have different units, or `wanted` is not the unit of those that have one.
        """
        given = [self.units[c] if c < len(self.units) else None for c in columns]
        units = [None if unit is None else symbol(unit) for unit in given]
        flat = [unit for unit in units[:2] if unit]
        if len({*flat}) > 1:
            raise NeurbsError(
                f"{path}: x and y must have the same unit, but the header in line {self.line} "
                f"has {' and '.join(flat)}: convert them"
            )
        known = [unit for unit in units if unit]
        if None not in units:
            return of_heights(known[0], known[-1])
        if wanted is not None and {*known} - {wanted}:
            missing = [axis for axis, unit in zip("xyz", units, strict=False) if unit is None]
            raise NeurbsError(
                f"{path}: unit must be {known[0]!r} or left out, as the header in line "
                f"{self.line} has no unit of {' and '.join(missing)}, got {wanted!r}: complete it "
                "to convert the points"
            )
        return None

    @property
    def keys(self) -> list[str]:
        """The names without separators and fillers."""
        return [_FILLERS.sub("", _SEPARATORS.sub("", name)) for name in self.names]

    def _all_found(self, columns: tuple[tuple[str, ...], ...]) -> tuple[int, ...]:
        keys = self.keys
        found = [
            next((keys.index(name) for name in names if name in keys), None) for names in columns
        ]
        return tuple(i for i in found if i is not None) if None not in found else ()


def _name_and_unit(label: str) -> tuple[str, str | None]:
    """Split a text into a name and its unit.

    Examples
    --------
    >>> _name_and_unit("depth [m]"), _name_and_unit("x_mm"), _name_and_unit("point no")
    (('depth', 'm'), ('x', 'mm'), ('point no', None))
    """
    match = _NAME.fullmatch(label)
    if match is None:
        return "", None
    name, unit = match.groups()
    joined = _JOINED.fullmatch(name)
    if unit is None and joined is not None and symbol(joined[2]) in LENGTH_UNITS:
        return joined[1].strip(), joined[2]
    return name, unit


def names_in(text: str) -> str:
    """Return the part of a header line that has the names, without the words of Tecplot."""
    return _VARIABLES.sub("", text)
