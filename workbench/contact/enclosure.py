"""Find the open parts that a body stands in: where a part has no inside, nothing else would notice.

From a point inside a closed surface every line of sight crosses it an odd number of times, whatever
its winding; from a point outside an even number of times. Of a surface with holes both hold for the
lines that miss the holes. A point counts as enclosed where more than `ENCLOSED` of `LINES` lines
cross an odd number of times, and a body where most of its segments are, each at the centre of its
largest sphere. A wall modelled with both its sides is crossed twice, so that a person between such
walls is not in them.
"""

from __future__ import annotations

import numpy as np

from workbench.contact.fields import packed_faces, packed_shells
from workbench.contact.kernels.inside import odd_shares
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.poses import Placed

__all__ = ["ENCLOSED", "LINES", "enclosed"]

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
