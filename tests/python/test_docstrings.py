"""The docstrings of all public names: present, with examples that run."""

import doctest
import inspect
from pathlib import Path

import pytest

import neurbs

CLASSES = [name for name in neurbs.__all__ if inspect.isclass(getattr(neurbs, name))]
FUNCTIONS = [name for name in neurbs.__all__ if inspect.isroutine(getattr(neurbs, name))]
WITHOUT_RESULT = {"num_threads", "set_num_threads", "show_versions"}
"""Functions whose results depend on the machine."""


def documented(name: str) -> dict[str, str]:
    """Return the docstrings of a public name and of its own public members."""
    thing = getattr(neurbs, name)
    things = {name: thing}
    if inspect.isclass(thing):
        # The members of exceptions are those of Python.
        own = [member for member in dir(thing) if not hasattr(Exception, member)]
        things |= {f"{name}.{m}": getattr(thing, m) for m in own if not m.startswith("_")}
    return {name: inspect.getdoc(each) or "" for name, each in things.items()}


@pytest.mark.parametrize("name", [*CLASSES, *FUNCTIONS])
def test_examples_run(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    docs = documented(name)
    assert docs[name]
    runner = doctest.DocTestRunner(verbose=False)
    for place, doc in docs.items():
        report: list[str] = []
        runner.run(doctest.DocTestParser().get_doctest(doc, {}, place, None, 0), out=report.append)
        assert not report, "".join(report)


@pytest.mark.parametrize("name", sorted({*FUNCTIONS} - WITHOUT_RESULT))
def test_each_function_has_an_example(name: str) -> None:
    assert ">>> " in documented(name)[name]
