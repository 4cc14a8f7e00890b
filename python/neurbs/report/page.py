"""The page of the report: figures, tables, settings and the command that repeats the job."""

from __future__ import annotations

import html
import inspect
import json
import math
import os
import shlex
from collections.abc import Iterable, Mapping
from importlib import resources
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any

import numpy as np

import neurbs
from neurbs import _core, candidate
from neurbs._core import NeurbsError
from neurbs.deviation import Deviation
from neurbs.errors import argument_error
from neurbs.extras import require
from neurbs.io.atomic_write import atomic_write
from neurbs.report.figures import MAX_POINTS, box_of, convergence, histogram, scene, shares
from neurbs.report.verdict import length, verdict

if TYPE_CHECKING:
    from neurbs import Reconstruction

_PERCENTS = (50.0, 90.0, 95.0, 99.0)
"""Percentiles in the report."""


def write(
    result: Reconstruction,
    path: str | os.PathLike[str],
    *,
    tolerance: float | None = None,
    unit: str = "",
    source: str | os.PathLike[str] | None = None,
    command: str | None = None,
) -> None:
    """Write an HTML page about a result; `Reconstruction.write_report` is this function.

    The page is one file of about 5 to 8 MB, for any browser without a network, with a light and a
    dark theme. A verdict comes first: whether the surface is valid and keeps the tolerance, what
    was left out, whether it is trimmed, and what to do. Warnings, the faces in 3D, colored by the
    deviation, with the points, charts and measures follow. At the end are settings, version and
    the command that repeats the job.

    Parameters
    ----------
    result : Reconstruction
        The result of `neurbs.reconstruct`.
    path : path
        The page, with the suffix ``.html``. The file is complete or does not exist.
    tolerance : float, optional
        The tolerance for the points, in their unit; by default the tolerance of the result, if it
        has one.
    unit : str, default ""
        Name of the points' unit, by default that of the result.
    source : path, optional
        The file of the points, for the title and the command.
    command : str, optional
        The command that repeats the job; by default one from `source` and the settings.

    Raises
    ------
    NeurbsError
        If `tolerance` is not positive, the suffix is not ``.html``, or plotly is not installed:
        ``pip install 'neurbs[report]'``.
    OSError
        If the file cannot be written.

    Examples
    --------
    >>> import numpy as np
    >>> import neurbs
    >>> x, y = np.random.default_rng(0).random((2, 200))
    >>> result = neurbs.reconstruct(np.column_stack([x, y, x * y]), grid=(6, 6))
    >>> result.write_report("report.html", tolerance=0.01)  # doctest: +SKIP
    """
    path = Path(path)
    if path.suffix.lower() not in (".html", ".htm"):
        got = f"the suffix {path.suffix!r}" if path.suffix else "no suffix"
        raise NeurbsError(f"{path}: a report must have the suffix .html, got {got}")
    with atomic_write(path) as new:
        write_page(result, new, tolerance=tolerance, unit=unit, source=source, command=command)


def write_page(
    result: Reconstruction,
    path: str,
    *,
    tolerance: float | None = None,
    unit: str = "",
    source: str | os.PathLike[str] | None = None,
    command: str | None = None,
) -> None:
    """Write the page directly to a file of any name; otherwise as `write`."""
    unit = unit or result.unit or ""
    if tolerance is None:
        tolerance = result.settings.get("tolerance")
    if tolerance is not None and not 0 < tolerance < math.inf:
        raise argument_error("tolerance", f"must be positive and finite, got {tolerance}")
    offline: Any = require("plotly.offline", "reports")
    deviation = Deviation.of_result(result)
    figures = {
        "view": scene(result, deviation, tolerance, unit),
        "histogram": histogram(deviation, tolerance, unit),
        "chart": _chart(result, deviation, tolerance, unit),
    }
    judged = verdict(result, deviation, tolerance, unit)
    name = html.escape(Path(source).name) if source else "Reconstruction"
    content = Template(_resource("page.html")).substitute(
        title=name,
        style=_resource("page.css"),
        version=_core.__version__,
        level=judged.level,
        verdict=html.escape(judged.title),
        answers=_definitions(judged.answers),
        warnings=_warnings(result),
        cards=_cards(result, deviation, tolerance, unit),
        shown=_shown(len(result.points), len(deviation.signed)),
        scale=_exaggeration(result, unit),
        face=_table(_face(result)),
        chart_title="Convergence" if _is_paper(result) else "Points within a distance",
        figures=_json_in_script(figures),
        measures=_table(_measures(deviation, tolerance, unit)),
        candidates=_candidates(result),
        report=_table(_flat(_figures(result))),
        settings=_table(_flat({n: _named(n, value) for n, value in result.settings.items()})),
        command=html.escape(command or _command(result, source)),
        call=html.escape(_call(result)),
        script=_resource("page.js"),
        plotly=offline.get_plotlyjs(),
    )
    Path(path).write_text(content, encoding="utf-8")


