"""STEP and IGES, read back by OpenCASCADE."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from OCP.BRep import BRep_Tool
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.IGESControl import IGESControl_Reader
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import TopAbs_FACE
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS

import neurbs
from neurbs import NurbsSurface, Reconstruction


def only_face(path: Path) -> Any:
    """Read the only face of a file as a surface of OpenCASCADE."""
    reader = STEPControl_Reader() if path.suffix == ".step" else IGESControl_Reader()
    assert reader.ReadFile(str(path)) == IFSelect_ReturnStatus.IFSelect_RetDone
    reader.TransferRoots()
    shape = reader.OneShape()
    assert BRepCheck_Analyzer(shape).IsValid()
    faces = TopExp_Explorer(shape, TopAbs_FACE)
    # Renamed between versions 7 and 8 of the bindings.
    as_face = getattr(TopoDS, "Face_s", None) or TopoDS.Face
    surface = BRep_Tool.Surface_s(as_face(faces.Current()))
    faces.Next()
    assert not faces.More()
    return surface


def knots(surface: Any, direction: str) -> NDArray[np.float64]:
    def of(name: str) -> Any:
        return getattr(surface, name.replace("*", direction))

    count = of("Nb*Knots")()
    repeated = ([of("*Knot")(i)] * of("*Multiplicity")(i) for i in range(1, count + 1))
    return np.concatenate([*repeated])


def make(shape: tuple[int, int], degree: tuple[int, int], **options: Any) -> NurbsSurface:
    """Make a wavy sheet of size 1, then scale and move it."""
    rng = np.random.default_rng(shape[0])
    x, y = np.meshgrid(*(np.linspace(0, 1, n) for n in shape), indexing="ij")
    net = np.stack([x, y, 0.3 * rng.random(shape)], axis=2) + 0.01 * rng.random((*shape, 3))
    net = net * options.get("scale", 1.0) + options.get("offset", 0.0)
    weights = rng.uniform(0.1, 10, shape) if options.get("rational") else None
    return NurbsSurface(net, weights, degree, options.get("knots"))


UNEVEN = ([0, 0, 0, 0.2, 0.2, 0.7, 0.9, 1, 1, 1], [-5, -5, -5, -5, 1 / 3, 2 / 3, 9, 9, 9, 9])

SURFACES = {
    "polynomial": make((20, 17), (3, 3)),
    "rational": make((20, 17), (3, 3), rational=True),
    "one bilinear patch": make((2, 2), (1, 1)),
    "one rational Bezier patch": make((4, 6), (3, 5), rational=True),
    "degree 9": make((12, 11), (9, 4), rational=True),
    "uneven knots": make((7, 6), (2, 3), rational=True, knots=UNEVEN),
    "a millimeter": make((9, 9), (3, 3), rational=True, scale=1e-3),
    "a kilometer far away": make((12, 12), (3, 3), rational=True, scale=1e3, offset=5e6),
    "far away, polynomial": make((12, 12), (3, 3), scale=1e3, offset=-7.8e6),
}


@pytest.mark.parametrize("suffix", [".step", ".igs"])
@pytest.mark.parametrize("name", SURFACES)
def test_opencascade_reads_one_valid_face_with_the_same_bits(
    name: str, suffix: str, tmp_path: Path
) -> None:
    ours, path = SURFACES[name], tmp_path / f"surface{suffix}"
    neurbs.save(ours, path)
    theirs = only_face(path)
    rows, cols = ours.control_points.shape[:2]
    assert (theirs.NbUPoles(), theirs.NbVPoles()) == (rows, cols)
    assert (theirs.UDegree(), theirs.VDegree()) == ours.degree
    places = [(i, j) for i in range(1, rows + 1) for j in range(1, cols + 1)]
    poles = np.array([theirs.Pole(i, j).Coord() for i, j in places])
    np.testing.assert_array_equal(poles.reshape(rows, cols, 3), ours.control_points)
    weights = np.array([theirs.Weight(i, j) for i, j in places]).reshape(rows, cols)
    np.testing.assert_array_equal(weights, 1 if ours.weights is None else ours.weights)
    for direction, expected in zip("UV", ours.knots, strict=True):
        np.testing.assert_array_equal(knots(theirs, direction), expected)
    for u, v in np.random.default_rng(0).random((20, 2)):
        at = [a + t * (b - a) for t, (a, b) in zip((u, v), ours.domain, strict=True)]
        point = ours.evaluate([at])[0]
        size = np.ptp(ours.control_points, axis=(0, 1)).max()
        magnitude = np.abs(ours.control_points).max()
        np.testing.assert_allclose(
            theirs.Value(*at).Coord(), point, rtol=0, atol=1e-12 * size + 1e-14 * magnitude
        )


def test_a_reconstruction_is_one_valid_face(result: Reconstruction, tmp_path: Path) -> None:
    for suffix in (".step", ".igs"):
        result.save(tmp_path / f"result{suffix}")
        assert only_face(tmp_path / f"result{suffix}").UDegree() == 3


def test_unclamped_surfaces_end_where_they_end(tmp_path: Path) -> None:
    """The boundary of the face is the boundary of the domain, not of the net."""
    ours = make((7, 8), (3, 3), rational=True, scale=1e3, knots=(np.arange(11.0), np.arange(12.0)))
    neurbs.save(ours, tmp_path / "a.step")
    neurbs.save(ours, tmp_path / "a.igs")
    for suffix in (".step", ".igs"):
        theirs = only_face(tmp_path / f"a{suffix}")
        for at in ([3, 3], [7, 8], [4, 5.5]):
            point = ours.evaluate([at])[0]
            np.testing.assert_allclose(theirs.Value(*at).Coord(), point, rtol=0, atol=1e-9)
    vertices = re.findall(r"VERTEX_POINT\('',#(\d+)\)", (tmp_path / "a.step").read_text())
    corners = ours.evaluate([[3, 3], [7, 3], [7, 8], [3, 8]])
    for number, corner in zip(vertices, corners, strict=True):
        point = re.search(
            rf"#{number}=CARTESIAN_POINT\('',\((.*)\)\)", (tmp_path / "a.step").read_text()
        )
        assert point is not None
        written = [float(x) for x in point.group(1).split(",")]
        np.testing.assert_allclose(written, corner, rtol=0, atol=1e-9)
