"""Process the signals of a crash: filters, accelerations, and injury criteria."""

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
    "carries",
    "cfc_filter",
    "evenly",
    "hic",
    "sustained_level",
    "velocity",
]

GRAVITY = 9.80665
"""Standard gravity, one g [m/s2]."""
CFC: tuple[int, ...] = (60, 180, 600, 1000)
"""Channel frequency classes of SAE J211-1."""
_EVEN = 1e-3
"""Greatest deviation of a time step from the median one, as a share, that counts as even."""
_BISECTIONS = 60
"""Halvings of the range of levels; the rest is below the rounding of a double."""


@dataclass(frozen=True)
class Hic:
    """A head injury criterion and the window that gives it."""

    value: float
    """[s g^2.5]."""
    start: float
    """Beginning of the window [s]."""
    end: float
    """End of the window [s]."""


def evenly(time: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Resample a signal at even time steps, unless its steps are even already.

    Parameters
    ----------
    time
        (n,) times [s], increasing.
    values
        (n, ...) samples.

    Returns
    -------
    tuple of Floats
        Times (m,) at the median step, and samples (m, ...) between the given ones, linear in time.

    Raises
    ------
    InputError
        If there are fewer than 3 samples.
    """
    _require_samples(time)
    steps = np.diff(time)
    step = float(np.median(steps))
    if np.all(np.abs(steps - step) <= _EVEN * step):
        return time, values
    count = int(np.floor((time[-1] - time[0]) / step + 1e-9)) + 1
    even = time[0] + step * np.arange(count)
    columns = [np.interp(even, time, column) for column in values.reshape(len(time), -1).T]
    return even, np.stack(columns, axis=-1).reshape(count, *values.shape[1:])


def velocity(time: Floats, position: Floats) -> Floats:
    """Differentiate positions by central differences, one-sided of second order at the ends.

    Parameters
    ----------
    time
        (n,) increasing times [s].
    position
        (n, 3) [m].

    Returns
    -------
    Floats
        (n, 3) [m/s].
    """
    return np.asarray(np.gradient(position, time, axis=0, edge_order=2))


def acceleration(time: Floats, position: Floats) -> Floats:
    """Differentiate positions twice, by second differences: between steps h before and k after a
    sample, 2 ((x1 - x0) / k - (x0 - x-1) / h) / (h + k).

    Parameters
    ----------
    time
        (n,) increasing times [s].
    position
        (n, 3) [m].

    Returns
    -------
    Floats
        (n, 3) [m/s2]; the first and the last repeat their neighbours.

    Raises
    ------
    InputError
        If there are fewer than 3 samples.
    """
    _require_samples(time)
    step = np.diff(time)[:, None]
    rate = np.diff(position, axis=0) / step
    inner = 2.0 * np.diff(rate, axis=0) / (step[1:] + step[:-1])
    return np.concatenate([inner[:1], inner, inner[-1:]])


def cfc_filter(time: Floats, values: Floats, *, cfc: int) -> Floats:
    """Filter a signal by a channel frequency class.

    The filter is a two-pole Butterworth low-pass, run forward and backward, so that it has no phase
    shift. The cutoff frequency of each pass is 2.0775 CFC [Hz].

    Parameters
    ----------
    time
        (n,) even times [s].
    values
        (n, ...) samples.
    cfc
        Channel frequency class, one of CFC.

    Raises
    ------
    UsageError
        If there is no such class, or the sampling rate is too low for it.

    References
    ----------
    SAE J211-1 (1995), Instrumentation for impact test, appendix C. It asks for a sampling rate of
    10 CFC; half of that is accepted here.
    """
    from scipy.signal import butter, sosfiltfilt  # takes a second to load

    if cfc not in CFC:
        raise UsageError(f"cfc {cfc}: the classes are {', '.join(map(str, CFC))}")
    rate = (len(time) - 1) / (time[-1] - time[0])
    _require_rate(rate, cfc)
    sections = butter(2, 2.0775 * cfc, fs=rate, output="sos")
    padding = min(len(time) - 1, int(rate / cfc))
    return np.asarray(sosfiltfilt(sections, values, axis=0, padlen=padding))


def _require_samples(time: Floats) -> None:
    """Refuse a signal of too few samples."""
    if len(time) < 3:
        raise InputError(
            f"a signal of {len(time)} samples has no acceleration: 3 or more are needed"
        )


def carries(rate: float, cfc: int) -> bool:
    """Whether a sampling rate [1/s] is high enough for a class."""
    return rate >= 5 * cfc


def _require_rate(rate: float, cfc: int) -> None:
    """Refuse a sampling rate [1/s] that is too low for a class."""
    if carries(rate, cfc):
        return
    possible = [c for c in CFC if carries(rate, c)]
    advice = (
        f"CFC {possible[-1]} is the highest it can carry"
        if possible
        else "it can carry no class: do without a filter"
    )
    raise UsageError(
        f"cfc {cfc} needs {10 * cfc} samples a second, the signal has {rate:.0f}; {advice}"
    )


def hic(time: Floats, resultant: Floats, *, window: float) -> Hic:
    """Compute the head injury criterion of a resultant acceleration.

    HIC = max over t1 < t2 <= t1 + window of (t2 - t1) (1 / (t2 - t1) integral of a dt)^2.5, with
    the acceleration a in g. Both ends are searched, since a shorter window often gives more. The
    search takes O(n w) time for n samples and w samples in the window. The integral is exact for a
    signal that is linear between samples; ends of windows are samples.

    Parameters
    ----------
    time
        (n,) times [s].
    resultant
        (n,) acceleration [m/s2] of the head's centre of gravity.
    window
        Longest window [s]: 0.015 (FMVSS 208 S6.2) or 0.036 (FMVSS 213).

    Raises
    ------
    UsageError
        If the window is not positive.
    InputError
        If there are fewer than 3 samples, or all are further apart than the window.
    """
    if window <= 0:
        raise UsageError(f"window {window:g} s: a positive time is needed")
    _require_samples(time)
    level = np.abs(resultant) / GRAVITY
    step = np.diff(time)
    longest = window * (1.0 + 1e-9)
    if step.min() > longest:
        raise InputError(
            f"samples {1000 * step.min():g} ms apart are too far for a window of {1000 * window:g} ms"
        )
    integral = np.concatenate([[0.0], np.cumsum(0.5 * (level[1:] + level[:-1]) * step)])
    last = np.searchsorted(time, time + longest, side="right") - 1
    best = Hic(0.0, float(time[0]), float(time[1]))
    for width in range(1, int((last - np.arange(len(time))).max()) + 1):
        span = time[width:] - time[:-width]
        gain = integral[width:] - integral[:-width]
        # (t2 - t1) (gain / (t2 - t1))^2.5 = gain^2.5 / (t2 - t1)^1.5
        values = np.where(span <= longest, gain**2.5 / span**1.5, 0.0)
        first = int(np.argmax(values))
        if values[first] > best.value:
            best = Hic(float(values[first]), float(time[first]), float(time[first + width]))
    return best


def sustained_level(time: Floats, values: Floats, *, hold: float = 0.003) -> float:
    """Find the highest level that a signal holds for a time on end (the 3 ms criterion).

    The level is found by bisection: a higher level is held for a shorter time.

    Parameters
    ----------
    time, values
        (n,) times [s] and samples, linear in between.
    hold
        Time [s] for which the signal stays at or above the level.

    Returns
    -------
    float
        The level, in the unit of the values.

    Raises
    ------
    InputError
        If the signal is shorter than `hold`.
    """
    if hold <= 0 or time[-1] - time[0] < hold:
        raise InputError(
            f"a signal of {1000 * (time[-1] - time[0]):g} ms cannot hold a level for {1000 * hold:g} ms"
        )
    low = float(np.min(values))
    high = float(np.max(values))
    for _ in range(_BISECTIONS):
        level = 0.5 * (low + high)
        if _longest_above(time, values, level) >= hold:
            low = level
        else:
            high = level
    return low


def _longest_above(time: Floats, values: Floats, level: float) -> float:
    """Longest time [s] on end with values at or above a level."""
    above = values >= level
    if above.all():
        return float(time[-1] - time[0])
    change = np.flatnonzero(above[1:] != above[:-1])
    share = (level - values[change]) / (values[change + 1] - values[change])
    crossing = time[change] + share * (time[change + 1] - time[change])
    # the signal is above between crossings 0 and 1, 2 and 3, ... and up to its own ends
    first = [time[0]] if above[0] else []
    last = [time[-1]] if above[-1] else []
    edges = np.concatenate([first, crossing, last])
    return float(np.max(edges[1::2] - edges[0::2], initial=0.0))
