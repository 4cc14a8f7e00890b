"""Points as a CSV table."""

from __future__ import annotations

import re
from typing import Any

from numpy.typing import NDArray

from neurbs.io.point_cloud import PointCloud
from neurbs.io.row_blocks import row_blocks
from neurbs.io.units import of_axes

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9 ]*")
"""Names of units that need no quotes."""


def write_csv(cloud: PointCloud, path: str) -> None:
    """Write points and their attributes with all digits; the header has the units in brackets."""
    units = of_axes(cloud.unit or "")
    known = all(map(_NAME.fullmatch, units))
    axes = ",".join(
        f"{axis} [{unit}]" if known else axis for axis, unit in zip("xyz", units, strict=True)
    )
    tables: dict[str, NDArray[Any]] = {axes: cloud.points}
    if cloud.normals is not None:
        tables["nx,ny,nz"] = cloud.normals
    if cloud.colors is not None:
        tables["red,green,blue"] = cloud.colors
    if cloud.distances is not None:
        tables["distance"] = cloud.distances[:, None]
    with open(path, "w", encoding="ascii", newline="\n") as file:
        file.write(",".join(tables) + "\n")
        for part in row_blocks(len(cloud)):
            # By columns, because integers and real numbers are formatted differently.
            columns = [column for table in tables.values() for column in table[part].T.tolist()]
            file.writelines(",".join(map(repr, row)) + "\n" for row in zip(*columns, strict=True))
