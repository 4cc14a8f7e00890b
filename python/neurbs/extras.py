"""Libraries that only some need: the extras of the package."""

import importlib
from types import ModuleType

from neurbs._core import NeurbsError


def require(module: str, *, extra: str, purpose: str) -> ModuleType:
    """Import a library, or say which installation brings it.

    Parameters
    ----------
    module : str
        Name of the module.
    extra : str
        The extra of neurbs that it belongs to.
    purpose : str
        What needs it, as a plural: "pictures".

    Examples
    --------
    >>> from neurbs.extras import require
    >>> require("no_such_library", extra="plot", purpose="pictures")
    Traceback (most recent call last):
    ...
    neurbs.NeurbsError: pictures need no_such_library: pip install 'neurbs[plot]'
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        library = module.partition(".")[0]
        if error.name is None or error.name.partition(".")[0] != library:
            raise
        message = f"{purpose} need {library}: pip install 'neurbs[{extra}]'"
        raise NeurbsError(message) from error
