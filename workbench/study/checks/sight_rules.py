"""Rules of sight: the view from a cockpit, pillars and the forward field of a car, the ground in
mirrors, and instruments mirrored in the windscreen.

Pillars and the forward field are of eye points that a rule gives from a seat, whoever sits there. The
others are of the eyes of each person as the posture holds them, or of a point of the environment.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from workbench.errors import InputError
from workbench.files.schema import error_at
from workbench.files.yaml_text import read_yaml
from workbench.model.accommodation import MET
from workbench.model.arrays import Floats
from workbench.model.criterion import NO_REASON, Criterion, Reason, hider
from workbench.model.environment import Environment, Mirror
from workbench.model.result import Finding
from workbench.model.rule_set import RuleSet
from workbench.model.study import Study
from workbench.model.units import UNITS, unit_of
from workbench.model.workplace import Workplace
from workbench.posture.seating.seating import leftward
from workbench.sight.eyes import Eyes, eyes_of, given_eyes
from workbench.sight.obscuration import target_of_part
from workbench.sight.regions import Region
from workbench.sight.rules.cockpit_view import COARSE, ClearView, clear_view, cockpit_outline
from workbench.sight.rules.eye_points import EyePoints, Side, car_eye_points
from workbench.sight.rules.forward_field import ForwardField, forward_field
from workbench.sight.rules.mirrors import (
    AWAY,
    OUTSIDE,
    glass_of,
    ground_points,
    mirror_field,
    mirror_ground,
    windscreen_reflection,
)
from workbench.sight.rules.pillar import PillarAngle, pillar_angle
from workbench.sight.scenery import Scenery, enclosing_items, scenery_of
from workbench.study.checks.margins import Asked, Margins, no_margins
from workbench.study.checks.sight import READ_BY
from workbench.study.situation import Situation

__all__ = [
    "asked_ground",
    "check_rules",
    "eye_points_of",
    "field_of",
    "findings",
    "margins",
    "most",
    "pillar_of",
    "rules_of",
    "source_of",
    "things_of",
]


@dataclass(frozen=True, eq=False)
class _Judged:
    """What a rule finds of B people, in SI: value (B,), which must not be below the limit, and the
    `Reason` of each (B,); source: the rule and how sure it is."""

    value: Floats
    limit: float
    why: NDArray[np.object_]
    source: str


@dataclass(frozen=True, eq=False)
class _Look:
    """Eyes of B people or of a point, where they are, and what may stand before them."""

    place: Workplace
    scenery: Scenery
    eyes: Eyes


def things_of(criterion: Criterion) -> tuple[str, ...]:
    """What a rule is asked about, each by itself: mirrors, instruments, a pillar, or the view."""
    if criterion.check == "pillar":
        return (", ".join(criterion.parts),)
    view = {"outline": "outline", "forward_field": "forward field"}
    return criterion.mirrors or criterion.instruments or (view[criterion.check],)


def margins(situation: Situation, asked: Sequence[Asked]) -> Margins:
    """How much better than asked everybody has it."""
    found = no_margins(len(situation), asked)
    for r, one in enumerate(asked):
        check = one.requirement.check
        judged = _judge(situation, one.criterion, one.requirement.target)
        found.margin[:, r] = unit_of(check).counted(judged.value - judged.limit)
        short = found.margin[:, r] < -MET
        found.words[short, r] = np.broadcast_to(judged.why, len(situation))[short]
    return found


def most(situation: Situation, asked: Sequence[Asked]) -> Floats:
    """(B, Q) what everybody has to spare at most, wherever the hands are that hold something, and
    the legs; infinite where that costs as much as to ask.

    Of outlines: what a coarse look leaves clear before what these do not move, with all that is
    hidden beside a border. Who has less than asked by more than that need not be asked.
    """
    found = np.full((len(situation), len(asked)), np.inf)
    scenery = situation.still_scenery
    if scenery is None:
        return found
    eyes = eyes_of(situation.placed)
    inside = np.maximum(enclosing_items(scenery, eyes.left), enclosing_items(scenery, eyes.right))
    for q, one in enumerate(asked):
        if one.requirement.check != "outline" or one.criterion.eye_point:
            continue
        region = _region(situation.place, one.criterion)
        for row in np.flatnonzero(inside < 0).tolist():
            view = clear_view(scenery, eyes, region, row=row, step=COARSE)
            found[row, q] = unit_of("outline").counts * (view.most - one.criterion.at_least)
    return found


def findings(situation: Situation, criterion: Criterion) -> Iterator[Finding]:
    """What a rule finds of each thing."""
    for name in things_of(criterion):
        judged = _judge(situation, criterion, name)
        yield Finding(
            case=situation.work.name,
            person=situation.place.role,
            other_person="",
            subject=name,
            target=judged.why[0].text,
            value=float(judged.value[0]),
            limit=judged.limit,
            unit=next(key for key, unit in UNITS.items() if unit is unit_of(criterion.check)),
            source=judged.source,
        )


def eye_points_of(environment: Environment, criterion: Criterion, seat: str) -> EyePoints:
    """The eye points of UN R125 for who sits in a seat: from the point that a criterion names, the
    angle of the seat's back and the length of its travel.

    InputError where the rule has none for that seat back.
    """
    one = environment.seat(seat)
    low, high = one.travel_forward
    try:
        return car_eye_points(
            environment.points[criterion.r_point],
            one.back_angle,
            rules_of(criterion),
            seat_travel=high - low,
            driver=_side(criterion.side),
        )
    except InputError as error:
        raise InputError(f"criterion {criterion.name!r}, seat {seat!r}: {error}") from None


def check_rules(study: Study) -> None:
    """Raise InputError for criteria of sight that cannot be judged in their seats or with their
    things, all at once: where they stand in the study's file, and what would be right."""
    faults = []
    for criterion in study.criteria:
        asked = [role.seat for role in study.roles if role.name in criterion.people]
        for seat in dict.fromkeys(asked):
            for key, right, ask in _BEFORE_A_RUN.get(criterion.check, ()):
                try:
                    ask(study.environment, criterion, seat or "")
                except InputError as error:
                    words = f"{error}; {right}, or leave the criterion out"
                    faults.append(_placed(study, criterion, key, words))
                    break
    if faults:
        raise InputError(tuple(dict.fromkeys(faults)))


