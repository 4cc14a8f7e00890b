"""Shells from STEP and IGES files of OpenCASCADE."""

import importlib.util
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rhino3dm

import neurbs
from neurbs import Face, NeurbsError, Shell

if importlib.util.find_spec("OCP.collections") is None:
    pytest.skip("OpenCASCADE 8 needs Python 3.11", allow_module_level=True)

from OCP.BRep import BRep_Builder
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_Transform
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
from OCP.BRepGProp import BRepGProp
from OCP.BRepPrimAPI import (
    BRepPrimAPI_MakeBox,
    BRepPrimAPI_MakeCone,
    BRepPrimAPI_MakeCylinder,
    BRepPrimAPI_MakeSphere,
    BRepPrimAPI_MakeTorus,
)
from OCP.gp import gp_Ax1, gp_Ax2, gp_Dir, gp_Pnt, gp_Trsf, gp_Vec
from OCP.GProp import GProp_GProps
from OCP.IGESCAFControl import IGESCAFControl_Writer
from OCP.IGESControl import IGESControl_Controller
from OCP.Interface import Interface_Static
from OCP.Quantity import Quantity_Color, Quantity_TypeOfColor
from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_StepModelType
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name
from OCP.TDocStd import TDocStd_Document
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_State
from OCP.TopExp import TopExp
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Compound
from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool

CAD = (".step", ".igs")
Color = tuple[float, float, float]
InnerPoint = Callable[[Face], tuple[Any, Any]]


# Shapes of OpenCASCADE


def along(axis: tuple[float, float, float], *origin: float) -> Any:
    return gp_Ax2(gp_Pnt(*origin), gp_Dir(*axis))


def box() -> Any:
    return BRepPrimAPI_MakeBox(10.0, 20.0, 30.0).Shape()


def drilled() -> Any:
    hole = BRepPrimAPI_MakeCylinder(along((0, 0.2, 1), 5, 8, -5), 3.0, 50.0).Shape()
    return BRepAlgoAPI_Cut(box(), hole).Shape()


def rounded() -> Any:
    shape = box()
    maker = BRepFilletAPI_MakeFillet(shape)
    for edge in sub_shapes(shape, TopAbs_EDGE):
        maker.Add(2.0, TopoDS.Edge(edge))
    return maker.Shape()


def crossed() -> Any:
    """Return a cylinder with a hole across: curves that are no isocurves."""
    tube = BRepPrimAPI_MakeCylinder(5.0, 20.0).Shape()
    hole = BRepPrimAPI_MakeCylinder(along((1, 0, 0), -10, 1, 10), 3.0, 30.0).Shape()
    return BRepAlgoAPI_Cut(tube, hole).Shape()


def slanted() -> Any:
    """Return a torus that a slanted plane cuts."""
    half = BRepPrimAPI_MakeBox(along((1, 0.3, 1), 0, 0, 0.1), 50.0, 50.0, 50.0).Shape()
    return BRepAlgoAPI_Cut(BRepPrimAPI_MakeTorus(4.0, 1.0).Shape(), half).Shape()


def bored() -> Any:
    """Return a ball with a hole beside its axis."""
    hole = BRepPrimAPI_MakeCylinder(along((0, 0, 1), 1, 0, -10), 2.0, 20.0).Shape()
    return BRepAlgoAPI_Cut(BRepPrimAPI_MakeSphere(5.0).Shape(), hole).Shape()


def moved(shape: Any) -> Any:
    """Return a shape far away, turned."""
    turn, shift = gp_Trsf(), gp_Trsf()
    turn.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(1, 2, 3)), 0.7)
    shift.SetTranslation(gp_Vec(100, -50, 20))
    return BRepBuilderAPI_Transform(shape, shift.Multiplied(turn)).Shape()


