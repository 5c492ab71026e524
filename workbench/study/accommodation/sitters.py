"""People in their places: each in the seat where view and pedals are had, then hand by hand.

The order is that of Zehner and Kennedy's cockpit assessments: the lowest seat that still gives the
view, the pedals, then the hands on the controls that they hold, in the tightest harness zone that
will do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.body.forward import place
from workbench.model.accommodation import AccommodationStudy
from workbench.model.arrays import Ints
from workbench.model.body import Body, stack_bodies
from workbench.model.environment import Control, Environment
from workbench.model.poses import Poses
from workbench.model.posing import join_poses
from workbench.posture.reaching.limbs import FEET, HANDS, limb
from workbench.posture.reaching.reach import reach
from workbench.posture.seating.driving import driving_posture
from workbench.posture.seating.posture import Pedals
from workbench.posture.seating.seat import Seated, join_seated, seat
from workbench.study.accommodation.drivers import drivers_among, feet_of, package_of

__all__ = [
    "SEAT_BACK",
    "SEAT_FORWARD",
    "Sitters",
    "join_sitters",
    "seated",
    "seated_at",
    "seating_study",
    "with_hands",
    "without_seat",
]

SEAT_BACK = "the seat stops too far back"
SEAT_FORWARD = "the seat stops too far forward"


@dataclass(frozen=True, eq=False)
class Sitters:
    """B people seated for a study, rows of a body: where the seat is, poses with the hands at rest
    and with hands on their controls."""

    body: Body
    seat: Seated
    held: Poses

    def rows(self, keep: Ints) -> Sitters:
        """The people at indices, in their order."""
        return Sitters(self.body[keep], self.seat.rows(keep), self.held.rows(keep))


def join_sitters(parts: Sequence[Sitters]) -> Sitters:
    """The rows of several parts, in their order."""
    return Sitters(
        stack_bodies([part.body for part in parts]),
        join_seated([part.seat for part in parts]),
        join_poses([part.held for part in parts]),
    )


def seated(study: AccommodationStudy, body: Body, rows: Sequence[int]) -> Sitters:
    """The B rows of a body, these rows of the study's people, in the seat, feet on the pedals, arms as in the
    posture they sit like."""
    study = seating_study(study)
    environment = study.environment
    aims = study.aims
    controls = {control.name: control for control in environment.controls}
    at = {foot: controls[name].at for foot, name in aims.controls.items() if foot in FEET}
    pedals = Pedals(at, environment.points[aims.heels][2] if aims.heels else None)
    eye = environment.points[aims.eyes][2] if aims.eyes else None
    assert study.pose is not None
    lap = body.segment("LT")
    world = place(body[0], study.pose).world_from_segment[:, lap]
    poses = Poses(
        np.repeat(study.pose.rotations, len(body), axis=0),
        lap,
        np.repeat(world, len(body), axis=0),
    )
    own_seat = environment.seat(study.seat)
    driving = aims.driving
    if driving is None:
        found = seat(body, poses, own_seat, eye=eye, pedals=pedals)
    else:
        found = driving_posture(
            body,
            poses,
            own_seat,
            drivers=drivers_among(study.people, rows, body, driving.age),
            seed=driving.seed,
            package=package_of(aims, environment),
            feet=feet_of(aims, environment),
            eye=eye,
            numbers=list(rows),
        )
    return Sitters(body, found, found.poses)


def seated_at(
    study: AccommodationStudy, body: Body, rows: Sequence[int], position: tuple[float, float]
) -> Sitters:
    """The same with the seat in one position for everybody, forward and up [m]."""
    environment = study.environment
    held = environment.with_seat(environment.seat(study.seat).held(*position))
    return seated(replace(study, environment=held), body, rows)


def seating_study(study: AccommodationStudy) -> AccommodationStudy:
    """The part of a study that decides where people sit: the seat, pedals and points, the people
    and their posture.

    People are seated with this study alone, so what is left out cannot move them: parts and their
    polygons, controls of the hands, criteria and words.
    """
    room = study.environment
    aims = study.aims
    feet = {foot: name for foot, name in aims.controls.items() if foot in FEET}
    nothing = np.zeros((0, 3))
    whole = np.zeros(0, dtype=np.int64)
    empty = Environment(
        name=room.name,
        description="",
        parts=(),
        part_start=np.zeros(1, dtype=np.int64),
        vertices=nothing,
        edges=whole.reshape(0, 2),
        edge_start=np.zeros(1, dtype=np.int64),
        normal=nothing,
        offset=np.zeros(0),
        circle_centre=nothing,
        circle_radius=np.zeros(0),
        triangles=whole.reshape(0, 3),
        triangle_start=np.zeros(1, dtype=np.int64),
        solid=np.zeros(0, dtype=np.bool_),
        hidden=np.zeros(0, dtype=np.bool_),
        see_through=np.zeros(0, dtype=np.bool_),
        seats=(room.seat(study.seat),),
        points=room.points,
        controls=tuple(control for control in room.controls if control.name in feet.values()),
    )
    return replace(
        study,
        title="",
        description="",
        environment=empty,
        aims=replace(aims, controls=feet),
        criteria=(),
        mixes={},
        maps=(),
        inputs={},
        warnings=(),
        changes=(),
    )


def with_hands(study: AccommodationStudy, sitters: Sitters) -> Sitters:
    """The hands on the controls that they hold, each in the tightest harness zone that will do."""
    controls = {control.name: control for control in study.environment.controls}
    poses = sitters.held
    for hand, name in study.aims.controls.items():
        if hand in HANDS:
            poses = _hand(study, Sitters(sitters.body, sitters.seat, poses), hand, controls[name])
    return Sitters(sitters.body, sitters.seat, poses)


def _hand(study: AccommodationStudy, sitters: Sitters, name: str, control: Control) -> Poses:
    """The postures with one hand on its control, in the tightest harness zone that will do."""
    body = sitters.body
    held = sitters.held
    rotations = held.rotations.copy()
    left = np.arange(len(body))
    for zone in range(1, control.zone + 1):
        found = reach(
            body,
            Poses(
                held.rotations[left], held.reference, held.world_from_reference[left], None, left
            ),
            [control.at],
            limb=limb(body, name, grip=control.grip, zone=zone),
            environment=study.environment,
            moving_parts=study.environment.seat(study.seat).moves,
            displacement=sitters.seat.shift[left],
        )
        rotations[left] = found.poses.rotations
        left = left[~found.reached[:, 0]]
        if not len(left):
            break
    return Poses(rotations, held.reference, held.world_from_reference)


def without_seat(environment: Environment, seat: str) -> Environment:
    """The environment without the sitters' own seat: a thigh presses the cushion down, it does not
    stop there."""
    gone = np.isin(environment.parts, environment.seat(seat).moves)
    return replace(environment, hidden=environment.hidden | gone)
