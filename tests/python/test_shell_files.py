"""Shells that neurbs writes and reads: JSON, 3DM, STEP, IGES and OBJ files."""

import json
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import neurbs
from neurbs import Face, NeurbsError, NurbsCurve, NurbsSurface, Shell

OURS = (".json", ".3dm", ".step", ".igs", ".obj")
InnerPoint = Callable[[Face], tuple[Any, Any]]


def without_warnings(path: Path) -> Shell:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return neurbs.load_shell(path)


def circle(u: float, v: float, radius: float) -> list[NurbsCurve]:
    return [NurbsCurve.arc([u, v, 0], [radius, 0, 0], [0, radius, 0])]


def trimmed_shell() -> Shell:
    """Return a wavy sheet with two holes."""
    x, y = np.meshgrid(np.linspace(0, 30, 6), np.linspace(0, 20, 5), indexing="ij")
    sheet = NurbsSurface(np.stack([x, y, np.sin(x) * np.cos(y)], axis=-1), degree=(3, 2))
    loops = [circle(0.5, 0.5, 0.45), circle(0.35, 0.5, 0.1), circle(0.7, 0.55, 0.12)]
    face = Face(sheet, loops, name="sheet", color=(0.2, 0.4, 1.0), reversed=True)
    return Shell(face, unit="cm")


def capped_tube() -> Shell:
    tube = NurbsSurface.cylinder([0, 0, 0], [0, 0, 5], 2.0)
    plane = [NurbsSurface.plane([-4, -4, z], [8, 0, 0], [0, 8, 0]) for z in (0, 5)]
    caps = [Face(each, [circle(0.5, 0.5, 0.25)]) for each in plane]
    return Shell([tube, caps[0].reversed(), caps[1]], unit="in")


def steps() -> Shell:
    """Return a wide rectangle below two narrow ones, which divide its edge."""

    def plane(x: float, y: float, width: float) -> NurbsSurface:
        return NurbsSurface.plane([x, y, 0], [width, 0, 0], [0, 1, 0])

    return Shell([plane(0, 0, 2), plane(0, 1, 1), plane(1, 1, 1)], unit="m")


MADE: dict[str, Callable[[], Shell]] = {
    "sheet": trimmed_shell,
    "capped": capped_tube,
    "steps": steps,
    "ball": lambda: Shell(NurbsSurface.sphere([1, 2, 3], 2.0), unit="mm"),
    "torus": lambda: Shell(NurbsSurface.torus([0, 0, 0], 3.0, 1.0), unit="ft"),
    "cone": lambda: Shell(NurbsSurface.cone([0, 0, 0], [0, 0, 3], 2.0, 0.0), unit="mm"),
    "plane": lambda: Shell(NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0]), unit="mm"),
}


@pytest.mark.parametrize("name", MADE)
def test_json_keeps_everything(tmp_path: Path, name: str) -> None:
    shell = MADE[name]()
    neurbs.save(shell, tmp_path / "a.json")
    assert without_warnings(tmp_path / "a.json") == shell
    surfaces = [face.surface for face in shell.faces]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert neurbs.load_surfaces(tmp_path / "a.json") == surfaces


def test_json_of_several_things(tmp_path: Path) -> None:
    ball, sheet = MADE["ball"](), trimmed_shell().faces[0]
    neurbs.save([ball, sheet], tmp_path / "a.json", unit="cm")
    shell = neurbs.load_shell(tmp_path / "a.json", unit="mm")
    assert [face.name for face in shell.faces] == [None, "sheet"]
    assert len(shell.edges) == 4
    assert shell.unit == "mm"
    # The ball keeps its size; the face, which has no unit, gets that of the file.
    np.testing.assert_allclose(shell.vertices[0], [1, 2, 1], atol=1e-12)
    low, high = sheet.surface.bounding_box()
    found = shell.faces[1].surface.bounding_box()
    np.testing.assert_allclose(found, [10 * low, 10 * high], atol=1e-12)
    with pytest.raises(NeurbsError, match="must have the same unit, got cm and mm: give `unit`"):
        neurbs.save([ball, trimmed_shell()], tmp_path / "a.json")
    with pytest.raises(NeurbsError, match="got a list: it can be written as"):
        neurbs.save([ball, sheet], tmp_path / "a.csv")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.update(version=2), "version must be 1, got 2"),
        (lambda d: d.update(shells=3), "shells must be a list, got int"),
        (lambda d: d.update(shells=[]), "at least one face, but has none"),
        (lambda d: d["shells"][0].pop("faces"), "shell 1: data must be a dict with faces"),
    ],
)
def test_json_that_is_wrong(tmp_path: Path, change: Callable[[Any], Any], message: str) -> None:
    path = tmp_path / "a.json"
    neurbs.save(trimmed_shell(), path)
    document = json.loads(path.read_text())
    change(document)
    path.write_text(json.dumps(document))
    with pytest.raises(NeurbsError, match=message):
        neurbs.load_shell(path)


