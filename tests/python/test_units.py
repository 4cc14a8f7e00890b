"""Units: known or given for each file, kept by objects, converted where they change."""

import dataclasses
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rhino3dm
import trimesh
from numpy.typing import NDArray
from OCP.Bnd import Bnd_Box
from OCP.BRepBndLib import BRepBndLib
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.IGESControl import IGESControl_Reader
from OCP.STEPControl import STEPControl_Reader

import neurbs
from neurbs import NeurbsError, NurbsSurface, PointCloud, Shell
from neurbs.io import mesh_vertices, units

Command = Callable[..., Any]
QUICK = ["--grid", "6", "--aspect", "fixed"]

CAD = (".step", ".igs", ".3dm")
"""Formats that store the unit of CAD programs."""

MILLIMETERS = {"Millimeters": 1.0, "Centimeters": 10.0, "Meters": 1e3, "Inches": 25.4}
"""Units of Rhino."""

JACKSBORO = Path(__file__).parents[2] / "examples" / "jacksboro.xyz"


def millimeters(path: Path) -> NDArray[np.float64]:
    """Return the sides of the box around a file's faces by the library of another program."""
    if path.suffix == ".3dm":
        model = rhino3dm.File3dm.Read(str(path))
        boxes = [item.Geometry.GetBoundingBox() for item in model.Objects]
        corners = np.array([[b.Min.X, b.Min.Y, b.Min.Z, b.Max.X, b.Max.Y, b.Max.Z] for b in boxes])
        sides = corners[:, 3:].max(axis=0) - corners[:, :3].min(axis=0)
        return np.asarray(sides * MILLIMETERS[model.Settings.ModelUnitSystem.name])
    reader = STEPControl_Reader() if path.suffix == ".step" else IGESControl_Reader()
    assert reader.ReadFile(str(path)) == IFSelect_ReturnStatus.IFSelect_RetDone
    reader.TransferRoots()
    box = Bnd_Box()
    box.SetGap(0)
    BRepBndLib.AddOptimal_s(reader.OneShape(), box, False, False)
    corners = np.array([box.CornerMin().Coord(), box.CornerMax().Coord()])
    of_box: NDArray[np.float64] = np.ptp(corners, axis=0)
    return of_box


def sheet(length: float = 2.0) -> NurbsSurface:
    """Return a flat sheet with sides of a length, and of half of it."""
    return NurbsSurface.plane([0, 0, 0], [length, 0, 0], [0, length / 2, 0])


@pytest.fixture(scope="module")
def in_inches() -> neurbs.Reconstruction:
    """Reconstruct a hill from points in inches, 4 by 2 by about 1."""
    x, y = np.random.default_rng(0).random((2, 300))
    corners = [[0, 0, 0], [4, 0, 0], [0, 2, 0], [4, 2, 0]]
    points = np.column_stack([4 * x, 2 * y, np.sin(np.pi * x) * np.sin(np.pi * y)])
    return neurbs.reconstruct(
        PointCloud(np.vstack([points, corners]), unit="in"), grid=(6, 6), trim=False
    )


# Reading


def test_points_of_a_file_without_a_unit_get_the_given_one(tmp_path: Path) -> None:
    path = tmp_path / "a.xyz"
    path.write_text("1 2 3\n4 5 6\n")
    cloud = neurbs.read_point_cloud(path, unit="in")
    assert (cloud.unit, cloud.points.tolist()) == ("in", [[1, 2, 3], [4, 5, 6]])
    assert neurbs.read_points(path, unit="in").tolist() == [[1, 2, 3], [4, 5, 6]]
    with pytest.raises(NeurbsError, match=r"unit must be 'mm' or .*, got 'inch'") as caught:
        neurbs.read_points(path, unit="inch")
    assert caught.value.argument == "unit"


