"""Files that are cut short are errors, whatever the libraries that read them think."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import (
    vtkCellArray,
    vtkPolyData,
    vtkStructuredGrid,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkIOLegacy import (
    vtkPolyDataWriter,
    vtkStructuredGridWriter,
    vtkUnstructuredGridWriter,
)

import neurbs

COUNT = 500


def triangles() -> Any:
    cells = vtkCellArray()
    for first in range(COUNT - 2):
        cells.InsertNextCell(3, (first, first + 1, first + 2))
    return cells


def poly_data() -> tuple[Any, Any]:
    data = vtkPolyData()
    data.SetPolys(triangles())
    return data, vtkPolyDataWriter()


def unstructured_grid() -> tuple[Any, Any]:
    data = vtkUnstructuredGrid()
    data.SetCells(5, triangles())
    return data, vtkUnstructuredGridWriter()


def structured_grid() -> tuple[Any, Any]:
    data = vtkStructuredGrid()
    data.SetDimensions(COUNT // 10, 10, 1)
    return data, vtkStructuredGridWriter()


@pytest.mark.parametrize("version", [42, 51])
@pytest.mark.parametrize("kind", [poly_data, unstructured_grid, structured_grid])
def test_a_vtk_file_that_is_cut_short_is_an_error(
    kind: Callable[[], tuple[Any, Any]], version: int, tmp_path: Path, rng: np.random.Generator
) -> None:
    points = rng.random((COUNT, 3))
    data, writer = kind()
    places = vtkPoints()
    places.SetData(numpy_to_vtk(points, deep=1))
    data.SetPoints(places)
    attributes = data.GetPointData()
    for name, values in {
        "RGB": rng.integers(0, 255, (COUNT, 3)).astype(np.uint8),
        "number": rng.integers(0, 9, COUNT),
    }.items():
        array = numpy_to_vtk(values, deep=1)
        array.SetName(name)
        attributes.AddArray(array)
    attributes.SetNormals(numpy_to_vtk(rng.random((COUNT, 3)), deep=1))
    attributes.SetScalars(numpy_to_vtk(rng.random(COUNT).astype(np.float32), deep=1))
    path = tmp_path / "whole.vtk"
    writer.SetInputData(data)
    writer.SetFileName(str(path))
    writer.SetFileTypeToBinary()
    writer.SetFileVersion(version)
    writer.Write()
    np.testing.assert_array_equal(neurbs.read_points(path), points)
    whole = path.read_bytes()
    cut = tmp_path / "cut.vtk"
    for end in np.linspace(200, len(whole) - 3, 40).astype(int):
        cut.write_bytes(whole[:end])
        with pytest.raises(neurbs.NeurbsError, match="cut short"):
            neurbs.read_points(cut)
