"""Numbers and units in text tables: marks between thousands, words, and what may be misread."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import neurbs
from neurbs import NeurbsError


def written(path: Path, content: str) -> Path:
    path.write_text(content, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "text",
    [
        "X;Y;Z\n600.123,25;4.800.210,5;99,5\n124;1.210,125;0,25\n",
        "X;Y;Z\n600,123.25;4,800,210.5;99.5\n124;1,210.125;0.25\n",
        "600,123.25\t4,800,210.5\t99.5\n124\t1,210.125\t0.25\n",
        "600,123.25 4,800,210.5 99.5\n124 1,210.125 0.25\n",
        'X,Y,Z\n"600,123.25","4,800,210.5",99.5\n124,"1,210.125",0.25\n',
        'X,Y,Z\n"600.123,25","4.800.210,5","99,5"\n124,"1.210,125","0,25"\n',
        "600'123.25 4'800'210.5 99.5\n124 1'210.125 0.25\n",
        "600'123,25;4'800'210,5;99,5\n124;1'210,125;0,25\n",
        "600 123,25;4 800 210,5;99,5\n124;1 210,125;0,25\n",
        "X\tY\tZ\n600\u00a0123,25\t4\u00a0800\u00a0210,5\t99,5\n124\t1\u00a0210,125\t0,25\n",
        "P1;600.123,25;4.800.210,5;99,5;TREE\nP2;124;1.210,125;0,25;\n",
        '"P1","600,123.25","4,800,210.5",99.5\n"P2",124,"1,210.125",0.25\n',
        "P1 600'123.25 4'800'210.5 99.5 EP\nP2 124 1'210.125 0.25 EP\n",
        "X|Y|Z\n600123.25|4800210.5|99.5\n124|1210.125|0.25\n",
        "| X | Y | Z |\n|---|---|---|\n| 600123.25|4800210.5|99.5|\n|124|1210.125|0.25|\n",
    ],
)  # fmt: skip
def test_thousands_are_read_where_they_are_certain(tmp_path: Path, text: str) -> None:
    points = neurbs.read_points(written(tmp_path / "p.csv", text))
    assert points.tolist() == [[600123.25, 4800210.5, 99.5], [124, 1210.125, 0.25]]


@pytest.mark.parametrize(
    "text",
    [
        "1,25;2,125;3,5;1,234.5\n4,5;5,125;6;7\n",
        "1.25;2.125;3.5;1.234,5\n4.5;5.125;6;7\n",
        "1,250;2,125;3,500;1,234.5\n4,500;5,125;6,0;7\n",
        "1.25\t2.125\t3.5\t1.234,5\n4.5\t5.125\t6.\t7\n",
    ],
)
def test_marks_have_one_meaning_in_a_table(tmp_path: Path, text: str) -> None:
    points = neurbs.read_points(written(tmp_path / "p.txt", text))
    assert points.tolist() == [[1.25, 2.125, 3.5], [4.5, 5.125, 6]]


def test_marks_of_other_columns_change_no_number(tmp_path: Path) -> None:
    path = written(tmp_path / "p.csv", "1.5;2.125;3.25;192.168.100.200\n4.5;5.125;6;01.03.2024\n")
    assert neurbs.read_points(path).tolist() == [[1.5, 2.125, 3.25], [4.5, 5.125, 6]]
    path.write_text('x,y,z,name\n1.5,2.125,3,"a, 1,234.5"\n')
    assert neurbs.read_points(path).tolist() == [[1.5, 2.125, 3]]


def test_old_words_for_what_is_not_finite(tmp_path: Path) -> None:
    path = written(tmp_path / "p.txt", "1 2 3\n4 5 ****\n6 7 1.#IND\n8 -1.#QNAN00 9 # end\n")
    assert neurbs.read_points(path, nan="drop").tolist() == [[1, 2, 3]]
    with pytest.raises(NeurbsError, match=r"line 2, column 3 .* got '\*{4}': remove or repair"):
        neurbs.read_points(path)


@pytest.mark.parametrize("name", ["us-ft", "ftUS", "US Survey Feet"])
def test_survey_feet_have_many_names(tmp_path: Path, name: str) -> None:
    path = written(tmp_path / "p.csv", f"x ({name}),y ({name}),z ({name})\n1,2,3\n")
    assert neurbs.read_point_cloud(path).unit == "US survey foot"


# Numbers that may be misread


@pytest.mark.parametrize("separator", [" ", ";", "\t"])
def test_commas_that_may_separate_thousands_are_refused(separator: str, tmp_path: Path) -> None:
    path = tmp_path / "p.txt"
    path.write_text(separator.join(["1,234", "2,000", "3,000"]) + "\n")
    with pytest.raises(NeurbsError, match=r"line 1 has 1,234, which may be 1\.234 or 1234: write"):
        neurbs.read_points(path)
    # One number that can only have decimals is enough.
    for row in ("1,234 2,000 3,00", "1,234 0,125 3,000", "4567,125 1,234 2,000"):
        path.write_text("1,234 2,000 3,000\n".replace(" ", separator) + row.replace(" ", separator))
        assert neurbs.read_points(path)[0].tolist() == [1.234, 2, 3]


def test_commas_in_a_grid_that_may_separate_thousands_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "p.asc"
    head = "ncols 2\nnrows 1\nxllcorner {}\nyllcorner 0\ncellsize 2\n"
    for corner, row in (("0", "1,234 2"), ("500,000", "1 2")):
        path.write_text(f"{head.format(corner)}{row}\n")
        with pytest.raises(NeurbsError, match=r"which may be .* write numbers with a decimal"):
            neurbs.read_points(path)
    path.write_text(head.format("500,000") + "1,5 2\n")
    assert neurbs.read_points(path).tolist() == [[501, 1, 1.5], [503, 1, 2]]


def test_exponents_of_fortran_are_read(tmp_path: Path) -> None:
    path = tmp_path / "p.txt"
    path.write_text("1.0D+03 .5d0 -2.D-1\n4.0D0 5 6\n")
    assert neurbs.read_points(path).tolist() == [[1000, 0.5, -0.2], [4, 5, 6]]
    path.write_text("x,y,z\n1,2,3\n4.0D+00,5.0D+00,6.0D+00\n")
    assert neurbs.read_points(path).tolist() == [[1, 2, 3], [4, 5, 6]]
    path.write_text("12D3 1 2 3\nP1.D5 4 5 6\n")
    with pytest.raises(NeurbsError):
        neurbs.read_points(path, columns=(0, 1, 2))


def test_hexadecimal_numbers_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "p.txt"
    for row in ("0x1F 0x2A 0x3C", "0x1.8p3 0x2 0x3"):
        path.write_text(f"{row}\n1 2 3\n")
        with pytest.raises(NeurbsError, match="line 1, column 1 must be a finite number, got '0x1"):
            neurbs.read_points(path)


@pytest.mark.parametrize("cell", ["0", "-1", "nan", "inf"])
def test_a_grid_without_a_size_of_its_cells_is_refused(cell: str, tmp_path: Path) -> None:
    path = tmp_path / "p.asc"
    path.write_text(f"ncols 2\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize {cell}\n1 2\n")
    with pytest.raises(NeurbsError, match="cellsize above 0"):
        neurbs.read_points(path)


@pytest.mark.parametrize(
    ("header", "unit"),
    [
        ("x [mm],y [mm],z [m]", "mm, z: m"),
        ("lon [deg],lat [°],height [m]", "degree, z: m"),
        ("x [millimetre],y [mm],z [mm]", "mm"),
        ("X,Y,Depth [ft]", None),
        ("X [m],Y [m],Z", None),
        ("X [m],Y,Z", None),
    ],
)
def test_columns_have_units_of_their_own(tmp_path: Path, header: str, unit: str | None) -> None:
    path = written(tmp_path / "p.csv", f"{header}\n1,2,3\n")
    cloud = neurbs.read_point_cloud(path)
    assert cloud.unit == unit
    neurbs.save(cloud, tmp_path / "q.csv")
    again = neurbs.read_point_cloud(tmp_path / "q.csv")
    assert (again.unit, again.points.tolist()) == (unit, [[1, 2, 3]])


def test_columns_with_units_of_their_own_are_converted(tmp_path: Path) -> None:
    path = written(tmp_path / "p.csv", "x [m],y [m],depth [ft]\n1,2,10\n")
    np.testing.assert_allclose(neurbs.read_points(path, unit="m"), [[1, 2, 3.048]])
    path.write_text("x [ft],y [deg],z [ft]\n1,2,3\n")
    with pytest.raises(NeurbsError, match=r"x and y must have the same unit, .* has ft and degree"):
        neurbs.read_point_cloud(path)


def test_columns_without_a_unit_can_only_have_that_of_the_others(
    tmp_path: Path, command: Callable[..., Any]
) -> None:
    path = written(tmp_path / "p.csv", "X,Y,Depth [ft]\n1,2,3\n")
    cloud = neurbs.read_point_cloud(path, unit="ft")
    assert (cloud.unit, cloud.points.tolist()) == ("ft", [[1, 2, 3]])
    with pytest.raises(NeurbsError, match=r"unit must be 'ft' .* no unit of x and y, got 'mm'"):
        neurbs.read_points(path, unit="mm")
    done = command("convert", path, tmp_path / "q.csv", "--unit", "mm")
    assert (done.code, "no unit of x and y, got 'mm'" in done.err) == (1, True)
