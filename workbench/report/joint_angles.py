"""The angles of joints as the rows of a table on a page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from workbench.model.body import Body
from workbench.model.units import plain
from workbench.posture.stops import moves_flesh

__all__ = ["angle_rows"]

_LEAST = 0.05
"""[degrees] Angles below this read as 0.0."""


def angle_rows(
    body: Body, postures: Sequence[Mapping[str, Mapping[str, float]]]
) -> list[tuple[str, str, list[str]]]:
    """Return a row for each axis of a joint that is turned in one of several postures.

    Joints of a missing limb have none. A row is the name of the joint, its motion, and the angle in each posture [degrees] with an ASCII
    minus. Where the joint turns both ways about an axis, the row has the first motion as positive
    and the other as negative: "flexion, − extension".

    Parameters
    ----------
    postures
        The angles [degrees] of each by joint and motion; what is not named is 0.
    """
    rows = []
    there = moves_flesh(body)
    for j, joint in enumerate(body.joints):
        if not there[j]:
            continue
        for plus, minus in body.stops.motions[j]:
            turned = [posture.get(joint, {}) for posture in postures]
            angles = [one.get(plus, 0.0) - one.get(minus, 0.0) for one in turned]
            forth = any(angle >= _LEAST for angle in angles)
            back = any(angle <= -_LEAST for angle in angles)
            if not (forth or back):
                continue
            sense = 1.0 if forth else -1.0
            words = f"{plus}, \u2212 {minus}" if forth and back else plus if forth else minus
            values = [f"{round(sense * angle, 1) + 0.0:.1f}" for angle in angles]
            rows.append((body.joint_names[j], plain(words), values))
    return rows
