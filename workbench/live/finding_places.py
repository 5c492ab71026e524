"""Where a finding is that has no point of its own: at its control, point, joint or the eyes."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from workbench.model.result import Finding
from workbench.study.checks.view import THE_EYES, eyes_of
from workbench.study.people import Present

__all__ = ["place_of_finding"]


def place_of_finding(finding: Finding, there: Present) -> tuple[float, float, float] | None:
    """Find the place [m] in the world that a finding about a posture is to be looked at.

    Findings of reach and of pedals are about a control, those of eye heights about a point; those of
    joint stops name the joint as their subject, those of a view over parts the eyes.

    Parameters
    ----------
    there
        The people of the state that was judged, and the environment with their seats.

    Returns
    -------
    tuple or None
        None where the finding is about no place, such as the travel of a seat.
    """
    if finding.point is not None:
        return finding.point
    for control in there.environment.controls:
        if control.name == finding.about:
            return _xyz(control.at)
    if finding.about in there.environment.points:
        return _xyz(there.environment.points[finding.about])
    for situation in (one for cases in there.situations for one in cases):
        body = situation.body
        asked = (situation.work.name, situation.place.role) == (finding.case, finding.person)
        if asked and finding.subject == THE_EYES:
            return _xyz(eyes_of(situation)[0])
        if asked and finding.subject in body.joint_names:
            joint = body.joint_names.index(finding.subject)
            child = situation.placed.world_from_segment[0, joint + 1]
            return _xyz(child[:, :3] @ body.joint_in_child[0, joint] + child[:, 3])
    return None


def _xyz(point: ArrayLike) -> tuple[float, float, float]:
    x, y, z = np.asarray(point, float).tolist()
    return x, y, z
