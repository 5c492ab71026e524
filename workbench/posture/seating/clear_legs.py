"""Legs of seated people kept clear of what stands around: by the search of arms, along the freedoms
that a leg has with its foot on a pedal.

The ball of the foot stays where it is. At first the sole stays as it was predicted, and the knee
swings about the line from hip to ankle. Where that does not do, the foot turns on its ball, heel out
or in, and the heel is lower or higher.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.joint_angles import motion_of
from workbench.model.poses import Poses
from workbench.posture.kernels.clear_reach import KEPT, SKIPPED
from workbench.posture.reaching.heeding import as_posed, deep_in, heeding, in_oneself, swung_clear
from workbench.posture.reaching.limbs import limb
from workbench.posture.reaching.obstacles import ObstacleScene, avoid_obstacles
from workbench.posture.reaching.oneself import own_arms
from workbench.posture.reaching.reach_solver import (
    REACHED,
    TURN_LEVER,
    LimbTask,
    ReachSolution,
    discomfort_of,
    goals_of,
    joint_rotations,
    rows_of,
    solve_reaches,
    tips_of,
)
from workbench.posture.seating.driving_legs import HEEL_LIFT
from workbench.posture.seating.posture import pointed_foot

__all__ = ["ClearLegs", "clear_legs"]

TURNS = np.radians([0.0, 12.0, -12.0])
"""How far [rad] a foot turns on its ball, toes out and in: hip, knee and ankle together turn by 15,
10 and 10 degrees to either side in comfort (Dreyfuss 3D)."""
SWINGS = (0.0, 0.25, -0.25)
"""Abduction [rad] added to that of the hip where a search starts, so that it finds its way round
either side of what is in the way."""
HOPELESS = 0.05
"""[m] What a swing of the knee may leave violated for the foot to be moved: more is never made up."""
OUT_OF_THE_WAY = 1e3
"""How far [m] the seat is put aside, so that what is indexed for arms serves legs too."""
SOLES = 2
"""Of how many soles, those with which the leg is least deep in something, such searches start."""


@dataclass(frozen=True, eq=False)
class ClearLegs:
    """Legs of B people, clear of what stands around where that was found.

    Parameters
    ----------
    poses
        (B,) their postures.
    overlap
        (B,) [m] by foot: how much deeper the leg is in a part than allowed, and no posture clear of
        it was found.
    part
        (B,) by foot: that part, -1 where there is none.
    """

    poses: Poses
    overlap: Mapping[str, Floats]
    part: Mapping[str, Ints]


def clear_legs(
    body: Body,
    poses: Poses,
    environment: Environment,
    pitches: Mapping[str, Floats | None],
    *,
    sat_on: Sequence[str] = (),
    arms: bool = False,
) -> ClearLegs:
    """Keep the legs of people with their feet on pedals clear of an environment.

    A leg that overlaps nothing by more than is allowed stays as it is, bit for bit. So does one of
    which no clear posture is found. Nor is a posture clear that enters the other leg, or another
    segment of the own body but the arms, deeper than the one before and than the body allows. Where
    the arms count, legs give way to them as they do to parts: the knees part.

    Parameters
    ----------
    body, poses
        B people, a pose of each row of the body.
    environment
        What stands around.
    pitches
        (B, 2) [rad] by foot: above the horizontal, what else the sole may have than it has. None
        where the heel may be lifted by `HEEL_LIFT`.
    sat_on
        Parts that are not looked at: a thigh presses a cushion down, it does not stop there.
    arms
        Whether the own arms are obstacles too, where the poses have them; `part` counts them beyond
        the parts.
    """
    seat = np.isin(environment.parts, list(sat_on)).astype(np.int64)
    own = own_arms(body, poses) if arms else None
    room = ObstacleScene(environment, seat, np.full((len(body), 3), OUT_OF_THE_WAY), own=own)
    rotations = np.array(poses.rotations)
    overlap: dict[str, Floats] = {}
    part: dict[str, Ints] = {}
    moved = np.zeros((len(pitches), len(body)), dtype=np.bool_)
    for k, (foot, other) in enumerate(pitches.items()):
        task, angles = as_posed(body, poses, pointed_foot(body, foot))
        at = tips_of(task, angles)
        task = replace(task, goal=_goals(at[:, :3], at[:, 3:]))
        found = deep_in(task, angles, room)
        overlap[foot] = np.where(found.part >= 0, found.overlap, 0.0)
        part[foot] = np.where(overlap[foot] > 0.0, found.part, -1)
        deep = np.flatnonzero(overlap[foot] > 0.0)
        if len(deep):
            rows, best = _clear(task, angles, deep, other, room)
            mine = replace(rows_of(task, rows), held=rotations[rows])
            rotations[rows] = joint_rotations(mine, best)
            moved[k, rows] = True
    cleared_poses = replace(poses, rotations=rotations)
    both = np.flatnonzero(moved.all(axis=0) & (len(moved) > 1))
    if len(both):
        # neither leg is the first: where each is clear of the other as it was, and not as it is now,
        # both stay, so that mirrored people are mirrored
        chain = pointed_foot(body, next(iter(pitches)))
        (was, then), (task, now) = (as_posed(body, one, chain) for one in (poses, cleared_poses))

        def before(legs: Ints) -> Floats:
            return in_oneself(rows_of(was, both[legs]), then[both[legs]])

        fine = heeding(rows_of(task, both), now[both], moved[0, both], before)
        moved[:, both] = fine
        rotations[both[~fine]] = poses.rotations[both[~fine]]
    for k, foot in enumerate(pitches):
        overlap[foot][moved[k]] = 0.0
        part[foot][moved[k]] = -1
    return ClearLegs(replace(poses, rotations=rotations), overlap, part)


def _goals(ball: Floats, sole: Floats) -> Floats:
    """(P, 12) goals of feet with their balls at points (P, 3) [m] and soles in directions (P, 3)."""
    goal = goals_of(ball)
    goal[:, 3:6] = sole
    goal[:, 9:] = TURN_LEVER
    return goal


def _soles(task: LimbTask, other: Floats | None) -> Floats:
    """(B, V, 3) directions that soles may have, from heel to ball: the first as it is, then the foot
    turned, then with other pitches, turned or not."""
    sole = task.goal[:, 3:6]
    if other is None:
        foot = task.limb.name.split(", ")[0]
        length = np.linalg.norm(task.limb.tip - limb(task.body, foot, grip="heel").tip, axis=1)
        lifted = np.outer(HEEL_LIFT / length, [0.5, 1.0])
        other = np.arcsin(np.maximum(sole[:, 2:] - lifted, -1.0))
    side = 1.0 if task.limb.name.startswith("left") else -1.0
    level = np.hypot(sole[:, 0], sole[:, 1])
    pitch = np.column_stack([np.arctan2(sole[:, 2], level), other])[:, :, None]
    turn = np.arctan2(sole[:, 1], sole[:, 0])[:, None, None] + side * TURNS
    across = np.cos(pitch)
    parts = across * np.cos(turn), across * np.sin(turn), np.sin(pitch)
    found = np.stack(np.broadcast_arrays(*parts), axis=-1).reshape(len(sole), -1, 3)
    found[:, 0] = sole
    return found


def _clear(
    task: LimbTask, angles: Floats, rows: Ints, other: Floats | None, room: ObstacleScene
) -> tuple[Ints, Floats]:
    """Of some rows (N,) of a task, whose soles may have other pitches (B, Q), those that a clear
    posture was found of, and its angles (M, K, 3)."""
    own = rows_of(task, rows)

    def before(legs: Ints) -> Floats:
        some, each = np.unique(legs, return_inverse=True)
        return in_oneself(rows_of(own, some), angles[rows[some]])[each]

    found, doubt = swung_clear(own, angles[rows], room)
    best = found.angles
    clear = heeding(own, best, doubt < KEPT, before)
    # of those that are BURIED it is proved that there is none
    hopeful = (doubt < KEPT) | ((doubt == KEPT) & (found.numbers[:, 1] <= HOPELESS))
    left = np.flatnonzero(~clear & hopeful)
    if len(left):
        soles = _soles(task, other)[rows[left]]
        turned, level = _turned(own, angles[rows], left, soles, room)
        lack = level.overlap + np.where(level.numbers[:, 0] > REACHED, level.numbers[:, 0], 0.0)
        whose = np.repeat(left, soles.shape[1])
        good = heeding(turned, level.angles, lack <= 0.0, lambda legs: before(whose[legs]))
        clear[left] = _take(best, left, turned, level.angles, good)
        lack = lack.reshape(len(left), -1)[~clear[left]]
        least = np.argsort(lack, axis=1, kind="stable")[:, :SOLES]
        at = (soles.shape[1] * np.flatnonzero(~clear[left])[:, None] + least).ravel()
        left = left[~clear[left]]
    if len(left):
        at = np.repeat(at, len(SWINGS))
        swung = rows_of(turned, at)
        axis, sign = motion_of(task.body, task.joints[0], "abduction")
        starts = level.angles[at]
        starts[:, 0, axis] += sign * np.tile(SWINGS, len(at) // len(SWINGS))
        found, doubt = swung_clear(swung, starts, room)
        good = heeding(swung, found.angles, doubt < KEPT, lambda legs: before(whose[at[legs]]))
        clear[left] = _take(best, left, swung, found.angles, good)
    return rows[clear], best[clear]


def _turned(
    task: LimbTask, angles: Floats, rows: Ints, soles: Floats, room: ObstacleScene
) -> tuple[LimbTask, ReachSolution]:
    """Some rows (N,) of a task with angles (B, K, 3), each with soles in directions (N, V, 3): what
    that comes to obstacles aside, and how deep it is in these."""
    each = np.repeat(rows, soles.shape[1])
    goal = _goals(task.goal[each, :3], soles.reshape(-1, 3))
    turned = replace(rows_of(task, each), goal=goal)
    return turned, avoid_obstacles(
        turned, solve_reaches(turned, angles[each], 0), room, effort=SKIPPED
    )[0]


def _take(best: Floats, rows: Ints, task: LimbTask, angles: Floats, clear: Bools) -> Bools:
    """Put the most comfortable of the clear postures of rows (N,), as many of a task for each, into
    best (B, K, 3); returns which have one."""
    cost = np.where(clear, discomfort_of(task, angles), np.inf).reshape(len(rows), -1)
    at = cost.argmin(axis=1)
    found = np.isfinite(cost.min(axis=1))
    some = angles.reshape(len(rows), -1, *angles.shape[1:])
    best[rows[found]] = some[np.flatnonzero(found), at[found]]
    return np.asarray(found)
