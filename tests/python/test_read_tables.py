"""Points from text tables: separators, headers, columns, encodings, errors."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import neurbs
from neurbs import NeurbsError

FAR = [[5000000.001, 7500000.0, 120.25], [0.1, -1e-300, 1e300], [1 / 3, 2.0, 3.0]]
"""Coordinates with all digits."""


def written(path: Path, content: str | bytes) -> Path:
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def rows(separator: str = " ") -> str:
    return "".join(separator.join(map(repr, row)) + "\n" for row in FAR)


@pytest.mark.parametrize("separator", [" ", "\t", ",", ";", ", ", " ; ", "   ", " \t "])
@pytest.mark.parametrize("suffix", [".xyz", ".txt", ".csv", ".XYZ"])
def test_text_keeps_every_digit(tmp_path: Path, separator: str, suffix: str) -> None:
    points = neurbs.read_points(written(tmp_path / f"p{suffix}", rows(separator)))
    assert points.tolist() == FAR
    assert points.dtype == np.float64
    assert points.flags.c_contiguous


@pytest.mark.parametrize(
    "text",
    [
        "# x y z\n\n" + rows() + "\n  \n# end",
        "//X Y Z\n" + rows(),
        rows().replace("\n", " # a comment\n"),
        rows().replace("\n", "  // a comment\n"),
        rows().replace("\n", "\r\n"),
        rows().replace("\n", "\r"),
        "x y z\n" + rows(),
        "Easting Northing Height\n" + rows(),
        '"X","Y","Z"\n' + rows(","),
        '"Point X" Y Z\n' + rows(),
        rows().replace("1e+300", '"1e300"'),
        "x;y;z;\n" + rows(";").replace("\n", ";\n"),
    ],
)
def test_comments_blank_lines_and_headers_are_no_points(tmp_path: Path, text: str) -> None:
    assert neurbs.read_points(written(tmp_path / "p.txt", text)).tolist() == FAR


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("id,z,Y,x\n7,3,2,1\n8,6,5,4\n", [[1, 2, 3], [4, 5, 6]]),
        ("name\tx\ty\tz\nbare ground\t1\t2\t3\ntree\t4\t5\t6\n", [[1, 2, 3], [4, 5, 6]]),
        ("1 2 3 255 0 0\n4 5 6 0 255 0\n", [[1, 2, 3], [4, 5, 6]]),
        ("1 2 3 ground\n4 5 6 tree\n", [[1, 2, 3], [4, 5, 6]]),
        ("point no\tx\ty\tz\n1\t2\t3\t4\n", [[2, 3, 4]]),
        ("1 2\n3 4\n", [[1, 2, 0], [3, 4, 0]]),
        ("x,y\n1,2\n3,4\n", [[1, 2, 0], [3, 4, 0]]),
        ("1 2 3", [[1, 2, 3]]),
    ],
)
def test_columns_are_found(tmp_path: Path, text: str, expected: list[list[float]]) -> None:
    points = neurbs.read_points(written(tmp_path / "p.csv", text))
    assert points.tolist() == expected
    assert points.flags.c_contiguous


@pytest.mark.parametrize("encoding", ["utf-8-sig", "latin-1", "utf-16"])
def test_encodings_are_detected(tmp_path: Path, encoding: str) -> None:
    text = "# Höhe über Grund\nx,y,z,größe\n1,2,3,é\n4,5,6,ß\n"
    path = written(tmp_path / "p.csv", text.encode(encoding))
    assert neurbs.read_points(path).tolist() == [[1, 2, 3], [4, 5, 6]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 2 3\n4 abc 6\n", "line 2, column 2 must be a finite number, got 'abc'"),
        ("# c\n\nx y z\n1 2 3\n4 5 6e\n", "line 5, column 3 must be a finite number, got '6e'"),
        ("1,2,3\n4,,6\n", "line 2, column 2 must be a finite number, got nothing"),
        ("1;2;3\n4;5;1,2.5\n", "line 2, column 3 must be a finite number, got '1.2.5'"),
        ("1 2 3\n4 5 nan\n", "line 2, column 3 must be a finite number, got 'nan': remove"),
        ("1 2 3\n4 5 1e999\n", "line 2, column 3 must be a finite number, got '1e999': remove"),
        ("1 2 3\n4 5 1_0\n", "line 2, column 3 must be a finite number, got '1_0'"),
        ("1 2 3 a\n4 x 6 b\n", "line 2, column 2 must be a finite number, got 'x'"),
        ("1 2 3\n4 5\n", "line 2 must have 3 columns, as in line 1, got 2: column 3 is missing"),
        ("1 2 3\n4 5 6 7\n", "line 2 must have 3 .* got 4: column 4, '7', is one too many"),
        ("1 2 3 4\n5 6 7\n", "line 2 must have 4 columns, as in line 1, got 3"),
        ("1\n2\n", "line 1 must have columns x, y and z .* got column 1 only, '1'"),
        ("4\n1 2 3\n", "must have 4 points, as in line 1, but the file is cut short after 1"),
        ("1\n1 2 3\n4 5 6\n", "must have 1 points, as in line 1, but there are 2: remove"),
        ("no,x,y,z\n1,2,3\n", "line 2 must have 4 columns, as the header in line 1, got 3"),
        ("x y z\n" + "m" * 99 + " 2 3\n", "line 2, column 1 .* got 'm{39}…'"),
        ("", "must have at least one point, but the file is empty"),
        ("\n# only comments\n", "must have at least one point, but the file is empty"),
        ("# c\nx y z\n", "must have at least one point, but ends after the header in line 2"),
    ],
)
def test_a_damaged_table_is_located(tmp_path: Path, text: str, message: str) -> None:
    path = written(tmp_path / "p.txt", text)
    with pytest.raises(NeurbsError, match=f"^{re.escape(str(path))}: {message}"):
        neurbs.read_points(path)


def test_binary_data_in_a_text_file_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path / "p.xyz", bytes(range(256)) * 40)
    with pytest.raises(NeurbsError, match=r"p\.xyz: line"):
        neurbs.read_points(path)


# Variants of tables


@pytest.mark.parametrize(
    "text",
    [
        "1,5;2;-3,25e2\n4;5,5;6\n",
        "1,5 2,0 -3,25e2\n4,0 5,5 6,0\n",
        "1,5\t2\t-3,25e2\n4\t5,5\t6\n",
        "X;Y;Z\n1,5;2;-3,25e2\n4;5,5;6\n",
        "Rechts\tHoch\tHöhe\n1,5\t2,0\t-325,0\n4\t5,5\t6\n",
    ],
)
def test_decimal_commas(tmp_path: Path, text: str) -> None:
    path = written(tmp_path / "p.csv", text)
    assert neurbs.read_points(path).tolist() == [[1.5, 2, -325], [4, 5.5, 6]]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("# id x y z\n7 1 2 3\n8 4 5 6\n", [[1, 2, 3], [4, 5, 6]]),
        ("//Z,Y,X\n3,2,1\n6,5,4\n", [[1, 2, 3], [4, 5, 6]]),
        ("# made by x y z\n1 2 3\n4 5 6\n", [[1, 2, 3], [4, 5, 6]]),
        ("Northing,Easting,Elevation\n2,1,3\n5,4,6\n", [[1, 2, 3], [4, 5, 6]]),
        ("P1 1 2 3\nP2 4 5 6\n", [[1, 2, 3], [4, 5, 6]]),
        ('"tree, large",1,2,3\n"rock, small",4,5,6\n', [[1, 2, 3], [4, 5, 6]]),
        (",X,Y,Z,name\n0,1,2,3,a\n1,4,5,6,b\n", [[1, 2, 3], [4, 5, 6]]),
        ("x [m], y [m], z [m]\n1, 2, 3\n4, 5, 6\n", [[1, 2, 3], [4, 5, 6]]),
    ],
)
def test_columns_are_found_by_header_or_comment(
    tmp_path: Path, text: str, expected: list[list[float]]
) -> None:
    assert neurbs.read_points(written(tmp_path / "p.csv", text)).tolist() == expected


def test_a_header_without_coordinates_asks_for_columns(tmp_path: Path) -> None:
    path = written(tmp_path / "p.csv", "id,time,x,y\n1,2,3,4\n")
    with pytest.raises(NeurbsError, match=r"header in line 1 must name x, y and z, .* `columns`"):
        neurbs.read_points(path)
    assert neurbs.read_points(path, columns=["x", "y"]).tolist() == [[3, 4, 0]]
    path = written(tmp_path / "q.csv", "name,a,b\nfirst,1,2\n")
    with pytest.raises(
        NeurbsError,
        match=r"line 2 must have three columns of numbers, got 'first', '1', '2': choose .*`",
    ):
        neurbs.read_points(path)


@pytest.mark.parametrize(
    ("columns", "expected"),
    [
        (("b", "c", "a"), [[2, 3, 1], [5, 6, 4]]),
        ((2, 1, 0), [[3, 2, 1], [6, 5, 4]]),
        (["A", 2], [[1, 3, 0], [4, 6, 0]]),
    ],
)
def test_columns_of_choice(
    tmp_path: Path, columns: list[str | int], expected: list[list[float]]
) -> None:
    path = written(tmp_path / "p.csv", "a,b,c\n1,2,3\n4,5,6\n")
    assert neurbs.read_points(path, columns=columns).tolist() == expected


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        (
            ("a", "b", "q"),
            "columns must be from 0 to 2 or of 'a', 'b', 'c', got",
        ),
        ((1, 2, 3), r"columns must be from 0 to 2 .* got \(1, 2, 3\)"),
        ((-1, 0, 1), r"columns must be from 0 to 2"),
        (("a",), "columns must be two or three names or numbers, got"),
        ((1.5, 2, 3), "columns must be two or three names or numbers, got"),
    ],
)
def test_columns_that_are_not_there(tmp_path: Path, columns: Any, message: str) -> None:
    path = written(tmp_path / "p.csv", "a,b,c\n1,2,3\n4,5,6\n")
    with pytest.raises(NeurbsError, match=message):
        neurbs.read_points(path, columns=columns)
    path = written(tmp_path / "p.ply", b"ply\n")
    with pytest.raises(NeurbsError, match=r"columns must be left out, unless the file is \.xyz"):
        neurbs.read_points(path, columns=(0, 1, 2))


def test_pts_of_several_scans(tmp_path: Path) -> None:
    text = "2\n1 2 3 -500 10 20 30\n4 5 6 9 1 2 3\n1\n7 8 9 0 255 255 255\n"
    cloud = neurbs.read_point_cloud(written(tmp_path / "p.pts", text))
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6], [7, 8, 9]]
    assert cloud.colors is not None
    assert cloud.colors.tolist() == [[10, 20, 30], [1, 2, 3], [255, 255, 255]]
    with pytest.raises(NeurbsError, match=r"must have 3 points, .* but is cut short after 2"):
        neurbs.read_points(written(tmp_path / "p.pts", text.replace("\n7 8 9 0 255 255 255", "")))
    assert neurbs.read_points(written(tmp_path / "p.pts", "1 2 3\n")).tolist() == [[1, 2, 3]]
    with pytest.raises(NeurbsError, match="must have columns x, y and z"):
        neurbs.read_points(written(tmp_path / "p.pts", "7\n"))


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1", "cp1252"])
@pytest.mark.parametrize("suffix", [".xyz", ".txt", ".csv", ".asc", ".pts"])
def test_every_table_in_every_encoding(tmp_path: Path, suffix: str, encoding: str) -> None:
    path = written(tmp_path / f"p{suffix}", "x;y;z;Größe\n1;2;3;ä\n".encode(encoding))
    assert neurbs.read_points(path).tolist() == [[1, 2, 3]]


# The rule for columns: by names, else by content


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("Lon;Lat;Depth [m]\n1,5;2;3\n4;5;6\n", [[1.5, 2, 3], [4, 5, 6]]),
        ("X (mm),Y (mm),Z (mm)\n1,2,3\n", [[1, 2, 3]]),
        ("z_m,y_m,x_m\n3,2,1\n", [[1, 2, 3]]),
        ("UTM_N,UTM_E,Elev.\n2,1,3\n", [[1, 2, 3]]),
        ("Nr Rechtswert Hochwert Höhe\n7 1 2 3\n8 4 5 6\n", [[1, 2, 3], [4, 5, 6]]),
        ('"Points:0","Points:1","Points:2","s"\n1,2,3,9\n', [[1, 2, 3]]),
        ("x-coordinate\ty-coordinate\tz-coordinate\n1\t2\t3\n", [[1, 2, 3]]),
        ("N,E,H,Code\n2,1,3,A\n5,4,6,B\n", [[1, 2, 3], [4, 5, 6]]),
        ("lon,lat,x,y,z\n9,9,1,2,3\n", [[1, 2, 3]]),
        ("Point#,X,Y,Z\n1,1,2,3\n", [[1, 2, 3]]),
        ("X,Y,Z\n1 2 3\n4 5 6\n", [[1, 2, 3], [4, 5, 6]]),
        ("x;y;z\n1;2;3;\n4;5;6;\n", [[1, 2, 3], [4, 5, 6]]),
        ("x;y;z;\n1;2;3\n4;5;6\n", [[1, 2, 3], [4, 5, 6]]),
        ("no;x;y;z;code\n;m;m;m\n1;1;2;3;\n2;4;5;6;B\n", [[1, 2, 3], [4, 5, 6]]),
        ('"x" "y" "z"\n"1" 1 2 3\n"2" 4 5 6\n', [[1, 2, 3], [4, 5, 6]]),
        ("# Z Y X\n7 3 2 1\n8 6 5 4\n", [[1, 2, 3], [4, 5, 6]]),
        ("id;//X;Y;Z\n7;1;2;3\n", [[1, 2, 3]]),
        ("id,x,y\n7,1,2\n8,3,4\n", [[1, 2, 0], [3, 4, 0]]),
    ],
)
def test_columns_have_many_names(tmp_path: Path, text: str, expected: list[list[float]]) -> None:
    assert neurbs.read_points(written(tmp_path / "p.csv", text)).tolist() == expected


@pytest.mark.parametrize(
    "text",
    [
        "Survey of the hill\nDate: 2024-03-12\nPoint,E,N,H,Code\n1,1,2,3,A\n2,4,5,6,B\n",
        "X;Y;Z\n[m];[m];[m]\n1;2;3\n4;5;6\n",
        "no,x,y,z\n-,m,m,m\n1,1,2,3\n2,4,5,6\n",
        "2\n1 2 3\n4 5 6\n",
        "2\nwater\nO 1 2 3\nH 4 5 6\n",
        'TITLE = "a"\nVARIABLES = "Z", "X", "Y"\nZONE I=2, F=POINT\n3 1 2\n6 4 5\n',
        "x y z\n----- ----- -----\n1 2 3\n4 5 6\n",
        "% made by a program\n! x y z\n1 2 3\n4 5 6\n",
        "sep=;\nx;y;z\n1;2;3\n4;5;6\n",
        "2024-03-12 10:00 1 2 3\n2024-03-12 10:01 4 5 6\n",
        "A,1,2,3\nB,4,5,6\n",
        "1,A,2,3\n4,B,5,6\n",
    ],
)
@pytest.mark.parametrize("suffix", [".xyz", ".dat", ".csv", ".tsv"])
def test_lines_above_the_points_are_skipped(tmp_path: Path, text: str, suffix: str) -> None:
    points = neurbs.read_points(written(tmp_path / f"p{suffix}", text))
    assert points.tolist() == [[1, 2, 3], [4, 5, 6]]


def test_a_row_of_units_gives_the_unit(tmp_path: Path) -> None:
    path = written(tmp_path / "p.csv", "X;Y;Z\n[ft];[ft];[ft]\n1;2;3\n")
    assert neurbs.read_point_cloud(path).unit == "ft"


@pytest.mark.parametrize(
    ("text", "expected", "reason"),
    [
        ("1,10,20,5\n2,11,21,6\n", [[10, 20, 5], [11, 21, 6]], "column 0 counts the rows"),
        ("7 10 20 5 TREE\n8 11 21 6 ROCK\n", [[10, 20, 5], [11, 21, 6]], "column 0 counts"),
        ("101,1.5,2,3\n7,4,5,6\n", [[101, 1.5, 2], [7, 4, 5]], "column 0 may number the points"),
        (
            "1,10.5,20.5,5.25,EP\n2,11.5,21.5,6,EP\n5,12.5,22,7.5,TREE\n",
            [[10.5, 20.5, 5.25], [11.5, 21.5, 6], [12.5, 22, 7.5]],
            "column 0 numbers the points and is skipped; x is column 1 and y 2",
        ),
        (
            "101 1.5 2.5 3.5\n102 4.5 5.5 6.5\n103 5.5 6.5 7.5\n",
            [[1.5, 2.5, 3.5], [4.5, 5.5, 6.5], [5.5, 6.5, 7.5]],
            "column 0 counts the rows and is skipped; .* many surveys have northing first",
        ),
        (
            "1,10.5,20.5,5.25\n2A,11.5,21.5,6.5\nCP1,12.5,22.5,7.5\n4,13.5,2.5,3.5\n",
            [[10.5, 20.5, 5.25], [11.5, 21.5, 6.5], [12.5, 22.5, 7.5], [13.5, 2.5, 3.5]],
            "column 0 numbers the points and is skipped",
        ),
        (
            "0 5.5 1.25 7.5\n7 5.5 1.5 7.5\n9 5.5 1.75 7.5\n",
            [[0, 5.5, 1.25], [7, 5.5, 1.5], [9, 5.5, 1.75]],
            "column 0 may number the points",
        ),
        (
            "1 1.5 2.5 3.5\n2 4.5 5.5 6.5\n2 7.5 8.5 9.5\n",
            [[1, 1.5, 2.5], [2, 4.5, 5.5], [2, 7.5, 8.5]],
            "column 0 may number the points",
        ),
        (
            "1.0 1.5 2.5 3.5\n2.0 4.5 5.5 6.5\n",
            [[1, 1.5, 2.5], [2, 4.5, 5.5]],
            "column 0 may number the points",
        ),
        (
            "0 5.5 1.25 7.5\n10 5.5 1.5 7.5\n20 5.5 1.75 7.5\n",
            [[0, 5.5, 1.25], [10, 5.5, 1.5], [20, 5.5, 1.75]],
            "column 0 may number the points",
        ),
        ("0,1,2\n1.5,2,3\n", [[1.5, 2, 3]], "line 1, '0,1,2', is read as a header"),
        (",0,1,2\n0,1.5,2,3\n1,4,5,6\n", [[1.5, 2, 3], [4, 5, 6]], "header, .*; column 0 counts"),
        ("a,b,c\n1,2,3\n", [[1, 2, 3]], "the names 'a', 'b', 'c' are not known"),
        ("x,y,value\n1,2,3\n", [[1, 2, 3]], "z has no known name"),
        ("x y z\n9 8q 7q\n1 2 3\n", [[1, 2, 3]], "line 2, '9 8q 7q', is read as a header"),
        ("Hill 12 March 2024\n1 2 3\n4 5 6\n", [[1, 2, 3], [4, 5, 6]], "line 1, .* as a title"),
    ],
)
def test_a_guess_is_a_warning(
    tmp_path: Path, text: str, expected: list[list[float]], reason: str
) -> None:
    path = written(tmp_path / "p.csv", text)
    with pytest.warns(neurbs.ColumnsGuessedWarning, match=f"as a guess: .*{reason}") as seen:
        assert neurbs.read_points(path).tolist() == expected
    assert len(seen) == 1
    assert seen[0].filename == __file__
    with pytest.warns(neurbs.ColumnsGuessedWarning, match="as a guess"):
        cloud = neurbs.read_point_cloud(path)
    assert cloud.columns is not None
    assert cloud.columns in str(seen[0].message) or cloud.columns.startswith("x, y, z are columns")
    with pytest.warns(neurbs.ColumnsGuessedWarning):
        chunks = list(neurbs.read_points(path, chunks=1))
    assert np.vstack(chunks).tolist() == expected


@pytest.mark.filterwarnings("error::neurbs.NeurbsWarning")
@pytest.mark.parametrize(
    ("text", "columns", "expected"),
    [
        ("1,10,20,5\n2,11,21,6\n", (0, 1, 2), [[1, 10, 20], [2, 11, 21]]),
        ("1,10,20,5\n2,11,21,6\n", (1, 2, 3), [[10, 20, 5], [11, 21, 6]]),
        ("x,y,Vp,Depth (m)\n1,2,9,3\n", ("x", "y", "depth (m)"), [[1, 2, 3]]),
        ("x,y,Vp,Depth (m)\n1,2,9,3\n", ("x", "y", "Depth"), [[1, 2, 3]]),
    ],
)
def test_the_given_columns_decide(
    tmp_path: Path, text: str, columns: tuple[str | int, ...], expected: list[list[float]]
) -> None:
    path = written(tmp_path / "p.csv", text)
    assert neurbs.read_points(path, columns=columns).tolist() == expected


@pytest.mark.filterwarnings("error::neurbs.NeurbsWarning")
@pytest.mark.parametrize(
    "text",
    [
        "1 2 3\n4 5 6\n",
        "1 2 3 0.5\n1 2.5 6 0.7\n",
        "0.5,1,2\n4,5,6\n",
        "1,2,3,4\n2,2,2,2\n3,1,1,1\n5,0,0,0\n",
        "1 1 2.5 0.5\n1 2 3.5 0.5\n2 1 4.5 0.5\n2 2 5.5 0.5\n",
        "id,x,y,z\n1,1,2,3\n2,4,5,6\n",
        "P1 1 2 3\nP2 4 5 6\n",
    ],
)
def test_what_is_clear_is_no_guess(tmp_path: Path, text: str) -> None:
    neurbs.read_points(written(tmp_path / "p.csv", text))


def test_a_line_says_what_was_read(tmp_path: Path) -> None:
    path = written(tmp_path / "p.csv", "title\nLon;Lat;Depth [m]\n1;2;3\n")
    found = "x, y, z are columns 'Lon', 'Lat', 'Depth [m]'; the points start in line 3"
    assert neurbs.read_point_cloud(path).columns == found
    path = written(tmp_path / "q.csv", "A,1,2,3\nB,4,5,6\n")
    found = "x, y, z are columns 1, 2, 3, counted from 0; the points start in line 1"
    assert neurbs.read_point_cloud(path).columns == found


def test_messages_have_the_names_that_are_there(tmp_path: Path) -> None:
    path = written(tmp_path / "p.csv", "x,y,Vp,Vs\n1,2,3,4\n")
    with pytest.raises(NeurbsError, match=r"must name x, y and z, got 'x', 'y', 'Vp', 'Vs'"):
        neurbs.read_points(path)
    with pytest.raises(NeurbsError, match=r"from 0 to 3 or of 'x', 'y', 'Vp', 'Vs', got"):
        neurbs.read_points(path, columns=("x", "y", "depth"))


def test_colors_and_normals_of_tables_of_six_columns(tmp_path: Path) -> None:
    text = "1 2 3 1.0 0.5 0\n4 5 6 0 0 1\n"
    cloud = neurbs.read_point_cloud(written(tmp_path / "p.xyzrgb", text))
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert cloud.colors is not None
    assert cloud.colors.tolist() == [[255, 128, 0], [0, 0, 255]]
    cloud = neurbs.read_point_cloud(written(tmp_path / "p.xyzn", text))
    assert cloud.normals is not None
    assert cloud.normals.tolist() == [[1, 0.5, 0], [0, 0, 1]]


def test_prose_is_no_table(tmp_path: Path) -> None:
    path = written(tmp_path / "p.txt", "a line without numbers\n" * 3000)
    with pytest.raises(NeurbsError, match="no points are in its first 1,000 lines"):
        neurbs.read_points(path)


@pytest.mark.filterwarnings("error::neurbs.NeurbsWarning")
@pytest.mark.parametrize(
    "text",
    [
        "title\n3\nX\nY\nZ (m)\n1 2 3\n4 5 6\n",
        "ore\n4\nX coordinate\nY coordinate\nZ\ngrade\n1 2 3 9\n4 5 6 9\n",
        "X coordinate   Y coordinate   Z coordinate\n1 2 3\n4 5 6\n",
        "; made by a tool\n; X Y Z\n1 2 3\n4 5 6\n",
        "* X Y Z\n1 2 3\n4 5 6\n",
        "> segment 1\n1 2 3\n> segment 2\n4 5 6\n",
        "Leste;Norte;Quota\n1;2;3\n4;5;6\n",
        "lon_dd,lat_dd,z_m\n1,2,3\n4,5,6\n",
        "Rechtswert in m;Hochwert in m;Höhe in m\n1;2;3\n4;5;6\n",
        "x−y\nx y z\n1 2 3\n4 5 6\n",
    ],
)
def test_headers_of_more_programs(tmp_path: Path, text: str) -> None:
    path = written(tmp_path / "p.txt", text)
    assert neurbs.read_points(path).tolist() == [[1, 2, 3], [4, 5, 6]]


def test_numbers_above_the_names_are_a_guess(tmp_path: Path) -> None:
    path = written(tmp_path / "p.txt", "Operator: Kim\nOffset: 0 0 0\nX Y Z\n1 2 3\n4 5 6\n")
    with pytest.warns(neurbs.ColumnsGuessedWarning, match="line 2, 'Offset: 0 0 0', is read as a"):
        assert neurbs.read_points(path).tolist() == [[1, 2, 3], [4, 5, 6]]
    path.write_text("7 8 9\nX Y Z\n1 2 3\n")
    with pytest.raises(NeurbsError, match="line 2, column 1 must be a finite number, got 'X'"):
        neurbs.read_points(path)


def test_lines_without_numbers_are_explained(tmp_path: Path) -> None:
    path = written(tmp_path / "p.txt", "X=1 Y=2 Z=3\nX=4 Y=5 Z=6\n")
    with pytest.raises(NeurbsError, match="none of its lines, up to 2, has two columns of numbers"):
        neurbs.read_points(path)


# Tables of many programs

NAMES = (
    "x y z", "X Y Z", "Easting Northing Elevation", "E N H", "Lon Lat Alt", "x_m y_m z_m",
    "Longitude Latitude Depth", "X(m) Y(m) Z(m)", "utm_x utm_y elev", "POINT_X POINT_Y POINT_Z",
    "Rechtswert Hochwert Höhe", "XCoord YCoord ZCoord", "px py pz", "x0 y0 z0", "#x y z",
)  # fmt: skip


@pytest.mark.filterwarnings("ignore::neurbs.ColumnsGuessedWarning")
@pytest.mark.parametrize("seed", range(200))
def test_tables_of_many_kinds_are_read_right(tmp_path: Path, seed: int) -> None:
    """Titles, names, units, numbers and codes of points come and go; columns change places."""
    rng = np.random.default_rng(seed)

    def maybe() -> bool:
        return bool(rng.random() < 0.4)

    count = int(rng.choice([2, 5, 40]))
    points = rng.uniform(-1e3, 1e6, (count, 3)).round(3)
    columns = [[f"{value}" for value in column] for column in points.T]
    names = str(rng.choice(NAMES)).split()
    named = bool(rng.random() < 0.7)
    if named and maybe():
        order = rng.permutation(3)
        columns, names = [columns[i] for i in order], [names[i] for i in order]
    if maybe():
        columns.insert(0, [str(i + 1) for i in range(count)])
        names.insert(0, str(rng.choice(["id", "No", "Point", "FID"])))
    if maybe():
        columns.append([str(rng.choice(["TREE", "A1", "7b"])) for _ in range(count)])
        names.append("code")
    if maybe():
        columns.append([f"{value:.2f}" for value in rng.random(count)])
        names.append("intensity")
    separator = str(rng.choice([",", ";", "\t", " ", ", "]))
    lines = [separator.join(row) for row in zip(*columns, strict=True)]
    above = [str(rng.choice(["My survey", "Project: hill 12", "# a comment"]))] if maybe() else []
    if named:
        above += [separator.join(names)]
        above += [separator.join("m" for _ in names)] if maybe() else []
    elif maybe():
        above += [str(count)]
    path = written(tmp_path / "p.csv", "\n".join([*above, *lines]) + "\n")
    np.testing.assert_array_equal(neurbs.read_points(path), points)
