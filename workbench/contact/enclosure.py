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
from workbench.contact.fields import packed_faces, packed_shells
from workbench.contact.kernels.clearance import ClearanceTask
from workbench.contact.kernels.inside import crossings_between, odd_shares
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
        rows = np.flatnonzero(_beyond(body, centres, placed.world_from_segment[p], environment, k))
        rows = rows[placed.window[body.sphere_segment[rows]]]
        number = np.arange(len(rows))
        row = np.stack([number, number, np.full(len(rows), k), np.zeros(len(rows), np.int64)], 1)
        task = ClearanceTask(rows, np.arange(len(rows) + 1), row, np.zeros(len(rows)))
        bodies = centres[None], radius[None], np.zeros((1, 3))
        found = least_clearances(bodies, task, environment, len(rows))
        beyond = -(found.distance[0] + 2.0 * radius[rows])
        for q in np.argsort(-beyond).tolist():
            where = p, int(body.sphere_segment[rows[q]]), k
            if beyond[q] < near.distance[where]:
                near.distance[where] = beyond[q]
                near.sphere[where] = rows[q]
                near.polygon[where] = found.polygon[0, q]
                near.point[where] = found.point[0, q]


def _beyond(
    body: Body, centres: Floats, world: Floats, environment: Environment, part: int
) -> Bools:
    """(S,) the spheres beyond a surface of limbs that go through it, of one pose: centres (S, 3), world from segment (N, 3, 4)."""
    largest = _largest(body)
    middle = np.array(world[..., 3])
    middle[body.sphere_segment[largest]] = centres[largest]
    joint = np.einsum("nij,nj->ni", world[1:, :, :3], body.joint_in_child[0]) + world[1:, :, 3]
    parent = body.parent[1:]
    crossed = []
    for start, end in (
        (middle[parent], joint),
        (joint, middle[1:]),
        (middle[body.sphere_segment], centres),
    ):
        count = np.zeros(len(start), dtype=np.int64)
        ways = np.ascontiguousarray(start), np.ascontiguousarray(end)
        index = packed_faces(environment), packed_shells(environment)
        crossings_between(*ways, *index, part, np.empty(64, dtype=np.int64), count)
        crossed.append(count)
    side = np.zeros(len(world), dtype=np.int64)
    for n, above in enumerate(parent.tolist(), 1):
        side[n] = side[above] + crossed[0][n - 1] + crossed[1][n - 1]
    own = side[body.sphere_segment]
    here = own[np.argmax(body.radius[0])]
    return np.asarray((own != here) & (own + crossed[2] != here))


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
