"""Descriptions of points in text tables, which have any number of words."""

from pathlib import Path

import pytest

import neurbs
from neurbs import NeurbsError


def written(path: Path, content: str) -> Path:
    path.write_text(content, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "text",
    [
        "A 1 2 3 TREE OAK 2\u2033\nB 4 5 6 ROCK\nC 7 8 9\n",
        "A,1,2,3,TREE, OAK\nB,4,5,6,ROCK\nC,7,8,9\n",
        "No,E,N,Z,Desc\nA,1,2,3,TREE, OAK\nB,4,5,6,ROCK\nC,7,8,9,\n",
        "1 2 3 tree oak\n4 5 6 rock\n7 8 9 q\n",
    ],
)
def test_descriptions_have_any_number_of_words(tmp_path: Path, text: str) -> None:
    path = written(tmp_path / "p.txt", text)
    assert neurbs.read_points(path).tolist() == [[1, 2, 3], [4, 5, 6], [7, 8, 9]]
    whole = path.read_text()
    for row, message in (
        ("D 5 TREE", "must have"),
        ("D 5 6 TREE", "must be a finite number|must have"),
        ("D 5 6 7 8 9 TREE", "must have"),
    ):
        row = row if "A" in text else row[2:]
        path.write_text(whole + (row.replace(" ", ",") if ",1" in text else row) + "\n")
        with pytest.raises(NeurbsError, match=f"line \\d.*{message}"):
            neurbs.read_points(path)


def test_points_of_a_survey_have_descriptions(tmp_path: Path) -> None:
    rows = ["1,10.5,20.5,5.5,TREE OAK, OLD", "2,11.5,21.5,6.5,", "5,12.5,22.5,7.5"]
    path = written(tmp_path / "p.txt", "\n".join(rows) + "\n")
    with pytest.warns(neurbs.ColumnsGuessedWarning, match="column 0 numbers the points"):
        points = neurbs.read_points(path)
    assert points.tolist() == [[10.5, 20.5, 5.5], [11.5, 21.5, 6.5], [12.5, 22.5, 7.5]]


def test_a_description_in_quotation_marks_may_have_several_lines(tmp_path: Path) -> None:
    text = 'x,y,z,n\n1,2,3,"two\nlines"\n4,5,6,b\n'
    points = neurbs.read_points(written(tmp_path / "p.csv", text))
    assert points.tolist() == [[1, 2, 3], [4, 5, 6]]
