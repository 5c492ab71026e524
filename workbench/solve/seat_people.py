"""Many people into one seat: for each body the seat position and posture that `seat_posture` finds.

All people and seat positions are rows of one batch: a coarse grid of positions, then the fine ones about the best.
Sitting and reaching take turns, as in `seat_posture`, each foot from where it was the turn before.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from workbench.errors import InputError, UsageError
from workbench.kernels.limb_contacts import least_heights
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.environment import Rest, Seat
from workbench.model.poses import Poses
from workbench.model.posing import angles_of
from workbench.model.reach import limit_words
from workbench.solve.chains import AGAIN, Found, Task, cold, posed, solved
from workbench.solve.family import Family, family_of, frames, packed_limbs, packed_links
from workbench.solve.limbs import Limb, limb
from workbench.solve.linkage import joints_between
from workbench.solve.posture import SHORT, STEP, Pedals, pointed_foot, positions
from workbench.solve.reach import REACHED, TURN_LEVER, goals_of, stopped_by
from workbench.solve.seating import seat_attitude, seat_planes
from workbench.solve.threads import in_pieces

__all__ = ["SeatedPeople", "seat_people"]

COARSE = 4
"""Every which of the positions is tried first."""
TURNS, LAST_TURNS = 4, 6
"""Turns of sitting and reaching: at every position, at the one that is taken."""
MOST_PEOPLE = 256
PIECE = 32
FREE_FOOT = 10.0
"""Discomfort of a heel in the air: it is put up with where the pedal cannot be had otherwise."""


@dataclass(frozen=True, eq=False)
class SeatedPeople:
    """B seated people, a row each: poses in the world (B rows, for each its own body), the seat's `forward` and `up`
    (B,) [m] from where it stands at rest, and shift (B, 3) [m], the same as a vector for the parts that go along.

    eye (B, 3) [m]: midway between the eyes; eye_off (B,) [m]: how much it stays above (+) or below (-) the height
    asked for, 0 where none is. miss (B,) [m] and limit of each foot: how far it stays from its pedal, and what limits
    it in words ("" where nothing does). spare_travel (B, 4) [m]: what is left of the seat's travel to the rear, to the
    front, down and up. discomfort (B,): of both legs.
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

    def __len__(self) -> int:
        return len(self.forward)


