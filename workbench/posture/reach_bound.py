"""Bound what a limb reaches by balls, without solving for a posture.

Let the limb turn first in a joint at c, v [m] lead from there to its next joint, and the other links
be l_2 ... l_n long in a line. Wherever the next joint is, at c + R v, the tip lies in the ball about
it of radius

    L = l_2 + ... + l_n.

The swing a and the twist t of a joint with a swing cone lie in a box of its limits, which is split
into cells. Within a cell of half-widths h (of the swing) and w (of the twist) about a0 and t0,

    |R v - R0 v| <= |h| |v| + w |v'|,   v' being v across the twist axis,

since exp(a) is within |a - a0| of exp(a0). So the tip lies in one of the balls about the points
c + R0 v, larger than L by so much. Of another kind of joint there is one ball, about c.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.body.forward import segment_frames
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.poses import Poses, people_of
from workbench.model.quaternions import exponential, matrices, multiply
from workbench.model.stops import StopKind, Stops
from workbench.posture.reaching.limbs import Limb
from workbench.posture.reaching.linkage import joints_between

__all__ = ["ReachBound", "reach_bound"]

CELLS = (5, 5, 2)
"""Cells of a box of swing and twist, along each axis: with more the balls become smaller by less
than they cost."""
BREACH = 2e-3
"""How much larger [m] the balls are, since a solution may lie past its stops by rounding."""


@dataclass(frozen=True, eq=False)
class ReachBound:
    """Balls of B people, of which one at least holds any point that the limb brings its tip to.

    centre (B, G, 3) and radius (B, G) [m].
    """

    centre: Floats
    radius: Floats

    def excludes(self, people: Ints, points: Floats) -> Bools:
        """(P,) whether points (P, 3) [m], each of one of the people (P,), are in none of the
        balls."""
        return self.misses(people, points) > 0.0

    def misses(self, people: Ints, points: Floats) -> Floats:
        """(P,) [m] by how much the limb misses points (P, 3) [m], each of one of the people (P,), at
        least: their distance from the nearest ball, 0 within one."""
        away = points[:, None] - self.centre[people]
        outside = np.sqrt(np.einsum("pgi,pgi->pg", away, away)) - self.radius[people]
        return np.maximum(outside.min(axis=1), 0.0)


def reach_bound(body: Body, poses: Poses, limb: Limb) -> ReachBound:
    """Bound what a limb reaches from B poses, in its own harness zone.

    Parameters
    ----------
    body, poses
        B poses of the rows of a body. The joints that the limb does not move stay as they are.
    limb
        The limb, of this body.

    Raises
    ------
    InputError
        If the poses are of another body.
    """
    person = people_of(body, poses)
    joints = joints_between(body, limb.base, limb.end)
    first = next(k for k, joint in enumerate(joints) if joint in limb.free)
    links = [
        body.joint_in_parent[person, after] - body.joint_in_child[person, joint]
        for joint, after in zip(joints[first:], joints[first + 1 :], strict=False)
    ]
    links.append(limb.tip[person] - body.joint_in_child[person, joints[-1]])
    length = np.linalg.norm(links[1:], axis=2).sum(axis=0) + BREACH
    joint = joints[first]
    frame = segment_frames(body, poses, int(body.parent[joint + 1]))
    pivot = _turned(frame, body.joint_in_parent[person, joint][:, None])[:, 0] + frame[:, :, 3]
    link = links[0]
    size = np.linalg.norm(link, axis=1)
    if body.stops.kind[joint] != StopKind.CONE:
        return ReachBound(pivot[:, None], (length + size)[:, None])
    turns, swing, twist = _cells(body.stops, joint)
    ends = np.einsum("gij,bj->bgi", turns, link)
    across = np.linalg.norm(np.cross(link, body.stops.axes[joint, 2]), axis=1)
    radius = length + swing * size + twist * across
    centre = pivot[:, None] + _turned(frame, ends)
    return ReachBound(centre, np.repeat(radius[:, None], len(turns), axis=1))


def _turned(frame: Floats, vectors: Floats) -> Floats:
    """Vectors (B, G, 3) of frames (B, 3, 4) as they stand in the world."""
    return np.einsum("bij,bgj->bgi", frame[:, :, :3], vectors)


def _cells(stops: Stops, joint: int) -> tuple[Floats, float, float]:
    """The middles (G, 3, 3) of the cells of a joint with a swing cone, as rotations, and how far
    [rad] a swing and a twist of a cell are from its middle at most."""
    middles = []
    half = []
    for (first, second), count in zip(stops.limits[joint], CELLS, strict=True):
        half.append(0.5 * (first + second) / count)
        middles.append(-second + half[-1] * (2.0 * np.arange(count) + 1.0))
    one, two, turn = (values.ravel() for values in np.meshgrid(*middles, indexing="ij"))
    axes = stops.axes[joint]
    swing = exponential(one[:, None] * axes[0] + two[:, None] * axes[1])
    twist = exponential(turn[:, None] * axes[2])
    return matrices(multiply(swing, twist)), float(np.hypot(half[0], half[1])), float(half[2])
