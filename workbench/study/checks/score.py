"""Scores of postures: RULA, REBA or OWAS of a person at most so many points.

The stance is that of the role, sitting or standing, where the criterion does not state one. Of a
motion the highest score counts.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from workbench.body.forward import place
from workbench.model.accommodation import MET
from workbench.model.arrays import pieces
from workbench.model.criterion import Criterion, Reason, Work
from workbench.model.poses import Placed
from workbench.model.result import Finding, MotionFound
from workbench.model.units import plain, unit_of
from workbench.model.workplace import Workplace
from workbench.strain.owas import owas
from workbench.strain.posture_score import ASKED_BY, PostureScore
from workbench.strain.reba import reba
from workbench.strain.rula import rula
from workbench.study.checks.margins import Asked, Margins, no_margins
from workbench.study.situation import Situation

__all__ = ["assumed_words", "findings", "margins", "moments"]

_METHODS = {"rula": rula, "reba": reba, "owas": owas}
_SIDES = ("left", "right")


def margins(situation: Situation, asked: Sequence[Asked]) -> Margins:
    """How many points everybody is below what is allowed."""
    found = no_margins(len(situation), asked)
    for r, one in enumerate(asked):
        work = _work(one.criterion, situation.place)
        score = _score(situation.placed, one.criterion, work)
        spare = one.criterion.at_most - score.score.astype(np.float64)
        found.margin[:, r] = unit_of("score").counted(spare)
        for b in np.flatnonzero(found.margin[:, r] < -MET).tolist():
            found.words[b, r] = Reason("words", _side(score, b))
    return found


def findings(situation: Situation, criterion: Criterion) -> Iterator[Finding]:
    """The score of a person."""
    score = _score(situation.placed, criterion, _work(criterion, situation.place))
    yield _finding(score, 0, criterion, situation.work.name, situation.place.role)


def moments(found: MotionFound, criterion: Criterion) -> list[Finding]:
    """The highest score of a motion, at its first moment."""
    study = found.study
    best: list[Finding] = []
    for frames in pieces(len(study.motion)):
        some = study.motion.rows(frames)
        score = _score(place(study.body, some), criterion, criterion.work)
        frame = int(score.score.argmax())
        if not best or -float(score.score[frame]) < best[0].value:
            one = _finding(score, frame, criterion, study.case, study.person)
            best = [replace(one, time=float(some.clock[frame]))]
    return best


def assumed_words(criterion: Criterion, where: Workplace) -> str:
    """What a criterion of a score assumes: "; assumed: load: nothing in the hands, ...", "" where
    all is stated."""
    words = _work(criterion, where).assumed(ASKED_BY[criterion.method])
    return _assumed(words)


def _assumed(words: Sequence[str]) -> str:
    told = ", ".join(one.removesuffix(" (assumed)") for one in words)
    return f"; assumed: {told}" if told else ""


def _work(criterion: Criterion, where: Workplace) -> Work:
    """What is stated of the work; the stance by where the role stands or sits, if by nothing else."""
    work = criterion.work
    if work.stance is not None or not (where.stand or where.seat):
        return work
    return replace(work, stance="standing" if where.stand is not None else "sitting")


def _score(placed: Placed, criterion: Criterion, work: Work) -> PostureScore:
    """The scores of postures."""
    assert criterion.rule_set is not None
    return _METHODS[criterion.method](placed, work, rules=criterion.rule_set)


def _side(score: PostureScore, row: int) -> str:
    """The worse side: "the right side", "both sides" where they are alike."""
    left, right = score.by_side[row].tolist()
    return "both sides" if left == right else f"the {_SIDES[int(right > left)]} side"


def _finding(
    score: PostureScore, row: int, criterion: Criterion, case: str, person: str
) -> Finding:
    part = plain(score.next_part[row])
    near = f"{math.degrees(score.to_next_band[row]):.1f} degrees from another band ({part})"
    rules = criterion.rule_set
    assert rules is not None
    return Finding(
        case=case,
        person=person,
        other_person="",
        subject=f"{score.method} of {_side(score, row)}",
        target=near,
        value=-float(score.score[row]),
        limit=-criterion.at_most,
        unit="points",
        source=f"{score.version}{rules.all_told.removeprefix(rules.description)}{_assumed(score.assumed)}",
    )
