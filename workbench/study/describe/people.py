"""The person who stands beside a mesh, for scale, and who sits in its seats."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from workbench.body.forward import place
from workbench.body.scaling.scale import scale
from workbench.files.body.bodies import body_path, load_body
from workbench.files.environment_parts import matching_parts
from workbench.files.environment_schema import EnvironmentFile
from workbench.files.environments import seat_of
from workbench.files.postures import load_postures, posture_path, posture_pose
from workbench.geometry.ground import Ground
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.environment import Seat
from workbench.model.poses import Placed, Poses
from workbench.model.units import plain
from workbench.posture.seating.seat import Seated, seat
from workbench.study.feet_on_floor import LEGS, UNDER, feet_on_floor, feet_words

__all__ = [
    "PERSON",
    "SeatedWords",
    "person_words",
    "seated_eye",
    "seated_person",
    "seated_words",
    "standing_man",
    "standing_people",
    "standing_person",
]

PERSON = "adult_male"
ENDS = {"a small woman": ("adult_female", 1.525), "a tall man": ("adult_male", 1.87)}
"""Bodies and statures [m] of a woman at the 5th and a man at the 95th percentile, rounded; ANSUR II."""
ASIDE = 0.6
"""How far [m] beside the mesh the person stands."""
BESIDE = 0.45
"""A pedal farther [m] aside of the middle of a seat is another seat's."""


@cache
def _person() -> Body:
    return load_body(PERSON)


@cache
def _posture(name: str, body: Body | None = None) -> Poses:
    path = posture_path(body_path(PERSON))
    assert path is not None
    who = body or _person()
    return posture_pose(who, load_postures(path, who)[0], name)


def standing_man() -> tuple[Body, Poses]:
    """The person, and how he stands (P = 1)."""
    return _person(), _posture("standing")


@cache
def standing_people() -> dict[str, tuple[Body, Poses]]:
    """By words the person and two others at the ends of what people are, as of `standing_man`."""
    bodies = {
        name: scale(load_body(body), {"stature": stature}) for name, (body, stature) in ENDS.items()
    }
    others = {name: (body, _posture("standing", body)) for name, body in bodies.items()}
    return {"a man": standing_man(), **others}


def standing_person(bounds: Floats) -> Placed:
    """Stand a person beside a mesh, looking forward.

    Parameters
    ----------
    bounds
        (2, 3) [m] of the mesh. The person stands at its foot, to the right of its front, where the
        corner view hides nothing.
    """
    poses = _posture("standing")
    low, high = bounds
    return _shifted(poses, np.array([high[0], low[1] - ASIDE]), float(low[2]))


def _shifted(poses: Poses, at: Floats, ground: float) -> Placed:
    """The person with the middle over a place (2,) [m] and the soles on the ground [m]."""
    placed = place(_person(), poses)
    radius = _person().radius[0]
    centres = placed.centres[0]
    world = poses.world_from_reference.copy()
    world[0, :2, 3] += at - centres[:, :2].mean(axis=0)
    world[0, 2, 3] += ground - (centres[:, 2] - radius).min()
    return place(_person(), Poses(poses.rotations, poses.reference, world))


def person_words() -> str:
    """Who stands there, with the stature."""
    placed = place(_person(), _posture("standing"))
    z = placed.centres[0, :, 2]
    radius = _person().radius[0]
    high = float((z + radius).max() - (z - radius).min())
    return f"{plain(PERSON)}, {high:.2f} m tall"


def seated_eye(file: EnvironmentFile, name: str) -> Floats:
    """(3,) [m] the middle between the eyes of the person in a seat, with trunk and head as a first
    study has those who operate: in the lap, hands let the head up by 13 mm and back by 90.

    Parameters
    ----------
    file, name
        As of `seated_person`.
    """
    return _seated("driving", file, name).eye[0]


@dataclass(frozen=True)
class SeatedWords:
    """Sentences about a seat with somebody in it: doubts, which there is something to mend of, and
    notes, of which nothing is."""

    doubts: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


def seated_words(file: EnvironmentFile, name: str, ground: Ground) -> SeatedWords:
    """Say what is wrong with the feet of the person in a seat, and what would mend it.

    Who has pedals ahead is not at work with the feet at rest: that they would be under the floor
    there is a note.

    Parameters
    ----------
    file, name
        As of `seated_person`.
    ground
        What may be a floor.
    """
    own_seat = seat_of(name, file.seats[name], ())
    pedals = {called: one for called, one in file.controls.items() if one.grip == "foot"}
    parts = [key for one in pedals.values() for key in one.part_keys]
    no_floor = [part for key in parts for part in matching_parts(key, ground.names)]
    placed = seated_person(file, name)
    feet = feet_on_floor(placed, 0, own_seat, ground, without=no_floor)
    who = f"{name}: {plain(PERSON)}, hands in the lap"
    ahead = [called for called, one in pedals.items() if _is_ahead(one.at, placed, own_seat)]
    if ahead and feet is not None and feet.above < -UNDER and math.isfinite(feet.ahead):
        words = (
            f"{who}: at rest the feet would be {-1e3 * feet.above:.0f} mm under {feet.part!r}; "
            f"{' and '.join(ahead[:2])} {'are' if len(ahead) > 1 else 'is'} farther ahead, and a study "
            f"puts the feet there"
        )
        return SeatedWords(notes=(words,))
    return SeatedWords(tuple(feet_words(who, feet, list(pedals))))


def _is_ahead(at: Sequence[float], placed: Placed, own_seat: Seat) -> bool:
    """Whether a pedal is before a seat, farther ahead than the feet of who sits in it at rest."""
    body = placed.body
    feet = [placed.centres[0, body.spheres(body.segment(foot)), :2].mean(axis=0) for foot in LEGS]
    ahead = np.array([math.cos(own_seat.yaw), math.sin(own_seat.yaw)])
    x, y = np.array(at[:2]) - own_seat.srp[:2]
    aside = ahead[0] * y - ahead[1] * x
    return bool((np.array(at[:2]) - np.mean(feet, axis=0)) @ ahead > 0.0 and abs(aside) < BESIDE)


def seated_person(file: EnvironmentFile, name: str) -> Placed:
    """Seat the person in a seat where it stands at rest, hands in the lap.

    Parameters
    ----------
    file
        What an environment's file says.
    name
        Of one of its seats.
    """
    return place(_person(), _seated("hands_in_lap", file, name).poses)


def _seated(posture: str, file: EnvironmentFile, name: str) -> Seated:
    return seat(_person(), _posture(posture), seat_of(name, file.seats[name], ()))
