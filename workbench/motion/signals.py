"""Signals of a crash: filters, accelerations, head injury criterion, the level held for 3 ms,
change of velocity."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.errors import InputError, UsageError
from workbench.model.arrays import Floats

__all__ = [
    "CFC",
    "GRAVITY",
    "Hic",
    "acceleration",
    "cfc_filter",
    "evenly",
    "held_level",
    "hic",
    "velocity",
]

GRAVITY = 9.80665
"""[m/s2] One g."""
CFC: tuple[int, ...] = (60, 180, 600, 1000)
_EVEN = 1e-3


@dataclass(frozen=True)
class Hic:
    """Head injury criterion: value [s g^2.5], and the window from `start` to `end` [s] that gives
    it."""

    value: float
    start: float
    end: float


def evenly(time: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Time (n,) and values (n, ...) at even steps: as they are where they are even, else linear at
    the median step.

    InputError for fewer than 3 samples.
    """
    if len(time) < 3:
        raise InputError(
            f"a signal of {len(time)} samples has no acceleration: 3 or more are needed"
        )
    steps = np.diff(time)
    step = float(np.median(steps))
    if np.all(np.abs(steps - step) <= _EVEN * step):
        return time, values
    count = int(np.floor((time[-1] - time[0]) / step + 1e-9)) + 1
    even = time[0] + step * np.arange(count)
    flat = values.reshape(len(time), -1)
    columns = [np.interp(even, time, flat[:, k]) for k in range(flat.shape[1])]
    return even, np.stack(columns, axis=-1).reshape(count, *values.shape[1:])


def velocity(time: Floats, position: Floats) -> Floats:
    """(n, 3) [m/s] of positions (n, 3) [m] at even times: central differences, one-sided at the
    ends."""
    return np.asarray(np.gradient(position, time, axis=0, edge_order=2))


def acceleration(time: Floats, position: Floats) -> Floats:
    """(n, 3) [m/s2] of positions (n, 3) [m] at even times: second differences; the ends repeat
    their neighbours."""
    step = (time[-1] - time[0]) / (len(time) - 1)
    inner = (position[2:] - 2 * position[1:-1] + position[:-2]) / step**2
    return np.concatenate([inner[:1], inner, inner[-1:]])


def cfc_filter(time: Floats, values: Floats, *, cfc: int) -> Floats:
    """Values (n, ...) at even times through a channel frequency class of SAE J211-1 (1995),
    appendix C.

    A Butterworth low-pass of two poles, run forward and backward, so that nothing is delayed; each
    pass at 2.0775 CFC [Hz]. UsageError for other classes and for samples too far apart for the
    class (J211 asks for 10 CFC a second).
    """
    from scipy.signal import butter, sosfiltfilt  # takes a second to load

    if cfc not in CFC:
        raise UsageError(f"cfc {cfc}: the classes are {', '.join(map(str, CFC))}")
    rate = (len(time) - 1) / (time[-1] - time[0])
    if rate < 5 * cfc:
        fits = [c for c in CFC if rate >= 5 * c]
        what = (
            f"CFC {fits[-1]} is the highest it can carry"
            if fits
            else "it can carry no class: do without a filter"
        )
        raise UsageError(
            f"cfc {cfc} needs {10 * cfc} samples a second, the signal has {rate:.0f}; {what}"
        )
    poles = butter(2, 2.0775 * cfc, fs=rate, output="sos")
    return np.asarray(
        sosfiltfilt(poles, values, axis=0, padlen=min(len(time) - 1, int(rate / cfc)))
    )


def hic(time: Floats, resultant: Floats, *, window: float) -> Hic:
    """Head injury criterion of a resultant acceleration (n,) [m/s2] of the head's centre of
    gravity.

    max over t1 < t2, t2 - t1 <= window [s], of (t2 - t1) (mean of a [g] from t1 to t2)^2.5 (FMVSS
    208 S6.2 with
    0.015 s, FMVSS 213 with 0.036 s). Both ends are searched: the longest window is not the best
    one. O(n w) on the integral, which is exact for a signal linear between samples; ends fall on
    samples.
    """
    if window <= 0:
        raise UsageError(f"window {window:g} s: a positive time is needed")
    at, level = evenly(time, np.abs(resultant) / GRAVITY)
    step = (at[-1] - at[0]) / (len(at) - 1)
    total = np.concatenate([[0.0], np.cumsum(0.5 * (level[1:] + level[:-1])) * step])
    best = 0.0
    where = (0, 1)
    for width in range(1, min(len(at) - 1, int(np.floor(window / step + 1e-9))) + 1):
        gain = total[width:] - total[:-width]
        first = int(np.argmax(gain))
        value = float(gain[first]) ** 2.5 / (width * step) ** 1.5
        if value > best:
            best = value
            where = (first, first + width)
    if step > window:
        raise InputError(
            f"samples {1000 * step:g} ms apart are too far for a window of {1000 * window:g} ms"
        )
    return Hic(best, float(at[where[0]]), float(at[where[1]]))


def held_level(time: Floats, values: Floats, *, hold: float = 0.003) -> float:
    """The highest level that values (n,) do not leave for `hold` [s] on end (the 3 ms clip), linear
    between samples."""
    if hold <= 0 or time[-1] - time[0] < hold:
        raise InputError(
            f"a signal of {1000 * (time[-1] - time[0]):g} ms cannot hold a level for {1000 * hold:g} ms"
        )
    low = float(np.min(values))
    high = float(np.max(values))
    for _ in range(60):
        level = 0.5 * (low + high)
        low, high = (level, high) if _longest(time, values, level) >= hold else (low, level)
    return low


def _longest(time: Floats, values: Floats, level: float) -> float:
    """The longest time [s] on end with values at or above a level."""
    above = values >= level
    if above.all():
        return float(time[-1] - time[0])
    change = np.flatnonzero(above[1:] != above[:-1])
    share = (level - values[change]) / (values[change + 1] - values[change])
    cross = time[change] + share * (time[change + 1] - time[change])
    edges = np.concatenate([[time[0]] if above[0] else [], cross, [time[-1]] if above[-1] else []])
    return float(np.max(edges[1::2] - edges[0::2], initial=0.0))
