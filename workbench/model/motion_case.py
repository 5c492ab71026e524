"""A motion of a body in an environment: what is asked of it, and what happens in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from workbench.model.arguments import short_repr
from workbench.model.arrays import Bools, Floats
from workbench.model.body import Body
from workbench.model.criterion import Criterion
from workbench.model.environment import Environment
from workbench.model.poses import Poses
from workbench.model.simulation import Belt, ContactRule, Pulse

__all__ = [
    "Agreement",
    "ContactEvent",
    "Excursion",
    "ForceCurve",
    "MotionCase",
    "Signal",
    "SignalPoint",
    "StopBreach",
]


@dataclass(frozen=True)
class SignalPoint:
    """A point whose motion is wanted.

    Parameters
    ----------
    segment, at
        Index of its segment, and where it is in the frame of the segment (3,) [m]: 0 is the centre
        of gravity.
    filter_class
        Channel frequency class of its accelerations, `j211` for that of SAE J211-1, or None for no filter.
    """

    name: str
    segment: int
    at: tuple[float, float, float]
    filter_class: int | Literal["j211"] | None = None


@dataclass(frozen=True, eq=False)
class MotionCase:
    """The motion of one person in one case, in its surroundings.

    Parameters
    ----------
    case, name
        The case of the study, and what the motion is called: with the role and the size of the
        person where there are several.
    person, body, motion
        The role, its body (B = 1) and P poses with times [s].
    environment, cabin
        The surroundings with the belts where they run at the first frame, and without them.
    points
        Whose signals are found.
    criteria
        The criteria that are asked of this case.
    belts, pulse
        The belts that are worn and the vehicle's own motion, None where it is not stated.
    forces
        Laws of contact.
    bears
        (K,) parts whose depth counts from their surface.
    warnings
        What a reader must know of how the motion was read.
    """

    case: str
    name: str
    person: str
    body: Body
    motion: Poses
    environment: Environment
    cabin: Environment
    points: tuple[SignalPoint, ...] = ()
    criteria: tuple[Criterion, ...] = ()
    belts: tuple[Belt, ...] = ()
    pulse: Pulse | None = None
    forces: tuple[ContactRule, ...] = ()
    bears: Bools = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    warnings: tuple[str, ...] = ()

    __repr__ = short_repr


@dataclass(frozen=True)
class ContactEvent:
    """One contact of the motion. who: the sphere that meets first in words ("head, forehead
    (front)"); deep: the one that is deepest; other: the part or segment. sphere, polygon,
    other_sphere: the numbers of what is deepest, of a polygon in its part; -1 where there is none.

    enter, deepest, leave [s]; began, lasts: in contact already at the first, still at the last
    frame. depth, allowed [m]; speed, normal, tangential [m/s]: of the sphere as it meets the part,
    normal toward it. point (3,) [m] where they meet. force [N]: at the deepest, by the law of the
    pair; None where there is no law.
    """

    segment: str
    who: str
    other: str
    enter: float
    deepest: float
    leave: float
    began: bool
    lasts: bool
    depth: float
    allowed: float
    speed: float
    normal: float
    tangential: float
    point: tuple[float, float, float]
    own: bool
    deep: str
    sphere: int
    polygon: int
    other_sphere: int
    force: float | None = None


@dataclass(frozen=True)
class StopBreach:
    """A joint past its stop from `begin` to `end` [s], by at most `worst` [rad] at `at` [s] in a
    motion's direction."""

    joint: str
    motion: str
    begin: float
    end: float
    at: float
    worst: float


@dataclass(frozen=True)
class Excursion:
    """How far [m] the surface of a sphere gets along a criterion's direction at most, and in which
    frame."""

    value: float
    frame: int
    sphere: int


@dataclass(frozen=True, eq=False)
class Signal:
    """A point's motion: time (n,) [s], position, velocity, acceleration (n, 3) in SI units, filtered
    by class `cfc` (None: not), at even times then; figures: name -> (value, begin [s], end [s]);
    note: how the filter differs from that of SAE J211-1, "" where it does not."""

    point: SignalPoint
    time: Floats
    position: Floats
    velocity: Floats
    acceleration: Floats
    cfc: int | None
    figures: Mapping[str, tuple[float, float, float]]
    note: str = ""


@dataclass(frozen=True, eq=False)
class Agreement:
    """How near a joint or segment of one motion is to that of the other, on one time axis: root
    mean square and peak [m], and when the peak is [s]."""

    name: str
    rms: float
    peak: float
    at: float


@dataclass(frozen=True, eq=False)
class ForceCurve:
    """The force of a part on a segment at each frame, by its law: force (P,) [N]. segment "": the
    tension of a belt."""

    segment: str
    part: str
    force: Floats
