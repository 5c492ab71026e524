"""Blended spheres: near a joint a sphere takes a share of the motion of the segment across it, so
that the surface stays smooth where the joint bends.

Sphere s of segment n is blended across joint j, of which n is one segment and o the other. Where
R_n, R_o turn the frames of both into the world, the sphere stands at joint + ((1 - w) R_n + w R_o)
(c - joint_in_n), c being its centre after the share of the twist. Where the proximal segment shares
the joint's twist, its surface near the joint carries the twist already, so R_o is taken without it.
(Linear blend skinning with one partner: spheres instead of vertices.)
"""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Bools, Floats
from workbench.model.body import Body, Topology

__all__ = ["blend_point", "distal", "enclosing_spheres", "swept_spheres", "twist_shared"]


def distal(body: Body | Topology) -> Bools:
    """(S,) True where a sphere is blended across the joint above its own segment."""
    above: Bools = (body.blend_joint >= 0) & (body.blend_joint == body.sphere_segment - 1)
    return above


def blend_point(body: Body) -> Floats:
    """(B, S, 3) the joint a sphere is blended across in the frame of its segment [m]; 0 where it is
    rigid."""
    if not len(body.joints):
        return np.zeros((len(body), len(body.blend_joint), 3))
    joint = np.maximum(body.blend_joint, 0)
    above = body.joint_in_child[:, joint]
    point = np.where(distal(body)[:, None], above, body.joint_in_parent[:, joint])
    return np.where(body.blend_joint[:, None] >= 0, point, 0.0)


def twist_shared(body: Body | Topology) -> Bools:
    """(J,) True where the joint's proximal segment shares its twist."""
    shared = np.zeros(len(body.joints), dtype=np.bool_)
    shared[body.twist_joint[body.twist_joint >= 0]] = True
    return shared


def swept_spheres(body: Body) -> tuple[Floats, Floats]:
    """Centres (S, 3) and radii (S,) [m], in segment frames, of spheres that hold each sphere of the
    first row however the joint turns that it is blended across; seen from the line that its segment's twist
    turns about, also at every twist.

    w R (c - joint) stays on a sphere of radius w |c - joint| about joint + (1 - w)(c - joint).
    Where the sphere twists about a line that the joint is not on, both are taken at their farthest
    from the line and from each other.
    """
    point = blend_point(body)[0]
    own = body.centre[0]
    share = np.where(body.blend_joint >= 0, body.blend_share[0], 0.0)
    middle = own - share[:, None] * (own - point)
    reach = np.linalg.norm(own - point, axis=1)
    segment = body.sphere_segment
    turned = np.flatnonzero(
        (share > 0) & (body.twist_share[0] > 0) & (body.twist_joint[segment] >= 0)
    )
    start = body.twist_point[0, segment[turned]]
    line = body.twist_axis[0, segment[turned]]
    both = np.stack([own[turned], point[turned]]) - start
    along = np.einsum("ksi,si->ks", both, line)
    off = both - along[..., None] * line
    far = np.linalg.norm(off, axis=-1)
    aside = far[1] > 1e-9
    turned = turned[aside]
    start = start[aside]
    line = line[aside]
    along = along[:, aside]
    off = off[:, aside]
    far = far[:, aside]
    part = np.stack([1.0 - share[turned], share[turned]])
    reach[turned] = np.hypot(along[0] - along[1], far.sum(axis=0))
    out = (
        np.where(far[0, :, None] > 1e-12, off[0], off[1])
        / np.where(far[0] > 1e-12, far[0], far[1])[:, None]
    )
    middle[turned] = (
        start + line * (along * part).sum(axis=0)[:, None] + out * (far * part).sum(axis=0)[:, None]
    )
    return middle, body.radius[0] + share * reach


def enclosing_spheres(
    body: Body, *, steps: int = 100, centre: Floats | None = None
) -> tuple[Floats, Floats]:
    """Centres (N, 3) and radii (N,) of small spheres around all spheres of each segment of the
    first row in every pose; radius 0 where there are none.

    Where a segment shares a twist the centre lies on the line it turns about, so that any twist
    fits. Found by moving toward the farthest sphere by ever smaller steps (after Badoiu & Clarkson
    2003), from `centre` where given.
    """
    middle, reach = swept_spheres(body)
    filled = np.flatnonzero(np.diff(body.start) > 0)
    first = body.start[filled]
    count = np.diff(body.start)[filled]
    group = np.repeat(np.arange(len(filled)), count)
    turns = (body.twist_joint[filled] >= 0)[:, None]
    point = body.twist_point[0, filled]
    axis = body.twist_axis[0, filled]

    def on_line(at: Floats) -> Floats:
        along = np.einsum("ni,ni->n", at - point, axis)[:, None]
        return np.where(turns, point + axis * along, at)

    weight = np.add.reduceat(reach, first)
    best = (
        np.add.reduceat(middle * reach[:, None], first) / weight[:, None]
        if centre is None
        else centre[filled]
    )
    kept = best = on_line(best)
    least = np.full(len(filled), np.inf)
    for step in range(steps + 1):
        gap = np.linalg.norm(middle - best[group], axis=1) + reach
        most = np.maximum.reduceat(gap, first)
        kept = np.where((most < least)[:, None], best, kept)
        least = np.minimum(most, least)
        at = np.flatnonzero(gap == most[group])
        far = at[np.searchsorted(group[at], np.arange(len(filled)))]
        best = on_line(best + (middle[far] - best) / (step + 2))
    centres = np.zeros((len(body.segments), 3))
    radii = np.zeros(len(body.segments))
    centres[filled] = kept
    radii[filled] = least + 1e-12
    return centres, radii
