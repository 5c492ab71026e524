"""What a reader of a result must know that no criterion asks: stops breached, bodies swallowed or
enclosed, seats missed."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.contact.enclosure import enclosed
from workbench.files.seat_doubts import place_of, rest_doubts
from workbench.geometry.ground import Ground, ground_of
from workbench.geometry.polygon import winding_number
from workbench.model.arrays import Floats
from workbench.model.criterion import Criterion
from workbench.model.environment import Doubt, Environment, Rest, Seat
from workbench.model.poses import Placed
from workbench.model.result import Finding, PersonFound, Verdict
from workbench.model.stops import motion_words
from workbench.model.study import Role
from workbench.model.units import tenths
from workbench.posture.seating.seating import seat_planes, seat_shift
from workbench.study.feet_on_floor import FeetOnFloor, feet_on_floor, feet_words

__all__ = [
    "controls_inside_solids",
    "enclosure_warnings",
    "lost_seats",
    "result_warnings",
    "seat_verdicts",
    "seat_warnings",
]

SEAT_TOLERANCE = 0.01
SEAT_LOST = 0.05
"""How far [m] the real sinking into a seat may be from the stated depth before it is reported, and
before it fails."""
DRIVER_TOLERANCE = 0.1
"""The same before it is reported of a driver, who sits by the hip point and whose back has an angle of
its own."""


def result_warnings(
    environment: Environment,
    cases: tuple[str, ...],
    people: tuple[PersonFound, ...],
    lost: Container[str],
) -> list[str]:
    """Sentences, person by person. lost: seats that are known to be elsewhere: where their sitters
    rest and have their feet says no more."""
    found: list[str] = []
    ground = ground_of(environment)
    for person in people:
        found += _breached(cases, person)
        found += _bodies_inside_solids(environment, cases, person)
        found += _bounded(environment, cases, person)
        found += enclosure_warnings(person.name, person.placed, environment, cases)
        if person.role.seat is not None and person.role.seat not in lost:
            found += seat_warnings(environment, cases, person)
            found += _under_floor(environment, person, cases, ground)
    return found


def lost_seats(environment: Environment, roles: Iterable[Role]) -> dict[str, Doubt]:
    """Return by seat that some roles sit in what is doubted of where it is, where anything is.

    Whoever sits there is not on the cushion, and what else is found of them follows from that. What
    the environment accepts is no doubt. environment: as its file has it.
    """
    found: dict[str, Doubt] = {}
    for name in {role.seat: None for role in roles if role.seat is not None}:
        seat = environment.seat(name)
        faces = [
            environment.triangle_corners(environment.part_index(rest.part))
            if rest.part
            else np.empty((0, 3, 3))
            for rest in (seat.cushion, seat.back)
        ]
        for doubt in rest_doubts(seat, *faces):
            about = doubt.about in (place_of(name), f"cushion of seat {name}")
            if about and doubt.said in environment.warnings:
                found.setdefault(name, doubt)
    return found


def seat_warnings(
    environment: Environment, cases: tuple[str, ...], person: PersonFound
) -> Iterator[str]:
    """A sentence for the cushion and for the back of a sitter's seat whose plane is not where the
    part is; nothing of who stands."""
    if person.role.seat is None:
        return
    most = DRIVER_TOLERANCE if "driver" in person.postures else SEAT_TOLERANCE
    seat = environment.seat(person.role.seat)
    rests = _rests(seat)
    said = [line for rest in rests for line in _missed(environment, person, rest, cases, most)]
    yield from said[:1] if seat.cushion.part == seat.back.part else said


def _under_floor(
    environment: Environment, person: PersonFound, cases: tuple[str, ...], ground: Ground
) -> list[str]:
    """What is wrong where the feet of a sitter are through the floor, deeper than any rule allows,
    in the case where they are deepest."""
    assert person.role.seat is not None
    rest = environment.seat(person.role.seat)
    x, y, z = (np.array(rest.srp) + seat_shift(rest, person.forward, person.up)).tolist()
    own = replace(rest, srp=(x, y, z))
    feet_controls = [one for one in environment.controls if one.for_feet]
    pedals = [one.name for one in feet_controls]
    no_floor = [one.part for one in feet_controls]
    worst: tuple[str, FeetOnFloor] | None = None
    for pose, case in enumerate(cases):
        feet = feet_on_floor(person.placed, pose, own, ground, without=no_floor)
        if feet is None or feet.above >= -_allowed(environment, feet.part):
            continue
        if worst is None or feet.above < worst[1].above:
            worst = case, feet
    if worst is None or worst[1].above > 0.0:
        return []
    return feet_words(f"{person.name}, {worst[0]}", worst[1], pedals)


def _allowed(environment: Environment, part: str) -> float:
    """How deep [m] feet may be in a part."""
    row = environment.part_index(part)
    depths = [
        rule.depth
        for rule in environment.allowances
        if rule.part == row and {"LF", "RF", "all"} & set(rule.segments)
    ]
    return max(depths, default=0.0)


def _breached(cases: tuple[str, ...], person: PersonFound) -> Iterator[str]:
    for case, joint in np.argwhere(person.margin < -1e-9):
        yield (
            f"{person.name}, {cases[case]}: {person.placed.body.joint_names[joint]} is "
            f"{tenths(-float(np.degrees(person.margin[case, joint])))} degrees past its stop in "
            f"{motion_words(person.margin_motion[case][joint])}"
        )


def _bodies_inside_solids(
    environment: Environment, cases: tuple[str, ...], person: PersonFound
) -> Iterator[str]:
    body = person.placed.body
    with_spheres = np.diff(body.start) > 0
    radius = body.radius[0][person.clearance.sphere[:, with_spheres]]
    inside = person.clearance.distance[:, with_spheres] < -radius
    for case, part in np.argwhere(np.all(inside, axis=1)):
        yield (
            f"{person.name}, {cases[case]}: the whole body is inside the solid part "
            f"{environment.parts[part]!r}; if that part is a shell around people, say 'solid: false' for it"
        )


def _bounded(
    environment: Environment, cases: tuple[str, ...], person: PersonFound
) -> Iterator[str]:
    """A sentence for each part whose depths are lower bounds, where somebody is deepest in it."""
    clearance = person.clearance
    for part in environment.tangled:
        case, segment = np.unravel_index(
            clearance.distance[:, :, part].argmin(), clearance.distance.shape[:2]
        )
        where = (int(case), int(segment), part)
        depth = -float(clearance.distance[where])
        if depth > 0:
            yield (
                f"{person.name}, {cases[case]}: {clearance.name(where)} is at least "
                f"{1000 * depth:.1f} mm deep in {environment.parts[part]!r}: a lower bound, since the "
                "part crosses itself and faces inside it count; mend its mesh before its depths are "
                "relied on"
            )


def enclosure_warnings(
    name: str, placed: Placed, environment: Environment, cases: Sequence[str] = ()
) -> Iterator[str]:
    """A sentence for each visible part that is open, not declared to be no solid, and encloses a
    body in some pose.

    cases: the names of the poses, where they have any.
    """
    around: dict[str, list[str]] = {}
    for part in environment.undecided:
        if environment.hidden[part]:
            continue
        within = np.flatnonzero(enclosed(placed, environment, part) > 0.5)
        if not len(within):
            continue
        where = f", {cases[int(within[0])]}" if cases else ""
        where += f" and {len(within) - 1} more" if cases and len(within) > 1 else ""
        around.setdefault(where, []).append(repr(environment.parts[part]))
    for where, parts in around.items():
        named = f"part{'s' * (len(parts) > 1)} {' and '.join(parts)}"
        yield (
            f"{name}{where}: the body is enclosed by the open {named}: that is right of a shell around people "
            f"('solid: false' says that it is one), and of a solid the mesh is to be mended"
        )


def _missed(
    environment: Environment, person: PersonFound, rest: _Rest, cases: tuple[str, ...], most: float
) -> Iterator[str]:
    """The seat's planes say where a sitter rests; the part itself may be elsewhere. most: how far
    [m] the sinking may be from what is stated."""
    surface = rest.surface
    touched = _touched(environment, person, rest)
    worst = max(touched, key=lambda one: abs(one.gap + surface.depth), default=None)
    if worst is None or abs(worst.gap + surface.depth) <= most:
        return
    clearance = person.clearance
    case = worst.where[0]
    named = clearance.name(worst.where)
    x, y, z = (1000 * value for value in clearance.point[worst.where])
    gap = worst.gap
    where = f"{1000 * gap:.0f} mm clear of" if gap > 0 else f"{-1000 * gap:.0f} mm deep in"
    yield (
        f"{person.name}, {cases[case]}: {named} is "
        f"{where} {surface.part!r}, the {rest.words}, at ({x:.0f}, {y:.0f}, {z:.0f}) mm, where {1000 * surface.depth:.0f} mm deep was stated: are the "
        f"seat reference point and the seat's angles right?"
    )


def seat_verdicts(
    environment: Environment, cases: tuple[str, ...], people: tuple[PersonFound, ...]
) -> list[Verdict]:
    """A failed verdict where somebody is not on his seat at all; nothing where everybody is.

    Whoever floats or is buried has clearances that mean nothing, whatever the study asks.
    """
    lost = []
    for person in people:
        if person.role.seat is None:
            continue
        rest = _rests(environment.seat(person.role.seat))[0]
        stated = -rest.surface.depth
        for one in _touched(environment, person, rest):
            if abs(one.gap - stated) > SEAT_LOST:
                polygon, _ = person.clearance.met(one.where)
                lost.append(
                    Finding(
                        case=cases[one.where[0]],
                        person=person.name,
                        other_person="",
                        subject=person.clearance.name(one.where),
                        target=person.clearance.other_name(one.where),
                        value=one.gap,
                        limit=stated,
                        sphere=int(person.clearance.sphere[one.where]),
                        polygon=polygon,
                    )
                )
    if not lost:
        return []
    everyone = tuple(person.name for person in people)
    criterion = Criterion("everybody is on his seat", "seated", everyone, (), (), 0.0)
    lost.sort(key=lambda finding: -abs(finding.margin))
    return [Verdict(criterion, False, lost[0], tuple(lost))]


@dataclass(frozen=True, eq=False)
class _Rest:
    """The cushion or the back of a seat.

    Parameters
    ----------
    surface, words
        What it is, and what it is called.
    normal, other
        (3,) unit normals of its plane, and of the other one's where both are the same part; None
        where they are two.
    """

    surface: Rest
    words: str
    normal: Floats
    other: Floats | None


def _rests(seat: Seat) -> tuple[_Rest, _Rest]:
    """The cushion and the back of a seat."""
    cushion, back, _ = seat_planes(seat)
    same = seat.cushion.part == seat.back.part
    return (
        _Rest(seat.cushion, f"cushion of seat {seat.name!r}", cushion, back if same else None),
        _Rest(seat.back, f"back of seat {seat.name!r}", back, cushion if same else None),
    )


@dataclass(frozen=True)
class _Touched:
    """Where a sitter is nearest to a part that is rested on: the distance [m], and the place in the
    clearances: case, segment, part."""

    gap: float
    where: tuple[int, int, int]


def _touched(environment: Environment, person: PersonFound, rest: _Rest) -> list[_Touched]:
    """Where whoever rests there is nearest to the real part, case by case; nothing where the part is
    not to be seen.

    A seat that is one part is touched by cushion and back; of these the polygons count that face
    more as the surface does.
    """
    surface = rest.surface
    body = person.placed.body
    names = body.segments if "all" in surface.segments else surface.segments
    rows = [body.segments.index(name) for name in names if name in body.segments]
    if (
        surface.part not in environment.parts
        or environment.hidden[environment.part_index(surface.part)]
    ):
        return []
    part = environment.part_index(surface.part)
    found = []
    for case in range(len(person.placed)):
        near = [row for row in rows if np.isfinite(person.clearance.distance[case, row, part])]
        facing = [row for row in near if _faces(environment, person, rest, (case, row, part))]
        of = facing or near
        if of:
            gaps = person.clearance.distance[case, of, part]
            nearest = int(np.argmin(gaps))
            found.append(_Touched(float(gaps[nearest]), (case, of[nearest], part)))
    return found


def _faces(
    environment: Environment, person: PersonFound, rest: _Rest, where: tuple[int, int, int]
) -> bool:
    """Whether the nearest polygon of the part faces as this surface does rather than as the other."""
    if rest.other is None:
        return True
    normal = environment.normal[person.clearance.target[where]]
    return bool(normal @ rest.normal >= normal @ rest.other)


def controls_inside_solids(environment: Environment) -> list[str]:
    """In words, the controls whose point is inside a solid part that is not their own."""
    solids = np.flatnonzero(environment.solid & ~environment.hidden).tolist()
    shells = {environment.parts[k]: environment.triangle_corners(k) for k in solids}
    notes = []
    for control in environment.controls:
        for name, corners in shells.items():
            if name in control.own_parts:
                continue
            if abs(winding_number(*control.at, corners, 0, len(corners))) > 0.5:
                notes.append(
                    f"control {control.name!r} is inside the solid part {name!r}: "
                    f"a hand gets there as deep as the part allows; check where it is"
                )
    return notes
