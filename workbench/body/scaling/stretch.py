"""Stretching a body: factors along x, y, z and for the radii of each pair of segments, and a taper.

For what no family of bodies reaches, and for bodies that belong to none. Centres, joints and radii
are linear in the factors.
"""

from __future__ import annotations

import numpy as np

from workbench.body.scaling.rig import Shape
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body

__all__ = ["KNOBS", "groups_of", "stretch_price", "stretch_shapes"]

KNOBS = 5
"""Numbers a group of segments: factors along x, y, z, factor of the radii, taper."""
ROUND = 4.0
ALONG = 0.5
SMOOTH = 1.0
LEAST = 0.25
EVEN = 1.5


def groups_of(body: Body) -> Ints:
    """(N,) left and right twins, known by their names, change together."""
    plain = [name.removeprefix("left ").removeprefix("right ") for name in body.segment_names]
    order = list(dict.fromkeys(plain))
    return np.array([order.index(name) for name in plain])


def stretch_shapes(body: Body, groups: Ints) -> Shape:
    """The stacked (K, ...) shapes whose sums with the factors as weights are all the shapes there
    are."""
    segment = body.sphere_segment
    parent = groups[body.parent[1:]]
    child = groups[1:]
    shapes = []
    for group in range(int(groups.max()) + 1):
        mine = (groups[segment] == group)[:, None]
        above = (parent == group)[:, None]
        below = (child == group)[:, None]
        for axis in range(4):
            along = np.eye(4)[axis, :3]
            shapes.append(
                Shape(
                    body.centre[0] * mine * along,
                    body.radius[0] * mine[:, 0] * float(axis == 3),
                    body.joint_in_parent[0] * above * along,
                    body.joint_in_child[0] * below * along,
                )
            )
        long, middle, half = _extent(body, groups, group)
        across = 1.0 - np.eye(3)[long]

        def taper(
            points: Floats, long: int = long, middle: float = middle, half: float = half
        ) -> Floats:
            share: Floats = (points[:, long : long + 1] - middle) / half
            return share

        shapes.append(
            Shape(
                body.centre[0] * mine * across * taper(body.centre[0]),
                body.radius[0] * mine[:, 0] * taper(body.centre[0])[:, 0],
                body.joint_in_parent[0] * above * across * taper(body.joint_in_parent[0]),
                body.joint_in_child[0] * below * across * taper(body.joint_in_child[0]),
            )
        )
    return Shape(
        *(
            np.stack([getattr(s, f) for s in shapes])
            for f in ("centre", "radius", "in_parent", "in_child")
        )
    )


def _extent(body: Body, groups: Ints, group: int) -> tuple[int, float, float]:
    """The long axis of a group's spheres, their middle along it and half their extent [m]."""
    centres = body.centre[0][groups[body.sphere_segment] == group]
    if len(centres) < 2:
        return 2, 0.0, 1.0
    span = np.ptp(centres, axis=0)
    long = int(np.argmax(span))
    return (
        long,
        float(centres[:, long].min() + 0.5 * span[long]),
        max(float(0.5 * span[long]), 1e-3),
    )


def stretch_price(body: Body, groups: Ints) -> Floats:
    """(K, K) the quadratic cost of factors that leave 1, differ within a segment or between
    neighbours: cross sections stay round (radius against the two axes across); lengths are freer to
    go their own way."""
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
        one = groups[child]
        other = groups[body.parent[child]]
        if one != other:
            rows.append(SMOOTH * (unit[KNOBS * one + 3] - unit[KNOBS * other + 3]))
    stacked = np.array(rows)
    price: Floats = stacked.T @ stacked
    return price