@dataclass(frozen=True, eq=False)
class _Rows:
    """R sitters: body who (R,), rotations (R, J, 4), world (R, 3, 4) of the reference segment, forward, up (R,) [m],
    eye (R, 3) [m]; miss and limiting stop (joint, axis, side) of each foot (R,), discomfort (R,)."""

    who: Ints
    rotations: Floats
    world: Floats
    forward: Floats
    up: Floats
    eye: Floats
    miss: dict[str, Floats]
    stop: dict[str, Floats]
    ease: Floats

    def taken(self, rows: Ints) -> _Rows:
        """Some of the rows."""
        return _Rows(
            self.who[rows], self.rotations[rows], self.world[rows], self.forward[rows], self.up[rows], self.eye[rows],
            {foot: values[rows] for foot, values in self.miss.items()},
            {foot: values[:, rows] for foot, values in self.stop.items()}, self.ease[rows],
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Place:
    """What all rows share: the family, the reference segment, seat, eye height [m], pedals, threads."""

    family: Family
    reference: int
    seat: Seat
    eye: float | None
    pedals: Pedals
    threads: int | None


def seat_people(
    bodies: Sequence[Body], poses: Poses, seat: Seat, *, eye: float | None, pedals: Pedals, threads: int | None = None
) -> SeatedPeople:
    """Seat B bodies of a family, one row of poses a body, each where view and pedals are had (see `seat_posture`).

    eye: the height [m] that the eyes are to reach, any where None. pedals: where the balls of the feet go, and the
    floor the heels stand on. threads: all cores where None; the answer does not depend on it. UsageError where there
    are not as many poses as bodies, or bodies are not of one family.
    """
    if len(poses) != len(bodies) or not len(bodies):
        raise UsageError(f"{len(bodies)} bodies need as many poses, and one at least, got {len(poses)}")
    found = []
    for first in range(0, len(bodies), MOST_PEOPLE):
        some = slice(first, first + MOST_PEOPLE)
        place = _Place(family_of(tuple(bodies[some])), poses.reference, seat, eye, pedals, threads)
        own = Poses(poses.rotations[some], poses.reference, poses.world_from_reference[some])
        found.append(_searched(place, own))
    return _answer(bodies[0], seat, eye, (poses.reference, found))


def _searched(place: _Place, poses: Poses) -> _Rows:
    """The best row of each person: of a coarse grid of positions, then of the fine ones about it."""
    every = positions(place.seat.travel_forward)
    coarse = np.unique(np.r_[0 : len(every) : COARSE, len(every) - 1])
    people = len(poses)
    who, at = np.repeat(np.arange(people), len(coarse)), np.tile(every[coarse], people)
    tried = _settled(place, _begun(place, poses, who, at), TURNS)
    best = _best(tried, people)
    near = np.abs(every[None] - best.forward[:, None]) < COARSE * STEP - 1e-6
    near &= np.abs(every[None] - best.forward[:, None]) > 1e-9
    who, at = np.nonzero(near)
    if len(who):
        finer = _settled(place, replace(best.taken(who), forward=every[at]), TURNS)
        best = _best(_both(best, finer), people)
    return _settled(place, best, LAST_TURNS)


def _both(one: _Rows, other: _Rows) -> _Rows:
    pairs = ((getattr(one, n), getattr(other, n)) for n in ("who", "rotations", "world", "forward", "up", "eye"))
    who, rotations, world, forward, up, eye = (np.concatenate(pair) for pair in pairs)
    miss = {foot: np.concatenate([values, other.miss[foot]]) for foot, values in one.miss.items()}
    stop = {foot: np.concatenate([values, other.stop[foot]], axis=1) for foot, values in one.stop.items()}
    return _Rows(who, rotations, world, forward, up, eye, miss, stop, np.concatenate([one.ease, other.ease]))


def _best(rows: _Rows, people: int) -> _Rows:
    """Of each person the row that misses least, then is easiest, then nearest to where the seat stands."""
    missed = sum(np.where(miss > SHORT, miss, 0.0) for miss in rows.miss.values()) * np.ones(len(rows.who))
    order = np.lexsort((np.abs(rows.forward), rows.ease.round(3), missed.round(4), rows.who))
    first = np.searchsorted(rows.who[order], np.arange(people))
    return rows.taken(order[first])


def _begun(place: _Place, poses: Poses, who: Ints, forward: Floats) -> _Rows:
    """The rows before anything has moved, knees and hips in comfort."""
    family, feet = place.family, list(place.pedals.at)
    rotations = np.array(poses.rotations)
    for foot in feet:
        chain = limb(family.bodies[0], foot, grip="ball")
        task = _leg(family, chain, (np.arange(len(poses)), rotations, None), np.zeros((len(poses), 12)))
        rotations = posed(task, cold(task, angles_of(family.bodies[0], poses)[:, task.joints]))
    world = np.array(poses.world_from_reference)[who]
    world[:, :, :3] = seat_attitude(place.seat)
    low, high = place.seat.travel_up
    up = np.full(len(who), min(max(0.0, low), high))
    none = np.full((3, len(who)), -1.0)
    return _Rows(
        who, rotations[who], world, forward, up, np.full((len(who), 3), np.nan),
        {foot: np.zeros(len(who)) for foot in feet}, dict.fromkeys(feet, none), np.zeros(len(who)),
    )  # fmt: skip


def _settled(place: _Place, rows: _Rows, turns: int) -> _Rows:
    """Sit and put the feet on the pedals in turns: thighs that the pedals lift change how a sitter rests."""
    rows = _sat(place, rows)
    for _ in range(turns):
        rows = replace(rows, ease=np.zeros(len(rows.who)))
        for foot, at in place.pedals.at.items():
            rows = _foot(place, rows, foot, at)
        rows = _sat(place, rows)
    return rows


def _sat(place: _Place, rows: _Rows) -> _Rows:
    """The rows at rest in the seat, as high as the eyes ask for (see `seat_body`)."""
    seat, body = place.seat, place.family.bodies[0]
    cushion, back, centre = seat_planes(seat)
    ways = np.stack([cushion, back])
    counts = np.stack([_resting(body, rest) for rest in (seat.cushion, seat.back)])
    limbs, heights = packed_limbs(place.family, _pelvis(body, place.reference, seat)), np.zeros((len(rows.who), 2))

    def work(begin: int, end: int) -> None:
        least_heights(limbs, rows.who, rows.rotations, rows.world, (ways, counts), heights, begin, end)

    in_pieces(work, len(rows.who), PIECE, threads=place.threads)
    point, ahead = np.array(seat.srp), np.array([centre[1], -centre[0], 0.0])
    aside = rows.world[:, :, 3] @ centre - centre @ point
    low, rear = heights[:, 0] - cushion @ point, heights[:, 1] - back @ point
    wanted = np.stack([-seat.cushion.depth - low, -seat.back.depth - rear, -aside], axis=1)
    world = rows.world.copy()
    world[:, :, 3] += np.linalg.solve(np.stack([cushion, back, centre]), wanted.T).T + rows.forward[:, None] * ahead
    eye, up = _eyes(place, rows, world), rows.up
    if place.eye is not None:
        up = np.clip(place.eye - eye[:, 2], *seat.travel_up)
    world[:, 2, 3] += up
    return replace(rows, world=world, up=up, eye=eye + up[:, None] * np.array([0.0, 0.0, 1.0]))


@lru_cache(maxsize=16)
def _pelvis(body: Body, reference: int, seat: Seat) -> Limb:
    """What rests on a seat, as a limb without joints."""
    resting = _resting(body, seat.cushion) | _resting(body, seat.back)
    none = np.zeros(len(body.sphere_names), dtype=np.bool_)
    moving = tuple(np.flatnonzero(resting).tolist())
    return Limb("what rests", reference, reference, (), np.zeros(3), np.zeros(3), moving, none)


def _resting(body: Body, rest: Rest) -> Bools:
    """(N,) the segments that rest there. InputError where none of them has spheres."""
    names = body.segments if "all" in rest.segments else rest.segments
    found: Bools = np.isin(body.segments, names) & (np.diff(body.start) > 0)
    if not found.any():
        raise InputError(f"body {body.name} has no spheres in {list(rest.segments)}, which rest on {rest.part!r}")
    return found


def _eyes(place: _Place, rows: _Rows, world: Floats) -> Floats:
    """(R, 3) [m] midway between the eyes. InputError where eyes are asked for and the body has none."""
    body = place.family.bodies[0]
    names = ("left eye", "right eye")
    if not all(name in body.sphere_names for name in names):
        if place.eye is None:
            return np.full((len(rows.who), 3), np.nan)
        raise InputError(f"body {body.name} has no spheres 'left eye' and 'right eye'")
    sphere = [body.sphere_names.index(name) for name in names]
    head = int(body.sphere_segment[sphere[0]])
    turned = frames(place.family, Poses(rows.rotations, place.reference, world), head, rows.who)
    middle = place.family.centre[rows.who][:, sphere].mean(axis=1)
    found: Floats = np.einsum("bij,bj->bi", turned[:, :, :3], middle) + turned[:, :, 3]
    return found


def _leg(family: Family, chain: Limb, rows: tuple[Ints, Floats, Floats | None], goal: Floats) -> Task:
    who, rotations, base = rows
    joints = joints_between(family.bodies[0], chain.base, chain.end)
    where = np.zeros((len(who), 3, 4)) if base is None else base
    return Task(family, chain, packed_links(family, chain), joints, who, rotations, where, goal)


def _foot(place: _Place, rows: _Rows, name: str, at: tuple[float, float, float]) -> _Rows:
    """Put one foot on its pedal, the heel on the floor where that can be."""
    family, count = place.family, len(rows.who)
    body = family.bodies[0]
    base = rows.world if place.reference == body.segment("LT") else frames(
        family, Poses(rows.rotations, place.reference, rows.world), body.segment("LT"), rows.who)  # fmt: skip
    goal = goals_of(np.repeat(np.array(at)[None], count, axis=0))
    chain, left = limb(body, name, grip="ball"), np.arange(count)
    if place.pedals.floor is not None:
        heeled = pointed_foot(body, name)
        task = _leg(family, heeled, (rows.who, rows.rotations, base), goal)
        heel, tip = packed_links(family, limb(body, name, grip="heel")).tip, packed_links(family, chain).tip
        sole = tip - heel
        size = np.linalg.norm(sole, axis=1)
        rise = np.clip((at[2] - place.pedals.floor) / size, -0.95, 0.95)[rows.who]
        centre = seat_planes(place.seat)[2]
        level = np.sqrt(1.0 - rise * rise)[:, None] * np.array([centre[1], -centre[0], 0.0])
        goal[:, 3:6], goal[:, 9:] = level + rise[:, None] * np.array([0.0, 0.0, 1.0]), TURN_LEVER
        link = task.link._replace(pointing=np.ascontiguousarray(sole / size[:, None]))
        task = replace(task, link=link, goal=goal)
        found, done = _stretched(task, place.threads, 1)
        rows = _taken(rows, task, found, (done, name, 0.0))
        left = np.flatnonzero(~done)
        goal = goals_of(np.repeat(np.array(at)[None], count, axis=0))
    if len(left):
        task = _leg(family, chain, (rows.who[left], rows.rotations[left], base[left]), goal[left])
        found, _ = _stretched(task, place.threads, AGAIN)
        whole = np.zeros(count, dtype=np.bool_)
        whole[left] = True
        rows = _taken(rows, task, found, (whole, name, FREE_FOOT if place.pedals.floor is not None else 0.0))
    return rows


def _stretched(task: Task, threads: int | None, again: int) -> tuple[Found, Bools]:
    """The legs solved from where they are, and which of them arrive."""
    found = solved(task, _angles(task), again, threads=threads)
    return found, found.numbers[:, 0] <= REACHED


def _angles(task: Task) -> Floats:
    """(P, K, 3) [rad] the chain's angles as the rows of a task hold them."""
    still = Poses(task.held, 0, np.repeat(np.eye(3, 4)[None], len(task), axis=0))
    return angles_of(task.body, still)[:, task.joints]


def _taken(rows: _Rows, task: Task, found: Found, what: tuple[Bools, str, float]) -> _Rows:
    """The rows with what was found put into the chosen ones; task and found hold all rows, or the chosen ones alone."""
    chosen, name, more = what
    own = chosen if len(task) == len(chosen) else np.ones(len(task), dtype=np.bool_)
    off = found.angles[:, task.link.free_joint, task.link.free_axis] - task.link.mode
    stopped = np.stack(stopped_by(task, found, found.numbers[:, 0] <= REACHED))
    rotations, ease = rows.rotations.copy(), rows.ease.copy()
    miss, stop = rows.miss[name].copy(), rows.stop[name].copy()
    rotations[chosen] = posed(task, found.angles)[own]
    ease[chosen] += (np.sum(task.link.weight * off * off, axis=1) + more)[own]
    miss[chosen], stop[:, chosen] = found.numbers[own, 0], stopped[:, own]
    stop[0, chosen] = np.where(found.numbers[own, 0] <= REACHED, -2.0, stop[0, chosen])
    return replace(rows, rotations=rotations, ease=ease, miss=rows.miss | {name: miss}, stop=rows.stop | {name: stop})


def _answer(body: Body, seat: Seat, eye: float | None, found: tuple[int, list[_Rows]]) -> SeatedPeople:
    reference, parts = found
    rows = parts[0]
    for other in parts[1:]:
        rows = _both(rows, other)
    (rear, front), (low, high) = seat.travel_forward, seat.travel_up
    centre = seat_planes(seat)[2]
    forward, up = rows.forward, rows.up
    words = {
        foot: tuple("" if stop[0, b] < -1.5 else limit_words(body, stop[:, b].astype(int)) for b in range(len(up)))
        for foot, stop in rows.stop.items()
    }
    return SeatedPeople(
        poses=Poses(rows.rotations, reference, rows.world),
        forward=forward,
        up=up,
        shift=np.outer(forward, [centre[1], -centre[0], 0.0]) + np.outer(up, [0.0, 0.0, 1.0]),
        eye=rows.eye,
        eye_off=rows.eye[:, 2] - eye if eye is not None else np.zeros(len(up)),
        miss=rows.miss,
        limit=words,
        spare_travel=np.stack([forward - rear, front - forward, up - low, high - up], axis=1),
        discomfort=rows.ease,
    )
