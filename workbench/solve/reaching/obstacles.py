"""Reaches kept off obstacles.

What a posture touches beyond what is allowed becomes walls that its spheres must stay behind, and the posture is solved
again from where it stands (kernels.limbs.around); where that leads nowhere, from the postures of people alike who
come clear, and from postures of all kinds that reach the target, always the same ones in the same order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from workbench.kernels.contact.field import Field
from workbench.kernels.contact.inside import Shells
from workbench.kernels.contact.polygon import Faces
from workbench.kernels.limbs.around import BLOCKED, LED, MOST_WALLS, OWN, SEARCH, Trail, settle
from workbench.kernels.limbs.contacts import Limbs, Obstacles, overlaps
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.solve.contact.collide import allowed_depth
from workbench.solve.contact.fields import field_of, packed_faces, packed_shells
from workbench.solve.family import packed_limbs
from workbench.solve.reaching.chains import PIECE, Found, Task, legal, rows_of, seeds_of, tips_of
from workbench.solve.threads import in_pieces

__all__ = ["Room", "cleared", "obstacles_of"]

CLEAR = 2e-4
"""Overlap [m] below which nothing is touched."""
REACHED = 1e-4
TRIES = 32
"""Postures that reach a target which a search looks at."""
EVERY = 16
"""Of people alike who are kept from a target, in the order of how far they must stretch, one in so many searches."""
SEEDS = 32
SMALL = 8


@dataclass(frozen=True, eq=False)
class Room:
    """Obstacles: an environment, and which of its parts (K,) stand aside by shift (B, 3) [m] for each body.

    alike (P,): rows of the same number are of people alike, who may lead one another; steps: of the way back from
    obstacles.
    """

    environment: Environment
    moving: Ints
    shift: Floats
    alike: Ints | None = None
    steps: int = 24
    threads: int | None = None


def cleared(task: Task, found: Found, room: Room) -> Found:
    """The same reaches kept off obstacles.

    Of people alike those who do not come clear search among other postures, one in EVERY; the others follow who has
    found a way. Whoever is kept from a target lies between two who have searched in vain.
    """
    count = len(task)
    alike = np.arange(count) if room.alike is None else room.alike
    free = found.numbers[:, 0] <= REACHED
    asked = free if room.alike is not None else np.ones(count, dtype=np.bool_)
    trail = Trail(
        np.array(found.angles), np.array(found.numbers), np.array(found.held), np.zeros(count),
        np.full(count, -1), np.zeros((count, MOST_WALLS, 6)), np.zeros((count, MOST_WALLS)),
        np.zeros(count, dtype=np.int64), np.zeros(count, dtype=np.int64),
    )  # fmt: skip
    every, none = np.arange(count), np.full(count, -1)
    _settled(task, room, trail, (every, none, alike, asked), OWN)
    left = _blocked(trail, free)
    if len(left):
        _settled(task, room, trail, (_sampled(left, alike), none, alike, asked), SEARCH)
        for way in (1, -1):
            left = _blocked(trail, free)[::way]
            guide = _guides(trail, left, alike, way)
            led = left[np.isin(alike[left], alike[trail.status == LED])] if room.alike is not None else left[:0]
            _settled(task, room, trail, (led, guide, alike, asked), 0)
    best = Found(trail.angles, trail.numbers, trail.held, trail.overlap, trail.part)
    left = np.flatnonzero(asked & (trail.overlap > 0))
    return _walked(task, best, left, room) if len(left) else best


def _blocked(trail: Trail, free: Bools) -> Ints:
    """Rows that enter obstacles, or miss a target that would be reached without them."""
    missed = free & (trail.numbers[:, 0] > REACHED)
    return np.flatnonzero((trail.status == BLOCKED) & ((trail.overlap > 0) | missed))


def _sampled(left: Ints, alike: Ints) -> Ints:
    """Of rows left the first and the last of each kind, and one in EVERY between; of few at least four."""
    groups = np.split(left, np.flatnonzero(np.diff(alike[left])) + 1)
    steps = [max(1, min(EVERY, len(group) // 4)) for group in groups]
    return np.concatenate(
        [np.unique(np.append(group[::step], group[-1])) for group, step in zip(groups, steps, strict=True)]
    )


def _guides(trail: Trail, left: Ints, alike: Ints, way: int) -> Ints:
    """(P,) for each row left the nearest before it (after it where way is -1) that is alike and was led around."""
    guide, led = np.full(len(alike), -1), np.flatnonzero(trail.status == LED)
    if len(led):
        at = np.searchsorted(led, left) - (1 if way > 0 else 0)
        near = led[np.clip(at, 0, len(led) - 1)]
        good = (at >= 0) & (at < len(led)) & (alike[near] == alike[left])
        guide[left[good]] = near[good]
    return guide


def _settled(task: Task, room: Room, trail: Trail, rows: tuple[Ints, Ints, Ints, Bools], ways: int) -> None:
    """Keep some rows off obstacles, into the trail."""
    todo, guide, alike, asked = rows
    limbs, obstacles = _packed(task, room)
    settings = (*seeds_of(task.body, task.limb), TRIES)
    order = todo, guide, alike, asked.astype(np.int64)

    def work(begin: int, end: int) -> None:
        settle(task.link, limbs, task.who, task.held, (task.base, task.goal), obstacles, settings, ways, order, trail,
               begin, end)  # fmt: skip

    in_pieces(work, len(todo), PIECE if ways & OWN else SMALL, threads=room.threads)


def _packed(task: Task, room: Room) -> tuple[Limbs, Obstacles]:
    around = obstacles_of(task.body, room.environment, room.moving, room.shift)
    return packed_limbs(task.family, task.limb), around


def obstacles_of(body: Body, environment: Environment, moving: Ints, shift: Floats) -> Obstacles:
    """Obstacles packed for the kernels, for a body and those with the same segments; the parts moving (K,) stand aside
    by shift (B, 3) [m] for each body."""
    return _fixed(body, environment, tuple(moving.tolist()))._replace(shift=np.array(shift))


@lru_cache(maxsize=8)
def _fixed(body: Body, environment: Environment, moving: tuple[int, ...]) -> Obstacles:
    """The obstacles for a body and those with the same segments, with the parts that move in a group of their own."""
    shown, moves = ~environment.hidden, np.array(moving)
    groups = [np.flatnonzero(shown & (moves == 0)), np.flatnonzero(shown & (moves > 0))]
    chosen = tuple(tuple(group.tolist()) for group in groups if len(group) or group is groups[0])
    allowed = allowed_depth(body, environment)
    least = np.stack([allowed[:, list(group)].min(axis=1, initial=np.inf) for group in chosen], axis=1)
    faces, shells, field = (Faces(*_plain(packed_faces(environment))), Shells(*_plain(packed_shells(environment))),
                            Field(*_plain(field_of(environment, chosen))))  # fmt: skip
    owner, allowed, moves, normal, least = _plain([environment.polygon_part, allowed, moves, environment.normal, least])
    return Obstacles(faces, shells, field, owner, allowed, moves, normal, least, np.zeros((1, 3)))


def _plain(arrays: Sequence[NDArray[Any]]) -> list[NDArray[Any]]:
    """Arrays as read-only ones in memory, whether they were that, or maps of a file: for each kind of array the kernels
    would be compiled again."""
    views = [np.asarray(array).view() for array in arrays]
    for view in views:
        view.flags.writeable = False
    return views


def _overlap(task: Task, angles: Floats, room: Room) -> Floats:
    """(P,) [m] how deep limbs at angles (P, K, 3) are in obstacles beyond what is allowed."""
    found = np.zeros(len(angles))
    limbs, obstacles = _packed(task, room)

    def work(begin: int, end: int) -> None:
        overlaps(limbs, task.who, task.held, task.base, angles, obstacles, CLEAR, found, begin, end)

    in_pieces(work, len(angles), PIECE, threads=room.threads)
    return found


def _walked(task: Task, best: Found, left: Ints, room: Room) -> Found:
    """Rows left, which enter obstacles, back to the last clear posture on the way from one that is clear, if any."""
    seeds = seeds_of(task.body, task.limb)[0][:SEEDS]
    one = rows_of(task, np.repeat(left[:1], len(seeds)))
    clear = np.flatnonzero((_overlap(one, seeds, room) <= 0) & legal(one, seeds))
    if not len(clear):
        return best
    some, angles = rows_of(task, left), best.angles[left]
    free = (slice(None), task.link.free_joint, task.link.free_axis)
    ends = angles[free]
    near = np.linalg.norm(seeds[clear][free][None] - ends[:, None], axis=2).argmin(axis=1)
    begins = seeds[clear][free][near]
    good, on, started = begins.copy(), np.ones(len(left), dtype=np.bool_), np.zeros(len(left), dtype=np.bool_)
    for step in range(room.steps + 1):
        angles[free] = begins + (ends - begins) * (step / room.steps)
        on &= (_overlap(some, angles, room) <= 0) & legal(some, angles)
        started |= on
        good[on] = angles[free][on]
        if not on.any():
            break
    angles[free] = good
    rows, angles = left[started], angles[started]
    error = np.linalg.norm(task.goal[rows, 6:] * (task.goal[rows, :6] - tips_of(rows_of(task, rows), angles)), axis=1)
    changed = replace(best, angles=best.angles.copy(), numbers=best.numbers.copy(), overlap=best.overlap.copy())
    changed.angles[rows], changed.overlap[rows] = angles, 0.0
    changed.numbers[rows, 0], changed.numbers[rows, 1:] = error, 0.0
    return changed
