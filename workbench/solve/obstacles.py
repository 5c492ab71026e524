"""Reaches kept off obstacles.

Obstacles are met in rounds: what a posture touches beyond what is allowed becomes planes that its spheres must stay
behind, and the posture is solved again from where it stands; where that leads nowhere, from other postures: those of
people alike that are clear, and seeds, always the same ones in the same order.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from workbench.kernels.limb_contacts import limb_contacts
from workbench.model.arrays import Floats, Ints
from workbench.model.environment import Environment
from workbench.solve.chains import Found, Task, Walls, legal, rows_of, seeds_of, solved, tips_of
from workbench.solve.collide import allowed_depth
from workbench.solve.family import packed_limbs
from workbench.solve.fields import field_of, packed_faces, packed_shells
from workbench.solve.threads import in_pieces

__all__ = ["Room", "cleared"]

DEEPEST, MOST_PLANES = 16, 48
CLEAR = 2e-4
"""How far [m] beyond what is allowed a posture is kept off obstacles, so that rounding does not touch them."""
AROUND = 0.03
"""How near [m] an obstacle is minded at once where a reach begins again from a posture that is clear."""
REACHED = 1e-4
PIECE = 64


@dataclass(frozen=True, eq=False)
class Room:
    """Obstacles: an environment, and which of its parts (K,) stand aside by shift (B, 3) [m] for each body.

    effort: rounds, seeds to begin again from, steps of the way back from obstacles. alike (P,): rows of the same number
    are of people alike, who may lead one another.
    """

    environment: Environment
    moving: Ints
    shift: Floats
    effort: tuple[int, int, int] = (8, 6, 24)
    alike: Ints | None = None
    threads: int | None = None


@dataclass(frozen=True, eq=False)
class _Touched:
    """Of P rows: overlap (P,) [m] beyond what is allowed, and the `many` (P,) deepest contacts as planes (P, Q, 8) with
    their parts (P, Q)."""

    overlap: Floats
    planes: Floats
    part: Ints
    many: Ints


def cleared(task: Task, found: Found, room: Room) -> Found:
    """The same reaches kept off obstacles."""
    best = _rounds(task, found, room)
    left = _unsettled(best, found, room)
    if room.alike is not None and len(left):
        rows, leads = _leads(best, left, room.alike)
        best = _from(task, best, rows, best.angles[leads], room)
        left = _unsettled(best, found, room)
    if not len(left):
        return best
    seeds, order = _seeds(task, room)
    free = (slice(None), task.link.free_joint, task.link.free_axis)
    for attempt in range(min(room.effort[1], order.shape[1])):
        start = found.angles[left].copy()
        start[free] = seeds[order[left, attempt]][free]
        best = _from(task, best, left, start, room)
        left = _unsettled(best, found, room)
        if not len(left):
            break
    left = left[best.overlap[left] > 0]
    if not len(left):
        return best
    walked = _walked(rows_of(task, left), (seeds[order[left, 0]], best.angles[left]), room)
    return _better(best, replace(walked, part=best.part[left]), left)


def _from(task: Task, best: Found, rows: Ints, start: Floats, room: Room) -> Found:
    """Begin again, some rows, from postures (P, K, 3), minding at once what is near to them."""
    if not len(rows):
        return best
    some = rows_of(task, rows)
    near = _touched(some, start, room, AROUND)
    walls = _walls([(np.arange(len(rows)), near)], len(rows))
    return _better(best, _rounds(some, solved(some, start, 0, walls=walls, threads=room.threads), room, walls), rows)


def _leads(best: Found, left: Ints, alike: Ints) -> tuple[Ints, Ints]:
    """Of the rows left those that have somebody alike who reaches clear of obstacles, and who: the nearest in order."""
    good = np.flatnonzero((best.overlap <= 0) & (best.numbers[:, 0] <= REACHED))
    if not len(good):
        return left[:0], left[:0]
    after = np.minimum(np.searchsorted(good, left), len(good) - 1)
    before = np.maximum(after - 1, 0)
    far = 10 * len(alike)
    gaps = [np.abs(good[k] - left) + far * (alike[good[k]] != alike[left]) for k in (before, after)]
    lead = np.where(gaps[0] <= gaps[1], good[before], good[after])
    has = np.minimum(*gaps) < far
    return left[has], lead[has]


def _walked(task: Task, ways: tuple[Floats, Floats], room: Room) -> Found:
    """The last clear posture on the way from one posture (P, K, 3), which is clear, to another, which is not."""
    begin, end = (angles.copy() for angles in ways)
    free = (slice(None), task.link.free_joint, task.link.free_axis)
    one, two = begin[free], end[free]
    begin[...] = end
    clear, good, overlap = np.ones(len(one), np.bool_), one.copy(), np.zeros(len(one))
    for step in range(room.effort[2] + 1):
        begin[free] = one + (two - one) * (step / room.effort[2])
        entered = _touched(task, begin, room, CLEAR).overlap
        if step == 0:
            overlap = entered
        clear &= (entered <= 0) & legal(task, begin)
        good[clear] = begin[free][clear]
        if not clear.any():
            break
    begin[free] = good
    numbers = np.zeros((len(one), 8))
    numbers[:, 0] = np.linalg.norm(task.goal[:, 6:] * (task.goal[:, :6] - tips_of(task, begin)), axis=1)
    held = np.zeros((len(one), 6 + len(task.link.rows)))
    return Found(begin, numbers, held, overlap, np.full(len(one), -1))


def _unsettled(best: Found, free: Found, room: Room) -> Ints:
    """Rows that enter obstacles, or miss a target that would be reached without them; of many people only those who
    would reach it: the others are told what they miss it by."""
    reachable = free.numbers[:, 0] <= REACHED
    asked = reachable if room.alike is not None else np.ones(len(reachable), dtype=np.bool_)
    return np.flatnonzero(asked & ((best.overlap > 0) | ((best.numbers[:, 0] > REACHED) & reachable)))


def _seeds(task: Task, room: Room) -> tuple[Floats, Ints]:
    """The postures to begin again from that enter no obstacle as the first row sits (all, where none does), and their
    numbers (P, M) for each row, nearest to its target first."""
    seeds, at = seeds_of(task.body, task.limb)
    overlap = _touched(rows_of(task, np.zeros(len(seeds), np.int64)), seeds, room, CLEAR).overlap
    clear = overlap <= 0 if np.any(overlap <= 0) else np.ones(len(seeds), np.bool_)
    local = np.einsum("pji,pj->pi", task.base[:, :, :3], task.goal[:, :3] - task.base[:, :, 3])
    gap = np.linalg.norm(local[:, None] - at[None, clear, :3], axis=-1)
    return seeds[clear], np.argsort(gap, axis=1, kind="stable")


def _rounds(task: Task, found: Found, room: Room, walls: Walls | None = None) -> Found:
    """Planes from what is touched, and solve again from there, until nothing is touched or the rounds are over."""
    best, current, history = found, found, list[tuple[Ints, _Touched]]()
    left = np.arange(len(task))
    for turn in range(room.effort[0] + 1):
        touched = _touched(rows_of(task, left), current.angles, room, CLEAR)
        part = _holding(current, walls)
        deepest = np.where(touched.many > 0, touched.part[:, 0], -1)
        part = np.where(touched.overlap > 0, deepest, part)
        current = replace(current, overlap=touched.overlap, part=part)
        best = current if turn == 0 else _better(best, current, left)
        hit = np.flatnonzero(touched.overlap > 0)
        if not len(hit) or turn == room.effort[0]:
            return best
        some = _Touched(touched.overlap[hit], touched.planes[hit], touched.part[hit], touched.many[hit])
        left = left[hit]
        history.append((left, some))
        walls = _walls(history, len(task), left)
        before = current.rows(hit)
        current = solved(rows_of(task, left), before.angles, 0, walls=walls, before=before, threads=room.threads)
    return best


def _holding(found: Found, walls: Walls | None) -> Ints:
    """(P,) the part of the plane that holds each limb, -1 where none."""
    if walls is None or not len(walls.part):
        return np.full(len(found.numbers), -1)
    held = (found.numbers[:, 7] > 0) & (found.numbers[:, 3] < 0)
    at = np.minimum(walls.start[:-1] + np.maximum(found.numbers[:, 4], 0).astype(np.int64), len(walls.part) - 1)
    return np.where(held, walls.part[at], -1)


def _walls(history: list[tuple[Ints, _Touched]], count: int, left: Ints | None = None) -> Walls:
    """The planes of all rounds, the last first, of the rows left (all where None); MOST_PLANES a row at most."""
    rows, planes, parts = [], [], []
    for row, touched in history[::-1]:
        some = np.arange(touched.planes.shape[1]) < touched.many[:, None]
        rows.append(np.repeat(row, touched.many))
        planes.append(touched.planes[some])
        parts.append(touched.part[some])
    row, plane, part = np.concatenate(rows), np.concatenate(planes), np.concatenate(parts)
    order = np.argsort(row, kind="stable")
    row, plane, part = row[order], plane[order], part[order]
    place = np.full(count, -1)
    place[np.arange(count) if left is None else left] = np.arange(count if left is None else len(left))
    rank = np.arange(len(row)) - np.searchsorted(row, row)
    keep = (rank < MOST_PLANES) & (place[row] >= 0)
    start = np.searchsorted(place[row[keep]], np.arange((count if left is None else len(left)) + 1))
    return Walls(plane[keep], part[keep], start.astype(np.int64))


def _touched(task: Task, angles: Floats, room: Room, near: float) -> _Touched:
    """What limbs at angles (P, K, 3) enter, or come nearer to than `near` [m], beyond what is allowed."""
    environment, count = room.environment, len(angles)
    shown = ~environment.hidden
    groups = [np.flatnonzero(shown & (room.moving == 0)), np.flatnonzero(shown & (room.moving > 0))]
    chosen = tuple(tuple(group.tolist()) for group in groups if len(group) or group is groups[0])
    limbs, allowed = packed_limbs(task.family, task.limb), allowed_depth(task.body, environment)
    least = np.stack([allowed[:, list(group)].min(axis=1, initial=np.inf) for group in chosen], axis=1)
    index = (
        packed_faces(environment), packed_shells(environment), field_of(environment, chosen),
        environment.polygon_part, allowed, room.moving, environment.normal, least,
    )  # fmt: skip
    out = (
        np.zeros((count, DEEPEST, 7)), np.zeros((count, DEEPEST, 8)), np.zeros(count, np.int64),
        np.full((count, DEEPEST), -1), np.zeros(count),
    )  # fmt: skip

    def work(begin: int, end: int) -> None:
        reach = (near, CLEAR)
        limb_contacts(limbs, task.who, task.held, task.base, angles, index, room.shift, reach, out, begin, end)

    in_pieces(work, count, PIECE, threads=room.threads)
    return _Touched(out[4], out[1], out[3], out[2])


def _better(best: Found, other: Found, rows: Ints) -> Found:
    """Take the other's rows where they are clear and these are not, or where miss and overlap together are less."""
    one, two = best.overlap[rows], other.overlap
    less = other.numbers[:, 0] + 2.0 * two < best.numbers[rows, 0] + 2.0 * one - 1e-9
    take = ((two > 0) == (one > 0)) & less | ((two <= 0) & (one > 0))
    chosen = rows[take]
    angles, numbers, held = best.angles.copy(), best.numbers.copy(), best.held.copy()
    overlap, part = best.overlap.copy(), best.part.copy()
    angles[chosen], numbers[chosen], held[chosen] = other.angles[take], other.numbers[take], other.held[take]
    overlap[chosen], part[chosen] = other.overlap[take], other.part[take]
    return Found(angles, numbers, held, overlap, part)
