"""The hip position and the pitch of the sole at which a driver's thigh, knee and ankle come nearest
to what is expected of them.

The leg in its upright plane is a triangle of thigh, shank and the line from hip to ankle. The cost
is the sum of squares of its angles' residuals in units of their scatter. It may have several minima:
the least is looked for on a grid over all, then on finer and finer ones about the best point.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import batch_loop, inlined

__all__ = ["FLAT", "DrivingLegs", "least_costs"]

Floats = NDArray[np.float64]

OUT_OF_REACH = 1e6
"""Cost [1/m] of an ankle that the leg does not reach. It outweighs every angle."""
FLAT = 1e-6
"""Distance [m] from a leg that is stretched or folded flat, where the angles have no derivative: there
it has its last ones."""
COARSE_HIPS = 60
COARSE_PITCHES = 7
"""Hip positions and pitches of the first grid."""
FINER = 7
HALVINGS = 14
"""Points along each axis of the grids that follow about the best point, each with half the spacing,
and how many there are: hips are found to 2e-6 m."""


class DrivingLegs(NamedTuple):
    """Legs of B drivers in upright planes."""

    lengths: Floats
    """(B, 2) [m] of thigh and shank."""
    ball: Floats
    """(B, 2) [m] x and z of the ball of the foot."""
    ankle: Floats
    """(B, 2) [m] from there to the ankle, forward and up in the foot's frame."""
    own_pitch: Floats
    """(B,) [rad] of the sole in the foot's frame."""
    height: Floats
    """(B,) [m] of the hips."""
    angles: Floats
    """(B, 3) [rad] of thigh, knee and ankle as expected."""
    spread: Floats
    """(B, 3) [rad] scatter of these; infinite where any will do."""
    others: Floats
    """(O, B, 3) [m] x and z of the ankles of other feet, and the longest that their legs may be."""


@inlined
def _cost(legs, b, hip, pitch):  # type: ignore[no-untyped-def]
    """The cost of one driver with the hips at x [m] and the sole pitched so far [rad]."""
    turn = pitch - legs.own_pitch[b]
    c = math.cos(turn)
    s = math.sin(turn)
    level = legs.ball[b, 0] + c * legs.ankle[b, 0] - s * legs.ankle[b, 1] - hip
    rise = legs.ball[b, 1] + s * legs.ankle[b, 0] + c * legs.ankle[b, 1] - legs.height[b]
    thigh = legs.lengths[b, 0]
    shank = legs.lengths[b, 1]
    distance = math.sqrt(level * level + rise * rise)
    span = min(max(distance, abs(thigh - shank) + FLAT), thigh + shank - FLAT)
    at_hip = math.acos((thigh * thigh + span * span - shank * shank) / (2.0 * thigh * span))
    knee = math.acos((thigh * thigh + shank * shank - span * span) / (2.0 * thigh * shank))
    lifted = math.atan2(rise, level) + at_hip
    plantarflexion = lifted + knee - 0.5 * math.pi - turn
    cost = OUT_OF_REACH * abs(distance - span)
    cost += ((lifted - legs.angles[b, 0]) / legs.spread[b, 0]) ** 2
    cost += ((knee - legs.angles[b, 1]) / legs.spread[b, 1]) ** 2
    cost += ((plantarflexion - legs.angles[b, 2]) / legs.spread[b, 2]) ** 2
    for other in range(len(legs.others)):
        away = legs.others[other, b, 0] - hip
        above = legs.others[other, b, 1] - legs.height[b]
        lack = math.sqrt(away * away + above * above) - legs.others[other, b, 2]
        cost += OUT_OF_REACH * max(lack, 0.0)
    return cost


@inlined
def _point(middle, half, k, count, low, high):  # type: ignore[no-untyped-def]
    """Point k of so many about the middle, between two ends."""
    at = middle if count == 1 else middle + half * (2.0 * k / (count - 1) - 1.0)
    return min(max(at, low), high)


@batch_loop
def least_costs(legs, hips, pitches, found):  # type: ignore[no-untyped-def]
    """Find where the cost of B drivers is least.

    Parameters
    ----------
    legs
        `DrivingLegs`.
    hips, pitches
        (B, 2) [m] and [rad] ends of the hips' x and of the soles' pitch.
    found
        (B, 2) written: x and pitch.
    """
    for b in range(len(found)):
        x = 0.5 * (hips[b, 0] + hips[b, 1])
        pitch = 0.5 * (pitches[b, 0] + pitches[b, 1])
        half_x = 0.5 * (hips[b, 1] - hips[b, 0])
        half_pitch = 0.5 * (pitches[b, 1] - pitches[b, 0])
        for halving in range(1 + HALVINGS):
            rows = 1 if half_x == 0.0 else (COARSE_HIPS if halving == 0 else FINER)
            columns = 1 if half_pitch == 0.0 else (COARSE_PITCHES if halving == 0 else FINER)
            least = math.inf
            best_x = x
            best_pitch = pitch
            for i in range(rows):
                at = _point(x, half_x, i, rows, hips[b, 0], hips[b, 1])
                for j in range(columns):
                    turned = _point(pitch, half_pitch, j, columns, pitches[b, 0], pitches[b, 1])
                    cost = _cost(legs, b, at, turned)
                    if cost < least:
                        least = cost
                        best_x = at
                        best_pitch = turned
            x = best_x
            pitch = best_pitch
            # the next grid reaches one and a half spacings to either side: half the spacing
            half_x *= 3.0 / max(rows - 1, 1)
            half_pitch *= 3.0 / max(columns - 1, 1)
        found[b, 0] = x
        found[b, 1] = pitch
