"""Surfaces from files: round trips, and files of other libraries."""

import importlib.util
import json
import os
import re
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rhino3dm
from geomdl import exchange, multi
from numpy.typing import NDArray
from OCP.Bnd import Bnd_Box
from OCP.BRep import BRep_Tool
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.IGESControl import IGESControl_Controller, IGESControl_Reader, IGESControl_Writer
from OCP.STEPControl import STEPControl_Reader, STEPControl_StepModelType, STEPControl_Writer
from OCP.TopAbs import TopAbs_FACE
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS

import neurbs
from neurbs import NeurbsError, NurbsSurface

if importlib.util.find_spec("OCP.collections") is None:
    pytest.skip("OpenCASCADE 8 needs Python 3.11", allow_module_level=True)

MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, "ft": 304.8}
EVERY = (".json", ".3dm", ".step", ".STP", ".igs", ".iges")
CAD = (".step", ".igs")


def wavy(*, rational: bool, offset: float = 0.0) -> NurbsSurface:
    rng = np.random.default_rng(0)
    x, y = np.meshgrid(np.linspace(0, 300, 9), np.linspace(0, 200, 7), indexing="ij")
    net = np.stack([x, y, 30 * rng.random((9, 7))], axis=-1) + offset
    weights = rng.uniform(0.3, 3, (9, 7)) if rational else None
    return NurbsSurface(net, weights, (3, 2))


def same(ours: NurbsSurface, theirs: NurbsSurface, *, scale: float = 1.0) -> None:
    assert ours.degree == theirs.degree
    for a, b in zip(ours.knots, theirs.knots, strict=True):
        np.testing.assert_array_equal(a, b)
    net = scale * ours.control_points
    np.testing.assert_allclose(
        theirs.control_points, net, rtol=0, atol=3 * np.spacing(np.abs(net).max())
    )
    assert (ours.weights is None) == (theirs.weights is None)
    if ours.weights is not None and theirs.weights is not None:
        np.testing.assert_allclose(theirs.weights, ours.weights, rtol=1e-15, atol=0)


def write_shape(path: Path, shape: Any) -> None:
    """Write a file with OpenCASCADE."""
    if path.suffix == ".step":
        step = STEPControl_Writer()
        step.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
        step.Write(str(path))
    else:
        IGESControl_Controller.Init_s()
        iges = IGESControl_Writer("MM", 1)
        iges.AddShape(shape)
        iges.Write(str(path))


# Round trips


@pytest.mark.parametrize("rational", [False, True])
@pytest.mark.parametrize("suffix", EVERY)
def test_saved_surfaces_are_loaded(tmp_path: Path, suffix: str, rational: bool) -> None:
    path = tmp_path / f"a{suffix}"
    for offset in (0.0, 5e6):
        ours = wavy(rational=rational, offset=offset)
        neurbs.save(ours, path)
        same(ours, neurbs.load_surface(path))
        (theirs,) = neurbs.load_surfaces(str(path))
        same(ours, theirs)


def test_json_keeps_every_bit(tmp_path: Path) -> None:
    ours = wavy(rational=True, offset=5e6)
    neurbs.save(ours, tmp_path / "a.json")
    assert neurbs.load_surface(tmp_path / "a.json") == ours


@pytest.mark.parametrize("unit", MILLIMETRES)
@pytest.mark.parametrize("suffix", [".step", ".igs", ".3dm"])
def test_units_are_written_and_read(tmp_path: Path, suffix: str, unit: str) -> None:
    ours, path = wavy(rational=True), tmp_path / f"a{suffix}"
    neurbs.save(ours, path, unit=unit)
    same(ours, neurbs.load_surface(path))
    same(ours, neurbs.load_surface(path, unit=unit))
    same(ours, neurbs.load_surface(path, unit="m"), scale=MILLIMETRES[unit] / 1000)


