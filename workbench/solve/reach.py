"""Reach: the most comfortable posture that brings a hand or foot to a target, within the joint stops and clear of
obstacles; or how far it is missed and what limits it.

Obstacles are met in rounds: what a posture touches beyond what is allowed becomes planes that its spheres must stay
behind, and the posture is solved again from where it stands; where that leads nowhere, from other postures, always
the same ones in the same order.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import UsageError
from workbench.kernels.inverse import breaches, solve_chains, tips
from workbench.kernels.limits import Planes
from workbench.kernels.linkage import Linkage
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.poses import Poses
from workbench.model.posing import angles_of, compose
from workbench.model.reach import Reach
from workbench.solve.collide import contacts
from workbench.solve.forward import place
from workbench.solve.limbs import Limb
from workbench.solve.linkage import joints_between, linkage
from workbench.solve.stops import stops

__all__ = ["REACHED", "reach"]

REACHED = 1e-4
"""A target is reached where the tip is this near to it [m]."""
TURN_LEVER = 0.2
"""What a radian between wanted and actual direction counts [m]."""
STEPS, AGAIN, SEEDS = 90, 12, 128
ROUNDS, FRESH, MOST_PLANES, WALK = 8, 6, 48, 24
CLEAR = 2e-4
"""How far [m] beyond what is allowed a posture is kept off obstacles, so that rounding does not touch them."""
SLACK = 0.03
"""A stop that gives less than this [m/rad] is not what limits a reach."""
_NO_PLANES = Planes(np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))


@dataclass(frozen=True, eq=False)
class _Task:
    """One limb of a body reaching for P targets: its chain, base (P, 3, 4), goal (P, 12)."""

    body: Body
    limb: Limb
    link: Linkage
    joints: list[int]
    poses: Poses
    base: Floats
    goal: Floats


@dataclass(frozen=True, eq=False)
class _Found:
    """Angles (P, K, 3), numbers (P, 8) as the kernel gives them, overlap (P,) [m], part (P,) that is entered deepest
    or holds the limb, -1 where none."""

    angles: Floats
    numbers: Floats
    overlap: Floats
    part: Ints


def reach(
    body: Body,
    poses: Poses,
    targets: ArrayLike,
    *,
    limb: Limb,
    direction: ArrayLike | None = None,
    environment: Environment | None = None,
    start: Poses | None = None,
    tries: int = AGAIN,
) -> Reach:
    """Reach for targets (P, 3) [m] from poses of the same number, or from one pose for all.

    What the limb does not move stays as the poses have it. direction (3,) or (P, 3): the way the limb is to point on
    arrival, any where None. environment: obstacles, with their allowances. start: postures near to the solutions,
    which then is quicker; from the comfort modes where None. tries: from how many other postures to begin again where
    a target is missed. UsageError where the numbers of rows do not fit.
    """
    task = _task(body, poses, np.atleast_2d(np.asarray(targets, dtype=np.float64)), limb, direction)
    angles = angles_of(body, task.poses)[:, task.joints]
    free = (slice(None), task.link.free_joint, task.link.free_axis)
    angles[free] = task.link.mode if start is None else angles_of(body, start)[:, task.joints][free]
    found = _solve(task, angles, tries)
    if environment is not None:
        found = _clear(task, found, environment)
    return _answer(task, found, environment)


def _task(body: Body, poses: Poses, targets: Floats, limb: Limb, direction: ArrayLike | None) -> _Task:
    if targets.ndim != 2 or targets.shape[1] != 3 or not np.all(np.isfinite(targets)):
        raise UsageError(f"targets are finite points (P, 3), got an array of shape {targets.shape}")
    if len(poses) not in (1, len(targets)):
        raise UsageError(f"{len(targets)} targets need one pose or {len(targets)}, got {len(poses)}")
    base = place(body, poses, window=[body.segments[limb.base]]).world_from_segment[:, limb.base]
    rotations = poses.rotations
    if len(poses) != len(targets):
        base, rotations = (np.repeat(array, len(targets), axis=0) for array in (base, rotations))
    goal = np.zeros((len(targets), 12))
    goal[:, :3], goal[:, 6:9] = targets, 1.0
    if direction is not None:
        way = np.broadcast_to(np.asarray(direction, dtype=np.float64), targets.shape)
        size = np.linalg.norm(way, axis=1, keepdims=True)
        if not np.all(size > 1e-9):
            raise UsageError("a direction is a vector (3,) or (P, 3) that has a length")
        goal[:, 3:6], goal[:, 9:] = way / size, TURN_LEVER
    held = Poses(rotations, limb.base, base)
    # arrays of one kind only: each new kind would have the kernel compiled again
    return _Task(body, limb, _chain(body, limb), joints_between(body, limb.base, limb.end), held, np.array(base), goal)


@lru_cache(maxsize=64)
def _chain(body: Body, limb: Limb) -> Linkage:
    return linkage(body, (limb.base, limb.end), limb.free, (limb.tip, limb.pointing))


@lru_cache(maxsize=64)
def _seeds(body: Body, limb: Limb) -> tuple[Floats, Floats]:
    """Legal angles (M, K, 3) spread over the chain's range, and where they bring tip and direction (M, 6) in the frame
    of the held segment; the same ones each time."""
    link, joints = _chain(body, limb), joints_between(body, limb.base, limb.end)
    limits = body.stops.limits[joints]
    share = np.random.default_rng(1).uniform(size=(4 * SEEDS, len(joints), 3))
    angles = np.where(link.free_of >= 0, -limits[..., 1] + share * limits.sum(axis=-1), 0.0)
    swing = np.linalg.norm(angles[..., :2], axis=-1, keepdims=True)
    angles[..., :2] *= np.minimum(1.0, 3.0 / np.maximum(swing, 1e-9))
    breach = np.zeros(len(angles))
    breaches(link, _NO_PLANES, angles, breach)
    # the legal ones first, then the least wrong: a start need not be legal
    order = np.argsort(breach, kind="stable")[:SEEDS]
    angles, at = np.ascontiguousarray(angles[order]), np.zeros((SEEDS, 6))
    tips(
        link, np.zeros(SEEDS, np.int64), np.ascontiguousarray(np.broadcast_to(np.eye(3, 4), (SEEDS, 3, 4))), angles, at
    )
    return angles, at


def _solve(task: _Task, start: Floats, again: int, planes: list[Floats] | None = None) -> _Found:
    """Solve all rows from their start angles (P, K, 3), again from `again` other postures where a row fails."""
    angles, numbers = np.array(start), np.zeros((len(start), 8))
    rows = planes or [np.zeros((0, 8))] * len(start)
    packed = np.concatenate(rows)
    first = np.concatenate([[0], np.cumsum([len(row) for row in rows])]).astype(np.int64)
    point, normal = np.ascontiguousarray(packed[:, 1:4]), np.ascontiguousarray(packed[:, 4:7])
    walls = Planes(packed[:, 0].astype(np.int64), point, normal, np.ascontiguousarray(packed[:, 7]))
    settings = (STEPS, *_seeds(task.body, task.limb), again)
    held, alone = np.zeros((len(start), 6 + len(task.link.rows))), np.full(len(start), -1)
    out, problem = (angles, numbers, held), (task.base, task.goal)
    solve_chains(task.link, np.zeros_like(alone), problem, (walls, first), settings, out, alone, 0, len(start))
    return _Found(angles, numbers, np.zeros(len(angles)), np.full(len(angles), -1))


def _clear(task: _Task, found: _Found, environment: Environment) -> _Found:
    """The same reaches kept off obstacles."""
    best = _rounds(task, found, environment)
    left = _unsettled(best, found)
    if not len(left):
        return best
    seeds, order = _clear_seeds(task, environment)
    free = (slice(None), task.link.free_joint, task.link.free_axis)
    for attempt in range(min(FRESH, order.shape[1])):
        start = found.angles[left].copy()
        start[free] = seeds[order[left, attempt]][free]
        rows = _rows(task, left)
        best = _better(best, _rounds(rows, _solve(rows, start, 0), environment), left)
        left = _unsettled(best, found)
        if not len(left):
            break
    left = np.flatnonzero(best.overlap > 0)
    if not len(left):
        return best
    walked = _walked(_rows(task, left), (seeds[order[left, 0]], best.angles[left]), environment)
    return _better(best, _part_of(walked, best, left), left)


def _part_of(walked: _Found, best: _Found, rows: Ints) -> _Found:
    """What was walked, limited by what the way's end is in."""
    return _Found(walked.angles, walked.numbers, walked.overlap, best.part[rows])


