"""Chains of bodies asked to reach for points of rays: the tasks of the solver, posed and
retargeted."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from workbench.body.forward import segment_frames
from workbench.errors import UsageError
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.joint_angles import angles_of
from workbench.model.poses import Poses
from workbench.posture.reaching.limbs import Limb
from workbench.posture.reaching.reach_solver import (
    LimbTask,
    ReachSolution,
    cold,
    goals_of,
    legal,
    limb_task,
    rows_of,
    tips_of,
)

__all__ = [
    "Drawn",
    "Rays",
    "anchors",
    "asked",
    "check_step",
    "comfort_start",
    "drawn",
    "held_at",
    "level_rays",
    "merged",
    "point_rays",
    "ray_grid",
    "rows_toward",
    "solid_angles",
]

AT_ONCE = 16
"""Points whose distances to all tips are held at once, as many as a cache holds."""
LEGAL = 5e-4
"""Breach [rad, m] below which a posture is within the stops."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """M legal postures: angles (M, K, 3), and where they bring the tips (B, M, 3) [m] of B
    bodies."""

    angles: Floats
    tips: Floats

    def nearest(self, who: Ints, points: Floats) -> tuple[Ints, Floats]:
        """For points (P, 3) of bodies who (P,): the posture (P,) that brings the tip nearest, and
        how near (P,) [m]."""
        best = np.zeros(len(points), np.int64)
        gap = np.zeros(len(points))
        for person in np.unique(who):
            rows = np.flatnonzero(who == person)
            tips = self.tips[person]
            # the square of the distance less that of the point: |t|^2 - 2 t . p, one product each
            square = np.vstack([-2.0 * tips.T, np.einsum("mi,mi->m", tips, tips)])
            raised = np.column_stack([points[rows], np.ones(len(rows))])
            for first in range(0, len(rows), AT_ONCE):
                some = slice(first, first + AT_ONCE)
                best[rows[some]] = (raised[some] @ square).argmin(axis=1)
            gap[rows] = np.linalg.norm(points[rows] - tips[best[rows]], axis=1)
        return best, gap


def asked(body: Body, poses: Poses, chain: Limb) -> LimbTask:
    """One row for each of the B rows of a body in its own pose (B rows of poses), as yet without a
    goal."""
    return limb_task(
        body,
        chain,
        np.arange(len(body)),
        held=poses.rotations,
        base=segment_frames(body, poses, chain.base),
        goal=goals_of(np.zeros((len(body), 3))),
    )


def rows_toward(task: LimbTask, who: Ints, points: Floats) -> LimbTask:
    """The bodies who (P,) of a task of one row a body, reaching for points (P, 3) [m]."""
    return replace(rows_of(task, who), goal=goals_of(points))


def comfort_start(task: LimbTask) -> Floats:
    """(P, K, 3) the chains' angles as the poses have them, the free ones at their comfort modes."""
    given = Poses(task.held, 0, np.repeat(np.eye(3, 4)[None], len(task), axis=0))
    return cold(task, angles_of(task.body, given)[:, task.joints])


def anchors(task: LimbTask) -> tuple[Floats, Floats]:
    """Of a task of one row a body: the points (B, 3) [m] that the first free joint turns about, and
    how far (B,) [m] the tip can be from there at most, all links beyond in one line."""
    link = task.link
    first = int(task.link.free_joint.min())
    held = np.zeros((len(task), 6))
    base = task.base
    if first > 0:
        # what lies before the first free joint is held: its link is where forward kinematics puts
        # it
        poses = Poses(task.held, task.limb.base, task.base)
        base = segment_frames(task.body, poses, task.joints[first - 1] + 1)
    held = np.einsum("bij,bj->bi", base[:, :, :3], link.at_parent[:, first]) + base[:, :, 3]
    steps = link.at_parent[:, first + 1 :] - link.at_child[:, first:-1]
    length = np.linalg.norm(steps, axis=2).sum(axis=1) + np.linalg.norm(
        link.tip - link.at_child[:, -1], axis=1
    )
    return held, length


