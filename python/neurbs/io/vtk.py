"""Points of VTK data sets: `.vtk`, `.vtp` and `.vtu`, read by VTK."""

from __future__ import annotations

import mmap
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from neurbs._core import NeurbsError
from neurbs.extras import require_for_file
from neurbs.io.point_cloud import BLOCK, Block, PointSource, Request
from neurbs.io.reading import check_size, damaged
from neurbs.io.vtk_legacy_check import check_whole

_READERS = {
    ".vtk": ("vtkmodules.vtkIOLegacy", "vtkGenericDataObjectReader"),
    ".vtp": ("vtkmodules.vtkIOXML", "vtkXMLPolyDataReader"),
    ".vtu": ("vtkmodules.vtkIOXML", "vtkXMLUnstructuredGridReader"),
}

_CLOSING, _TAIL = re.compile(rb"</VTKFile\s*>"), 4096
"""The last tag, and in how many bytes at the end of the file it must be."""

_COUNT = re.compile(rb"\sNumberOf[A-Z]\w{1,30}\s{0,9}=\s{0,9}[\"']\s{0,9}(\d{1,30})")
"""A number of points, of cells or of components."""

_MOST_SHRUNK = 10_000
"""Most values for each byte of a compressed file."""

_COLORS = ("RGB", "RGBA", "Colors", "colors")
"""Names for the colors of points in files of different programs; VTK defines none."""


def read_vtk(path: Path, request: Request) -> PointSource:
    """Read the points of a data set."""
    module, name = _READERS[path.suffix.lower()]
    (check_whole if path.suffix.lower() == ".vtk" else _check_xml)(path)
    reader = getattr(require_for_file(path, module), name)()
    to_numpy = require_for_file(path, "vtkmodules.util.numpy_support").vtk_to_numpy
    reader.SetFileName(str(path))
    if (error := _run(path, reader)) or reader.GetOutputDataObject(0) is None:
        raise damaged(path, error or "VTK finds no data set")
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


def _check_xml(path: Path) -> None:
    """Check that a file ends with its closing tag, and is not too small for its numbers.

    VTK reads files without the closing tag, and allocates memory for numbers of any size.
    """
    with path.open("rb") as file:
        file.seek(max(path.stat().st_size - _TAIL, 0))
        if not _CLOSING.search(file.read()):
            raise damaged(path, "it is cut short, as it does not end with </VTKFile>")
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
            counts = [int(match[1]) for match in _COUNT.finditer(content)]
    check_size(path, max(counts, default=0), 1 / _MOST_SHRUNK, "points or cells")


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
    output = window.GetOutput()
    # VTK returns bytes if they are not UTF-8.
    text = output.decode(errors="replace") if isinstance(output, bytes) else output
    _, is_error, text = text.partition("ERROR: ")
    return text.partition("): ")[2].partition("\n")[0] if is_error else ""
