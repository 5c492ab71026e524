"""Derived geometry of a body's segments: lines that twist is shared along, and enclosing spheres."""

from __future__ import annotations

import numpy as np

from workbench.files.body_schema import BodyFile
from workbench.model.arrays import Floats, Ints

__all__ = ["Lines", "enclosing", "line_of", "twist_lines", "twist_share"]

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


def line_of(lines: Lines, segment: int) -> tuple[Floats, Floats] | None:
    """Point and direction of a segment's twist line, None where it has none."""
    return (lines[1][segment], lines[2][segment]) if lines[0][segment] >= 0 else None


def enclosing(spheres: tuple[Floats, Floats], axis: tuple[Floats, Floats] | None) -> tuple[Floats, float]:
    """A small sphere around spheres; with its centre on the twist axis where there is one, so that any twist fits."""
    centre, radius = spheres
    if not len(centre):
        return np.zeros(3), 0.0
    best = (centre * radius[:, None]).sum(axis=0) / radius.sum()
    step = 1.0
    for _ in range(200):
        if axis is not None:
            best = axis[0] + axis[1] * ((best - axis[0]) @ axis[1])
        reach = np.linalg.norm(centre - best, axis=1) + radius
        far = int(np.argmax(reach))
        step *= 0.95
        best = best + step * 0.5 * (centre[far] - best)
    if axis is not None:
        best = axis[0] + axis[1] * ((best - axis[0]) @ axis[1])
    return best, float((np.linalg.norm(centre - best, axis=1) + radius).max()) + 1e-12