@pytest.mark.parametrize("unit", [None, *MILLIMETRES])
@pytest.mark.parametrize("suffix", CAD)
def test_opencascade_sees_the_size_of_every_unit(
    tmp_path: Path, suffix: str, unit: str | None
) -> None:
    """OpenCASCADE converts all units to millimeters."""
    ours, path = wavy(rational=False), tmp_path / f"a{suffix}"
    neurbs.save(ours, path, unit=unit)
    reader = STEPControl_Reader() if suffix == ".step" else IGESControl_Reader()
    assert reader.ReadFile(str(path)) == IFSelect_ReturnStatus.IFSelect_RetDone
    reader.TransferRoots()
    shape = reader.OneShape()
    assert BRepCheck_Analyzer(shape).IsValid()
    box = Bnd_Box()
    BRepBndLib.AddOptimal_s(shape, box, False, False)
    low, high = ours.bounding_box()
    scale = MILLIMETRES[unit or "mm"]
    found = [box.CornerMin(), box.CornerMax()]
    expected = np.array([low, high]) * scale
    np.testing.assert_allclose(
        [[p.X(), p.Y(), p.Z()] for p in found], expected, rtol=0, atol=1e-3 * scale
    )
    faces = TopExp_Explorer(shape, TopAbs_FACE)
    # The tolerance in the file is a millionth of the net's size.
    size = scale * np.linalg.norm(np.ptp(ours.control_points, axis=(0, 1)))
    assert BRep_Tool.Tolerance_s(TopoDS.Face(faces.Current())) <= 1e-6 * size


# Other readers


@pytest.mark.parametrize("rational", [False, True])
def test_geomdl_reads_and_writes_the_same_json(tmp_path: Path, rational: bool) -> None:
    ours = wavy(rational=rational)
    neurbs.save(ours, tmp_path / "a.json")
    (theirs,) = exchange.import_json(str(tmp_path / "a.json"))
    uv = np.random.default_rng(0).random((20, 2))
    np.testing.assert_allclose(
        theirs.evaluate_list(uv.tolist()), ours.evaluate(uv), rtol=0, atol=1e-10
    )
    exchange.export_json(neurbs.to_geomdl(ours), str(tmp_path / "b.json"))
    back = neurbs.load_surface(tmp_path / "b.json")
    np.testing.assert_allclose(back.evaluate(uv), ours.evaluate(uv), rtol=0, atol=1e-10)


def test_several_surfaces_of_geomdl(tmp_path: Path) -> None:
    several = multi.SurfaceContainer()
    for rational in (True, False):
        several.add(neurbs.to_geomdl(wavy(rational=rational)))
    exchange.export_json(several, str(tmp_path / "a.json"))
    assert len(neurbs.load_surfaces(tmp_path / "a.json")) == 2
    with pytest.raises(NeurbsError, match=r"must have one surface, got 2: .* load_surfaces"):
        neurbs.load_surface(tmp_path / "a.json")


@pytest.mark.parametrize("rational", [False, True])
def test_rhino_reads_the_same_surface(tmp_path: Path, rational: bool) -> None:
    ours = wavy(rational=rational)
    neurbs.save(ours, tmp_path / "a.3dm", unit="in")
    model = rhino3dm.File3dm.Read(str(tmp_path / "a.3dm"))
    assert model.Settings.ModelUnitSystem == rhino3dm.UnitSystem.Inches
    (item,) = model.Objects
    theirs = item.Geometry
    assert theirs.IsValid
    assert theirs.IsRational == rational
    uv = np.random.default_rng(0).random((20, 2))
    points = [theirs.PointAt(u, v) for u, v in uv.tolist()]
    np.testing.assert_allclose(
        [[p.X, p.Y, p.Z] for p in points], ours.evaluate(uv), rtol=0, atol=1e-10
    )


def test_solids_of_rhino_give_their_faces(tmp_path: Path) -> None:
    model = rhino3dm.File3dm()
    cylinder = rhino3dm.Cylinder(rhino3dm.Circle(2.0), 5.0)
    model.Objects.AddBrep(rhino3dm.Brep.CreateFromCylinder(cylinder, True, True))
    model.Objects.AddSphere(rhino3dm.Sphere(rhino3dm.Point3d(1, 2, 3), 4.0))
    model.Settings.ModelUnitSystem = rhino3dm.UnitSystem.Meters
    model.Write(str(tmp_path / "a.3dm"), 7)
    with pytest.warns(UserWarning, match="2 of 4 faces are trimmed: the result has"):
        surfaces = neurbs.load_surfaces(tmp_path / "a.3dm")
    areas = [surface.area() for surface in surfaces]
    assert areas[0] == pytest.approx(20 * np.pi)
    assert areas[-1] == pytest.approx(64 * np.pi)


