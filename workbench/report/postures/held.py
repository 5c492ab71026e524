"""What somebody does in a case, in words."""

from __future__ import annotations

import numpy as np

from workbench.model.joint_angles import angles_of
from workbench.model.result import PersonFound
from workbench.model.units import plain

__all__ = ["posture_words"]

_SAME = np.radians(0.05)
"""[rad] Angles that are nearer to each other are shown alike."""
_FOUND = ("predicted", "driver")
"""Postures that are found anew in each case."""
_MOST = 4
"""Joints that are named."""


def posture_words(person: PersonFound, case: int) -> str:
    """Return the name of a posture, and the joints that are not as in the first case in which the
    person takes it: "riding, with other angles at right shoulder and right elbow"."""
    name = person.postures[case]
    first = person.postures.index(name)
    words = plain(name)
    if first == case or name in _FOUND:
        return words
    angles = angles_of(person.body, person.poses)
    other = np.flatnonzero((np.abs(angles[case] - angles[first]) > _SAME).any(axis=1))
    if not len(other):
        return words
    names = [person.body.joint_names[int(joint)] for joint in other]
    if len(names) > _MOST:
        return f"{words}, with other angles at {len(names)} joints"
    listed = " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
    return f"{words}, with other angles at {listed}"
