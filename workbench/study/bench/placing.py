"""Where the people of a state are in the case that is looked at, and what they see from there.

While something is dragged, nobody takes another place to see it. The verdicts are those of a run
where everybody stays: the same functions find and judge them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike

from workbench.body.forward import place
from workbench.errors import InputError
from workbench.model.accommodation import OF_RULES, OF_SIGHT
from workbench.model.arrays import Floats, xyz
from workbench.model.body import Body
from workbench.model.bystander import Bystander
from workbench.model.environment import Control, Environment, Seat
from workbench.model.poses import Placed, Poses
from workbench.model.quaternions import exponential, from_matrices, matrices
from workbench.model.result import Shortfall, Verdict
from workbench.model.study import GivenPosture
from workbench.model.surroundings import Surroundings, moved_along
from workbench.posture.seating.seating import seat_shift
from workbench.sight.eyes import TURNS, Gaze, eyes_of, gaze, head_of
from workbench.sight.obscuration import Obscuration, obscuration
from workbench.sight.regions import Region
from workbench.sight.scenery import Scenery
from workbench.study.bench.state import (
    Arrangement,
    OpenStudy,
    PersonState,
    Settings,
    arranged_environment,
    arranged_parts,
    arranged_study,
)
from workbench.study.hands import hands_together
from workbench.study.people import Present, among_others, present_people, verdicts_of
from workbench.study.seat_words import shortfalls
from workbench.study.situation import (
    Seating,
    Situation,
    moved_by,
    situated,
    solid_to_others,
    take_places,
)
from workbench.study.workplaces import workplace_of

__all__ = [
    "FieldOfView",
    "PlacedPerson",
    "Placement",
    "controls_there",
    "field_of",
    "people_here",
    "placed_environment",
    "placed_people",
    "placed_person",
    "sight_verdicts",
]


@dataclass(frozen=True, eq=False)
class PlacedPerson:
    """One person where he or she is.

    Parameters
    ----------
    state
        The person's state that this is of.
    body
        One row.
    poses
        (1,) in the world.
    forward, up
        [m] where the seat stands.
    shift
        (3,) [m] by how much the parts that move with the seat are displaced.
    settings
        Where the person has set what may be adjusted and the state does not say.
    resting
        The person with the hands at rest, where they are brought to controls.
    held
        The person with the hands on the controls, where these are brought there.
    """

    state: PersonState
    case: int
    body: Body
    poses: Poses
    forward: float
    up: float
    shift: Floats
    settings: Settings = ()
    resting: Situation | None = None
    held: Situation | None = None

    @cached_property
    def shortfalls(self) -> tuple[Shortfall, ...]:
        """What seat, feet and hands miss of what a prediction asks of them."""
        return () if self.held is None else tuple(shortfalls(self.held))

    @cached_property
    def placed(self) -> Placed:
        """The body in the world."""
        return place(self.body, self.poses)

    @cached_property
    def bystander(self) -> Bystander:
        """The person as hands of others keep clear of the person."""
        solid = np.ones(len(self.body.sphere_names), dtype=np.bool_)
        if self.resting is not None:
            solid = solid_to_others(self.resting, hands_on=True)
        return Bystander(self.state.role, self.placed, solid)


@dataclass(frozen=True, eq=False, repr=False)
class Placement:
    """A state, its people where they are in its case, the environment with their seats there, and
    where adjustments are set in it, by the study or by its people."""

    arrangement: Arrangement
    people: tuple[PlacedPerson, ...]
    parts: Surroundings
    settings: Settings = ()

    def __repr__(self) -> str:
        return f"Placement({self.arrangement!r})"


def placed_people(
    opened: OpenStudy,
    arrangement: Arrangement,
    *,
    there: Present | None = None,
    before: Placement | None = None,
) -> Placement:
    """Put the people of a state where they are.

    Parameters
    ----------
    there
        Where people with a free seat have gone; looked for where None is given, which may take
        seconds.
    before
        A placement of another state: who is the same there is not placed again.
    """
    people: list[PlacedPerson] = []
    if there is None and any(person.free for person in arrangement.people):
        there = present_people(arranged_study(opened, arrangement), arrangement.occupants)
    for row, person in enumerate(arrangement.people):
        known = before.people[row] if before is not None else None
        free = there.situations[row][arrangement.case] if there is not None else None
        same = known is not None and known.state is person and known.case == arrangement.case
        if known is not None and person.free:
            same = same and free is not None and known.resting is free.at_rest
        elif before is not None and _surroundings_moved(before.arrangement, arrangement, row):
            action = person.actions[arrangement.case]
            same = same and isinstance(action, GivenPosture) and not action.hands
        if same and known is not None:
            people.append(known)
        elif person.free and free is not None:
            people.append(_of_situation(person, free, free.at_rest))
        else:
            people.append(_placed(opened, arrangement, row, people, known))
    if before is None or any(
        now is not known for now, known in zip(people, before.people, strict=True)
    ):
        people = _with_hands_on(people, before)
    shifts = np.array([person.shift for person in people]).reshape(-1, 3)
    settings = dict(arrangement.settings)
    for there_is in people:
        settings |= dict(there_is.settings)
    set_so = tuple(sorted(settings.items()))
    parts = arranged_parts(opened, arrangement.moves, shifts, set_so)
    return Placement(arrangement, tuple(people), parts, set_so)


def placed_person(opened: OpenStudy, arrangement: Arrangement, row: int) -> PlacedPerson:
    """Put one person of a state, whose seat is held or who has none, where he or she is."""
    return _placed(opened, arrangement, row, (), None)


def placed_environment(opened: OpenStudy, placement: Placement) -> Environment:
    """Build the environment of a placement with parts, controls and adjustments where they are, and
    the seats at rest."""
    return arranged_environment(opened, replace(placement.arrangement, settings=placement.settings))


def _surroundings_moved(one: Arrangement, other: Arrangement, row: int) -> bool:
    """Whether controls, points, parts or the seats of others may stand elsewhere for a person."""
    if (one.moves, one.settings) != (other.moves, other.settings):
        return True
    pairs = zip(one.people, other.people, strict=True)
    seats = [(a.forward, a.up, a.free) == (b.forward, b.up, b.free) for a, b in pairs]
    return not all(seats[:row] + seats[row + 1 :])


def _with_hands_on(people: Sequence[PlacedPerson], before: Placement | None) -> list[PlacedPerson]:
    """People with the hands on the controls that a prediction holds, clear of one another; who is
    then as in another placement is the same object."""
    rows = [row for row, person in enumerate(people) if person.resting is not None]
    standing = [person.bystander for person in people if person.resting is None]
    resting = [one for person in people if (one := person.resting) is not None]
    found = list(people)
    for row, situation in zip(rows, hands_together(resting, standing), strict=True):
        person = people[row]
        now = _of_situation(person.state, situation, person.resting)
        known = before.people[row] if before is not None else None
        found[row] = known if known is not None and _as_known(now, known) else now
    return found


def _as_known(now: PlacedPerson, known: PlacedPerson) -> bool:
    """Whether a person is in the same state at the same place as in another placement."""
    return (
        now.state is known.state
        and now.resting is known.resting
        and np.array_equal(now.poses.rotations, known.poses.rotations)
        and np.array_equal(now.poses.world_from_reference, known.poses.world_from_reference)
    )


def _placed(
    opened: OpenStudy,
    arrangement: Arrangement,
    row: int,
    before: Sequence[PlacedPerson],
    known: PlacedPerson | None,
) -> PlacedPerson:
    """A person whose seat is held, or who has none.

    Parameters
    ----------
    before
        The people who are placed already.
    known
        The same person in another state, None where there is none.
    """
    person = arrangement.people[row]
    action = person.actions[arrangement.case]
    if not isinstance(action, GivenPosture) or action.hands:
        resting = _predicted(opened, arrangement, row, before)
        return _of_situation(person, resting, resting)
    role = opened.study.roles[row]
    seat = opened.seat(row)
    if known is not None and seat is not None and _rests_alike(seat, known, person, action.poses):
        world = known.poses.world_from_reference
        poses = Poses(action.poses.rotations, known.poses.reference, world)
        return replace(known, state=person, case=arrangement.case, poses=poses)
    held = None if seat is None else seat.held(person.forward, person.up)
    who = person.figure.who
    taken = take_places(Seating(held, role.stand, action.poses), who)
    shift = np.zeros(3) if taken.seated is None else taken.seated.shift[0]
    return PlacedPerson(
        state=person,
        case=arrangement.case,
        body=who.body,
        poses=taken.poses,
        forward=person.forward,
        up=person.up,
        shift=shift,
    )


def _rests_alike(seat: Seat, known: PlacedPerson, person: PersonState, poses: Poses) -> bool:
    """Whether a person rests in the seat as before: only joints are turned otherwise that move
    nothing of what rests there."""
    if (person.forward, person.up) != (known.forward, known.up):
        return False
    if known.body is not person.figure.body:
        return False
    old = known.state.actions[known.case]
    if not isinstance(old, GivenPosture) or poses.reference != old.poses.reference:
        return False
    if old.hands:
        return False
    body = known.body
    turned = np.any(poses.rotations[0] != old.poses.rotations[0], axis=1)
    names = {*seat.cushion.segments, *seat.back.segments, body.segments[poses.reference]}
    rests = np.isin(body.segments, list(names)) | ("all" in names)
    return not np.any(moved_by(body, turned) & rests[body.sphere_segment])


def _predicted(
    opened: OpenStudy, arrangement: Arrangement, row: int, before: Sequence[PlacedPerson]
) -> Situation:
    """A person whose posture is predicted, or whose hands hold controls, in a seat that is held,
    with the hands at rest; they will keep clear of the seats of others."""
    study = arranged_study(opened, arrangement)
    place_there = workplace_of(study, row, _surroundings(opened, arrangement, row, before))
    who = arrangement.people[row].figure.who
    return situated(place_there, arrangement.case, who)


def _surroundings(
    opened: OpenStudy, arrangement: Arrangement, row: int, before: Sequence[PlacedPerson]
) -> Environment:
    """The environment of a state with the seats of others where they have put them, of those after
    a person where these are held."""
    environment = arranged_environment(opened, arrangement)
    for other, person in enumerate(arrangement.people):
        if other < len(before):
            shift = before[other].shift
        elif other != row and not person.free:
            shift = seat_shift(opened.seat(other), person.forward, person.up)
        else:
            continue
        if shift.any():
            parts = [environment.parts[k] for k in opened.movers[other]]
            environment = moved_along(environment, parts, shift)
    return environment


def controls_there(
    opened: OpenStudy, environment: Environment, row: int, shift: Floats
) -> tuple[Control, ...]:
    """The controls of an environment, those that go with the seat of a person displaced by (3,) [m]."""
    along = {environment.parts[k] for k in opened.movers[row]}
    return tuple(
        replace(one, at=xyz(one.at + shift)) if one.part in along else one
        for one in environment.controls
    )


def _of_situation(
    person: PersonState, situation: Situation, resting: Situation | None
) -> PlacedPerson:
    """A person as a situation has the person."""
    seated = situation.seated
    place_there = situation.place
    settings = tuple(
        (one, place_there.environment.adjustment(one).at) for one in place_there.adjusts
    )
    return PlacedPerson(
        state=person,
        case=situation.case,
        body=situation.body,
        poses=replace(situation.poses, person=None),
        forward=person.forward if seated is None else float(seated.forward[0]),
        up=person.up if seated is None else float(seated.up[0]),
        shift=np.zeros(3) if seated is None else seated.shift[0],
        settings=settings,
        resting=resting,
        held=situation,
    )


_TRUNK = "UT"
"""The segment that turns with the trunk, and bears arms and head."""
_HEAD_TURNED = replace(TURNS, head_side=0.0, head_up=0.0, head_down=0.0)
"""How far eyes turn whose head has turned already."""
_FAR = 1000.0
"""Distance [m] of what somebody looks at who looks in a direction."""


def people_here(opened: OpenStudy, placement: Placement) -> Present:
    """The people of a placement in the case that is looked at, as a run has them who sit so."""
    arrangement = replace(placement.arrangement, settings=placement.settings)
    study = arranged_study(opened, arrangement)
    environment = study.environment
    found = []
    for row, person in enumerate(placement.people):
        one = person.held
        if one is None:
            place = workplace_of(study, row, study.environment)
            one = situated(place, person.case, person.state.figure.who)
        found.append(one)
        if person.shift.any():
            parts = [environment.parts[k] for k in opened.movers[row]]
            environment = moved_along(environment, parts, person.shift)
    mine = tuple((one.seat_moved(environment),) for one in found)
    return Present(environment, study.roles, mine, ())


def sight_verdicts(opened: OpenStudy, arrangement: Arrangement, here: Present) -> Iterator[Verdict]:
    """Judge the criteria of sight in the case that is looked at, those of a rule last: these cost
    the most.

    Parameters
    ----------
    here
        Of `people_here`.
    """
    criteria = [one for one in opened.study.criteria if one.check in OF_SIGHT]
    criteria.sort(key=lambda one: one.check in OF_RULES)
    yield from verdicts_of(criteria, here, (), (opened.cases[arrangement.case],))


@dataclass(frozen=True, eq=False)
class FieldOfView:
    """What stands before the eyes of somebody who looks in a direction.

    Parameters
    ----------
    placed
        The person with trunk and head turned.
    scenery
        What may hide something.
    gaze
        The eyes where they are, one row, and by how much they and the head have turned.
    hidden
        What each item hides within an angle of the direction.
    """

    placed: Placed
    scenery: Scenery
    gaze: Gaze
    hidden: Obscuration


def field_of(
    opened: OpenStudy,
    placement: Placement,
    row: int,
    toward: ArrayLike,
    *,
    within: float,
    step: float,
) -> FieldOfView:
    """Turn the eyes and the head of somebody, and measure what hides the field.

    The eyes turn first, then the head with what is worn on it, then the trunk with all that it bears,
    as far as a criterion of the person lets it, as `gaze` has it.

    Parameters
    ----------
    row
        Of the person in the placement.
    toward
        (3,) the direction in which the person looks.
    within
        [rad] from it the field goes.
    step
        As of `obscuration`.

    Raises
    ------
    InputError
        If the person has no eyes, or an eye is inside something, or the direction is none.
    """
    way = np.asarray(toward, dtype=np.float64)
    length = float(np.linalg.norm(way))
    if not math.isfinite(length) or length == 0.0:
        raise InputError("a direction to look in is three numbers that are not all 0")
    situation = _seeing(opened, placement)[row]
    asked = [one.trunk for one in opened.study.criteria if situation.place.role in one.people]
    target = eyes_of(situation.placed).middle + _FAR / length * way
    turned, looks = _turned_to(situation, target, max(asked, default=0.0))
    ahead = way / length
    left = looks.eyes.axes[0, 1]
    if abs(left @ ahead) > 0.9:  # far beyond the turn of the head
        left = np.cross(looks.eyes.axes[0, 2], ahead)
    left = left - (left @ ahead) * ahead
    left /= np.linalg.norm(left)
    region = Region("field", np.stack([ahead, left, np.cross(ahead, left)]), within)
    hidden = obscuration(turned.scenery, looks.eyes, within=region, step=step)
    return FieldOfView(turned.placed, turned.scenery, looks, hidden)


def _turned_to(situation: Situation, target: Floats, trunk: float) -> tuple[Situation, Gaze]:
    """Turn a person to a target (1, 3) [m]: the posture with trunk and head turned, and how the eyes
    look from there; trunk: how far [rad] it may turn."""
    body = situation.body
    head = head_of(body)
    looks = gaze(eyes_of(situation.placed), target, trunk=trunk)
    if not head:
        return situation, looks  # nothing bears the head
    aside = looks.trunk_turn
    if aside.any() and _TRUNK in body.segments:
        up = eyes_of(situation.placed).axes[0, 2]
        situation = _with_turn(situation, body.segment(_TRUNK), aside[0] * up)
        looks = gaze(eyes_of(situation.placed), target)
    _, left, up = eyes_of(situation.placed).axes[0]
    to_left, upward = looks.head_turn[0].tolist()
    situation = _with_turn(situation, head, to_left * up - upward * left)
    rest = gaze(eyes_of(situation.placed), target, _HEAD_TURNED)
    return situation, replace(rest, head_turn=looks.head_turn, trunk_turn=aside)


def _with_turn(situation: Situation, segment: int, turn: Floats) -> Situation:
    """A person with a segment, and all that it bears, turned about its joint by a rotation vector (3,)
    [rad] in the world."""
    world = situation.placed.world_from_segment[:, :, :, :3]
    parent = world[0, situation.body.parent[segment]]
    rotations = situation.poses.rotations.copy()
    turned = parent.T @ matrices(exponential(turn)) @ world[0, segment]
    rotations[0, segment - 1] = from_matrices(turned)
    poses = Poses(rotations, 0, situation.placed.world_from_segment[:, 0])
    return replace(situation, poses=poses)


@lru_cache(maxsize=2)
def _seeing(opened: OpenStudy, placement: Placement) -> list[Situation]:
    """The people of a placement with the others before them: what stands there is collected once for
    all directions."""
    return among_others(people_here(opened, placement))
