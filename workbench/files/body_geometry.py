"""Derived geometry of a body's segments: the lines that twist is shared along."""

from __future__ import annotations

import numpy as np

from workbench.files.body_schema import BodyFile
from workbench.model.arrays import Floats, Ints

__all__ = ["Lines", "twist_lines", "twist_share"]

Lines = tuple[Ints, Floats, Floats, Floats]


def twist_lines(tree: tuple[list[str], list[str]], file: BodyFile, ends: tuple[Floats, Floats]) -> Lines:
    """For each segment: the distal joint whose twist it shares, the line it turns about, and the line's length.

    The line runs from the proximal to the distal joint; its sense is that of the joint's own twist axis.
    """
    order, joints = tree
    in_parent, in_child = ends
    joint = np.full(len(order), -1)
    point, axis, length = np.zeros((len(order), 3)), np.zeros((len(order), 3)), np.ones(len(order))
    for n, name in enumerate(order):
        if (twist := file.segments[name].twist_along) is None:
            continue
        joint[n] = joints.index(twist)
        proximal = in_child[n - 1] if n else np.zeros(3)
        span = in_parent[joint[n]] - proximal
        length[n] = np.linalg.norm(span)
        point[n] = proximal
        axis[n] = span / length[n]
    return joint, point, axis, length


def twist_share(lines: Lines, spheres: tuple[Floats, Ints]) -> Floats:
    """(S,) the share of the joint's twist that each sphere takes: 0 at the proximal joint to 1 at the distal one."""
    joint, point, axis, length = lines
    centre, start = spheres
    share = np.zeros(len(centre))
    for n in np.flatnonzero(joint >= 0):
        rows = slice(start[n], start[n + 1])
        share[rows] = np.clip((centre[rows] - point[n]) @ axis[n] / length[n], 0.0, 1.0)
    return share