def _mirrors_given(environment: Environment, criterion: Criterion, _: str) -> None:
    """InputError where a mirror has no surface, or its class no ground."""
    for name in criterion.mirrors:
        mirror = environment.mirror(name)
        try:
            glass_of(environment, mirror)
            ground_points(asked_ground(environment, criterion, mirror, np.array(mirror.at)))
        except InputError as error:
            raise InputError(f"criterion {criterion.name!r}, {error}") from None


def _instruments_ahead(environment: Environment, criterion: Criterion, seat: str) -> None:
    """InputError where nobody in a seat has the eyes behind an instrument."""
    if not seat:
        return
    one = environment.seat(seat)
    ahead = np.array([np.cos(one.yaw), np.sin(one.yaw), 0.0])
    for name in criterion.instruments:
        behind = float(ahead @ np.subtract(one.nominal_eye, environment.instrument(name).at))
        if behind > _EYES_BACK:
            raise InputError(
                f"criterion {criterion.name!r}, instrument {name!r}: it is {1000 * behind:.0f} mm "
                f"behind the usual place of the eyes in seat {seat!r}, so that nobody there reads it"
            )


def _placed(study: Study, criterion: Criterion, key: str, words: str) -> str:
    """A fault of a key of a criterion, with its place where the study is from a file."""
    if "study" not in study.inputs:
        return f"{key}: {words}"
    document = read_yaml(study.inputs["study"])
    names = [one.get("name") for one in document.value["criteria"]]
    row = names.index(criterion.name) if criterion.name in names else 0
    return error_at(document, ("criteria", row, key), words)


def source_of(criterion: Criterion, *more: str) -> str:
    """Name the rule of a criterion, with which of the values that it is judged by are not sure, and
    their doubts; more: names of values beside those that its check always has."""
    used = [name for name in _USED.get(criterion.check, ()) if name in rules_of(criterion).values]
    stated = ["pillar_limit"] if criterion.at_most else []
    return rules_of(criterion).told(*(name for name in used if name not in stated), *more)


def rules_of(criterion: Criterion) -> RuleSet:
    """The rule set of a criterion that has one."""
    assert criterion.rule_set is not None
    return criterion.rule_set


def _side(name: str) -> Side:
    return "left" if name == "left" else "right"


@dataclass(frozen=True)
class _OfSeat:
    """What a rule finds of a seat [rad], whoever sits there, and what there is to say of it."""

    angle: float
    why: Reason


def _judged(situation: Situation, found: _OfSeat, most: float, source: str) -> _Judged:
    """What must not exceed a limit, the same for everybody."""
    count = len(situation)
    why = np.full(count, found.why, dtype=object)
    return _Judged(np.full(count, -found.angle), -most, why, source)


