"""The hypotheses about a surface, each with its score."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable
from typing import Any

from numpy.typing import ArrayLike

from neurbs import _core
from neurbs.choices import KindChoice


@dataclasses.dataclass(frozen=True)
class Candidate:
    """A hypothesis about the surface, with its score and outcome.

    Attributes
    ----------
    chart : str
        The chart: the method that gives each point its parameters (u, v).
    kind : {"height", "sheet", "tube", "torus"}
        The kind of surface.
    direction : (float, float, float) or None
        For a height field the direction of the heights.
    score : float or None
        The score; the lowest wins. None if it was not computed.
    terms : dict of str to float
        The weighted terms whose sum is the score.
    rank : int or None
        Place in the ranking from 1; None without a score.
    outcome : str
        ``"chosen"``, or the reason why it was not.
    """

    chart: str
    kind: str
    direction: tuple[float, float, float] | None
    score: float | None
    terms: dict[str, float] = dataclasses.field(repr=False, hash=False)
    rank: int | None
    outcome: str


def of_core(found: Iterable[dict[str, Any]]) -> tuple[Candidate, ...]:
    """Convert candidates from the core."""
    return tuple(Candidate(**candidate) for candidate in found)


COLUMNS = ("rank", "chart", "kind", "score", "outcome")
"""The columns of `rows`."""


def rows(candidates: Iterable[Candidate]) -> list[tuple[str, str, str, str, str]]:
    """Return the cells of a table of candidates."""
    return [
        (
            "–" if one.rank is None else str(one.rank),
            one.chart,
            one.kind,
            "–" if one.score is None else f"{one.score:.3f}",
            one.outcome,
        )
        for one in candidates
    ]


def table(candidates: Iterable[Candidate]) -> str:
    """Return a table of candidates as text, one line each."""
    texts = rows(candidates)
    widths = [max(map(len, column)) for column in zip(*texts, strict=True)]
    lines = (
        "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True))
        for row in texts
    )
    return "\n".join(line.rstrip() for line in lines)


def candidates(
    points: ArrayLike,
    kind: KindChoice = "auto",
    *,
    progress: Callable[[_core.Progress], object] | None = None,
) -> list[Candidate]:
    """Rank the hypotheses about the surface of points, without a final fit.

    Parameters
    ----------
    points : array_like of shape (n, 3) or (n, 2)
        At least four distinct points, finite, not all on one line.
    kind : {"auto", "sheet", "height", "tube", "torus"}, default "auto"
        The kind of surface, if it is known.
    progress : callable, optional
        Called some 25 times a second with a `Progress`. An exception that it raises ends the job.

    Returns
    -------
    list of Candidate
        The hypotheses, the best first.

    Raises
    ------
    NeurbsError
        If no surface fits the points (fewer than four distinct ones, or all on one line), or the
        kind is unknown.

    Examples
    --------
    >>> import numpy as np
    >>> import neurbs
    >>> turns, z = np.random.default_rng(0).random((2, 2000))
    >>> angle = 2 * np.pi * turns
    >>> found = neurbs.candidates(np.column_stack([np.cos(angle), np.sin(angle), 3 * z]))
    >>> found[0].kind, found[0].outcome
    ('tube', 'chosen')
    """
    return list(of_core(_core.candidates(points, kind, progress)))
