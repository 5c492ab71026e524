"""Blended spheres: near a joint a sphere takes a share of the motion of the segment across it, so
that the surface stays smooth where the joint bends.

Sphere s of segment n is blended across joint j, of which n is one segment and o the other. Where
R_n, R_o turn the frames of both into the world, the sphere stands at joint + ((1 - w) R_n + w R_o)
(c - joint_in_n), c being its centre after the share of the twist. Where the proximal segment shares
the joint's twist, its surface near the joint carries the twist already, so R_o is taken without it.
(Linear blend skinning with one partner: spheres instead of vertices.)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import ROW_FIELDS, Body, Topology, body_of_rows

__all__ = [
    "blend_point",
    "distal",
    "enclosing_spheres",
    "swept_spheres",
    "twist_shared",
    "with_derived_fields",
]


def distal(body: Body | Topology) -> Bools:
    """(S,) True where a sphere is blended across the joint above its own segment."""
    return (body.blend_joint >= 0) & (body.blend_joint == body.sphere_segment - 1)


def blend_point(body: Body) -> Floats:
    """(B, S, 3) the joint a sphere is blended across in the frame of its segment [m]; 0 where it is
    rigid."""
    if not len(body.joints):
        return np.zeros((len(body), len(body.blend_joint), 3))
    joint = np.maximum(body.blend_joint, 0)
    above = body.joint_in_child[:, joint]
    point = np.where(distal(body)[:, None], above, body.joint_in_parent[:, joint])
    # in order in memory: the kernels are compiled for that, and anew for any other order
    return np.ascontiguousarray(np.where(body.blend_joint[:, None] >= 0, point, 0.0))


def twist_shared(body: Body | Topology) -> Bools:
    """(J,) True where the joint's proximal segment shares its twist."""
    shared = np.zeros(len(body.joints), dtype=np.bool_)
    shared[body.twist_joint[body.twist_joint >= 0]] = True
    return shared


def swept_spheres(body: Body) -> tuple[Floats, Floats]:
    """Find spheres that hold each sphere however the joint turns that it is blended across; seen
    from the line that its segment's twist turns about, also at every twist.

    w R (c - joint) stays on a sphere of radius w |c - joint| about joint + (1 - w)(c - joint).
    Where the sphere twists about a line that the joint is not on, both are taken at their farthest
    from the line and from each other.

    Returns
    -------
    tuple
        Centres (B, S, 3) and radii (B, S) [m] in segment frames.
    """
    point = blend_point(body)
    own = body.centre
    share = np.where(body.blend_joint >= 0, body.blend_share, 0.0)
    middle = own - share[..., None] * (own - point)
    reach = np.linalg.norm(own - point, axis=2)
    row, aside = _beside_line(body, share, point)
    segment = body.sphere_segment[aside]
    start = body.twist_point[row, segment]
    line = body.twist_axis[row, segment]
    # the sphere and its joint, each at its farthest from the line, on opposite sides of it
    along, off = _from_line(np.stack([own[row, aside], point[row, aside]]), start, line)
    far = np.linalg.norm(off, axis=-1)
    reach[row, aside] = np.hypot(along[0] - along[1], far.sum(axis=0))
    # between the two where the share w divides them, on the side of the sphere
    out = (
        np.where(far[0, :, None] > 1e-12, off[0], off[1])
        / np.where(far[0] > 1e-12, far[0], far[1])[:, None]
    )
    part = np.stack([1.0 - share[row, aside], share[row, aside]])
    middle[row, aside] = (
        start + line * (along * part).sum(axis=0)[:, None] + out * (far * part).sum(axis=0)[:, None]
    )
    return middle, body.radius + share * reach


def _beside_line(body: Body, share: Floats, point: Floats) -> tuple[Ints, Ints]:
    """The rows and spheres that are blended, and twist about a line that their joint (B, S, 3) is
    not on."""
    segment = body.sphere_segment
    row, turned = np.nonzero(
        (share > 0) & (body.twist_share > 0) & (body.twist_joint[segment] >= 0)
    )
    start = body.twist_point[row, segment[turned]]
    _, off = _from_line(point[row, turned], start, body.twist_axis[row, segment[turned]])
    beside = np.linalg.norm(off, axis=-1) > 1e-9
    return row[beside], turned[beside]


def _from_line(points: Floats, start: Floats, line: Floats) -> tuple[Floats, Floats]:
    """How far (..., K) points (..., K, 3) lie along lines (K, 3) from their starts (K, 3) [m], and
    the vectors (..., K, 3) to them from the lines."""
    away = points - start
    along = np.einsum("...si,si->...s", away, line)
    return along, away - along[..., None] * line


