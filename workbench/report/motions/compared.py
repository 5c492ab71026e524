"""Motions of one study side by side: which criteria come out differently, and by what."""

from __future__ import annotations

from markupsafe import Markup

from workbench.files.results.result import ResultFile, VerdictRow
from workbench.report.section import Section
from workbench.report.side_by_side import side_by_side

__all__ = ["compared_section"]


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