def records(path: Path) -> dict[str, list[list[str]]]:
    """Read the statements of an OBJ file by its specification."""
    found: dict[str, list[list[str]]] = {}
    for line in path.read_text().replace("\\\n", " ").splitlines():
        key, *values = line.split()
        found.setdefault(key, []).append(values)
    return found


@pytest.mark.parametrize("rational", [False, True])
def test_obj_has_the_surface_itself(tmp_path: Path, rational: bool) -> None:
    """Evaluate the surface with geomdl, from the statements of the file."""
    ours = wavy(rational=rational)
    neurbs.save(ours, tmp_path / "a.obj")
    found = records(tmp_path / "a.obj")
    assert found["cstype"] == [["rat", "bspline"] if rational else ["bspline"]]
    assert found["end"] == [[]]
    assert "f" not in found
    (p, q), (surf,) = map(int, found["deg"][0]), found["surf"]
    u, v = ([float(x) for x in parm[1:]] for parm in found["parm"])
    assert [parm[0] for parm in found["parm"]] == ["u", "v"]
    assert [float(x) for x in surf[:4]] == [u[p], u[-p - 1], v[q], v[-q - 1]]
    cols, rows = len(v) - q - 1, len(u) - p - 1
    vertices = np.array(found["v"], float)[np.array(surf[4:], int) - 1]
    net = vertices.reshape(cols, rows, -1).transpose(1, 0, 2)
    theirs = NurbsSurface(net[..., :3], net[..., 3] if rational else None, (p, q), (u, v))
    assert theirs == ours
    uv = np.random.default_rng(0).random((20, 2))
    evaluated = neurbs.to_geomdl(theirs).evaluate_list(uv.tolist())
    np.testing.assert_allclose(evaluated, ours.evaluate(uv), rtol=0, atol=1e-10)


# Faces of other programs


@pytest.mark.parametrize("suffix", CAD)
def test_the_faces_of_a_box_are_six_surfaces(tmp_path: Path, suffix: str) -> None:
    write_shape(tmp_path / f"a{suffix}", BRepPrimAPI_MakeBox(10.0, 20.0, 30.0).Shape())
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        surfaces = neurbs.load_surfaces(tmp_path / f"a{suffix}", unit="cm")
    areas = sorted(surface.area() for surface in surfaces)
    np.testing.assert_allclose(areas, [2, 2, 3, 3, 6, 6], rtol=1e-9)


@pytest.mark.parametrize("suffix", CAD)
def test_trimmed_faces_are_a_warning(tmp_path: Path, suffix: str) -> None:
    box = BRepPrimAPI_MakeBox(10.0, 20.0, 30.0).Shape()
    corner = BRepPrimAPI_MakeCylinder(3.0, 50.0).Shape()
    path = tmp_path / f"a{suffix}"
    write_shape(path, BRepAlgoAPI_Cut(box, corner).Shape())
    with pytest.warns(UserWarning, match="2 of 7 faces are trimmed") as seen:
        surfaces = neurbs.load_surfaces(path)
    assert seen[0].filename == __file__
    # The quarter of a cylinder, 30 high.
    quarter = 0.5 * np.pi * 3 * 30
    assert any(surface.area() == pytest.approx(quarter) for surface in surfaces)


def test_a_periodic_surface_becomes_clamped(tmp_path: Path) -> None:
    cylinder = neurbs.NurbsSurface.cylinder([0, 0, 0], [0, 0, 5], 2.0)
    face = BRepBuilderAPI_MakeFace(neurbs.to_opencascade(cylinder), 1e-7).Face()
    write_shape(tmp_path / "a.step", face)
    surface = neurbs.load_surface(tmp_path / "a.step")
    assert surface.area() == pytest.approx(20 * np.pi)


