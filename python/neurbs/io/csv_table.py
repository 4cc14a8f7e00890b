"""Points as a CSV table."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from neurbs.io.point_cloud import PointCloud
from neurbs.io.row_blocks import row_blocks


def write_csv(cloud: PointCloud, path: str) -> None:
    """Write points and their attributes with a header and all digits."""
    tables: dict[str, NDArray[Any]] = {"x,y,z": cloud.points}
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
