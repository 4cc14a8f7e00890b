"""Sphinx extension: tables of the settings of a stage, read from the Rust sources.

The directive ``{settings} MODULE [STRUCT ...]`` reads ``src/MODULE/settings.rs`` and writes a table
for each struct: name, value, unit, meaning and source of each field. Without struct names it takes
all structs of the file, in their order. The option ``:exclude:`` leaves structs out.

The expected form of a struct is

    /// What the settings are for.
    pub(crate) struct CleanSettings {
        /// What the field means. Unit: points. Source: calibrated on the scoreboard.
        pub(crate) k_neighbors: usize,
    }
    impl CleanSettings {
        pub(crate) const STANDARD: Self = Self { k_neighbors: 8 };
    }

A field whose type is another settings struct needs neither unit nor source. A struct that has only
such fields needs no STANDARD.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

if TYPE_CHECKING:
    from sphinx.application import Sphinx

SOURCES = Path(__file__).parents[1] / "src"

STRUCT = re.compile(r"^\s*(?:pub(?:\([^)]*\))?\s+)?struct\s+(\w+)\s*\{", re.MULTILINE)
FIELD = re.compile(r"^(?:pub(?:\([^)]*\))?\s+)?(\w+)\s*:\s*(.+)$", re.DOTALL)
DOC = re.compile(r"^(?P<meaning>.*?)\s+Unit:\s+(?P<unit>.+?)\.\s+Source:\s+(?P<source>.+?)\.?$")
LINK = re.compile(r"\[(`[^`]*`)\](?:\([^)]*\))?")


class SettingsError(ValueError):
    """A settings file is missing, or does not have the expected form."""


@dataclasses.dataclass(frozen=True)
class Field:
    """A setting."""

    name: str
    value: str
    unit: str
    meaning: str
    source: str


@dataclasses.dataclass(frozen=True)
class Struct:
    """The settings of a stage."""

    name: str
    meaning: str
    fields: tuple[Field, ...]


def read(module: str, names: tuple[str, ...] = (), exclude: tuple[str, ...] = ()) -> list[Struct]:
    """Read the settings structs of a module of the crate.

    Parameters
    ----------
    module : str
        The folder below ``src/``.
    names : tuple of str, default ()
        The structs to return, in this order; all of the file if empty.
    exclude : tuple of str, default ()
        The structs to leave out.

    Returns
    -------
    list of Struct
        The structs with their fields.

    Raises
    ------
    SettingsError
        If the file or a named struct is missing, or a field lacks unit, source or value.
    """
    path = SOURCES / module / "settings.rs"
    if not path.is_file():
        raise SettingsError(f"src/{module}/settings.rs does not exist")
    found = parse(path.read_text(encoding="utf-8"))
    known = {struct.name: struct for struct in found}
    missing = [name for name in (*names, *exclude) if name not in known]
    if missing:
        file, absent, present = f"src/{module}/settings.rs", ", ".join(missing), ", ".join(known)
        raise SettingsError(f"{file} has no struct {absent}; it has {present}")
    wanted = names or tuple(name for name in known if name not in exclude)
    return [known[name] for name in wanted]


def parse(text: str) -> list[Struct]:
    """Parse the settings structs of a Rust source file."""
    return [
        Struct(
            match[1],
            _docs_before(text[: match.start()]),
            tuple(_fields(match[1], text, match.end())),
        )
        for match in STRUCT.finditer(text)
    ]


def markdown(struct: Struct) -> list[str]:
    """Write a struct as lines of Markdown: its name and meaning, and a table of its fields."""
    lines = [f"**{struct.name}**: {struct.meaning}", ""]
    lines += ["| name | value | unit | meaning | source |", "| --- | --- | --- | --- | --- |"]
    for field in struct.fields:
        cells = (f"`{field.name}`", f"`{field.value}`", field.unit, field.meaning, field.source)
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return [*lines, ""]


def _fields(struct: str, text: str, start: int) -> Iterator[Field]:
    """Yield the fields of a struct whose body starts at this place."""
    body = text[start : _closing(text, start)]
    values = _values(struct, text)
    for part in _split(body):
        doc = _docs([line for line in _lines(part) if line.startswith("///")])
        code = " ".join(line for line in _lines(part) if not line.startswith(("//", "#[")))
        match = FIELD.match(code)
        if match is None:
            raise SettingsError(f"{struct}: cannot read the field {code!r}")
        name, kind = match[1], match[2].strip()
        nested = kind.split("::")[-1].endswith("Settings")
        if nested and not values:
            value = f"{kind}::STANDARD"
        elif name in values:
            value = values[name]
        else:
            raise SettingsError(f"{struct}::{name} has no value in STANDARD")
        parts = DOC.match(doc)
        if parts is not None:
            yield Field(name, value, parts["unit"], parts["meaning"], parts["source"])
        elif nested:
            yield Field(name, value, "", doc, "")
        else:
            raise SettingsError(f"{struct}::{name} lacks 'Unit: ….' or 'Source: ….': {doc!r}")


def _values(struct: str, text: str) -> dict[str, str]:
    """Return the values in the constant STANDARD of a struct as they are written, if it has one."""
    impl = re.search(rf"\bimpl\s+{struct}\s*\{{", text)
    body = text[impl.end() : _closing(text, impl.end())] if impl else ""
    literal = re.search(r"\bconst\s+STANDARD\s*:\s*\w+\s*=\s*\w+\s*\{", body)
    if literal is None:
        return {}
    values = {}
    for part in _split(body[literal.end() : _closing(body, literal.end())]):
        code = " ".join(line for line in _lines(part) if not line.startswith("//"))
        name, _, value = code.partition(":")
        values[name.strip()] = (value or name).strip()
    return values


def _docs(lines: list[str]) -> str:
    """Join doc comments, without links to items."""
    return LINK.sub(r"\1", " ".join(line[3:].strip() for line in lines)).strip()


def _docs_before(text: str) -> str:
    """Return the doc comment that ends a text, before attributes."""
    lines = _lines(text)
    while lines and lines[-1].startswith("#["):
        lines.pop()
    begin = len(lines)
    while begin and lines[begin - 1].startswith("///"):
        begin -= 1
    return _docs(lines[begin:])


def _lines(text: str) -> list[str]:
    return [line.strip() for line in text.splitlines() if line.strip()]


def _closing(text: str, start: int) -> int:
    """Return the place of the brace that closes the one before `start`."""
    depth = 1
    for place, character in _code(text, start):
        depth += (character == "{") - (character == "}")
        if depth == 0:
            return place
    raise SettingsError("a brace is not closed")


def _split(body: str) -> list[str]:
    """Split a body at the commas outside of brackets and comments."""
    parts, depth, begin = [], 0, 0
    for place, character in _code(body, 0):
        depth += (character in "([{") - (character in ")]}")
        if character == "," and depth == 0:
            parts.append(body[begin:place])
            begin = place + 1
    parts.append(body[begin:])
    return [part for part in parts if any(not line.startswith("//") for line in _lines(part))]


def _code(text: str, start: int) -> Iterator[tuple[int, str]]:
    """Yield the places and characters of a text that are not in line comments."""
    place = start
    while place < len(text):
        if text.startswith("//", place):
            end = text.find("\n", place)
            place = len(text) if end < 0 else end
            continue
        yield place, text[place]
        place += 1


def setup(app: Sphinx) -> dict[str, object]:
    """Add the directive to Sphinx."""
    from sphinx.errors import ExtensionError
    from sphinx.util.docutils import SphinxDirective

    class SettingsDirective(SphinxDirective):
        """The tables of the settings of a module."""

        required_arguments = 1
        optional_arguments = 1
        final_argument_whitespace = True
        option_spec: ClassVar = {"exclude": str}

        def run(self) -> list[Any]:
            module, *names = " ".join(self.arguments).split()
            exclude = self.options.get("exclude", "").split()
            self.env.note_dependency(str(SOURCES / module / "settings.rs"))
            try:
                structs = read(module, tuple(names), tuple(exclude))
            except SettingsError as error:
                raise ExtensionError(f"{self.env.docname}: settings: {error}") from error
            lines = [line for struct in structs for line in markdown(struct)]
            return self.parse_text_to_nodes(
                "\n".join([":::{container} settings", "", *lines, ":::"])
            )

    app.add_directive("settings", SettingsDirective)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
