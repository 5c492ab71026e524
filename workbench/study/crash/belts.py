"""Belts as parts: ribbons along their points on a placed body."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from workbench.body.forward import place
from workbench.files.crash.restraints import surface_point
from workbench.files.meshes.assembly import build_environment
from workbench.files.meshes.parts import RawPart
from workbench.model.arrays import Floats, pieces
from workbench.model.body import Body
from workbench.model.environment import Allowance, Environment
from workbench.model.motion_case import ForceCurve, MotionCase
from workbench.model.poses import Placed
from workbench.model.simulation import Belt, BeltPoint, tension_history
from workbench.model.surroundings import merge_environments

__all__ = ["belt_line", "belt_tensions", "with_belts"]

_LIFT = 0.004
"""[m] A ribbon lies so far off the spheres."""
_BETWEEN = 3


def with_belts(
    environment: Environment, belts: Iterable[Belt], placed: Placed, *, pose: int = 0
) -> Environment:
    """The environment with each belt as a ribbon along its points in one pose, into which the body
    may move as deep as the belt allows."""
    worn = list(belts)
    if not worn:
        return environment
    ribbons, faults = build_environment(
        "belts", [_ribbon(belt, placed, pose) for belt in worn], solid=[False] * len(worn)
    )
    assert not faults  # only solids have any
    allowed = tuple(Allowance(k, ("all",), belt.allow) for k, belt in enumerate(worn))
    return merge_environments(environment, replace(ribbons, allowances=allowed, warnings=()))


def belt_tensions(study: MotionCase) -> tuple[ForceCurve, ...]:
    """The tension of each belt over the frames by its law: how much longer its way is than at the
    first frame, beyond the slack."""
    if not study.belts:
        return ()
    ways: list[list[Floats]] = [[] for _ in study.belts]
    for rows in pieces(len(study.motion)):
        world = place(study.body, study.motion.rows(rows)).world_from_segment
        for way, belt in zip(ways, study.belts, strict=True):
            line = np.stack([_along(point, world) for point in belt.points], axis=1)
            way.append(np.linalg.norm(np.diff(line, axis=1), axis=2).sum(axis=1))
    return tuple(
        _tension(belt, np.concatenate(way)) for belt, way in zip(study.belts, ways, strict=True)
    )


def _along(point: BeltPoint, world: Floats) -> Floats:
    """(P, 3) [m] a point of a belt in every pose."""
    if point.segment < 0:
        return np.broadcast_to(np.array(point.at), (len(world), 3))
    frame = world[:, point.segment]
    return np.asarray(frame[:, :, :3] @ np.array(point.at) + frame[:, :, 3])


def _tension(belt: Belt, length: Floats) -> ForceCurve:
    return ForceCurve("", belt.name, tension_history(belt.law, length - length[0] - belt.slack))


def belt_line(belt: Belt, placed: Placed, pose: int) -> Floats:
    """Return the middle line (M, 3) [m] of a belt in one pose; M is the same in all poses."""
    line, _ = _middle(belt, placed, pose)
    return line


def _middle(belt: Belt, placed: Placed, pose: int) -> tuple[Floats, Floats]:
    """The middle line (M, 3) [m] of a belt, and the way (M, 3) out of the body at its points; 0 at
    anchors."""
    world = placed.world_from_segment[pose]
    points = []
    outward = []
    for segment, at in _laid(belt, placed.body):
        frame = world[segment] if segment >= 0 else np.eye(3, 4)
        out = frame[:, :3] @ at if segment >= 0 else np.zeros(3)
        points.append(
            frame[:, :3] @ at + frame[:, 3] + _LIFT * out / max(float(np.linalg.norm(out)), 1e-12)
        )
        outward.append(out)
    return np.array(points), np.array(outward)


def _ribbon(belt: Belt, placed: Placed, pose: int) -> RawPart:
    line, outward = _middle(belt, placed, pose)
    side = _sides(line, outward)
    edges = np.concatenate([line + 0.5 * belt.width * side, line - 0.5 * belt.width * side])
    count = len(line)
    k = np.arange(count - 1)
    corners = [(k, k + 1, k + 1 + count), (k, k + 1 + count, k + count)]
    return RawPart(belt.name, edges, np.concatenate([np.stack(three, axis=1) for three in corners]))


def _laid(belt: Belt, body: Body) -> list[tuple[int, Floats]]:
    """Segment and place (3,) [m] of each point of a belt, with some more where it lies on one
    segment for a while."""
    laid: list[tuple[int, Floats]] = []
    for before, point in zip((None, *belt.points[:-1]), belt.points, strict=True):
        if before is not None and before.segment == point.segment >= 0:
            for share in np.linspace(0, 1, _BETWEEN + 2)[1:-1]:
                way = (1 - share) * np.array(before.at) + share * np.array(point.at)
                laid.append((point.segment, surface_point(body, point.segment, way)))
        laid.append((point.segment, np.array(point.at)))
    return laid


def _sides(line: Floats, outward: Floats) -> Floats:
    """(M, 3) unit directions across a belt: square to its way, flat on the body; at anchors as at
    their neighbours."""
    way = np.gradient(line, axis=0)
    way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-12)
    across = np.cross(way, outward)
    size = np.linalg.norm(across, axis=1)
    held = np.flatnonzero(size > 1e-9)
    if not len(held):
        spare = np.cross(way, np.eye(3)[np.argmin(np.abs(way[0]))])
        return np.asarray(spare / np.linalg.norm(spare, axis=1, keepdims=True))
    nearest = held[np.argmin(np.abs(np.arange(len(line))[:, None] - held), axis=1)]
    side = across[nearest] / size[nearest, None]
    side -= np.sum(side * way, axis=1, keepdims=True) * way
    return np.asarray(side / np.maximum(np.linalg.norm(side, axis=1, keepdims=True), 1e-12))
