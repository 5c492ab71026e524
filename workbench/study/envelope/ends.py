"""The ends of rays: how far out a limb reaches along each, and from where on, obstacles aside.

A miss is the distance to the nearest point that is reached, so no point nearer than that along the
ray is reached either: from outside, each solution says how far to come in, from the origin, how far
to go out (the sphere tracing of Hart 1996). Once that is less than `FLAT` the boundary is taken as
flat there, and the step is as long as the ray needs to meet that plane; a step that thereby went
past the boundary is halved back.

A solver that finds the nearest posture near by may overlook a nearer one. So each ray is searched
again from the postures at the ends of the rays beside it that go farther out, and from sampled
postures whose tips lie beside it beyond what was found, until none of these gains.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints
from workbench.posture.reaching.obstacles import ObstacleScene
from workbench.posture.reaching.reach_solver import (
    LimbTask,
    ReachSolution,
    rows_of,
    solve_reaches,
    tips_of,
)
from workbench.study.envelope.asking import (
    Drawn,
    Rays,
    anchors,
    comfort_start,
    held_at,
    merged,
    rows_toward,
)
from workbench.study.envelope.clearing import CLEAR, REACHED, cleared_from, touched

__all__ = ["NEAR", "SPACING", "Ends", "Stations", "cleared_stations", "ray_ends", "stations"]

NEAR = 3e-4
"""How exactly an end is found [m]."""
FLAT = 0.05
ROUNDS = 60
SWEEPS = 6
GAIN = 5e-3
"""How much farther out [m] another posture must be to be worth a search."""
BESIDE = np.cos(np.radians(9.0))


@dataclass(frozen=True, eq=False)
class Ends:
    """Outer and inner radius (R,) [m] along R rays, whether anything is reached there (R,), and the
    postures (R, K, 3) at the outer ends. Where nothing is reached both radii are where the limb
    comes nearest."""

    outer: Floats
    inner: Floats
    reached: Bools
    angles: Floats


def ray_ends(task: LimbTask, rays: Rays, postures: Drawn) -> Ends:
    """The ends of what the chains of a task of one row a body reach along rays."""
    far, near = _bounds(task, rays)
    rows = np.flatnonzero(far > near)
    outer = far.copy()
    reached = np.zeros(len(rays), np.bool_)
    angles = np.zeros((len(rays), *postures.angles.shape[1:]))
    first = postures.nearest(rays.who[rows], rays.rows(rows).at(far[rows]))[0]
    some = rays.rows(rows)
    got = _march(task, postures, some, far[rows], near[rows], postures.angles[first])
    outer[rows], reached[rows], angles[rows] = got
    ends = _mended(task, rays, postures, Ends(outer, far, reached, angles))
    inner = ends.outer.copy()
    rows = np.flatnonzero(ends.reached)
    start = postures.nearest(rays.who[rows], rays.rows(rows).at(near[rows]))[0]
    inner[rows] = np.minimum(
        _march(
            task,
            postures,
            rays.rows(rows),
            near[rows],
            ends.outer[rows],
            postures.angles[start],
        )[0],
        inner[rows],
    )
    return Ends(ends.outer, inner, ends.reached, ends.angles)


def _bounds(task: LimbTask, rays: Rays) -> tuple[Floats, Floats]:
    """The farthest and nearest radius (R,) at which each ray is within the sphere that the chain's
    length draws about its first joint; where it is not, the nearest twice."""
    centre, length = anchors(task)
    to = centre[rays.who] - rays.origin
    along = np.einsum("ri,ri->r", to, rays.direction)
    square = length[rays.who] ** 2 - np.einsum("ri,ri->r", to, to) + along**2
    half = np.sqrt(np.maximum(square, 0.0))
    meets = (square > 0) & (along + half > 0)
    nearest = np.maximum(along, 0.0)
    return np.where(meets, along + half, nearest), np.where(
        meets, np.maximum(along - half, 0.0), nearest
    )


def _march(
    task: LimbTask, postures: Drawn | None, rays: Rays, begin: Floats, end: Floats, start: Floats
) -> tuple[Floats, Bools, Floats]:
    """Where each ray first meets what is reached on its way from `begin` to `end` (R,) [m] (else
    where it came nearest), whether it does, and the posture there; beginning from postures (R, K,
    3)."""
    sign = np.where(end > begin, 1.0, -1.0)
    at = begin.copy()
    best = begin.copy()
    least = np.full(len(rays), np.inf)
    out = begin.copy()
    got = np.full(len(rays), np.nan)
    angles = start.copy()
    left = np.arange(len(rays))
    before = None
    for _ in range(ROUNDS):
        if not len(left):
            break
        some = rows_toward(task, rays.who[left], rays.rows(left).at(at[left]))
        found = _nearest(some, postures, start if before is None else before)
        miss = found.numbers[:, 0]
        closer = miss < least[left]
        best[left[closer]] = at[left[closer]]
        least[left[closer]] = miss[closer]
        reached = miss < NEAR
        got[left[reached]] = at[left[reached]]
        angles[left[reached]] = found.angles[reached]
        out[left[~reached]] = at[left[~reached]]
        at[left] += sign[left] * _step(some, found, sign[left, None] * rays.direction[left])
        known = ~np.isnan(got[left])
        at[left[known]] = 0.5 * (out[left[known]] + got[left[known]])
        on = np.where(
            known, np.abs(out[left] - got[left]) > NEAR, sign[left] * (end[left] - at[left]) >= 0
        )
        left = left[on]
        before = found.rows(on)
    reached = ~np.isnan(got)
    return np.where(reached, got, best), reached, angles


def _nearest(
    some: LimbTask, postures: Drawn | None, before: ReachSolution | Floats
) -> ReachSolution:
    """How near the chains come to their goals: from what was found before, or from a sampled
    posture where one comes nearer than that did; at first from given angles."""
    if not isinstance(before, ReachSolution):
        return solve_reaches(some, before, 0)
    found = solve_reaches(some, before.angles, 0, near=before)
    if postures is None:
        return found
    number, gap = postures.nearest(some.who, some.goal[:, :3])
    again = np.flatnonzero(gap < found.numbers[:, 0])
    if not len(again):
        return found
    return merged(
        found, solve_reaches(rows_of(some, again), postures.angles[number[again]], 0), again
    )


def _step(task: LimbTask, found: ReachSolution, way: Floats) -> Floats:
    """(P,) [m] how far to go on along the ways (P, 3): by as much as is missed, or near the
    boundary as far as its tangent plane."""
    miss = np.maximum(found.numbers[:, 0], NEAR)
    toward = (tips_of(task, found.angles)[:, :3] - task.goal[:, :3]) / miss[:, None]
    cosine = np.clip(np.einsum("pi,pi->p", toward, way), 1 / 3, 1.0)
    return np.where(miss < FLAT, miss / cosine, miss)


def _mended(task: LimbTask, rays: Rays, postures: Drawn, ends: Ends) -> Ends:
    """The outer ends searched again from the postures of rays and samples beside that go
    farther."""
    outer = ends.outer.copy()
    reached = ends.reached.copy()
    angles = ends.angles.copy()
    far = ends.inner
    ray, sample, radius = _samples_beside(rays, postures)
    changed = np.ones(len(rays), np.bool_)
    for sweep in range(SWEEPS):
        mine = np.where(reached, outer, 0.0)
        i, k = np.nonzero(rays.beside >= 0)
        j = rays.beside[i, k]
        worth = changed[j] & reached[j] & (outer[j] > mine[i] + GAIN) & (far[i] > mine[i] + GAIN)
        i = i[worth]
        start = angles[j[worth]]
        begin = outer[j[worth]]
        if sweep == 0:
            worth = (radius > mine[ray] + GAIN) & (far[ray] > mine[ray] + GAIN)
            i = np.concatenate([i, ray[worth]])
            begin = np.concatenate([begin, radius[worth]])
            start = np.concatenate([start, postures.angles[sample[worth]]])
        if not len(i):
            break
        nearest = mine[i] + NEAR
        outermost = np.minimum(begin, far[i])
        got, found, posture = _march(task, None, rays.rows(i), outermost, nearest, start)
        changed[:] = False
        gain = found & (got > mine[i] + NEAR)
        for row in np.flatnonzero(gain)[np.argsort(got[gain], kind="stable")]:
            outer[i[row]] = got[row]
            reached[i[row]] = True
            angles[i[row]] = posture[row]
            changed[i[row]] = True
    return Ends(outer, far, reached, angles)


def _samples_beside(rays: Rays, postures: Drawn) -> tuple[Ints, Ints, Floats]:
    """For each ray that has any the sample beside it whose tip is farthest out: ray, sample, its
    radius [m]."""
    ray = np.arange(len(rays))
    sample = np.zeros(len(rays), np.int64)
    radius = np.zeros(len(rays))
    off = square = np.zeros(0)
    for row in range(len(rays)):
        new = row == 0 or rays.who[row] != rays.who[row - 1]
        if new or np.any(rays.origin[row] != rays.origin[row - 1]):
            off = postures.tips[rays.who[row]] - rays.origin[row]
            square = np.einsum("mi,mi->m", off, off)
        along = off @ rays.direction[row]
        score = np.where((along > 0) & (along**2 > BESIDE**2 * square), square, 0.0)
        sample[row] = int(score.argmax())
        radius[row] = np.sqrt(score[sample[row]])
    return ray, sample, radius


# Stations along rays: points that a limb reaches free of obstacles, in what comfort, and whether
# it can clear of them.
#
# A station whose most comfortable posture enters nothing is clear. From there clearness spreads: a
# station beside a clear one is tried from that one's posture, kept off what is near, and from sampled
# clear postures whose tips are near.

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
    task: LimbTask
    angles: Floats
    reached: Bools
    discomfort: Floats
    clear: Bools
    part: Ints

    def __len__(self) -> int:
        return len(self.ray)


def stations(task: LimbTask, rays: Rays, ends: Ends) -> Stations:
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
    found = solve_reaches(some, comfort_start(some), 0)
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


def _reached_from_beside(at: Stations, found: ReachSolution) -> ReachSolution:
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
            found, solve_reaches(rows_of(at.task, rows), found.angles[beside[rows, lead]], 0), rows
        )


def cleared_stations(at: Stations, room: ObstacleScene, postures: Drawn) -> Stations:
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
    at: Stations, room: ObstacleScene, clear: Bools, angles: Floats, beside: Ints, failed: Bools
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


def _from_samples(
    at: Stations, room: ObstacleScene, clear: Bools, angles: Floats, postures: Drawn
) -> bool:
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
