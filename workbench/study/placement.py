"""People into their places: seats are adjusted with the parts that move along, bodies settle into
them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench.body.forward import place
from workbench.body.parts import moved
from workbench.model.arrays import Floats
from workbench.model.environment import Environment
from workbench.model.poses import Placed, Poses
from workbench.model.posture_study import Person, PostureStudy
from workbench.posture.seating.seat import seat
from workbench.posture.seating.seating import seat_planes

__all__ = ["adjusted_environment", "place_person", "seat_point"]


def adjusted_environment(study: PostureStudy) -> Environment:
    """The environment with every occupied seat where its sitter has put it."""
    environment = study.environment
    for person in study.people:
        if person.seat is not None and (person.forward or person.up):
            seat = environment.seat(person.seat)
            environment = moved(environment, seat.moves, _travel(person, environment))
    return environment


def place_person(person: Person, environment: Environment) -> Placed:
    """The person's body in all cases, in its seat, standing on its point, or where its poses
    say."""
    poses = person.poses
    if person.seat is not None:
        stands = environment.seat(person.seat)
        stands = replace(stands, travel_forward=(person.forward,) * 2, travel_up=(person.up,) * 2)
        sitting = seat(person.body, poses, stands).poses
        if any(person.held):
            held = np.array(person.held)[:, None, None]
            world = np.where(held, poses.world_from_reference, sitting.world_from_reference)
            sitting = Poses(poses.rotations, poses.reference, world)
        poses = sitting
    if person.stand is not None:
        centres = place(person.body, poses).centres
        world = poses.world_from_reference.copy()
        lowest = np.min(centres[:, :, 2] - person.body.radius[0], axis=1)
        world[:, :, 3] += np.array(person.stand) - np.stack(
            [world[:, 0, 3], world[:, 1, 3], lowest], axis=1
        )
        poses = Poses(poses.rotations, poses.reference, world)
    return place(person.body, poses)


def seat_point(person: Person, environment: Environment) -> Floats:
    """(3,) [m] the reference point of the person's seat where the seat stands. InputError for
    somebody without one."""
    point: Floats = np.array(environment.seat(person.seat or "").srp) + _travel(person, environment)
    return point


def _travel(person: Person, environment: Environment) -> Floats:
    """(3,) [m] how far the person's seat stands from its reference position: horizontally ahead,
    and up."""
    centre = seat_planes(environment.seat(person.seat or ""))[2]
    ahead = np.array([centre[1], -centre[0], 0.0])
    travel: Floats = ahead * person.forward + np.array([0.0, 0.0, person.up])
    return travel
