"""The tables of settings in the documentation are read from the Rust sources."""

import importlib.util
import re
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [
    *sorted((ROOT / "docs" / "stages").glob("*.md")),
    ROOT / "docs" / "shells.md",
    ROOT / "docs" / "theory.md",
]
DIRECTIVE = re.compile(r"```\{settings\} ([\w/]+)([^\n]*)\n(?::exclude:([^\n]*)\n)?")

SMALL = """
//! Settings.

/// Cleaning: duplicates
/// and gross outliers.
#[derive(Clone, Copy)]
pub(crate) struct CleanSettings {
    /// Neighbors whose mean distance, see [`Spacing`](super::Spacing), is the spacing of a place.
    /// Unit: points. Source: calibrated, up to 1.5, on the scoreboard.
    pub(crate) k_neighbors: usize,
    /// Least and largest ratio. Unit: none. Source: closed form: 1 - 1 / e.
    range: (f64, f64),
    /// The fit.
    pub fit: FitSettings,
}

impl CleanSettings {
    /// The values that are used.
    pub(crate) const STANDARD: Self = Self {
        // A comment, with a comma.
        k_neighbors: 8,
        range: (0.5, f64::EPSILON),
        fit: FitSettings::STANDARD,
    };
}

/// The fit.
struct FitSettings {
    /// Rounds. Unit: steps. Source: cost.
    rounds: usize,
}
impl FitSettings {
    const STANDARD: Self = Self { rounds: 2 * 3 };
}
"""


def load() -> ModuleType:
    """Import the extension, which is no part of the package."""
    spec = importlib.util.spec_from_file_location("settings", ROOT / "docs" / "settings.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["settings"] = module
    spec.loader.exec_module(module)
    return module


settings = load()


def test_structs_and_fields_are_read() -> None:
    clean, fit = settings.parse(SMALL)
    assert (clean.name, clean.meaning) == (
        "CleanSettings",
        "Cleaning: duplicates and gross outliers.",
    )
    assert [field.name for field in clean.fields] == ["k_neighbors", "range", "fit"]
    neighbors, interval, nested = clean.fields
    assert neighbors.value == "8"
    assert neighbors.unit == "points"
    assert neighbors.meaning == (
        "Neighbors whose mean distance, see `Spacing`, is the spacing of a place."
    )
    assert neighbors.source == "calibrated, up to 1.5, on the scoreboard"
    assert interval.value == "(0.5, f64::EPSILON)"
    assert interval.source == "closed form: 1 - 1 / e"
    assert (nested.value, nested.unit, nested.source) == ("FitSettings::STANDARD", "", "")
    assert fit.fields[0].value == "2 * 3"


def test_a_struct_of_settings_needs_no_values() -> None:
    text = "pub struct AllSettings {\n/// The fit.\npub fit: FitSettings,\n}"
    (only,) = settings.parse(text)
    assert [field.value for field in only.fields] == ["FitSettings::STANDARD"]


def test_a_table_has_a_line_for_each_field() -> None:
    lines = settings.markdown(settings.parse(SMALL)[1])
    assert lines[0] == "**FitSettings**: The fit."
    assert lines[-2] == "| `rounds` | `2 * 3` | steps | Rounds. | cost |"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (" Unit: steps.", "", "FitSettings::rounds lacks"),
        (" Source: cost.", "", "FitSettings::rounds lacks"),
        ("{ rounds: 2 * 3 }", "{ }", "FitSettings::rounds has no value"),
        ("STANDARD: Self = Self { rounds", "OTHER: Self = Self { rounds", "rounds has no value"),
    ],
)
def test_a_field_without_unit_source_or_value_is_an_error(old: str, new: str, message: str) -> None:
    assert old in SMALL
    with pytest.raises(settings.SettingsError, match=message):
        settings.parse(SMALL.replace(old, new))


def test_a_missing_file_or_struct_is_an_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(settings, "SOURCES", tmp_path)
    with pytest.raises(settings.SettingsError, match=r"src/cloud/settings\.rs does not exist"):
        settings.read("cloud")
    (tmp_path / "cloud").mkdir()
    (tmp_path / "cloud" / "settings.rs").write_text(SMALL, encoding="utf-8")
    with pytest.raises(settings.SettingsError, match="no struct OtherSettings"):
        settings.read("cloud", ("OtherSettings",))
    (fit,) = settings.read("cloud", exclude=("CleanSettings",))
    assert fit.name == "FitSettings"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_settings_of_a_stage_are_documented(page: Path) -> None:
    for module, names, exclude in DIRECTIVE.findall(page.read_text(encoding="utf-8")):
        assert settings.read(module, tuple(names.split()), tuple(exclude.split()))


def test_each_settings_struct_is_on_a_page() -> None:
    shown: set[tuple[str, str]] = set()
    for page in PAGES:
        for module, names, exclude in DIRECTIVE.findall(page.read_text(encoding="utf-8")):
            structs = settings.read(module, tuple(names.split()), tuple(exclude.split()))
            shown |= {(module, struct.name) for struct in structs}
    for path in (ROOT / "src").rglob("settings.rs"):
        module = path.parent.relative_to(ROOT / "src").as_posix()
        for struct in settings.read(module):
            assert (module, struct.name) in shown, f"{module}::{struct.name} is on no page"
