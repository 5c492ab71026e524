"""How far a body is from its own mirror image in the plane y = 0 of its zero pose."""

from __future__ import annotations

import numpy as np

FLIP = np.array([1.0, -1.0, 1.0])


def other_side(name, names):
    """The name of the twin on the other side among names; a name of the middle is its own twin."""
    turned = {"L": "R", "R": "L"}.get(name[0], name[0]) + name[1:]
    return turned if turned in names else name


def twins_of(body):
    """(N,) the segment on the other side of each."""
    names = body.segments
    return np.array([names.index(other_side(name, names)) for name in names])


def asymmetry(body):
    """Greatest distance [m] of a sphere, a joint or a segment's origin from a mirror image of
    another, of a radius from its twin's, and of a mass [kg] from its twin's."""
    placed_origin = body.zero_origins[0]
    twin = twins_of(body)
    worst = [
        float(np.abs(placed_origin - placed_origin[twin] * FLIP).max()),
        float(np.abs(body.mass[0] - body.mass[0, twin]).max()),
    ]
    rows = np.column_stack([placed_origin[body.sphere_segment] + body.centre[0], body.radius[0]])
    for n in range(len(body.segments)):
        here = rows[body.sphere_segment == n]
        there = rows[body.sphere_segment == twin[n]] * [*FLIP, 1.0]
        assert len(here) == len(there)
        if len(here):
            gap = np.abs(here[:, None] - there[None]).max(axis=2)
            worst.append(float(gap.min(axis=1).max()))
    joints = placed_origin[body.parent[1:]] + body.joint_in_parent[0]
    image = [body.joints.index(other_side(name, body.joints)) for name in body.joints]
    worst.append(float(np.abs(joints - joints[image] * FLIP).max()))
    return max(worst)
