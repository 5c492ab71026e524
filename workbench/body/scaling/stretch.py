"""Stretch a body: factors along x, y, z and for the radii of each group of segments, and a taper.

A group is a segment and its twin on the other side. Stretching serves bodies without a family, and
closes what a family does not reach. Centres, joints and radii are linear in the parameters.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.body.scaling.rig import Shape
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body

__all__ = ["PARAMETERS", "groups_of", "stretch_price", "stretch_shapes"]

PARAMETERS = 5
"""Parameters of a group: factors along x, y, z, factor of the radii, taper."""
_ROUND_WEIGHT = 4.0
"""Weight of a radius that changes otherwise than the two axes across: sections stay round."""
_LENGTH_WEIGHT = 0.5
"""Weight of a radius that changes otherwise than the long axis: lengths are freer."""
_NEIGHBOUR_WEIGHT = 1.0
"""Weight of radii that change otherwise in two neighbours."""
_CHANGE_WEIGHT = 0.25
"""Weight of any change."""
_TAPER_WEIGHT = 1.5


def groups_of(body: Body) -> Ints:
    """Return the group (N,) of each segment. Left and right twins, known by name, are one group."""
    plain = [name.removeprefix("left ").removeprefix("right ") for name in body.segment_names]
    order = list(dict.fromkeys(plain))
    return np.array([order.index(name) for name in plain])


def twins_of(body: Body) -> Ints:
    """Return the segment (N,) on the other side of each, itself of the middle ones."""
    alike = groups_of(body)[:, None] == groups_of(body)
    number = np.arange(len(alike))
    # of two alike the other one is their sum less oneself
    return np.where(alike.sum(axis=1) == 2, alike @ number - number, number)


def stretch_shapes(body: Body, groups: Ints) -> Shape:
    """Return what each parameter adds to the shape of a body.

    Parameters
    ----------
    groups
        (N,) group of each segment, see `groups_of`.

    Returns
    -------
    Shape
        (K, ...) stacked; a shape is their sum weighted with the parameters.
    """
    shapes = []
    for group in range(int(groups.max()) + 1):
        parts = _GroupParts.of(body, groups, group)
        shapes += [parts.scaled(axis) for axis in range(3)]
        shapes += [parts.thickened(), parts.tapered(body)]
    return Shape(
        *(
            np.stack([getattr(shape, field) for shape in shapes])
            for field in ("centre", "radius", "in_parent", "in_child")
        )
    )


@dataclass(frozen=True, eq=False)
class _GroupParts:
    """The coordinates of a body that belong to one group; zero for all others."""

    centre: Floats
    """(S, 3) [m]."""
    radius: Floats
    """(S,) [m]."""
    in_parent: Floats
    """(J, 3) [m]."""
    in_child: Floats
    """(J, 3) [m]."""
    extent: _Extent

    @classmethod
    def of(cls, body: Body, groups: Ints, group: int) -> _GroupParts:
        """Select the coordinates of a group."""
        spheres = groups[body.sphere_segment] == group
        return cls(
            body.centre[0] * spheres[:, None],
            body.radius[0] * spheres,
            body.joint_in_parent[0] * (groups[body.parent[1:]] == group)[:, None],
            body.joint_in_child[0] * (groups[1:] == group)[:, None],
            _extent(body, groups, group),
        )

    def scaled(self, axis: int) -> Shape:
        """Coordinates along one axis."""
        along = np.eye(3)[axis]
        return Shape(
            self.centre * along, 0.0 * self.radius, self.in_parent * along, self.in_child * along
        )

    def thickened(self) -> Shape:
        """Radii."""
        nothing = (0.0 * self.centre, 0.0 * self.in_parent, 0.0 * self.in_child)
        return Shape(nothing[0], self.radius, nothing[1], nothing[2])

    def tapered(self, body: Body) -> Shape:
        """Coordinates across the long axis and radii, growing from -1 to 1 along it."""
        across = 1.0 - np.eye(3)[self.extent.axis]
        share = self.extent.share(self.centre, body.sphere_segment)
        above = self.extent.share(self.in_parent, body.parent[1:])
        below = self.extent.share(self.in_child, np.arange(1, len(body.segments)))
        return Shape(
            self.centre * across * share[:, None],
            self.radius * share,
            self.in_parent * across * above[:, None],
            self.in_child * across * below[:, None],
        )


class _Extent(NamedTuple):
    """The extent of a group's spheres along its long axis."""

    axis: int
    middle: float
    """[m]."""
    half: float
    """Half the extent [m]."""
    outward: Floats
    """(N,) -1 for segments of the right where the axis is sideways, else 1: twins are mirrored."""

    def share(self, points: Floats, segment: Ints) -> Floats:
        """(n,) position of points (n, 3) of segments (n,) along the axis, from -1 to 1."""
        along = points[:, self.axis] * self.outward[segment]
        return np.asarray((along - self.middle) / self.half)


def _extent(body: Body, groups: Ints, group: int) -> _Extent:
    """The extent of a group: of its left or middle segments, which the right ones mirror."""
    right = np.array([name.startswith("right ") for name in body.segment_names])
    paired = np.isin(groups, groups[~right])
    mirrored = right & paired
    some = (groups == group) & ~mirrored
    axis = _long_axis(body, int(np.flatnonzero(some)[0]))
    outward = np.where(mirrored & (axis == 1), -1.0, 1.0)
    along = body.centre[0][some[body.sphere_segment], axis]
    if len(along) < 2:
        return _Extent(axis, 0.0, 1.0, outward)
    half = 0.5 * float(np.ptp(along))
    return _Extent(axis, float(along.min()) + half, max(half, 1e-3), outward)


def _long_axis(body: Body, segment: int) -> int:
    """The axis along which a segment lies: from the joint above it to the mean of those below, or
    to its centre of gravity (the origin of its frame) where it is the last.

    Left and right cancel in the mean, so that a trunk that is broader than long lies upright, and
    no taper makes one of its sides thicker than the other.
    """
    below = body.joint_in_parent[0][body.parent[1:] == segment]
    end = below.mean(axis=0) if len(below) else np.zeros(3)
    if segment == 0:
        return 2
    return int(np.argmax(np.abs(end - body.joint_in_child[0, segment - 1])))


def stretch_price(body: Body, groups: Ints) -> Floats:
    """Return the quadratic cost of stretching.

    It is the sum of weighted squares of changes, of differences within a group, and of differences
    between neighbours.

    Parameters
    ----------
    groups
        (N,) group of each segment, see `groups_of`.

    Returns
    -------
    Floats
        (K, K) matrix C of the cost v' C v of changes v of the parameters.
    """
    count = int(groups.max()) + 1
    unit = np.eye(PARAMETERS * count)
    rows = [_CHANGE_WEIGHT * row for row in unit]
    for group in range(count):
        long_axis = _extent(body, groups, group).axis
        first = PARAMETERS * group
        radius = unit[first + 3]
        for axis in range(3):
            weight = _LENGTH_WEIGHT if axis == long_axis else _ROUND_WEIGHT
            rows.append(weight * (unit[first + axis] - radius))
        rows.append(_TAPER_WEIGHT * unit[first + 4])
    for child in range(1, len(groups)):
        one = groups[child]
        other = groups[body.parent[child]]
        if one != other:
            difference = unit[PARAMETERS * one + 3] - unit[PARAMETERS * other + 3]
            rows.append(_NEIGHBOUR_WEIGHT * difference)
    stacked = np.array(rows)
    return stacked.T @ stacked
