"""Reach envelopes about the seat reference point, as Kennedy measured them (AMRL-TR-77-50, 1978): how far the grip
goes along rays on a grid of 15 degrees.

A miss is the distance to the nearest point that is reached, so no point nearer than that along the ray is reached
either: from far outside, each solution says how far to come in, and from the origin how far to go out. That leaves
the outermost and the innermost reached point of every ray, each within `NEAR`, with fewer solutions than bisection.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.envelope import Envelope
from workbench.model.environment import Environment
from workbench.model.poses import Placed, Poses
from workbench.model.study import ReachTask, Study
from workbench.solve.limbs import Limb, limb
from workbench.solve.reach import reach
from workbench.study.placement import seat_point

__all__ = ["envelope", "envelopes", "ray_grid"]

STEP = 15
FARTHEST, NEAR, ROUNDS = 1.8, 3e-4, 40
SAMPLE = 0.1
"""Spacing [m] of the points of a ray that are tried against obstacles."""


def envelopes(study: Study, placed: Mapping[str, Placed], environment: Environment) -> Iterator[Envelope]:
    """The envelopes that a study asks for, from each person's first case's posture."""
    for task in study.envelopes:
        person = next(person for person in study.people if person.name == task.person)
        world = placed[person.name].world_from_segment[:1, person.poses.reference]
        poses = Poses(person.poses.rotations[:1], person.poses.reference, world)
        origin = seat_point(person, environment)
        yield envelope(placed[person.name].body, poses, origin, task=task, environment=environment)


def envelope(
    body: Body, poses: Poses, origin: Floats, *, task: ReachTask, environment: Environment | None = None
) -> Envelope:
    """The reach envelope of a hand about an origin (3,) [m], from one pose. InputError where the body lacks the grip's
    landmarks."""
    chain = limb(body, task.limb, grip=task.grip, zone=task.zone)
    direction, triangles = ray_grid(STEP)
    outer, hit = _trace((body, poses, chain), origin, direction, inward=True)
    inner = outer.copy()
    first, _ = _trace((body, poses, chain), origin, direction[hit], inward=False)
    inner[hit] = np.minimum(first, outer[hit])
    blocked = np.zeros(len(direction))
    if task.obstacles and environment is not None:
        blocked = _blocked((body, poses, chain), origin, (direction, inner, outer), environment)
    rays = len(direction)
    whole = _volume(direction, outer, triangles) - _volume(direction, inner, triangles)
    return Envelope(
        person=task.person,
        limb=chain.name,
        zone=task.zone,
        origin=origin,
        step=float(np.radians(STEP)),
        direction=direction,
        outer=outer,
        inner=inner,
        any_reached=hit,
        triangles=np.concatenate([triangles, triangles[:, ::-1] + rays]),
        volume=whole,
        obstacles=task.obstacles,
        lost=_lost((direction, inner, outer, triangles), blocked),
        blocked=blocked,
    )


def ray_grid(step: int) -> tuple[Floats, Ints]:
    """Unit rays (D, 3) every `step` degrees of azimuth and elevation, level by level from below, then the lowest and
    the highest; and the triangles (T, 3) between them, counter-clockwise seen from outside."""
    azimuth = np.radians(np.arange(0, 360, step))
    levels = np.radians(np.arange(-90 + step, 90, step))
    a, e = (grid.ravel() for grid in np.meshgrid(azimuth, levels))
    direction = np.stack([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)], axis=1)
    count, rows = len(azimuth), len(levels)
    here = np.arange(count)
    after = (here + 1) % count
    triangles = []
    for level in range(rows - 1):
        low, high = level * count, (level + 1) * count
        triangles += [np.stack([low + here, low + after, high + after], axis=1)]
        triangles += [np.stack([low + here, high + after, high + here], axis=1)]
    bottom, top = np.full(count, rows * count), np.full(count, rows * count + 1)
    triangles += [np.stack([bottom, after, here], axis=1)]
    triangles += [np.stack([top, (rows - 1) * count + here, (rows - 1) * count + after], axis=1)]
    return np.concatenate([direction, [[0, 0, -1.0], [0, 0, 1.0]]]), np.concatenate(triangles)


Reacher = tuple[Body, Poses, Limb]


def _trace(who: Reacher, origin: Floats, direction: Floats, *, inward: bool) -> tuple[Floats, Bools]:
    """(D,) [m] where each ray first meets what is reached, from far away or from the origin, and whether it does; else
    where it came nearest."""
    body, poses, chain = who
    rays = len(direction)
    at = np.full(rays, FARTHEST if inward else 0.0)
    best, least = at.copy(), np.full(rays, np.inf)
    hit, left = np.zeros(rays, np.bool_), np.arange(rays)
    start: Poses | None = None
    for turn in range(ROUNDS):
        if not len(left):
            break
        targets = origin + at[left, None] * direction[left]
        found = reach(body, poses, targets, limb=chain, start=start, tries=4 if turn == 0 else 1)
        near = found.miss < NEAR
        closer = found.miss < least[left]
        best[left[closer]], least[left[closer]] = at[left[closer]], found.miss[closer]
        hit[left[near]] = True
        at[left] += (-1.0 if inward else 1.0) * np.maximum(found.miss, NEAR)
        on = ~near & (at[left] >= 0.0) & (at[left] <= FARTHEST)
        left = left[on]
        start = Poses(found.poses.rotations[on], found.poses.reference, found.poses.world_from_reference[on])
    return best, hit


def _blocked(who: Reacher, origin: Floats, rays: tuple[Floats, Floats, Floats], environment: Environment) -> Floats:
    """(D,) the share of each ray between its ends that obstacles take."""
    body, poses, chain = who
    direction, inner, outer = rays
    counts = np.maximum(1, np.ceil((outer - inner) / SAMPLE)).astype(np.int64)
    counts[outer - inner < NEAR] = 0
    ray = np.repeat(np.arange(len(direction)), counts)
    place = np.arange(len(ray)) - np.repeat(np.cumsum(counts) - counts, counts)
    at = inner[ray] + (outer - inner)[ray] * (place + 0.5) / counts[ray]
    share = np.zeros(len(direction))
    if len(ray):
        targets = origin + at[:, None] * direction[ray]
        found = reach(body, poses, targets, limb=chain, environment=environment, tries=2)
        np.add.at(share, ray, ~found.reached / counts[ray])
    return share


def _volume(direction: Floats, radius: Floats, triangles: Ints) -> float:
    """[m3] enclosed by the surface at these radii, by the divergence theorem."""
    a, b, c = ((direction * radius[:, None])[triangles[:, k]] for k in range(3))
    return float(np.sum(np.cross(a, b) * c) / 6.0)


def _lost(shell: tuple[Floats, Floats, Floats, Ints], blocked: Floats) -> float:
    """[m3] of the shell that obstacles take: each triangle's part weighed by what its rays lose."""
    direction, inner, outer, triangles = shell
    total = 0.0
    for radius, sign in ((outer, 1.0), (inner, -1.0)):
        a, b, c = ((direction * radius[:, None])[triangles[:, k]] for k in range(3))
        share = blocked[triangles].mean(axis=1)
        total += sign * float(np.sum(np.sum(np.cross(a, b) * c, axis=1) / 6.0 * share))
    return total
