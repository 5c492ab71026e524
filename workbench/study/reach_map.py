"""The population reach map: for points all over a part's surface, the weighted share of people who reach them.

Nobody solves for every point. A miss is a distance: within it of a point that is missed nothing is reached, so points
there are settled at once, and exactly. The points left are taken coarse to fine, so that the first ones settle most.
Obstacles do not count: the map says how far arms are long enough and joints free enough.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import UsageError
from workbench.model.accommodation import MapTask, ReachMap
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.poses import Poses
from workbench.solve.limbs import HANDS
from workbench.solve.reach_people import reach_people

__all__ = ["part_points", "reach_map", "who_reaches"]

LEVELS = (27, 9, 3, 1)
"""Every which of the points, in their scattered order, is asked about in turn."""


def reach_map(
    bodies: Sequence[Body],
    poses: Poses,
    environment: Environment,
    part: str,
    *,
    points: int = 2000,
    grip: str = "push",
    zone: int = 2,
    hand: str | None = None,
    weights: ArrayLike | None = None,
    threads: int | None = None,
) -> ReachMap:
    """The share of B bodies of a family, a row of poses each, that reach points spread over a part.

    hand: "left" or "right", either where None; weights (B,): of the people, alike where None. InputError for an unknown
    part, UsageError where numbers do not fit.
    """
    if points < 1:
        raise UsageError(f"a reach map needs one point or more, got {points}")
    if hand not in (None, "left", "right"):
        raise UsageError(f"hand is left or right, or None for either, got {hand!r}")
    weight = np.ones(len(bodies)) if weights is None else np.asarray(weights, dtype=np.float64)
    if weight.shape != (len(bodies),) or not np.all(weight >= 0) or not weight.sum() > 0:
        raise UsageError(f"weights are {len(bodies)} numbers that are not negative, got {weights!r}")
    point, normal = part_points(environment, part, points)
    names = HANDS if hand is None else (f"{hand} hand",)
    reached = np.zeros((len(bodies), len(point)), dtype=np.bool_)
    for name in names:
        reached |= who_reaches(bodies, poses, point, limb=(name, grip, zone), settled=reached, threads=threads)
    task = MapTask(part, grip, zone, hand or "either", points)
    return ReachMap(task, point, normal, _flat(point, normal), weight @ reached / weight.sum())


def who_reaches(
    bodies: Sequence[Body],
    poses: Poses,
    points: Floats,
    *,
    limb: tuple[str, str, int],
    settled: Bools | None = None,
    threads: int | None = None,
) -> Bools:
    """(B, M) who reaches which of the points (M, 3) [m] with a limb (name, grip, zone); what is settled (B, M) already
    is not asked again, and told as reached."""
    people, count = len(bodies), len(points)
    reached = np.zeros((people, count), dtype=np.bool_) if settled is None else settled.copy()
    known, order = reached.copy(), _scattered(count)
    name, grip, zone = limb
    for at in np.array_split(np.arange(people), max(1, people // 64)):
        own = Poses(poses.rotations[at], poses.reference, poses.world_from_reference[at])
        some = [bodies[b] for b in at]
        for k, level in enumerate(LEVELS):
            new = np.setdiff1d(order[::level], order[:: LEVELS[k - 1]] if k else order[:0])
            open_ = new[~known[np.ix_(at, new)].all(axis=0)]
            if not len(open_):
                continue
            found = reach_people(some, own, points[open_], name=name, grip=grip, zone=zone, threads=threads)
            reached[np.ix_(at, open_)] |= found.reached
            known[np.ix_(at, open_)] = True
            _settle(points, open_, found.miss, (at, known))
    return reached


def _settle(points: Floats, asked: Ints, miss: Floats, what: tuple[Ints, Bools]) -> None:
    """Mark as known what lies within the miss of a point asked about: it is not reached."""
    at, known = what
    for k, m in enumerate(asked):
        if not np.any(miss[:, k] > 1e-3):
            continue
        gap = np.linalg.norm(points - points[m], axis=1)
        known[at] |= gap[None] < miss[:, k, None] - 1e-3


def part_points(environment: Environment, part: str, count: int) -> tuple[Floats, Floats]:
    """(M, 3) points [m] spread evenly over a part's surface, about `count` of them, and the normals (M, 3) there.

    Each triangle has its share of them by area, on a grid of low discrepancy (the R2 sequence of Roberts 2018): always
    the same ones. InputError for an unknown part.
    """
    rows = environment.polygons(environment.part(part))
    first, last = (int(environment.triangle_start[k]) for k in (rows.start, rows.stop))
    corner = environment.vertices[environment.triangles[first:last]]
    polygon = np.repeat(
        np.arange(rows.start, rows.stop), np.diff(environment.triangle_start[rows.start : rows.stop + 1])
    )
    one, two = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    area = 0.5 * np.linalg.norm(np.cross(one, two), axis=1)
    ends = np.cumsum(area)
    triangle = np.searchsorted(ends, (np.arange(count) + 0.5) * ends[-1] / count).clip(0, len(area) - 1)
    step = 1.0 / 1.32471795724474602596
    u, v = ((0.5 + np.arange(count) * f) % 1.0 for f in (step, step * step))
    out = u + v > 1.0
    u, v = np.where(out, 1.0 - u, u), np.where(out, 1.0 - v, v)
    point = corner[triangle, 0] + u[:, None] * one[triangle] + v[:, None] * two[triangle]
    return point, environment.normal[polygon[triangle]]


def _scattered(count: int) -> Ints:
    """The points in an order in which every beginning is spread over all of them: by van der Corput's numbers."""
    bits = max(1, int(np.ceil(np.log2(max(count, 2)))))
    value = sum(((np.arange(count) >> k) & 1) << (bits - 1 - k) for k in range(bits))
    return np.argsort(value, kind="stable")


def _flat(point: Floats, normal: Floats) -> Floats:
    """(M, 2) [m] the points to the right and up, as seen against the mean normal, from the first plane's middle."""
    facing = normal.mean(axis=0)
    if np.linalg.norm(facing) < 0.05:  # all around: by the thinnest side of the cloud
        facing = np.linalg.svd(point - point.mean(axis=0), full_matrices=False)[2][-1]
    facing = facing / np.linalg.norm(facing)
    up = np.array([0.0, 0.0, 1.0]) if abs(facing[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    right = np.cross(up, facing)
    right /= np.linalg.norm(right)
    arm = point - point.mean(axis=0)
    return np.stack([arm @ right, arm @ np.cross(facing, right)], axis=1)
