"""What seat, feet and hands of one person could not give, in words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from workbench.model.accommodation import MET
from workbench.model.arrays import Floats
from workbench.model.criterion import NO_REASON, Criterion, Reason, short_words
from workbench.model.result import Shortfall
from workbench.model.units import plain
from workbench.model.workplace import Workplace
from workbench.posture.seating.driving import DrivingPosture
from workbench.posture.seating.seat import Seated
from workbench.study.checks.margins import Asked
from workbench.study.checks.sight import shortfall_words
from workbench.study.checks.table import same_everywhere
from workbench.study.hands import kept_off_by_others
from workbench.study.positions import FittedBody, Outcomes
from workbench.study.settings import adjustments_of, setting_text
from workbench.study.situation import Situation, freely_seated, on_fixed_pedals, position_of

__all__ = ["move_words", "setting_words", "shortfalls", "unjudged"]

REPORTED = 1e-3
"""A miss [m] that is reported."""
INSIDE = 5e-5
"""[m] A leg that is deeper in a part than allowed by less is not mentioned: it reads as 0.0 mm."""
AT_END = 1e-6
"""Travel [m] that is none."""
LOW = "eyes too low"
HIGH = "eyes too high"
FARTHER = 0.5
"""How far [m] beyond the ends of a seat's travel it is looked for where legs would have it."""
PEDALS_OFF = 0.02
"""Pedals that are nearer or farther by less [m] than legs would have them are not mentioned."""

_NO_ROOM = (
    "no posture was found in which all hands are on their controls and nobody touches another"
)
"""What is said where people keep each other off: a search that fails is no proof."""


def shortfalls(situation: Situation) -> list[Shortfall]:
    """What a person with the hands on the controls misses of the aims of a case."""
    seated = situation.seated
    held = situation.work.held
    found: list[Shortfall | None] = []
    if seated is not None and situation.work.aims is not None:
        found += [
            _eyes_off(situation, seated),
            _travel_off(situation, seated),
            _pressed(situation, seated),
        ]
        for foot, miss in seated.miss.items():
            found.append(_limb_off(situation, foot, held[foot], miss, seated.limit[foot]))
        found += _legs_inside(situation, seated)
    kept_off = kept_off_by_others(situation)
    for hand, miss in situation.hand_miss.items():
        limit = situation.hand_limit[hand]
        overlap = float(situation.hand_overlap[hand][0])
        off = _limb_off(situation, hand, held[hand], miss, limit, overlap)
        if off is not None and hand in kept_off:
            names = " or ".join(one.name for one in situation.bystanders)
            by = off.why if limit[0].kind == "other" else f"kept off by {names}"
            off = replace(off, why=f"{by}: {_NO_ROOM}")
        found.append(off)
    return [one for one in found if one is not None]


def unjudged(found: Sequence[Shortfall], criteria: Sequence[Criterion]) -> list[Shortfall]:
    """Return those shortfalls that no criterion judges: how far the eyes may be off their point is
    for an `eye_height` to say that has a limit on their side, whether it passes or fails."""
    return [one for one in found if not any(_judges(criterion, one) for criterion in criteria)]


def _judges(criterion: Criterion, one: Shortfall) -> bool:
    limit = {LOW: criterion.below, HIGH: criterion.above}.get(one.what, math.inf)
    asks = criterion.check == "eye_height" and criterion.asks(one.case)
    return asks and one.person in criterion.people and limit < math.inf


def _shortfall(
    situation: Situation, what: str, words: str, *, size: float, why: str = ""
) -> Shortfall:
    return Shortfall(situation.place.role, situation.work.name, what, words, why, size)


