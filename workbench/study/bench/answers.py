"""What a state of an open study comes to: at once what is nearest to what, and the verdicts.

The verdicts are those of a run: the same functions find and judge them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from workbench.contact.clearance_pairs import FrameRooms, room_of_segments, rooms_by_mover
from workbench.contact.collide import body_clearance, self_clearance
from workbench.contact.kernels.search import Nearest
from workbench.model.arrays import Floats
from workbench.model.contacts import Clearance
from workbench.model.result import PosturesFound
from workbench.posture.reaching.limbs import FEET, HANDS, limb
from workbench.posture.stops import stop_limits
from workbench.study.bench.near import (
    MOST_NEAR,
    NearPair,
    Someone,
    Tolerances,
    own_pair,
    part_pairs,
    people_pair,
)
from workbench.study.bench.placing import PlacedPerson, Placement
from workbench.study.bench.state import Arrangement, OpenStudy, arranged_study, given_angles
from workbench.study.people import Present, people_found, present_people

__all__ = ["TOUCHES", "Answer", "BenchEvaluation", "PersonAnswer", "answer", "judged", "near_pairs"]

TOUCHES = 1e-6
"""[m] Spheres that overlap by less only touch."""


@dataclass(frozen=True, eq=False)
class PersonAnswer:
    """What is found of one person.

    Parameters
    ----------
    person
        Where the person is.
    rooms, near
        What comes nearest to each segment: mover by mover, and (1, N) of all parts.
    own
        (1, N, N) the nearest pairs of segments of the same body.
    angles
        (J, 3) [rad].
    limits
        (J, 3, 2) [rad] how far each angle may go up and down.
    tips
        (3,) [m] by limb, the points that arrive.
    """

    person: PlacedPerson
    rooms: FrameRooms
    near: Nearest
    own: Clearance
    angles: Floats
    limits: Floats
    tips: dict[str, Floats]


@dataclass(frozen=True, eq=False)
class Answer:
    """What is found of a state: of each person, and between each two of them.

    Parameters
    ----------
    overlaps
        By person, the spheres that are in somebody else.
    tolerances
        What criteria let overlap beyond what parts and flesh allow.
    """

    placement: Placement
    people: tuple[PersonAnswer, ...]
    between: tuple[NearPair, ...]
    overlaps: tuple[frozenset[int], ...]
    tolerances: Tolerances


@dataclass(frozen=True, eq=False)
class BenchEvaluation:
    """What a run finds of a state, and where its people are."""

    arrangement: Arrangement
    there: Present
    found: PosturesFound


def answer(
    placement: Placement, before: Answer | None = None, tolerances: Tolerances | None = None
) -> Answer:
    """Find what is near to what in a placement.

    Parameters
    ----------
    before
        The answer to another state: of who is in the same place, only what has moved is asked again.
    tolerances
        What criteria let overlap beyond what parts and flesh allow; nothing if None.
    """
    tolerances = tolerances or Tolerances()
    people = []
    for row, person in enumerate(placement.people):
        known = before.people[row] if before is not None else None
        same = known is not None and known.person is person
        people.append(_of_person(person, placement, known if same else None))
    overlaps: list[set[int]] = [set() for _ in people]
    between = tuple(_between(placement.people, overlaps, tolerances))
    deep = tuple(map(frozenset, overlaps))
    return Answer(placement, tuple(people), between, deep, tolerances)


def _of_person(
    person: PlacedPerson, placement: Placement, known: PersonAnswer | None
) -> PersonAnswer:
    """What is found of a person; what is `known` of the same person in the same place."""
    rooms = rooms_by_mover(person.placed, placement.parts, known.rooms if known else None)
    if known is not None:
        return replace(known, rooms=rooms, near=room_of_segments(rooms))
    body = person.body
    angles = given_angles(body, person.poses)
    return PersonAnswer(
        person=person,
        rooms=rooms,
        near=room_of_segments(rooms),
        own=self_clearance(person.placed),
        angles=angles,
        limits=stop_limits(body, angles[None])[0],
        tips=_tips(person),
    )


def _tips(person: PlacedPerson) -> dict[str, Floats]:
    """Where the hands and feet of a human body are: the points that arrive by their first grips."""
    found = {}
    names = set(person.body.segments)
    for name in (*HANDS, *FEET):
        side = name[0].upper()
        if {f"{side}HN", f"{side}F", "UT", "LT"} <= names:
            one = limb(person.body, name)
            world = person.placed.world_from_segment[0, one.end]
            found[name] = world[:, :3] @ one.tip[0] + world[:, 3]
    return found


def _between(
    people: Sequence[PlacedPerson], overlaps: Sequence[set[int]], tolerances: Tolerances
) -> Iterator[NearPair]:
    """The nearest segments of each two people; the spheres that overlap are put into the sets of
    their people."""
    for (row, one), (column, other) in combinations(enumerate(people), 2):
        near = body_clearance(one.placed, other.placed)
        distance = np.where(np.isnan(near.distance), np.inf, near.distance)
        deep = distance < -TOUCHES
        overlaps[row].update(near.sphere[deep].tolist())
        overlaps[column].update(near.target[deep].tolist())
        yield people_pair(_someone(one), _someone(other), near, tolerances=tolerances)


def _someone(person: PlacedPerson) -> Someone:
    return Someone(person.state.role, person.body)


def near_pairs(found: Answer, most: int = MOST_NEAR) -> list[NearPair]:
    """The nearest pairs of an answer, the worst first: of each segment and what is nearest to it, of
    each body and itself, and of each two people."""
    rows = list(found.between)
    environment = found.placement.parts.environment
    for one in found.people:
        someone = _someone(one.person)
        tolerances = found.tolerances
        rows += part_pairs(someone, environment, one.near, tolerances=tolerances, most=most)
        rows += own_pair(someone, one.own)
    return sorted(rows, key=lambda pair: pair.room)[:most]


def judged(opened: OpenStudy, arrangement: Arrangement) -> BenchEvaluation:
    """Judge a state as a run of its study does, in all cases."""
    study = arranged_study(opened, arrangement)
    there = present_people(study, arrangement.occupants)
    return BenchEvaluation(arrangement, there, people_found(study, there))
