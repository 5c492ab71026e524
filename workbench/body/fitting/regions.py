"""Find which segments' spheres must hold which part of a surface.

A place belongs to the nearest bone, with distances measured in the thickness of the part around the
bone. Where a body of spheres is known to stand in the surface, it belongs to the nearest sphere.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.distance import cdist

from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["EVERYONE", "Regions", "bone_distance"]

EVERYONE = np.int64(2**62 - 1)
"""The bits of all segments."""


_MAX_DEPTH = 1.1
"""Greatest depth of a sphere's centre, as a multiple of the distance to the bone."""
_FOREIGN = 0.45
"""Difference of distances, in thicknesses, from which on a point is far inside another part. A limb's
lap over a joint is 0.4 long at its middle line."""


_LIMB = 0.06
"""Gap [m] to a sphere that counts as one thickness."""
_WITHIN = 0.05
"""Least distance, in thicknesses: deep inside a sphere."""


@dataclass(frozen=True, eq=False)
class Regions:
    """The parts of N segments around B bones. Without bones, all belongs to one segment.

    A place 30 mm from the bone of a thin arm is farther from it than one 60 mm from the bone of a thick
    trunk.
    """

    head: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    """(B, 3) [m] where each bone begins."""
    tail: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    """(B, 3) [m] where it ends."""
    owner: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """(B,) number of its segment."""
    thickness: Floats = field(default_factory=lambda: np.ones((0, 2)))
    """(B, K) [m] depth of the bone under the surface, at K even steps."""
    beside: Bools = field(default_factory=lambda: np.ones((1, 1), dtype=np.bool_))
    """(N, N) True for segments that share a joint, or are the same."""
    border: float = 0.08
    """A place whose distance is up to 1 + border times that of its own segment belongs to a neighbour
    too, so that both still meet when the joint bends."""
    centre: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    """(S, 3) [m] centres of spheres that are known to stand in the surface; none decide if empty."""
    radius: Floats = field(default_factory=lambda: np.zeros(0))
    """(S,) [m]."""
    sphere_owner: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """(S,) number of the segment of each sphere."""

    @property
    def count(self) -> int:
        """Number of segments."""
        return len(self.beside)

    def measure(self, points: Floats) -> Floats:
        """Return the distance (n, N) of points (n, 3) to the bones, or spheres, of each segment, in
        thicknesses there."""
        if len(self.radius):
            return self._from_spheres(points)
        far, share, beyond = bone_distance(points, self.head, self.tail)
        steps = self.thickness.shape[1] - 1
        low = np.minimum((share * steps).astype(np.int64), steps - 1)
        part = share * steps - low
        bone = np.arange(len(self.head))
        thick = (1 - part) * self.thickness[bone, low] + part * self.thickness[bone, low + 1]
        # behind an end, as at a heel, bones that meet there are equally near: the bone that points
        # there is taken as the nearer one
        far = far + 0.1 * beyond
        found = np.full((len(points), self.count), np.inf)
        for b, owner in enumerate(self.owner):
            found[:, owner] = np.minimum(found[:, owner], far[:, b] / thick[:, b])
        return found

    def _from_spheres(self, points: Floats) -> Floats:
        """Distance (n, N): one thickness on the spheres of a segment, and one more each `_LIMB`
        farther."""
        found = np.full((len(points), self.count), np.inf)
        for owner in range(self.count):
            own = self.sphere_owner == owner
            far = cdist(points, self.centre[own]) - self.radius[own]
            found[:, owner] = far.min(axis=1, initial=np.inf)
        return np.maximum(1.0 + found / _LIMB, _WITHIN)

    def reach(self, points: Floats, bits: Ints) -> Floats:
        """Return how deep (n,) [m] under each point (n, 3) the centre of a segment's sphere may be.

        It is about as deep as the bones of the segment, given as its bit (n,). A sphere beyond them would
        leave its place when the joint turns.
        """
        if self.count == 1:
            return np.full(len(points), np.inf)
        far = bone_distance(points, self.head, self.tail)[0]
        mine = (bits[:, None] >> self.owner) & 1 == 1
        nearest: Floats = np.where(mine, far, np.inf).min(axis=1)
        return _MAX_DEPTH * nearest

    def foreign(self, points: Floats, bits: Ints) -> Bools:
        """Return True (n,) for points (n, 3) far inside another segment's part than that of their bit (n,)."""
        if self.count == 1:
            return np.zeros(len(points), dtype=np.bool_)
        found = self.measure(points)
        mine = np.where((bits[:, None] >> np.arange(self.count)) & 1 == 1, found, np.inf).min(
            axis=1
        )
        return mine - found.min(axis=1) > _FOREIGN

    def number(self, points: Floats) -> Ints:
        """Return the segment (n,) to which each point (n, 3) belongs."""
        if self.count == 1:
            return np.zeros(len(points), dtype=np.int64)
        return self.measure(points).argmin(axis=1)

    def own(self, points: Floats) -> Ints:
        """Return the bit (n,) of the segment to which each point (n, 3) belongs."""
        return np.int64(1) << self.number(points)

    def shared(self, points: Floats) -> Bools:
        """Return the segments (n, N) whose spheres must each hold a point (n, 3).

        They are its own, and a neighbour near the border.
        """
        if self.count == 1:
            return np.ones((len(points), 1), dtype=np.bool_)
        found = self.measure(points)
        segment = found.argmin(axis=1)
        near = found <= (1 + self.border) * found.min(axis=1, keepdims=True)
        both: Bools = near & self.beside[segment]
        both[np.arange(len(points)), segment] = True
        return both


def bone_distance(points: Floats, head: Floats, tail: Floats) -> tuple[Floats, Floats, Floats]:
    """Compute the distance of points to bones, which are line segments.

    Parameters
    ----------
    points
        (n, 3) [m].
    head, tail
        (B, 3) ends of the bones [m].

    Returns
    -------
    tuple of Floats
        Distance (n, B) [m]; position (n, B) of the nearest point along the bone, 0 to 1; and how far
        beyond an end the point lies (n, B) [m], along the bone.
    """
    along = tail - head
    square = np.maximum(np.einsum("bc,bc->b", along, along), 1e-18)
    distance, share, beyond = np.empty((3, len(points), len(head)))
    long = np.linalg.norm(along, axis=1)
    for b in range(len(head)):
        part = (points - head[b]) @ along[b] / square[b]
        share[:, b] = np.clip(part, 0.0, 1.0)
        beyond[:, b] = np.abs(part - share[:, b]) * long[b]
        distance[:, b] = np.linalg.norm(points - head[b] - share[:, b, None] * along[b], axis=1)
    return distance, share, beyond
