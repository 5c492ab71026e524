"""Reaches of a result: rows for result.json, tables, sentences."""

from __future__ import annotations

from collections.abc import Sequence

from workbench.files.results.postures import ReachRow
from workbench.model.reach import DOUBTS
from workbench.model.result import ControlReach, PosturesFound
from workbench.report.words import millimetres

__all__ = ["doubt_sentence", "reach_rows"]


def reach_rows(result: PosturesFound) -> list[ReachRow]:
    """The reaches of a result in millimetres and words."""
    return [
        ReachRow(
            person=row.person,
            control=row.control,
            zone=row.zone,
            own_zone=row.own_zone,
            limb=row.limb,
            reached=row.reached,
            miss_mm=0.0 if row.reached else round(1000 * row.miss, 3),
            overlap_mm=round(1000 * row.overlap, 3),
            limit=row.limit.text,
            spare_mm=None if row.spare is None else round(1000 * row.spare, 3),
            discomfort=round(row.discomfort, 4),
            doubt=row.doubt,
            sentence=_sentence(row),
        )
        for row in result.reaches
    ]


def _sentence(row: ControlReach) -> str:
    lead = f"{row.person}, zone {row.zone}: the {row.limb}"
    if row.reached:
        return f"{lead} reaches {row.control}."
    entered = f", {millimetres(row.overlap)} into it" if row.overlap > 0 else ""
    by = f", limited by {row.limit.text}"
    return f"{lead} stays {millimetres(row.miss)} from {row.control}{by}{entered}."


def doubt_sentence(ends: Sequence[str]) -> str:
    """Return how many reaches obstacles put in doubt, and how these ended; "" where none was."""
    certain, soon, other, kept, proved = (ends.count(end) for end in DOUBTS)
    doubted = len(ends) - certain
    if not doubted:
        return ""
    ways = [
        f"{count} {'was' if count == 1 else 'were'} solved by {how}"
        for count, how in ((soon, "a small change of posture"), (other, "another posture"))
        if count
    ]
    if kept:
        ways.append(f"for {kept} no clear posture was found, which does not prove that none exists")
    if proved:
        ways.append(f"for {proved} none exists, because the control is too deep inside a part")
    lead = f"In {doubted} of {len(ends)} reaches an obstacle was in the way at first"
    return f"{lead}: {', '.join(ways)}."