def _walked(task: _Task, ways: tuple[Floats, Floats], environment: Environment) -> _Found:
    """The last clear posture on the way from one posture (P, K, 3), which is clear, to another, which is not."""
    begin, end = (angles.copy() for angles in ways)
    free = (slice(None), task.link.free_joint, task.link.free_axis)
    one, two = begin[free], end[free]
    begin[...] = end
    count = len(one)
    clear, good = np.ones(count, np.bool_), one.copy()
    overlap = np.zeros(count)
    for step in range(WALK + 1):
        begin[free] = one + (two - one) * (step / WALK)
        entered, _, _ = _touched(task, begin, environment)
        legal = stops(task.body, _posed(task, begin)).margin[:, list(task.limb.free)].min(axis=1) > -1e-3
        if step == 0:
            overlap = entered
        clear &= (entered <= 0) & legal
        good[clear] = begin[free][clear]
    begin[free] = good
    at, numbers = np.zeros((count, 6)), np.zeros((count, 8))
    tips(task.link, np.zeros(count, np.int64), task.base, begin, at)
    numbers[:, 0] = np.linalg.norm(task.goal[:, 6:] * (task.goal[:, :6] - at), axis=1)
    return _Found(begin, numbers, overlap, np.full(count, -1))


def _unsettled(best: _Found, free: _Found) -> Ints:
    """Rows that enter obstacles, or miss a target that would be reached without them."""
    return np.flatnonzero((best.overlap > 0) | ((best.numbers[:, 0] > REACHED) & (free.numbers[:, 0] <= REACHED)))


