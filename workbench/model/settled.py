"""What follows from a body's spheres and joints: lines that twist is shared along, shares,
enclosing spheres."""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.blend import enclosing_spheres
from workbench.model.body import ROW_FIELDS, Body, body_of_rows

__all__ = ["settled"]


def settled(body: Body, *, steps: int = 100) -> Body:
    """The body of one row with twist_point, twist_axis, twist_share and its enclosing spheres as
    its joints and spheres say.

    The line of a segment runs from its proximal joint (the origin, at the stage) to the distal
    joint whose twist it shares; the share is 0 at the first and 1 at the second. steps: how long
    small enclosing spheres are sought.
    """
    point = np.zeros((len(body.segments), 3))
    axis = np.zeros((len(body.segments), 3))
    share = np.zeros(len(body.sphere_names))
    for n in np.flatnonzero(body.twist_joint >= 0):
        point[n] = body.joint_in_child[0, n - 1] if n else 0.0
        span: Floats = body.joint_in_parent[0, body.twist_joint[n]] - point[n]
        length = float(np.linalg.norm(span))
        axis[n] = span / length
        some = body.spheres(int(n))
        along = (body.centre[0, some] - point[n]) @ axis[n]
        share[some] = np.clip(along / length, 0.0, 1.0)
    rows = {name: getattr(body, name) for name in ROW_FIELDS}
    rows |= {"twist_point": point[None], "twist_axis": axis[None], "twist_share": share[None]}
    centre, radius = enclosing_spheres(body_of_rows(body, rows), steps=steps)
    rows |= {"enclosing_centre": centre[None], "enclosing_radius": radius[None]}
    return body_of_rows(body, rows)
