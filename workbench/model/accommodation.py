"""Accommodation: what a study asks of a population beside its criteria, and what it says of
shares and changes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Bools, Floats

__all__ = [
    "MAP_POINTS",
    "MET",
    "Change",
    "Gain",
    "GroupShare",
    "IntervalRule",
    "MapTask",
    "ReachMap",
    "Requirement",
    "met_of",
]

MAP_POINTS = 3, 20_000
"""The fewest and the most points that a population reach map may have."""
MET = 1e-6
"""A margin [m] down to which a requirement counts as met: below what any length here is known
to."""


def met_of(margin: Floats) -> Bools:
    """Whether margins [m] are met; what does not apply (NaN) is."""
    return np.asarray(np.isnan(margin) | (margin >= -MET), dtype=np.bool_)


@dataclass(frozen=True)
class MapTask:
    """A population reach map that a study asks for: a part's surface with so many points on it, by
    which hands (left, right or either), grip and zone, from the posture of which case."""

    part: str
    grip: str
    zone: int
    hand: str
    points: int
    case: int = 0


@dataclass(frozen=True)
class Change:
    """A change of the design: a control (with the part it is on) or parts moved by `move` (3,) [m];
    or the ends of the seat's travel moved: lower and upper end of it, forward and up [m]."""

    words: str
    control: str = ""
    parts: tuple[str, ...] = ()
    move: tuple[float, float, float] = (0.0, 0.0, 0.0)
    travel_forward: tuple[float, float] = (0.0, 0.0)
    travel_up: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class IntervalRule:
    """How a share's interval is found: method "wilson" or "bootstrap", with its seed and number of
    draws."""

    method: str = "wilson"
    seed: int = 0
    draws: int = 10_000


@dataclass(frozen=True)
class Requirement:
    """The smallest thing that is asked of a person: one control, one clearance, the view, the pedals.

    name: "reach throttle", "right knee clear of the panel": unique in a result; criterion: the
    criterion of the study that it belongs to; check: as of the criterion; target: the control or part; zone: of a reach, 0 of others.
    """

    name: str
    criterion: str
    check: str
    target: str
    zone: int = 0


@dataclass(frozen=True)
class GroupShare:
    """The share, 0 to 1, of a group ("everybody", "women", "75 % men") that is served, with its
    interval."""

    group: str
    share: float
    low: float
    high: float
    count: int


@dataclass(frozen=True)
class Gain:
    """What a change of the design would gain, found from the margins and confirmed by a run with
    the change made.

    words: "moving flaps 32 mm aft"; requirement: the one it is for; move [m]; rate: share gained by
    a metre, and margin_rate: metres by which the margin grows with a metre, mean of those who do
    not meet the requirement, both at the design as it is; before, after: the share that meets the
    requirement without and with the change (run again); joint_before, joint_after: the share that
    meets all.
    """

    words: str
    requirement: str
    move: float
    rate: float
    before: float
    after: float
    joint_before: float
    joint_after: float
    margin_rate: float = math.nan


@dataclass(frozen=True, eq=False)
class ReachMap:
    """The share of people who reach each point of a part: points and normals (M, 3) [m], share (M,)
    0 to 1; flat (M, 2) [m]: the points in the part's main plane, first to the sitter's right, then
    up."""

    task: MapTask
    points: Floats
    normals: Floats
    flat: Floats
    share: Floats
