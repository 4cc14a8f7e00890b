"""The first rows of a text table, from which its columns are recognized."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate, pairwise

from neurbs.io.table_layout import Layout, is_missing, is_number

SAMPLE, _CHARACTERS = 1000, 1 << 20
"""Most rows that are looked at, and most characters of them."""

MAX_ROW = 1 << 16
"""Most characters of the first row, and of a line above it."""

_INTEGER = re.compile(r"\+?\d{1,15}")

_LABEL = re.compile(r"\d{1,15}|(?=\w*\d)(?=\w*[A-Za-z])\w+(?<![eE]\d)")
"""A number of a point, or one with letters."""


def check_length(line: int, text: str) -> None:
    """Raise a ValueError if a row is too long for a table of points."""
    if len(text) > MAX_ROW:
        raise ValueError(f"line {line} has more than {MAX_ROW:,} characters")


@dataclass(frozen=True)
class Sample:
    """The first rows of a table.

    Attributes
    ----------
    line : int
        The line of the first row.
    fields : list of list of str
        The fields of the rows that are as wide as the first.
    """

    line: int
    fields: list[list[str]]

    @classmethod
    def of(cls, rows: Sequence[tuple[int, str]], layout: Layout) -> Sample:
        """Split rows.

        Raises
        ------
        ValueError
            If the first row is too long for a table of points.
        """
        check_length(*rows[0])
        lengths = accumulate(len(text) for _, text in rows[:SAMPLE])
        count = sum(1 for length in lengths if length <= _CHARACTERS)
        split = [layout.split(text) for _, text in rows[:count]]
        return cls(rows[0][0], [fields for fields in split if len(fields) == len(split[0])])

    @property
    def width(self) -> int:
        """The number of columns."""
        return len(self.fields[0])

    @cached_property
    def filled(self) -> int:
        """The number of columns without those at the end that are empty in all rows."""
        places = (i for fields in self.fields for i, field in enumerate(fields, 1) if field)
        return max(places, default=0)

    @cached_property
    def is_number(self) -> list[bool]:
        """For each column, whether at least half of the fields that are not missing are numbers.

        Fields of a damaged row do not turn a column into one of text.
        """
        found = []
        for column in zip(*self.fields, strict=True):
            present = [field for field in column if not is_missing(field)]
            found.append(bool(present) and 2 * sum(map(is_number, present)) >= len(present))
        return found

    def counts(self, column: int) -> bool:
        """Whether a column has consecutive integers, in at least two rows."""
        texts = [fields[column] for fields in self.fields]
        if len(texts) < 2 or not all(map(_INTEGER.fullmatch, texts)):
            return False
        first = int(texts[0])
        return all(int(text) == first + i for i, text in enumerate(texts))

    def numbers_with_gaps(self, column: int, others: Sequence[int]) -> bool:
        """Whether a column has increasing integers with gaps, beside others with decimals.

        At even steps, or beside a constant column, they may be places along a profile. Some may
        have letters, as in ``2A``.
        """
        texts = [fields[column] for fields in self.fields]
        if not all(map(self._has_decimals, others)) or any(map(self._is_constant, others[:2])):
            return False
        integers = [text for text in texts if _INTEGER.fullmatch(text)]
        if len(integers) < len(texts):
            return all(_LABEL.fullmatch(text) for text in texts)
        steps = {int(after) - int(before) for before, after in pairwise(texts)}
        return len(steps) > 1 and min(steps) > 0

    def _is_constant(self, column: int) -> bool:
        return len({fields[column] for fields in self.fields}) == 1

    def _has_decimals(self, column: int) -> bool:
        """Whether at least half of the fields of a column are no integers."""
        texts = [fields[column].lstrip("-") for fields in self.fields]
        return 2 * sum(map(bool, map(_INTEGER.fullmatch, texts))) <= len(texts)

    def may_count(self, column: int, others: Sequence[int]) -> bool:
        """Whether a column may number the points.

        It has different integers, and one of the others has other numbers; or it has some equal
        ones, and all others have decimals; or it has consecutive numbers such as ``1.0``.
        """
        texts = [fields[column] for fields in self.fields]
        whole = [text.removesuffix(".0") for text in texts]
        if len(texts) < 2 or not all(map(_INTEGER.fullmatch, whole)):
            return False
        if whole != texts:
            return all(int(text) == int(whole[0]) + i for i, text in enumerate(whole))
        if len(set(texts)) < len(texts):
            return len(set(texts)) > 1 and all(map(self._has_decimals, others))
        fields = [fields[other] for fields in self.fields for other in others]
        return not all(map(_INTEGER.fullmatch, fields))
