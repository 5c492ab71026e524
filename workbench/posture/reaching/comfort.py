"""Comfortable joint angles: for each motion a mode and half a range, in which discomfort is
counted.

The ranges are those of Dreyfuss 3D as the Jack and IPS manikins use them (Tilley & Dreyfuss 1993,
The Measure of Man and Woman); included angles are told here as flexion. Joints of the trunk and the
shoulder girdle have no published range: their mode is the neutral posture. A published sum of
squares from modes is the joint displacement of Marler, Yang et al. (Santos, University of Iowa);
half the range as its unit is this project's choice.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.joint_angles import motion_of

__all__ = ["COMFORT", "comfort_modes"]

Range = tuple[str, float, float]
"""A motion and the least and greatest comfortable angle along it [degrees]."""

# By the end of a joint's name, so that LS and RS share a row. A motion that a joint does not have
# is left out.
COMFORT: Mapping[str, tuple[Range, ...]] = {
    "S": (("flexion", -15, 35), ("abduction", 0, 30), ("medial_rotation", -40, 60)),
    "E": (("flexion", 15, 100),),
    "W": (("flexion", -25, 45), ("ulnar_deviation", 0, 10), ("pronation", 0, 98)),
    "H": (("flexion", 60, 85), ("abduction", -5, 20), ("medial_rotation", -15, 15)),
    "K": (("flexion", 45, 85), ("medial_rotation", -10, 10)),
    "A": (("plantarflexion", -5, 20), ("inversion", -10, 10), ("medial_rotation", -10, 10)),
    "C": (("protraction", -10, 10), ("elevation", -10, 10), ("axial_back", -10, 10)),
    "trunk": (("flexion", -10, 10), ("bend_left", -10, 10), ("turn_left", -10, 10)),
}
_TRUNK = ("W", "SP", "NP", "HP")
_LEAST_HALF_RANGE = math.radians(5.0)


def comfort_modes(body: Body, joint: int) -> tuple[Floats, Floats]:
    """Mode (3,) [rad] and half range (3,) [rad] of the two swing angles and the twist of a joint.

    A joint that the table does not know has the middle of its range as mode and half its range as
    unit.
    """
    limits = body.stops.limits[joint]
    mode = 0.5 * (limits[:, 0] - limits[:, 1])
    half = np.maximum(0.5 * (limits[:, 0] + limits[:, 1]), _LEAST_HALF_RANGE)
    name = body.joints[joint]
    rows = (
        COMFORT["trunk"] if name in _TRUNK else COMFORT.get(name[-1:], ()) if len(name) == 2 else ()
    )
    known = {motion for pair in body.stops.motions[joint] for motion in pair}
    for motion, low, high in rows:
        if motion in known:
            axis, sign = motion_of(body, joint, motion)
            mode[axis] = sign * math.radians(0.5 * (low + high))
            half[axis] = math.radians(0.5 * (high - low))
    return mode, half
