"""The verdict of a report: whether a result can be used, and what to do if not."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from neurbs.reconstruction_report import short

if TYPE_CHECKING:
    from neurbs import Reconstruction
    from neurbs.deviation import Deviation
    from neurbs.reconstruction_report import Report


@dataclass(frozen=True)
class Verdict:
    """The answer to the first questions about a result.

    Attributes
    ----------
    level : {"good", "warning", "bad"}
        ``"bad"`` for a surface that is not valid or misses the tolerance.
    title : str
        The verdict in a few words.
    answers : dict of str to str
        Sentences about validity, tolerance, points that were left out, trimming, and what to do.
    """

    level: str
    title: str
    answers: dict[str, str]


def verdict(
    result: Reconstruction, deviation: Deviation, tolerance: float | None, unit: str
) -> Verdict:
    """Judge a result by its report, and by a tolerance if there is one."""
    report = result.report
    missed = tolerance is not None and deviation.within(tolerance) < 1
    findings = len(report.diagnostics)
    if not report.valid:
        level, title = "bad", "The surface is not valid"
    elif missed:
        level, title = "bad", "The tolerance is not kept"
    elif findings:
        level, title = "warning", "Usable, with warnings"
    else:
        level, title = "good", "Good to use"
    answers = {
        "Valid?": _validity(result),
        "Tolerance kept?": _tolerance(deviation, tolerance, unit),
        "Left out?": _left_out(result),
        "Trimmed?": _trim(report, unit),
        "What to do?": _advice(findings, level, missed=missed),
    }
    return Verdict(level, title, answers)


def _validity(result: Reconstruction) -> str:
    defects = [found.code for found in result.report.diagnostics if found.is_defect]
    if result.report.valid:
        return "Yes: no defects were found."
    return f"No: {', '.join(defects) or 'it has defects'}."


def _tolerance(deviation: Deviation, tolerance: float | None, unit: str) -> str:
    if tolerance is None:
        within = length(deviation.percentiles(95.0)[95.0], unit)
        return f"None was given. 95 % of the points lie within {within}."
    far = int((deviation.distances > tolerance).sum())
    if far == 0:
        return f"Yes: all points lie within {length(tolerance, unit)}."
    share, largest = 100 * deviation.within(tolerance), length(deviation.max, unit)
    return (
        f"No: {share:.4g} % of the points lie within {length(tolerance, unit)}. "
        f"{far:,} {'is' if far == 1 else 'are'} farther away, by up to {largest}."
    )


def _left_out(result: Reconstruction) -> str:
    total, used = len(result.points), int(result.inliers.sum())
    if total == used:
        return f"Nothing: all {total:,} points were used."
    left_out, outliers = total - used, result.report.outliers
    whom = "all" if outliers == left_out else f"{outliers:,} of them"
    share = 100 * left_out / total
    return f"{left_out:,} of {total:,} points ({share:.2g} %), {whom} as outliers."


def _trim(report: Report, unit: str) -> str:
    trim = report.trim
    if trim is None:
        return "No: the face is the whole surface, as was asked for."
    square = f" {unit}²" if unit else ""
    if any(found.code == "untrimmed" for found in report.diagnostics):
        whole = f"the face is the whole surface, of area {short(trim.area)}{square}"
        return f"No: {whole}. The warning below gives the reason."
    if trim.area == trim.surface_area:
        return f"No: the points reach the sides of the surface, of area {short(trim.area)}{square}."
    count = len(trim.holes)
    holes = f"{count} hole{'s' * (count > 1)}" if count else "no holes"
    # A surface that runs away from the points has an area without meaning.
    share = 100 * (1 - trim.area / trim.surface_area)
    area = f"{short(trim.area)}{square}"
    return (
        f"Yes: the face has {holes} and an area of {area}. The rest, {share:.3g} % of the surface, "
        "was cut off."
    )


def _advice(findings: int, level: str, *, missed: bool) -> str:
    if level == "good":
        return "Nothing."
    advice = []
    if findings:
        one = findings == 1
        advice.append(f"Follow the advice in the {'warning' if one else 'warnings'} below.")
    if missed:
        advice.append(
            "Raise the tolerance, or look at the places in red and blue: points far from the "
            "surface may be outliers."
        )
    return " ".join(advice) or "Look at the surface below."


def length(value: float, unit: str) -> str:
    """Return a length with its unit in words."""
    return f"{short(value)} {unit}".strip()
