"""Compute the space of shapes of a body: coordinates and radii that are linear in K parameters.

The parameters of a body of a family are the coefficients of the family and those of stretching
(`scaling.stretch`), otherwise of stretching alone. Every posture of the anthropometer is linear
too, so what each parameter adds to a length is computed once.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np

from workbench.body.scaling.manikin import AXES, QUEUE, SEATED, Length, Manikin, PointExtent
from workbench.body.scaling.rig import Shape
from workbench.body.scaling.stretch import PARAMETERS, groups_of, stretch_price, stretch_shapes
from workbench.geometry.overlap import union_volumes
from workbench.model.arrays import Floats, Ints
from workbench.model.basis import Detail
from workbench.model.body import Body

__all__ = ["ON_JOINT", "ShapeSpace", "detail_of", "shape_space", "volumes"]

_FIELDS = ("centre", "radius", "in_parent", "in_child")
_STRETCH_PRICE = 4.0e3
"""Factor on the cost of stretching a body of a family. A stretch by 1.02 costs about as much as one
standard deviation of a coefficient, so that lengths are found within the family first."""
_VOLUME_LINES = 14
"""Lines across a segment in each direction, for its volume."""
_MIN_DEVIATION = 0.02
"""Least standard deviation of a coefficient among similar people, so that some room is left."""
ON_JOINT = 2e-6
"""Distance [m] from a joint up to which a sphere is on it."""


@dataclass(frozen=True, eq=False)
class ShapeSpace:
    """The shapes of a body of N segments with K parameters."""

    base: Manikin
    """The unchanged body."""
    groups: Ints
    """(N,) group of each segment, see `stretch.groups_of`."""
    family: int
    """Number of parameters that are coefficients of the family; they come first."""
    neutral: Floats
    """(K,) parameters of the unchanged body."""
    effects: Shape
    """(K, ...) what each parameter adds to the fields of a shape."""
    price: Floats
    """(K, K) matrix of the quadratic cost of a change."""
    cheap: Floats
    """(K, K) inverse of `price`."""
    overlaps: Floats
    """(N, N) [m] of the unchanged body, see `Manikin.overlaps`."""
    volume: Floats
    """(N,) [m3] of the unchanged body's segments."""
    tied: tuple[tuple[Ints, Ints], tuple[Ints, Ints]]
    """Spheres on a joint and these joints: of the parents, then of the children."""
    likely: tuple[Floats, Floats]
    """Variances and axes of the family's coefficients among similar people."""
    _seated: Shape
    """(K, ...) what each parameter adds to the fields of a shape on a seat."""
    _origins: Floats
    """(Q, K, N, 3) [m] what each parameter adds to the segments' origins."""
    _joints: Floats
    """(Q, K, J, 3) [m] what each parameter adds to the joints."""
    _stacked: Floats
    """(K, n) the fields of `effects` side by side."""
    _still: Floats
    """(n,) the fields of the unchanged shape side by side."""
    _rows: dict[PointExtent, Floats] = field(default_factory=dict)
    """(K,) rows that are known, by reach."""

    def shape(self, values: Floats) -> Shape:
        """Return the shape with parameters (K,). Spheres on joints are exactly on them."""
        flat = (values - self.neutral) @ self._stacked + self._still
        shape = _unstacked(flat, len(self.base.rig.segment))
        (above, joint_above), (below, joint_below) = self.tied
        shape.centre[above] = shape.in_parent[joint_above]
        shape.centre[below] = shape.in_child[joint_below]
        return shape

    def manikin(self, values: Floats) -> Manikin:
        """Return the body with parameters (K,), in all postures."""
        return self.base.changed(self.shape(values))

    @cached_property
    def unchanged(self) -> Manikin:
        """The body with the neutral parameters, from which every search starts."""
        return self.manikin(self.neutral)

    def row(self, length: Length) -> Floats:
        """Return what each parameter (K,) adds to a length whose extreme spheres are held fixed."""
        total = np.zeros(len(self.neutral))
        for sign, reach in length.terms:
            if reach not in self._rows:
                self._rows[reach] = self._reach_row(reach)
            total += sign * self._rows[reach]
        return total

    def _reach_row(self, reach: PointExtent) -> Floats:
        """What each parameter (K,) adds to one reach: the sum over origin, centre and blend, plus the radius."""
        q = QUEUE[reach.posture]
        along = AXES[reach.direction]
        if reach.joint >= 0:
            return np.asarray(self._joints[q, :, reach.joint] @ along)
        s = reach.sphere
        rig = self.base.rig
        origin = self._origins[q, :, rig.segment[s]] @ along
        effects = self._seated if q in SEATED else self.effects
        row: Floats = origin + effects.centre[:, s] @ (along @ rig.turn[q, s])
        for b in np.flatnonzero(rig.blended == s):
            end = self.effects.in_child if rig.distal[b] else self.effects.in_parent
            row = row + end[:, rig.joint[b]] @ (along @ rig.lever[q, b])
        return row + effects.radius[:, s] if reach.surface else row


