"""Find the open parts that a body stands in or goes through: where a part has no inside, nothing else
would notice.

From a point inside a closed surface every line of sight crosses it an odd number of times, whatever
its winding; from a point outside an even number of times. Of a surface with holes both hold for the
lines that miss the holes. A point counts as enclosed where more than `ENCLOSED` of `LINES` lines
cross an odd number of times, and a body where most of its segments are, each at the centre of its
largest sphere. A wall modelled with both its sides is crossed twice, so that a person between such
walls is not in them.

A limb goes through a surface where the way inside the body does, from the largest sphere by the joints
to the middle of a segment. Who enters a box by its opening goes through nothing, and neither does a
sole or a thigh whose skin alone is beyond a thin pedal or cushion.
"""

from __future__ import annotations

import numpy as np

from workbench.contact.batches import least_clearances
from workbench.contact.distance_fields import packed_faces, packed_shells
from workbench.contact.kernels.clearance import ClearanceTask
from workbench.contact.kernels.point_in_solid import crossings_between, odd_shares
from workbench.contact.kernels.search import Nearest
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.poses import Placed

__all__ = ["ENCLOSED", "LINES", "deepen", "enclosed"]

LINES = 96
"""Directions, spread evenly over the sphere."""
ENCLOSED = 0.6
"""Share of the lines from a point that must cross an odd number of times: 5/6 do in the middle of a
cube with one face missing, one half in the middle of a face that is missing, less outside."""
_LEAN = np.array([1.37, 1.21, 1.29])


def enclosed(placed: Placed, environment: Environment, part: int) -> Floats:
    """(P,) the share of the body's segments that a part encloses, pose by pose; segments out of
    sight do not count."""
    body = placed.body
    rows = _largest(body)[placed.window[np.diff(body.start) > 0]]
    points = np.ascontiguousarray(placed.centres[:, rows].reshape(-1, 3))
    faces = packed_faces(environment)
    shells = packed_shells(environment)
    share = np.zeros(len(points))
    odd_shares(points, _directions(), faces, shells, part, np.empty(64, dtype=np.int64), share)
    return (share.reshape(len(placed), -1) > ENCLOSED).mean(axis=1)


def deepen(near: Nearest, placed: Placed, environment: Environment) -> None:
    """Count depth in parts that are no solids as in solids, where limbs go through them, in place.

    A sphere of such a limb beyond the surface is as deep as its centre is away from the part, and its
    radius more. By itself it overlaps a surface by a radius at most.

    Parameters
    ----------
    near
        What of P poses (P, N, K) is nearest, as `clearance_by_part` finds it.
    placed
        These poses, of a body of one row.
    """
    body = placed.body
    radius = body.radius[0]
    about = np.isfinite(near.distance).any(axis=1) & ~environment.solid
    for p, k in np.argwhere(about).tolist():
        centres = placed.centres[p]
        beyond = _beyond(body, centres, placed.world_from_segment[p], environment, k)
        rows = np.flatnonzero(beyond & placed.window[body.sphere_segment])
        each = np.arange(len(rows) + 1)
        row = np.stack([each[:-1], each[:-1], 0 * rows + k, 0 * rows], axis=1)
        task = ClearanceTask(rows, each, row, np.zeros(len(rows)))
        bodies = centres[None], radius[None], np.zeros((1, 3))
        found = least_clearances(bodies, task, environment, len(rows))
        depth = found.distance[0] + 2.0 * radius[rows]
        for q in np.argsort(depth).tolist():  # the deepest last
            where = p, int(body.sphere_segment[rows[q]]), k
            if -depth[q] < near.distance[where]:
                there = (-depth[q], rows[q], found.polygon[0, q], found.point[0, q])
                for values, value in zip(near, there, strict=True):
                    values[where] = value


def _beyond(
    body: Body, centres: Floats, world: Floats, environment: Environment, part: int
) -> Bools:
    """(S,) the spheres beyond a surface of limbs that go through it, of one pose: centres (S, 3), world from segment (N, 3, 4)."""
    largest = _largest(body)
    middle = np.array(world[..., 3])
    middle[body.sphere_segment[largest]] = centres[largest]
    joint = np.einsum("nij,nj->ni", world[1:, :, :3], body.joint_in_child[0]) + world[1:, :, 3]
    parent = body.parent[1:]
    start = np.concatenate([middle[parent], joint, middle[body.sphere_segment]])
    end = np.concatenate([joint, middle[1:], centres])
    # no component of a way is zero: it leans aside by a part in 1e9
    ways = end - start + 1e-9 * (np.abs(end - start).sum(axis=1) + 1e-6)[:, None] * _LEAN
    index = packed_faces(environment), packed_shells(environment), part
    wide = 4e-12 * max(np.abs(end).max(), np.abs(environment.vertices).max())
    count = np.zeros(len(start), dtype=np.int64)
    crossings_between(start, end, ways, wide, *index, np.empty(64, dtype=np.int64), count)
    to_joint, to_middle, to_sphere = np.split(count, [len(parent), 2 * len(parent)])
    side = np.zeros(len(world), dtype=np.int64)
    for n, above in enumerate(parent.tolist()):
        side[n + 1] = side[above] + to_joint[n] + to_middle[n]
    here = side[body.sphere_segment]
    root = here[np.argmax(body.radius[0])]
    return np.asarray((here != root) & (here + to_sphere != root))


def _largest(body: Body) -> Ints:
    """The largest sphere of each segment that has any."""
    rows = [row for row in map(body.spheres, range(len(body.segments))) if row.stop > row.start]
    return np.array(
        [row.start + int(np.argmax(body.radius[0, row])) for row in rows], dtype=np.int64
    )


def _directions() -> Floats:
    """(LINES, 3) unit vectors on a golden spiral, turned so that none has a component of zero."""
    n = np.arange(LINES) + 0.5
    height = 1.0 - 2.0 * n / LINES
    around = np.pi * (1.0 + np.sqrt(5.0)) * n + 0.1234
    flat = np.sqrt(1.0 - height**2)
    return np.stack([flat * np.cos(around), flat * np.sin(around), height], axis=1)