def _clear_seeds(task: _Task, environment: Environment) -> tuple[Floats, Ints]:
    """The postures to begin again from that enter no obstacle (all, where none does), and their numbers (P, M) for
    each row, nearest to its target first."""
    seeds, at = _seeds(task.body, task.limb)
    trial = _rows(task, np.zeros(len(seeds), np.int64))
    overlap, _, _ = _touched(trial, seeds, environment)
    clear = overlap <= 0 if np.any(overlap <= 0) else np.ones(len(seeds), np.bool_)
    local = np.einsum("pji,pj->pi", task.base[:, :, :3], task.goal[:, :3] - task.base[:, :, 3])
    gap = np.linalg.norm(local[:, None] - at[None, clear, :3], axis=-1)
    return seeds[clear], np.argsort(gap, axis=1, kind="stable")


def _rounds(task: _Task, found: _Found, environment: Environment) -> _Found:
    """Planes from what is touched, and solve again from there, until nothing is touched or the rounds are over."""
    best, current = found, found
    planes = [np.zeros((0, 8))] * len(found.angles)
    parts: list[Ints] = [np.zeros(0, np.int64)] * len(found.angles)
    left = np.arange(len(found.angles))
    for turn in range(ROUNDS + 1):
        rows = _rows(task, left)
        overlap, near, touched = _touched(rows, current.angles, environment)
        held = np.where((current.numbers[:, 7] > 0) & (current.numbers[:, 3] < 0), current.numbers[:, 4], -1)
        part = np.array([parts[p][int(h)] if h >= 0 else -1 for p, h in zip(left, held, strict=True)], dtype=np.int64)
        deepest = np.array([t[0] if len(t) else -1 for t in touched], dtype=np.int64)
        current = _Found(current.angles, current.numbers, overlap, np.where(overlap > 0, deepest, part))
        best = current if turn == 0 else _better(best, current, left)
        hit = np.flatnonzero(overlap > 0)
        if not len(hit) or turn == ROUNDS:
            return best
        for row in hit:
            p = left[row]
            planes[p] = np.concatenate([near[row], planes[p]])[:MOST_PLANES]
            parts[p] = np.concatenate([touched[row], parts[p]])[:MOST_PLANES]
        left = left[hit]
        current = _solve(_rows(task, left), current.angles[hit], 0, [planes[p] for p in left])
    return best


