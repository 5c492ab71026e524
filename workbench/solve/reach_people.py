"""Reaches of many people at once: one limb of B bodies of a family, each to its T targets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import UsageError
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.people_reach import PeopleReach
from workbench.model.poses import Poses
from workbench.model.reach import Reach
from workbench.solve.forward import place
from workbench.solve.limbs import HANDS, Limb, limb
from workbench.solve.reach import reach

__all__ = ["reach_people"]

NEAR = 1e-3
"""How near [m] to the farthest reached point the spare ends."""
STEPS = 40


def reach_people(
    bodies: Sequence[Body],
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
    """Reach with a limb of B bodies, one row of poses a body, for targets (T, 3) or (B, T, 3) [m].

    bodies: of one family, with the same segments, joints and stops; only lengths and spheres differ. name, grip, zone:
    as for `limb`. environment: obstacles, with their allowances; moves: its parts that have gone along with each
    person's seat by shift (B, 3) [m]. spare [m]: how far beyond a reached target to look for the farthest point that
    the limb still reaches, on the ray from its first joint (shoulder, hip) as it stands in the poses; to within 1 mm,
    obstacles aside. rotations: whether to give the postures found. threads: all cores where None; the answer does not
    depend on it. UsageError where numbers of rows do not fit or bodies are not of one family.
    """
    goals = _targets(bodies, poses, targets)
    moved_by = np.zeros((len(bodies), 3)) if shift is None else np.asarray(shift, dtype=np.float64)
    rows, spares = [], np.zeros(goals.shape[:2])
    for b, body in enumerate(bodies):
        who = body, _one(poses, b), limb(body, name, grip=grip, zone=zone)
        rows.append(_reach(who, goals[b], environment, (moves, moved_by[b])))
        spares[b] = _spare(who, rows[b], spare)
    return _gathered(bodies[0], rows, spares, rotations)


def _gathered(body: Body, rows: Sequence[Reach], spares: Floats, rotations: bool) -> PeopleReach:
    return PeopleReach(
        body=body,
        limb=rows[0].limb,
        target=np.stack([row.target for row in rows]),
        reached=np.stack([row.reached for row in rows]),
        miss=np.stack([row.miss for row in rows]),
        overlap=np.stack([row.overlap for row in rows]),
        discomfort=np.stack([row.discomfort for row in rows]),
        joint=np.stack([row.joint for row in rows]),
        axis=np.stack([row.axis for row in rows]),
        side=np.stack([row.side for row in rows]),
        part=np.stack([row.part for row in rows]),
        spare=spares,
        parts=rows[0].parts,
        rotations=np.stack([row.poses.rotations for row in rows]) if rotations else None,
    )


def _targets(bodies: Sequence[Body], poses: Poses, targets: ArrayLike) -> Floats:
    """Targets (B, T, 3); UsageError where the numbers of rows do not fit or bodies are not of one family."""
    goals = np.asarray(targets, dtype=np.float64)
    if len(poses) != len(bodies):
        raise UsageError(f"{len(bodies)} bodies need as many poses, got {len(poses)}")
    for body in bodies:
        same = body.joints == bodies[0].joints and np.array_equal(body.stops.limits, bodies[0].stops.limits)
        if not same:
            raise UsageError(f"bodies of one family have the same joints and stops: {bodies[0].name} and {body.name}")
    if goals.ndim == 2:
        goals = np.broadcast_to(goals, (len(bodies), *goals.shape))
    if goals.ndim != 3 or goals.shape[0] != len(bodies) or goals.shape[2] != 3 or not np.all(np.isfinite(goals)):
        raise UsageError(f"targets are finite points (T, 3) or (B, T, 3), got an array of shape {np.shape(targets)}")
    return goals


def _one(poses: Poses, row: int) -> Poses:
    return Poses(poses.rotations[row : row + 1], poses.reference, poses.world_from_reference[row : row + 1])


def _reach(
    who: tuple[Body, Poses, Limb],
    goals: Floats,
    environment: Environment | None,
    seat: tuple[Sequence[str], Floats],
) -> Reach:
    body, pose, chain = who
    return reach(body, pose, goals, limb=chain, environment=environment and _moved(environment, *seat))


def _moved(environment: Environment, parts: Sequence[str], by: Floats) -> Environment:
    """The environment with these parts shifted."""
    chosen = np.isin(np.arange(len(environment.parts)), [environment.part(name) for name in parts])
    if not chosen.any() or not by.any():
        return environment
    polygon = chosen[environment.polygon_part]
    vertex = np.zeros(len(environment.vertices), dtype=np.bool_)
    vertex[environment.triangles[np.repeat(polygon, np.diff(environment.triangle_start))].ravel()] = True
    return replace(
        environment,
        vertices=environment.vertices + np.where(vertex[:, None], by, 0.0),
        offset=environment.offset + np.where(polygon, environment.normal @ by, 0.0),
        circle_centre=environment.circle_centre + np.where(polygon[:, None], by, 0.0),
    )


def _spare(who: tuple[Body, Poses, Limb], found: Reach, most: float) -> Floats:
    """(T,) [m] how much farther out the limb reaches: from the far end inward by as much as is missed."""
    body, pose, chain = who
    spare = np.zeros(len(found))
    rows = np.flatnonzero(found.reached) if most > 0 else np.zeros(0, np.int64)
    if not len(rows):
        return spare
    origin = _first_joint(who)
    way = found.target[rows] - origin
    way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-9)
    spare[rows] = most
    for _ in range(STEPS):
        if not len(rows):
            break
        farther = reach(body, pose, found.target[rows] + spare[rows, None] * way, limb=chain)
        on = farther.miss > NEAR
        rows, way = rows[on], way[on]
        spare[rows] = np.maximum(spare[rows] - farther.miss[on], 0.0)
    return spare


def _first_joint(who: tuple[Body, Poses, Limb]) -> Floats:
    """(3,) [m] the shoulder of an arm, the hip of a leg, in the pose."""
    body, pose, chain = who
    joint = body.joint(body.segments[chain.end][0] + ("S" if chain.name.split(",")[0] in HANDS else "H"))
    world = place(body, pose, window=[body.segments[joint + 1]]).world_from_segment[0, joint + 1]
    point: Floats = world[:, :3] @ body.joint_in_child[joint] + world[:, 3]
    return point
