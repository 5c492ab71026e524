"""What it changes that a study moves parts: its people and criteria with the parts where they were,
and where they are now."""

from __future__ import annotations

from collections.abc import Sequence

from workbench.model.result import PosturesFound, Result, Verdict
from workbench.model.study import Study
from workbench.model.units import plain
from workbench.report.postures.section import case_states
from workbench.report.result_rows import verdict_row
from workbench.report.section import Making, Section
from workbench.report.sentences import moved_line
from workbench.report.side_by_side import side_by_side
from workbench.study.run import unmoved_postures

__all__ = ["moved_sections"]

_NAMES = ("before", "after")
_CAPTION = "before: parts where the environment has them; after: where the study moves them"


def moved_sections(result: Result, making: Making) -> list[Section]:
    """The section of what the moves of a study change, for each of several sizes; none where the
    study moves nothing, or has no single people in postures.

    The people are found once more without the moves.
    """
    study: Study = result.study
    if not study.moved or not result.postures or study.crowd is not None:
        return []
    making.progress("the same without what is moved")
    return [
        _section(before, after, making, number)
        for number, (before, after) in enumerate(
            zip(unmoved_postures(study), result.postures, strict=True)
        )
    ]


def _section(before: PosturesFound, after: PosturesFound, making: Making, number: int) -> Section:
    """What the moves change for one of several sizes."""
    found: dict[str, dict[str, Verdict]] = {}
    for name, verdicts in zip(_NAMES, (before.verdicts, after.verdicts), strict=True):
        for verdict in verdicts:
            found.setdefault(verdict.criterion.name, {})[name] = verdict
    criteria = {
        name: {state: verdict_row(verdict) for state, verdict in mine.items()}
        for name, mine in found.items()
    }
    case = _case(before.verdicts, after)
    picture = case_states((before, after), case, names=_NAMES, caption=_CAPTION, making=making)
    (words,) = moved_line(after.study.moved)
    size = f": {after.row}" if after.row else ""
    html = side_by_side(
        criteria,
        _NAMES,
        what=f"Each criterion before and after; {plain(words)}",
        picture=picture,
    )
    end = f"-{number + 1}" if number else ""
    return Section("compared", f"moved{end}", f"Before and after what is moved{size}", html)


def _case(before: Sequence[Verdict], after: PosturesFound) -> int:
    """The case to be shown: that of the first criterion that fails before or after, else the
    first."""
    for verdict in (*before, *after.verdicts):
        if not verdict.passed and verdict.worst is not None and verdict.worst.case in after.cases:
            return after.cases.index(verdict.worst.case)
    return 0