def _json_in_script(document: Any) -> str:
    """Return JSON in which characters of HTML markup are escaped."""
    signs = {ord(sign): f"\\u{ord(sign):04x}" for sign in "<>&"}
    return json.dumps(document).translate(signs)


def _resource(name: str) -> str:
    return resources.files("neurbs.report").joinpath(name).read_text(encoding="utf-8")


def _figures(result: Reconstruction) -> dict[str, Any]:
    """Return the report without candidates and diagnostics, which have their own tables."""
    tables = ("candidates", "diagnostics")
    return {name: value for name, value in result.report.to_dict().items() if name not in tables}


def _candidates(result: Reconstruction) -> str:
    """Return the table of candidates, the best first."""
    if not result.report.candidates:
        return ""
    lines = [
        _row("th", candidate.COLUMNS),
        *(_row("td", row) for row in candidate.rows(result.report.candidates)),
    ]
    table = f"<table class='candidates'>{''.join(lines)}</table>"
    return f"<h2>Candidates</h2><div class='scroll'>{table}</div>"


def _row(cell: str, texts: Iterable[str]) -> str:
    return f"<tr>{''.join(f'<{cell}>{html.escape(text)}</{cell}>' for text in texts)}</tr>"


def _warnings(result: Reconstruction) -> str:
    """Return the list of diagnostics, defects first."""
    found = sorted(result.report.diagnostics, key=lambda each: not each.is_defect)
    if not found:
        return ""
    lines = "".join(
        f"<li class='{'bad' if each.is_defect else 'warning'}'><b>{html.escape(each.code)}</b> "
        f"{html.escape(each.message)}</li>"
        for each in found
    )
    return f"<section><h2>Warnings</h2><ul class='warnings'>{lines}</ul></section>"


def _definitions(texts: Mapping[str, str]) -> str:
    return "".join(
        f"<dt>{html.escape(name)}</dt><dd>{html.escape(text)}</dd>" for name, text in texts.items()
    )


def _chart(
    result: Reconstruction, deviation: Deviation, tolerance: float | None, unit: str
) -> dict[str, Any]:
    """Return the chart of the method: the training of the paper's, the accuracy of a fit."""
    if _is_paper(result):
        return convergence(result, unit)
    return shares(deviation, tolerance, unit)


def _cards(result: Reconstruction, deviation: Deviation, tolerance: float | None, unit: str) -> str:
    rows, cols = result.surface.control_points.shape[:2]
    cards = {
        "points": f"{len(result.points):,}",
        "control points": f"{rows} × {cols}",
        "rms": length(deviation.rms, unit),
        "95 % within": length(deviation.percentiles(95.0)[95.0], unit),
        "largest": length(deviation.max, unit),
    }
    if tolerance is not None:
        cards[f"within {length(tolerance, unit)}"] = f"{100 * deviation.within(tolerance):.2f} %"
    return "".join(
        f"<div class='card'><b>{html.escape(value)}</b><span>{html.escape(name)}</span></div>"
        for name, value in cards.items()
    )


def _measures(deviation: Deviation, tolerance: float | None, unit: str) -> dict[str, str]:
    within = "no tolerance was given"
    if tolerance is not None:
        share = 100 * deviation.within(tolerance)
        within = f"{share:.3f} % of the points, within {length(tolerance, unit)}"
    return {
        "rms": length(deviation.rms, unit),
        "mean, signed": length(deviation.mean, unit),
        **{
            f"{share:g} % of the points within": length(distance, unit)
            for share, distance in deviation.percentiles(*_PERCENTS).items()
        },
        "largest": length(deviation.max, unit),
        "within tolerance": within,
    }