def _judge(situation: Situation, criterion: Criterion, name: str) -> _Judged:
    """What a rule finds; of a point of the environment once for all people, (1,)."""
    if criterion.check in _OF_SEATS:
        return _OF_SEATS[criterion.check](situation, criterion, name)
    if criterion.eye_point:
        return _from_point(situation.place, criterion, name)
    look = _Look(situation.place, situation.scenery, eyes_of(situation.placed))
    return _OF_EYES[criterion.check](look, criterion, name)


@lru_cache(maxsize=64)
def _from_point(place: Workplace, criterion: Criterion, name: str) -> _Judged:
    """What a rule finds from a point: nobody's body stands before it, and seats stand in their
    reference positions."""
    left = leftward(place)
    point = np.array([place.environment.points[criterion.eye_point]])
    eyes = given_eyes(point, ahead=(left[1], -left[0], 0.0))
    look = _Look(place, scenery_of(place.environment), eyes)
    return _OF_EYES[criterion.check](look, criterion, name)


def _region(place: Workplace, criterion: Criterion) -> Region:
    """The outline about the direction in which people face."""
    left = leftward(place)
    axes = np.stack([np.array([left[1], -left[0], 0.0]), left, np.array([0.0, 0.0, 1.0])])
    return cockpit_outline(rules_of(criterion), seat=_side(criterion.side), axes=axes)


def _outline(look: _Look, criterion: Criterion, _: str) -> _Judged:
    """The share of the outline of AC 25.773-1 that is clear."""
    scenery, eyes = look.scenery, look.eyes
    region = _region(look.place, criterion)
    inside = np.maximum(enclosing_items(scenery, eyes.left), enclosing_items(scenery, eyes.right))
    clear = np.zeros(len(eyes))
    why = np.full(len(eyes), NO_REASON, dtype=object)
    for row in range(len(eyes)):
        if inside[row] >= 0:
            why[row] = hider(scenery.names[inside[row]], look.place.environment.parts)
            continue
        view = clear_view(scenery, eyes, region, row=row)
        clear[row] = view.clear
        why[row] = _hides_most(view, region, look.place.environment.parts)
    return _Judged(clear, criterion.at_least, why, source_of(criterion))


def _hides_most(view: ClearView, region: Region, parts: tuple[str, ...]) -> Reason:
    """What hides most of the outline, and its share of it."""
    chief = max(view.hidden, key=lambda name: view.hidden[name], default="")
    return hider(chief, parts, view.hidden.get(chief, 0.0) / region.solid_angle)


def _pillar(situation: Situation, criterion: Criterion, _: str) -> _Judged:
    """The angle that a pillar hides from both eyes."""
    assert situation.place.seat is not None
    rules = rules_of(criterion)
    found = _pillar_angle(situation.environment, criterion, situation.place.seat)
    limit = criterion.at_most or rules.number("pillar_limit")
    return _judged(situation, found, limit, source_of(criterion))


@lru_cache(maxsize=64)
def pillar_of(environment: Environment, criterion: Criterion, seat: str) -> PillarAngle:
    """What a pillar hides from the eyes that a criterion's rule turns to it, for a seat; the side of a
    pillar is that of its middle. InputError as of `pillar_angle` and `eye_points_of`."""
    points = eye_points_of(environment, criterion, seat)
    corners = np.concatenate(
        [environment.triangle_corners(environment.part_index(part)) for part in criterion.parts]
    )
    side: Side = "left" if corners[..., 1].mean() > points["pm"][1] else "right"
    try:
        return pillar_angle(corners, points, rules_of(criterion), side=side)
    except InputError as error:
        raise InputError(f"criterion {criterion.name!r}: {error}") from None


def _pillar_angle(environment: Environment, criterion: Criterion, seat: str) -> _OfSeat:
    """[rad] hidden."""
    found = pillar_of(environment, criterion, seat)
    upper, lower = np.degrees((found.of_upper, found.of_lower)).tolist()
    return _OfSeat(found.angle, Reason("cuts", f"{upper:.1f} and {lower:.1f} degrees"))


def _field(situation: Situation, criterion: Criterion, _: str) -> _Judged:
    """How wide something stands in the forward field."""
    assert situation.place.seat is not None
    found = _field_width(situation.environment, criterion, situation.place.seat)
    return _judged(situation, found, criterion.at_most, source_of(criterion))


@lru_cache(maxsize=64)
def field_of(environment: Environment, criterion: Criterion, seat: str) -> ForwardField:
    """What stands in the forward field of a criterion, for a seat. InputError as of `forward_field`
    and `eye_points_of`."""
    return forward_field(
        environment,
        eye_points_of(environment, criterion, seat),
        rules_of(criterion),
        exempt=criterion.parts,
        wheel=criterion.wheel,
        inside_wheel=criterion.inside_wheel,
    )


