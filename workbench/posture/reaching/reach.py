"""Reach: the most comfortable posture that brings a hand or foot to a target, within the joint
stops and clear of obstacles; or how far it is missed and what limits it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from workbench.body.forward import segment_frames
from workbench.errors import UsageError
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.bystander import Bystander
from workbench.model.environment import Environment
from workbench.model.joint_angles import angles_of
from workbench.model.poses import Poses, check_joints, people_of
from workbench.model.reach import Reach, join_reaches
from workbench.posture.kernels.clear_reach import BRIEF, BURIED, PRECISE, WHOLE
from workbench.posture.reaching.guides import Guides, Guiding, guides_of
from workbench.posture.reaching.heeding import deep_in, in_own_body
from workbench.posture.reaching.history import Recall
from workbench.posture.reaching.limbs import Limb, moves_arm_alone, tighter
from workbench.posture.reaching.linkage import joints_between
from workbench.posture.reaching.nearer import (
    asked_again,
    missed_by_obstacles,
    targets_aside,
)
from workbench.posture.reaching.obstacles import ObstacleScene, avoid_obstacles
from workbench.posture.reaching.oneself import own_body, own_names
from workbench.posture.reaching.outward import Lead, no_lead, outward
from workbench.posture.reaching.reach_solver import (
    AGAIN,
    TURN_LEVER,
    LimbTask,
    ReachSolution,
    apply,
    cold,
    discomfort_of,
    goals_of,
    joint_rotations,
    limb_task,
    nearest,
    reaches,
    root_joint,
    rows_of,
    solve_reaches,
    stopped_by,
    tips_of,
)

__all__ = ["reach"]

PEOPLE_PER_REACH_BATCH = 512
"""Rows of a body that are packed at a time, which bounds the memory."""
MOST_EXTENSION = 1.0
"""[m] No limb reaches farther beyond a target that it reaches."""
LEANS = tuple(
    sorted(
        product((-0.7, 0.0, 0.45), (-0.6, 0.0, 0.6), (-0.6, 0.0, 0.6)),
        key=lambda lean: (sum(share**2 for share in lean), lean),
    )
)
"""How a trunk leans that is tried where the arm comes into the own body: back or forward, away from the
arm or toward it, and turned likewise, as shares of what the joints allow; the least leaning first."""


NEAR_BY = 3
"""Reaches to targets near by whose trunk is tried, at most."""


@dataclass(frozen=True, eq=False)
class _Ask:
    """What is asked of everybody: how to search, and what to keep clear of."""

    initial: Poses | None
    restarts: int | None
    directed: bool
    environment: Environment | None
    moving_parts: Sequence[str]
    bystanders: Sequence[Bystander]
    most: float
    tighter: bool
    brief: bool
    recall: Recall | None
    thorough: bool
    other_arm: bool
    threads: int | None

    def rows(self, keep: slice | Ints, count: int) -> _Ask:
        """What is asked of some of so many people."""
        initial = self.initial
        if initial is not None and len(initial) == count:
            initial = initial.rows(keep)
        recall = self.recall.rows(keep) if self.recall is not None else None
        return replace(self, initial=initial, recall=recall)


def reach(
    body: Body,
    poses: Poses,
    targets: ArrayLike,
    *,
    limb: Limb,
    direction: ArrayLike | None = None,
    environment: Environment | None = None,
    moving_parts: Sequence[str] = (),
    displacement: ArrayLike | None = None,
    bystanders: Sequence[Bystander] = (),
    initial: Poses | None = None,
    restarts: int | None = None,
    max_extension: float = 0.0,
    tighter_zones: bool = True,
    brief: bool = False,
    recall: Recall | None = None,
    thorough: bool = True,
    other_arm: bool = False,
    threads: int | None = None,
) -> Reach:
    """Solve the inverse kinematics of one limb for B people with T targets each.

    Each reach depends on the person, the posture, the target and the obstacles alone. So the same
    person gets the same answer alone, in any order, and in any crowd. A hand in a freer harness
    zone never reaches less: what it misses is tried in the tighter zones, with the trunk as the
    posture has it.

    Parameters
    ----------
    body, poses
        B poses of the rows of a body: of one person, of each row in their order, or of the rows
        that `poses.person` names. What the limb does not move stays as the poses have it.
    targets
        (T, 3) targets for everybody, or (B, T, 3) for each person, in the world [m].
    limb
        The limb that reaches, made for this body by `limb`.
    direction
        (3,), (T, 3) or (B, T, 3): where the limb is to point on arrival; anywhere if None.
    environment
        Obstacles, with the contact that they allow; none if None. Beside them an arm keeps clear of
        the own trunk, head and legs too, as far as these may not overlap.
    moving_parts, displacement
        The names of obstacles that are displaced, and (B, 3) [m] by how much for each person.
    bystanders
        People who are obstacles too, and stand still; beside an environment only.
    initial
        1 or B poses near the solutions, from which the search starts, that round obstacles too. If
        None it starts from the solution of a standard limb for a target near by.
    restarts
        How many other postures to start again from where a target is missed. If given, the search
        starts from `initial`, or from the comfort modes.
    max_extension
        How far [m] to search beyond a reached target, on the ray from the shoulder or hip.
    tighter_zones
        Whether what a hand misses in its own harness zone is tried in the tighter ones. A caller
        who knows that they miss it spares the time.
    brief
        Whether what obstacles put in doubt is left so where no way about them is found from the
        posture that reaches without them: it counts as missed, and may not be.
    recall
        What is known of the same people and targets from elsewhere; it is made to hold what becomes
        of them here.
    thorough
        Whether what is missed is asked again from many starts, and by obstacles at targets near by
        too, so that no miss exceeds that of a target near by by more than their distance. A caller
        who only compares many places spares the time.
    other_arm
        Whether the other arm is an obstacle too, where the poses have it; else it gives way.
    threads
        All cores if None. No answer depends on it.

    Returns
    -------
    Reach
        Arrays (B, T), and the postures.

    Raises
    ------
    UsageError
        If the numbers of rows do not match, the limb is of another body, or bystanders are given
        without an environment.

    Examples
    --------
    >>> import workbench as wb
    >>> body, trainer = wb.load_body("adult_male"), wb.load_environment("trainer")
    >>> seated = wb.seat(body, wb.pose(body, {}, reference="LT"), trainer.seat("left")).poses
    >>> arm = wb.limb(body, "right hand", zone=2)
    >>> found = wb.reach(body, seated, [trainer.control("throttle").at], limb=arm)
    >>> found.reached, found.miss.round(3)
    (array([[ True]]), array([[0.]]))
    """
    if bystanders and environment is None:
        raise UsageError("bystanders: they are heeded beside an environment only, got none")
    goals, ways = _goals(body, poses, targets, direction)
    count = len(poses)
    displaced = np.zeros((count, 3)) if displacement is None else np.asarray(displacement, float)
    _check(body, limb, count, displaced, initial, max_extension)
    ask = _Ask(
        initial=initial,
        restarts=restarts,
        directed=direction is not None,
        environment=environment,
        moving_parts=moving_parts,
        bystanders=tuple(bystanders),
        most=max_extension,
        tighter=tighter_zones,
        brief=brief,
        recall=recall,
        thorough=thorough and not brief,
        other_arm=other_arm,
        threads=threads,
    )
    person = people_of(body, poses)
    held = Poses(poses.rotations, limb.base, segment_frames(body, poses, limb.base), person=person)
    parts = []
    for first in range(0, count, PEOPLE_PER_REACH_BATCH):
        some = slice(first, first + PEOPLE_PER_REACH_BATCH)
        crowd = _crowd(body, limb, held.rows(some), goals[some], ways[some], displaced[some])
        own = ask.rows(some, count)
        parts.append(_answer(crowd, own, _solved_crowd(crowd, own, outermost=True)))
    return join_reaches(parts, body, held)


def _check(
    body: Body,
    limb: Limb,
    count: int,
    displaced: Floats,
    initial: Poses | None,
    max_extension: float,
) -> None:
    """UsageError for the first option that does not fit `count` poses of a body."""
    if displaced.shape != (count, 3):
        raise UsageError(
            f"displacement: expected shape ({count}, 3) for {count} poses, got {displaced.shape}"
        )
    if not 0 <= max_extension <= MOST_EXTENSION:
        raise UsageError(
            f"max_extension: expected 0 to {MOST_EXTENSION:g} m, got {max_extension:g}"
        )
    if len(limb) != len(body):
        raise UsageError(
            f"limb: expected one of a body of {len(body)} rows, got one of {len(limb)}; "
            f"make it by limb(body, ...)"
        )
    if initial is not None and len(initial) not in (1, count):
        raise UsageError(
            f"initial: expected 1 or {count} rows for {count} poses, got {len(initial)}"
        )


def _goals(
    body: Body, poses: Poses, targets: ArrayLike, direction: ArrayLike | None
) -> tuple[Floats, Floats]:
    """Targets and unit directions (B, T, 3); UsageError where numbers of rows do not match."""
    check_joints(body, poses)
    if not len(poses):
        raise UsageError("poses: expected one row at least, got none")
    given = np.atleast_2d(np.asarray(targets, dtype=np.float64))
    count = len(poses)
    if given.ndim not in (2, 3) or given.shape[-1] != 3 or not np.all(np.isfinite(given)):
        raise UsageError(
            f"targets: expected finite points (T, 3) or ({count}, T, 3), got an array {given.shape}"
        )
    if given.ndim == 3 and len(given) != count:
        raise UsageError(
            f"targets: expected shape (T, 3) or ({count}, T, 3) for {count} poses, got {given.shape}"
        )
    goals = np.broadcast_to(given, (count, *given.shape[-2:]))
    if direction is None:
        return goals, np.zeros(goals.shape)
    ways = np.asarray(direction, dtype=np.float64)
    if ways.shape not in ((3,), goals.shape[1:], goals.shape):
        raise UsageError(
            f"direction: expected a vector (3,), {goals.shape[1:]} or {goals.shape}, "
            f"got an array {ways.shape}"
        )
    size = np.linalg.norm(ways, axis=-1, keepdims=True)
    if not np.all(size > 1e-9):
        raise UsageError("direction: expected vectors that have a length, got one of length 0")
    return goals, np.broadcast_to(ways / size, goals.shape)


@dataclass(frozen=True, eq=False)
class _Crowd:
    """People whose reaches are solved at once."""

    body: Body
    limb: Limb
    held: Poses
    """(B,) the postures that they reach from, placed by the segment that the limb hangs on."""
    person: Ints
    """(B,) the row of the body of each."""
    goals: Floats
    """(B, T, 3) [m]"""
    ways: Floats
    """(B, T, 3) unit vectors, zero where no direction is asked for."""
    displacement: Floats
    """(rows of the body, 3) [m] of the parts that move."""


def _crowd(
    body: Body, limb: Limb, held: Poses, goals: Floats, ways: Floats, displaced: Floats
) -> _Crowd:
    """People as a crowd. A body that is small enough stays whole, so that what is packed of it
    serves again."""
    person = people_of(body, held)
    alike = len(np.unique(person)) < len(person)
    if len(body) > PEOPLE_PER_REACH_BATCH or (alike and displaced.any()):
        body, limb, person = body[person], limb.rows(person), np.arange(len(person))
        held = replace(held, person=None)
    displacement = np.zeros((len(body), 3))
    displacement[person] = displaced
    return _Crowd(body, limb, held, person, goals, ways, displacement)


@dataclass(frozen=True, eq=False)
class _Solved:
    """What P reaches have come to, a row each: the targets of the first person first."""

    task: LimbTask
    found: ReachSolution
    doubt: Ints
    reached: Bools
    extension: Floats

    def rows(self, rows: Ints) -> _Solved:
        """Some of the rows."""
        return _Solved(
            rows_of(self.task, rows),
            self.found.rows(rows),
            self.doubt[rows],
            self.reached[rows],
            self.extension[rows],
        )


def _solved_crowd(crowd: _Crowd, ask: _Ask, *, outermost: bool = False) -> _Solved:
    """What the reaches of a crowd come to, in tighter zones where the limb misses in its own;
    outermost: in the zone that was asked for, in which what is missed is missed by least."""
    task = _task(crowd, ask)
    start = _start(task, crowd, ask)
    guided = _guided(task, crowd, ask)
    near = None if guided is None else guided.guides.near(guided.cubes, guided.how, start)
    found = solve_reaches(
        task, start, AGAIN if ask.restarts is None else ask.restarts, near=near, threads=ask.threads
    )
    if ask.thorough and outermost:
        found = nearest(task, found, threads=ask.threads)
    doubt = np.zeros(len(task), np.int64)
    if ask.environment is not None:
        found, doubt = _among_obstacles(task, found, start, crowd, ask)
    extension = np.zeros(len(task))
    own = _Solved(task, found, doubt, reaches(found), extension)
    held = tighter(crowd.body, crowd.limb)
    if held is not None and ask.environment is not None:
        into_itself = _turn_arms_alone(own, held, crowd, ask)
        if ask.thorough and held.base != crowd.limb.base:
            _lean_elsewhere(own, held, into_itself, crowd, ask)
            _lean_as_near_by(own, held, into_itself, crowd, ask)
    if held is not None and ask.tighter:
        _take_tighter(own, held, crowd, ask)
    rows = np.flatnonzero(own.reached)
    if ask.most > 0 and len(rows):
        some = rows_of(task, rows)
        root = _roots(task, _at_origin(crowd.held))[task.pose[rows]]
        lead = no_lead(some) if guided is None else guided.beyond(rows, start[rows], ask.most)
        beyond = _extension(some, found.rows(rows), root, lead, ask)
        extension[rows] = np.maximum(extension[rows], beyond)
    return own


def _room(crowd: _Crowd, ask: _Ask) -> ObstacleScene:
    """The obstacles of a crowd, without the own body."""
    assert ask.environment is not None
    moving = np.isin(ask.environment.parts, list(ask.moving_parts)).astype(np.int64)
    return ObstacleScene(ask.environment, moving, crowd.displacement, ask.bystanders, ask.threads)


def _among_obstacles(
    task: LimbTask, free: ReachSolution, start: Floats, crowd: _Crowd, ask: _Ask
) -> tuple[ReachSolution, Ints]:
    """What reaches come to beside obstacles, and what became of each. What then enters the own body is
    searched for again."""
    room = _room(crowd, ask)
    effort = BRIEF if ask.brief else WHOLE
    found, doubt = avoid_obstacles(task, free, room, effort=effort, recall=ask.recall)
    rows = np.flatnonzero(reaches(found))
    again = ask.thorough or ask.initial is not None
    if moves_arm_alone(task.limb) and (len(rows) or again):
        own = own_body(task.body, crowd.held, task.limb, other_arm=ask.other_arm)
        room = replace(room, own=own)
        rows = rows[in_own_body(rows_of(task, rows), found.angles[rows], room) > 0]
        if len(rows):
            recall = ask.recall.each().rows(rows) if ask.recall is not None else None
            clear = avoid_obstacles(
                rows_of(task, rows), found.rows(rows), room, effort=effort, recall=recall
            )
            found.put(rows, clear[0])
            doubt[rows] = clear[1]
        if ask.thorough:  # of what is missed, too, no posture is told that enters the own body
            rows = missed_by_obstacles(found, doubt)
            deep = in_own_body(rows_of(task, rows), found.angles[rows], room)
            found.overlap[rows] = np.maximum(found.overlap[rows], deep)
    starts = start if ask.initial is not None else None
    return asked_again(task, free, found, doubt, room, starts=starts, thorough=ask.thorough)


def _turn_arms_alone(own: _Solved, arm: Limb, crowd: _Crowd, ask: _Ask) -> Ints:
    """Where a limb that moves trunk or shoulder has come into the own body, let the arm alone reach, from
    these as they have come to lie; returns these rows. arm: the limb in the next tighter zone."""
    rows = np.flatnonzero(own.reached)
    some = rows_of(own.task, rows), own.found.angles[rows]
    rows = rows[in_own_body(*some, _room(crowd, ask), other_arm=ask.other_arm) > 0]
    if len(rows):
        angles = own.found.angles[rows]
        _put(own, rows, _arms_alone(own, arm, rows, angles, crowd, ask), angles)
    return rows


def _arms_alone(
    own: _Solved, arm: Limb, rows: Ints, angles: Floats, crowd: _Crowd, ask: _Ask
) -> _Solved:
    """What arms alone come to in some rows, from the trunk at angles (P, K, 3) [rad]."""
    task = rows_of(own.task, rows)
    poses = Poses(joint_rotations(task, angles), task.limb.base, task.base, person=task.who)
    ask = replace(_of_rows(ask, own.task.pose, rows), recall=None)
    return _solved_crowd(_held_crowd(crowd, arm, poses, rows), ask)


def _lean_elsewhere(own: _Solved, arm: Limb, rows: Ints, crowd: _Crowd, ask: _Ask) -> None:
    """Let arms that the own body keeps off reach from a trunk that leans in another way, for one
    posture of the trunk proves nothing of others: the first of `LEANS` from which one reaches, and in
    which the trunk too is clear."""
    brief = replace(ask, brief=True, thorough=False, tighter=False)
    body = own.task.body
    trunk = own.task.joints[: -len(joints_between(body, arm.base, arm.end))]
    reach_of = body.stops.limits[trunk]
    aside = 1.0 if arm.name.startswith("left") else -1.0
    for lean in LEANS:
        rows = rows[~own.reached[rows]]
        if not len(rows):
            return
        share = np.array(lean) * (1.0, aside, aside)
        leaning = np.where(share > 0, reach_of[:, :, 0], reach_of[:, :, 1]) * share
        angles = own.found.angles[rows]
        angles[:, : len(trunk)] = leaning
        there = _arms_alone(own, arm, rows, angles, crowd, brief)
        clear = deep_in(
            rows_of(own.task, rows),
            np.concatenate([angles[:, : len(trunk)], there.found.angles], axis=1),
            _room(crowd, ask),
        )
        got = np.flatnonzero(there.reached & (clear.overlap <= 0))
        _put(own, rows[got], there.rows(got), angles[got])


def _lean_as_near_by(own: _Solved, arm: Limb, rows: Ints, crowd: _Crowd, ask: _Ask) -> None:
    """Let arms that are still kept off reach from a trunk that leans as for a target near by, where the
    reach to that shows that something nearer is possible: a miss contradicts none of theirs."""
    rows = rows[~own.reached[rows]]
    if not len(rows):
        return
    pose = own.task.pose[rows]
    aside = targets_aside(own.task.base[rows])
    count = aside.shape[1]
    goals, ways = (values.reshape(-1, 1, 3)[rows] for values in (crowd.goals, crowd.ways))
    some = replace(
        crowd,
        held=crowd.held.rows(pose),
        person=crowd.person[pose],
        goals=goals + aside,
        ways=np.repeat(ways, count, axis=1),
    )
    asked = replace(_of_rows(ask, own.task.pose, rows), recall=None, thorough=False, tighter=False)
    near = _solved_crowd(some, asked)
    at_best = np.linalg.norm(aside, axis=2) + _lack(near).reshape(-1, count)
    for rank in range(NEAR_BY):
        best = np.argsort(at_best, axis=1, kind="stable")[:, rank]
        left = np.flatnonzero(_lack(own.rows(rows)) > at_best[np.arange(len(rows)), best] + PRECISE)
        if not len(left):
            return
        angles = near.found.angles[left * count + best[left]]
        there = _arms_alone(own, arm, rows[left], angles, crowd, ask)
        better = np.flatnonzero(_lack(there) < _lack(own.rows(rows[left])) - PRECISE)
        _put(own, rows[left[better]], there.rows(better), angles[better])


def _lack(own: _Solved) -> Floats:
    """(P,) [m] what reaches lack, nothing where they come to their targets."""
    return np.where(own.reached, 0.0, _short(own.found))


def _take_tighter(own: _Solved, held: Limb, crowd: _Crowd, ask: _Ask) -> None:
    """Put in what the limb reaches in tighter zones where it misses in its own, and what it misses
    by less there. What is too deep in a part for the hand is so in every zone."""
    missed = np.flatnonzero(~own.reached & (own.doubt != BURIED))
    if not len(missed):
        return
    whose = own.task.pose
    poses = replace(crowd.held, person=crowd.person).rows(whose[missed])
    there = _solved_crowd(
        _held_crowd(crowd, held, poses, missed),
        _of_rows(ask, whose, missed),
    )
    less = _short(there.found) < _short(own.found.rows(missed)) - PRECISE
    got = np.flatnonzero(there.reached | less)
    rows = missed[got]
    angles = angles_of(own.task.body, crowd.held)[whose[rows]][:, own.task.joints]
    _put(own, rows, there.rows(got), angles)


def _put(own: _Solved, rows: Ints, there: _Solved, angles: Floats) -> None:
    """Put what some rows of reaches come to in a tighter zone in their place; the joints that are held
    there are at angles (P, K, 3) [rad]."""
    columns = [own.task.joints.index(joint) for joint in there.task.joints]
    angles[:, columns] = there.found.angles
    numbers = there.found.numbers.copy()
    numbers[:, 3] = np.array(columns)[numbers[:, 3].astype(np.int64)]  # the joint of a stop
    held = np.zeros((len(rows), own.found.held.shape[1]))  # not the multipliers of another chain
    own.found.put(rows, replace(there.found, angles=angles, numbers=numbers, held=held))
    own.doubt[rows] = there.doubt
    own.reached[rows] = there.reached
    own.extension[rows] = there.extension


def _short(found: ReachSolution) -> Floats:
    """(P,) [m] what reaches lack: how far they stay away, and how deep they enter something."""
    lack: Floats = found.numbers[:, 0] + found.overlap
    return lack


def _held_crowd(crowd: _Crowd, held: Limb, poses: Poses, rows: Ints) -> _Crowd:
    """A crowd of one person for each of some reaches of a crowd, in poses (P,), with the limb in another
    zone."""
    world = segment_frames(crowd.body, poses, held.base)
    person = people_of(crowd.body, poses)
    poses = Poses(poses.rotations, held.base, world, person=person)
    goals, ways = (values.reshape(-1, 1, 3)[rows] for values in (crowd.goals, crowd.ways))
    return replace(crowd, limb=held, held=poses, person=person, goals=goals, ways=ways)


def _of_rows(ask: _Ask, whose: Ints, rows: Ints) -> _Ask:
    """What is asked of a person for each of some reaches."""
    initial = ask.initial
    if initial is not None and len(initial) > 1:
        initial = initial.rows(whose[rows])
    recall = ask.recall.each().rows(rows) if ask.recall is not None else None
    return replace(ask, initial=initial, recall=recall)


def _extension(task: LimbTask, found: ReachSolution, root: Floats, lead: Lead, ask: _Ask) -> Floats:
    """(P,) [m] how much farther out limbs reach than their targets, on rays from root (P, 3) [m], in
    the axes of the held segments."""
    ways = task.own.goal[:, :3] - root
    led = outward(task, found, ways, lead, most=ask.most, threads=ask.threads)
    beyond: Floats = np.clip(led.ways, 0.0, ask.most)
    return beyond


def _task(crowd: _Crowd, ask: _Ask) -> LimbTask:
    """A row for each reach, the targets of the first person first."""
    count = crowd.goals.shape[1]
    goal = goals_of(crowd.goals.reshape(-1, 3))
    if ask.directed:
        goal[:, 3:6] = crowd.ways.reshape(-1, 3)
        goal[:, 9:] = TURN_LEVER
    return limb_task(
        crowd.body,
        crowd.limb,
        np.repeat(crowd.person, count),
        held=np.repeat(crowd.held.rotations, count, axis=0),
        base=np.repeat(crowd.held.world_from_reference, count, axis=0),
        goal=goal,
        pose=np.repeat(np.arange(len(crowd.held)), count),
    )


def _start(task: LimbTask, crowd: _Crowd, ask: _Ask) -> Floats:
    """(P, K, 3) [rad] the angles as the poses have them, the free ones at their comfort modes or as
    in the initial poses."""
    angles = cold(task, angles_of(task.body, crowd.held)[task.pose][:, task.joints])
    if ask.initial is not None:
        link = task.link
        given = angles_of(task.body, ask.initial)[:, task.joints]
        given = np.repeat(given, len(crowd.held), axis=0) if len(given) == 1 else given
        angles = np.where(link.free_of >= 0, given[task.pose], angles)
    return angles


@dataclass(frozen=True, eq=False)
class _Guided:
    """The guides of a limb, how the people stand to them, and the cube of each reach."""

    guides: Guides
    how: Guiding
    cubes: Ints

    def beyond(self, rows: Ints, start: Floats, most: float) -> Lead:
        """How far outward the guides of some rows get."""
        return self.guides.beyond(self.cubes[rows], self.how.rows(rows), start, most)


def _guided(task: LimbTask, crowd: _Crowd, ask: _Ask) -> _Guided | None:
    """The guides of a task; None where the search starts elsewhere."""
    if ask.initial is not None or ask.restarts is not None or ask.directed:
        return None
    guides = guides_of(task.body, task.limb)
    if guides is None:
        return None
    how = guides.guiding(task, _at_origin(crowd.held), task.pose)
    return _Guided(guides, how, guides.cubes(task.own.goal[:, :3], how))


def _at_origin(held: Poses) -> Poses:
    """Postures in the axes of the segments that they are placed by."""
    return replace(held, world_from_reference=np.repeat(np.eye(3, 4)[None], len(held), axis=0))


def _roots(task: LimbTask, held: Poses) -> Floats:
    """(B, 3) [m] the shoulder or hip in the postures that people reach from."""
    joint = root_joint(task.body, task.limb)
    world = segment_frames(task.body, held, joint + 1)
    person = people_of(task.body, held)
    return apply(world[:, :, :3], task.body.joint_in_child[person, joint]) + world[:, :, 3]


def _answer(crowd: _Crowd, ask: _Ask, solved_rows: _Solved) -> Reach:
    """The answers of the rows (P,), a row (T,) for each person."""
    task = solved_rows.task
    found = solved_rows.found
    reached = solved_rows.reached
    shape = crowd.goals.shape[:2]
    tip = tips_of(task, found.angles)[:, :3]
    arm = tip - task.goal[:, :3]
    miss = np.sqrt(arm[:, 0] ** 2 + arm[:, 1] ** 2 + arm[:, 2] ** 2)
    discomfort = discomfort_of(task, found.angles)
    joint, axis, side = stopped_by(task, found, reached)
    others = [name for one in ask.bystanders for name in one.segment_names]
    return Reach(
        body=task.body,
        limb=task.limb.name,
        held=crowd.held,
        joints=tuple(task.joints),
        free=task.limb.free,
        target=crowd.goals,
        tip=tip.reshape(*shape, 3),
        angles=found.angles.reshape(*shape, -1, 3),
        reached=reached.reshape(shape),
        miss=miss.reshape(shape),
        overlap=found.overlap.reshape(shape),
        discomfort=discomfort.reshape(shape),
        extension=solved_rows.extension.reshape(shape),
        joint=joint.reshape(shape),
        axis=axis.reshape(shape),
        side=side.reshape(shape),
        part=np.where(reached, -1, found.part).reshape(shape),
        doubt=solved_rows.doubt.reshape(shape),
        parts=ask.environment.parts if ask.environment is not None else (),
        bodies=(*others, *own_names(task.body)),
    )
