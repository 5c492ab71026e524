"""What follows from a body's spheres and joints: lines that twist is shared along, shares,
enclosing spheres."""

from __future__ import annotations

import numpy as np

from workbench.model.blend import enclosing_spheres
from workbench.model.body import ROW_FIELDS, Body, body_of_rows

__all__ = ["settled"]


def settled(body: Body, *, steps: int = 100) -> Body:
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