def _field_width(environment: Environment, criterion: Criterion, seat: str) -> _OfSeat:
    """[rad] that is covered, and the part that covers most of it."""
    found = field_of(environment, criterion, seat)
    chief = max(found.blocked, key=lambda name: found.blocked[name].width, default="")
    return _OfSeat(found.width, hider(chief, environment.parts))


def _mirror(look: _Look, criterion: Criterion, name: str) -> _Judged:
    """The share of the ground of a mirror's class that is seen in it."""
    environment = look.place.environment
    mirror = environment.mirror(name)
    scenery, eyes = look.scenery, look.eyes
    seen = np.zeros(len(eyes))
    why = np.full(len(eyes), NO_REASON, dtype=object)
    for row, middle in enumerate(eyes.middle):
        polygon = asked_ground(environment, criterion, mirror, middle)
        found = mirror_field(
            scenery,
            eyes,
            glass_of(environment, mirror, eye=middle),
            ground_points(polygon, count=_GROUND),
            item=environment.part_index(mirror.part),
            row=row,
        )
        seen[row] = found.share
        if found.hidden:
            chief = max(found.hidden, key=lambda item: found.hidden[item])
            why[row] = hider(chief, environment.parts, found.hidden[chief])
            if chief in (OUTSIDE, AWAY):
                why[row] = Reason("outside", chief, share=round(found.hidden[chief], 3))
    return _Judged(seen, criterion.at_least, why, source_of(criterion, f"field_{mirror.field}"))


def asked_ground(
    environment: Environment, criterion: Criterion, mirror: Mirror, eye: Floats
) -> Floats:
    """The corners (K, 3) [m] of the ground that a criterion asks for in a mirror, for eyes with their
    middle (3,) [m]."""
    ground = environment.points[criterion.ground][2]
    rules = rules_of(criterion)
    return mirror_ground(
        environment, mirror, rules, eye=eye, vehicle=criterion.parts, ground=ground
    )


def _reflection(look: _Look, criterion: Criterion, name: str) -> _Judged:
    """The share of an instrument whose image in the windscreen is inside the outline."""
    environment = look.place.environment
    scenery, eyes = look.scenery, look.eyes
    region = _region(look.place, criterion)
    one = environment.instrument(name)
    target = target_of_part(environment, one.part, facing=one.face)
    share = np.zeros(len(eyes))
    why = np.full(len(eyes), NO_REASON, dtype=object)
    for row in range(len(eyes)):
        found = windscreen_reflection(
            scenery,
            eyes,
            target,
            environment=environment,
            windscreen=criterion.parts,
            region=region,
            row=row,
        )
        share[row] = found.share
        if found.parts:
            why[row] = Reason("mirrored", ", ".join(found.parts))
    return _Judged(-share, -criterion.at_most, why, source_of(criterion))


_USED = {
    "outline": ("outline_left_seat",),
    "reflection": ("outline_left_seat",),
    "pillar": (
        *("p1", "p2", "pm", "seat_back_shift", "seat_travel_over", "seat_travel_shift"),
        *("p_to_e", "e_apart", "s1_rise", "s2_fall", "pillar_limit"),
    ),
    "forward_field": ("v1", "v2", "seat_back_shift", "field_fall", "wheel_fall"),
    "reads": READ_BY,
}
"""The values of its rule set that a check is judged by."""
_GROUND = 900
"""Points of the ground of a mirror: a share is known to about 1 %."""
_OF_SEATS: dict[str, Callable[[Situation, Criterion, str], _Judged]] = {
    "pillar": _pillar,
    "forward_field": _field,
}
_EYES_BACK = 0.25
"""[m] From the usual place of eyes in a seat back to where nobody's are, in no position of it."""
_BACK_ANGLE = ("rules", "set 'back_angle' of the seat within it")
_BEFORE_A_RUN: dict[
    str, tuple[tuple[str, str, Callable[[Environment, Criterion, str], object]], ...]
] = {
    "pillar": (
        (*_BACK_ANGLE, eye_points_of),
        ("parts", "name the parts of the A-pillar there", _pillar_angle),
    ),
    "forward_field": (
        (*_BACK_ANGLE, eye_points_of),
        ("wheel", "name the parts of the steering wheel", _field_width),
    ),
    "mirror": (("mirrors", "leave it out of 'mirrors'", _mirrors_given),),
    "reads": (("instruments", "leave it out of 'instruments'", _instruments_ahead),),
}
"""What is tried of a check before a run, for each seat: the key of the criterion that a fault is put down
to, and what would be right."""
_OF_EYES: dict[str, Callable[[_Look, Criterion, str], _Judged]] = {
    "outline": _outline,
    "mirror": _mirror,
    "reflection": _reflection,
}