@dataclass(frozen=True, eq=False)
class _Spheres:
    """Spheres of B rows, grouped by segments that have some: centre (B, S, 3), radius (B, S) [m].

    first (G,): the first sphere of each group; group (S,): the group of each sphere.
    """

    centre: Floats
    radius: Floats
    first: Ints
    group: Ints

    def middle(self) -> Floats:
        """(B, G, 3) the mean of the centres of each group, weighted by the radii."""
        weight = np.add.reduceat(self.radius, self.first, axis=1)
        total = np.add.reduceat(self.centre * self.radius[..., None], self.first, axis=1)
        return np.asarray(total / weight[..., None])

    def farthest(self, at: Floats) -> tuple[Floats, Floats]:
        """(B, G) how far the spheres of each group go from a point (B, G, 3) [m], and (B, G, 3) the
        centre of the first that goes farthest."""
        away = self.centre - at[:, self.group]
        x, y, z = away[..., 0], away[..., 1], away[..., 2]
        gap = np.sqrt(x * x + y * y + z * z) + self.radius
        most = np.maximum.reduceat(gap, self.first, axis=1)
        row, some = np.nonzero(gap == most[:, self.group])
        first = np.searchsorted(row * len(self.first) + self.group[some], np.arange(most.size))
        return most, self.centre[row[first], some[first]].reshape(at.shape)


@dataclass(frozen=True, eq=False)
class _Lines:
    """Lines that centres must lie on: turns (G, 1): whether there is one; point, axis (B, G, 3)."""

    turns: Bools
    point: Floats
    axis: Floats

    def nearest(self, at: Floats) -> Floats:
        """(B, G, 3) the point of each line nearest to another; the other where there is no line."""
        along = np.einsum("bni,bni->bn", at - self.point, self.axis)[..., None]
        return np.where(self.turns, self.point + self.axis * along, at)


def enclosing_spheres(body: Body, *, steps: int = 100) -> tuple[Floats, Floats]:
    """Find small spheres around all spheres of each segment of each row in every pose.

    Where a segment shares a twist the centre lies on the line it turns about, so that any twist
    fits. Found by moving toward the farthest sphere by ever smaller steps (after Badoiu & Clarkson
    2003). A row has the same spheres alone and among others.

    Parameters
    ----------
    body
        B rows.
    steps
        How many steps are made.

    Returns
    -------
    tuple
        Centres (B, N, 3) and radii (B, N) [m]; radius 0 where a segment has no spheres.
    """
    count = np.diff(body.start)
    filled = np.flatnonzero(count > 0)
    group = np.repeat(np.arange(len(filled)), count[filled])
    spheres = _Spheres(*swept_spheres(body), body.start[filled], group)
    turns = (body.twist_joint[filled] >= 0)[:, None]
    lines = _Lines(turns, body.twist_point[:, filled], body.twist_axis[:, filled])
    kept = best = lines.nearest(spheres.middle())
    least = np.full(best.shape[:2], np.inf)
    for step in range(steps + 1):
        most, far = spheres.farthest(best)
        kept = np.where((most < least)[..., None], best, kept)
        least = np.minimum(most, least)
        best = lines.nearest(best + (far - best) / (step + 2))
    centres = np.zeros((len(body), len(body.segments), 3))
    radii = np.zeros((len(body), len(body.segments)))
    centres[:, filled] = kept
    radii[:, filled] = least + 1e-12
    return centres, radii


# What follows from a body's spheres and joints: lines that twist is shared along, shares,
# enclosing spheres.


def with_derived_fields(body: Body, *, steps: int = 100) -> Body:
    """The body with twist_point, twist_axis, twist_share and enclosing spheres as the joints and
    spheres of each row say.

    The line of a segment runs from its proximal joint (the origin, at the stage) to the distal
    joint whose twist it shares; the share is 0 at the first and 1 at the second. steps: how long
    small enclosing spheres are sought.
    """
    point = np.zeros((len(body), len(body.segments), 3))
    axis = np.zeros(point.shape)
    share = np.zeros(body.radius.shape)
    for n in np.flatnonzero(body.twist_joint >= 0):
        if n:
            point[:, n] = body.joint_in_child[:, n - 1]
        span = body.joint_in_parent[:, body.twist_joint[n]] - point[:, n]
        length = np.linalg.norm(span, axis=1, keepdims=True)
        axis[:, n] = span / length
        some = body.spheres(int(n))
        along = np.einsum("bsi,bi->bs", body.centre[:, some] - point[:, n, None], axis[:, n])
        share[:, some] = np.clip(along / length, 0.0, 1.0)
    rows = {name: getattr(body, name) for name in ROW_FIELDS}
    rows |= {"twist_point": point, "twist_axis": axis, "twist_share": share}
    centre, radius = enclosing_spheres(body_of_rows(body, rows), steps=steps)
    rows |= {"enclosing_centre": centre, "enclosing_radius": radius}
    return body_of_rows(body, rows)
