"""Belts as parts: ribbons along their points on a placed body."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from workbench.files.meshes.assembly import built
from workbench.files.meshes.parts import RawPart
from workbench.model.arrays import Floats
from workbench.model.environment import Allowance, Environment
from workbench.model.joined import joined
from workbench.model.poses import Placed
from workbench.model.simulation import Belt

__all__ = ["with_belts"]


def with_belts(environment: Environment, belts: Iterable[Belt], placed: Placed, *, pose: int = 0) -> Environment:
    """The environment with each belt as a ribbon along its points in one pose, into which the body may move as deep as
    the belt allows."""
    worn = list(belts)
    if not worn:
        return environment
    ribbons, faults = built("belts", [_ribbon(belt, placed, pose) for belt in worn], solid=[False] * len(worn))
    assert not faults  # only solids have any
    allowed = tuple(Allowance(k, ("all",), belt.allow) for k, belt in enumerate(worn))
    return joined(environment, replace(ribbons, allowances=allowed, warnings=()))


def _ribbon(belt: Belt, placed: Placed, pose: int) -> RawPart:
    world = placed.world_from_segment[pose]
    points, outward = [], []
    for point in belt.points:
        at = np.array(point.at)
        if point.segment < 0:
            points.append(at)
            outward.append(np.zeros(3))
        else:
            frame = world[point.segment]
            points.append(frame[:, :3] @ at + frame[:, 3])
            outward.append(frame[:, :3] @ at)
    line = np.array(points)
    side = _sides(line, np.array(outward))
    edges = np.concatenate([line + 0.5 * belt.width * side, line - 0.5 * belt.width * side])
    count = len(line)
    k = np.arange(count - 1)
    corners = [(k, k + 1, k + 1 + count), (k, k + 1 + count, k + count)]
    return RawPart(belt.name, edges, np.concatenate([np.stack(three, axis=1) for three in corners]))


def _sides(line: Floats, outward: Floats) -> Floats:
    """(M, 3) unit directions across a belt: square to its way, flat on the body; at anchors as at their neighbours."""
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