SHAPES: dict[str, tuple[Callable[[], Any], int]] = {
    "box": (box, 2),
    "drilled": (drilled, 0),
    "rounded": (rounded, 2),
    "ball": (lambda: BRepPrimAPI_MakeSphere(2.0).Shape(), 2),
    "torus": (lambda: BRepPrimAPI_MakeTorus(4.0, 1.0).Shape(), 0),
    "rod": (lambda: BRepPrimAPI_MakeCylinder(2.0, 5.0).Shape(), 2),
    "cone": (lambda: BRepPrimAPI_MakeCone(3.0, 0.0, 5.0).Shape(), 2),
    "frustum": (lambda: BRepPrimAPI_MakeCone(3.0, 1.0, 5.0).Shape(), 2),
    "wedge": (lambda: BRepPrimAPI_MakeCylinder(2.0, 5.0, 4.0).Shape(), 2),
    "crossed": (crossed, 0),
    "slanted": (slanted, 2),
    "bored": (bored, 0),
    "moved": (lambda: moved(crossed()), 0),
}
"""Closed shapes, with their Euler characteristic."""


def sub_shapes(shape: Any, kind: Any) -> list[Any]:
    """Return each sub-shape once."""
    from OCP.collections import IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher

    found = IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher()
    TopExp.MapShapes_s(shape, kind, found)
    return [found.FindKey(k + 1) for k in range(found.Extent())]


def document(shapes: list[tuple[Any, str | None, Color | None]]) -> Any:
    """Return a document of shapes with names and colors."""
    made = TDocStd_Document(TCollection_ExtendedString("XCAF"))
    shape_tool = XCAFDoc_DocumentTool.ShapeTool_s(made.Main())
    for shape, name, color in shapes:
        label = shape_tool.AddShape(shape, False)
        if name is not None:
            TDataStd_Name.Set_s(label, TCollection_ExtendedString(name))
        if color is not None:
            paint(made, label, color)
    return made


def paint(made: Any, target: Any, color: Color) -> None:
    tool = XCAFDoc_DocumentTool.ColorTool_s(made.Main())
    theirs = Quantity_Color(*color, Quantity_TypeOfColor.Quantity_TOC_sRGB)
    tool.SetColor(target, theirs, XCAFDoc_ColorType.XCAFDoc_ColorSurf)


def write(path: Path, made: Any, unit: str = "MM") -> None:
    """Write a document with OpenCASCADE, IGES as solids."""
    step = path.suffix == ".step"
    if step:
        writer = STEPCAFControl_Writer()
        Interface_Static.SetCVal_s("write.step.unit", unit)
        writer.Transfer(made, STEPControl_StepModelType.STEPControl_AsIs)
    else:
        IGESControl_Controller.Init_s()
        Interface_Static.SetIVal_s("write.iges.brep.mode", 1)
        Interface_Static.SetCVal_s("write.iges.unit", unit)
        writer = IGESCAFControl_Writer()
        writer.Transfer(made)
        writer.ComputeModel()
    try:
        writer.Write(str(path))
    finally:
        Interface_Static.SetCVal_s("write.step.unit", "MM")
        Interface_Static.SetCVal_s("write.iges.unit", "MM")


def written(path: Path, shape: Any) -> Path:
    write(path, document([(shape, None, None)]))
    return path


def without_warnings(path: Path, **options: Any) -> Shell:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return neurbs.load_shell(path, **options)


# Faces, edges and orientation


@pytest.mark.parametrize("suffix", CAD)
@pytest.mark.parametrize("name", SHAPES)
def test_a_solid_is_closed_with_normals_outward(
    tmp_path: Path, name: str, suffix: str, inner_point: InnerPoint
) -> None:
    make, characteristic = SHAPES[name]
    shape = make()
    shell = without_warnings(written(tmp_path / f"a{suffix}", shape))
    assert shell.is_closed
    assert shell.euler_characteristic == characteristic
    assert shell.unit == "mm"
    faces = sub_shapes(shape, TopAbs_FACE)
    assert len(shell.faces) == len(faces)
    lengths = sum(edge.curve.length() for edge in shell.edges)
    expected = 0.0
    for edge in sub_shapes(shape, TopAbs_EDGE):
        properties = GProp_GProps()
        BRepGProp.LinearProperties_s(edge, properties)
        expected += properties.Mass()
    assert lengths == pytest.approx(expected, rel=1e-6)
    classifier = BRepClass3d_SolidClassifier(shape)
    for face in shell.faces:
        point, normal = inner_point(face)
        for side, state in ((1, TopAbs_State.TopAbs_OUT), (-1, TopAbs_State.TopAbs_IN)):
            there = point + side * 1e-3 * normal
            classifier.Perform(gp_Pnt(*there.tolist()), 1e-7)
            assert classifier.State() == state


