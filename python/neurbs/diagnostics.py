"""Diagnostics about points and surfaces, and their warnings."""

from __future__ import annotations

import dataclasses
import re
import sys
import warnings
from collections.abc import Callable, Iterable
from typing import Any

from numpy.typing import ArrayLike

from neurbs import _core


class NeurbsWarning(UserWarning):
    """The base class of all warnings about points, their files, and surfaces.

    Each code has a subclass, which programs can filter.

    Attributes
    ----------
    code : str
        The stable code of the class, such as ``"folded"``.

    Examples
    --------
    >>> import warnings
    >>> import neurbs
    >>> neurbs.FoldedWarning.code
    'folded'
    >>> with warnings.catch_warnings():
    ...     warnings.simplefilter("error", neurbs.FoldedWarning)
    """

    code: str = ""


_OTHER_NAMES = {"not-settled": "ConvergenceWarning"}
"""Names of classes that differ from their code."""


def _category(code: str, meaning: str) -> type[NeurbsWarning]:
    """Make the warning class of a code: ``FoldedWarning`` for ``folded``."""
    name = _OTHER_NAMES.get(code) or "".join(map(str.title, code.split("-"))) + "Warning"
    members = {"__doc__": meaning, "__module__": "neurbs", "code": code}
    return type(name, (NeurbsWarning,), members)


READER_CODES = [
    ("columns-guessed", "The columns of the coordinates in a table are a guess."),
    ("control-points", "Points that were read are control points of surfaces."),
    ("crs-unknown", "A file has a reference system that cannot be read."),
    ("points-dropped", "Points that are not finite were left out."),
]
"""Codes and meanings of warnings about files of points."""

CATEGORIES = {
    code: _category(code, meaning) for code, meaning in [*_core.DIAGNOSTIC_CODES, *READER_CODES]
}
"""The warning class of each code."""

ClosedBodyWarning = CATEGORIES["closed-body"]
ColumnsGuessedWarning = CATEGORIES["columns-guessed"]
ComponentsWarning = CATEGORIES["components"]
ControlPointsWarning = CATEGORIES["control-points"]
ConvergenceWarning = CATEGORIES["not-settled"]
CrsUnknownWarning = CATEGORIES["crs-unknown"]
FoldedWarning = CATEGORIES["folded"]
KindDoubtfulWarning = CATEGORIES["kind-doubtful"]
LeftOutWarning = CATEGORIES["left-out"]
MixedUnitsWarning = CATEGORIES["mixed-units"]
NoDataWarning = CATEGORIES["no-data"]
OvershootWarning = CATEGORIES["overshoot"]
PointsDroppedWarning = CATEGORIES["points-dropped"]
RegionsWarning = CATEGORIES["regions"]
ThickWarning = CATEGORIES["thick"]
ToleranceMissedWarning = CATEGORIES["tolerance-missed"]
TornWarning = CATEGORIES["torn"]
TrimDoubtfulWarning = CATEGORIES["trim-doubtful"]
TwoLayersWarning = CATEGORIES["two-layers"]
UncoveredWarning = CATEGORIES["uncovered"]
UntrimmedWarning = CATEGORIES["untrimmed"]


_ACTIONS = ("default", "always", "all", "ignore", "module", "once", "error")
"""Actions of an option ``-W``, which may be abbreviated."""


def _apply_options(options: Iterable[str]) -> None:
    """Apply the options ``-W`` that name warning classes of this package.

    Python cannot import packages when it reads its options: it reports such a class as invalid and
    ignores it. Filters that a program has set take precedence.
    """
    classes = {f"neurbs.{category.__name__}": category for category in CATEGORIES.values()}
    classes["neurbs.NeurbsWarning"] = NeurbsWarning
    for option in options:
        word, message, name, *_ = (*map(str.strip, option.split(":")), "", "", "")
        action = next((action for action in _ACTIONS if word and action.startswith(word)), None)
        if action is not None and name in classes:
            warnings.filterwarnings(action, re.escape(message), classes[name], append=True)  # type: ignore[arg-type]


_apply_options(sys.warnoptions)


@dataclasses.dataclass(frozen=True)
class Diagnostic:
    """A finding about points or about the surface through them.

    Attributes
    ----------
    code : str
        The stable code; ``neurbs.NeurbsWarning`` has a subclass for each.
    message : str
        Cause and remedy; arguments stand between backticks.
    data : dict of str to object
        The numbers: shares from 0 to 1, lengths in the points' unit.
    is_defect : bool
        Whether this finding makes a surface invalid.
    """

    code: str
    message: str
    data: dict[str, Any] = dataclasses.field(repr=False, hash=False)
    is_defect: bool

    def __str__(self) -> str:
        """Return the message."""
        return self.message


def of_core(found: Iterable[tuple[str, str, dict[str, Any], bool]]) -> tuple[Diagnostic, ...]:
    """Convert findings from the core."""
    return tuple(Diagnostic(*finding) for finding in found)


def warn(diagnostics: Iterable[Diagnostic], *, stacklevel: int) -> None:
    """Issue a warning for each diagnostic; `stacklevel` is relative to the caller."""
    for found in diagnostics:
        warnings.warn(found.message, CATEGORIES[found.code], stacklevel=stacklevel + 1)


def validate(
    surface: _core.NurbsSurface,
    points: ArrayLike,
    *,
    progress: Callable[[_core.Progress], object] | None = None,
) -> list[Diagnostic]:
    """Find the defects of a surface, given the points that it should fit.

    Parameters
    ----------
    surface : NurbsSurface
        A surface of any origin.
    points : array_like of shape (n, 3) or (n, 2)
        The points that it should fit.
    progress : callable, optional
        Called some 25 times a second with a `Progress`. An exception that it raises ends the job.

    Returns
    -------
    list of Diagnostic
        The defects; empty if the surface is valid.

    Raises
    ------
    NeurbsError
        If no surface fits the points: fewer than four distinct ones, or all on one line.

    Examples
    --------
    >>> import numpy as np
    >>> import neurbs
    >>> x, y = np.random.default_rng(0).random((2, 500))
    >>> points = np.column_stack([x, y, 0 * x])
    >>> def strip(*x):
    ...     return neurbs.NurbsSurface([[(x, 0, 0), (x, 1, 0)] for x in x], degree=(3, 1))
    >>> neurbs.validate(strip(0, 0.3, 0.7, 1), points)
    []
    >>> [found.code for found in neurbs.validate(strip(0, 2, -1, 1), points)]
    ['folded', 'torn']
    """
    return list(of_core(_core.validate(surface, points, progress)))
