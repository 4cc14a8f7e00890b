"""The examples, links and pictures of the documentation."""

import re
from pathlib import Path

import numpy as np
import pytest

import neurbs
import neurbs.io
from neurbs.io.table_header import HORIZONTAL, VERTICAL, Header

DOCS = Path(__file__).parents[2] / "docs"
ALL = [*DOCS.glob("*.md"), *DOCS.glob("stages/*.md")]
STAGES = sorted(DOCS.glob("stages/*.md"))
PAGES = [page.stem for page in ALL if "```python\n" in page.read_text("utf-8")]


@pytest.mark.parametrize("page", PAGES)
def test_the_examples_of_a_page_run(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if page in ("start", "tutorial"):
        pytest.importorskip("plotly", reason="plotly is not installed")
    (tmp_path / "examples").symlink_to(DOCS.parent / "examples")
    monkeypatch.chdir(tmp_path)
    text = (DOCS / f"{page}.md").read_text(encoding="utf-8")
    examples = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    names: dict[str, object] = {}
    for example in examples:
        exec(example, names)


def test_links_of_the_pages_exist() -> None:
    for page in ALL:
        for target in re.findall(r"\]\(\s*([^)#\s]+)", page.read_text(encoding="utf-8")):
            assert (page.parent / target).exists(), f"{page.name}: {target}"


def test_every_picture_is_made_by_a_script() -> None:
    scripts = [*DOCS.glob("*.py"), *(DOCS.parent / "examples").glob("*.py")]
    sources = "".join(script.read_text(encoding="utf-8") for script in scripts)
    for picture in (DOCS / "images").iterdir():
        # By the stem, as some scripts take the name of the picture as an argument.
        assert picture.stem in sources, picture.name


@pytest.mark.parametrize("page", ["choosing", "stages/select"])
def test_pages_list_the_terms_of_the_score(page: str, rng: np.random.Generator) -> None:
    angle, height = rng.random((2, 500)) * [[2 * np.pi], [3.0]]
    pipe = np.column_stack([np.cos(angle), np.sin(angle), height])
    first, *_ = neurbs.candidates(pipe)
    text = (DOCS / f"{page}.md").read_text(encoding="utf-8")
    table = re.search(r"\| term \|.*?\n\n", text, re.DOTALL)
    assert table is not None
    assert re.findall(r"^\| `(\w+)`", table[0], re.MULTILINE) == list(first.terms)


@pytest.mark.parametrize("page", STAGES, ids=lambda page: page.stem)
def test_a_stage_has_all_sections_and_a_picture(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    sections = re.findall(r"^## (.+)$", text, re.MULTILINE)
    assert sections == ["Method", "Limits", "Test", "Settings"]
    assert "| input |" in text
    assert "| output |" in text
    assert "](../images/" in text


@pytest.mark.parametrize("page", STAGES, ids=lambda page: page.stem)
def test_the_tests_that_a_stage_names_exist(page: Path) -> None:
    section = page.read_text(encoding="utf-8").split("## Test\n")[1].split("\n## ")[0]
    names = re.findall(r"`([\w/.]+)::(\w+)`", section)
    assert names
    for place, name in names:
        path = DOCS.parent / place
        files = path.rglob("*.rs") if path.is_dir() else [path]
        found = re.compile(rf"\b(fn|def) {name}\(")
        assert any(found.search(file.read_text(encoding="utf-8")) for file in files), name


def test_the_charts_of_the_page_are_those_of_the_crate() -> None:
    text = (DOCS / "stages" / "propose.md").read_text(encoding="utf-8")
    table = re.search(r"\| chart \|.*?\n\n", text, re.DOTALL)
    assert table is not None
    first = re.findall(r"^\| (`.+?) \|", table[0], re.MULTILINE)
    sources = "".join(file.read_text("utf-8") for file in (DOCS.parent / "src/chart").glob("*.rs"))
    for name in re.findall(r"`([\w ]+)`", " ".join(first)):
        assert f'"{name}"' in sources, name


def test_the_names_of_columns_are_listed() -> None:
    text = (DOCS / "point-files.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^ +\| (x and y|z) \| (.+) \|$", text, re.MULTILINE))
    pairs = [tuple(Header.of(pair.split(","), 0).keys) for pair in rows["x and y"].split(";")]
    assert pairs == list(HORIZONTAL)
    # The last one is damaged by a wrong encoding.
    assert set(Header.of(rows["z"].split(","), 0).keys) == {*VERTICAL} - {"h\ufffdhe"}


def test_all_suffixes_are_listed() -> None:
    text = (DOCS / "point-files.md").read_text(encoding="utf-8")
    section = text.split("## Formats\n")[1].split("\n## ")[0]
    listed = set(re.findall(r"(?<![\w.])\.\w+", section))
    assert set(neurbs.io.READABLE) <= listed | {".laz"}
