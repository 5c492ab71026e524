"""A body's skeleton in place: its bones for cutting a surface, and fitted spheres back in its
segments' frames."""

from __future__ import annotations

import numpy as np

from workbench.body.fitting.segmenting import Bones, SegmentedFit
from workbench.errors import InputError
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.vocabulary import DIRECTIONS

__all__ = ["bones_of", "named_rows", "spheres_in_frames"]

_NEAR = 1e-3
_BEHIND = 0.3


def bones_of(body: Body, world: Floats) -> Bones:
    """The bones of a placed body, world (N, 3, 4) from its segments [m], in the order of its
    segments.

    From the proximal joint (the stage: its origin) to each distal one; a segment without a distal
    joint has bones from its joint to the farthest of its spheres, ahead and, where it reaches
    behind the joint (a heel), behind.
    """
    names: list[str] = []
    ends: list[tuple[Floats, Floats]] = []
    for n, name in enumerate(body.segments):
        turn = world[n, :, :3]
        shift = world[n, :, 3]
        start = body.joint_in_child[0, n - 1] if n else np.zeros(3)
        distal = [
            body.joint_in_parent[0, j] for j in range(len(body.joints)) if body.parent[j + 1] == n
        ]
        tips = [p for p in distal if np.linalg.norm(p - start) > _NEAR] or _tips(body, n, start)
        for tip in tips:
            names.append(name)
            ends.append((turn @ start + shift, turn @ tip + shift))
    return Bones(tuple(names), np.array([e[0] for e in ends]), np.array([e[1] for e in ends]))


def _tips(body: Body, segment: int, start: Floats) -> list[Floats]:
    """Ends of the bones of a segment without distal joints: its far sphere centres ahead and
    behind."""
    centre = body.centre[0, body.spheres(segment)]
    way = -start
    length = float(np.linalg.norm(way))
    if length < _NEAR or not len(centre):
        return [start + (way if length >= _NEAR else np.array([0.0, 0.0, 0.02]))]
    reach = (centre - start) @ (way / length)
    ahead = int(reach.argmax())
    back = int(reach.argmin())
    tips = [centre[ahead] if reach[ahead] > length else start + way]
    if reach[back] < -_BEHIND * max(float(reach[ahead]), length):
        tips.append(centre[back])
    return tips


def spheres_in_frames(
    body: Body, world: Floats, cut: SegmentedFit
) -> dict[str, tuple[Floats, Floats]]:
    """Centres (n, 3) and radii (n,) [m] of each segment in its own frame; a sphere at a joint has
    its coordinates."""
    found = {}
    for n, name in enumerate(body.segments):
        centre, radius = cut.spheres(name)
        local = (centre - world[n, :, 3]) @ world[n, :, :3]
        joints = [
            body.joint_in_parent[0, j] for j in range(len(body.joints)) if body.parent[j + 1] == n
        ]
        for joint in [*joints, *([body.joint_in_child[0, n - 1]] if n else [])]:
            at = np.linalg.norm(local - joint, axis=1)
            if not len(at) or at.min() > _NEAR:
                raise InputError(f"segment {name}: no sphere at one of its joints")
            local[at.argmin()] = joint
        found[name] = local, radius
    return found


def named_rows(
    body: Body, segment: int, centre: Floats, radius: Floats
) -> dict[int, tuple[str, ...]]:
    """Names, with their directions, for fitted spheres (n, 3), (n,): each name goes to the sphere
    whose surface is nearest to the outermost place of the sphere that bore it; no sphere gets
    two."""
    rows: dict[int, tuple[str, ...]] = {}
    free = np.ones(len(radius), dtype=np.bool_)
    table: Ints = body.sphere_direction
    for s in range(body.start[segment], body.start[segment + 1]):
        label = body.sphere_names[s]
        if not label or not free.any():
            continue
        side = int(table[s])
        out = (
            body.directions[segment, side]
            if side >= 0
            else body.centre[0, s] / max(np.linalg.norm(body.centre[0, s]), 1e-9)
        )
        place = body.centre[0, s] + body.radius[0, s] * out
        gap = np.abs(np.linalg.norm(place - centre, axis=1) - radius)
        gap[~free] = np.inf
        best = int(gap.argmin())
        free[best] = False
        rows[best] = (label, DIRECTIONS[side]) if side >= 0 else (label,)
    return rows