# Files that cannot be read


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9])
@pytest.mark.parametrize("suffix", [".json", ".3dm", ".step", ".igs"])
def test_a_truncated_file_is_refused(
    tmp_path: Path, suffix: str, share: float, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / f"a{suffix}"
    neurbs.save(wavy(rational=True), path)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(NeurbsError, match=rf"^{re.escape(str(path))}: must .* cut short"):
        neurbs.load_surface(path)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.pop("shape"), "must be a surface as geomdl writes it, but 'shape' is missing"),
        (lambda d: d["shape"].update(type="curve"), "shape of type 'surface', got 'curve'"),
        (lambda d: d["shape"].update(data=[]), "must have at least one surface, but has none"),
        (lambda d: d["shape"]["data"][0].pop("degree_u"), "but 'degree_u' is missing"),
        (lambda d: d["shape"]["data"][0].update(size_u=4), "cannot reshape array"),
        (lambda d: d["shape"]["data"][0].update(knotvector_u=[0, 1]), "knot"),
        (lambda d: d["shape"]["data"][0].update(knotvector_u="abc"), "knot"),
    ],
)
def test_json_of_something_else(tmp_path: Path, change: Callable[[Any], Any], message: str) -> None:
    path = tmp_path / "a.json"
    neurbs.save(wavy(rational=False), path)
    document = json.loads(path.read_text())
    change(document)
    path.write_text(json.dumps(document))
    with pytest.raises(NeurbsError, match=rf"a\.json: .*{message}"):
        neurbs.load_surface(path)


def test_a_trimmed_surface_of_geomdl(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    neurbs.save(wavy(rational=False), path)
    document = json.loads(path.read_text())
    document["shape"]["data"][0]["trims"] = {"count": 1, "data": [{"type": "spline"}]}
    path.write_text(json.dumps(document))
    with pytest.warns(UserWarning, match="1 of 1 faces are trimmed"):
        neurbs.load_surface(path)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"missing\.step"):
        neurbs.load_surface(tmp_path / "missing.step")
    with pytest.raises(IsADirectoryError, match="surfaces are read from a file, not a folder"):
        neurbs.load_surface(tmp_path)
    (tmp_path / "a.obj").touch()
    with pytest.raises(NeurbsError, match=r"suffix of \.json \.3dm .*, got the suffix '\.obj'"):
        neurbs.load_surface(tmp_path / "a.obj")
    neurbs.save(wavy(rational=False), tmp_path / "a.json")
    assert neurbs.load_surface(tmp_path / "a.json", unit="m") == wavy(rational=False)
    with pytest.raises(NeurbsError, match=r"unit must be 'mm' or .*, got 'parsec'"):
        neurbs.load_surface(tmp_path / "a.json", unit="parsec")
    (tmp_path / "locked.json").touch(0)
    if not os.access(tmp_path / "locked.json", os.R_OK):
        with pytest.raises(PermissionError, match=r"locked\.json"):
            neurbs.load_surface(tmp_path / "locked.json")


@pytest.mark.parametrize(("module", "suffix"), [("OCP", ".step"), ("rhino3dm", ".3dm")])
def test_a_missing_library_is_named(
    tmp_path: Path, module: str, suffix: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    neurbs.save(wavy(rational=False), tmp_path / f"a{suffix}")
    monkeypatch.setitem(sys.modules, module, None)
    message = rf"{suffix} files need .*: pip install 'neurbs\[cad\]'"
    with pytest.raises(NeurbsError, match=message):
        neurbs.load_surface(tmp_path / f"a{suffix}")
    if suffix == ".3dm":
        with pytest.raises(NeurbsError, match=message):
            neurbs.save(wavy(rational=False), tmp_path / "b.3dm")
        assert not (tmp_path / "b.3dm").exists()


@pytest.mark.skipif("NEURBS_DATA" not in os.environ, reason="NEURBS_DATA names no folder")
@pytest.mark.parametrize("suffix", EVERY)
def test_a_real_surface_goes_around(tmp_path: Path, suffix: str) -> None:
    points: NDArray[np.float64] = np.load(
        Path(os.environ["NEURBS_DATA"]) / "npy" / "claudius_h000.npy"
    )
    ours = neurbs.reconstruct(points, grid=(20, 20)).surface
    neurbs.save(ours, tmp_path / f"a{suffix}", unit=None if suffix == ".json" else "m")
    same(ours, neurbs.load_surface(tmp_path / f"a{suffix}"))