@pytest.mark.parametrize("suffix", CAD)
@pytest.mark.parametrize("name", SHAPES)
def test_area_and_volume_are_those_of_opencascade(tmp_path: Path, name: str, suffix: str) -> None:
    shape = SHAPES[name][0]()
    shell = neurbs.load_shell(written(tmp_path / f"a{suffix}", shape))
    area, volume = GProp_GProps(), GProp_GProps()
    BRepGProp.SurfaceProperties_s(shape, area, 1e-9)
    BRepGProp.VolumeProperties_s(shape, volume, 1e-9)
    assert shell.area() == pytest.approx(area.Mass(), rel=1e-6)
    assert shell.volume() == pytest.approx(volume.Mass(), rel=1e-6)


@pytest.mark.parametrize("suffix", CAD)
def test_whole_surfaces_are_not_trimmed(tmp_path: Path, suffix: str) -> None:
    for name, trimmed in (("ball", 0), ("torus", 0), ("box", 0), ("rod", 2), ("drilled", 3)):
        shape = SHAPES[name][0]()
        shell = neurbs.load_shell(written(tmp_path / f"{name}{suffix}", shape))
        assert sum(face.is_trimmed for face in shell.faces) == trimmed
    holes = sorted(len(face.inner) for face in shell.faces)
    assert holes == [0, 0, 0, 0, 0, 1, 1]


def test_a_reversed_face_has_opposite_normals(tmp_path: Path, inner_point: InnerPoint) -> None:
    """Only STEP: OpenCASCADE writes no orientation of a single face in IGES files."""
    face = TopoDS.Face(sub_shapes(box(), TopAbs_FACE)[0])
    normals = []
    for k, shape in enumerate((face, face.Reversed())):
        shell = neurbs.load_shell(written(tmp_path / f"{k}.step", shape))
        normals.append(inner_point(shell.faces[0])[1])
    np.testing.assert_allclose(normals, [[-1, 0, 0], [1, 0, 0]], atol=1e-12)


@pytest.mark.parametrize("unit", ["MM", "CM", "M", "INCH", "FT"])
@pytest.mark.parametrize("suffix", CAD)
def test_units(tmp_path: Path, suffix: str, unit: str) -> None:
    path = tmp_path / f"a{suffix}"
    write(path, document([(box(), None, None)]), unit)
    shell = neurbs.load_shell(path)
    assert shell.unit == {"INCH": "in"}.get(unit, unit.lower())
    in_meters = neurbs.load_shell(path, unit="m")
    assert in_meters.unit == "m"
    size = np.ptp(in_meters.vertices, axis=0)
    np.testing.assert_allclose(size, [0.01, 0.02, 0.03], rtol=1e-8)


# Names, colors, assemblies


@pytest.mark.parametrize("suffix", CAD)
def test_colors_of_solids_and_faces(tmp_path: Path, suffix: str) -> None:
    shape = box()
    made = document([(shape, "block", (0.2, 0.4, 0.6))])
    paint(made, sub_shapes(shape, TopAbs_FACE)[2], (1.0, 0.0, 0.0))
    write(tmp_path / f"a{suffix}", made)
    shell = neurbs.load_shell(tmp_path / f"a{suffix}")
    colors = sorted(np.round(face.color or (), 5).tolist() for face in shell.faces)
    assert colors == [[0.2, 0.4, 0.6]] * 5 + [[1.0, 0.0, 0.0]]


