"""Hands of people who are there together: on the controls that they hold, clear of one another.

One after the other people bring their hands to their controls. Whoever does keeps clear of the
others: of those before as they are, of those after but for the arms that are still to go to
controls. Fingers on a control bend around it and count for nobody.

1. They go in the order of their names, whatever their order in the study.
2. Where somebody then stays off a control that alone would be reached, orders are tried in which
   each who does goes first.

3. Where that is not enough, who is not kept off makes room for those who are, by ever more.

The first of these in which nobody stays off a control for the sake of others is taken, or else one in
which the fewest people do, and of these the one in which the hands stay off least, of equal ones the
first: where two hands can't both hold a lever, one holds it. Who is not in the way of others is where
he or she would be alone, in every order. A failed search is no proof: there may be postures in which
all hands are on their controls although none was found.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from workbench.model.bystander import Bystander
from workbench.study.situation import Situation, as_bystander, with_hands

__all__ = ["hands_together", "kept_off_by_others"]

ROOM_MADE = (0.003, 0.006, 0.012, 0.024)
"""[m] How far hands keep off people who are themselves kept off their controls."""
ROOMS = 2
"""Ways of those that were tried first, from which room is made."""
AGAIN = 2
"""How often those who still stay off come as near as they can beside the others as they then are."""
SAME = 1e-4
"""[m] A hand that stays off its control by less more than alone does not for the sake of others."""


@dataclass(frozen=True, eq=False)
class _Tried:
    """People with the hands on their controls, and how much farther [m] each stays off than alone."""

    people: list[Situation]
    off: list[float]

    @property
    def cost(self) -> tuple[int, float]:
        """How many people stay off, and how far [m] all do: the least is the best."""
        return sum(off > 0.0 for off in self.off), sum(self.off)


def hands_together(
    resting: Sequence[Situation], standing: Sequence[Bystander] = ()
) -> list[Situation]:
    """Bring the hands of people on the controls that they hold, clear of one another.

    Parameters
    ----------
    resting
        The people who are there in one case, one person each (B = 1), with the hands at rest.
    standing
        Others who are there and do not move.

    Returns
    -------
    list[Situation]
        The same with the hands on the controls, or as near as was found.
    """
    rows = sorted(range(len(resting)), key=lambda row: resting[row].place.role)
    found = _by_name([resting[row] for row in rows], standing)
    return [found[rows.index(row)] for row in range(len(resting))]


def _by_name(resting: Sequence[Situation], standing: Sequence[Bystander]) -> list[Situation]:
    """The people, who come in the order of their names, with the hands on the controls."""
    everybody = range(len(resting))
    tried = [_tried(_in_order(resting, standing, everybody))]
    for k in everybody[1:]:
        if tried[0].off[k] > 0.0:
            order = [k, *(i for i in everybody if i != k)]
            tried.append(_tried(_in_order(resting, standing, order)))
    for room in ROOM_MADE:
        if min(one.cost for one in tried)[0]:
            tried += [_tried(_with_room(resting, standing, one, room)) for one in tried[:ROOMS]]
    best = min(tried, key=lambda one: one.cost)
    for _ in range(AGAIN):
        if sum(best.off) > 0.0:
            again = _tried(_with_room(resting, standing, best, 0.0))
            best = min(best, again, key=lambda one: one.cost)
    return best.people


def _tried(people: list[Situation]) -> _Tried:
    return _Tried(people, [sum(kept_off_by_others(one).values()) for one in people])


def _in_order(
    resting: Sequence[Situation], standing: Sequence[Bystander], order: Sequence[int]
) -> list[Situation]:
    """The people with the hands on their controls, brought there in an order."""
    found = list(resting)
    for k in order:
        others = [as_bystander(one) for i, one in enumerate(found) if i != k]
        found[k] = with_hands(replace(resting[k], bystanders=(*standing, *others)))
    return found


def _with_room(
    resting: Sequence[Situation], standing: Sequence[Bystander], before: _Tried, room: float
) -> list[Situation]:
    """The people with the hands on their controls anew: first who is not kept off, at a distance
    [m] from those who are; then these."""
    found = list(before.people)
    off = before.off
    for k in sorted(range(len(off)), key=lambda k: off[k] > 0.0):
        others = [
            replace(as_bystander(one), kept_off=room if off[i] > 0.0 and off[k] == 0.0 else 0.0)
            for i, one in enumerate(found)
            if i != k
        ]
        found[k] = with_hands(replace(resting[k], bystanders=(*standing, *others)))
    return found


def kept_off_by_others(situation: Situation) -> dict[str, float]:
    """How much farther [m] hands of the first person stay off their controls than they would without
    bystanders, what they are deeper in obstacles added; hands that do not are left out."""
    short = _shortages(situation)
    if not situation.bystanders or not any(short.values()):
        return {}
    alone = _shortages(with_hands(situation.at_rest))
    return {hand: more for hand in short if (more := short[hand] - alone[hand]) > SAME}


def _shortages(situation: Situation) -> dict[str, float]:
    """By hand that holds a control how far [m] it stays from it and how deep it is in obstacles."""
    return {
        hand: float(miss[0] + situation.hand_overlap[hand][0])
        for hand, miss in situation.hand_miss.items()
    }
