"""A crash to be simulated: who sits where, how the vehicle is stopped, what holds the occupant; and
what came of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Bools, Floats, read_only
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.poses import Poses

__all__ = [
    "STANDARD_GRAVITY",
    "Airbag",
    "Belt",
    "BeltPoint",
    "ContactRule",
    "ForceLaw",
    "JointRule",
    "Pulse",
    "Restraints",
    "Simulated",
    "Simulation",
    "depth_offset",
    "force_at",
    "force_history",
    "gained",
    "half_sine",
    "law_of",
    "level_at",
    "ruled",
    "table_pulse",
    "tension_history",
    "trapezoid",
]


STANDARD_GRAVITY = 9.80665
"""[m/s2] One g."""


@dataclass(frozen=True, eq=False)
class Pulse:
    """A deceleration of a vehicle along `toward`, the unit way (3,) in which its occupants are
    thrown.

    A half-sine of height `peak` [m/s2] and length `duration` [s] where `time` is empty; else
    straight lines through level (n,) [m/s2] at time (n,) [s]. 0 before `start` [s] and after the
    end. shape: its name.
    """

    shape: str
    start: float
    duration: float
    peak: float
    toward: tuple[float, float, float] = (1.0, 0.0, 0.0)
    time: Floats = field(default_factory=lambda: np.zeros(0))
    level: Floats = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        time = read_only(self.time, np.float64, (None,), "pulse.time")
        level = read_only(self.level, np.float64, (len(time),), "pulse.level")
        if not (
            np.isfinite(time).all() and np.isfinite(level).all() and np.all(np.diff(time) >= 0)
        ):
            raise InputError("a pulse needs finite levels at times that do not go back")
        if not (np.isfinite([self.start, self.peak]).all() and 0 < self.duration < np.inf):
            raise InputError(
                f"a pulse needs a finite peak and a positive duration, got {self.peak}, {self.duration}"
            )
        if len(level) and max(abs(level[0]), abs(level[-1])) > 1e-9 + 0.01 * np.abs(level).max():
            raise InputError("a pulse begins and ends at 0")
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "level", level)


def half_sine(peak: float, duration: float, *, start: float = 0.0) -> Pulse:
    """A half-sine pulse of peak [m/s2] and duration [s]; it changes the speed by 2 peak duration /
    pi."""
    return Pulse("half-sine", start, duration, peak)


def trapezoid(peak: float, times: tuple[float, float, float], *, start: float = 0.0) -> Pulse:
    """A trapezoid pulse of peak [m/s2]: times [s] of its rise, its plateau and its fall, any of
    which may be 0."""
    rise, hold, fall = times
    if min(times) < 0:
        raise InputError(f"the times of a trapezoid are not negative, got {times}")
    time = np.cumsum([0.0, rise, hold, fall])
    level = np.array([0.0, peak, peak, 0.0])
    shape = "trapezoid" if times[1] > 0 else "triangle"
    return Pulse(shape, start, float(time[-1]), peak, time=time, level=level)


def table_pulse(time: Floats, level: Floats, *, start: float = 0.0) -> Pulse:
    """A pulse through level (n,) [m/s2] at time (n,) [s] since its start; InputError where it does
    not end at 0."""
    if len(time) < 3:
        raise InputError(f"a pulse needs 3 samples or more, got {len(time)}")
    since = time - time[0]
    peak = float(level[np.argmax(np.abs(level))])
    return Pulse("table", start + float(time[0]), float(since[-1]), peak, time=since, level=level)


def level_at(pulse: Pulse, time: Floats) -> Floats:
    """(n,) [m/s2] the deceleration at times (n,) [s]."""
    since = np.asarray(time, dtype=np.float64) - pulse.start
    if len(pulse.time):
        return np.asarray(np.interp(since, pulse.time, pulse.level, left=0.0, right=0.0))
    inside = (since > 0) & (since < pulse.duration)
    return np.where(inside, pulse.peak * np.sin(np.pi * np.clip(since / pulse.duration, 0, 1)), 0.0)


def gained(pulse: Pulse, time: Floats) -> Floats:
    """(n,) [m/s] the speed a free occupant has gained against the vehicle by times (n,) [s]: the
    exact integral."""
    since = np.asarray(time, dtype=np.float64) - pulse.start
    if not len(pulse.time):
        share = np.clip(since / pulse.duration, 0, 1)
        return np.asarray(pulse.peak * pulse.duration / np.pi * (1.0 - np.cos(np.pi * share)))
    step = np.diff(pulse.time)
    total = np.concatenate([[0.0], np.cumsum(0.5 * (pulse.level[1:] + pulse.level[:-1]) * step)])
    at = np.clip(since, 0.0, pulse.duration)
    k = np.clip(np.searchsorted(pulse.time, at, side="right") - 1, 0, len(step) - 1)
    into = at - pulse.time[k]
    return np.asarray(
        total[k] + 0.5 * into * (pulse.level[k] + np.interp(at, pulse.time, pulse.level))
    )


# Forces of contact as functions of depth: loading along a power of the depth, unloading along a
# steeper one.


@dataclass(frozen=True)
class ForceLaw:
    """F = stiffness depth^exponent while the depth grows; stiffness [N/m^exponent].

    returned: the share of the work of loading that comes back, above 0, at most 1. On the way out
    and back in again, below the greatest depth D so far, F = F(D) (depth / D)^m with m = (exponent
    + 1) / returned - 1: both curves meet at D, and the areas under them stand as 1 to `returned`.
    friction: Coulomb's coefficient.
    """

    stiffness: float
    exponent: float = 1.0
    returned: float = 1.0
    friction: float = 0.0

    def __post_init__(self) -> None:
        fine = (
            self.stiffness >= 0
            and self.exponent >= 1
            and 0 < self.returned <= 1
            and self.friction >= 0
        )
        if not (fine and np.isfinite([self.stiffness, self.exponent, self.friction]).all()):
            raise InputError(
                "a force law needs stiffness >= 0, exponent >= 1, returned above 0 and at most 1, and "
                f"friction >= 0, got {self}"
            )

    @property
    def unloading(self) -> float:
        """The exponent m of the way out."""
        return (self.exponent + 1.0) / self.returned - 1.0


def force_at(law: ForceLaw, depth: float, deepest: float) -> float:
    """[N] at a depth [m], the deepest [m] so far being `deepest`; 0 where there is no contact."""
    if depth <= 0:
        return 0.0
    most = max(depth, deepest)
    return float(law.stiffness * most**law.exponent * (depth / most) ** law.unloading)


def force_history(law: ForceLaw, depth: Floats) -> Floats:
    """(P,) [N] over depths (P,) [m] in the order of time, negative where apart. A contact that
    parts begins anew."""
    force = np.zeros(len(depth))
    deepest = 0.0
    for p, now in enumerate(depth.tolist()):
        deepest = max(deepest, now) if now > 0 else 0.0
        force[p] = force_at(law, now, deepest)
    return force


def tension_history(law: ForceLaw, longer: Floats) -> Floats:
    """(P,) [N] over elongations (P,) [m] in the order of time. Webbing that was stretched stays as
    it has become: it pulls again along the same way back."""
    deepest = np.maximum.accumulate(np.maximum(longer, 0.0))
    return np.array(
        [
            force_at(law, now, most)
            for now, most in zip(longer.tolist(), deepest.tolist(), strict=True)
        ]
    )


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
