"""The docstrings of curves, surfaces and shells are complete."""

import inspect
import re

import pytest

import neurbs
from neurbs import _core

CLASSES = [
    _core.NurbsSurface,
    _core.NurbsCurve,
    _core.Curvatures,
    _core.ClosestPoints,
    _core.Face,
    _core.Shell,
    _core.Edge,
    _core.FacePoints,
]
MEMBERS = [(kind, name) for kind in CLASSES for name in vars(kind) if not name.startswith("_")]


@pytest.mark.parametrize(("kind", "name"), MEMBERS, ids=lambda x: getattr(x, "__name__", x))
def test_docstrings_are_complete(kind: type, name: str) -> None:
    doc = inspect.getdoc(getattr(kind, name))
    assert doc, "no docstring"
    if not callable(getattr(kind, name)) or name == "save":
        return
    assert ">>>" in doc or name in ("tessellate", "plot"), "no example"
    assert "Returns\n-------" in doc
    arguments = set(inspect.signature(getattr(kind, name)).parameters) - {"self"}
    if arguments:
        section = doc.split("Parameters\n----------")[1].split("\n\n")[0]
        heads = re.findall(r"^(\w[\w, ]*)(?: : |$)", section, re.M)
        named = {word.strip() for head in heads for word in head.split(",")}
        assert arguments == named


def test_help_describes_a_surface() -> None:
    doc = inspect.getdoc(neurbs.NurbsSurface)
    assert doc is not None
    for section in ["Parameters", "Attributes", "Raises", "See Also", "Notes", "Examples"]:
        assert f"\n{section}\n{'-' * len(section)}\n" in doc
