"""Pedals and the place of the seat, as seating came out.

The margin of pedals is how much farther the worse foot may stay from its pedal. A foot that comes
there only with its leg deeper in a part than is allowed stays as far short as the leg is too deep.
Feet that come there only with the thighs deeper in the front of the cushion than it gives stay as far short as the
thighs are too deep. The margin of the preferred seat is the travel that is left to its nearer end
where the seat is wanted, less what is asked for.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.model.accommodation import MET
from workbench.model.arrays import Bools, Floats
from workbench.model.criterion import Criterion, Reason
from workbench.model.environment import Control
from workbench.model.result import Finding
from workbench.study.checks.margins import Asked, Margins, no_margins
from workbench.study.situation import Situation, moved_by_legs

__all__ = [
    "ON_PEDAL",
    "SEAT_FORWARD",
    "FootOnPedal",
    "foot_on_pedal",
    "foot_seated",
    "most",
    "pedal_findings",
    "pedal_margins",
    "seat_findings",
    "seat_margins",
    "spheres_asked",
    "worse_foot",
]

SEAT_BACK = Reason("words", "the seat stops too far back")
SEAT_FORWARD = Reason("words", "the seat stops too far forward")
THIGHS = Reason("words", "the thighs on the front of the cushion")
ON_PEDAL = 1e-3
"""[m] A foot that stays short of its pedal by no more reaches it: pedals allow that, too, unless a
study says otherwise, and the search of the seat's place tells no less apart."""


@dataclass(frozen=True, eq=False)
class FootOnPedal:
    """How a foot of B people came to the pedal that their case puts it on.

    Parameters
    ----------
    miss
        (B,) [m] its distance from the pedal.
    overlap
        (B,) [m] how much deeper than allowed its leg is in a part, or the thighs are in the front of
        the cushion, together.
    limit
        (B,) what limits it: a stop, a part, the thighs, or nothing.
    """

    miss: Floats
    overlap: Floats
    limit: tuple[Reason, ...]

    @property
    def short(self) -> Floats:
        """(B,) [m] how far it stays short of its pedal."""
        return self.miss + self.overlap


def foot_on_pedal(situation: Situation, foot: str) -> FootOnPedal:
    """How a foot came to its pedal; it must have one, see `foot_seated`."""
    seat = situation.seated
    assert seat is not None
    limit = list(seat.limit[foot])
    depth = seat.leg_overlap.get(foot, np.zeros(len(situation)))  # nobody may have looked yet
    for b in np.flatnonzero(depth > seat.miss[foot]).tolist():
        part = situation.environment.parts[seat.leg_part[foot][b]]
        limit[b] = Reason("deep", part, at="leg")
    for b in np.flatnonzero(seat.pressed > MET).tolist():
        limit[b] = limit[b] or THIGHS
    return FootOnPedal(seat.miss[foot], depth + seat.pressed, tuple(limit))


def foot_seated(situation: Situation, control: Control, limbs: Sequence[str]) -> bool:
    """Whether a control is asked of one limb alone, the foot that the case has brought there as its
    owner was seated."""
    seat = situation.seated
    return (
        len(limbs) == 1
        and seat is not None
        and limbs[0] in seat.miss
        and situation.work.held.get(limbs[0]) == control.name
    )


def pedal_margins(situation: Situation, asked: Sequence[Asked]) -> Margins:
    """How much farther everybody's worse foot may stay from its pedal, with the thighs no deeper in
    the front of the cushion than it gives."""
    found = no_margins(len(situation), asked)
    seat = situation.seated
    if seat is None or not seat.miss:
        return found
    feet = {foot: foot_on_pedal(situation, foot) for foot in seat.miss}
    short = np.stack([one.short for one in feet.values()])
    worst = short.argmax(axis=0)
    for r, one in enumerate(asked):
        found.margin[:, r] = one.criterion.at_most - short.max(axis=0)
        for b in np.flatnonzero(found.margin[:, r] < -MET):
            foot = list(feet)[int(worst[b])]
            found.words[b, r] = replace(feet[foot].limit[b], foot=foot)
    return found


def most(situation: Situation, asked: Sequence[Asked]) -> Floats:
    """(B, R) [m] what everybody has to spare on the pedals at most: whatever the legs are in, where
    nobody looked yet."""
    return pedal_margins(situation, asked).margin


def spheres_asked(situation: Situation, criterion: Criterion) -> Bools:
    """(S,) what pedals depend on: the legs whose feet are on them."""
    return moved_by_legs(situation)


def worse_foot(situation: Situation) -> str:
    """The foot of the first person that stays farther short of its pedal, "" where there are none."""
    feet = situation.seated.miss if situation.seated is not None else ()
    return max(feet, key=lambda name: float(foot_on_pedal(situation, name).short[0]), default="")


def pedal_findings(situation: Situation, criterion: Criterion) -> Iterator[Finding]:
    """How far the worse foot stays from its pedal, with the thighs no deeper in the front of the
    cushion than it gives."""
    seat = situation.seated
    aims = situation.work.aims
    if seat is None or aims is None or not seat.miss:
        return
    foot = worse_foot(situation)
    there = foot_on_pedal(situation, foot)
    yield Finding(
        case=situation.work.name,
        person=situation.place.role,
        other_person="",
        subject=f"the {foot}",
        target=aims.controls[foot] + there.limit[0].clause,
        value=-float(there.short[0]),
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
