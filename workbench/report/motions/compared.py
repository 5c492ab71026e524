"""Motions of one study side by side: which criteria come out differently, and by what."""

from __future__ import annotations

from markupsafe import Markup

from workbench.files.results.result import ResultFile, VerdictRow
from workbench.report.section import Section
from workbench.report.side_by_side import comes_out_differently, side_by_side

__all__ = ["compared_section", "differs_sentence"]


def compared_section(rows: ResultFile, *, both: Markup | str = "") -> Section:
    """The criteria motion by motion, those that come out differently first.

    both: the place of a picture of two of the motions, "" for none.
    """
    names = [motion.name for motion in rows.motions]
    what = "Each criterion, motion by motion"
    html = side_by_side(_by_criterion(rows), names, what=what, picture=both)
    return Section("compared", "compared", "What differs", html)


def _by_criterion(rows: ResultFile) -> dict[str, dict[str, VerdictRow]]:
    """For each criterion that is asked of motions its verdicts by motion."""
    found: dict[str, dict[str, VerdictRow]] = {}
    for verdict in rows.verdicts:
        if verdict.motion:
            found.setdefault(verdict.name, {})[verdict.motion] = verdict
    return found


def differs_sentence(rows: ResultFile) -> str:
    """Which criteria do not come out alike in all motions: "4 of 7 criteria fail with “the lap belt
    alone” and hold with “lap and shoulder belts”: head excursion, ..."."""
    criteria = _by_criterion(rows)
    if not criteria:
        return "No criterion is asked of these motions."
    fails: dict[tuple[str, ...], list[str]] = {}
    for name, mine in criteria.items():
        if comes_out_differently(mine):
            failing = tuple(motion for motion, verdict in mine.items() if not verdict.passed)
            fails.setdefault(failing, []).append(name)
    if not fails:
        failed = sum(not verdict.passed for mine in criteria.values() for verdict in mine.values())
        how = "fail or hold alike" if failed else "hold"
        return f"All criteria {how} in all motions."
    return " ".join(_fails_words(failing, names, rows) for failing, names in fails.items())


def _fails_words(failing: tuple[str, ...], names: list[str], rows: ResultFile) -> str:
    """Which criteria fail in some motions and hold in the others."""
    others = [motion.name for motion in rows.motions if motion.name not in failing]
    count = len(_by_criterion(rows))
    one = len(names) == 1
    lead = f"{len(names)} of {count} criteria" if count > 1 else "The criterion"
    return (
        f"{lead} {'fails' if one else 'fail'} with {_listed(failing)} and "
        f"{'holds' if one else 'hold'} with {_listed(others)}: {', '.join(names)}."
    )


def _listed(names: list[str] | tuple[str, ...]) -> str:
    return " and ".join(f"“{name}”" for name in names)
