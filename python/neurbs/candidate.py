"""The hypotheses among which a surface is chosen."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable
from typing import Any

from numpy.typing import ArrayLike

from neurbs import _core


@dataclasses.dataclass(frozen=True)
class Candidate:
    """A hypothesis about the surface, its score, and what became of it.

    Attributes
    ----------
    chart : str
        The chart that put the points on a parameter domain.
    kind : {"height", "sheet", "tube", "torus"}
        The kind of surface.
    direction : (float, float, float) or None
        The direction of the heights, of a height field.
    score : float or None
        The score, the lowest of which wins; None if it was not computed.
    terms : dict of str to float
        The weighted terms whose sum is the score.
    rank : int or None
        Place in the ranking, the first being 1; None without a score.
    outcome : str
        ``"chosen"``, or why it lost.
    """

    chart: str
    kind: str
    direction: tuple[float, float, float] | None
    score: float | None
    terms: dict[str, float] = dataclasses.field(repr=False, hash=False)
    rank: int | None
    outcome: str


def of_core(found: Iterable[dict[str, Any]]) -> tuple[Candidate, ...]:
    """Wrap the candidates of the core."""
    return tuple(Candidate(**candidate) for candidate in found)


COLUMNS = ("rank", "chart", "kind", "score", "outcome")
"""The columns of `rows`."""


def rows(candidates: Iterable[Candidate]) -> list[tuple[str, str, str, str, str]]:
    """Return the table of candidates as texts."""
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
    """Return the table of candidates, a line for each, in columns."""
    texts = rows(candidates)
    widths = [max(map(len, column)) for column in zip(*texts, strict=True)]
    lines = (
        "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True))
        for row in texts
    )
    return "\n".join(line.rstrip() for line in lines)


def candidates(
    points: ArrayLike,
    kind: str = "auto",
    *,
    progress: Callable[[_core.Progress], object] | None = None,
) -> list[Candidate]:
    """Rank the hypotheses about points, without the fit of the final surface.

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
        If the points cannot be a surface, or the kind is unknown.

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
