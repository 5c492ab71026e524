"""Crash: a motion of a body in an environment, what is asked about it, and what was found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from workbench.model.arrays import Bools, Floats
from workbench.model.body import Body
from workbench.model.criterion import Criterion, Limit
from workbench.model.environment import Environment
from workbench.model.episodes import Episodes
from workbench.model.poses import Poses
from workbench.model.pulse import Pulse
from workbench.model.simulation import Belt, ContactRule

__all__ = [
    "Agreement",
    "CrashResult",
    "CrashStudy",
    "CrashVerdict",
    "ForceCurve",
    "Meeting",
    "Signal",
    "SignalPoint",
    "StopBreach",
]


@dataclass(frozen=True)
class SignalPoint:
    """A point whose motion is wanted: at `at` (3,) [m] of a segment's frame (0: its centre of
    gravity)."""

    name: str
    segment: int
    at: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class CrashStudy:
    """A crash study ready to run. `against`: a second motion to compare with, None where there is
    none.

    compared: whether the difference of the two motions is asked for. cabin: the environment without belts, which move; belts: those of the motion. pulse: the
    vehicle's own, None where it is not stated. forces: laws of contact; bears (K,): parts whose
    depth counts from their surface. held: the same of `against`: its environment, cabin, belts and
    pulse are those of that study.
    """

    name: str
    title: str
    description: str
    environment: Environment
    person: str
    body: Body
    motion: Poses
    against: Poses | None
    against_name: str
    points: tuple[SignalPoint, ...]
    cfc: int | None
    rules: str
    limits: tuple[Limit, ...]
    criteria: tuple[Criterion, ...]
    inputs: Mapping[str, Path]
    cabin: Environment
    belts: tuple[Belt, ...] = ()
    pulse: Pulse | None = None
    forces: tuple[ContactRule, ...] = ()
    bears: Bools = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    held: CrashStudy | None = None
    motion_name: str = ""
    compared: bool = True
    film: bool = False
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Meeting:
    """One contact of the motion. who, side: in words ("forehead" of the head, "front"); other: the
    part or segment.

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


@dataclass(frozen=True, eq=False)
class Signal:
    """A point's motion at even times: time (n,) [s], position, velocity, acceleration (n, 3) in SI
    units, filtered by class `cfc` (None: not), figures: name -> (value, begin [s], end [s])."""

    point: SignalPoint
    time: Floats
    position: Floats
    velocity: Floats
    acceleration: Floats
    cfc: int | None
    figures: Mapping[str, tuple[float, float, float]]


@dataclass(frozen=True, eq=False)
class Agreement:
    """How near a joint or segment of one motion is to that of the other, on one time axis: root
    mean square and peak [m], and when the peak is [s]."""

    name: str
    rms: float
    peak: float
    at: float


@dataclass(frozen=True, eq=False)
class CrashVerdict:
    """How one criterion came out: value against limit in `unit` (mm, degrees, g or 1), at a time
    [s], in words."""

    criterion: Criterion
    passed: bool
    value: float
    limit: float
    unit: str
    at: float
    told: str


@dataclass(frozen=True, eq=False)
class ForceCurve:
    """The force of a part on a segment at each frame, by its law: force (P,) [N]. segment "": the
    tension of a belt."""

    segment: str
    part: str
    force: Floats


@dataclass(frozen=True, eq=False)
class CrashResult:
    """What was found. clearance (P, N) [m]: of each segment from everything it may not touch, at
    each frame. forces: of the pairs that have a law and touch; other: what was found of the motion
    it is compared with."""

    study: CrashStudy
    episodes: Episodes
    meetings: tuple[Meeting, ...]
    breaches: tuple[StopBreach, ...]
    signals: tuple[Signal, ...]
    clearance: Floats
    agreements: tuple[Agreement, ...]
    verdicts: tuple[CrashVerdict, ...]
    provenance: Mapping[str, Mapping[str, str]]
    warnings: tuple[str, ...]
    forces: tuple[ForceCurve, ...] = ()
    other: CrashResult | None = None

    @property
    def passed(self) -> bool:
        """True where every criterion holds."""
        return all(verdict.passed for verdict in self.verdicts)
