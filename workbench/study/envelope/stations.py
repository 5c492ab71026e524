"""Stations along rays: points that a limb reaches free of obstacles, in what comfort, and whether
it can clear of them.

A station whose most comfortable posture enters nothing is clear. From there clearness spreads: a
station beside a clear one is tried from that one's posture, kept off what is near, and from sampled
clear postures whose tips are near.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints
from workbench.posture.reaching.chains import Found, Task, rows_of, solved
from workbench.study.envelope.asking import Drawn, Rays, comfort_start, held_at, merged, rows_toward
from workbench.study.envelope.clearing import CLEAR, REACHED, Room, cleared_from, touched
from workbench.study.envelope.ends import NEAR, Ends

__all__ = ["SPACING", "Stations", "cleared_stations", "stations"]

SPACING = 0.05
"""Distance [m] of the stations of a ray, at most."""
TRIES = 4
"""Postures of stations beside from which one is tried."""
NEARBY = 0.1
"""How near [m] the tip of a sampled posture is to a station that is tried from it."""
SAMPLES = 2000


@dataclass(frozen=True, eq=False)
class Stations:
    """S stations, those of a ray in one run from its inner end outward: ray, place (S,): number of
    the ray and on it; radius (S,) [m]; first (R,), count (R,): the run of each ray. task: reaching
    for them; angles (S, K, 3): the posture; reached (S,), discomfort (S,): free of obstacles. clear
    (S,): reached clear of obstacles, by that posture; part (S,): else the obstacle that is entered
    deepest, -1 where none."""

    rays: Rays
    ray: Ints
    place: Ints
    radius: Floats
    first: Ints
    count: Ints
    task: Task
    angles: Floats
    reached: Bools
    discomfort: Floats
    clear: Bools
    part: Ints

    def __len__(self) -> int:
        return len(self.ray)


def stations(task: Task, rays: Rays, ends: Ends) -> Stations:
    """The stations of the rays on which something is reached, between their ends, each in its most
    comfortable posture obstacles aside."""
    span = ends.outer - ends.inner
    count = np.where(ends.reached, np.ceil(span / SPACING).astype(np.int64) + 1, 0)
    ray = np.repeat(np.arange(len(rays)), count)
    first = np.cumsum(count) - count
    place = np.arange(len(ray)) - first[ray]
    inside = np.minimum(NEAR, 0.5 * span)
    share = place / np.maximum(count[ray] - 1, 1)
    radius = (ends.inner + inside)[ray] + share * (span - 2.0 * inside)[ray]
    some = rows_toward(task, rays.who[ray], rays.rows(ray).at(radius))
    found = solved(some, comfort_start(some), 0)
    last = np.flatnonzero((place == count[ray] - 1) & (found.numbers[:, 0] >= REACHED))
    found = merged(found, held_at(rows_of(some, last), ends.angles[ray[last]]), last)
    none = np.zeros(len(ray), np.bool_)
    at = Stations(
        rays,
        ray,
        place,
        radius,
        first,
        count,
        some,
        found.angles,
        none,
        np.zeros(len(ray)),
        none,
        np.full(len(ray), -1),
    )
    found = _reached_from_beside(at, found)
    link = task.link
    reached = found.numbers[:, 0] < REACHED
    off = found.angles[:, link.free_joint, link.free_axis] - link.mode
    discomfort = np.sum(link.weight * off * off, axis=1)
    return replace(at, angles=found.angles, reached=reached, discomfort=discomfort, clear=reached)


def _reached_from_beside(at: Stations, found: Found) -> Found:
    """Stations that were missed, solved again from the postures of those beside that were not."""
    beside = _beside(at)
    tried = np.zeros(beside.shape, np.bool_)
    while True:
        reached = found.numbers[:, 0] < REACHED
        can = (beside >= 0) & reached[np.maximum(beside, 0)] & ~tried & ~reached[:, None]
        can &= (tried.sum(axis=1) < TRIES)[:, None]
        rows = np.flatnonzero(can.any(axis=1))
        if not len(rows):
            return found
        lead = can[rows].argmax(axis=1)
        tried[rows, lead] = True
        found = merged(
            found, solved(rows_of(at.task, rows), found.angles[beside[rows, lead]], 0), rows
        )


def cleared_stations(at: Stations, room: Room, postures: Drawn) -> Stations:
    """The stations with what obstacles leave of them."""
    first = touched(at.task, at.angles, room, CLEAR)
    clear = at.reached & (first.overlap <= 0)
    angles = at.angles.copy()
    part = np.where(first.overlap > 0, first.part[:, 0], -1)
    beside = _beside(at)
    failed = np.zeros(beside.shape, np.bool_)
    _spread(at, room, clear, angles, beside, failed)
    if _from_samples(at, room, clear, angles, postures):
        _spread(at, room, clear, angles, beside, failed)
    return replace(at, angles=angles, clear=clear, part=np.where(clear, -1, part))


def _beside(at: Stations) -> Ints:
    """(S, N) the stations next to each on its own ray and on the rays beside, -1 where there is
    none."""
    here = np.arange(len(at))
    last = at.count[at.ray] - 1
    beside = [np.where(at.place > 0, here - 1, -1), np.where(at.place < last, here + 1, -1)]
    for column in range(at.rays.beside.shape[1]):
        other = at.rays.beside[at.ray, column]
        ray = np.maximum(other, 0)
        some = (other >= 0) & (at.count[ray] > 0)
        begin = at.radius[np.minimum(at.first[ray], len(at) - 1)]
        end = at.radius[np.minimum(at.first[ray] + np.maximum(at.count[ray], 1) - 1, len(at) - 1)]
        share = (at.radius - begin) / np.maximum(end - begin, 1e-9)
        place = np.clip(
            np.round(share * (at.count[ray] - 1)), 0, np.maximum(at.count[ray] - 1, 0)
        ).astype(np.int64)
        found = np.where(some, np.minimum(at.first[ray] + place, len(at) - 1), 0)
        beside.append(np.where(some & (np.abs(at.radius[found] - at.radius) < SPACING), found, -1))
    return np.stack(beside, axis=1)


def _spread(
    at: Stations, room: Room, clear: Bools, angles: Floats, beside: Ints, failed: Bools
) -> None:
    """Try stations from clear ones beside, until nothing is gained; fills clear (S,) and angles (S,
    K, 3).

    failed (S, N): pairs of a station and one beside that have been tried in vain. The posture of a
    clear station never changes, so they would fail again: they count as tried and are not solved.
    """
    tried = np.zeros(beside.shape, np.bool_)
    while True:
        can = (beside >= 0) & clear[np.maximum(beside, 0)] & ~tried & (at.reached & ~clear)[:, None]
        can &= (tried.sum(axis=1) < TRIES)[:, None]
        rows = np.flatnonzero(can.any(axis=1))
        if not len(rows):
            return
        lead = can[rows].argmax(axis=1)
        tried[rows, lead] = True
        new = ~failed[rows, lead]
        rows = rows[new]
        lead = lead[new]
        if not len(rows):
            continue
        found, good = cleared_from(rows_of(at.task, rows), angles[beside[rows, lead]], room)
        failed[rows, lead] = ~good
        clear[rows[good]] = True
        angles[rows[good]] = found.angles[good]


def _from_samples(at: Stations, room: Room, clear: Bools, angles: Floats, postures: Drawn) -> bool:
    """Try stations from sampled clear postures near by; whether that gained any."""
    some = postures.angles[:SAMPLES]
    gained = False
    for person in np.unique(at.task.who):
        every = rows_toward(
            at.task,
            np.flatnonzero(at.task.who == person)[:1].repeat(len(some)),
            np.zeros((len(some), 3)),
        )
        free = touched(every, some, room, CLEAR).overlap <= 0
        rows = np.flatnonzero(at.reached & ~clear & (at.task.who == person))
        if not len(rows) or not free.any():
            continue
        own = Drawn(some[free], postures.tips[person : person + 1, :SAMPLES][:, free])
        number, gap = own.nearest(np.zeros(len(rows), np.int64), at.task.goal[rows, :3])
        rows = rows[gap < NEARBY]
        number = number[gap < NEARBY]
        if len(rows):
            found, good = cleared_from(rows_of(at.task, rows), own.angles[number], room)
            clear[rows[good]] = True
            angles[rows[good]] = found.angles[good]
            gained = gained or bool(good.any())
    return gained
