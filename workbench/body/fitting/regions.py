"""Which segments' spheres must hold which part of a surface: the nearest bone, measured in the
bone's own thickness."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["EVERYONE", "Regions", "bone_distance"]

EVERYONE = np.int64(2**62 - 1)
"""The bits of all segments."""


_BEYOND = 1.1
_INSIDE = 0.45
"""Thicknesses: a limb's lap over a joint is 0.4 long at its middle line."""


@dataclass(frozen=True, eq=False)
class Regions:
    """Bones from head (B, 3) to tail (B, 3) [m], the segment each belongs to, owner (B,), numbered
    from 0.

    thickness (B, K) [m]: how deep under the surface the bone runs, at K even steps; a place 30 mm
    from a bone in a thin arm is farther from it than one 60 mm from a bone in a thick trunk. beside
    (N, N): segments that share a joint (or are the same). border: a place within 1 + border times
    the measure of its own segment is held by a neighbour as well, so that both still meet when the
    joint bends. Without bones all belongs to one segment.
    """

    head: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    tail: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    owner: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    thickness: Floats = field(default_factory=lambda: np.ones((0, 2)))
    beside: Bools = field(default_factory=lambda: np.ones((1, 1), dtype=np.bool_))
    border: float = 0.08

    @property
    def count(self) -> int:
        """How many segments there are."""
        return len(self.beside)

    def measure(self, points: Floats) -> Floats:
        """(n, N) distance of points (n, 3) to the bones of each segment, in units of the bone's
        thickness there."""
        far, share, beyond = bone_distance(points, self.head, self.tail)
        steps = self.thickness.shape[1] - 1
        low = np.minimum((share * steps).astype(np.int64), steps - 1)
        part = share * steps - low
        bone = np.arange(len(self.head))
        thick = (1 - part) * self.thickness[bone, low] + part * self.thickness[bone, low + 1]
        # behind an end, as at a heel, bones that meet there are equally near: that which points
        # there is the nearer
        far = far + 0.1 * beyond
        found = np.full((len(points), self.count), np.inf)
        for b, owner in enumerate(self.owner):
            found[:, owner] = np.minimum(found[:, owner], far[:, b] / thick[:, b])
        return found

    def reach(self, points: Floats, bits: Ints) -> Floats:
        """(n,) how deep [m] under each point a sphere of a segment, given as its bit (n,), may have
        its centre: about as deep as the segment's bones. A sphere beyond them would leave its place
        when the joint turns."""
        if self.count == 1:
            return np.full(len(points), np.inf)
        far = bone_distance(points, self.head, self.tail)[0]
        mine = (bits[:, None] >> self.owner) & 1 == 1
        nearest: Floats = np.where(mine, far, np.inf).min(axis=1)
        return _BEYOND * nearest

    def foreign(self, points: Floats, bits: Ints) -> Bools:
        """(n,) True where a point lies far inside the part of another segment than that given by
        its bit (n,)."""
        if self.count == 1:
            return np.zeros(len(points), dtype=np.bool_)
        found = self.measure(points)
        mine = np.where((bits[:, None] >> np.arange(self.count)) & 1 == 1, found, np.inf).min(
            axis=1
        )
        far: Bools = mine - found.min(axis=1) > _INSIDE
        return far

    def number(self, points: Floats) -> Ints:
        """(n,) the segment each point belongs to."""
        if self.count == 1:
            return np.zeros(len(points), dtype=np.int64)
        segment: Ints = self.measure(points).argmin(axis=1)
        return segment

    def own(self, points: Floats) -> Ints:
        """(n,) the one bit of the segment each point belongs to."""
        bit: Ints = np.int64(1) << self.number(points)
        return bit

    def shared(self, points: Floats) -> Bools:
        """(n, N) the segments whose spheres must each hold a point: its own, and a neighbour near
        the border."""
        if self.count == 1:
            return np.ones((len(points), 1), dtype=np.bool_)
        found = self.measure(points)
        segment = found.argmin(axis=1)
        near = found <= (1 + self.border) * found.min(axis=1, keepdims=True)
        both: Bools = near & self.beside[segment]
        both[np.arange(len(points)), segment] = True
        return both


def bone_distance(points: Floats, head: Floats, tail: Floats) -> tuple[Floats, Floats, Floats]:
    """Distance (n, B) [m] of points (n, 3) to bones, as line segments, how far along each the foot
    is, 0 to 1, and how far beyond an end [m] the point lies, along the bone."""
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