def matches(shell: Shell, other: Shell, inner_point: InnerPoint) -> None:
    """Compare two shells up to rounding."""
    assert len(other.faces) == len(shell.faces)
    assert other.is_closed == shell.is_closed
    assert other.euler_characteristic == shell.euler_characteristic
    for ours, theirs in zip(shell.faces, other.faces, strict=True):
        assert len(theirs.inner) == len(ours.inner)
        point, normal = inner_point(theirs)
        closest = ours.surface.closest_points([point])
        assert closest.distances[0] < 1e-6
        expected = ours.surface.normals(closest.uv)[0]
        np.testing.assert_allclose(normal, -expected if ours.is_reversed else expected, atol=1e-5)
        assert theirs.name == ours.name
    lengths = [sum(e.curve.length() for e in each.edges) for each in (shell, other)]
    assert lengths[1] == pytest.approx(lengths[0], rel=1e-6)


@pytest.mark.parametrize("suffix", [".3dm", ".step", ".igs", ".obj"])
@pytest.mark.parametrize("name", MADE)
def test_shells_are_written_and_read(
    tmp_path: Path, name: str, suffix: str, inner_point: InnerPoint
) -> None:
    shell = MADE[name]()
    neurbs.save(shell, tmp_path / f"a{suffix}")
    read = without_warnings(tmp_path / f"a{suffix}")
    matches(shell, read, inner_point)
    if suffix != ".obj":
        assert read.unit == shell.unit
        for ours, theirs in zip(shell.faces, read.faces, strict=True):
            assert theirs.color == pytest.approx(ours.color, abs=1e-5)


@pytest.mark.parametrize("suffix", OURS)
def test_a_file_cut_anywhere_is_refused(
    tmp_path: Path, suffix: str, refuse_cuts: Callable[[Path], None]
) -> None:
    path = tmp_path / f"a{suffix}"
    neurbs.save(trimmed_shell(), path)
    refuse_cuts(path)


# OBJ

PLATE = """\
g plate
v 0 0 0
v 4 0 0
v 0 4 0
v 4 4 0
vp 0.5 0.25
vp 0.75 0.5
vp 0.5 0.75
vp 0.25 0.5
cstype bspline
deg 1
curv2 1 2 3 4 1
parm u 0 0 1 2 3 4 4
end
vp 0 0
vp 1 0
vp 1 1
vp 0 1
curv2 -4 -3 -2 \\
-1 -4
parm u 0 0 1 2 3 4 4
end
deg 1 1
surf 0 1 0 1 1 2 3 4
parm u 0 0 1 1
parm v 0 0 1 1
trim 0 4 2
hole 4 0 1
end
f 1 2 3
"""


def test_trims_of_an_obj_file(tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    path.write_text(PLATE)
    with pytest.warns(UserWarning, match="left out: 1 polygon"):
        shell = neurbs.load_shell(path)
    (face,) = shell.faces
    assert face.name == "plate"
    assert len(face.inner) == 1
    assert sum(edge.curve.length() for edge in shell.edges) == pytest.approx(16 + 4 * 2**0.5)
    with pytest.warns(UserWarning, match="vertices are control points of free-form surfaces"):
        assert len(neurbs.read_points(path)) == 4
    path.write_text(PLATE.replace("trim 0 4 2\n", "").replace("g plate", "o lid\ng default"))
    with pytest.warns(UserWarning, match="polygon"):
        (face,) = neurbs.load_shell(path).faces
    assert face.name == "lid"
    assert len(face.inner) == 1


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("hole 4 0 1", "hole 4 0 9", "curv2 must have numbers from 1 to 2, got 9"),
        ("surf 0 1 0 1 1 2 3 4", "surf 0 1 0 1 1 2 3 x", "line 29: `end` must"),
        ("parm v 0 0 1 1\n", "", "must have parm u and parm v, but 'v' is missing"),
        ("end\nf 1 2 3\n", "", "has no `end`: it may be cut short"),
        (
            "g plate",
            "# 2 surfaces\ng plate",
            "must have 2 surfaces, as in its first line, but has 1",
        ),
        ("f 1 2 3\n", "g next\n", "points and curves have no surface: it may be cut short"),
        ("cstype bspline", "cstype bezier", "cstype must be bspline"),
    ],
)
def test_wrong_obj_files(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert old in PLATE
    (tmp_path / "a.obj").write_text(PLATE.replace(old, new))
    with pytest.raises(NeurbsError, match=message):
        neurbs.load_shell(tmp_path / "a.obj")


def test_a_mesh_has_no_faces(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(NeurbsError, match=r"but has only 1 polygon$"):
        neurbs.load_shell(tmp_path / "a.obj")


def test_edges_that_do_not_meet_are_not_joined(tmp_path: Path) -> None:
    """A file whose edges are wrong is joined by position."""
    path = tmp_path / "a.json"
    planes = [NurbsSurface.plane([x, 0, 0], [1, 0, 0], [0, 1, 0]) for x in (0.0, 5.0)]
    shell = Shell(planes, edges=[[[0, 1, 2, 3]], [[4, 5, 6, 1]]])
    assert len(shell.border()) == 6
    neurbs.save(shell, path)
    assert len(neurbs.load_shell(path).border()) == 8
