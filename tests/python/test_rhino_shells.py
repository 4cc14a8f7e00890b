"""Shells from and to Rhino files."""

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rhino3dm

import neurbs
from neurbs import Face, NeurbsError, NurbsSurface, Shell

InnerPoint = Callable[[Face], tuple[Any, Any]]


def without_warnings(path: Path) -> Shell:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return neurbs.load_shell(path)


def test_rhino_solids_and_extrusions(tmp_path: Path, inner_point: InnerPoint) -> None:
    model = rhino3dm.File3dm()
    cylinder = rhino3dm.Cylinder(rhino3dm.Circle(2.0), 5.0)
    model.Objects.AddBrep(rhino3dm.Brep.CreateFromCylinder(cylinder, True, True))
    model.Objects.AddSphere(rhino3dm.Sphere(rhino3dm.Point3d(11, 2, 3), 4.0))
    profile = rhino3dm.Circle(1.0).ToNurbsCurve()
    profile.Translate(rhino3dm.Vector3d(30, 0, 0))
    model.Objects.AddExtrusion(rhino3dm.Extrusion.Create(profile, 7.0, True))
    box = rhino3dm.BoundingBox(50, 0, 0, 51, 2, 3)
    attributes = rhino3dm.ObjectAttributes()
    attributes.Name = "crate"
    attributes.ColorSource = rhino3dm.ObjectColorSource.ColorFromObject
    attributes.ObjectColor = (255, 51, 0, 255)
    model.Objects.AddBrep(rhino3dm.Brep.CreateFromBox(rhino3dm.Box(box)), attributes)
    model.Settings.ModelUnitSystem = rhino3dm.UnitSystem.Meters
    model.Write(str(tmp_path / "a.3dm"), 7)
    shell = without_warnings(tmp_path / "a.3dm")
    assert shell.is_closed
    assert shell.unit == "m"
    assert shell.euler_characteristic == 8
    assert [face.name for face in shell.faces[-6:]] == ["crate"] * 6
    assert shell.faces[-1].color == (1, 0.2, 0)
    middles = {"tube": (0, 0, 2.5), "ball": (11, 2, 3), "bar": (30, 0, 3.5), "box": (50.5, 1, 1.5)}
    for face in shell.faces:
        point, normal = inner_point(face)
        nearest = min(middles.values(), key=lambda m: float(np.linalg.norm(point - m)))
        assert (point - nearest) @ normal > 0


def nested_model() -> Any:
    """Return a model with a ball in a block, which is twice in another one, mirrored there."""
    model = rhino3dm.File3dm()
    layer = rhino3dm.Layer()
    layer.Name, layer.Color = "balls", (0, 255, 0, 255)
    model.Layers.Add(layer)
    model.Layers.AddLayer("others", (0, 0, 0, 255))
    ball = rhino3dm.Sphere(rhino3dm.Point3d(1, 0, 0), 0.5).ToBrep()
    attributes = rhino3dm.ObjectAttributes()
    attributes.LayerIndex = 0
    origin = rhino3dm.Point3d(0, 0, 0)
    inner = model.InstanceDefinitions.Add("inner", "", "", "", origin, (ball,), (attributes,))
    identifier = model.InstanceDefinitions.FindIndex(inner).Id
    mirror = rhino3dm.Transform.Mirror(origin, rhino3dm.Vector3d(1, 0, 0))
    references = (
        rhino3dm.InstanceReference(identifier, rhino3dm.Transform.Translation(0, 5, 0)),
        rhino3dm.InstanceReference(identifier, mirror),
    )
    plain = rhino3dm.ObjectAttributes()
    outer = model.InstanceDefinitions.Add("outer", "", "", "", origin, references, (plain, plain))
    identifier = model.InstanceDefinitions.FindIndex(outer).Id
    for z in (0.0, 100.0):
        shift = rhino3dm.Transform.Translation(0, 0, z)
        model.Objects.AddInstanceObject(rhino3dm.InstanceReference(identifier, shift))
    return model


def test_blocks_are_read_where_they_stand(tmp_path: Path, inner_point: InnerPoint) -> None:
    nested_model().Write(str(tmp_path / "a.3dm"), 7)
    shell = without_warnings(tmp_path / "a.3dm")
    assert shell.is_closed
    middles = [np.mean(face.surface.bounding_box(), axis=0).round(9) for face in shell.faces]
    expected = [[1, 5, 0], [-1, 0, 0], [1, 5, 100], [-1, 0, 100]]
    np.testing.assert_allclose(middles, expected, atol=1e-9)
    for face, middle in zip(shell.faces, middles, strict=True):
        point, normal = inner_point(face)
        assert (point - middle) @ normal > 0
        assert (face.name, face.color) == ("balls", (0, 1, 0))


