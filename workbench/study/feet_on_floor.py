"""Whether the feet of a sitter are on the floor, and what is wrong where they are not: the seat, the
floor, or pedals that are missing."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.geometry.ground import Ground
from workbench.model.arrays import Floats
from workbench.model.environment import Seat
from workbench.model.poses import Placed

__all__ = ["BROAD", "LEGS", "UNDER", "FeetOnFloor", "feet_on_floor", "feet_words"]

LEGS = {"LF": "LLL", "RF": "RLL"}
"""The lower leg of each foot."""
UNDER = 0.02
"""Feet that are less [m] under a floor are on it: soles and carpets give way."""
OVER = 0.05
"""Feet that are less [m] above it are on it."""
BROAD = 0.6
"""A part that is broader [m], as seen from above, is no pedal."""
_SLOPES = 0.1
"""How much higher or lower [m] a floor is under another part of the same foot or shank."""
_UNDER_KNEE = 0.05
"""What is less [m] below the knee is no floor."""


@dataclass(frozen=True)
class FeetOnFloor:
    """How the lower one of two feet stands to the floor.

    Parameters
    ----------
    above
        How far [m] the sole is above the floor, negative under it.
    part
        What is the floor there.
    height
        How far [m] the seat reference point is above the floor.
    ahead
        How much farther [m] ahead the foot would be on the floor with the knee where it is; nan
        where it can't be.
    """

    above: float
    part: str
    height: float
    ahead: float


def feet_on_floor(
    placed: Placed, pose: int, seat: Seat, ground: Ground, *, without: Iterable[str] = ()
) -> FeetOnFloor | None:
    """Find how the feet of a sitter stand to the floor under them.

    Parameters
    ----------
    placed, pose
        Who sits, and in which pose.
    seat
        The seat where it stands.
    ground
        What may be a floor.
    without
        Parts that are none: those that pedals are on, but for one so broad that the pedal is on the
        floor itself.

    Returns
    -------
    FeetOnFloor | None
        Of the foot that is deepest, None where there is no floor under either.
    """
    body = placed.body
    centres = placed.centres[pose]
    radius = body.radius[placed.person[pose]]
    named = [ground.names.index(name) for name in without if name in ground.names]
    left_out = [part for part in named if ground.breadth(part) <= BROAD]
    found = []
    for foot, leg in LEGS.items():
        if not (body.has(foot) and body.has(leg)):
            continue
        own = body.spheres(body.segment(foot))
        shank = centres[body.spheres(body.segment(leg))]
        knee = float(shank[:, 2].max())
        sole = float((centres[own, 2] - radius[own]).min())
        limb = np.concatenate([shank, centres[own]])
        below = sole + UNDER, knee - _UNDER_KNEE
        floor = _under(ground, centres[own, :2].mean(axis=0), below, limb, left_out)
        if floor is not None:
            height, part = floor
            ahead = _ahead(knee - sole, knee - height)
            found.append(FeetOnFloor(sole - height, part, seat.srp[2] - height, ahead))
    return min(found, key=lambda one: one.above, default=None)


def _under(
    ground: Ground, at: Floats, below: tuple[float, float], limb: Floats, left_out: list[int]
) -> tuple[float, str] | None:
    """Height [m] and part of the highest floor at a place (2,): a surface below the first height
    [m], or one below the second that a limb with spheres at (S, 3) [m] goes through. What is over a
    foot alone, as a panel over pedals, is none."""
    heights, parts = ground.levels(at)
    rows = np.flatnonzero((heights < below[1]) & ~np.isin(parts, left_out))
    for row in rows[::-1].tolist():
        height, part = float(heights[row]), int(parts[row])
        if height < below[0] or _passes(ground, part, height, limb):
            return height, ground.names[part]
    return None


def _passes(ground: Ground, part: int, height: float, limb: Floats) -> bool:
    """Whether a limb with spheres at (S, 3) [m] has some over a part, which is about at a height
    [m] there, and some under it."""
    over = set()
    for x, y, z in limb.tolist():
        heights, parts = ground.levels(np.array([x, y]))
        own = heights[(parts == part) & (np.abs(heights - height) < _SLOPES)]
        if len(own):
            over.add(z > own[np.argmin(np.abs(own - height))])
    return len(over) == 2


def _ahead(leg: float, room: float) -> float:
    """How much farther ahead [m] a foot is on the floor if the leg below the knee, `leg` [m] high
    where it is upright, has `room` [m] under the knee."""
    if not 0.0 < room < leg:
        return math.nan
    return math.sqrt(leg * leg - room * room)


def feet_words(who: str, feet: FeetOnFloor | None, pedals: Sequence[str]) -> list[str]:
    """Return what is wrong with the feet of a sitter and what would mend it; nothing where they are
    on the floor.

    Parameters
    ----------
    who
        What sentences begin with.
    feet
        As of `feet_on_floor`.
    pedals
        Controls of the environment where feet go.
    """
    if feet is None:
        return [
            f"{who}: there is no floor under the feet: is it left out or hidden, or is the seat in "
            f"another place?"
        ]
    if feet.above > OVER:
        return [
            f"{who}: the feet hang {1e3 * feet.above:.0f} mm above {feet.part!r}: the seat "
            f"reference point is {1e3 * feet.height:.0f} mm above it. A seat "
            f"{1e3 * feet.above:.0f} mm lower, or a footrest, would hold them"
        ]
    if feet.above >= -UNDER:
        return []
    under = -feet.above
    needed = feet.height + under
    words = (
        f"{who}: the feet are {1e3 * under:.0f} mm under {feet.part!r}: with these knees the seat "
        f"reference point must be {1e3 * needed:.0f} mm above it, and it is "
        f"{1e3 * feet.height:.0f} mm. A seat {1e3 * under:.0f} mm higher would mend it"
    )
    if math.isfinite(feet.ahead):
        words += f", or feet {1e3 * feet.ahead:.0f} mm farther ahead"
    if pedals:
        return [f"{words}, as on {' and '.join(pedals[:2])}"]
    return [f"{words}; no control is for feet: are pedals missing?"]