def drawn(task: LimbTask, count: int) -> Drawn:
    """Legal postures spread evenly over the joints' ranges out of `count` tries, of a task of one
    row a body: the same ones each time, and for all."""
    link = task.link
    people = len(task)
    limits = task.body.stops.limits[task.joints]
    share = np.random.default_rng(7).uniform(size=(count, len(task.joints), 3))
    angles = np.repeat(comfort_start(rows_of(task, np.arange(1))), count, axis=0)
    free: Bools = link.free_of >= 0
    angles[:, free] = (-limits[..., 1] + share * limits.sum(axis=-1))[:, free]
    good = np.linalg.norm(angles[..., :2], axis=-1).max(axis=1) < 3.0
    good &= legal(rows_of(task, np.zeros(count, np.int64)), angles)
    angles = angles[good]
    every = rows_of(task, np.repeat(np.arange(people), len(angles)))
    tips = tips_of(every, np.tile(angles, (people, 1, 1)))[:, :3]
    return Drawn(angles, tips.reshape(people, len(angles), 3))


def merged(found: ReachSolution, other: ReachSolution, rows: Ints) -> ReachSolution:
    """Found with the rows (Q,) taken from another (Q) where that came nearer within the stops."""
    less = (other.numbers[:, 0] < found.numbers[rows, 0]) & (other.numbers[:, 1] < LEGAL)
    take = rows[less]
    angles = found.angles.copy()
    numbers = found.numbers.copy()
    held = found.held.copy()
    overlap = found.overlap.copy()
    part = found.part.copy()
    angles[take] = other.angles[less]
    numbers[take] = other.numbers[less]
    held[take] = other.held[less]
    overlap[take] = other.overlap[less]
    part[take] = other.part[less]
    return ReachSolution(angles, numbers, held, overlap, part)


def held_at(task: LimbTask, angles: Floats) -> ReachSolution:
    """Postures (P, K, 3) as they are, with how far they miss the goals of a task."""
    gap = np.linalg.norm(tips_of(task, angles)[:, :3] - task.goal[:, :3], axis=1)
    numbers = np.zeros((len(task), 8))
    numbers[:, 0] = gap
    held = np.zeros((len(task), 6 + len(task.link.rows)))
    return ReachSolution(angles, numbers, held, np.zeros(len(task)), np.full(len(task), -1))


# Rays along which reach is found: a grid about one point, as Kennedy's device had it, and levels
# about an upright axis.
#
# Kennedy (1978, AMRL-TR-77-50) measured along rods 15 degrees apart that pointed at the seat
# reference point, and measured the reach in level and upright sections.


@dataclass(frozen=True, eq=False)
class Rays:
    """R rays: where they begin (R, 3) [m], unit directions (R, 3), whose they are (R,): a number of
    a body; beside (R, N): the rays next to each, -1 where there are fewer than N."""

    origin: Floats
    direction: Floats
    who: Ints
    beside: Ints

    def __len__(self) -> int:
        return len(self.who)

    def at(self, radius: Floats) -> Floats:
        """(R, 3) [m] the points at these radii (R,)."""
        return self.origin + radius[:, None] * self.direction

    def rows(self, rows: Ints) -> Rays:
        """Some of the rays; those beside keep the numbers they had."""
        return Rays(self.origin[rows], self.direction[rows], self.who[rows], self.beside[rows])


def point_rays(origins: Floats, direction: Floats, triangles: Ints) -> Rays:
    """The rays (B D,) of B people about their origins (B, 3) [m] along the directions (D, 3) of a
    grid of triangles (T, 3), person by person."""
    people = len(origins)
    rays = len(direction)
    who = np.repeat(np.arange(people), rays)
    beside = np.tile(_beside(rays, triangles), (people, 1))
    beside = np.where(beside >= 0, beside + who[:, None] * rays, -1)
    return Rays(np.repeat(origins, rays, axis=0), np.tile(direction, (people, 1)), who, beside)