def _face(result: Reconstruction) -> dict[str, str]:
    """Return the main figures of the fit, beside its chart."""
    names = ("net", "kind", "face", "fit", "training", "time")
    lines = result.report.lines()
    return {name: lines[name] for name in names if name in lines}


def _exaggeration(result: Reconstruction, unit: str) -> str:
    """Return a sentence about axes that are drawn longer."""
    box = box_of(result, unit)
    longer = [box.label(axis) for axis in range(3) if box.factor[axis] != 1]
    if not longer:
        return "All axes are to scale."
    return f"Not to scale: axes are drawn longer ({', '.join(longer)})."


def _shown(points: int, inliers: int) -> str:
    """Return a sentence about the points that are shown and measured."""
    left_out = points - inliers
    measured = f"all except {left_out:,} that were left out of the fit" if left_out else "all"
    if inliers <= MAX_POINTS:
        return f"Of {points:,} points {measured} are shown."
    return f"A sample of {MAX_POINTS:,} of {points:,} points is shown; {measured} are measured."


def _flat(values: Mapping[str, Any]) -> dict[str, str]:
    return {name.replace("_", " "): _text(value) for name, value in values.items()}


def _text(value: Any) -> str:
    match value:
        case None:
            return "default"
        case dict():
            return ", ".join(f"{name} {_text(part)}" for name, part in value.items())
        case float():
            return f"{value:.6g}"
        case list() | tuple():
            return " × ".join(map(_text, value))
    return str(value)


def _table(rows: Mapping[str, str]) -> str:
    cells = (
        f"<tr><th>{html.escape(name)}</th><td>{html.escape(value)}</td></tr>"
        for name, value in rows.items()
    )
    return f"<table>{''.join(cells)}</table>"


class _Name(str):
    """The name of an argument, in the place of an array."""

    __repr__ = str.__str__


def _named(name: str, value: Any) -> Any:
    """Return a setting, or its name for an array."""
    # `axis_scale` has three elements, other settings have fewer, and arrays have more.
    return value if np.size(value) <= 3 else _Name(name)


def _is_paper(result: Reconstruction) -> bool:
    """Return whether the paper's method made the result: only that has no fairness."""
    return result.report.fairness is None


def _function(result: Reconstruction) -> str:
    """Return the name of the function that made the result."""
    return "reconstruct_paper" if _is_paper(result) else "reconstruct"


def _changed(result: Reconstruction) -> dict[str, Any]:
    """Return the settings that differ from the defaults."""
    parameters = inspect.signature(getattr(neurbs, _function(result))).parameters
    settings = {name: _named(name, value) for name, value in result.settings.items()}
    return {
        name: value
        for name, value in settings.items()
        if name in parameters and value != parameters[name].default
    }


def _command(result: Reconstruction, source: str | os.PathLike[str] | None) -> str:
    command = _function(result).replace("_", "-")
    words = ["neurbs", command, os.fspath(source) if source else "POINTS", "-o", "out.step"]
    for name, value in _changed(result).items():
        option = name.replace("_", "-")
        match value:
            case _Name():
                return f"# There is no command for this call, because {name} is an array."
            case bool() if name == "trim":
                words += ["--trim", "yes" if value else "no"]
            case bool():
                words.append(f"--{option}" if value else f"--no-{option}")
            case tuple() | list():
                words += [f"--{option}", *map(str, value)]
            case _:
                words += [f"--{option}", str(value)]
    if result.unit in _core.LENGTH_UNITS:
        words += ["--unit", result.unit]
    return shlex.join(words)


def _call(result: Reconstruction) -> str:
    options = [f"{name}={value!r}" for name, value in _changed(result).items()]
    if result.unit in _core.LENGTH_UNITS:
        options.append(f"unit={result.unit!r}")
    return f"neurbs.{_function(result)}({', '.join(['points', *options])})"