def _eyes_off(situation: Situation, seated: Seated) -> Shortfall | None:
    """How far the eyes are from the height of their point."""
    if situation.eyes is None:
        return None
    above = float(seated.eye[0, 2] - situation.environment.points[situation.eyes][2])
    if abs(above) <= REPORTED:
        return None
    seat = situation.place.own_seat
    assert seat is not None
    low, high = seat.travel_up
    height = float(seated.up[0])
    left, way = (high - height, "high") if above < 0 else (height - low, "low")
    where = (
        f"stay {-1000 * above:.0f} mm below" if above < 0 else f"are {1000 * above:.0f} mm above"
    )
    return _shortfall(
        situation,
        LOW if above < 0 else HIGH,
        f"the eyes {where} {situation.eyes}",
        size=abs(above),
        why=f"the seat is as {way} as it goes" if left < AT_END else "",
    )


def _travel_off(situation: Situation, seated: Seated) -> Shortfall | None:
    """How far the travel ends before the seat is where a driver wants it, or legs have it by the
    pedals."""
    if isinstance(seated, DrivingPosture):
        beyond = float(seated.wanted[0] - seated.forward[0])
        at_end = float(seated.spare_travel[0, :2].min()) < AT_END
        if abs(beyond) <= REPORTED or not at_end:
            return None
        words = f"the seat would have to go {_farther(beyond)} than its travel"
        return _shortfall(situation, "seat", words, size=abs(beyond))
    if not float(situation.spare[0].min()) < AT_END:
        return None
    wanted = freely_seated(situation, FARTHER)
    seat = situation.place.own_seat
    if wanted is None or seat is None:
        return None
    forward = float(wanted.forward[0])
    beyond = forward - float(np.clip(forward, *seat.travel_forward))
    if abs(beyond) < PEDALS_OFF:
        return None
    reached = all(float(miss[0]) <= REPORTED for miss in seated.miss.values())
    return _shortfall(
        situation,
        "seat",
        f"{'the feet reach the pedals, but ' * reached}{'these' if reached else 'the pedals'} are "
        f"{_pedals_off(beyond)} for legs at ease",
        size=abs(beyond),
        why=f"the seat would have to go {_farther(beyond)} than its travel",
    )


def _farther(beyond: float) -> str:
    """How far [m] beyond its travel a seat would go: "30 mm farther back"."""
    return f"{1000 * abs(beyond):.0f} mm farther {'forward' if beyond > 0 else 'back'}"


def _pedals_off(beyond: float) -> str:
    """How pedals are for legs that would have the seat so much [m] farther forward."""
    return f"{1000 * abs(beyond):.0f} mm too {'far' if beyond > 0 else 'near'}"


def _pressed(situation: Situation, seated: Seated) -> Shortfall | None:
    """How much deeper the thighs press into the front of the cushion than it gives."""
    deeper = float(seated.pressed[0])
    if deeper <= REPORTED:
        return None
    seat = situation.place.own_seat
    assert seat is not None and seat.front is not None
    gives = seat.front.gives
    words = (
        f"the thighs press {1000 * (gives + deeper):.0f} mm deep into the front of "
        f"{seat.cushion.part}, which gives {1000 * gives:.0f} mm"
    )
    return _shortfall(situation, "thighs", words, size=deeper)


def _limb_off(
    situation: Situation,
    limb: str,
    control: str,
    miss: Floats,
    limit: tuple[Reason, ...],
    overlap: float = 0.0,
) -> Shortfall | None:
    """How far a hand or foot stays from its control, and how deep [m] it is in an obstacle."""
    short = float(miss[0])
    if short <= (REPORTED if limb.endswith("foot") else 0.0):
        return None
    if overlap > 0.0 and short <= REPORTED:
        words = short_words(limb, control, 0.0, overlap, limit[0])
        return _shortfall(situation, limb, words, size=overlap)
    words = short_words(limb, control, short, 0.0, NO_REASON)
    deep = f", which it is {_mm(overlap)} too deep in even there" if overlap > 0.0 else ""
    return _shortfall(situation, limb, words, size=short, why=limit[0].why + deep)