def test_an_assembly_has_its_parts_in_their_places(tmp_path: Path) -> None:
    made = TDocStd_Document(TCollection_ExtendedString("XCAF"))
    tool = XCAFDoc_DocumentTool.ShapeTool_s(made.Main())
    assembly = tool.NewShape()
    parts = {"bolt": BRepPrimAPI_MakeSphere(1.0).Shape(), "block": box()}
    places = {"bolt": [(0, 0, 100), (0, 50, 0)], "block": [(7, 0, 0)]}
    for name, shape in parts.items():
        label = tool.AddShape(shape, False)
        TDataStd_Name.Set_s(label, TCollection_ExtendedString(name))
        for k, place in enumerate(places[name]):
            move = gp_Trsf()
            move.SetTranslation(gp_Vec(*place))
            component = tool.AddComponent(assembly, label, TopLoc_Location(move))
            if name == "bolt":
                paint(made, component, (float(k), 1.0, 0.0))
    tool.UpdateAssemblies()
    write(tmp_path / "a.step", made)
    shell = without_warnings(tmp_path / "a.step")
    assert shell.is_closed
    assert shell.euler_characteristic == 6
    assert sorted({face.name or "" for face in shell.faces}) == ["block", "bolt"]
    bolts = [face for face in shell.faces if face.name == "bolt"]
    middles = [np.mean(face.surface.bounding_box(), axis=0).round(9).tolist() for face in bolts]
    assert sorted(middles) == [[0, 0, 100], [0, 50, 0]]
    found = {tuple(m): face.color for m, face in zip(middles, bolts, strict=True)}
    assert found[0, 0, 100] == pytest.approx((0, 1, 0), abs=1e-5)
    assert found[0, 50, 0] == pytest.approx((1, 1, 0), abs=1e-5)
    low, high = shell.vertices.min(axis=0), shell.vertices.max(axis=0)
    np.testing.assert_allclose([low, high], [[0, 0, -1], [17, 51, 101]], atol=51)


def test_names_of_faces(tmp_path: Path) -> None:
    path = written(tmp_path / "a.step", box())
    text = path.read_text()
    assert "ADVANCED_FACE(''" in text
    path.write_text(text.replace("ADVANCED_FACE(''", "ADVANCED_FACE('lid'", 1))
    names = [face.name for face in neurbs.load_shell(path).faces]
    assert sorted(names, key=str) == [None] * 5 + ["lid"]


# Damage, faces that cannot be read


def test_a_file_of_many_faces(tmp_path: Path) -> None:
    holes, builder = TopoDS_Compound(), BRep_Builder()
    builder.MakeCompound(holes)
    for row in range(10):
        for column in range(20):
            origin = (6 + 9.8 * column, 6 + 11.9 * row, -1)
            hole = BRepPrimAPI_MakeCylinder(along((0, 0.05, 1), *origin), 2.5, 20.0).Shape()
            builder.Add(holes, hole)
    plate = BRepPrimAPI_MakeBox(200.0, 130.0, 8.0).Shape()
    path = written(tmp_path / "a.step", BRepAlgoAPI_Cut(plate, holes).Shape())
    shell = neurbs.load_shell(path)
    assert shell.is_closed
    assert len(shell.faces) == 206
    assert shell.euler_characteristic == 2 - 2 * 200


@pytest.mark.parametrize("suffix", CAD)
def test_a_file_cut_anywhere_is_refused(
    tmp_path: Path, suffix: str, refuse_cuts: Callable[[Path], None]
) -> None:
    refuse_cuts(written(tmp_path / f"a{suffix}", drilled()))


def test_a_file_without_faces_says_what_it_has(tmp_path: Path) -> None:
    edge = BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 0), gp_Pnt(1, 1, 1)).Edge()
    for suffix in CAD:
        path = written(tmp_path / f"a{suffix}", edge)
        with pytest.raises(NeurbsError, match=r"at least one face, but has only 1 curve$"):
            neurbs.load_shell(path)


@pytest.mark.parametrize("name", ["drilled", "rounded", "crossed", "slanted", "bored"])
def test_solids_of_opencascade_become_valid_polysurfaces(tmp_path: Path, name: str) -> None:
    shape = SHAPES[name][0]()
    shell = neurbs.load_shell(written(tmp_path / "a.step", shape))
    neurbs.save(shell, tmp_path / "a.3dm")
    model = rhino3dm.File3dm.Read(str(tmp_path / "a.3dm"))
    (item,) = model.Objects
    assert isinstance(item.Geometry, rhino3dm.Brep)
    assert item.Geometry.IsValidWithLog == (True, "")
    assert item.Geometry.IsSolid
    read = without_warnings(tmp_path / "a.3dm")
    assert read.is_closed
    assert read.euler_characteristic == shell.euler_characteristic
    lengths = [sum(edge.curve.length() for edge in each.edges) for each in (shell, read)]
    assert lengths[1] == pytest.approx(lengths[0], rel=1e-6)
