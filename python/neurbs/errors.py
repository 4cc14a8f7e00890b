"""Messages of errors."""

import re

from neurbs._core import NeurbsError

_UNSEEN = re.compile("[\x00-\x1f\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069]")
"""Control characters, among them those that change the direction of the text."""


def printable(text: str) -> str:
    r"""Escape control characters, which could change what a terminal shows.

    Examples
    --------
    >>> from neurbs.errors import printable
    >>> print(printable("scan\x1b[2J.csv"))
    scan\x1b[2J.csv
    """
    return _UNSEEN.sub(lambda match: match[0].encode("unicode_escape").decode(), text)


def argument_error(argument: str, requirement: str) -> NeurbsError:
    """Return the error about the value of an argument.

    Parameters
    ----------
    argument : str
        Name of the argument; the error has it as its attribute `argument`.
    requirement : str
        The message after that name: "must be ..., got ...".

    Examples
    --------
    >>> from neurbs.errors import argument_error
    >>> error = argument_error("share", "must be a number from 0 to 1, got 2")
    >>> str(error), error.argument
    ('share must be a number from 0 to 1, got 2', 'share')
    """
    error = NeurbsError(f"{argument} {requirement}")
    error.argument = argument
    return error
