"""Words that the shell completes after an option."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import PurePath


def of_words(*words: str) -> Callable[[str], list[str]]:
    """Return a completion by one of several words."""

    def complete(incomplete: str) -> list[str]:
        return [word for word in words if word.startswith(incomplete)]

    return complete


def of_suffixes(*suffixes: str) -> Callable[[str], list[str]]:
    """Return a completion of file names by a suffix; names without a dot are left to the shell."""

    def complete(incomplete: str) -> list[str]:
        name, dot, _ = incomplete.rpartition(".")
        if not dot or not PurePath(name).name:
            return []
        return [name + suffix for suffix in suffixes if (name + suffix).startswith(incomplete)]

    return complete