def test_what_is_not_a_face_is_named(tmp_path: Path) -> None:
    model = nested_model()
    mesh = rhino3dm.Mesh()
    for x, y in ((0, 0), (1, 0), (0, 1)):
        mesh.Vertices.Add(x, y, 0.0)
    mesh.Faces.AddFace(0, 1, 2)
    model.Objects.AddMesh(mesh)
    model.Objects.AddLine(rhino3dm.Point3d(0, 0, 0), rhino3dm.Point3d(1, 0, 0))
    model.Objects.AddLine(rhino3dm.Point3d(0, 0, 0), rhino3dm.Point3d(2, 0, 0))
    model.Write(str(tmp_path / "a.3dm"), 7)
    with pytest.warns(UserWarning, match="only faces are read; left out: 2 curves, 1 mesh$"):
        assert len(neurbs.load_shell(tmp_path / "a.3dm").faces) == 4


def test_a_file_without_faces_says_what_it_has(tmp_path: Path) -> None:
    model = rhino3dm.File3dm()
    for k in range(3):
        model.Objects.AddLine(rhino3dm.Point3d(0, 0, 0), rhino3dm.Point3d(1, k, 0))
    model.Objects.AddPoint(rhino3dm.Point3d(0, 0, 0))
    model.Write(str(tmp_path / "a.3dm"), 7)
    for load, kind in ((neurbs.load_shell, "face"), (neurbs.load_surfaces, "surface")):
        with pytest.raises(NeurbsError, match=f"at least one {kind}, but .* 3 curves, 1 point$"):
            load(tmp_path / "a.3dm")


def test_a_face_of_a_high_degree_is_left_out(tmp_path: Path) -> None:
    model = rhino3dm.File3dm()
    for degree, name in ((31, "high"), (3, "low")):
        surface = rhino3dm.NurbsSurface.Create(3, False, degree + 1, 2, degree + 1, 2)
        for k in range(2 * degree):
            surface.KnotsU[k] = float(k >= degree)
        surface.KnotsV[0], surface.KnotsV[1] = 0.0, 1.0
        for i in range(degree + 1):
            for j in range(2):
                surface.Points[i, j] = rhino3dm.Point4d(i, j, i * i % 3, 1)
        attributes = rhino3dm.ObjectAttributes()
        attributes.Name = name
        model.Objects.AddSurface(surface, attributes)
    model.Write(str(tmp_path / "a.3dm"), 7)
    message = r"1 of 2 faces are left out: face 1 \('high'\): degree must be"
    with pytest.warns(UserWarning, match=message) as seen:
        shell = neurbs.load_shell(tmp_path / "a.3dm")
    assert seen[0].filename == __file__
    assert [face.name for face in shell.faces] == ["low"]
    with pytest.raises(NeurbsError, match=r"each surface must be readable, but face 1 \('high'\)"):
        neurbs.load_surfaces(tmp_path / "a.3dm")


def test_three_faces_at_an_edge_are_not_joined(tmp_path: Path) -> None:
    along_y = [0.0, 4.0, 0.0]
    planes = [NurbsSurface.plane([0, 0, 0], x, along_y) for x in ([1, 0, 0], [0, 0, 1], [-1, 0, 1])]
    neurbs.save(planes, tmp_path / "a.3dm")
    with pytest.warns(UserWarning, match="3 faces are not joined: .* near \\(0.0"):
        shell = neurbs.load_shell(tmp_path / "a.3dm")
    assert len(shell.faces) == 3
    assert all(edge.is_border for edge in shell.edges)


def test_a_polysurface_has_one_name_and_color(tmp_path: Path) -> None:
    shell = Shell(
        [
            Face(NurbsSurface.plane([x, 0, 0], [1, 0, 0], [0, 1, 0]), name=name, color=(0, 1, 0))
            for x, name in ((0, "a"), (1, "b"))
        ]
    )
    with pytest.warns(UserWarning, match="has one name: those of the faces differ") as seen:
        neurbs.save(shell, tmp_path / "a.3dm")
    assert seen[0].filename == __file__
    read = neurbs.load_shell(tmp_path / "a.3dm")
    assert [face.name for face in read.faces] == [None, None]
    assert [face.color for face in read.faces] == [(0, 1, 0), (0, 1, 0)]
