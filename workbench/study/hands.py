"""Hands of people who are there together: on the controls that they hold, clear of one another.

One after the other people bring their hands to their controls. Whoever does keeps clear of the
others: of those before as they are, of those after but for the arms that are still to go to
controls. Fingers on a control bend around it and count for nobody.

1. They go in the order of the study's roles.
2. Where somebody then stays off a control that alone would be reached, orders are tried in which
   each who does goes first.

3. Where that is not enough, who is not kept off makes room for those who are, by ever more.

The first of these in which nobody stays off a control for the sake of others is taken, or else the one
in which the hands stay off least, of equal ones the first. Who is not in the way of others is where
he or she would be alone, in every order. A failed search is no proof: there may be postures in which
all hands are on their controls although none was found.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from workbench.model.bystander import Bystander
from workbench.study.situation import Situation, as_bystander, with_hands

__all__ = ["hands_together"]

ROOM_MADE = (0.003, 0.006, 0.012, 0.024)
"""[m] How far hands keep off people who are themselves kept off their controls."""
SAME = 1e-4
"""[m] A hand that stays off its control by less more than alone does not for the sake of others."""


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
    best = _in_order(resting, standing, range(len(resting)))
    least = _kept_off(resting, best)
    for tried in _other_ways(resting, standing, best, least):
        off = _kept_off(resting, tried)
        if sum(off) < sum(least):
            best = tried
            least = off
        if sum(least) == 0.0:
            break
    return best


def _other_ways(
    resting: Sequence[Situation],
    standing: Sequence[Bystander],
    first: Sequence[Situation],
    off: Sequence[float],
) -> Iterator[list[Situation]]:
    """The people with the hands on their controls in other ways, where some are kept off: in other
    orders, then with room that is made for these."""
    everybody = range(len(resting))
    kept = [k for k in everybody if off[k] > 0.0]
    orders = [[*everybody], *([k, *(i for i in everybody if i != k)] for k in kept if k > 0)]
    tried = [list(first)]
    for order in orders[1:]:
        tried.append(_in_order(resting, standing, order))
        yield tried[-1]
    for room in ROOM_MADE if kept else ():
        for found in tried:
            yield _with_room(resting, standing, found, room)


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
    resting: Sequence[Situation],
    standing: Sequence[Bystander],
    before: Sequence[Situation],
    room: float,
) -> list[Situation]:
    """The people with the hands on their controls anew: first who is not kept off, at a distance
    [m] from those who are; then these."""
    off = _kept_off(resting, before)
    found = list(before)
    for k in sorted(range(len(off)), key=lambda k: off[k] > 0.0):
        others = [
            replace(as_bystander(one), kept_off=room if off[i] > 0.0 and off[k] == 0.0 else 0.0)
            for i, one in enumerate(found)
            if i != k
        ]
        found[k] = with_hands(replace(resting[k], bystanders=(*standing, *others)))
    return found


def _kept_off(resting: Sequence[Situation], found: Sequence[Situation]) -> list[float]:
    """How much farther [m] the hands of each person stay off their controls than alone, in all."""
    return [_farther(*both) for both in zip(resting, found, strict=True)]


def _farther(resting: Situation, found: Situation) -> float:
    """How much farther [m] the hands of a person stay off their controls than alone, what they are
    deeper in obstacles added."""
    short = _shortages(found)
    if not any(short.values()):
        return 0.0
    alone = _shortages(with_hands(resting.at_rest))
    more = [short[hand] - alone[hand] for hand in short]
    return sum(off for off in more if off > SAME)


def _shortages(situation: Situation) -> dict[str, float]:
    """By hand that holds a control how far [m] it stays from it and how deep it is in obstacles."""
    return {
        hand: float(miss[0] + situation.hand_overlap[hand][0])
        for hand, miss in situation.hand_miss.items()
    }
