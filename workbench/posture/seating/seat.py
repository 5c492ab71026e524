"""Sitters: for each body the place of the seat and the posture that give the view and the pedals.

The order is that of cockpit assessments (Zehner & Kennedy's): the lowest seat that still brings the
eyes to the height asked for, then fore and aft where both feet reach their pedals, heels on the
floor, thighs on the cushion and not through its front edge, most comfortably. What the seat cannot
give is told, not hidden: eyes stay below, feet stop short, thighs press in too deep.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from workbench.model.arguments import short_repr
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.criterion import Reason
from workbench.model.environment import Seat
from workbench.model.joint_angles import join_poses
from workbench.model.poses import Poses, check_rows, row_for_each
from workbench.posture.kernels.seat_optimization import SeatPlaces, new_seat_search, optimize_seat
from workbench.posture.kernels.seated_posture import (
    PRESSED,
    ROW,
    TOTAL_DISCOMFORT,
    VISITED,
    Sitting,
)
from workbench.posture.reaching.reach_solver import LimbTask, apply
from workbench.posture.seating.posture import DECIMALS, Pedals, positions
from workbench.posture.seating.resting import at_rest, lap_of, sitting_of
from workbench.posture.seating.seating import SeatAxes, own_axes, seat_attitude
from workbench.posture.seating.stepping import (
    comfortable,
    first_places,
    foot_tasks,
    legs_of,
    limits_of,
)
from workbench.threads import run_in_threads

__all__ = ["PEOPLE_PER_SEAT_BATCH", "SeatMemory", "Seated", "in_world", "join_seated", "seat"]

_Number = TypeVar("_Number", np.float64, np.int64)
_People = TypeVar("_People", bound="Seated")

PEOPLE_PER_SEAT_BATCH = 256
"""Rows of a body that are packed at a time, which bounds the memory."""
PIECE = 16
"""People that a thread takes at a time."""


@dataclass(frozen=True, eq=False)
class Seated:
    """B seated people, a row each."""

    poses: Poses
    """(B,) their postures in the world, each of its own row of the body."""
    forward: Floats
    """(B,) [m] travel of the seat, forward from where it stands at rest."""
    up: Floats
    """(B,) [m] travel of the seat, up from where it stands at rest."""
    shift: Floats
    """(B, 3) [m] displacement of the parts that move with the seat."""
    eye: Floats
    """(B, 3) [m] the middle between the eyes, NaN for a body without eyes."""
    eye_off: Floats
    """(B,) [m] how much the eyes stay above (+) or below (-) the height asked for; 0 if none is."""
    miss: Mapping[str, Floats]
    """(B,) [m] by foot: its distance from its pedal."""
    limit: Mapping[str, tuple[Reason, ...]]
    """(B,) by foot: what limits it."""
    spare_travel: Floats
    """(B, 4) [m] travel that is left to the rear, to the front, down and up."""
    discomfort: Floats
    """(B,) of both legs; 0 for drivers."""
    tried: Ints
    """(B,) how many places of the seat were tried."""
    pressed: Floats
    """(B,) [m] how much deeper the thighs press into the front of the cushion than it gives."""
    pitches: Mapping[str, Floats] = field(default_factory=dict)
    """(B, 2) [rad] by foot of a driver: the flattest and the steepest that the sole may be."""
    leg_overlap: Mapping[str, Floats] = field(default_factory=dict)
    """(B,) [m] by foot: how much deeper its leg is in a part than allowed, and was not found clear;
    empty as long as nobody looked at what stands around."""
    leg_part: Mapping[str, Ints] = field(default_factory=dict)
    """(B,) by foot: that part, -1 where there is none."""

    __repr__ = short_repr

    def __len__(self) -> int:
        return len(self.forward)

    def rows(self, keep: Ints) -> Seated:
        """The people at indices, in their order."""
        return Seated(
            poses=self.poses.rows(keep),
            forward=self.forward[keep],
            up=self.up[keep],
            shift=self.shift[keep],
            eye=self.eye[keep],
            eye_off=self.eye_off[keep],
            miss=_rows_of(self.miss, keep),
            limit={foot: tuple(words[k] for k in keep) for foot, words in self.limit.items()},
            spare_travel=self.spare_travel[keep],
            discomfort=self.discomfort[keep],
            tried=self.tried[keep],
            pressed=self.pressed[keep],
            pitches=_rows_of(self.pitches, keep),
            leg_overlap=_rows_of(self.leg_overlap, keep),
            leg_part=_rows_of(self.leg_part, keep),
        )


def _rows_of(by_foot: Mapping[str, NDArray[_Number]], keep: Ints) -> dict[str, NDArray[_Number]]:
    return {foot: values[keep] for foot, values in by_foot.items()}


def _joined(by_foot: Sequence[Mapping[str, NDArray[_Number]]]) -> dict[str, NDArray[_Number]]:
    return {foot: np.concatenate([one[foot] for one in by_foot]) for foot in by_foot[0]}


_Rest = Callable[[Floats], tuple[Floats, Floats]]
"""`at_rest` of some people, by the rotations (B, J, 4) of their joints."""


@dataclass(frozen=True, eq=False)
class _Ask:
    """What all people share: seat, eye height [m], pedals; whether every place is tried;
    threads."""

    seat: Seat
    eye: float | None
    pedals: Pedals
    every: bool
    threads: int | None


@dataclass(frozen=True, eq=False)
class _Travel:
    """Where the seats of B people may stand [m]."""

    forward: Floats
    """(B, 2) from the rear to the front."""
    up: Floats
    """(B, 2) from the lowest to the highest."""
    grid: Floats
    """(B, G) the places forward that are tried."""


def seat(
    body: Body,
    poses: Poses,
    seat: Seat,
    *,
    eye: float | None = None,
    pedals: Pedals | None = None,
    held: Floats | None = None,
    every: bool = False,
    threads: int | None = None,
) -> Seated:
    """Seat B people where the view and the pedals are had.

    The segment that the poses are placed by leans with the seat's back. Trunk, head and arms stay
    as the poses have them. Without pedals the legs stay too, and the seat stays where it stands at
    rest, or as near to that as its travel allows.

    With pedals, the seat stands at one of the places 10 mm apart along its travel: where the feet
    miss least, then where the thighs press no deeper into the front of the cushion than it gives,
    then most comfortably, then nearest to where it stands at rest. These are looked for downhill
    from a guess. The same person is seated alike alone and in any company, and wherever the seat stands
    and faces: all is looked for in the seat's own axes.

    Parameters
    ----------
    body, poses
        B poses of the rows of a body: of one person, of each row in their order, or of the rows
        that `poses.person` names.
    seat
        The seat with its travel.
    eye
        Height [m] that the eyes are to reach; the seat is as low as gives it. Any height if None.
    pedals
        Where the balls of the feet go, and the floor that the heels stand on.
    held
        (P, 2) [m] where the seat of each pose stands, forward and up. Anywhere within its travel
        if None.
    every
        Whether every place is tried. This takes many times as long and comes to the same.
    threads
        All cores if None. No answer depends on it.

    Raises
    ------
    UsageError
        If there are not as many poses as rows.
    InputError
        If nothing of a body rests on the seat, or if the eyes are asked for and it has none.

    Examples
    --------
    >>> import workbench as wb
    >>> body, trainer = wb.load_body("adult_male"), wb.load_environment("trainer")
    >>> sitting = wb.pose(body, {"LH": {"flexion": 85}, "RH": {"flexion": 85}}, reference="LT")
    >>> found = wb.seat(body, sitting, trainer.seat("left"))
    >>> found.poses.reference, found.poses.world_from_reference[0, :3, 3].round(3)  # [m]
    (1, array([0.087, 0.28 , 0.435]))
    """
    check_rows(poses, len(poses), "people")
    people = row_for_each(body, poses)
    axes = own_axes(seat)
    ask = _Ask(
        axes.seat,
        None if eye is None else axes.height(eye),
        Pedals({}) if pedals is None else _pedals_in(axes, pedals),
        every,
        threads,
    )
    found = []
    for first in range(0, len(poses), PEOPLE_PER_SEAT_BATCH):
        some = slice(first, first + PEOPLE_PER_SEAT_BATCH)
        own = Poses(poses.rotations[some], poses.reference, poses.world_from_reference[some])
        travel = _travel_of(seat, len(own), None if held is None else held[some])
        found.append(_some_people(people[some], own, ask, travel))
    seated = in_world(found[0] if len(found) == 1 else join_seated(found), axes)
    return replace(seated, poses=replace(seated.poses, time=poses.time, person=poses.person))


def _pedals_in(axes: SeatAxes, pedals: Pedals) -> Pedals:
    """Pedals in the axes of a seat."""
    floor = pedals.floor
    return Pedals(
        {foot: axes.point(at) for foot, at in pedals.at.items()},
        None if floor is None else axes.height(floor),
        pedals.along,
    )


def in_world(found: _People, axes: SeatAxes) -> _People:
    """People who sit in the axes of a seat, in the world."""
    heading = axes.world[:, :3]
    world = heading @ found.poses.world_from_reference
    world[:, :, 3] += axes.world[:, 3]
    return replace(
        found,
        poses=replace(found.poses, world_from_reference=world),
        shift=apply(heading[None], found.shift),
        eye=axes.back(found.eye),
    )


def _travel_of(seat: Seat, people: int, held: Floats | None) -> _Travel:
    """The travel of a seat for each of so many people; one place each where it is held (B, 2)."""
    if held is None:
        travel = np.array([seat.travel_forward, seat.travel_up], dtype=np.float64)
        forward, up, grid = (
            np.repeat(values[None], people, axis=0)
            for values in (*travel, positions(seat.travel_forward))
        )
        return _Travel(forward, up, grid)
    forward, up = (np.repeat(values[:, None], 2, axis=1) for values in held.T)
    return _Travel(forward, up, np.round(held[:, :1], DECIMALS))


def _some_people(body: Body, poses: Poses, ask: _Ask, may: _Travel) -> Seated:
    seat = ask.seat
    segment = body.segment("LT") if ask.pedals.at else poses.reference
    lap = lap_of(body, poses, seat, segment=segment, eye=ask.eye)
    sitting = sitting_of(body, poses, seat, lap, may.up, feet=ask.pedals.at)
    tasks = foot_tasks(body, poses, ask.pedals, sitting.ahead)
    grid = may.grid
    if not set(ask.pedals.at) - set(
        ask.pedals.along
    ):  # no place suits the legs better than another
        grid = np.clip(0.0, *may.forward.T)[:, None]
    rest = partial(at_rest, body, lap, sitting)
    found = (
        _stepped(sitting, tasks, poses.rotations, ask, grid, rest)
        if tasks
        else _resting(sitting, poses.rotations, may, rest)
    )
    eye = found.lap + lap.eyes
    world = np.zeros((len(poses), 3, 4))
    world[:, :, :3] = seat_attitude(seat)
    world[:, :, 3] = found.lap - lap.lean[:, :, 3]
    forward, up = found.travel.T
    rear, front = may.forward.T
    low, high = may.up.T
    shift = np.outer(forward, sitting.ahead) + np.outer(up, [0.0, 0.0, 1.0])
    return Seated(
        poses=Poses(found.rotations, poses.reference, world),
        forward=forward,
        up=up,
        shift=shift,
        eye=eye,
        eye_off=eye[:, 2] - ask.eye if ask.eye is not None else np.zeros(len(eye)),
        miss={foot: found.numbers[:, k, 0] for k, foot in enumerate(ask.pedals.at)},
        limit={
            foot: limits_of(tasks[k], found.numbers[:, k]) for k, foot in enumerate(ask.pedals.at)
        },
        spare_travel=np.stack([forward - rear, front - forward, up - low, high - up], axis=1),
        discomfort=found.row[:, TOTAL_DISCOMFORT],
        tried=found.row[:, VISITED].astype(np.int64),
        pressed=found.row[:, PRESSED],
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


def _stepped(
    sitting: Sitting, tasks: list[LimbTask], rotations: Floats, ask: _Ask, grid: Floats, rest: _Rest
) -> _Found:
    """People with their feet on pedals, each from a guess at the place of the seat on its grid (B,
    G)."""
    legs = legs_of(tasks, ask.pedals)
    count = len(rotations)
    turned = comfortable(tasks, rotations)
    lap = sitting.lap.copy()
    lap[:, :, 3] = rest(turned)[0]
    first = first_places(tasks, lap, grid, sitting.ahead, legs.along)
    travel = np.zeros((count, 2))
    numbers = np.zeros((count, 2, 8))
    row = np.zeros((count, ROW))
    out = SeatPlaces(turned, lap, travel, numbers, row)

    def work(begin: int, end: int) -> None:
        search = new_seat_search(sitting, legs, grid.shape[1], turned.shape[1])
        optimize_seat(sitting, legs, grid, first, ask.every, out, begin, end, search)

    run_in_threads(work, count, PIECE, threads=ask.threads)
    return _Found(turned, lap[:, :, 3].copy(), travel, numbers, row)


def _resting(sitting: Sitting, rotations: Floats, may: _Travel, rest: _Rest) -> _Found:
    """People without pedals: the seat stays where it is, or as near to that as its travel lets
    it."""
    count = len(rotations)
    at, up = rest(rotations)
    forward = np.clip(0.0, *may.forward.T)
    lap = at + forward[:, None] * sitting.ahead
    row = np.zeros((count, ROW))
    row[:, VISITED] = 1.0
    return _Found(rotations, lap, np.stack([forward, up], axis=1), np.zeros((count, 0, 8)), row)


def join_seated(parts: Sequence[Seated]) -> Seated:
    """The rows of several parts, in their order."""

    def whole(name: str) -> Floats:
        return np.concatenate([getattr(part, name) for part in parts])

    feet = list(parts[0].miss)
    return Seated(
        poses=join_poses([part.poses for part in parts]),
        forward=whole("forward"),
        up=whole("up"),
        shift=whole("shift"),
        eye=whole("eye"),
        eye_off=whole("eye_off"),
        miss=_joined([part.miss for part in parts]),
        limit={foot: tuple(words for part in parts for words in part.limit[foot]) for foot in feet},
        spare_travel=whole("spare_travel"),
        discomfort=whole("discomfort"),
        tried=np.concatenate([part.tried for part in parts]),
        pressed=whole("pressed"),
        pitches=_joined([part.pitches for part in parts]),
        leg_overlap=_joined([part.leg_overlap for part in parts]),
        leg_part=_joined([part.leg_part for part in parts]),
    )


# Where the people of a population sit once their seats are held in a position.
#
# The same people are seated in the same positions over and over: as the travel is searched, where the
# search ends, and with each change of the design that leaves seat, pedals and view as they are. Who
# sits where does not depend on the company, so everybody is seated once in each position.


@dataclass(frozen=True, eq=False)
class SeatMemory:
    """Seated people, filled in place.

    Parameters
    ----------
    known
        By the key of what decides it, and by the number of a person and the position [m] forward
        and up: people who were seated together, and the row among them.
    """

    known: dict[bytes, dict[tuple[int, float, float], tuple[Seated, int]]] = field(
        default_factory=dict
    )

    def seated(
        self, key: bytes, numbers: Ints, positions: Floats, some: Callable[[Ints], Seated]
    ) -> Seated:
        """B people of these numbers (B,) in positions (B, 2) [m]; some: seats those at indices, who
        were not seated there before."""
        known = self.known.setdefault(key, {})
        at = list(zip(numbers.tolist(), *positions.T.tolist(), strict=True))
        new = np.array([row for row, one in enumerate(at) if one not in known], dtype=np.int64)
        if len(new):
            fresh = some(new)
            known.update((at[row], (fresh, k)) for k, row in enumerate(new.tolist()))
        together: dict[int, list[int]] = {}
        for row, one in enumerate(at):
            together.setdefault(id(known[one][0]), []).append(row)
        parts = []
        for rows in together.values():
            batch = known[at[rows[0]]][0]
            parts.append(batch.rows(np.array([known[at[row]][1] for row in rows])))
        return join_seated(parts).rows(np.argsort(np.concatenate(list(together.values()))))
