"""Crash pulses: how a vehicle is decelerated over time."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Floats, frozen

__all__ = [
    "STANDARD_GRAVITY",
    "Pulse",
    "gained",
    "half_sine",
    "level_at",
    "table_pulse",
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
        time = frozen(self.time, np.float64, (None,), "pulse.time")
        level = frozen(self.level, np.float64, (len(time),), "pulse.level")
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
