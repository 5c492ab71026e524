"""Motions of one study side by side: which criteria come out differently, and by what."""

from __future__ import annotations

from typing import Any

from markupsafe import Markup

from workbench.files.results.result import ResultFile, VerdictRow
from workbench.report.criteria import asked_words, measured_words
from workbench.report.section import Section
from workbench.report.templates import template

__all__ = ["compared_section", "differs_sentence"]


def compared_section(rows: ResultFile, *, both: Markup | str = "") -> Section:
    """The criteria motion by motion, those that come out differently first.

    both: the place of a picture of two of the motions, "" for none.
    """
    names = [motion.name for motion in rows.motions]
    lines = []
    for name, mine in _by_criterion(rows).items():
        known = [verdict for verdict in mine.values() if verdict.worst is not None]
        lines.append(
            {
                "name": name,
                "cells": [_cell(mine.get(motion)) for motion in names],
                "asked": asked_words(known[0]) if known else "–",
                "differs": _differs(mine),
            }
        )
    lines.sort(key=lambda line: not line["differs"])
    html = template("motions/compared.html.j2").render(names=names, lines=lines, both=both)
    return Section("compared", "compared", "What differs", Markup(html))


def _by_criterion(rows: ResultFile) -> dict[str, dict[str, VerdictRow]]:
    """For each criterion that is asked of motions its verdicts by motion."""
    found: dict[str, dict[str, VerdictRow]] = {}
    for verdict in rows.verdicts:
        if verdict.motion:
            found.setdefault(verdict.name, {})[verdict.motion] = verdict
    return found


def _differs(verdicts: dict[str, VerdictRow]) -> bool:
    return len({verdict.passed for verdict in verdicts.values()}) > 1


def _cell(verdict: VerdictRow | None) -> dict[str, Any]:
    """What a criterion comes to in one motion."""
    if verdict is None:
        return {"text": "not asked", "passed": True, "asked": False}
    measured = measured_words(verdict)
    text = measured if verdict.worst is not None else verdict.sentence.rstrip(".").lower()
    return {"text": text, "passed": verdict.passed, "asked": True}


def differs_sentence(rows: ResultFile) -> str:
    """Which criteria do not come out alike in all motions: "4 of 7 criteria fail with “the lap belt
    alone” and hold with “lap and shoulder belts”: head excursion, ..."."""
    criteria = _by_criterion(rows)
    if not criteria:
        return "No criterion is asked of these motions."
    fails: dict[tuple[str, ...], list[str]] = {}
    for name, mine in criteria.items():
        if _differs(mine):
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
