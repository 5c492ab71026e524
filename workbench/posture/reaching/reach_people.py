"""Reaches of many people at once: one limb of the B rows of a body, each to its T targets.

People are taken in the order of how far they must stretch for a target, so that each can follow the
one before: his solution and its multipliers are a start that mostly needs three steps. The first of
every PIECE of them starts from the comfort modes, as a single reach does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from workbench.body.forward import segment_frames
from workbench.errors import UsageError
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.people_reach import PeopleReach
from workbench.model.poses import Poses, row_for_each
from workbench.model.posing import angles_of
from workbench.posture.reaching.chains import (
    AGAIN,
    PIECE,
    Found,
    Task,
    cold,
    posed,
    rows_of,
    solved,
    tips_of,
)
from workbench.posture.reaching.limbs import HANDS, Limb, limb
from workbench.posture.reaching.linkage import joints_between
from workbench.posture.reaching.obstacles import Room, cleared
from workbench.posture.reaching.outward import outward
from workbench.posture.reaching.packing import packed_links
from workbench.posture.reaching.reach import REACHED, goals_of, stopped_by

__all__ = ["reach_people"]

MOST_PEOPLE = 512
"""People packed at a time."""
MOST_SPARE = 1.0
"""[m] No limb reaches farther beyond a target that it reaches."""


@dataclass(frozen=True, eq=False)
class _Rows:
    """The rows of the kernels: order (B T,) target by target, in each by how far people must
    stretch; follow (B T,): the row whose solution each starts from, -1 where none; shoulder (B, 3)
    [m]."""

    order: Ints
    follow: Ints
    shoulder: Floats


@dataclass(frozen=True, eq=False)
class _Ask:
    """What is asked of everybody: limb, grip, zone; environment and the parts that move; spare [m];
    threads."""

    limb: tuple[str, str | None, int]
    environment: Environment | None
    moves: Sequence[str]
    spare: float
    rotations: bool
    threads: int | None


def reach_people(
    body: Body,
    poses: Poses,
    targets: ArrayLike,
    *,
    name: str,
    grip: str | None = None,
    zone: int = 1,
    environment: Environment | None = None,
    moves: Sequence[str] = (),
    shift: ArrayLike | None = None,
    spare: float = 0.0,
    rotations: bool = False,
    threads: int | None = None,
) -> PeopleReach:
    """Reach with a limb of B people, a row of poses each, for targets (T, 3) or (B, T, 3) [m].

    body: its row for each of the poses is the person's. name, grip, zone: as for `limb`. environment: obstacles, with their allowances; moves:
    its parts that have gone along with each person's seat by shift (B, 3) [m]. spare [m]: how far
    beyond a reached target to look for the farthest point that the limb still reaches, on the ray
    from its first joint (shoulder, hip) as it stands in the poses; to within 1 mm, obstacles aside.
    rotations: whether to give the postures found. threads: all cores where None; the answer does
    not depend on it. A posture may depend slightly on the other people, because each solution
    starts from a neighbour's; who is kept from a target by obstacles does not, because everybody in
    doubt is solved alone. UsageError where numbers of rows do not fit.
    """
    people = row_for_each(body, poses)
    goals = _targets(poses, targets)
    moved_by = np.zeros((len(poses), 3)) if shift is None else np.asarray(shift, dtype=np.float64)
    if moved_by.shape != (len(poses), 3):
        raise UsageError(
            f"shift: expected ({len(poses)}, 3) for {len(poses)} people, got {moved_by.shape}"
        )
    if not 0 <= spare <= MOST_SPARE:
        raise UsageError(f"spare: expected 0 to {MOST_SPARE:g} m, got {spare:g}")
    ask = _Ask((name, grip, zone), environment, moves, spare, rotations, threads)
    answers = []
    for first in range(0, len(poses), MOST_PEOPLE):
        some = slice(first, first + MOST_PEOPLE)
        own = Poses(poses.rotations[some], poses.reference, poses.world_from_reference[some])
        answers.append(_some_people(people[some], own, goals[some], moved_by[some], ask))
    return answers[0] if len(answers) == 1 else _joined(answers)


def _targets(poses: Poses, targets: ArrayLike) -> Floats:
    """Targets (B, T, 3); UsageError where the numbers of rows do not fit."""
    goals = np.asarray(targets, dtype=np.float64)
    if not len(poses):
        raise UsageError("poses: expected one row at least, got none")
    if goals.ndim == 2:
        goals = np.broadcast_to(goals, (len(poses), *goals.shape))
    if (
        goals.ndim != 3
        or goals.shape[0] != len(poses)
        or goals.shape[2] != 3
        or not np.all(np.isfinite(goals))
    ):
        raise UsageError(
            f"targets: expected finite points (T, 3) or (B, T, 3), got an array {np.shape(targets)}"
        )
    return goals


def _some_people(body: Body, poses: Poses, goals: Floats, shift: Floats, ask: _Ask) -> PeopleReach:
    name, grip, zone = ask.limb
    chain = limb(body, name, grip=grip, zone=zone)
    rows = _rows(body, poses, chain, goals)
    people, count = goals.shape[:2]
    who = rows.order % people
    joints = joints_between(body, chain.base, chain.end)
    base = segment_frames(body, poses, chain.base)
    link = packed_links(body, chain)
    goal = goals_of(goals.transpose(1, 0, 2).reshape(-1, 3)[rows.order])
    task = Task(body, chain, link, joints, who, poses.rotations[who], base[who], goal)
    start = cold(task, angles_of(body, poses)[who][:, joints])
    free = solved(task, start, AGAIN, follow=rows.follow, threads=ask.threads)
    found = free
    if ask.environment is not None:
        moving = np.isin(ask.environment.parts, list(ask.moves)).astype(np.int64)
        room = Room(ask.environment, moving, shift, ask.threads)
        found = cleared(task, free, room, anew=True)
    reached = (found.numbers[:, 0] <= REACHED) & (found.overlap <= 0)
    spare = _spare(task, found, reached, rows, ask)
    return _answer((task, found, reached), spare, rows.order, (people, count), ask)


def _rows(body: Body, poses: Poses, chain: Limb, goals: Floats) -> _Rows:
    joint = body.joint(
        body.segments[chain.end][0] + ("S" if chain.name.split(",")[0] in HANDS else "H")
    )
    world = segment_frames(body, poses, joint + 1)
    shoulder = (
        np.einsum("bij,bj->bi", world[:, :, :3], body.joint_in_child[:, joint]) + world[:, :, 3]
    )
    beyond = range(joint + 1, chain.end)
    length = sum(
        np.linalg.norm(body.joint_in_parent[:, j] - body.joint_in_child[:, j - 1], axis=1)
        for j in beyond
    )
    stretch = np.linalg.norm(goals - shoulder[:, None], axis=2) / np.maximum(length, 1e-6)[:, None]
    people, count = goals.shape[:2]
    order = (np.argsort(stretch, axis=0, kind="stable") + people * np.arange(count)).T.ravel()
    place = np.arange(people * count)
    follow = np.where((place % people == 0) | (place % PIECE == 0), -1, place - 1)
    return _Rows(order, follow, shoulder)


def _spare(task: Task, found: Found, reached: Bools, rows: _Rows, ask: _Ask) -> Floats:
    """(P,) [m] how much farther out the limb reaches than where it does."""
    spare = np.zeros(len(task))
    at = np.flatnonzero(reached) if ask.spare > 0 else np.zeros(0, np.int64)
    if len(at):
        some = rows_of(task, at)
        ways = some.goal[:, :3] - rows.shoulder[some.who]
        alike = rows.order[at] // len(rows.shoulder)
        spare[at] = outward(some, found.rows(at), ways, alike, most=ask.spare, threads=ask.threads)
    return spare


def _answer(
    solution: tuple[Task, Found, Bools],
    spare: Floats,
    order: Ints,
    shape: tuple[int, int],
    ask: _Ask,
) -> PeopleReach:
    """The rows back in their places (B, T)."""
    task, found, reached = solution
    people, count = shape
    back = np.empty(len(order), dtype=np.int64)
    back[order] = np.arange(len(order))
    place = back.reshape(count, people).T
    off = found.angles[:, task.link.free_joint, task.link.free_axis] - task.link.mode
    gap = np.linalg.norm(tips_of(task, found.angles)[:, :3] - task.goal[:, :3], axis=1)
    joint, axis, side = (
        values.astype(np.int64)[place] for values in stopped_by(task, found, reached)
    )
    return PeopleReach(
        body=task.body,
        limb=task.limb.name,
        target=task.goal[place, :3],
        reached=reached[place],
        miss=gap[place],
        overlap=found.overlap[place],
        discomfort=np.sum(task.link.weight * off * off, axis=1)[place],
        joint=joint,
        axis=axis,
        side=side,
        part=np.where(reached, -1, found.part)[place],
        spare=spare[place],
        parts=ask.environment.parts if ask.environment is not None else (),
        rotations=posed(task, found.angles)[place] if ask.rotations else None,
    )


def _joined(answers: Sequence[PeopleReach]) -> PeopleReach:
    def whole(name: str) -> Any:
        return np.concatenate([getattr(answer, name) for answer in answers])

    return replace(
        answers[0],
        target=whole("target"),
        reached=whole("reached"),
        miss=whole("miss"),
        overlap=whole("overlap"),
        discomfort=whole("discomfort"),
        joint=whole("joint"),
        axis=whole("axis"),
        side=whole("side"),
        part=whole("part"),
        spare=whole("spare"),
        rotations=whole("rotations") if answers[0].rotations is not None else None,
    )
