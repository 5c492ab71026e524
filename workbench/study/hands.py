"""Hands of people who are there together: on the controls that they hold, clear of one another.

One after the other people bring their hands to their controls. Whoever does keeps clear of the
others: of those before as they are, of those after but for the arms that are still to go to
controls. Fingers on a control bend around it and count for nobody.

1. They go in the order of the study's roles.
2. Where somebody then stays off a control that alone would be reached, orders are tried in which
   each who does goes first.

The first order in which nobody stays off a control for the sake of others is taken, or else the one
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
    least = [_kept_off(*both) for both in zip(resting, best, strict=True)]
    for order in _other_orders(least):
        if sum(least) == 0.0:
            break
        found = _in_order(resting, standing, order)
        off = [_kept_off(*both) for both in zip(resting, found, strict=True)]
        if sum(off) < sum(least):
            best = found
            least = off
    return best


def _in_order(
    resting: Sequence[Situation], standing: Sequence[Bystander], order: Sequence[int]
) -> list[Situation]:
    """The people with the hands on their controls, brought there in an order."""
    found = list(resting)
    for k in order:
        others = [as_bystander(one) for i, one in enumerate(found) if i != k]
        found[k] = with_hands(replace(resting[k], bystanders=(*standing, *others)))
    return found


def _other_orders(off: Sequence[float]) -> Iterator[list[int]]:
    """Orders in which each who stays off a control goes first, the others as they were."""
    for k, miss in enumerate(off):
        if k > 0 and miss > 0.0:
            yield [k, *(i for i in range(len(off)) if i != k)]


def _kept_off(resting: Situation, found: Situation) -> float:
    """How much farther [m] the hands of a person stay off their controls than alone, in all."""
    if not any(miss[0] > 0.0 for miss in found.hand_miss.values()):
        return 0.0
    alone = with_hands(resting.at_rest).hand_miss
    more = [float(miss[0] - alone[hand][0]) for hand, miss in found.hand_miss.items()]
    return sum(off for off in more if off > SAME)
