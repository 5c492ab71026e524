"""Which segments' spheres may hold which part of a surface."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from workbench.model.arrays import Floats, Ints

__all__ = ["Regions", "nearest_bones"]


@dataclass(frozen=True, eq=False)
class Regions:
    """Bones, each from one end (B, 3) to the other (B, 3) [m], and how softly a point passes from one to the next.

    Without bones all belongs to one region. border: a point belongs also to bones whose distance is at most 1 + border
    times that of its nearest bone.
    """

    head: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    tail: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    border: float = 0.35

    def own(self, points: Floats) -> Ints:
        """(n,) the one bit of the region of each point."""
        if not len(self.head):
            return np.ones(len(points), dtype=np.int64)
        bit: Ints = np.int64(1) << bone_distance(points, self.head, self.tail).argmin(axis=1)
        return bit

    def may(self, points: Floats) -> Ints:
        """(n,) the bits of all regions whose spheres may hold each point."""
        if not len(self.head):
            return np.ones(len(points), dtype=np.int64)
        far = bone_distance(points, self.head, self.tail)
        near = far <= (1 + self.border) * far.min(axis=1, keepdims=True) + 1e-12
        bits: Ints = (near * (np.int64(1) << np.arange(len(self.head)))).sum(axis=1)
        return bits


def nearest_bones(points: Floats, head: Floats, tail: Floats) -> Ints:
    """(n,) the bone nearest to each point (n, 3); bones (B, 3) to (B, 3)."""
    number: Ints = bone_distance(points, head, tail).argmin(axis=1)
    return number


def bone_distance(points: Floats, head: Floats, tail: Floats) -> Floats:
    """(n, B) distance [m] of points (n, 3) to bones, as line segments."""
    along = tail - head
    square = np.maximum(np.einsum("bc,bc->b", along, along), 1e-18)
    distance = np.empty((len(points), len(head)))
    for b in range(len(head)):
        t = np.clip((points - head[b]) @ along[b] / square[b], 0.0, 1.0)
        distance[:, b] = np.linalg.norm(points - head[b] - t[:, None] * along[b], axis=1)
    return distance
