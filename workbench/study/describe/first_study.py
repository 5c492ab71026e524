"""Write a first study of an environment: somebody in each seat or at each group of controls, with
what a reviewer asks of any workplace.

It is a beginning to be edited. What was guessed stands in it as comments, and so do the limits
that this project assumes.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.files.environment_doubts import part_box
from workbench.files.names import words_of
from workbench.files.yaml_changes import flow_text
from workbench.model.arrays import Bools, Floats
from workbench.model.environment import Control, Environment
from workbench.sight.rays import first_hits
from workbench.study.describe.at_controls import SeatFrame, Sitter, left_out, sitters_of
from workbench.study.describe.people import PERSON
from workbench.study.describe.standing_place import (
    MAY_STEP,
    StandingPlace,
    floor_mm,
    standing_places,
)
from workbench.study.feet_on_floor import BROAD

__all__ = ["Around", "around", "first_study", "floor_below", "guesses_of"]

HEAD_ROOM = 50
KNEE_ROOM = 30
WHEEL_ROOM = 25
BELLY_ROOM = 50
EYES_BELOW = 25
EYES_ABOVE = 40
DOWN = 5
TRAVEL_LEFT = 20
SHARE = 90
GIVES = 10
"""Limits that are assumed: [mm], degrees, percent."""
SHORT_TRAVEL = 0.06
"""Of less travel [m] nothing is asked to be left."""
SHANKS = ["LLL", "RLL", "LF", "RF"]
LIMBS = ["LLA", "RLA", "LHN", "RHN", *SHANKS]
"""Segments that are asked not to be in the rest of the body: folds of trunk, shoulders and hips are
no fault."""
LEGS = ["LUL", "RUL", "LLL", "RLL"]
CASE = "at the controls"
AT_REST = "seated"
STANDING = "standing"
"""Names of the case, where anybody is at controls and where nobody is."""
LEANING = "bending and stepping, in balance"
"""What zone 3 is to somebody who stands."""
THIGH = 0.42
SHANK = 0.50
HIP = 0.09
OVER_FLOOR = 0.015
"""Of a median man hip to knee, knee to sole, and the hip point above the cushion [m]; and how far
[m] soles are kept over the floor."""
MOST_LEAN = 0.77
"""A shank leans forward by no more than the angle of this cosine: then knees rise."""
SOLE = 25.0
"""Degrees by which a foot is stretched at most, so that the sole lies flat."""
ARM_AT_REST = {
    "C": {"protraction": 0},
    "S": {"flexion": 15, "medial_rotation": 15},
    "E": {"flexion": 75},
    "W": {"pronation": 50, "flexion": 4},
}
"""A hand above the own thigh, in degrees by joint of its side."""


@dataclass(frozen=True)
class _Row:
    """A criterion, and what is assumed in it or says what it is about; "" where nothing is."""

    asked: dict[str, Any]
    note: str = ""


def first_study(environment: Environment, source: str, *, people: int = 0) -> str:
    """Return the text of a study that runs as it is.

    Parameters
    ----------
    environment
        The environment.
    source
        How the study is to name it: a name of the catalogue, or a path from the study's file.
    people
        So many people of a survey take the place of the one who operates most. One person in each
        place if 0.
    """
    sitters = sitters_of(environment)
    stands = {} if sitters else _stand_names(standing_places(environment))
    if people:
        sitters = _most_operating(sitters)
        stands = dict(list(stands.items())[:1])
    name = _plain_name(environment.name) + ("_people" if people else "")
    asked = {one.name for sitter in sitters.values() for one in sitter.asked}
    asked |= {one.name for stand in stands.values() for one in stand.controls}
    around_each = {role: around(environment, sitter) for role, sitter in sitters.items()}
    lines = [
        "# A first study, made by `workbench new`: a beginning to be edited.",
        "# docs/studies.md has all that can be said here. What was guessed:",
        *(f"#   {line}" for line in _guesses(sitters, stands)),
        *(f"#   {line}" for line in left_out(environment, asked) if not people),
        f"study: {name}",
        "length: mm",
        f"environment: {flow_text(source)}",
        "people:                       # who is present at once; other people: size, population",
    ]
    extra = {"population": {"source": "ansur2", "people": people, "seed": 1}} if people else {}
    for role, sitter in sitters.items():
        who = {"body": PERSON, "seat": sitter.frame.seat.name, **extra}
        lines.append(f"  {flow_text(role)}: {flow_text(who)}")
    for role, stand in stands.items():
        on = [round(1e3 * value) for value in stand.on[:2]]
        on.append(floor_mm(stand.on[2]))
        place = {"on": on, "yaw": round(math.degrees(stand.yaw)), **_steps(stand)}
        lines.append(f"  {flow_text(role)}: {flow_text({'body': PERSON, 'stand': place, **extra})}")
    actions = {
        role: _action(role, sitter, around_each[role], len(sitters))
        for role, sitter in sitters.items()
    }
    lines += _posture_lines([made.posture for made in actions.values() if made.posture])
    case = AT_REST if sitters else STANDING
    if any(one.operates for one in sitters.values()) or any(
        one.controls for one in stands.values()
    ):
        case = CASE
    lines += ["cases:", f"  - name: {case}", "    people:"]
    for role, made in actions.items():
        lines.append(f"      {flow_text(role)}: {flow_text(made.action)}")
    lines += [f"      {flow_text(role)}: {flow_text({'posture': 'standing'})}" for role in stands]
    rows = [*_asked(sitters, around_each, stands, people)]
    if people:
        share = {"name": f"{SHARE} in a hundred", "check": "share", "at_least": SHARE}
        rows.append(_Row(share, "assumed: the share of these people who meet everything"))
    return "\n".join([*lines, "criteria:", *_criteria_lines(rows)]) + "\n"


def guesses_of(text: str) -> list[str]:
    """What was guessed in a first study, as its text says it."""
    return [line[4:] for line in text.splitlines() if line.startswith("#   ")]


def _plain_name(words: str) -> str:
    """A name of a study: letters, digits and underscores."""
    return "_".join(re.findall(r"[a-z0-9]+", words.lower())) or "study"


def _stand_names(places: Sequence[StandingPlace]) -> dict[str, StandingPlace]:
    """A role for each place where somebody stands."""
    if len(places) == 1:
        return {"person": places[0]}
    return {f"at {place.controls[0].name}": place for place in places}


def _most_operating(sitters: Mapping[str, Sitter]) -> dict[str, Sitter]:
    """The sitter with most hands and feet on controls, the first of these."""
    if not sitters:
        return {}
    most = max(sitters, key=lambda role: len(sitters[role].hands) + len(sitters[role].feet))
    return {most: sitters[most]}


def _steps(stand: StandingPlace) -> dict[str, Any]:
    """The area [mm] to step in, {} where there is none."""
    ways = {
        name: [round(1e3 * end) for end in ends] for name, ends in stand.area.items() if any(ends)
    }
    return {"area": ways} if ways else {}


def _guesses(sitters: Mapping[str, Sitter], stands: Mapping[str, StandingPlace]) -> Iterator[str]:
    """What was guessed, and by what."""
    for role, sitter in sitters.items():
        yield from (f"{role}: {why}" for why in sitter.why)
        if sitter.operates and not sitter.eyes:
            yield f"{role}: no eye point is near where the eyes are: no view is asked for"
        if sitter.hands and not sitter.feet:
            yield f"{role}: no pedal is nearest to the seat: legs rest as the seat has them"
    most = max(max(ends) for ends in MAY_STEP.values())
    for role, stand in stands.items():
        yield f"{role} stands {stand.why}"
        if _steps(stand):
            yield (
                f"{role} may step as far as the floor is level and somebody small or tall is clear but "
                f"for {GIVES} mm, arms apart, at most {most:g} m"
            )
            yield from (
                f"{role} may step no more than {far}: farther on, {why}"
                for far, why in stand.limits.items()
            )


@dataclass(frozen=True)
class _Action:
    """What a role does, and the posture that is made for it, None where there is none."""

    action: dict[str, Any]
    posture: tuple[str, dict[str, Any]] | None


def _action(role: str, sitter: Sitter, about: Around, seats: int) -> _Action:
    """What the occupant of a seat does: hands and feet on controls, or at rest."""
    name = "at rest" if seats == 1 else f"{role} at rest"
    if not sitter.operates:
        angles = {**_legs(sitter, about), **_arms(["left", "right"])}
        return _Action({"posture": name}, (name, {"like": "driving", "angles": angles}))
    predicted: dict[str, Any] = {}
    posture = None
    resting = [side for side in ("left", "right") if side not in sitter.hands]
    if resting or not sitter.feet:
        predicted["like"] = name
        legs = {} if sitter.feet else _legs(sitter, about)
        posture = (name, {"like": "driving", "angles": {**legs, **_arms(resting)}})
    predicted |= {"hands": sitter.hands} if sitter.hands else {}
    predicted |= {"feet": sitter.feet} if sitter.feet else {}
    predicted |= {"eyes": sitter.eyes} if sitter.eyes else {}
    predicted |= {"heels": sitter.heels} if sitter.heels else {}
    return _Action({"predicted": predicted}, posture)


def _arms(sides: Sequence[str]) -> dict[str, Any]:
    """Angles of arms at rest."""
    letters = " ".join(f"{side[0].upper()}{{}}" for side in sides)
    return {letters.replace("{}", joint): angles for joint, angles in ARM_AT_REST.items() if sides}


def _legs(sitter: Sitter, about: Around) -> dict[str, Any]:
    """Angles of legs that lie along the cushion with the soles flat on the floor. Over a low floor
    the shanks hang, over a high one the knees rise."""
    seat = sitter.frame.seat
    rise = seat.cushion_angle
    lean = 0.0
    if about.floor is not None:
        hip = seat.srp[2] + HIP - about.floor - OVER_FLOOR
        lean = math.acos(min(max((hip + THIGH * math.sin(rise)) / SHANK, MOST_LEAN), 1.0))
        rise = math.asin(min(max((SHANK * math.cos(lean) - hip) / THIGH, math.sin(rise)), 0.7))
    return {
        "LH RH": {"flexion": round(90.0 + math.degrees(rise - seat.back_angle)), "abduction": 3},
        "LK RK": {"flexion": round(90.0 + math.degrees(rise - lean))},
        "LA RA": {"plantarflexion": round(min(math.degrees(lean), SOLE))},
    }


def _posture_lines(postures: Sequence[tuple[str, dict[str, Any]]]) -> list[str]:
    """The postures of the study."""
    if not postures:
        return []
    return [
        "postures:",
        *(f"  {flow_text(name)}: {flow_text(posture)}" for name, posture in postures),
    ]


def _criteria_lines(rows: Sequence[_Row]) -> Iterator[str]:
    for row in rows:
        if row.note:
            yield f"  # {row.note}"
        yield f"  - {flow_text(row.asked)}"


def _asked(
    sitters: Mapping[str, Sitter],
    around_each: Mapping[str, Around],
    stands: Mapping[str, StandingPlace],
    people: int,
) -> Iterator[_Row]:
    """What is asked of everybody, and of each by where he is."""
    contact = {"name": "nobody is in the structure", "check": "contact"}
    gives = {"at_most": GIVES} if people else {}
    yield _Row(
        contact | gives, "assumed: flesh, sleeves and soles give way by so much" * bool(people)
    )
    note = "forearms, hands, shanks and feet: folds of trunk, shoulders and hips are no fault"
    limbs = LIMBS
    if not sitters:  # arms hang as the posture has them, beside hips of any breadth
        note = "shanks and feet: arms that hang at rest give way, folds are no fault"
        limbs = SHANKS
    if people:
        note += "; assumed: where two limbs lie on one another, the flesh of both gives way"
    own = {"name": "no one overlaps himself", "check": "self_contact", "segments": limbs}
    yield _Row(own | {key: 2 * most for key, most in gives.items()}, note)
    several = len(sitters) + len(stands) > 1
    for role, sitter in sitters.items():
        for row in _asked_in_seat(sitter, around_each[role], people):
            yield _owned(row, role) if several else row
    for role, stand in stands.items():
        for row in _reaches(stand.controls, LEANING):
            yield _owned(row, role) if several else row
    if several:
        room = {"name": "room between people", "check": "between_people", "at_least": 0}
        yield _Row(room)


def _owned(row: _Row, role: str) -> _Row:
    """A criterion of one of several roles."""
    asked = row.asked
    name = f"{role}: {asked['name']}"
    return _Row({"name": name, "check": asked["check"], "people": [role], **_but(asked)}, row.note)


def _but(asked: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in asked.items() if key not in ("name", "check")}


def _asked_in_seat(sitter: Sitter, about: Around, people: int) -> Iterator[_Row]:
    """What is asked of the occupant of a seat; a population may use the travel up to its ends."""
    yield from _view(sitter, about)
    yield from _clearances(sitter, about)
    if sitter.feet:
        yield _Row({"name": "feet on the pedals", "check": "pedals"})
    seat = sitter.frame.seat
    low, high = seat.travel_forward
    worked = {one.part for one in sitter.asked if one.name in sitter.feet.values()}
    if worked - {*seat.moves} and not people and high - low >= SHORT_TRAVEL:
        travel = {"name": "travel left", "check": "preferred_seat", "at_least": TRAVEL_LEFT}
        note = "assumed: so much of the seat's travel is left fore and aft where it is comfortable"
        yield _Row(travel, note)
    yield from _reaches(sitter.asked)


def _view(sitter: Sitter, about: Around) -> Iterator[_Row]:
    """What is asked of the eyes, where a design eye is."""
    if not sitter.eyes:
        return
    heights = {"below": EYES_BELOW, "above": EYES_ABOVE}
    note = "assumed: the eyes come so near to the height of the design eye"
    yield _Row(
        {"name": "eyes at the height of the design eye", "check": "eye_height", **heights}, note
    )
    if about.over:
        over = {"name": "view ahead", "check": "view_over", "parts": list(about.over)}
        note = f"assumed: {DOWN} degrees down over what lies before the eyes, parts by their names"
        yield _Row({**over, "down": DOWN}, note)


def _clearances(sitter: Sitter, about: Around) -> Iterator[_Row]:
    """What is asked of the room about an occupant."""
    if about.above:
        soup = not about.rests.isdisjoint(about.above)  # the headrest may be of the same part
        who = {"subparts": ["H/crown"]} if soup else {"segments": ["H"]}
        parts = {"parts": list(about.above), "at_least": HEAD_ROOM}
        note = "assumed: room for a headset and bumps; the parts that are above the head"
        yield _Row({"name": "head room", "check": "clearance", **who, **parts}, note)
    if about.before:
        soup = not about.rests.isdisjoint(about.before)  # shanks are near the floor
        knees = {"subparts": ["LLL/knee cap", "RLL/knee cap"]}
        who = knees if soup else {"segments": LEGS}
        parts = {"parts": list(about.before), "at_least": KNEE_ROOM}
        note = "assumed: room to get in and out; the parts that are before knees and shins"
        yield _Row({"name": "knee room", "check": "clearance", **who, **parts}, note)
    if sitter.wheels:
        parts = {"parts": list(sitter.wheels)}
        thighs = {"segments": ["LUL", "RUL"], **parts, "at_least": WHEEL_ROOM}
        yield _Row(
            {"name": "thighs to the wheel", "check": "clearance", **thighs},
            "assumed: room to turn the wheel",
        )
        belly = {"segments": ["LT", "CT", "UT"], **parts, "at_least": BELLY_ROOM}
        yield _Row({"name": "belly to the wheel", "check": "clearance", **belly}, "assumed")


def _reaches(
    controls: Sequence[Control], leaning: str = "leaning over the lap belt"
) -> Iterator[_Row]:
    """The controls of each zone are reached."""
    zones = {
        1: ("primary controls", "zone 1, without stretching a shoulder"),
        2: ("secondary controls", "zone 2, with the shoulder stretched"),
        3: ("other controls", f"zone 3, {leaning}"),
    }
    for zone, (name, note) in zones.items():
        names = [one.name for one in controls if one.zone == zone]
        if names:
            yield _Row({"name": f"{name} in reach", "check": "reach", "controls": names}, note)


# What is about the occupant of a seat: above the head, before the knees, under the feet.
#
# Rays go from where head and knees of a median man are. The parts that they meet first are those
# that a clearance is asked from.

HEAD = (-0.09, 0.04)
"""The middle of the head is so far [m] ahead of and above the eyes."""
ROOF = 0.6
"""What is farther [m] from the middle of the head is not asked about."""
KNEES = ((0.50, 0.16, 0.22), (0.50, -0.16, 0.22), (0.62, 0.14, 0.0), (0.62, -0.14, 0.0))
"""Knees and shins, ahead, to the left and above the seat reference point [m]."""
PANEL = 0.4
"""What is farther [m] from knees and shins is not asked about."""
LAP = ((0.1, 0.15), (0.1, -0.15), (0.25, 0.12), (0.25, -0.12), (0.4, 0.1), (0.4, -0.1))
"""Buttocks and thighs, ahead and to the left [m]: what is below them bears the cushion, and a thigh
that sinks into the cushion comes near to it, whoever sits there."""
FEET = ((0.50, 0.1), (0.50, -0.1), (0.65, 0.1), (0.65, -0.1), (0.80, 0.1), (0.80, -0.1))
"""Where feet may stand, ahead and to the left [m]."""
DROP = 0.8
"""A floor that is farther [m] below the seat is none to stand on."""
UNEVEN = 0.1
"""What is higher [m] than the middle of the floor is a step, not a slope."""
COAMING = {
    "panel",
    "dash",
    "dashboard",
    "glareshield",
    "glare",
    "coaming",
    "cowl",
    "cowling",
    "hood",
    "bonnet",
    "fascia",
    "instrumententafel",
    "armaturenbrett",
    "haube",
    "tableau",
    "capot",
    "cruscotto",
    "cofano",
    "tablero",
}
"""What one looks out over is called so."""
AHEAD = 2.5
"""A coaming is no farther [m] ahead of the eyes."""


@dataclass(frozen=True, eq=False)
class Around:
    """What is about an occupant.

    above, before, over: the parts above the head, before the knees, and that one looks out over.
    rests: those parts of `above` and `before` that the occupant also sits, or stands on, or that are
    below the lap. floor:
    height [m], None where nothing is under the feet.
    """

    above: tuple[str, ...]
    before: tuple[str, ...]
    over: tuple[str, ...]
    rests: frozenset[str]
    floor: float | None


def around(environment: Environment, sitter: Sitter) -> Around:
    """Find what is about the occupant of a seat."""
    frame = sitter.frame
    seat = frame.seat
    eye = np.array(environment.points[sitter.eyes] if sitter.eyes else seat.nominal_eye)
    held = {*sitter.hands.values(), *sitter.feet.values()}
    touched = {one.part for one in environment.controls if one.name in held or one.for_feet}
    fixed = _visible(environment, seat.moves)
    stood_on, floor = floor_below(environment, frame, fixed)
    lap = np.array([frame.world(ahead, left, 0.1) for ahead, left in LAP])
    below = _met(environment, lap, np.array([[0.0, 0.0, -1.0]]), DROP / 2, fixed)
    rests = {*seat.parts, *stood_on, *below}
    head = eye + HEAD[0] * frame.ahead + np.array([0.0, 0.0, HEAD[1]])
    steep = _upright_fan(frame.ahead, np.radians([35.0, 55.0, 75.0, 90.0]), _turns(180.0))
    low = _upright_fan(frame.ahead, np.radians([15.0]), _turns(90.0))
    above = _met(environment, head[None], np.concatenate([steep, low]), ROOF, fixed)
    knees = np.array([frame.world(*place) for place in KNEES])
    fan = _upright_fan(frame.ahead, np.radians([-10.0, 10.0, 40.0, 70.0]), _turns(60.0))
    hittable = fixed & ~np.isin(environment.parts, list(touched | set(sitter.wheels)))
    before = _met(environment, knees, fan, PANEL, hittable)
    return Around(
        tuple(above),
        tuple(before),
        tuple(_looked_over(environment, frame, eye)) if sitter.eyes else (),
        frozenset(rests & {*above, *before}),
        environment.points[sitter.heels][2] if sitter.heels else floor,
    )


def _upright_fan(ahead: Floats, rises: Floats, turns: Floats) -> Floats:
    """(R, 3) unit directions at angles of elevation, each at all angles [rad] about the vertical
    from straight `ahead` (3,)."""
    aside = np.array([-ahead[1], ahead[0], 0.0])
    rise, turn = (axis.ravel() for axis in np.meshgrid(rises, turns, indexing="ij"))
    level = np.cos(turn)[:, None] * ahead + np.sin(turn)[:, None] * aside
    found: Floats = np.cos(rise)[:, None] * level
    found[:, 2] = np.sin(rise)
    return found


def _turns(most: float) -> Floats:
    """Angles [rad] from straight ahead to both sides, 30 degrees apart, the greatest in degrees."""
    return np.radians(np.arange(-most, most + 1.0, 30.0))


def _visible(environment: Environment, without: Iterable[str]) -> Bools:
    """(K,) the shown parts without some."""
    return ~environment.hidden & ~np.isin(environment.parts, list(without))


def _met(
    environment: Environment, origins: Floats, ways: Floats, length: float, among: Bools
) -> list[str]:
    """The parts that rays from each origin meet first."""
    starts = np.repeat(origins, len(ways), axis=0)
    hits = first_hits(
        environment, starts, np.tile(ways, (len(origins), 1)), length=length, among=among
    )
    return [environment.parts[part] for part in hits.parts]


def floor_below(
    environment: Environment, frame: SeatFrame, among: Bools
) -> tuple[list[str], float | None]:
    """What is under the feet of an occupant: parts, and the height [m] of the highest place there;
    None where nothing is."""
    starts = np.array([frame.world(ahead, left, 0.1) for ahead, left in FEET])
    down = np.tile([0.0, 0.0, -1.0], (len(starts), 1))
    pedals = {one.part for one in environment.controls if one.for_feet and one.part}
    pedals = {part for part in pedals if _breadth(environment, part) <= BROAD}
    hits = first_hits(
        environment,
        starts,
        down,
        length=DROP + 0.1,
        among=among & ~np.isin(environment.parts, list(pedals)),
    )
    met = np.isfinite(hits.distance)
    if not met.any():
        return [], None
    heights = starts[met, 2] - hits.distance[met]
    low = heights < frame.srp[2] - 0.03  # else it is the cushion's own front
    if not low.any():
        return [], None
    parts = [environment.parts[part] for part in np.unique(hits.part[met][low])]
    middle = float(np.median(heights[low]))
    return parts, float(heights[low & (heights <= middle + UNEVEN)].max())


def _breadth(environment: Environment, part: str) -> float:
    """The smaller extent [m] of a part as seen from above."""
    return float(np.ptp(part_box(environment, part), axis=0)[:2].min())


def _looked_over(environment: Environment, frame: SeatFrame, eye: Floats) -> list[str]:
    """The parts by name that lie before the eyes and below them, in the seat's upright plane."""
    found = []
    for part, name in enumerate(environment.parts):
        if environment.hidden[part] or COAMING.isdisjoint(words_of(name)):
            continue
        way = environment.triangle_corners(part).reshape(-1, 3) - eye
        ahead = way @ frame.ahead
        left = way @ frame.left
        if (
            len(way)
            and 0.1 < ahead.max() < AHEAD
            and left.min() < 0 < left.max()
            and way[:, 2].max() < 0.05
        ):
            found.append(name)
    return found
