"""Errors about the value of one argument."""

from neurbs._core import NeurbsError


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
