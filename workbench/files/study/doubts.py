"""What of a study is probably a mistake: points for eyes, heels and wheels where no sitter can have
them, and contact that is allowed to nobody.

Nothing of it is an error. Each sentence gives the distance.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from workbench.files.environment_doubts import unknown_segments
from workbench.files.seat_doubts import eye_doubts, heel_doubts
from workbench.files.study.roles import LoadedRole
from workbench.files.study.schema import StudyFile
from workbench.geometry.ground import Ground, ground_of
from workbench.model.criterion import Criterion
from workbench.model.environment import Environment, Seat
from workbench.model.joint_angles import attitude_matrix
from workbench.model.study import PredictedPosture
from workbench.model.units import UNITS, limit_unit_of
from workbench.model.workplace import PostureGoals

__all__ = ["far_words", "length_doubts", "study_doubts"]

_HIP_AWAY = 0.3
"""How far [m] a hip point may be from the seat reference point: sitters sink in less."""
_WHEEL = (0.15, 1.2)
"""Least and greatest distance [m] of a wheel's centre from the seat reference point."""
_LAP = tuple((ahead, left) for ahead in (0.1, 0.25, 0.4) for left in (-0.12, 0.12))
_UNDER_LAP = (-0.25, 0.1)
"""Where thighs are, ahead and to the left of the seat reference point [m]; what is at such heights
[m] over it there bears them, or is what bears them."""


def study_doubts(
    environment: Environment,
    roles: Mapping[str, LoadedRole],
    actions: Mapping[tuple[int, str], object],
    criteria: Sequence[Criterion],
) -> list[str]:
    """Return a sentence for each thing that is probably a mistake.

    Parameters
    ----------
    environment
        Where the study takes place.
    roles
        Who takes part, by name.
    actions
        What each does, by the row of the case and the name of the role.
    criteria
        What must hold.
    """
    bodies = [role.body for role in roles.values()]
    doubts = unknown_segments(environment, [name for body in bodies for name in body.segments])
    for (_, name), action in actions.items():
        seat = roles[name].file.seat
        if isinstance(action, PredictedPosture) and seat is not None:
            aims = _aim_doubts(environment, environment.seat(seat), action.aims)
            doubts += [one for one in aims if not any(one in said for said in environment.warnings)]
    rooms = [one for one in criteria if one.check == "clearance" and one.at_least > 0.0]
    seats = {name: role.file.seat for name, role in roles.items() if role.file.seat is not None}
    ground = ground_of(environment) if rooms and seats else None
    for name, seat in seats.items():
        mine = [one for one in rooms if name in one.people]
        if ground is not None:
            doubts += _lap_doubts(environment.seat(seat), ground, mine)
    return list(dict.fromkeys(doubts))


def _lap_doubts(seat: Seat, ground: Ground, rooms: Sequence[Criterion]) -> Iterator[str]:
    """Clearances of thighs from what they lie on, or what is under that: no room for knees."""
    under: set[str] = set()
    for ahead, left in _LAP:
        x, y, _ = (attitude_matrix(yaw=seat.yaw) @ np.array([ahead, left, 0.0])).tolist()
        heights, parts = ground.levels(np.array([seat.srp[0] + x, seat.srp[1] + y]))
        low, high = (seat.srp[2] + height for height in _UNDER_LAP)
        near = parts[(heights > low) & (heights < high)]
        under.update(ground.names[part] for part in near.tolist())
    for one in rooms:
        borne = [part for part in one.parts if part in under]
        if borne and not one.subparts and {"LUL", "RUL"} & set(one.segments):
            yield (
                f"criterion {one.name!r}: the thighs of who sits in seat {seat.name!r} lie over "
                f"{' and '.join(map(repr, borne))}, so that {1e3 * one.at_least:g} mm from it say nothing "
                f"of the room for knees: leave it out, or ask 'subparts: [LLL/knee cap, RLL/knee cap]'"
            )


def _aim_doubts(environment: Environment, seat: Seat, aims: PostureGoals) -> Iterator[str]:
    """What is odd about the points that a posture is predicted from."""
    points = environment.points
    if aims.eyes is not None:
        yield from eye_doubts(seat, aims.eyes, points[aims.eyes])
    if aims.heels is not None:
        yield from heel_doubts(seat, ground_of(environment), aims.heels, points[aims.heels])
    driving = aims.driving
    if driving is not None:
        away = math.dist(points[driving.h_point], seat.srp)
        if away > _HIP_AWAY:
            yield (
                f"point {driving.h_point!r}: the hip point is {1e3 * away:.0f} mm away from the "
                f"reference point of seat {seat.name!r}; at most {1e3 * _HIP_AWAY:.0f} mm is plausible"
            )
        away = math.dist(points[driving.wheel], seat.srp)
        least, greatest = _WHEEL
        if not least <= away <= greatest:
            yield (
                f"point {driving.wheel!r}: the wheel's centre is {1e3 * away:.0f} mm away from the "
                f"reference point of seat {seat.name!r}; {1e3 * least:.0f} to "
                f"{1e3 * greatest:.0f} mm is plausible"
            )


def length_doubts(environment: Environment, file: StudyFile) -> Iterator[str]:
    """Return a sentence for each move and limit of a study that is larger than its environment: a
    number of millimetres where metres count."""
    for row, move in enumerate(file.moved):
        yield from far_words(f"moved[{row}]", [move.by], environment)
    for criterion in file.criteria:
        limits = [criterion.below, criterion.above]
        if limit_unit_of(criterion.check) is UNITS["m"]:
            limits += [criterion.at_least, criterion.at_most]
        stated = [(limit,) for limit in limits if limit is not None]
        yield from far_words(f"criterion {criterion.name!r}", stated, environment)


def far_words(
    what: str, lengths: Iterable[tuple[float, ...]], environment: Environment
) -> Iterator[str]:
    """Return a sentence where lengths [m] are larger than an environment.

    what: what the lengths are of.
    """
    size = float(np.ptp(environment.bounds, axis=0).max())
    farthest = max((abs(length) for row in lengths for length in row), default=0.0)
    if farthest > size:
        yield (
            f"{what}: {farthest:g} m is farther than environment {environment.name} is large "
            f"({size:.3g} m): is a unit missing, as in '20 mm'?"
        )
