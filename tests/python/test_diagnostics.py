"""Diagnostics, their warnings, and the candidates of the report."""

import dataclasses
import pickle
import re
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs
from neurbs import Candidate, Diagnostic, NeurbsWarning, Reconstruction, _core
from neurbs.diagnostics import CATEGORIES, READER_CODES

Points = NDArray[np.float64]
DOCS = Path(__file__).parents[2] / "docs"


def missed(points: Points) -> Reconstruction:
    """Miss a tolerance."""
    return neurbs.reconstruct(points, tolerance=1e-6, max_control_points=50)


def test_each_code_has_a_public_class() -> None:
    codes = [code for code, _ in [*_core.DIAGNOSTIC_CODES, *READER_CODES]]
    assert list(CATEGORIES) == codes
    assert len(set(codes)) == len(codes)
    for code, category in CATEGORIES.items():
        assert issubclass(category, NeurbsWarning)
        assert category.code == code
        assert category.__name__ in neurbs.__all__
        assert getattr(neurbs, category.__name__) is category
        assert pickle.loads(pickle.dumps(category)) is category
    assert neurbs.FoldedWarning.code == "folded"
    assert neurbs.ConvergenceWarning.code == "not-settled"


@pytest.mark.parametrize(
    ("page", "codes"), [("choosing", _core.DIAGNOSTIC_CODES), ("point-files", READER_CODES)]
)
def test_the_docs_have_the_table_of_codes(page: str, codes: list[tuple[str, str]]) -> None:
    text = (DOCS / f"{page}.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `([a-z-]+)` \| `(\w+)` \| (.+) \|$", text, re.MULTILINE)
    assert rows == [(code, CATEGORIES[code].__name__, meaning) for code, meaning in codes]


def test_each_diagnostic_is_one_warning(terrain_points: Points) -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        result = missed(terrain_points)
    found = result.report.diagnostics
    assert [warning.category for warning in caught] == [CATEGORIES[one.code] for one in found]
    assert [str(warning.message) for warning in caught] == [one.message for one in found]
    # The caller is to blame, not the package.
    assert {warning.filename for warning in caught} == {__file__}


def test_a_warning_can_be_an_error(terrain_points: Points) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", neurbs.FoldedWarning)
        warnings.simplefilter("ignore", neurbs.ToleranceMissedWarning)
        missed(terrain_points)
        warnings.simplefilter("error", neurbs.ToleranceMissedWarning)
        with pytest.raises(neurbs.ToleranceMissedWarning, match="not reached"):
            missed(terrain_points)


def test_validate_finds_defects(rng: np.random.Generator) -> None:
    x, y = rng.random((2, 800))
    sheet = np.column_stack([x, y, 0.2 * np.sin(3 * x) * y])
    surface = neurbs.fit_heights(sheet, (8, 8)).surface
    assert neurbs.validate(surface, sheet) == []
    net = surface.control_points.copy()
    net[3, :, 0] += 0.8
    folded = neurbs.NurbsSurface(net, degree=surface.degree, knots=surface.knots)
    (found,) = neurbs.validate(folded, sheet)
    assert (found.code, found.is_defect) == ("folded", True)
    assert 0.01 < found.data["share"] < 1
    assert str(found) == found.message
    net = surface.control_points.copy()
    net[4, 4, 2] += 5
    bulged = neurbs.NurbsSurface(net, degree=surface.degree, knots=surface.knots)
    assert "overshoot" in [one.code for one in neurbs.validate(bulged, sheet)]
    with pytest.raises(neurbs.NeurbsError, match="finite"):
        neurbs.validate(surface, sheet * np.nan)


def test_candidates_are_ranked(rng: np.random.Generator) -> None:
    x, y = rng.random((2, 800))
    sheet = np.column_stack([x, y, 0.2 * np.sin(3 * x) * y])
    first, *_ = neurbs.candidates(sheet)
    assert (first.kind, first.rank, first.outcome) == ("height", 1, "chosen")
    assert first.direction == (0, 0, 1)
    assert neurbs.candidates(sheet, "sheet")[0].kind == "sheet"
    with pytest.raises(neurbs.NeurbsError, match="kind must be"):
        neurbs.candidates(sheet, "cone")  # type: ignore[arg-type]


