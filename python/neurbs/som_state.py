"""Parameters of a map as plain values that JSON knows, and back."""

from __future__ import annotations

from typing import Any

import numpy as np

from neurbs._core import Lattice


def plain(value: Any) -> Any:
    """Turn a parameter into something that JSON knows."""
    if isinstance(value, Lattice):
        if value.cells is None:
            return {"nodes": value.nodes, "edges": value.edges}
        rows, cols = value.shape
        grid = {"rows": rows, "cols": cols, "cells": value.cells, "topology": value.topology}
        return {"grid": grid}
    if callable(value):
        return {"schedule": ["table", [float(value(share)) for share in np.linspace(0, 1, 4097)]]}
    if isinstance(value, tuple):
        return {"schedule": list(value)}
    if isinstance(value, (str, type(None))):
        return value
    return np.asarray(value).tolist()


def from_plain(value: Any) -> Any:
    """Undo `plain`."""
    if isinstance(value, dict):
        if "grid" in value:
            return Lattice.grid(**value["grid"])
        if "edges" in value:
            return Lattice.graph(value["nodes"], value["edges"])
        return tuple(value["schedule"])
    return np.array(value) if isinstance(value, list) else value
