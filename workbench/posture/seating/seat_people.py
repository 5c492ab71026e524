"""Sitters: for each body the place of the seat and the posture that give the view and the pedals.

The order is that of cockpit assessments (Zehner & Kennedy's): the lowest seat that still brings the
eyes to the height asked for, then fore and aft where both feet reach their pedals, heels on the
floor, most comfortably. What the seat cannot give is told, not hidden: eyes stay below, feet stop
short.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.environment import Seat
from workbench.model.poses import Poses, check_rows, row_for_each
from workbench.model.posing import join_poses
from workbench.posture.kernels.seat_search import ROW, seat_rows
from workbench.posture.kernels.sitting import EASE, TRIED, Sitting
from workbench.posture.reaching.chains import Task
from workbench.posture.seating.posture import Pedals, positions
from workbench.posture.seating.resting import at_rest, lap_of, sitting_of
from workbench.posture.seating.seating import seat_attitude
from workbench.posture.seating.stepping import (
    comfortable,
    first_places,
    foot_tasks,
    legs_of,
    limits_of,
)
from workbench.threads import in_pieces

__all__ = ["SeatedPeople", "seat_people"]

MOST_PEOPLE = 256
PIECE = 16


@dataclass(frozen=True, eq=False)
class SeatedPeople:
    """B seated people, a row each: poses in the world (B rows, for each its own body), the seat's
    `forward` and `up` (B,) [m] from where it stands at rest, and shift (B, 3) [m], the same as a
    vector for the parts that go along.

    eye (B, 3) [m]: midway between the eyes; eye_off (B,) [m]: how much it stays above (+) or below
    (-) the height asked for, 0 where none is. miss (B,) [m] and limit of each foot: how far it
    stays from its pedal, and what limits it in words ("" where nothing does). spare_travel (B, 4)
    [m]: what is left of the seat's travel to the rear, to the front, down and up. discomfort (B,):
    of both legs; tried (B,): how many places of the seat were.
    """

    poses: Poses
    forward: Floats
    up: Floats
    shift: Floats
    eye: Floats
    eye_off: Floats
    miss: Mapping[str, Floats]
    limit: Mapping[str, tuple[str, ...]]
    spare_travel: Floats
    discomfort: Floats
    tried: Ints

    def __len__(self) -> int:
        return len(self.forward)

    def rows(self, keep: Ints) -> SeatedPeople:
        """The people at indices, in their order."""
        return SeatedPeople(
            poses=self.poses.rows(keep),
            forward=self.forward[keep],
            up=self.up[keep],
            shift=self.shift[keep],
            eye=self.eye[keep],
            eye_off=self.eye_off[keep],
            miss={foot: miss[keep] for foot, miss in self.miss.items()},
            limit={foot: tuple(words[k] for k in keep) for foot, words in self.limit.items()},
            spare_travel=self.spare_travel[keep],
            discomfort=self.discomfort[keep],
            tried=self.tried[keep],
        )


@dataclass(frozen=True, eq=False)
class _Ask:
    """What all people share: seat, eye height [m], pedals; whether every place is tried;
    threads."""

    seat: Seat
    eye: float | None
    pedals: Pedals
    every: bool
    threads: int | None


def seat_people(
    body: Body,
    poses: Poses,
    seat: Seat,
    *,
    eye: float | None,
    pedals: Pedals,
    every: bool = False,
    threads: int | None = None,
) -> SeatedPeople:
    """Seat B people, rows of a body and a row of poses each, where view and pedals are had.

    Trunk, head and arms stay as the poses have them. eye: the height [m] that the eyes are to
    reach, any where None; the seat is as low as gives it. pedals: where the balls of the feet go,
    and the floor that the heels stand on. The seat stands at one of the places 10 mm apart along
    its travel: where the feet miss least, then most comfortably, then nearest to where it stands at
    rest. These are looked for downhill from a guess; every: all are tried, which takes many times
    as long and comes to the same. threads: all cores where None; no answer depends on it, nor on
    who else is seated. UsageError where there are not as many poses as rows; InputError where
    nothing of a body rests on the seat, or eyes are asked for that it does not have.
    """
    check_rows(poses, len(poses), "people")
    people = row_for_each(body, poses)
    ask = _Ask(seat, eye, pedals, every, threads)
    found = []
    for first in range(0, len(poses), MOST_PEOPLE):
        some = slice(first, first + MOST_PEOPLE)
        own = Poses(poses.rotations[some], poses.reference, poses.world_from_reference[some])
        found.append(_some_people(people[some], own, ask))
    return found[0] if len(found) == 1 else _joined(found)


def _some_people(body: Body, poses: Poses, ask: _Ask) -> SeatedPeople:
    seat = ask.seat
    segment = body.segment("LT") if ask.pedals.at else poses.reference
    lap = lap_of(body, poses, seat, segment=segment, eye=ask.eye)
    sitting = sitting_of(body, poses, seat, lap)
    tasks = foot_tasks(body, poses, ask.pedals, sitting.ahead)
    found = (
        _stepped(sitting, tasks, poses.rotations, ask)
        if tasks
        else _resting(sitting, poses.rotations, ask)
    )
    eye = found.lap + lap.eyes
    world = np.zeros((len(poses), 3, 4))
    world[:, :, :3] = seat_attitude(seat)
    world[:, :, 3] = found.lap - lap.lean[:, :, 3]
    (rear, front), (low, high) = seat.travel_forward, seat.travel_up
    forward, up = found.travel.T
    return SeatedPeople(
        poses=Poses(found.rotations, poses.reference, world),
        forward=forward,
        up=up,
        shift=np.outer(forward, sitting.ahead) + np.outer(up, [0.0, 0.0, 1.0]),
        eye=eye,
        eye_off=eye[:, 2] - ask.eye if ask.eye is not None else np.zeros(len(eye)),
        miss={foot: found.numbers[:, k, 0] for k, foot in enumerate(ask.pedals.at)},
        limit={
            foot: limits_of(tasks[k], found.numbers[:, k]) for k, foot in enumerate(ask.pedals.at)
        },
        spare_travel=np.stack([forward - rear, front - forward, up - low, high - up], axis=1),
        discomfort=found.row[:, EASE],
        tried=found.row[:, TRIED].astype(np.int64),
    )


@dataclass(frozen=True, eq=False)
class _Found:
    """Rotations (B, J, 4), lap (B, 3) [m] and travel (B, 2) [m] of people, numbers (B, 2, 8) of
    their feet, row (B, R) as of the kernel."""

    rotations: Floats
    lap: Floats
    travel: Floats
    numbers: Floats
    row: Floats


def _stepped(sitting: Sitting, tasks: list[Task], rotations: Floats, ask: _Ask) -> _Found:
    """People with their feet on pedals, each from a guess at the place of the seat."""
    legs = legs_of(tasks, ask.pedals)
    grid = positions(ask.seat.travel_forward)
    count = len(rotations)
    turned = comfortable(tasks, rotations)
    lap = sitting.lap.copy()
    lap[:, :, 3] = at_rest(sitting, turned)[0]
    first = first_places(tasks, lap, grid, sitting.ahead)
    travel = np.zeros((count, 2))
    numbers = np.zeros((count, 2, 8))
    row = np.zeros((count, ROW))
    out = turned, lap, travel, numbers, row

    def work(begin: int, end: int) -> None:
        seat_rows(sitting, legs, grid, first, int(ask.every), out, begin, end)

    in_pieces(work, count, PIECE, threads=ask.threads)
    return _Found(turned, lap[:, :, 3].copy(), travel, numbers, row)


def _resting(sitting: Sitting, rotations: Floats, ask: _Ask) -> _Found:
    """People without pedals: the seat stays where it is, or as near to that as its travel lets
    it."""
    count, (rear, front) = len(rotations), ask.seat.travel_forward
    at, up = at_rest(sitting, rotations)
    forward = np.full(count, min(max(0.0, rear), front))
    lap = at + forward[:, None] * sitting.ahead
    row = np.zeros((count, ROW))
    row[:, TRIED] = 1.0
    return _Found(rotations, lap, np.stack([forward, up], axis=1), np.zeros((count, 0, 8)), row)


def _joined(parts: list[SeatedPeople]) -> SeatedPeople:
    """All parts of a crowd as one."""

    def whole(name: str) -> Floats:
        return np.concatenate([getattr(part, name) for part in parts])

    feet = list(parts[0].miss)
    return SeatedPeople(
        poses=join_poses([part.poses for part in parts]),
        forward=whole("forward"),
        up=whole("up"),
        shift=whole("shift"),
        eye=whole("eye"),
        eye_off=whole("eye_off"),
        miss={foot: np.concatenate([part.miss[foot] for part in parts]) for foot in feet},
        limit={foot: tuple(words for part in parts for words in part.limit[foot]) for foot in feet},
        spare_travel=whole("spare_travel"),
        discomfort=whole("discomfort"),
        tried=np.concatenate([part.tried for part in parts]),
    )
