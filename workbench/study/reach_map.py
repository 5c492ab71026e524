"""The population reach map: for points all over a part's surface, the weighted share of people who
reach them.

Nobody solves for every point. Points are taken from coarse to fine, each the one farthest from all
before. Each person is asked about the first until none is farther than COARSE from one of them; of
the others only about those that are not surrounded by points which he reaches all, or misses all:
the edge of what he reaches is found to the last point, and only a patch smaller than COARSE far from
that edge could be overlooked.

A point beyond the length of the limb (see `posture.reach_bound`) needs no search.

Obstacles do not count: the map says how far arms are long enough and joints free enough.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from workbench.errors import UsageError
from workbench.geometry.sampling import even_places
from workbench.model.accommodation import MAP_POINTS, MapTask, ReachMap
from workbench.model.arrays import Bools, Floats, Ints, pieces
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.poses import Poses, row_for_each
from workbench.posture.reach_bound import reach_bound
from workbench.posture.reaching.limbs import HANDS, Limb, limb, limbs_there, tighter
from workbench.posture.reaching.reach import reach

__all__ = [
    "COARSE",
    "ReachObstacles",
    "farthest_point_order",
    "part_points",
    "reach_map",
    "who_reaches",
]

COARSE = 0.04
"""How far [m] a point may be from one that everybody is asked about."""
FINER = 3
"""How many times more points each turn knows of than the one before."""
AROUND = 2.0
"""A point is surrounded by those known that are nearer than so many times the distance that no
point is farther than from one of them."""
FEWEST = 3
"""How many known points surround another one at least."""
TOGETHER = 16_384
"""People and points that are asked about at a time, which bounds the memory."""


def reach_map(
    body: Body,
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
    """The share of B people, rows of a body and of poses, that reach points spread over a part.

    hand: "left" or "right", either where None; weights (B,): of the people, alike where None.
    InputError for an unknown part, UsageError where numbers do not fit.
    """
    if not len(poses):
        raise UsageError("poses: expected one row at least, got none")
    people = row_for_each(body, poses)
    least, most = MAP_POINTS
    if not least <= points <= most:
        raise UsageError(f"points: expected {least} to {most}, got {points}")
    if hand not in (None, "left", "right"):
        raise UsageError(f"hand is left or right, or None for either, got {hand!r}")
    weight = np.ones(len(poses)) if weights is None else np.asarray(weights, dtype=np.float64)
    if weight.shape != (len(poses),) or not np.all(weight >= 0) or not weight.sum() > 0:
        raise UsageError(f"weights are {len(poses)} numbers that are not negative, got {weights!r}")
    point, normal = part_points(environment, part, points)
    names = limbs_there(people, HANDS) if hand is None else (f"{hand} hand",)
    reached = np.zeros((len(poses), len(point)), dtype=np.bool_)
    for name in names:
        reached |= who_reaches(
            people, poses, point, name, grip=grip, zone=zone, settled=reached, threads=threads
        )
    task = MapTask(part, grip, zone, hand or "either", points)
    return ReachMap(task, point, normal, _flat(point, normal), weight @ reached / weight.sum())


@dataclass(frozen=True, eq=False)
class ReachObstacles:
    """What is in the way of B people: parts of an environment, of which some, by name, are displaced
    (B, 3) [m]."""

    environment: Environment
    moving_parts: tuple[str, ...]
    displacement: Floats


def who_reaches(
    body: Body,
    poses: Poses,
    points: Floats,
    name: str,
    *,
    grip: str,
    zone: int,
    settled: Bools | None = None,
    hopeless: Bools | None = None,
    obstacles: ReachObstacles | None = None,
    order: tuple[Ints, Floats] | None = None,
    coarse: float = COARSE,
    threads: int | None = None,
) -> Bools:
    """Tell which of some points each of B people reaches with a limb.

    Parameters
    ----------
    body, poses
        B rows of either.
    points
        (M, 3) [m].
    name, grip, zone
        As of `limb`.
    settled, hopeless
        (B, M) what is known to be reached, and to be missed: it is not asked again.
    obstacles
        What is in the way. Who finds no way about it from the posture that reaches without it
        counts as missing the point.
    order
        Of `farthest_point_order`, where the points are asked about more than once.
    coarse
        How far [m] a point may be from one that everybody is asked about; 0 asks about all.

    Returns
    -------
    (B, M) array
    """
    known = np.zeros((len(poses), len(points)), dtype=np.int8)  # 1 reached, -1 missed, 0 not known
    if hopeless is not None:
        known[hopeless] = -1
    if settled is not None:
        known[settled] = 1
    arms = _in_zones(body, limb(body, name, grip=grip, zone=zone))
    bounds = [reach_bound(body, poses, arm) for arm in arms]

    def ask(who: Ints, at: Ints) -> Bools:
        found = np.zeros(len(who), dtype=np.bool_)
        for arm, bound in zip(arms, bounds, strict=True):
            left = np.flatnonzero(~found)
            for piece in pieces(len(left), size=TOGETHER):
                some = left[piece]
                some = some[~bound.excludes(who[some], points[at[some]])]
                if not len(some):
                    continue
                if obstacles is not None:
                    found[some] = _clear(body, poses, arm, obstacles, who[some], points[at[some]])
                    continue
                each = Poses(
                    poses.rotations[who[some]],
                    poses.reference,
                    poses.world_from_reference[who[some]],
                    person=who[some],
                )
                target = points[at[some]][:, None]
                found[some] = reach(
                    body, each, target, limb=arm, thorough=False, threads=threads
                ).reached[:, 0]
        return found

    return _asked(points, order or farthest_point_order(points), known, ask, coarse)


def _clear(
    body: Body, poses: Poses, arm: Limb, obstacles: ReachObstacles, who: Ints, targets: Floats
) -> Bools:
    """(K,) whether people (K,) reach a target (K, 3) [m] each, clear of obstacles. One person at a
    time, so that what is packed of a body serves all targets."""
    found = np.zeros(len(who), dtype=np.bool_)
    for person in np.unique(who).tolist():
        rows = np.flatnonzero(who == person)
        one = np.array([person])
        alone = Poses(poses.rotations[one], poses.reference, poses.world_from_reference[one])
        found[rows] = reach(
            body[one],
            alone,
            targets[rows],
            limb=arm.rows(one),
            environment=obstacles.environment,
            moving_parts=obstacles.moving_parts,
            displacement=obstacles.displacement[one],
            brief=True,
        ).reached[0]
    return found


def _in_zones(body: Body, arm: Limb) -> list[Limb]:
    """A limb in its harness zone and in each tighter one, each to be asked by itself: what it misses
    in its own zone only matters in the next where that is not out of reach."""
    arms = []
    held: Limb | None = arm
    while held is not None:
        arms.append(replace(held, zone=1))  # else `reach` asks in the tighter zones too
        held = tighter(body, held)
    return arms


def _asked(
    points: Floats,
    order: tuple[Ints, Floats],
    known: NDArray[np.int8],
    ask: Callable[[Ints, Ints], Bools],
    coarse: float,
) -> Bools:
    """(B, M) who reaches which points: `ask` says it of some people (K,) for a point (K,) each.
    known (B, M): 1 reached, -1 missed, 0 not known; it is filled."""
    rows, far = order
    done = 0
    count = int(np.argmax(far <= coarse)) + 1 if far[-1] <= coarse else len(rows)
    while done < len(rows):
        old = rows[:done]
        new = rows[done:count]
        if done:
            near = (
                np.linalg.norm(points[old, None] - points[None, new], axis=2)
                < AROUND * far[done - 1]
            )
            votes = [
                (known[:, old] == kind).astype(np.float32) @ near.astype(np.float32)
                for kind in (1, -1)
            ]
            # one or two neighbours do not surround a point
            alike = np.where(votes[1] == 0, 1, np.where(votes[0] == 0, -1, 0))
            guess = np.where(votes[0] + votes[1] < FEWEST, 0, alike).astype(np.int8)
            known[:, new] = np.where(known[:, new] == 0, guess, known[:, new])
        who, at = np.nonzero(known[:, new] == 0)
        if len(who):
            known[who, new[at]] = np.where(ask(who, new[at]), 1, -1)
        done = count
        count = min(FINER * count, len(rows))
    return np.asarray(known == 1)


def farthest_point_order(points: Floats) -> tuple[Ints, Floats]:
    """The points (M, 3) in an order in which each is the farthest from all before (Gonzalez 1985),
    from the first; and (M,) [m] how far any point is at most from those up to it."""
    order = np.zeros(len(points), dtype=np.int64)
    far = np.zeros(len(points))
    gap = np.full(len(points), np.inf)
    for k in range(len(points)):
        order[k] = int(np.argmax(gap)) if k else 0
        gap = np.minimum(gap, np.sum((points - points[order[k]]) ** 2, axis=1))
        gap[order[k]] = -1.0  # points at one place all get their turn
        far[k] = np.sqrt(max(gap.max(), 0.0))
    return order, far


def part_points(environment: Environment, part: str, count: int) -> tuple[Floats, Floats]:
    """(M, 3) points [m] spread evenly over a part's surface, about `count` of them, and the normals
    (M, 3) there.

    Each triangle has its share of them by area, on a grid of low discrepancy (the R2 sequence of
    Roberts 2018): always the same ones. InputError for an unknown part.
    """
    rows = environment.polygons(environment.part_index(part))
    corner = environment.triangle_corners(environment.part_index(part))
    polygon = np.repeat(
        np.arange(rows.start, rows.stop),
        np.diff(environment.triangle_start[rows.start : rows.stop + 1]),
    )
    one = corner[:, 1] - corner[:, 0]
    two = corner[:, 2] - corner[:, 0]
    area = 0.5 * np.linalg.norm(np.cross(one, two), axis=1)
    ends = np.cumsum(area)
    triangle = np.searchsorted(ends, (np.arange(count) + 0.5) * ends[-1] / count).clip(
        0, len(area) - 1
    )
    u, v = even_places(count)
    point = corner[triangle, 0] + u[:, None] * one[triangle] + v[:, None] * two[triangle]
    return point, environment.normal[polygon[triangle]]


def _flat(point: Floats, normal: Floats) -> Floats:
    """(M, 2) [m] the points to the right and up, as seen against the mean normal, from the first
    plane's middle."""
    facing = normal.mean(axis=0)
    if np.linalg.norm(facing) < 0.05:  # all around: by the thinnest side of the cloud
        facing = np.linalg.svd(point - point.mean(axis=0), full_matrices=False)[2][-1]
    facing = facing / np.linalg.norm(facing)
    up = np.array([0.0, 0.0, 1.0]) if abs(facing[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    right = np.cross(up, facing)
    right /= np.linalg.norm(right)
    arm = point - point.mean(axis=0)
    return np.stack([arm @ right, arm @ np.cross(facing, right)], axis=1)
