"""A crash to be simulated: who sits where, how the vehicle is stopped, what holds the occupant; and
what came of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.model.arrays import Bools, Floats
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.force import ForceLaw
from workbench.model.poses import Poses
from workbench.model.pulse import Pulse

__all__ = [
    "Airbag",
    "Belt",
    "BeltPoint",
    "ContactRule",
    "JointRule",
    "Restraints",
    "Simulated",
    "Simulation",
    "depth_offset",
    "law_of",
    "ruled",
]


@dataclass(frozen=True)
class BeltPoint:
    """Where a belt runs: at `at` (3,) [m] of the world, or of a segment's frame (segment -1: the
    world)."""

    segment: int
    at: tuple[float, float, float]
    name: str = ""


@dataclass(frozen=True)
class Belt:
    """Webbing that slides freely through its points from end to end. law: tension over elongation
    [m] beyond `slack` [m]; width [m]; allow [m]: how far the body may move into it where it is a
    part."""

    name: str
    points: tuple[BeltPoint, ...]
    law: ForceLaw
    slack: float
    width: float
    allow: float


@dataclass(frozen=True)
class Airbag:
    """A deployed airbag: an ellipsoid about `centre` (3,) [m] with half_axes (3,) [m], pitched
    [rad], that stands still; allow [m]: how deep every segment may go into it."""

    name: str
    centre: tuple[float, float, float]
    half_axes: tuple[float, float, float]
    pitch: float
    allow: float


@dataclass(frozen=True, eq=False)
class Restraints:
    """What holds the occupant of a motion: belts and airbags, which become parts, and the vehicle's
    pulse; seat: the one that the occupant has adjusted, by `forward` and `up` [m], "" for none."""

    pulse: Pulse | None = None
    belts: tuple[Belt, ...] = ()
    airbags: tuple[Airbag, ...] = ()
    seat: str = ""
    forward: float = 0.0
    up: float = 0.0

    @property
    def names(self) -> tuple[str, ...]:
        """The parts that they become: airbags, then belts."""
        return (*(bag.name for bag in self.airbags), *(belt.name for belt in self.belts))


@dataclass(frozen=True, eq=False)
class ContactRule:
    """The force law of some segments (N,) against some parts (K,); both masks."""

    segments: Bools
    parts: Bools
    law: ForceLaw


@dataclass(frozen=True)
class JointRule:
    """Passive stiffness [Nm/rad] toward the posture at the start and damping [Nm s/rad] of joints
    by index; None where the body's own masses say it."""

    joints: tuple[int, ...]
    stiffness: float | None
    damping: float | None


@dataclass(frozen=True, eq=False)
class Simulation:
    """A crash ready to be simulated; times in s.

    poses: one pose, where the occupant is put. bears (K,): parts that bear the sitter: contact
    counts from their surface; elsewhere from the depth that is allowed or that the posture begins
    with. rules: the last that fits a pair counts, `other` where none does; flesh: the law of
    segments against each other. tone: how stiff joints without a rule are, in moments of the weight
    they carry; relaxed: joints that do not hold the posture while the occupant settles.
    """

    name: str
    body: Body
    environment: Environment
    poses: Poses
    pulse: Pulse
    belts: tuple[Belt, ...]
    rules: tuple[ContactRule, ...]
    other: ForceLaw
    flesh: ForceLaw
    joints: tuple[JointRule, ...]
    relaxed: tuple[int, ...]
    bears: Bools
    tone: float
    gravity: float
    duration: float
    frame: float
    step: float
    settle: float
    inputs: Mapping[str, Path]


@dataclass(frozen=True, eq=False)
class Simulated:
    """What came of it: the motion in the vehicle's frame, from the settled posture on; tension (P,
    B) [N] of the belts and payout (P, B) [m], how much longer than at the start they are; kinetic,
    work (P,) [J]: energy of motion against the vehicle, and what pulse and weight have put in.
    settled [m/s]: the greatest speed left at the start."""

    motion: Poses
    tension: Floats
    payout: Floats
    kinetic: Floats
    work: Floats
    settled: float
    warnings: tuple[str, ...]


def law_of(simulation: Simulation, segment: int, part: int) -> ForceLaw:
    """The force law of a segment against a part: of the last rule that names both, else the one for
    all others."""
    return ruled(simulation.rules, segment, part) or simulation.other


def ruled(rules: tuple[ContactRule, ...], segment: int, part: int) -> ForceLaw | None:
    """The law of the last rule that names both, None where there is none."""
    fits = (rule.law for rule in reversed(rules) if rule.segments[segment] and rule.parts[part])
    return next(fits, None)


def depth_offset(bears: Bools, allowed: Floats, start: Floats | float = 0.0) -> Floats:
    """(N, K) [m] the depth from which on contact is pushed back, of allowed and starting depths (N,
    K) [m]: nothing for parts (K,) that bear who sits in them."""
    return np.where(bears, 0.0, np.maximum(allowed, np.maximum(start, 0.0)))
