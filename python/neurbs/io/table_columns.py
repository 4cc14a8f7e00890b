"""Which columns of a text table are the coordinates: by names, else by content.

The rule is documented in `neurbs.read_points`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from neurbs._core import NeurbsError
from neurbs.io.point_cloud import Columns, Doubt
from neurbs.io.table import shown
from neurbs.io.table_header import Header
from neurbs.io.table_sample import Sample

_CHOOSE = "choose the coordinates with `columns`"


@dataclass(frozen=True)
class Choice:
    """The columns of the coordinates.

    Attributes
    ----------
    points : tuple of int
        The columns, from 0.
    guess : str or None
        Why they may be wrong.
    """

    points: tuple[int, ...]
    guess: str | None = None

    def described(self, header: Header) -> str:
        """Say in a line which columns are the coordinates."""
        axes = ", ".join("xyz"[: len(self.points)])
        if header.labels and all(header.labels[c] for c in self.points):
            columns = ", ".join(repr(header.labels[c]) for c in self.points)
            return f"{axes} are columns {columns}"
        return f"{axes} are columns {', '.join(map(str, self.points))}, counted from 0"


def choose(path: Path, header: Header, sample: Sample, columns: Columns | None) -> Choice:
    """Choose the columns of the coordinates.

    Parameters
    ----------
    path : Path
        The file, for messages.
    header : Header
        The names of the columns, if there are any.
    sample : Sample
        The first rows.
    columns : tuple of str or int, optional
        The choice of the caller.

    Raises
    ------
    NeurbsError
        If there are no such columns.
    """
    if sample.width < 2:
        raise NeurbsError(
            f"{path}: line {sample.line} must have columns x, y and z (or x and y), "
            f"got column 1 only, {shown(' '.join(sample.fields[0]))}: "
            "separate columns by whitespace, comma, semicolon or tab"
        )
    if columns is not None:
        return Choice(header.chosen(path, columns, sample.width))
    if len(header.axes) == 3 and len(header.names) != sample.width:
        raise NeurbsError(
            f"{path}: line {sample.line} must have {len(header.names)} columns, "
            f"as the header in line {header.line}, got {sample.width}"
        )
    if header.axes:
        return Choice(header.axes)
    numbers = [i for i, found in enumerate(sample.is_number) if found]
    if header.horizontal is not None:
        return _with_unnamed_height(path, header, sample, numbers)
    if header.has_some_axes and len(numbers) != 2:
        raise _unnamed(path, header)
    return _by_content(path, header, sample, numbers)


def doubts(described: str, guesses: Iterable[str | None]) -> list[Doubt]:
    """Return the doubts about columns for reasons, of which None is none."""
    reasons = [guess for guess in guesses if guess]
    if not reasons:
        return []
    message = f"{described}, as a guess: {'; '.join(reasons)}: use `columns` to choose"
    return [Doubt("columns-guessed", message)]


def _with_unnamed_height(path: Path, header: Header, sample: Sample, numbers: list[int]) -> Choice:
    """Choose the only other column of numbers as z, if there is one and it comes last."""
    x, y = header.horizontal or (0, 1)
    others = [i for i in numbers if i not in (x, y)]
    if others and others[0] == 0 and (header.numbers_points or sample.counts(0)):
        others = others[1:]
    if len(others) > 1 or any(i < max(x, y) for i in others):
        raise _unnamed(path, header)
    return Choice((x, y, *others), "z has no known name" if others else None)


def _unnamed(path: Path, header: Header) -> NeurbsError:
    return NeurbsError(
        f"{path}: the header in line {header.line} must name x, y and z, got "
        f"{', '.join(map(repr, header.labels))}: {_CHOOSE}"
    )


def _by_content(path: Path, header: Header, sample: Sample, numbers: list[int]) -> Choice:
    """Choose the first three columns of numbers, after one that numbers the points."""
    guess = None
    if header.names:
        guess = f"the names {', '.join(map(repr, header.labels))} are not known"
    if len(numbers) > 3:
        first, *others = numbers
        # Files of surveys often have northing before easting, and no names.
        order = f"; x is column {others[0]} and y {others[1]}, but many surveys have northing first"
        if first == 0 and header.numbers_points:
            numbers = others
        elif sample.counts(first):
            guess = f"column {first} counts the rows and is skipped{order}"
            numbers = others
        elif sample.numbers_with_gaps(first, others[:3]):
            guess = f"column {first} numbers the points and is skipped{order}"
            numbers = others
        elif sample.may_count(first, others[:3]):
            guess = guess or f"column {first} may number the points"
    if len(numbers) >= 3:
        return Choice(tuple(numbers[:3]), guess)
    if len(numbers) == 2 and sample.filled == 2:
        return Choice(tuple(numbers), guess)
    row = ", ".join(map(shown, sample.fields[0]))
    raise NeurbsError(
        f"{path}: line {sample.line} must have three columns of numbers, got {row}: {_CHOOSE}"
    )
