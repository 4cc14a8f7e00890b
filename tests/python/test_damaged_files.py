"""Files that are cut short, or refer to other files."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rasterio
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


def test_a_raster_does_not_lead_to_another_file(tmp_path: Path, rng: np.random.Generator) -> None:
    secret = tmp_path / "secret.tif"
    shape = {"height": 8, "width": 9, "count": 1, "dtype": "float64"}
    transform = rasterio.transform.from_origin(0, 8, 1, 1)
    with rasterio.open(secret, "w", driver="GTiff", transform=transform, **shape) as file:
        file.write(rng.random((8, 9)), 1)
    assert len(neurbs.read_points(secret)) == 72
    leading = tmp_path / "leading.tif"
    leading.write_text(
        f"""<VRTDataset rasterXSize="9" rasterYSize="8"><VRTRasterBand dataType="Float64" band="1">
        <SimpleSource><SourceFilename relativeToVRT="0">{secret}</SourceFilename>
        <SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>"""
    )
    with pytest.raises(neurbs.NeurbsError, match="must be a complete GeoTIFF"):
        neurbs.read_points(leading)
