"""Libraries that only some need: the extras of the package."""

import importlib
from types import ModuleType

from neurbs._core import NeurbsError
from neurbs.io.extras import EXTRAS


def require(module: str, purpose: str) -> ModuleType:
    """Import a library of an extra, or say which installation brings it.

    Parameters
    ----------
    module : str
        Name of the module.
    purpose : str
        What needs it, as a plural: "pictures".

    Examples
    --------
    >>> from neurbs.extras import require
    >>> require("matplotlib", "pictures").__name__
    'matplotlib'
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        library = module.partition(".")[0]
        if (error.name or "").partition(".")[0] != library:
            raise
        package, extra = EXTRAS[library]
        message = f"{purpose} need {package}: pip install 'neurbs[{extra}]'"
        raise NeurbsError(message) from None
