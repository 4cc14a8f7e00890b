"""Old names: the error for each gives the new name."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Any, TypeVar

_NEW = {
    "module 'neurbs'": {
        "Pieces": "neurbs.Components",
        "Topology": "neurbs.Candidate",
        "detect_topology": "neurbs.candidates",
        "free_weights": "neurbs.fit_weights",
        "inspect": "neurbs.validate",
        "pieces": "neurbs.components",
    },
    "reconstruct()": {
        "topology": "kind",
        "pieces": "component",
        "method": "neurbs.reconstruct_paper",
        "surface": "neurbs.reconstruct_paper(surface=...)",
        "max_steps": "neurbs.reconstruct_paper(max_steps=...)",
        "reach": "neurbs.reconstruct_paper(reach=...)",
        "min_change": "neurbs.reconstruct_paper(min_change=...)",
    },
    "'Reconstruction' object": {"distances": "deviations"},
    "'Report' object": {
        "topology": "kind",
        "topology_reason": "candidates",
        "warnings": "diagnostics",
    },
}
"""For each owner its old names and the new ones."""

Function = TypeVar("Function", bound=Callable[..., Any])


def missing_attribute(owner: str, name: str) -> AttributeError:
    """Return the error for an attribute that does not exist."""
    new = _NEW[owner].get(name)
    hint = f": it is now {new}" if new else ""
    return AttributeError(f"{owner} has no attribute {name!r}{hint}")


def without_old_keywords(function: Function) -> Function:
    """Make a function raise for an old keyword, with an error that gives the new one."""
    owner = f"{function.__name__}()"
    known = inspect.signature(function).parameters
    old = {name: new for name, new in _NEW[owner].items() if name not in known}

    @functools.wraps(function)
    def checked(*args: Any, **kwargs: Any) -> Any:
        for name in kwargs:
            if name in old:
                raise TypeError(
                    f"{owner} got an unexpected keyword argument {name!r}: it is now {old[name]}"
                )
        return function(*args, **kwargs)

    return checked  # type: ignore[return-value]
