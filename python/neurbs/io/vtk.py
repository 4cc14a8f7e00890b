"""Points of VTK data sets: `.vtk`, `.vtp`, `.vtu`, `.vti`, `.vts` and `.vtr`, read by VTK."""

from __future__ import annotations

import math
import mmap
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neurbs._core import NeurbsError
from neurbs.extras import require_for_file
from neurbs.io.point_cloud import BLOCK, Block, PointSource, Request
from neurbs.io.reading import check_size, damaged
from neurbs.io.vtk_legacy_check import check_whole

_READERS = {
    ".vtk": ("vtkmodules.vtkIOLegacy", "vtkGenericDataObjectReader"),
    ".vtp": ("vtkmodules.vtkIOXML", "vtkXMLPolyDataReader"),
    ".vtu": ("vtkmodules.vtkIOXML", "vtkXMLUnstructuredGridReader"),
    ".vti": ("vtkmodules.vtkIOXML", "vtkXMLImageDataReader"),
    ".vts": ("vtkmodules.vtkIOXML", "vtkXMLStructuredGridReader"),
    ".vtr": ("vtkmodules.vtkIOXML", "vtkXMLRectilinearGridReader"),
}

_CLOSING, _TAIL = re.compile(rb"</VTKFile\s*>"), 4096
"""The last tag, and in how many bytes at the end of the file it must be."""

_COUNT = re.compile(rb"\sNumberOf[A-Z]\w{1,30}\s{0,9}=\s{0,9}[\"']\s{0,9}(\d{1,30})")
"""A number of points, of cells or of components."""

_MOST_SHRUNK = 10_000
"""Most values for each byte of a compressed file."""

_EXTENT = re.compile(rb"\sWholeExtent\s{0,9}=\s{0,9}[\"']([-+\d\s]{1,200})[\"']")

_FREE_NODES, _MOST_NODES = 10**7, 20
"""Nodes that a grid may have, and more of them for each byte of its file."""

_NODES = ("vtkImageData", "vtkStructuredPoints", "vtkRectilinearGrid", "vtkUniformGrid")
"""Regular grids, whose nodes are no array of points."""

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
    if not hasattr(data, "GetNumberOfPoints"):
        raise NeurbsError(
            f"{path}: must be a data set with points (PolyData, UnstructuredGrid, "
            f"StructuredGrid, ImageData), got {data.GetClassName()}"
        )
    count = data.GetNumberOfPoints()
    if not count:
        raise NeurbsError(f"{path}: must have at least one point, but it is empty")
    points = None if data.GetClassName() in _NODES else to_numpy(data.GetPoints().GetData())
    if points is None:
        _check_nodes(path, count)
    normals = colors = None
    if request.attributes:
        attributes = data.GetPointData()
        found = attributes.GetNormals()
        normals = None if found is None else to_numpy(found)
        found = next(filter(None, map(attributes.GetArray, _COLORS)), None)
        colors = None if found is None else to_numpy(found)[:, :3]

    def blocks() -> Iterator[Block]:
        for start in range(0, count, BLOCK):
            part = slice(start, min(start + BLOCK, count))
            yield Block(
                _nodes(data, part) if points is None else points[part],
                None if normals is None else normals[part],
                None if colors is None else colors[part],
            )

    return PointSource(blocks(), count=count)


def _nodes(data: Any, part: slice) -> NDArray[np.float64]:
    """Return some nodes of a regular grid, x fastest."""
    columns, rows, _ = data.GetDimensions()
    index = np.arange(part.start, part.stop)
    ijk = np.column_stack([index % columns, index // columns % rows, index // (columns * rows)])
    if data.GetClassName() == "vtkRectilinearGrid":
        axes = (data.GetXCoordinates(), data.GetYCoordinates(), data.GetZCoordinates())
        places = [[axis.GetTuple1(i) for i in range(axis.GetNumberOfTuples())] for axis in axes]
        return np.column_stack([np.array(p)[i] for p, i in zip(places, ijk.T, strict=True)])
    matrix = data.GetIndexToPhysicalMatrix()
    full = np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(3)])
    low = np.array(data.GetExtent()[::2])
    nodes: NDArray[np.float64] = (ijk + low) @ full[:, :3].T + full[:, 3]
    return nodes


def _check_nodes(path: Path, count: int) -> None:
    """Check that a grid has no more nodes than its file can have values for."""
    most = _FREE_NODES + _MOST_NODES * path.stat().st_size
    if count > most:
        raise NeurbsError(f"{path}: a grid in a file of this size must have at most {most} nodes")


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
            extents = [match[1].split() for match in _EXTENT.finditer(content)]
    for extent in extents:
        ends = list(map(int, extent))
        sizes = [high - low + 1 for low, high in zip(ends[::2], ends[1::2], strict=True)]
        _check_nodes(path, math.prod(sizes))
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
