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

from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints
from workbench.posture.reaching.chains import Found, Task, rows_of, solved, tips_of
from workbench.study.envelope.asking import Drawn, Rays, anchors, merged, rows_toward

__all__ = ["NEAR", "Ends", "ray_ends"]

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


def ray_ends(task: Task, rays: Rays, postures: Drawn) -> Ends:
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


def _bounds(task: Task, rays: Rays) -> tuple[Floats, Floats]:
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
    task: Task, postures: Drawn | None, rays: Rays, begin: Floats, end: Floats, start: Floats
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


def _nearest(some: Task, postures: Drawn | None, before: Found | Floats) -> Found:
    """How near the chains come to their goals: from what was found before, or from a sampled
    posture where one comes nearer than that did; at first from given angles."""
    if not isinstance(before, Found):
        return solved(some, before, 0)
    found = solved(some, before.angles, 0, near=before)
    if postures is None:
        return found
    number, gap = postures.nearest(some.who, some.goal[:, :3])
    again = np.flatnonzero(gap < found.numbers[:, 0])
    if not len(again):
        return found
    return merged(found, solved(rows_of(some, again), postures.angles[number[again]], 0), again)


def _step(task: Task, found: Found, way: Floats) -> Floats:
    """(P,) [m] how far to go on along the ways (P, 3): by as much as is missed, or near the
    boundary as far as its tangent plane."""
    miss = np.maximum(found.numbers[:, 0], NEAR)
    toward = (tips_of(task, found.angles)[:, :3] - task.goal[:, :3]) / miss[:, None]
    cosine = np.clip(np.einsum("pi,pi->p", toward, way), 1 / 3, 1.0)
    step: Floats = np.where(miss < FLAT, miss / cosine, miss)
    return step


def _mended(task: Task, rays: Rays, postures: Drawn, ends: Ends) -> Ends:
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
