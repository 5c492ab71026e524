"""Reaches kept off obstacles: parts of an environment, and other people.

A reach is in doubt where its posture enters something, or misses the target by little. Another
posture is then searched for (kernels.clear_reach), by each reach for itself: the answer does not
depend on who else is asked. A reach is what its posture shows: the tip on the target, the joints
within their stops, nothing entered.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from workbench.contact.collide import allowed_depth
from workbench.contact.distance_fields import build_distance_field, packed_faces, packed_shells
from workbench.contact.kernels.distance_field import DistanceField
from workbench.contact.kernels.point_in_solid import SolidMeshes
from workbench.contact.kernels.search import Trees
from workbench.geometry.polygon import Faces
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body, Topology
from workbench.model.bystander import Bystander
from workbench.model.environment import Environment
from workbench.posture.kernels.clear_reach import (
    WHOLE,
    Outcome,
    clear_reaches,
    new_desk,
    prove_no_room,
)
from workbench.posture.kernels.hand_room import new_turns
from workbench.posture.kernels.limb_contacts import Company, Limbs, Obstacles, new_space
from workbench.posture.reaching.history import Recall, known_of
from workbench.posture.reaching.limbs import Limb
from workbench.posture.reaching.oneself import OwnBody
from workbench.posture.reaching.packing import packed_limbs
from workbench.posture.reaching.reach_solver import PIECE, LimbTask, ReachSolution
from workbench.threads import run_in_threads

__all__ = ["ObstacleScene", "avoid_obstacles", "hands_without_room", "obstacles_of"]


ENCLOSING = 1e-9
"""[m] More than the rounding of the radius of an enclosing sphere."""


def _plain(arrays: Sequence[NDArray[Any]]) -> list[NDArray[Any]]:
    """Arrays as read-only ones in memory, whether they were that, or maps of a file: for each kind
    of array the kernels would be compiled again."""
    views = [np.asarray(array).view() for array in arrays]
    for view in views:
        view.flags.writeable = False
    return views


NOBODY = Company(
    *_plain(
        [
            np.zeros((1, 0, 3)),
            np.zeros((1, 0)),
            np.zeros(1, np.int64),
            np.zeros((1, 0, 3)),
            np.zeros((1, 0)),
            np.zeros((1, 1, 0)),
            np.zeros(0, np.int64),
        ]
    )
)
"""No people."""


@dataclass(frozen=True, eq=False)
class ObstacleScene:
    """Obstacles: an environment, and which of its parts (K,) stand aside by shift (B, 3) [m] for
    each body; people who stand still; and the own body, None where it is not heeded. Of parts that
    are `held` nothing keeps the segment of a limb that arrives."""

    environment: Environment
    moving: Ints
    shift: Floats
    people: Sequence[Bystander] = ()
    threads: int | None = None
    held: Sequence[int] = ()
    own: OwnBody | None = None
    bodies_only: bool = False
    """Whether the environment does not count."""


def avoid_obstacles(
    task: LimbTask,
    found: ReachSolution,
    room: ObstacleScene,
    *,
    effort: int = WHOLE,
    recall: Recall | None = None,
) -> tuple[ReachSolution, Ints]:
    """Keep reaches clear of obstacles.

    Parameters
    ----------
    task, found
        P reaches, and what they have come to without obstacles. If nearer postures are asked for: a
        start of each, and numbers as of `Outcome`.
    room
        The obstacles.
    effort
        WHOLE: all ways about the obstacles are tried. BRIEF: a reach is left in doubt where no way
        is found from its own posture. NEARER or NEXT_TO: a posture is sought that is nearer to the
        target than one that is known.
    recall
        What is known of the same reaches from elsewhere, for WHOLE; it is made to hold what they
        come to.

    Returns
    -------
    found, doubt
        What the reaches come to, and what became of each (P,): an `Outcome.doubt`.
    """
    count = len(task)
    out = Outcome(
        np.array(found.angles),
        np.array(found.numbers),
        np.zeros(count),
        np.full(count, -1),
        np.zeros(count, dtype=np.int64),
        *known_of(task, effort=effort, recall=recall),
    )
    limbs, obstacles = _packed(task, room)

    def work(begin: int, end: int) -> None:
        clear_reaches(
            task.link,
            limbs,
            task.who,
            task.held,
            (*task.own, task.base, task.goal),
            obstacles,
            task.seeds,
            out,
            begin,
            end,
            new_desk(task.link, limbs, task.held.shape[1], len(task.seeds.angles)),
        )

    run_in_threads(work, count, PIECE, threads=room.threads)
    if recall is not None and effort == WHOLE:
        recall.keep(task.limb, out)
    return ReachSolution(out.angles, out.numbers, found.held, out.overlap, out.part), out.doubt


def hands_without_room(
    body: Body,
    limb: Limb,
    targets: Floats,
    environment: Environment,
    moving_parts: Sequence[str],
) -> Bools:
    """Prove that hands have no room at targets, wherever the seat stands and however they are
    turned.

    Parameters
    ----------
    body, limb
        The hand of B rows of a body.
    targets
        (T, 3) [m] in the world.
    environment, moving_parts
        The obstacles, of which those that move with the seat are not asked.

    Returns
    -------
    (B, T) array
        False where there is no proof.
    """
    count = len(targets)
    moving = np.isin(environment.parts, list(moving_parts)).astype(np.int64)
    room = obstacles_of(body, environment, moving, np.zeros((len(body), 3)))
    limbs = packed_limbs(body, limb)
    who = np.repeat(np.arange(len(body)), count)
    each = np.tile(targets, (len(body), 1))
    proved = np.zeros(len(who), np.int64)

    def work(begin: int, end: int) -> None:
        space = new_space(limbs, len(limbs.axes))
        prove_no_room(limbs, who, each, room, proved, begin, end, space, new_turns())

    run_in_threads(work, len(who), PIECE)
    return np.asarray(proved.reshape(-1, count) > 0)


def _packed(task: LimbTask, room: ObstacleScene) -> tuple[Limbs, Obstacles]:
    around = obstacles_of(task.body, room.environment, room.moving, room.shift)
    if room.people or room.own is not None:
        around = _with_people(around, room, task.pose)
    if room.bodies_only:
        trees = around.field.trees
        nowhere = _plain([np.full_like(trees.root, -1)])[0]
        around = around._replace(field=around.field._replace(trees=trees._replace(root=nowhere)))
    if room.held:
        allowed = np.array(around.allowed)
        allowed[task.limb.end, list(room.held)] = np.inf
        around = around._replace(allowed=_plain([allowed])[0])
    return packed_limbs(task.body, task.limb), around


def obstacles_of(body: Body, environment: Environment, moving: Ints, shift: Floats) -> Obstacles:
    """Obstacles packed for the kernels, for a body and those with the same segments; the parts
    moving (K,) stand aside by shift (B, 3) [m] for each body."""
    return _fixed(body.topology, environment, tuple(moving.tolist()))._replace(
        shift=np.array(shift)
    )


def _with_people(parts: Obstacles, room: ObstacleScene, pose: Ints) -> Obstacles:
    """Obstacles with people in them, then the own body, in pose (P,) in each reach. Each of their
    segments counts as a part: of the others those that are shown, of the own body all that have
    spheres."""
    some = [_others(room.people, len(parts.allowed))] if room.people else []
    some += [_own(room.own, pose)] if room.own is not None else []
    people = some[0] if len(some) == 1 else _both(some[0], some[1])
    counts = np.diff(people.start)
    owner, allowed, moving = _plain(
        [
            np.concatenate(
                [parts.owner, len(parts.moving) + np.repeat(np.arange(len(counts)), counts)]
            ),
            np.hstack([parts.allowed, np.zeros((len(parts.allowed), len(counts)))]),
            np.concatenate([parts.moving, np.zeros(len(counts), np.int64)]),
        ]
    )
    return parts._replace(
        owner=owner,
        allowed=allowed,
        moving=moving,
        people=Company(*_plain([np.ascontiguousarray(values) for values in people])),
    )


def _others(people: Sequence[Bystander], segments: int) -> Company:
    """People who stand in one way, for limbs of so many segments."""
    at = [one.placed.centres[:, some] for one in people for some in one.spheres]
    radius = [
        one.placed.body.radius[one.placed.person][:, some] + one.kept_off
        for one in people
        for some in one.spheres
    ]
    around = [0.5 * (points.min(axis=1) + points.max(axis=1)) for points in at]
    big = [
        np.max(np.linalg.norm(points - hub[:, None], axis=2) + size, axis=1) + ENCLOSING
        for points, hub, size in zip(at, around, radius, strict=True)
    ]
    return Company(
        np.concatenate([np.zeros((1, 0, 3)), *at], axis=1),
        np.concatenate([np.zeros((1, 0)), *radius], axis=1),
        np.concatenate([[0], np.cumsum([points.shape[1] for points in at])]).astype(np.int64),
        np.array(around).reshape(1, -1, 3),
        np.array(big).reshape(1, -1),
        np.zeros((1, segments, len(at))),
        np.zeros(0, np.int64),
    )


def _own(own: OwnBody, pose: Ints) -> Company:
    """The own body, in pose (P,) in each reach."""
    placed = own.placed
    body = placed.body
    full = np.diff(body.start) > 0
    world = placed.world_from_segment[:, full]
    middle = body.enclosing_centre[placed.person][:, full]
    around = np.einsum("qgij,qgj->qgi", world[..., :3], middle) + world[..., 3]
    return Company(
        placed.centres,
        body.radius[placed.person],
        np.unique(body.start),
        around,
        body.enclosing_radius[placed.person][:, full] + ENCLOSING,
        own.allowed,
        pose,
    )


def _both(others: Company, own: Company) -> Company:
    """Other people and the own body."""
    ways = len(own.centres)
    each = (np.repeat(values, ways, axis=0) for values in others[:2])
    centres, radius = (np.concatenate(pair, axis=1) for pair in zip(each, own[:2], strict=True))
    again = (np.repeat(values, ways, axis=0) for values in others[3:6])
    around, big, allowed = (
        np.concatenate(pair, axis=axis)
        for pair, axis in zip(zip(again, own[3:6], strict=True), (1, 1, 2), strict=True)
    )
    start = np.concatenate([others.start, others.start[-1] + own.start[1:]])
    return Company(centres, radius, start, around, big, allowed, own.row)


@lru_cache(maxsize=8)
def _fixed(topology: Topology, environment: Environment, moving: tuple[int, ...]) -> Obstacles:
    """The obstacles for bodies of a topology, with the parts that move in a group of their own."""
    shown = ~environment.hidden
    moves = np.array(moving)
    groups = [np.flatnonzero(shown & (moves == 0)), np.flatnonzero(shown & (moves > 0))]
    chosen = tuple(tuple(group.tolist()) for group in groups if len(group) or group is groups[0])
    allowed = allowed_depth(topology, environment)
    least = np.stack(
        [allowed[:, list(group)].min(axis=1, initial=np.inf) for group in chosen], axis=1
    )
    faces = Faces(*_plain(packed_faces(environment)))
    shells = SolidMeshes(*_plain(packed_shells(environment)))
    index = build_distance_field(environment, chosen)
    field = DistanceField(Trees(*_plain(index.trees)), *_plain(index[1:]))
    owner, allowed, moves, normal, least = _plain(
        [environment.polygon_part, allowed, moves, environment.normal, least]
    )
    (branch,) = _plain([_branches(field.trees, owner)])
    shift = np.zeros((1, 3))
    return Obstacles(
        faces, shells, field, owner, allowed, moves, normal, least, shift, branch, NOBODY
    )


def _branches(trees: Trees, owner: Ints) -> Ints:
    """(M, 8) the part of all polygons below each child of M tree nodes; -1 where there are several."""
    used = np.arange(trees.child.shape[1]) < trees.many[:, None]
    leaf = trees.child < 0
    polygon = trees.record[trees.begin[:-1] + 8].astype(np.int64)
    own = owner[polygon[np.where(leaf, -1 - trees.child, 0)]]
    found = np.where(leaf, own, 0)
    while True:  # from the leaves up, a level a turn
        low = np.where(used, found, np.iinfo(np.int64).max).min(axis=1)
        high = np.where(used, found, -1).max(axis=1)
        node = np.where(low == high, low, -1)
        above = np.where(leaf, own, node[np.where(leaf, 0, trees.child)])
        if np.array_equal(above, found):
            return above
        found = above
