"""Points of VTK data sets: `.vtk`, `.vtp` and `.vtu`, read by VTK."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from neurbs._core import NeurbsError
from neurbs.extras import require_for_file
from neurbs.io.point_cloud import BLOCK, Block, PointSource, Request
from neurbs.io.vtk_legacy_check import check_whole

_READERS = {
    ".vtk": ("vtkmodules.vtkIOLegacy", "vtkGenericDataObjectReader"),
    ".vtp": ("vtkmodules.vtkIOXML", "vtkXMLPolyDataReader"),
    ".vtu": ("vtkmodules.vtkIOXML", "vtkXMLUnstructuredGridReader"),
}

_COLORS = ("RGB", "RGBA", "Colors", "colors")
"""Names for the colors of points in files of different programs; VTK defines none."""


def read_vtk(path: Path, request: Request) -> PointSource:
    """Read the points of a data set."""
    module, name = _READERS[path.suffix.lower()]
    if path.suffix.lower() == ".vtk":
        check_whole(path)
    reader = getattr(require_for_file(path, module), name)()
    to_numpy = require_for_file(path, "vtkmodules.util.numpy_support").vtk_to_numpy
    reader.SetFileName(str(path))
    if (error := _run(path, reader)) or reader.GetOutputDataObject(0) is None:
        raise NeurbsError(
            f"{path}: must be a complete VTK file, but is damaged or cut short: {error}"
        )
    data = reader.GetOutputDataObject(0)
    if not hasattr(data, "GetPoints") or data.GetPoints() is None:
        raise NeurbsError(
            f"{path}: must be a data set with points (PolyData, UnstructuredGrid, "
            f"StructuredGrid), got {data.GetClassName()}"
        )
    points = to_numpy(data.GetPoints().GetData())
    normals = colors = None
    if request.attributes:
        attributes = data.GetPointData()
        found = attributes.GetNormals()
        normals = None if found is None else to_numpy(found)
        found = next(filter(None, map(attributes.GetArray, _COLORS)), None)
        colors = None if found is None else to_numpy(found)[:, :3]

    def blocks() -> Iterator[Block]:
        for start in range(0, len(points), BLOCK):
            part = slice(start, start + BLOCK)
            yield Block(
                points[part],
                None if normals is None else normals[part],
                None if colors is None else colors[part],
            )

    return PointSource(blocks(), count=len(points))


def _run(path: Path, reader: Any) -> str:
    """Run a reader and return its first error message, which VTK would only print."""
    core = require_for_file(path, "vtkmodules.vtkCommonCore")
    window, before = core.vtkStringOutputWindow(), core.vtkOutputWindow.GetInstance()
    logger = core.vtkLogger
    core.vtkOutputWindow.SetInstance(window)
    logger.SetStderrVerbosity(logger.VERBOSITY_OFF)
    try:
        reader.Update()
    finally:
        logger.SetStderrVerbosity(logger.VERBOSITY_INFO)
        core.vtkOutputWindow.SetInstance(before)
    # "ERROR: In <file>, line <n>\n<reader> (<address>): <message>\n..."
    _, is_error, text = window.GetOutput().partition("ERROR: ")
    return text.partition("): ")[2].partition("\n")[0] if is_error else ""