def volumes(body: Body, shape: Shape) -> Floats:
    """Return the volume (N,) [m3] of the union of each segment's spheres."""
    return union_volumes(shape.centre, shape.radius, body.start, _VOLUME_LINES)


@lru_cache(maxsize=16)
def shape_space(body: Body) -> ShapeSpace:
    """Compute the space of shapes of a body; it is kept, as bodies compare by identity."""
    groups = groups_of(body)
    effects = stretch_shapes(body, groups)
    neutral = np.tile([1.0, 1.0, 1.0, 1.0, 0.0], len(effects.radius) // PARAMETERS)
    price = stretch_price(body, groups)
    likely = (np.zeros(0), np.zeros((0, 0)))
    if body.basis is not None:
        effects = _joined_shapes(family_shapes(body), effects)
        neutral = np.concatenate([body.basis_at[0], neutral])
        likely = _likely(body)
        price = _joint_price(likely, price)
    base = Manikin(body)
    origins, joints = base.rig.origins(effects)
    return ShapeSpace(
        base=base,
        groups=groups,
        family=len(likely[0]),
        neutral=neutral,
        effects=effects,
        price=price,
        cheap=np.linalg.inv(price).astype(np.float64),
        overlaps=base.overlaps(),
        volume=volumes(body, base.shape),
        tied=_tied(body),
        likely=likely,
        _seated=effects if base.flesh is None else base.flesh.spread(effects),
        _origins=origins,
        _joints=joints,
        _stacked=_flattened(effects, len(neutral)),
        _still=_flattened(base.shape, 1)[0],
    )


def _joined_shapes(first: Shape, second: Shape) -> Shape:
    """Stacked shapes (K, ...) of two lists, one after the other."""
    return Shape(*(np.concatenate([getattr(first, f), getattr(second, f)]) for f in _FIELDS))


def _flattened(shapes: Shape, count: int) -> Floats:
    """(count, n) the fields of shapes side by side, see `_unstacked`."""
    return np.concatenate([getattr(shapes, f).reshape(count, -1) for f in _FIELDS], axis=1)


def _joint_price(likely: tuple[Floats, Floats], stretch: Floats) -> Floats:
    """(K, K) cost of coefficients and stretching (M, M) together.

    Coefficients cost their squared Mahalanobis distance, z' A diag(1 / variance) A' z.
    """
    variance, axes = likely
    family = len(variance)
    price = np.zeros((family + len(stretch), family + len(stretch)))
    price[:family, :family] = (axes / variance) @ axes.T
    price[family:, family:] = _STRETCH_PRICE * stretch
    return price


def _unstacked(flat: Floats, spheres: int) -> Shape:
    """The shape of a row of numbers (n,): centres, radii, joints in their parents, joints in their children."""
    centre = flat[: 3 * spheres]
    radius = flat[3 * spheres : 4 * spheres]
    joints = flat[4 * spheres :]
    in_parent, in_child = joints.reshape(2, -1, 3)
    return Shape(centre.reshape(-1, 3), radius, in_parent, in_child)


def family_shapes(body: Body) -> Shape:
    """Return what each coefficient (K, ...) of a body's family adds to its spheres and joints, in segment frames."""
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
    """Return the level of detail of its family that a body has, by its spheres in each segment."""
    assert body.basis is not None
    counts = np.diff(body.start)
    levels = body.basis.details.values()
    return next(
        d for d in levels if np.array_equal(np.bincount(d.segment, minlength=len(counts)), counts)
    )


def _likely(body: Body) -> tuple[Floats, Floats]:
    """Variances (K,) and axes (K, K) of the coefficients among people like the family's nearest anchor."""
    basis = body.basis
    assert basis is not None
    variance, axes = np.linalg.eigh(basis.anchor_spread[basis.nearest_anchor(body.basis_at[0])])
    return np.maximum(variance, _MIN_DEVIATION**2), axes


def _tied(body: Body) -> tuple[tuple[Ints, Ints], tuple[Ints, Ints]]:
    """Spheres on a joint below their segment and these joints, then those on the joint above."""
    pairs: list[tuple[Ints, Ints]] = []
    segment = body.sphere_segment
    child = np.arange(1, len(body.segments))
    for owner, at in ((body.parent[1:], body.joint_in_parent[0]), (child, body.joint_in_child[0])):
        gap = np.linalg.norm(body.centre[0, :, None] - at[None], axis=-1)
        sphere, joint = np.nonzero((gap <= ON_JOINT) & (segment[:, None] == owner[None]))
        pairs.append((sphere, joint))
    return pairs[0], pairs[1]
