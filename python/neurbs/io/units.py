"""Units of length: their names in files, and conversion between them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from neurbs._core import LENGTH_UNITS, NeurbsError
from neurbs.errors import argument_error

_SYMBOLS = {
    "millimetre": "mm", "millimeter": "mm", "millimeters": "mm",
    "centimetre": "cm", "centimeter": "cm", "centimeters": "cm",
    "metre": "m", "meter": "m", "metres": "m", "meters": "m",
    "inch": "in", "inches": "in", "foot": "ft", "feet": "ft",
    "micron": "um", "micrometre": "um", "micrometer": "um", "micrometers": "um", "\u00b5m": "um",
    "kilometre": "km", "kilometer": "km", "kilometers": "km", "yard": "yd", "yards": "yd",
    "deg": "degree", "degrees": "degree", "\u00b0": "degree", "decimal degrees": "degree",
    **dict.fromkeys(
        ("us survey foot", "us survey feet", "survey foot", "survey feet", "us-ft", "us_ft",
         "us ft", "usft", "ftus", "ft us", "ft-us", "sft", "us feet", "us foot"),
        "US survey foot",
    ),
}  # fmt: skip

_LENGTHS = LENGTH_UNITS | {
    "um": 1e-3,
    "km": 1e6,
    "yd": 914.4,
    # 1200/3937 m, by the definition of 1893.
    "US survey foot": 1.2e6 / 3937,
}
"""Lengths in millimeters, also of units that files can have but `unit` cannot be."""

_OF_HEIGHTS = ", z: "
"""Between the unit of x and y and that of z, where they differ."""


def symbol(name: str) -> str:
    """Return the symbol of a unit, or its name if it has none.

    Examples
    --------
    >>> symbol("Metre"), symbol("US survey foot"), symbol("degree")
    ('m', 'US survey foot', 'degree')
    """
    return _SYMBOLS.get(name.strip().lower(), name.strip())


def of_length(millimeters: float) -> str | None:
    """Return the unit of a length, None if there is none.

    Examples
    --------
    >>> of_length(25.4), of_length(7.0)
    ('in', None)
    """
    units = (unit for unit, length in _LENGTHS.items() if math.isclose(length, millimeters))
    return next(units, None)


def check_unit(unit: str | None) -> None:
    """Check that files can have a unit.

    Raises
    ------
    NeurbsError
        If the unit is not one of `LENGTH_UNITS`.
    """
    if unit is not None and unit not in LENGTH_UNITS:
        known = " or ".join(map(repr, LENGTH_UNITS))
        raise argument_error("unit", f"must be {known}, got {unit!r}")


def of_heights(unit: str, height_unit: str) -> str:
    """Return the unit of coordinates whose z may have another one.

    Examples
    --------
    >>> of_heights("m", "ft"), of_heights("m", "m")
    ('m, z: ft', 'm')
    """
    return unit if unit == height_unit else f"{unit}{_OF_HEIGHTS}{height_unit}"


def of_axes(unit: str) -> tuple[str, str, str]:
    """Return the units of x, y and z, the inverse of `of_heights`.

    Examples
    --------
    >>> of_axes("m"), of_axes("m, z: ft")
    (('m', 'm', 'm'), ('m', 'm', 'ft'))
    """
    plane, _, height = unit.partition(_OF_HEIGHTS)
    return plane, plane, height or plane


def conversion(unit: str | None, wanted: str) -> NDArray[np.float64]:
    """Return the factors of x, y and z that convert coordinates to another unit.

    Parameters
    ----------
    unit : str or None
        The unit of the coordinates. None, if it is unknown: they are taken to have the wanted one.
    wanted : {"mm", "cm", "m", "in", "ft"}
        The new unit.

    Raises
    ------
    NeurbsError
        If the unit is not a length.

    Examples
    --------
    >>> conversion("in", "mm"), conversion("m, z: ft", "m")
    (array([25.4, 25.4, 25.4]), array([1.    , 1.    , 0.3048]))
    """
    if unit is None or unit == wanted:
        return np.ones(3)
    try:
        lengths = [_LENGTHS[symbol(name)] for name in of_axes(unit)]
    except KeyError:
        raise NeurbsError(
            f"coordinates must have a unit of length to be converted to {wanted}, got {unit!r}"
        ) from None
    return np.array(lengths) / LENGTH_UNITS[wanted]


def ratio(unit: str, wanted: str) -> float:
    """Return the factor that converts lengths from a unit to another; see `conversion`."""
    return float(conversion(unit, wanted)[0])


def file_unit(unit: str | None) -> str | None:
    """Return the unit that a file has by default for coordinates in a unit.

    It is the unit itself where files can have it, else the nearest length to that of x. None if
    the unit is unknown or not a length.

    Examples
    --------
    >>> file_unit("in"), file_unit("US survey foot"), file_unit("m, z: ft"), file_unit("degree")
    ('in', 'ft', 'm', None)
    """
    if unit is None or unit in LENGTH_UNITS:
        return unit
    try:
        conversion(unit, "mm")
    except NeurbsError:
        return None
    length = _LENGTHS[symbol(of_axes(unit)[0])]
    return min(LENGTH_UNITS, key=lambda known: abs(math.log(LENGTH_UNITS[known] / length)))
