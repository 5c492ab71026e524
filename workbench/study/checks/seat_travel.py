"""Pedals and the place of the seat, as seating came out.

The margin of pedals is how much farther the worse foot may stay from its pedal. Feet that come
there only with the thighs deeper in the front of the cushion than it gives stay as far short as the
thighs are too deep. The margin of the preferred seat is the travel that is left to its nearer end
where the seat is wanted, less what is asked for.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from workbench.model.accommodation import MET
from workbench.model.criterion import NO_REASON, Criterion, Reason
from workbench.model.result import Finding
from workbench.posture.seating.seat import Seated
from workbench.study.checks.margins import Asked, Margins, no_margins
from workbench.study.situation import Situation

__all__ = [
    "SEAT_FORWARD",
    "pedal_findings",
    "pedal_margins",
    "seat_findings",
    "seat_margins",
    "worse_foot",
]

SEAT_BACK = Reason("words", "the seat stops too far back")
SEAT_FORWARD = Reason("words", "the seat stops too far forward")
THIGHS = Reason("words", "the thighs on the front of the cushion")


def pedal_margins(situation: Situation, asked: Sequence[Asked]) -> Margins:
    """How much farther everybody's worse foot may stay from its pedal, with the thighs no deeper in
    the front of the cushion than it gives."""
    found = no_margins(len(situation), asked)
    seat = situation.seated
    if seat is None or not seat.miss:
        return found
    feet = list(seat.miss)
    miss = np.stack([seat.miss[foot] for foot in feet])
    worst = miss.argmax(axis=0)
    for r, one in enumerate(asked):
        found.margin[:, r] = one.criterion.at_most - (miss.max(axis=0) + seat.pressed)
        for b in np.flatnonzero(found.margin[:, r] < -MET):
            foot = feet[int(worst[b])]
            limit = seat.limit[foot][b] or THIGHS
            found.words[b, r] = replace(limit, foot=foot)
    return found


def worse_foot(seat: Seated) -> str:
    """The foot of the first person that stays farther from its pedal, "" where there are none."""
    return max(seat.miss, key=lambda name: float(seat.miss[name][0]), default="")


def pedal_findings(situation: Situation, criterion: Criterion) -> Iterator[Finding]:
    """How far the worse foot stays from its pedal, with the thighs no deeper in the front of the
    cushion than it gives."""
    seat = situation.seated
    aims = situation.work.aims
    if seat is None or aims is None or not seat.miss:
        return
    foot = worse_foot(seat)
    pressed = float(seat.pressed[0])
    limit = seat.limit[foot][0] or (THIGHS if pressed > MET else NO_REASON)
    yield Finding(
        case=situation.work.name,
        person=situation.place.role,
        other_person="",
        subject=f"the {foot}",
        target=aims.controls[foot] + limit.clause,
        value=-(float(seat.miss[foot][0]) + pressed),
        limit=-criterion.at_most,
        about=aims.controls[foot],
    )


def seat_margins(situation: Situation, asked: Sequence[Asked]) -> Margins:
    """What is left of the travel, fore and aft, where everybody wants the seat."""
    found = no_margins(len(situation), asked)
    spare = situation.spare
    for r, one in enumerate(asked):
        found.margin[:, r] = spare.min(axis=1) - one.criterion.at_least
        for b in np.flatnonzero(found.margin[:, r] < -MET):
            back = spare[b, 1] < spare[b, 0]
            found.words[b, r] = SEAT_BACK if back else SEAT_FORWARD
    return found


def seat_findings(situation: Situation, criterion: Criterion) -> Iterator[Finding]:
    """What is left of the travel where the seat is wanted."""
    if situation.seated is None or situation.work.aims is None:
        return
    yield Finding(
        case=situation.work.name,
        person=situation.place.role,
        other_person="",
        subject=f"seat {situation.place.seat}",
        target="the travel",
        value=float(situation.spare[0].min()),
        limit=criterion.at_least,
    )