CANDIDATES = (
    Candidate("plane z", "height", (0.0, 0.0, 1.0), 0.41, {"held_out": 0.41}, 1, "chosen"),
    Candidate("isomap", "sheet", None, 0.9312, {"held_out": 0.93}, 2, "score"),
    Candidate("center line", "tube", None, None, {}, None, "a gap of 90 degrees"),
)


def test_the_report_has_the_candidates(result: Reconstruction, tmp_path: Path) -> None:
    thick = Diagnostic("thick", "The points fill a volume.", {"rms": 1.0, "diagonal": 2.0}, True)
    report = dataclasses.replace(
        result.report, candidates=CANDIDATES, diagnostics=(thick,), valid=False
    )
    lines = str(report).splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith("candidates"))
    assert [line.split(maxsplit=1)[-1] for line in lines[start : start + 1]] == [
        "1  plane z      height  0.410  chosen"
    ]
    assert lines[start + 1].strip() == "2  isomap       sheet   0.931  score"
    assert lines[start + 2].strip() == "–  center line  tube    –      a gap of 90 degrees"
    assert "not valid: thick" in str(report)
    plain = report.to_dict()
    assert plain["candidates"][0]["direction"] == [0.0, 0.0, 1.0]
    assert plain["diagnostics"][0]["code"] == "thick"
    pytest.importorskip("plotly", reason="plotly is not installed")
    dataclasses.replace(result, report=report).write_report(tmp_path / "a.html")
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    for words in ("<td>plane z</td>", "<td>0.931</td>", "a gap of 90 degrees", "fill a volume"):
        assert words in page


def test_results_can_be_pickled(result: Reconstruction) -> None:
    report = dataclasses.replace(result.report, candidates=CANDIDATES)
    assert pickle.loads(pickle.dumps(report)) == report


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("pieces", "neurbs.components"),
        ("Pieces", "neurbs.Components"),
        ("detect_topology", "neurbs.candidates"),
        ("Topology", "neurbs.Candidate"),
        ("inspect", "neurbs.validate"),
        ("free_weights", "neurbs.fit_weights"),
    ],
)
def test_the_error_for_an_old_name_gives_the_new_one(old: str, new: str) -> None:
    with pytest.raises(AttributeError, match=rf"no attribute '{old}': it is now {new}$"):
        getattr(neurbs, old)


def test_old_keywords_and_attributes_give_the_new_ones(result: Reconstruction) -> None:
    for old, new in [("topology", "kind"), ("pieces", "component"), ("method", "neurbs.reco")]:
        with pytest.raises(TypeError, match=rf"keyword argument '{old}': it is now {new}"):
            neurbs.reconstruct(np.eye(4, 3), **{old: 0})  # type: ignore[call-overload]
    with pytest.raises(TypeError, match="unexpected keyword argument 'speed'"):
        neurbs.reconstruct(np.eye(4, 3), speed=1)  # type: ignore[call-overload]
    for thing, old, new in [
        (result, "distances", "deviations"),
        (result.report, "topology", "kind"),
        (result.report, "warnings", "diagnostics"),
    ]:
        with pytest.raises(AttributeError, match=f"no attribute '{old}': it is now {new}"):
            getattr(thing, old)
    with pytest.raises(AttributeError, match=r"'Report' object has no attribute 'speed'$"):
        getattr(result.report, "speed")  # noqa: B009


def test_python_filters_by_class() -> None:
    program = "import warnings, neurbs; warnings.warn('x', neurbs.ToleranceMissedWarning)"
    for category, code in [("FoldedWarning", 0), ("ToleranceMissedWarning", 1)]:
        command = [sys.executable, "-W", f"error::neurbs.{category}", "-c", program]
        done = subprocess.run(command, capture_output=True, text=True, timeout=60)
        assert done.returncode == code, done.stderr


def test_pytest_filters_by_class(tmp_path: Path) -> None:
    (tmp_path / "test_it.py").write_text(
        "import warnings, neurbs\ndef test_it():\n"
        "    warnings.warn('x', neurbs.ToleranceMissedWarning)\n"
    )
    for category, code in [("FoldedWarning", 0), ("ToleranceMissedWarning", 1)]:
        command = [sys.executable, "-m", "pytest", "-q", "-W", f"error::neurbs.{category}"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60)
        assert done.returncode == code, done.stdout + done.stderr