def test_points_of_a_file_with_a_unit_are_converted(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("x [in],y [in],z [in]\n1,2,3\n-4,5,6\n")
    expected = 25.4 * np.array([[1, 2, 3], [-4, 5, 6]])
    cloud = neurbs.read_point_cloud(path, unit="mm")
    assert cloud.unit == "mm"
    np.testing.assert_allclose(cloud.points, expected, rtol=1e-15)
    (chunk,) = neurbs.read_points(path, unit="mm", chunks=5)
    np.testing.assert_array_equal(chunk, cloud.points)
    degrees = PointCloud(expected, unit="degree")
    neurbs.save(degrees, tmp_path / "b.csv")
    with pytest.raises(NeurbsError, match=r"must have a unit of length .* to mm, got 'degree'"):
        neurbs.read_points(tmp_path / "b.csv", unit="mm")


@pytest.mark.parametrize("suffix", [".ply", ".csv"])
@pytest.mark.parametrize("unit", ["mm", "in", "US survey foot", "degree", None])
def test_files_of_points_keep_their_unit(tmp_path: Path, suffix: str, unit: str | None) -> None:
    cloud = PointCloud(np.arange(6.0).reshape(2, 3), unit=unit, distances=np.ones(2))
    neurbs.save(cloud, tmp_path / f"a{suffix}")
    read = neurbs.read_point_cloud(tmp_path / f"a{suffix}")
    assert read.unit == unit
    np.testing.assert_array_equal(read.points, cloud.points)


def test_the_mesh_of_a_file_keeps_its_unit(tmp_path: Path) -> None:
    neurbs.save(Shell(sheet(), unit="in"), tmp_path / "a.ply")
    assert neurbs.read_point_cloud(tmp_path / "a.ply").unit == "in"
    sheet().tessellate().save(tmp_path / "b.ply", unit="ft")
    assert neurbs.read_point_cloud(tmp_path / "b.ply").unit == "ft"


def test_a_surface_in_json_keeps_its_unit(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    neurbs.save(sheet(), path, unit="in")
    assert neurbs.load_shell(path).unit == "in"
    assert neurbs.load_surface(path) == sheet()
    in_mm = neurbs.load_surface(path, unit="mm")
    np.testing.assert_allclose(in_mm.control_points, 25.4 * sheet().control_points, rtol=1e-15)
    path.write_text(path.read_text().replace('"unit": "in"', '"unit": "cubit"'))
    with pytest.raises(NeurbsError, match=r"unit must be 'mm' .*, got 'cubit'"):
        neurbs.load_shell(path)


@pytest.mark.parametrize(
    ("name", "length"), [("Microns", 1e-3), ("Kilometers", 1e6), ("Yards", 914.4), ("Feet", None)]
)
def test_rhino_files_in_other_units(tmp_path: Path, name: str, length: float | None) -> None:
    path = tmp_path / "a.3dm"
    neurbs.save(sheet(), path)
    model = rhino3dm.File3dm.Read(str(path))
    model.Settings.ModelUnitSystem = getattr(rhino3dm.UnitSystem, name)
    assert model.Write(str(path), 7)
    shell = neurbs.load_shell(path)
    assert shell.unit == ("ft" if length is None else "mm")
    assert shell.bounding_box()[1][0] == pytest.approx(2 * (length or 1))


def test_scenes_have_the_unit_of_their_format(tmp_path: Path) -> None:
    box = trimesh.creation.box()
    paths = {suffix: tmp_path / f"a{suffix}" for suffix in (".glb", ".stl")}
    for path in paths.values():
        box.export(path)
    assert neurbs.read_point_cloud(paths[".glb"]).unit == "m"
    assert neurbs.read_point_cloud(paths[".stl"]).unit is None
    # As the library reads 3MF and Collada.
    for theirs, ours in {
        "millimeter": "mm",
        "micron": "um",
        "inch": "in",
        "0.0254 * meters": "in",
        "0.007 * meters": None,
    }.items():
        box.units = theirs
        assert mesh_vertices._unit(Path("a.3mf"), box.scene()) == ours, theirs


# Objects


def test_points_are_converted() -> None:
    cloud = PointCloud(
        np.ones((1, 3)),
        normals=np.array([[0.6, 0, 0.8]]),
        distances=np.array([2.0]),
        unit="m",
        offset=(1, 2, 3),
    )
    in_mm = cloud.to_unit("mm")
    assert (in_mm.unit, in_mm.offset) == ("mm", (1000, 2000, 3000))
    assert in_mm.points.tolist() == [[1000, 1000, 1000]]
    assert in_mm.normals is not None
    assert in_mm.normals.tolist() == [[0.6, 0, 0.8]]
    assert in_mm.distances is not None
    assert in_mm.distances.tolist() == [2000]
    assert cloud.to_unit("m").points.tolist() == [[1, 1, 1]]
    mixed = dataclasses.replace(cloud, unit="m, z: ft")
    with pytest.raises(NeurbsError, match="must have one unit for x, y and z, got 'm, z: ft'"):
        mixed.to_unit("m")
    in_m = dataclasses.replace(mixed, distances=None).to_unit("m")
    np.testing.assert_allclose(in_m.points, [[1, 1, 0.3048]], rtol=1e-15)
    assert in_m.normals is not None
    # Normals stay perpendicular: the plane 0.6 x + 0.8 z (ft) is 0.6 x + 0.8/0.3048 z (m).
    expected = np.array([0.6, 0, 0.8 / 0.3048])
    np.testing.assert_allclose(in_m.normals[0], expected / np.linalg.norm(expected), rtol=1e-15)


def test_a_survey_foot_is_not_a_foot() -> None:
    assert units.conversion("US survey foot", "m")[0] == pytest.approx(1200 / 3937, rel=1e-15)
    assert units.conversion("ft", "m")[0] == pytest.approx(0.3048, rel=1e-15)


def test_a_shell_is_converted() -> None:
    shell = Shell(sheet(), unit="in", tolerance=1e-3)
    in_mm = shell.to_unit("mm")
    assert in_mm.unit == "mm"
    assert in_mm.area() == pytest.approx(25.4**2 * shell.area(), rel=1e-12)
    assert in_mm.tolerance == pytest.approx(0.0254, rel=1e-12)
    assert Shell(sheet()).to_unit("m") == Shell(sheet(), unit="m")
    with pytest.raises(NeurbsError, match="unit must be 'mm'"):
        shell.to_unit("inch")  # type: ignore[arg-type]


def test_a_result_has_the_unit_of_its_points(in_inches: neurbs.Reconstruction) -> None:
    assert in_inches.unit == "in"
    assert neurbs.reconstruct(in_inches.points, grid=(6, 6)).unit is None
    cloud = PointCloud(in_inches.points, unit="cm")
    assert neurbs.reconstruct_paper(cloud, grid=(4, 4), max_steps=100).unit == "cm"
    (each,) = neurbs.reconstruct(cloud, grid=(6, 6), component="each")
    assert each.unit == "cm"


def test_a_result_has_the_unit_that_is_given(in_inches: neurbs.Reconstruction) -> None:
    points = in_inches.points
    options: dict[str, Any] = {"grid": (6, 6), "trim": False}
    from_array = neurbs.reconstruct(points, unit="in", **options)
    assert (from_array.unit, from_array.shell.unit) == ("in", "in")
    assert from_array.surface == in_inches.surface
    chunks = iter([points[:100], points[100:]])
    assert neurbs.reconstruct(chunks, unit="in", **options).unit == "in"
    cloud = PointCloud(points, unit="in")
    in_mm = neurbs.reconstruct(cloud, tolerance=2.54, unit="mm", **options)
    assert (in_mm.unit, in_mm.report.converged) == ("mm", True)
    assert in_mm.shell.unit == "mm"
    np.testing.assert_allclose(in_mm.points, 25.4 * points, rtol=1e-15)
    (each,) = neurbs.reconstruct(cloud, component="each", unit="cm", **options)
    assert each.unit == "cm"
    paper = neurbs.reconstruct_paper(points, grid=(4, 4), max_steps=100, unit="m")
    assert (paper.unit, paper.shell.unit) == ("m", "m")
    with pytest.raises(NeurbsError, match=r"unit must be 'mm' or .*, got 'inch'"):
        neurbs.reconstruct(points, unit="inch")  # type: ignore[call-overload]
    with pytest.raises(NeurbsError, match=r"must have a unit of length .* to mm, got 'degree'"):
        neurbs.reconstruct(PointCloud(points, unit="degree"), unit="mm")


def test_legends_have_the_unit_of_the_points(
    in_inches: neurbs.Reconstruction, tmp_path: Path
) -> None:
    labels = [axes.get_ylabel() for axes in in_inches.plot(color="deviation").axes]
    assert any("deviation, in" in label for label in labels), labels
    pytest.importorskip("plotly", reason="plotly is not installed")
    page = tmp_path / "a.html"
    in_inches.save(page)
    text = page.read_text(encoding="utf-8")
    assert re.search(r"[0-9] in<", text)
    assert "--unit in" in text
    with pytest.raises(NeurbsError, match="unit must be 'in', that of the result, got 'mm'"):
        in_inches.save(page, unit="mm")


def test_any_text_can_be_a_unit(in_inches: neurbs.Reconstruction, tmp_path: Path) -> None:
    name = "$\\frac$ </script>\nelement"
    odd = dataclasses.replace(in_inches, unit=name)
    odd.plot(color="deviation").savefig(tmp_path / "a.png")
    neurbs.save(PointCloud(odd.points, unit=name), tmp_path / "a.ply")
    read = neurbs.read_point_cloud(tmp_path / "a.ply")
    np.testing.assert_array_equal(read.points, odd.points)
    assert read.unit == "$\\frac$ </script> element"


# Writing


@pytest.mark.parametrize("unit", [None, "mm", "cm", "m", "in"])
@pytest.mark.parametrize("suffix", CAD)
def test_a_result_keeps_its_size_in_every_unit(
    in_inches: neurbs.Reconstruction, tmp_path: Path, suffix: str, unit: str | None
) -> None:
    path = tmp_path / f"a{suffix}"
    in_inches.save(path, unit=unit)
    # Rhino's library gives the box around the control points.
    sides = np.ptp(in_inches.surface.bounding_box(tight=suffix != ".3dm"), axis=0)
    np.testing.assert_allclose(millimeters(path), 25.4 * sides, rtol=1e-6)
    shell = neurbs.load_shell(path)
    assert shell.unit == (unit or "in")
    back = shell.to_unit("in").faces[0].surface.control_points
    np.testing.assert_allclose(back, in_inches.surface.control_points, atol=1e-12)


@pytest.mark.parametrize("suffix", CAD)
def test_shells_keep_their_size_in_every_unit(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    for thing, unit, length in (
        (Shell(sheet(), unit="in"), None, 50.8),
        (Shell(sheet(), unit="in"), "mm", 50.8),
        ([Shell(sheet(), unit="in"), Shell(sheet(1.0), unit="m")], "cm", 1000.0),
        (Shell(sheet()), "m", 2000.0),
        (sheet(), None, 2.0),
        (sheet(), "in", 50.8),
        (neurbs.Face(sheet()), "cm", 20.0),
    ):
        neurbs.save(thing, path, unit=unit)
        assert millimeters(path).max() == pytest.approx(length, abs=1e-6)


def test_meshes_and_points_of_a_result_keep_their_size(
    in_inches: neurbs.Reconstruction, tmp_path: Path
) -> None:
    sides = np.ptp(in_inches.mesh.vertices, axis=0)
    in_inches.save(tmp_path / "a.glb")
    size = np.ptp(neurbs.read_points(tmp_path / "a.glb"), axis=0)
    np.testing.assert_allclose(size, 0.0254 * sides, rtol=1e-6)
    in_inches.save(tmp_path / "a.stl", unit="mm")
    size = np.ptp(neurbs.read_points(tmp_path / "a.stl"), axis=0)
    np.testing.assert_allclose(size, 25.4 * sides, rtol=1e-3)
    in_inches.save(tmp_path / "a.csv", unit="mm")
    cloud = neurbs.read_point_cloud(tmp_path / "a.csv")
    assert cloud.unit == "mm"
    np.testing.assert_allclose(cloud.points, 25.4 * in_inches.points, rtol=1e-15)
    in_inches.save(tmp_path / "a.json")
    assert neurbs.load_shell(tmp_path / "a.json").unit == "in"


def test_cad_files_of_units_that_they_cannot_have(
    in_inches: neurbs.Reconstruction, tmp_path: Path
) -> None:
    path = tmp_path / "a.step"
    surveyed = dataclasses.replace(in_inches, unit="US survey foot")
    surveyed.save(path)
    assert neurbs.load_shell(path).unit == "ft"
    expected = in_inches.surface.control_points * (1200 / 3937 / 0.3048)
    found = neurbs.load_surface(path).control_points
    np.testing.assert_allclose(found, expected, rtol=1e-14)
    mixed = dataclasses.replace(in_inches, unit="m, z: ft")
    mixed.save(path)
    expected = in_inches.surface.control_points * [1, 1, 0.3048]
    np.testing.assert_allclose(neurbs.load_surface(path).control_points, expected, rtol=1e-14)
    degrees = dataclasses.replace(in_inches, unit="degree")
    with pytest.warns(UserWarning, match="the unit 'degree' is not a length"):
        degrees.save(path)
    assert neurbs.load_surface(path) == in_inches.surface
    with pytest.raises(NeurbsError, match=r"must have a unit of length .* to m, got 'degree'"):
        degrees.save(path, unit="m")


# The command line


def test_convert_changes_numbers_and_not_the_size(tmp_path: Path, command: Command) -> None:
    inches, mm = tmp_path / "inches.step", tmp_path / "mm.step"
    neurbs.save(Shell(sheet(), unit="in"), inches)
    assert command("convert", inches, mm, "--unit", "mm").code == 0
    shell = neurbs.load_shell(mm)
    assert (shell.unit, shell.bounding_box()[1][0]) == ("mm", pytest.approx(50.8))
    np.testing.assert_allclose(millimeters(mm), millimeters(inches), atol=1e-9)
    # Without --unit the unit is that of the file, also through formats of one surface.
    for name in ("a.json", "a.3dm", "a.igs", "b.step"):
        assert command("convert", inches, tmp_path / name, "-q").code == 0
        inches = tmp_path / name
        assert neurbs.load_shell(inches).unit == "in", name
    assert millimeters(inches).max() == pytest.approx(50.8)


def test_convert_takes_the_unit_of_numbers_without_one(tmp_path: Path, command: Command) -> None:
    source, target = tmp_path / "a.xyz", tmp_path / "a.csv"
    source.write_text("1 2 3\n4 5 6\n")
    words = ["convert", source, target, "--unit", "mm"]
    done = command(*words, "--from-unit", "in", "--json")
    assert (done.code, done.json()["unit"]) == (0, "mm")
    assert target.read_text().startswith("x [mm],y [mm],z [mm]\n25.4,50.8,")
    found = neurbs.read_points(target)
    np.testing.assert_allclose(found, 25.4 * neurbs.read_points(source), rtol=1e-15)
    assert command(*words).code == 0
    np.testing.assert_array_equal(neurbs.read_points(target), neurbs.read_points(source))
    assert neurbs.read_point_cloud(target).unit == "mm"
    done = command("convert", target, tmp_path / "b.csv", "--from-unit", "in")
    assert done.code == 2
    assert "'--from-unit': must be left out, as " in done.err
    done = command("convert", source, target, "--from-unit", "inch")
    assert (done.code, "'--from-unit': must be one of mm, " in done.err) == (2, True)
    done = command("convert", source, target, "--unit", "inch")
    assert (done.code, "'--unit': must be 'mm' or " in done.err) == (2, True)


def test_info_shows_the_unit(tmp_path: Path, command: Command) -> None:
    file, plain = tmp_path / "a.json", tmp_path / "a.xyz"
    neurbs.save(Shell(sheet(), unit="in"), file)
    plain.write_text("1 2 3\n4 5 6\n")
    assert re.search(r"^unit +in$", command("info", file).out, re.M)
    assert re.search(r"^unit +unknown$", command("info", plain).out, re.M)
    assert command("info", plain, "--json").json()["unit"] is None
    in_mm = command("info", file, "--unit", "mm", "--json").json()
    assert (in_mm["unit"], in_mm["high"][0]) == ("mm", pytest.approx(50.8))


def test_a_mesh_on_the_command_line_keeps_its_size(tmp_path: Path, command: Command) -> None:
    file, mesh = tmp_path / "a.step", tmp_path / "a.stl"
    neurbs.save(Shell(sheet(), unit="in"), file)
    assert command("tessellate", file, "-o", mesh, "--unit", "mm").code == 0
    assert np.ptp(neurbs.read_points(mesh), axis=0)[0] == pytest.approx(50.8, rel=1e-6)


def test_reconstruct_converts_points_of_another_unit(
    in_inches: neurbs.Reconstruction, tmp_path: Path, command: Command
) -> None:
    points, part = tmp_path / "a.ply", tmp_path / "a.step"
    neurbs.save(PointCloud(in_inches.points, unit="in"), points)
    words = ["reconstruct", points, "-o", part, *QUICK]
    done = command(*words, "--unit", "mm", "--tolerance", "2.54", "--json")
    # The tolerance is in the same unit.
    assert (done.code, done.json()["unit"], done.json()["report"]["converged"]) == (0, "mm", True)
    found = neurbs.load_surface(part, unit="in").closest_points(in_inches.points)
    assert found.distances.max() < 0.1
    assert re.search(r"^unit +in$", command(*words).out, re.M)
    assert neurbs.load_shell(part).unit == "in"


def test_metres_of_the_tutorial_stay_metres(tmp_path: Path, command: Command) -> None:
    cloud = neurbs.read_point_cloud(JACKSBORO)
    assert cloud.unit == "m"
    neurbs.reconstruct(cloud, grid=(9, 9)).save(tmp_path / "python.step")
    # Without the header the unit is given.
    points, surface = tmp_path / "points.xyz", tmp_path / "terrain.json"
    np.savetxt(points, cloud.points)
    words = ["-o", surface, "-o", tmp_path / "terrain.step", "--unit", "m", "--grid", "9", "-q"]
    assert command("reconstruct", points, *words).code == 0
    assert command("convert", surface, tmp_path / "terrain.igs", "-q").code == 0
    for name in ("python.step", "terrain.step", "terrain.igs"):
        size = 1000 * np.ptp(cloud.points, axis=0)
        np.testing.assert_allclose(millimeters(tmp_path / name)[:2], size[:2], rtol=1e-2)
        assert neurbs.load_shell(tmp_path / name).unit == "m"


def test_files_of_different_units_are_compared(
    in_inches: neurbs.Reconstruction, tmp_path: Path, command: Command
) -> None:
    part, points = tmp_path / "a.step", tmp_path / "a.ply"
    in_inches.save(part, unit="mm")
    neurbs.save(PointCloud(in_inches.points, unit="in"), points)
    done = command("compare", part, points, "--json").json()
    # The distances are in the unit of the second file.
    assert done["unit"] == "in"
    distances = in_inches.surface.closest_points(in_inches.points).distances
    assert done["deviation"]["max"] == pytest.approx(distances.max(), rel=1e-6)
    in_mm = command("compare", part, points, "--unit", "mm", "--json").json()
    assert in_mm["deviation"]["max"] == pytest.approx(25.4 * distances.max(), rel=1e-6)
    picture = tmp_path / "a.png"
    assert command("view", part, "--points", points, "-o", picture).code == 0


def test_a_file_without_a_unit_has_that_of_the_other(tmp_path: Path, command: Command) -> None:
    points = np.random.default_rng(0).random((50, 3))
    known, plain = tmp_path / "a.ply", tmp_path / "b.xyz"
    neurbs.save(PointCloud(points, unit="m, z: US survey foot"), known)
    np.savetxt(plain, points, fmt="%.17g")
    for files in ((known, plain), (plain, known)):
        done = command("compare", *files, "--json").json()
        assert (done["unit"], done["deviation"]["max"]) == ("m, z: US survey foot", 0)


def test_a_view_is_in_its_unit(
    in_inches: neurbs.Reconstruction, tmp_path: Path, command: Command
) -> None:
    part, points, picture = (tmp_path / name for name in ("a.step", "a.csv", "a.svg"))
    in_inches.save(part)
    neurbs.save(PointCloud(in_inches.points, unit="in"), points)
    words = ["view", part, "--points", points, "--color", "deviation", "-o", picture]
    for options, unit in (([], "in"), (["--unit", "mm"], "mm")):
        assert command(*words, *options).code == 0
        drawn = picture.read_text()
        assert f"<!-- deviation, {unit} (local mean) -->" in drawn
        (rms,) = re.findall(r"<!-- rms ([\d.e-]+), max", drawn)
        expected = in_inches.report.rms * units.conversion("in", unit)[0]
        assert float(rms) == pytest.approx(expected, rel=0.05)
    done = command("view", part, "--unit", "inch", "-o", picture)
    assert (done.code, "'--unit': must be 'mm' or " in done.err) == (2, True)
