"""A map and the state of its training in a NumPy archive."""

from __future__ import annotations

import json
import os
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from neurbs._core import BatchSums, Lattice, Map, NeurbsError
from neurbs.io.atomic_write import atomic_write


def write_archive(
    path: str | os.PathLike[str],
    parameters: dict[str, Any],
    trained: Map,
    pending: BatchSums | None,
    stream_state: dict[str, Any] | None,
) -> None:
    """Write parameters, map, sums of an unfinished epoch and state of a stream to an archive."""
    plain_parameters = {name: plain(value) for name, value in parameters.items()}
    arrays = {
        "codebook": trained.codebook,
        "parameters": np.array(json.dumps(plain_parameters)),
        "state": np.frombuffer(trained.to_bytes(), dtype=np.uint8),
        "sums": np.frombuffer(b"" if pending is None else pending.to_bytes(), dtype=np.uint8),
        "drawn": np.array(json.dumps(stream_state)),
    }
    with atomic_write(Path(path)) as new, open(new, "wb") as file:
        np.savez(file, allow_pickle=False, **arrays)


def read_archive(
    path: str | os.PathLike[str],
) -> tuple[dict[str, Any], Map, BatchSums | None, dict[str, Any] | None]:
    """Read an archive that `write_archive` has written."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            parameters = json.loads(str(archive["parameters"]))
            state, sums = archive["state"].tobytes(), archive["sums"].tobytes()
            stream_state = json.loads(str(archive["drawn"]))
    except (ValueError, KeyError, EOFError, AttributeError, zipfile.BadZipFile) as error:
        message = f"{os.fspath(path)} must be a map that SelfOrganizingMap.save wrote: {error}"
        raise NeurbsError(message) from error
    values = {name: from_plain(value) for name, value in parameters.items()}
    pending = BatchSums.from_bytes(sums) if sums else None
    return values, Map.from_bytes(state), pending, stream_state


def plain(value: Any) -> Any:
    """Convert a parameter to a value for JSON."""
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
    """Convert a value from JSON to a parameter, the inverse of `plain`."""
    if isinstance(value, dict):
        if "grid" in value:
            return Lattice.grid(**value["grid"])
        if "edges" in value:
            return Lattice.graph(value["nodes"], value["edges"])
        return tuple(value["schedule"])
    return np.array(value) if isinstance(value, list) else value