def _legs_inside(situation: Situation, seated: Seated) -> list[Shortfall]:
    """Of legs of which no clear posture was found, what they are in and how deep."""
    parts = situation.environment.parts
    return [
        _shortfall(
            situation,
            f"{foot.split()[0]} leg",
            f"the {foot.split()[0]} leg is {_mm(depth[0])} deeper in "
            f"{parts[seated.leg_part[foot][0]]} than is allowed",
            size=float(depth[0]),
            why=f"with the foot on {situation.work.held[foot]} no posture of it was found that is clear",
        )
        for foot, depth in seated.leg_overlap.items()
        if depth[0] > INSIDE
    ]


def setting_words(
    situation: Situation, place: Workplace, found: FittedBody, asked: Sequence[Asked]
) -> list[str]:
    """That a person has set something otherwise than a workplace had it, and why.

    situation: of the case that decides where the seat is wanted; found: of this one person.
    """
    set_so = [
        setting_text(one, value)
        for one, value in zip(adjustments_of(place), found.setting[0].tolist(), strict=True)
        if value != one.at
    ]
    if not set_so:
        return []
    lead = f"{situation.place.role}, {situation.work.name}"
    return [f"{lead}: {' and '.join(set_so)}, where {_why(place, found.tried, asked)}"]


def _why(place: Workplace, found: Outcomes, asked: Sequence[Asked]) -> str:
    """Why the first person is where he or she is."""
    if lacks := _lacks(place, found.margin[0], asked):
        return f"the shortfall is smallest: {lacks}"
    if float(np.nanmin(found.margin[0])) >= -MET:
        return "every requirement on this person is met"
    where = "where the person stands" if place.seat is None else "the seat position"
    return f"every requirement that depends on {where} is met"


def move_words(situation: Situation, found: FittedBody, asked: Sequence[Asked]) -> list[str]:
    """That the seat of a person has left the comfortable position, or that a person who stands has
    stepped, why, and what that means for the legs.

    situation: in the comfortable position of the setting found; found: of this one person.
    """
    stands = situation.place.seat is None
    aside = ("to the left of", "to the right of") if stands else ("above", "below")
    comfortable = position_of(situation)[0]
    ahead, above = (found.tried.seat[0] - comfortable).tolist()
    if not (ahead or above):
        return []
    way = [
        f"{1000 * abs(size):.0f} mm {words[0] if size > 0 else words[1]}"
        for size, words in ((ahead, ("ahead of", "behind")), (above, aside))
        if round(1000 * abs(size))
    ]
    lead = f"{situation.place.role}, {situation.work.name}"
    if stands:
        chosen = situation.work.aims is not None
        where = f"{' and '.join(way)} the {'most comfortable' if chosen else 'stated'} place"
        return [
            f"{lead}: the person stands {where}, where {_why(situation.place, found.tried, asked)}"
        ]
    where = f"{' and '.join(way)} the most comfortable position"
    why = _why(situation.place, found.tried, asked)
    before = _lacks(situation.place, found.first[0], asked)
    there = f"; in the most comfortable position {before}" if before else ""
    legs = ""
    at_end = float(situation.spare[0].min()) < AT_END  # what pedals are for the legs is said then
    if on_fixed_pedals(situation) and abs(ahead) >= PEDALS_OFF and not at_end:
        legs = f"; the pedals are then {_pedals_off(-ahead)} for legs at ease"
    return [f"{lead}: the seat is set {where}, where {why}{there}{legs}"]


def _lacks(place: Workplace, margin: Floats, asked: Sequence[Asked]) -> str:
    """What is missed most of the requirements (R,) that depend on the position, by how much, and how
    many more; "" where nothing is."""
    missed = [
        r
        for r in np.argsort(margin).tolist()
        if margin[r] < -MET and not same_everywhere(place, asked[r])
    ]
    if not missed:
        return ""
    first = asked[missed[0]]
    size = -float(margin[missed[0]])
    much = shortfall_words(first.requirement, first.criterion, size, NO_REASON)
    more = len(missed) - 1
    others = f", and {more} more requirement{'s' if more > 1 else ''} missed" if more else ""
    return f"{plain(first.requirement.name)!r} is missed by {much}{others}"


def _mm(size: float) -> str:
    return f"{1000 * size:.0f} mm" if size >= 1e-3 else f"{1000 * size:.1f} mm"
