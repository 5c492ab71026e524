"""All the shapes a body can be given: a vector of numbers ("knobs") that its coordinates and radii
are linear in.

A body of a family has the family's coefficients as knobs. Every body can be stretched: five numbers
for each pair of segments, factors along x, y, z and for the radii, and a taper: how much thicker
the one end gets than the other. Every posture of the anthropometer is linear too, so what each knob
adds to any length is worked out once.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from workbench.body.scaling.manikin import AXES, QUEUE, Length, Manikin, Reach
from workbench.body.scaling.rig import Shape
from workbench.body.scaling.stretch import KNOBS, groups_of, stretch_price, stretch_shapes
from workbench.geometry.overlap import union_volumes
from workbench.model.arrays import Floats, Ints
from workbench.model.basis import Detail
from workbench.model.body import Body

__all__ = ["ShapeSpace", "detail_of", "shape_space", "volumes"]

_FIELDS = ("centre", "radius", "in_parent", "in_child")
CLOSING = 4.0e3
"""What a stretch costs a body of a family beside its coefficients: a factor of 1.02 about as much
as one standard deviation, so that lengths are found within the family first and stretching closes
what is left."""
VOLUME_LINES = 14
"""Lines each way across a segment that its volume is found by."""
NARROW = 0.02
"""Least standard deviation of a coefficient among people of a kind: however narrow they are, some
room is left."""


@dataclass(frozen=True, eq=False)
class ShapeSpace:
    """K knobs of a body of N segments; the first `family` of them are coefficients of its family,
    the rest stretch it.

    groups (N,): the group of each segment; neutral (K,): the knobs of the unchanged body; knobs:
    for the fields of Shape what each knob adds (K, ...); price (K, K): the quadratic cost of knobs
    off neutral, cheap its inverse; overlaps (N, N) [m], volume (N,) [m3]: of the unchanged body;
    tied: spheres that stand on a joint and these joints, of the parents, then of the children;
    likely: variances and axes, in the family's coefficients, of people like it.
    """

    base: Manikin
    groups: Ints
    family: int
    neutral: Floats
    knobs: Shape
    price: Floats
    cheap: Floats
    overlaps: Floats
    volume: Floats
    tied: tuple[tuple[Ints, Ints], tuple[Ints, Ints]]
    likely: tuple[Floats, Floats]
    _origins: Floats
    _joints: Floats
    _stacked: Floats
    _still: Floats
    _rows: dict[Reach, Floats] = field(default_factory=dict)

    def shape(self, values: Floats) -> Shape:
        """The shape with these knobs (K,); spheres that stand on joints stand on them exactly."""
        flat = (values - self.neutral) @ self._stacked + self._still
        shape = _apart(flat, len(self.base.rig.segment))
        (above, joint_above), (below, joint_below) = self.tied
        shape.centre[above] = shape.in_parent[joint_above]
        shape.centre[below] = shape.in_child[joint_below]
        return shape

    def manikin(self, values: Floats) -> Manikin:
        """The body with these knobs, in all postures."""
        return self.base.changed(self.shape(values))

    def row(self, length: Length) -> Floats:
        """(K,) what each knob adds to a length whose extreme spheres are held fixed."""
        total = np.zeros(len(self.neutral))
        for sign, reach in length.terms:
            if reach not in self._rows:
                self._rows[reach] = self._reach_row(reach)
            total += sign * self._rows[reach]
        return total

    def _reach_row(self, reach: Reach) -> Floats:
        q = QUEUE[reach.posture]
        along = AXES[reach.direction]
        if reach.joint >= 0:
            places: Floats = self._joints[q, :, reach.joint] @ along
            return places
        s = reach.sphere
        rig = self.base.rig
        places = self._origins[q, :, rig.segment[s]] @ along + self.knobs.centre[:, s] @ (
            along @ rig.turn[q, s]
        )
        for b in np.flatnonzero(rig.blended == s):
            end = self.knobs.in_child if rig.distal[b] else self.knobs.in_parent
            places = places + end[:, rig.joint[b]] @ (along @ rig.lever[q, b])
        return places + self.knobs.radius[:, s] if reach.surface else places


def volumes(body: Body, shape: Shape) -> Floats:
    """(N,) volume [m3] of the spheres of each segment together."""
    found: Floats = union_volumes(shape.centre, shape.radius, body.start, VOLUME_LINES)
    return found


@lru_cache(maxsize=16)
def shape_space(body: Body) -> ShapeSpace:
    """The shapes of a body, worked out once (nouns are frozen and compare by identity)."""
    groups = groups_of(body)
    stretch = stretch_shapes(body, groups)
    neutral = np.tile([1.0, 1.0, 1.0, 1.0, 0.0], len(stretch.radius) // KNOBS)
    price = stretch_price(body, groups)
    family = 0
    knobs = stretch
    likely = (np.zeros(0), np.zeros((0, 0)))
    if body.basis is not None:
        within = family_shapes(body)
        family = len(within.radius)
        knobs = Shape(*(np.concatenate([getattr(within, f), getattr(stretch, f)]) for f in _FIELDS))
        neutral = np.concatenate([body.basis_at[0], neutral])
        likely = _likely(body)
        both = np.zeros((family + len(price), family + len(price)))
        both[:family, :family] = (likely[1] / likely[0]) @ likely[1].T
        both[family:, family:] = CLOSING * price
        price = both
    base = Manikin(body)
    cheap: Floats = np.linalg.inv(price).astype(np.float64)
    measured = (price, cheap, base.overlaps(), volumes(body, base.shape), _tied(body), likely)
    stacked = np.concatenate([getattr(knobs, f).reshape(len(neutral), -1) for f in _FIELDS], axis=1)
    still = np.concatenate([getattr(base.shape, f).ravel() for f in _FIELDS])
    return ShapeSpace(
        base, groups, family, neutral, knobs, *measured, *base.rig.origins(knobs), stacked, still
    )


def _apart(flat: Floats, spheres: int) -> Shape:
    """The shape of a flat row of numbers: centres, radii, joints in their parents, joints in their
    children."""
    centre = flat[: 3 * spheres]
    radius = flat[3 * spheres : 4 * spheres]
    joints = flat[4 * spheres :]
    in_parent, in_child = joints.reshape(2, -1, 3)
    return Shape(centre.reshape(-1, 3), radius, in_parent, in_child)


def family_shapes(body: Body) -> Shape:
    """What each coefficient of the body's family adds to its spheres and joints, in segment frames:
    (K, ...)."""
    basis = body.basis
    assert basis is not None
    detail = detail_of(body)
    joint = basis.joint_basis
    origin = basis.origin_basis
    return Shape(
        detail.centre_basis - origin[:, detail.segment],
        detail.radius_basis,
        joint - origin[:, body.parent[1:]],
        joint - origin[:, 1:],
    )


def detail_of(body: Body) -> Detail:
    """The level of detail of its family that a body has: the one with as many spheres in each
    segment."""
    assert body.basis is not None
    counts = np.diff(body.start)
    levels = body.basis.details.values()
    return next(
        d for d in levels if np.array_equal(np.bincount(d.segment, minlength=len(counts)), counts)
    )


def _likely(body: Body) -> tuple[Floats, Floats]:
    """Variances (K,) and axes (K, K) of the coefficients among people like the nearest anchor of
    the family."""
    basis = body.basis
    assert basis is not None
    variance, axes = np.linalg.eigh(basis.anchor_spread[basis.nearest_anchor(body.basis_at[0])])
    return np.maximum(variance, NARROW**2), axes


def _tied(body: Body) -> tuple[tuple[Ints, Ints], tuple[Ints, Ints]]:
    """Spheres that stand on a joint below or above their segment, and these joints."""
    pairs: list[tuple[Ints, Ints]] = []
    segment = body.sphere_segment
    child = np.arange(1, len(body.segments))
    for owner, at in ((body.parent[1:], body.joint_in_parent[0]), (child, body.joint_in_child[0])):
        gap = np.linalg.norm(body.centre[0, :, None] - at[None], axis=-1)
        sphere, joint = np.nonzero((gap <= 2e-6) & (segment[:, None] == owner[None]))
        pairs.append((sphere, joint))
    return pairs[0], pairs[1]
