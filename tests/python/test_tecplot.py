"""Points from text files of Tecplot."""

from pathlib import Path

import meshio
import numpy as np
import pytest

import neurbs
from neurbs import NeurbsError

POINTS = [[0, 0, 1.5], [1, 0, 2.5], [0, 1, 3.5], [1, 1, 4.5]]
"""A grid of 2 × 2 points."""

NAMES = 'TITLE = "a 3"\nVARIABLES = "X" "Y" "Z" "P"\n'

ROWS = "".join(f"{x} {y} {z} 7\n" for x, y, z in POINTS)

COLUMNS = "0 1 0 1\n0 0\n1 1 1.5 2.5\n3.5 4.5 4*7\n"
"""The same numbers by variables; line breaks have no meaning."""


def written(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


@pytest.mark.filterwarnings("error::neurbs.NeurbsWarning")
@pytest.mark.parametrize(
    "text",
    [
        f"{NAMES}ZONE I=2, J=2, F=POINT\n{ROWS}",
        f"{NAMES}ZONE T=\"a F=BLOCK\"\n I=2, J=2, K=1\n ZONETYPE=Ordered DATAPACKING=POINT\n{ROWS}",
        f"{NAMES}ZONE\n{ROWS}",
        f"{NAMES}zone i=2, j=2, f=block\n{COLUMNS}",
        f"{NAMES}ZONE I=2, J=2, DATAPACKING=BLOCK, DT=(SINGLE SINGLE SINGLE\n SINGLE)\n{COLUMNS}",
        f"{NAMES}ZONE I=2, J=2\n{COLUMNS.replace('1 0 1', '1 0 1 0', 1)}".replace("\n0 0", "\n0"),
        f"{NAMES}ZONE N=4, E=1, F=FEPOINT, ET=QUADRILATERAL\n{ROWS}1 2 4 3\n",
        f"{NAMES}ZONE NODES=4, ELEMENTS=1, DATAPACKING=BLOCK, ZONETYPE=FEQUADRILATERAL\n"
        f"{COLUMNS}1 2 4 3\n",
        f"{NAMES}ZONE I=2, J=2, DATAPACKING=BLOCK, VARLOCATION=([4]=CELLCENTERED)\n"
        f"{COLUMNS.replace('4*7', '7')}",
        f"# a\n{NAMES}DATASETAUXDATA a=\"1\"\nTEXT X=5, Y=6\n1 2\nZONE I=2, J=2\n# b\n{ROWS}",
        "VARIABLES = X, Y, Z\n\"P\"\nZONE F=POINT\n" + ROWS.replace(" ", ",").replace(".5", ".5D0"),
        f"{NAMES}ZONE I=1, J=2, F=POINT\n{ROWS[:20]}ZONE J=2, F=BLOCK\n0 1 1 1 3.5 4.5 7 7\n",
        f"{NAMES}ZONE I=2, J=2, F=POINT\n{ROWS}"
        "ZONE I=2, J=2, F=BLOCK, VARSHARELIST=([1-3]=1)\n7 7 7 7\n",
        f"{NAMES}{ROWS}",
    ],
)  # fmt: skip
@pytest.mark.parametrize("suffix", [".dat", ".txt", ".csv"])
def test_nodes_of_all_zones_are_read(tmp_path: Path, suffix: str, text: str) -> None:
    points = neurbs.read_points(written(tmp_path / f"a{suffix}", text))
    assert points.tolist() == POINTS


def test_variables_are_found_by_their_names(tmp_path: Path) -> None:
    head = 'VARIABLES = "P" "Depth [ft]", "Easting [m]" "Northing [m]"\n'
    path = written(tmp_path / "a.dat", f"{head}ZONE I=2 F=BLOCK\n9 9 3 6 1 4 2 5\n")
    cloud = neurbs.read_point_cloud(path)
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert cloud.unit == "m, z: ft"
    named = "x, y, z are columns 'Easting [m]', 'Northing [m]', 'Depth [ft]'"
    assert cloud.columns == f"{named}; the points start in line 3"
    chosen = neurbs.read_points(path, columns=("P", "Northing", 1))
    assert chosen.tolist() == [[9, 2, 3], [9, 5, 6]]
    path = written(tmp_path / "b.dat", "VARIABLES = a b c d\nZONE\n1 2 3 4\n2 5 6 7\n")
    with pytest.warns(neurbs.ColumnsGuessedWarning, match="names 'a', 'b', 'c', 'd' are not known"):
        assert neurbs.read_points(path).tolist() == [[1, 2, 3], [2, 5, 6]]
    path = written(tmp_path / "c.dat", "VARIABLES = X Y U V\nZONE\n1 2 3 4\n")
    with pytest.raises(NeurbsError, match="must name x, y and z, got 'X', 'Y', 'U', 'V'"):
        neurbs.read_points(path)


@pytest.mark.parametrize("count", [3, 70_000])
def test_files_of_another_program(tmp_path: Path, count: int) -> None:
    points = np.random.default_rng(0).random((count, 3))
    cells = np.arange(count // 3 * 3).reshape(-1, 3)
    mesh = meshio.Mesh(points, [("triangle", cells)], point_data={"P": points[:, 0]})
    meshio.write(tmp_path / "a.dat", mesh, file_format="tecplot")
    np.testing.assert_allclose(neurbs.read_points(tmp_path / "a.dat"), points, rtol=1e-12)
    chunks = list(neurbs.read_points(tmp_path / "a.dat", chunks=50_000))
    assert sum(map(len, chunks)) == count


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (f"{NAMES}ZONE I=2, J=2, F=POINT\n{ROWS[:20]}", "zone in line 3 must have 16 values by"),
        (f"{NAMES}ZONE I=2, J=2, F=BLOCK\n{COLUMNS}1\n", "16 values by its header, but has 17"),
        (f"{NAMES}ZONE N=4, F=FEBLOCK\n1 2 3\n", "16 values .* but is cut short after 3"),
        (f"{NAMES}ZONE I=x\n1 2 3 4\n", "must have a number as I, got 'X'"),
        (f"{NAMES}ZONE\n1 2 3 4 a\n", "must have numbers, got 'a'"),
        (f"{NAMES}ZONE\n999999999999*1\n", "is damaged: it repeats numbers too often"),
        (f"{NAMES}ZONE\n{'9' * 30}*1\n", "must have numbers|damaged"),
        (f"{NAMES}ZONE T=\"a\"\n", "must have a zone with numbers"),
        (f"{NAMES}ZONE I=2 VARSHARELIST=([1]=1)\n1 2\n", "shares some with other zones"),
        (f"{NAMES}ZONE I=2 F=BLOCK VARLOCATION=([3]=CELLCENTERED)\n1 2 3\n", "not in cells"),
        (f"{NAMES}ZONE\n1 2 3 4\nVARIABLES = X Y\nZONE\n1 2\n", "must have one set of names"),
        ("VARIABLES = X\nZONE\n1\n2\n", "must have columns x, y and z"),
    ],
)  # fmt: skip
def test_damaged_zones_are_located(tmp_path: Path, text: str, message: str) -> None:
    path = written(tmp_path / "a.dat", text)
    with pytest.raises(NeurbsError, match=message):
        neurbs.read_points(path)
