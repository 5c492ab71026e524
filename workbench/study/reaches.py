"""Who reaches which control, in each harness zone, with what to spare or short by how much, and
what limits it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from workbench.geometry.polygon import point_winding
from workbench.model.body import Body
from workbench.model.environment import Control, Environment
from workbench.model.poses import Placed, Poses
from workbench.model.posture_study import Person, PostureStudy
from workbench.model.reach import Reach
from workbench.model.result import ControlReach
from workbench.posture.reaching.limbs import FEET, HANDS, ZONES, limb
from workbench.posture.reaching.reach import reach
from workbench.study.accommodation.sitters import without_seat

__all__ = ["buried_controls", "control_reaches"]


def control_reaches(
    study: PostureStudy, placed: Mapping[str, Placed], environment: Environment
) -> Iterator[ControlReach]:
    """Every control that a criterion of the study is about, for the people and cases it names, from
    the posture of the case, in the zones 1 to 3; by the hand or foot that comes nearest, and of
    those that arrive the more comfortable. What is reached in one zone is reached in the next,
    which leaves the limb free to do the same.

    InputError where a body lacks the landmarks of a grip.
    """
    wanted: dict[tuple[str, int, str], set[str]] = {}
    for criterion in study.criteria:
        if criterion.check == "reach":
            for name in criterion.people:
                for case in range(len(study.cases)):
                    if criterion.asks(study.cases[case]):
                        key = (name, case, criterion.hand or "")
                        wanted.setdefault(key, set()).update(criterion.controls)
    for person in study.people:
        for (name, case, hand), names in wanted.items():
            if name == person.name:
                controls = [c for c in environment.controls if c.name in names]
                yield from _case_reaches(
                    person, placed[name], environment, _Asked(case, hand, controls)
                )


@dataclass(frozen=True)
class _Asked:
    """Controls to be reached from the posture of a case, by one hand or by either ("")."""

    case: int
    hand: str
    controls: list[Control]


def _case_reaches(
    person: Person, shown: Placed, environment: Environment, asked: _Asked
) -> Iterator[ControlReach]:
    """The reaches of one person from one case, by grip."""
    row = slice(asked.case, asked.case + 1)
    poses = Poses(
        person.poses.rotations[row],
        person.poses.reference,
        shown.world_from_segment[row, person.poses.reference],
    )
    for grip in dict.fromkeys(control.grip for control in asked.controls):
        group = [control for control in asked.controls if control.grip == grip]
        room = environment
        if grip == "foot" and person.seat is not None:
            room = without_seat(environment, person.seat)
        tighter: dict[int, tuple[str, Reach]] = {}
        for zone in ZONES:
            found = [
                entry
                for entry in _tried(shown.body, poses, group, (zone, room))
                if not asked.hand or entry[0].startswith(asked.hand)
            ]
            for number, control in enumerate(group):
                limb_name, best = min(found, key=lambda entry: _rank(entry[1], number))
                if number in tighter and not best.reached[0, number]:
                    limb_name, best = tighter[number]  # who may do more can still do that
                if best.reached[0, number]:
                    tighter[number] = (limb_name, best)
                yield ControlReach(
                    person=person.name,
                    control=control.name,
                    zone=zone,
                    own_zone=control.zone,
                    limb=limb_name,
                    reached=bool(best.reached[0, number]),
                    miss=float(best.miss[0, number]),
                    overlap=float(best.overlap[0, number]),
                    limit=best.limit(0, number),
                    discomfort=float(best.discomfort[0, number]),
                    case=asked.case,
                    hand=asked.hand,
                )


def _tried(
    body: Body, poses: Poses, controls: list[Control], how: tuple[int, Environment]
) -> Iterator[tuple[str, Reach]]:
    """The controls by each hand, or each foot."""
    zone, environment = how
    targets = np.array([control.at for control in controls])
    foot = controls[0].grip == "foot"
    for name in FEET if foot else HANDS:
        chain = limb(body, name, grip="ball" if foot else controls[0].grip, zone=zone)
        yield name, reach(body, poses, targets, limb=chain, environment=environment)


def _rank(found: Reach, row: int) -> tuple[bool, float, float]:
    reached = bool(found.reached[0, row])
    return (
        not reached,
        0.0 if reached else float(found.miss[0, row] + found.overlap[0, row]),
        float(found.discomfort[0, row]),
    )


def buried_controls(environment: Environment) -> list[str]:
    """In words, the controls whose point is inside a solid part that is not their own."""
    corners = environment.vertices[environment.triangles]
    told = []
    for control in environment.controls:
        for k in np.flatnonzero(environment.solid & ~environment.hidden):
            if environment.parts[k] == control.part:
                continue
            first, last = (
                int(environment.triangle_start[environment.part_start[k + i]]) for i in (0, 1)
            )
            if abs(point_winding(*control.at, corners, first, last)) > 0.5:
                told.append(
                    f"control {control.name!r} is inside the solid part {environment.parts[k]!r}: "
                    f"a hand gets there as deep as the part allows; check where it is"
                )
    return told