def _beside(rays: int, triangles: Ints) -> Ints:
    """(D, N) the rays that share an edge of a triangle with each, the first 8 of them, -1 where
    there are fewer."""
    pairs = np.unique(
        np.concatenate([triangles[:, list(pair)] for pair in ((0, 1), (1, 2), (2, 0))]), axis=0
    )
    beside = np.full((rays, 8), -1)
    count = np.zeros(rays, np.int64)
    for one, other in pairs:
        if count[one] < 8:
            beside[one, count[one]] = other
            count[one] += 1
    return beside


def level_rays(origin: Floats, heights: Floats, step: int) -> Rays:
    """Level rays every `step` degrees of azimuth about the upright axis through an origin (3,) [m],
    at each of the heights (H,) [m] above it, height by height."""
    azimuth = np.radians(np.arange(0, 360, step))
    direction = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(len(azimuth))], axis=1)
    start = origin + np.repeat(heights, len(azimuth))[:, None] * np.array([0.0, 0.0, 1.0])
    place = np.arange(len(heights) * len(azimuth)).reshape(len(heights), len(azimuth))
    down = np.full_like(place, -1)
    up = np.full_like(place, -1)
    down[1:] = place[:-1]
    up[:-1] = place[1:]
    beside = np.stack(
        [np.roll(place, 1, axis=1), np.roll(place, -1, axis=1), down, up], axis=-1
    ).reshape(-1, 4)
    return Rays(
        start, np.tile(direction, (len(heights), 1)), np.zeros(len(start), dtype=np.int64), beside
    )


def check_step(step: int) -> None:
    """UsageError for a step of a grid of rays [deg] that does not go into a right angle."""
    if step < 1 or 90 % step:
        steps = ", ".join(str(whole) for whole in range(1, 91) if 90 % whole == 0)
        raise UsageError(f"step: expected one of {steps} degrees, got {step}")


def ray_grid(step: int) -> tuple[Floats, Ints]:
    """Unit rays (D, 3) every `step` degrees of azimuth and elevation, level by level from below,
    then the lowest and the highest; and the triangles (T, 3) between them, counter-clockwise seen
    from outside."""
    azimuth = np.radians(np.arange(0, 360, step))
    levels = np.radians(np.arange(-90 + step, 90, step))
    a, e = (grid.ravel() for grid in np.meshgrid(azimuth, levels))
    direction = np.stack([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)], axis=1)
    count = len(azimuth)
    rows = len(levels)
    here = np.arange(count)
    after = (here + 1) % count
    triangles = []
    for level in range(rows - 1):
        low = level * count
        high = (level + 1) * count
        triangles += [np.stack([low + here, low + after, high + after], axis=1)]
        triangles += [np.stack([low + here, high + after, high + here], axis=1)]
    bottom = np.full(count, rows * count)
    top = np.full(count, rows * count + 1)
    triangles += [np.stack([bottom, after, here], axis=1)]
    triangles += [np.stack([top, (rows - 1) * count + here, (rows - 1) * count + after], axis=1)]
    return np.concatenate([direction, [[0, 0, -1.0], [0, 0, 1.0]]]), np.concatenate(triangles)


def solid_angles(direction: Floats, step: float) -> Floats:
    """(D,) [sr] of the cells of a grid of rays, `step` [rad] wide about each; together 4 pi."""
    elevation = np.arcsin(np.clip(direction[:, 2], -1.0, 1.0))
    low = np.maximum(elevation - step / 2, -np.pi / 2)
    high = np.minimum(elevation + step / 2, np.pi / 2)
    width = np.where(np.abs(direction[:, 2]) > 1.0 - 1e-12, 2 * np.pi, step)
    return width * (np.sin(high) - np.sin(low))
