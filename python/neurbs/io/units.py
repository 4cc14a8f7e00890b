"""Units of length and their names in files."""

from neurbs._core import LENGTH_UNITS
from neurbs.errors import argument_error

_SYMBOLS = {
    "millimetre": "mm", "millimeter": "mm", "millimeters": "mm",
    "centimetre": "cm", "centimeter": "cm", "centimeters": "cm",
    "metre": "m", "meter": "m", "metres": "m", "meters": "m",
    "inch": "in", "inches": "in", "foot": "ft", "feet": "ft",
}  # fmt: skip


def symbol(name: str) -> str:
    """Return the symbol of a unit, or its name if it has none.

    Examples
    --------
    >>> symbol("Metre"), symbol("US survey foot")
    ('m', 'US survey foot')
    """
    return _SYMBOLS.get(name.strip().lower(), name.strip())


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