def _touched(task: _Task, angles: Floats, environment: Environment) -> tuple[Floats, list[Floats], list[Ints]]:
    """Overlap (P,) [m] beyond what is allowed, and for each row its planes (Q, 8) (link, point, normal, offset) with
    their parts, deepest first."""
    body, limb = task.body, task.limb
    placed = place(body, _posed(task, angles), window=[body.segments[n] for n in limb.moving])
    met = contacts(placed, environment, margin=CLEAR)
    links = {segment: k + 1 for k, segment in enumerate(joint + 1 for joint in task.joints)}
    met = met.rows(limb.solid[met.sphere] & (met.excess > -CLEAR))
    overlap, planes, parts = np.zeros(len(angles)), [], []
    np.maximum.at(overlap, met.pose, np.where(met.excess > 0, met.excess, 0.0))
    order = np.lexsort((met.sphere, -met.excess, met.pose))
    met = met.rows(order)
    # what hangs on the chain without being in it (the head) goes with the last link before it
    link = np.array([links.get(int(n), links.get(int(body.parent[n]), 0)) for n in range(len(body.segments))])
    for segment in sorted(set(limb.moving) - set(links)):
        link[segment] = link[body.parent[segment]]
    carrier = np.array([1 + task.joints[max(k - 1, 0)] for k in link])[met.segment]
    world = placed.world_from_segment[met.pose, carrier]
    centre = placed.centres[met.pose, met.sphere]
    point = np.einsum("cji,cj->ci", world[..., :3], centre - world[..., 3])
    offset = np.sum(met.normal * met.point, axis=1) + body.radius[met.sphere] - met.allowed + 2 * CLEAR
    table = np.concatenate([link[met.segment][:, None], point, met.normal, offset[:, None]], axis=1)
    bounds = np.searchsorted(met.pose, np.arange(len(angles) + 1))
    for a, b in pairwise(bounds):
        planes.append(table[a : min(b, a + MOST_PLANES // 3)])
        parts.append(met.part[a : min(b, a + MOST_PLANES // 3)])
    return overlap, planes, parts


def _better(best: _Found, other: _Found, rows: Ints) -> _Found:
    """Take the other's rows where they are clear and these are not, or where miss and overlap together are less."""
    one, two = best.overlap[rows], other.overlap
    less = other.numbers[:, 0] + 2.0 * two < best.numbers[rows, 0] + 2.0 * one - 1e-9
    take = ((two > 0) == (one > 0)) & less | ((two <= 0) & (one > 0))
    chosen = rows[take]
    angles, numbers, overlap, part = best.angles.copy(), best.numbers.copy(), best.overlap.copy(), best.part.copy()
    angles[chosen], numbers[chosen] = other.angles[take], other.numbers[take]
    overlap[chosen], part[chosen] = other.overlap[take], other.part[take]
    return _Found(angles, numbers, overlap, part)


def _rows(task: _Task, rows: Ints | Bools) -> _Task:
    held = Poses(task.poses.rotations[rows], task.poses.reference, task.poses.world_from_reference[rows])
    return _Task(task.body, task.limb, task.link, task.joints, held, task.base[rows], task.goal[rows])


def _posed(task: _Task, angles: Floats) -> Poses:
    """The poses with the chain's joints at these angles (P, K, 3)."""
    every = angles_of(task.body, task.poses)
    every[:, task.joints] = angles
    rotations = task.poses.rotations.copy()
    free = [j for j in task.joints if j in task.limb.free]
    rotations[:, free] = compose(task.body, every)[:, free]
    return Poses(rotations, task.limb.base, task.base)


def _answer(task: _Task, found: _Found, environment: Environment | None) -> Reach:
    link, numbers = task.link, found.numbers
    at = np.zeros((len(found.angles), 6))
    tips(link, np.zeros(len(at), np.int64), task.base, found.angles, at)
    off = found.angles[:, link.free_joint, link.free_axis] - link.mode
    reached = (numbers[:, 0] <= REACHED) & (found.overlap <= 0)
    stopped = ~reached & (found.part < 0) & (numbers[:, 7] > 0) & (numbers[:, 3] >= 0) & (numbers[:, 6] > SLACK)
    joint = np.array(task.joints)[numbers[:, 3].astype(np.int64)]
    return Reach(
        body=task.body,
        limb=task.limb.name,
        poses=_posed(task, found.angles),
        target=task.goal[:, :3],
        tip=at[:, :3],
        reached=reached,
        miss=np.linalg.norm(at[:, :3] - task.goal[:, :3], axis=1),
        overlap=found.overlap,
        discomfort=np.sum(link.weight * off * off, axis=1),
        joint=np.where(stopped, joint, -1),
        axis=np.where(stopped, numbers[:, 4], -1).astype(np.int64),
        side=np.where(stopped, numbers[:, 5], -1).astype(np.int64),
        part=np.where(reached, -1, found.part),
        parts=environment.parts if environment is not None else (),
    )
