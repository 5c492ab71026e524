"""All the shapes a body can be stretched to: five numbers for each pair of segments, factors along x, y, z and for the
radii, and a taper: how much thicker the one end gets than the other.

Centres, joints and radii are linear in the factors. Every posture of the anthropometer is too, so the places of all
spheres and joints for each factor by itself are worked out once a body, and any shape is a sum of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.shape.manikin import POSTURES, Length, Manikin, Shape

__all__ = ["KNOBS", "ShapeSpace", "shape_space"]

KNOBS = 5
"""Numbers a group of segments: factors along x, y, z, factor of the radii, taper."""
ROUND, ALONG, SMOOTH, LEAST, EVEN = 4.0, 0.5, 1.0, 0.25, 1.5


@dataclass(frozen=True, eq=False)
class ShapeSpace:
    """K factors of a body of N segments.

    groups (N,): the group of each segment, KNOBS factors each; neutral (K,): those
    of the unchanged body; basis: for the
    fields of Shape the stacked (K, ...) parts; spheres, joints: by posture (K, S, 3) and (K, J, 3); price (K, K): the
    quadratic cost of factors that leave 1, differ within a segment or between neighbours; overlaps (N, N): of the
    unchanged body."""

    base: Manikin
    groups: Ints
    basis: Shape
    spheres: dict[str, Floats]
    joints: dict[str, Floats]
    price: Floats
    overlaps: Floats
    neutral: Floats

    def shape(self, factors: Floats) -> Shape:
        """The shape with these factors (K,)."""
        basis = self.basis
        return Shape(
            np.tensordot(factors, basis.centre, axes=1),
            factors @ basis.radius,
            np.tensordot(factors, basis.in_parent, axes=1),
            np.tensordot(factors, basis.in_child, axes=1),
        )

    def manikin(self, factors: Floats) -> Manikin:
        """The body with these factors, in all postures."""
        placed = {
            name: (np.tensordot(factors, self.spheres[name], axes=1), np.tensordot(factors, self.joints[name], axes=1))
            for name in POSTURES
        }
        return self.base.changed(self.shape(factors), placed)

    def row(self, length: Length) -> Floats:
        """(K,) what each factor adds to a length whose extreme spheres are held fixed."""
        total = np.zeros(len(self.price))
        for sign, reach in length.terms:
            if reach.joint >= 0:
                places = self.joints[reach.posture][:, reach.joint]
            else:
                places = self.spheres[reach.posture][:, reach.sphere]
            total += sign * (places @ np.array(reach.direction))
            if reach.joint < 0 and reach.surface:
                total += sign * self.basis.radius[:, reach.sphere]
        return total


@lru_cache(maxsize=16)
def shape_space(body: Body) -> ShapeSpace:
    """The shapes of a body, worked out once (nouns are frozen and compare by identity)."""
    groups = _groups(body)
    basis = _basis(body, groups)
    base = Manikin(body)
    placed = [base.changed(shape).placed for shape in basis]
    stacked = Shape(*(np.stack([getattr(s, field) for s in basis]) for field in
                      ("centre", "radius", "in_parent", "in_child")))  # fmt: skip
    return ShapeSpace(
        base=base,
        groups=groups,
        basis=stacked,
        spheres={name: np.stack([p[name][0] for p in placed]) for name in POSTURES},
        joints={name: np.stack([p[name][1] for p in placed]) for name in POSTURES},
        price=_price(body, groups),
        overlaps=base.overlaps(),
        neutral=np.tile([1.0, 1.0, 1.0, 1.0, 0.0], int(groups.max()) + 1),
    )


def _groups(body: Body) -> Ints:
    """(N,) left and right twins, known by their names, change together."""
    plain = [name.removeprefix("left ").removeprefix("right ") for name in body.segment_names]
    order = list(dict.fromkeys(plain))
    return np.array([order.index(name) for name in plain])


def _basis(body: Body, groups: Ints) -> list[Shape]:
    """The shapes whose sums with the factors as weights are all the shapes there are."""
    segment = body.sphere_segment
    parent, child = groups[body.parent[1:]], groups[1:]
    shapes = []
    for group in range(int(groups.max()) + 1):
        mine = (groups[segment] == group)[:, None]
        above, below = (parent == group)[:, None], (child == group)[:, None]
        for axis in range(4):
            along = np.eye(4)[axis, :3]
            shapes.append(Shape(
                body.centre * mine * along,
                body.radius * mine[:, 0] * float(axis == 3),
                body.joint_in_parent * above * along,
                body.joint_in_child * below * along,
            ))  # fmt: skip
        long, middle, half = _extent(body, groups, group)
        across = 1.0 - np.eye(3)[long]

        def taper(points: Floats, long: int = long, middle: float = middle, half: float = half) -> Floats:
            share: Floats = (points[:, long : long + 1] - middle) / half
            return share

        shapes.append(Shape(
            body.centre * mine * across * taper(body.centre),
            body.radius * mine[:, 0] * taper(body.centre)[:, 0],
            body.joint_in_parent * above * across * taper(body.joint_in_parent),
            body.joint_in_child * below * across * taper(body.joint_in_child),
        ))  # fmt: skip
    return shapes


def _extent(body: Body, groups: Ints, group: int) -> tuple[int, float, float]:
    """The long axis of a group's spheres, their middle along it and half their extent [m]."""
    centres = body.centre[groups[body.sphere_segment] == group]
    if len(centres) < 2:
        return 2, 0.0, 1.0
    span = np.ptp(centres, axis=0)
    long = int(np.argmax(span))
    return long, float(centres[:, long].min() + 0.5 * span[long]), max(float(0.5 * span[long]), 1e-3)


def _price(body: Body, groups: Ints) -> Floats:
    """Cross sections stay round (radius against the two axes across); lengths are freer to go their own way."""
    count = int(groups.max()) + 1
    unit = np.eye(KNOBS * count)
    rows = [LEAST * row for row in unit]
    for group in range(count):
        long = _extent(body, groups, group)[0]
        first = KNOBS * group
        for axis in range(3):
            rows.append((ALONG if axis == long else ROUND) * (unit[first + axis] - unit[first + 3]))
        rows.append(EVEN * unit[first + 4])
    for child in range(1, len(groups)):
        one, other = groups[child], groups[body.parent[child]]
        if one != other:
            rows.append(SMOOTH * (unit[KNOBS * one + 3] - unit[KNOBS * other + 3]))
    stacked = np.array(rows)
    price: Floats = stacked.T @ stacked
    return price
