"""The criteria of a study on its page: which fail and by how much, which hold and with what to
spare, and the one that decides."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from markupsafe import Markup

from workbench.files.results.result import FindingRow, ResultFile, VerdictRow
from workbench.model.reach import MOST_SPARE
from workbench.model.units import tenths, unit_in
from workbench.report.section import Making, Section
from workbench.report.sentences import surface_words
from workbench.report.templates import template

__all__ = [
    "asked_words",
    "criteria_sections",
    "measured_words",
    "none_measured_words",
    "spare_words",
]

_MOST_CLOSE_UPS = 12
_OVERLAPS = ("contact", "self_contact")
_REACHED = ("reach", "pedals")
_AT_MOST = ("excursion", "injury", "score")


def criteria_sections(
    rows: ResultFile, making: Making, overlaps: Sequence[Markup]
) -> list[Section]:
    """The sections of criteria that fail, of warnings, and of criteria that hold.

    Parameters
    ----------
    making
        What the sections of the page share, with the pictures of all cases.
    overlaps
        The overlaps that no criterion asks about, each as a line.
    """
    verdicts = by_criterion(rows.verdicts)
    failed = [verdict for verdict in verdicts if not verdict.passed]
    held = [verdict for verdict in verdicts if verdict.passed]
    doubtful = [verdict for verdict in verdicts if verdict.doubtful]
    about = len({(verdict.row, verdict.motion) for verdict in verdicts}) > 1
    of = f" of {len(verdicts)} verdicts" if about else ""  # on a few criteria, several times
    sections = []
    if failed:
        shown = [_failed(verdict, making, k) for k, verdict in enumerate(failed)]
        html = template("criteria_failed.html.j2").render(failed=shown, making=making, about=about)
        title = f"Criteria that fail ({len(failed)}{of})"
        sections.append(Section("failed", "failed", title, Markup(html)))
    if rows.warnings or overlaps or doubtful:
        html = template("warnings.html.j2").render(
            warnings=rows.warnings, overlaps=overlaps, doubtful=doubtful, making=making
        )
        sections.append(Section("warnings", "warnings", "Warnings", Markup(html)))
    if held:
        shown = [_row(verdict) for verdict in held]
        html = template("criteria_held.html.j2").render(held=shown, making=making, about=about)
        title = f"Criteria that hold ({len(held)}{of})"
        sections.append(Section("passed", "passed", title, Markup(html), folded=True))
    return sections


def by_criterion(verdicts: Sequence[VerdictRow]) -> list[VerdictRow]:
    """The verdicts in the order of the criteria, those of all motions on one criterion together."""
    order = list(dict.fromkeys(verdict.name for verdict in verdicts))
    return sorted(verdicts, key=lambda verdict: order.index(verdict.name))


def _row(verdict: VerdictRow) -> dict[str, Any]:
    """One criterion as a line of a table."""
    return {
        "verdict": verdict,
        "of": verdict.row or verdict.motion or "",
        "measured": measured_words(verdict),
        "asked": asked_words(verdict),
        "spare": spare_words(verdict),
    }


def _failed(verdict: VerdictRow, making: Making, number: int) -> dict[str, Any]:
    """One criterion that fails, with a close-up of where it fails by most."""
    picture = making.views.close_up(verdict) if number < _MOST_CLOSE_UPS else ""
    worst = verdict.worst
    return _row(verdict) | {
        "look": making.views.of_verdict(verdict),
        "picture": picture,
        "struck": worst is not None and worst.polygon is not None and worst.value < 0.0,
        "over": verdict.check in (*_OVERLAPS, *_AT_MOST) or worst is None,
    }


def measured_words(verdict: VerdictRow) -> str:
    """What was measured where a criterion is nearest to failing or fails by most: "53.4 mm deep",
    "64.6 ± 7 mm" where the error of the body's surface is known; "–" where nothing was."""
    worst = verdict.worst
    if worst is None:
        return "–"
    limit = abs(worst.limit) if worst.value * worst.limit > 0 else 0.0
    error = worst.surface_known_to
    known = surface_words(error / 1000) if error is not None else ""
    value = _figure(abs(worst.value), worst, limit, known)
    if verdict.check in _OVERLAPS or (
        verdict.check in ("clearance", "between_people", "seated") and worst.value < 0
    ):
        return f"{value} {'deep' if worst.value < 0 else 'apart'}"
    if verdict.check in _REACHED:
        return f"{value} short" if worst.value < 0 else "reached"
    return (
        f"{value} {'past the stop' if worst.value < 0 else 'from the stop'}"
        if verdict.check == "stops"
        else _figure(worst.value, worst, worst.limit, known)
    )


def asked_words(verdict: VerdictRow) -> str:
    """What a criterion asks for: "at least 50.0 mm", "at most 45.0 mm deep"."""
    worst = verdict.worst
    if worst is None:
        return "–"
    limit = _figure(abs(worst.limit), worst, abs(worst.value))
    if verdict.check in _OVERLAPS:
        return f"at most {limit} deep" if worst.limit < 0 else "no overlap"
    if verdict.check == "seated":
        return f"{limit} deep"
    if verdict.check in _REACHED:
        return f"within {limit}" if worst.limit < 0 else "reached"
    if verdict.check == "stops":
        if worst.limit < 0:
            return f"at most {limit} past the stop"
        return f"at least {limit} from the stop" if worst.limit > 0 else "not past the stop"
    return f"{'at most' if verdict.check in _AT_MOST else 'at least'} {_figure(worst.limit, worst, worst.value)}"


def none_measured_words(verdict: VerdictRow) -> str:
    """What a criterion asks for of which nothing was measured: "no overlap" of contacts, of which
    none may have been found; "–" of others."""
    return "no overlap" if verdict.check in _OVERLAPS and verdict.passed else "–"


def spare_words(verdict: VerdictRow) -> str:
    """What is to spare or is lacking; "–" where it is not measured, as of pedals that are reached."""
    worst = verdict.worst
    if worst is None or (verdict.check == "pedals" and verdict.passed):
        return "–"
    more = verdict.check == "reach" and worst.value >= 1000 * MOST_SPARE
    lead = "≥\u00a0" if more else ""
    figure = _figure(abs(worst.margin), worst, 0.0)
    return lead + (figure.replace("%", "points") if worst.unit == "percent" else figure)


def _figure(value: float, finding: FindingRow, limit: float, known: str = "") -> str:
    """A value with its unit, told from a limit. known: how well, " ± 3", "" where it is not said."""
    unit = unit_in(finding.unit).sign
    text = tenths(value, limit) if finding.unit else f"{value + 0.0:.0f}"
    return f"{text}{known}{unit}".rstrip()
