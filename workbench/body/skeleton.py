"""Convert between a body and a fit: its bones for cutting a surface, and fitted spheres in its frames."""

from __future__ import annotations

import numpy as np

from workbench.body.fitting.segmenting import Bones, SegmentedFit
from workbench.errors import InputError
from workbench.model.arrays import Bools, Floats
from workbench.model.body import DIRECTIONS, Body

__all__ = ["bones_of", "named_rows", "spheres_in_frames"]

_SAME_POINT = 1e-3
"""Distance [m] up to which a point and a joint are the same."""
_BEHIND = 0.3
"""Extent behind the joint, as a share of that ahead, from which on a segment has a bone there."""
_BESIDE = 3.0
"""A sphere whose centre is so many radii from the bones of its segment has one of its own, as a thumb
has."""
_MOST_BESIDE = 2
_SHORT_BONE = 0.02
"""Length [m] of the bone of a segment whose joint is at its origin."""


def bones_of(body: Body, world: Floats) -> Bones:
    """Return the bones of a placed body, in the order of its segments.

    A bone runs from the proximal joint of its segment (the stage: its origin) to each distal joint. A
    segment without a distal joint has a bone to the farthest of its spheres, one behind the joint
    if it reaches there, as a heel does, and one to what stands far beside these, as a thumb does. A segment without spheres has no bone: nothing of a surface
    is its own, as of the stage that a person stands on.

    Parameters
    ----------
    body
        One body.
    world
        (N, 3, 4) world-from-segment transforms [m].
    """
    names: list[str] = []
    ends: list[tuple[Floats, Floats]] = []
    for n in np.flatnonzero(_has_spheres(body)).tolist():
        name = body.segments[n]
        rotation = world[n, :, :3]
        origin = world[n, :, 3]
        start = body.joint_in_child[0, n - 1] if n else np.zeros(3)
        tips = [
            p for p in _distal_joints(body, n) if np.linalg.norm(p - start) > _SAME_POINT
        ] or _tips(body, n, start)
        for tip in tips:
            names.append(name)
            ends.append((rotation @ start + origin, rotation @ tip + origin))
    return Bones(tuple(names), np.array([e[0] for e in ends]), np.array([e[1] for e in ends]))


def _has_spheres(body: Body) -> Bools:
    """(N,) which segments have spheres."""
    return np.diff(body.start) > 0


def _distal_joints(body: Body, segment: int) -> list[Floats]:
    """Joints (3,) [m] at which other segments are attached to a segment, in its frame."""
    return [
        body.joint_in_parent[0, j] for j in range(len(body.joints)) if body.parent[j + 1] == segment
    ]


def _tips(body: Body, segment: int, start: Floats) -> list[Floats]:
    """Ends (3,) of the bones of a segment without distal joints: far sphere centres ahead and behind."""
    centre = body.centre[0, body.spheres(segment)]
    ahead_vector = -start  # from the joint to the origin, the centre of gravity
    length = float(np.linalg.norm(ahead_vector))
    if length < _SAME_POINT or not len(centre):
        short = np.array([0.0, 0.0, _SHORT_BONE])
        return [start + (ahead_vector if length >= _SAME_POINT else short)]
    reach = (centre - start) @ (ahead_vector / length)
    ahead = int(reach.argmax())
    back = int(reach.argmin())
    tips = [centre[ahead] if reach[ahead] > length else start + ahead_vector]
    if reach[back] < -_BEHIND * max(float(reach[ahead]), length):
        tips.append(centre[back])
    radius = body.radius[0, body.spheres(segment)]
    for _ in range(_MOST_BESIDE):
        beside = np.min([_from_bone(centre, start, tip) for tip in tips], axis=0) / radius
        if beside.max() <= _BESIDE:
            break
        tips.append(centre[int(beside.argmax())])
    return tips


def _from_bone(points: Floats, start: Floats, tip: Floats) -> Floats:
    """Distance (n,) [m] of points (n, 3) from a bone."""
    bone = tip - start
    share = np.clip((points - start) @ bone / (bone @ bone), 0.0, 1.0)
    found: Floats = np.linalg.norm(points - start - share[:, None] * bone, axis=1)
    return found


def spheres_in_frames(
    body: Body, world: Floats, cut: SegmentedFit
) -> dict[str, tuple[Floats, Floats]]:
    """Return the fitted spheres of each segment in its own frame.

    Parameters
    ----------
    body
        One body.
    world
        (N, 3, 4) world-from-segment transforms [m] in which the surface was cut.
    cut
        The fit.

    Returns
    -------
    dict
        Centres (n, 3) and radii (n,) [m] by segment that has spheres. A sphere at a joint has exactly
        its coordinates.

    Raises
    ------
    InputError
        If a joint has no sphere.
    """
    found = {}
    has_spheres = _has_spheres(body)
    for n in np.flatnonzero(has_spheres).tolist():
        name = body.segments[n]
        centre, radius = cut.spheres(name)
        local = (centre - world[n, :, 3]) @ world[n, :, :3]
        proximal = [body.joint_in_child[0, n - 1]] if n else []
        if n and not has_spheres[body.parent[n]]:  # no bone ends there: a sphere within the others
            within = float((radius - np.linalg.norm(local - proximal[0], axis=1)).max())
            local = np.concatenate([local, proximal])
            radius = np.append(radius, max(within, _SAME_POINT))
        for joint in [*_distal_joints(body, n), *proximal]:
            gap = np.linalg.norm(local - joint, axis=1)
            if not len(gap) or gap.min() > _SAME_POINT:
                raise InputError(f"segment {name}: no sphere at one of its joints")
            local[gap.argmin()] = joint
        found[name] = local, radius
    return found


def named_rows(
    body: Body, segment: int, centre: Floats, radius: Floats
) -> dict[int, tuple[str, ...]]:
    """Give the names of a segment's spheres to fitted spheres.

    A name goes to the sphere whose surface is nearest to the outermost point of the sphere that had
    it. No sphere gets two.

    Parameters
    ----------
    body, segment
        One body, and the number of a segment.
    centre, radius
        Fitted spheres (n, 3) and (n,) [m], in the segment's frame.

    Returns
    -------
    dict
        Name, and direction if it has one, by the index of the fitted sphere.
    """
    rows: dict[int, tuple[str, ...]] = {}
    free = np.ones(len(radius), dtype=np.bool_)
    for s in range(body.start[segment], body.start[segment + 1]):
        name = body.sphere_names[s]
        if not name or not free.any():
            continue
        gap = np.abs(np.linalg.norm(_outermost_point(body, segment, s) - centre, axis=1) - radius)
        gap[~free] = np.inf
        best = int(gap.argmin())
        free[best] = False
        direction = int(body.sphere_direction[s])
        rows[best] = (name, DIRECTIONS[direction]) if direction >= 0 else (name,)
    return rows


def _outermost_point(body: Body, segment: int, sphere: int) -> Floats:
    """(3,) [m] point of a sphere in its named direction, or away from the segment's origin."""
    centre = body.centre[0, sphere]
    direction = int(body.sphere_direction[sphere])
    outward = centre / max(float(np.linalg.norm(centre)), 1e-9)
    if direction >= 0:
        outward = body.directions[segment, direction]
    return np.asarray(centre + body.radius[0, sphere] * outward)
