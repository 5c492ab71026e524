"""Signals of points on a moving body, and the figures that injury limits are about."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench.errors import UsageError
from workbench.model.arrays import Floats
from workbench.model.criterion import Limit
from workbench.model.motion_case import MotionCase, Signal, SignalPoint
from workbench.model.simulation import gained, level_at
from workbench.motion.signals import (
    GRAVITY,
    acceleration,
    carries,
    cfc_filter,
    evenly,
    held_level,
    hic,
    velocity,
)

__all__ = ["LONGEST_HIC", "figure_of", "signal_of"]

_J211 = {"UT": 180, "CT": 180}
"""Channel frequency classes of accelerations by SAE J211-1 (1995), table 1: of the thorax at the
spine. That of head, pelvis and limbs is 1000."""
_USUAL = {
    ("held", 0.003): "3 ms",
    ("hic", 0.015): "HIC15",
    ("hic", 0.036): "HIC36",
    ("hic", np.inf): "HIC",
}
"""Figures of every signal, HIC of the head only, by what they are and over how long [s]."""
LONGEST_HIC = 0.2
"""[s] Windows of a HIC without a stated one are searched up to here."""


def signal_of(clock: Floats, path: Floats, point: SignalPoint, study: MotionCase) -> Signal:
    """The signal of a point that is on a path (P, 3) [m] at times (P,) [s], with its figures.
    UsageError where the frames are too few for the filter."""
    time, position = clock, path
    second = acceleration(time, position)
    moved = velocity(time, position)
    if (
        study.pulse is not None
    ):  # what the vehicle does itself is added: signals are against the ground
        toward = np.array(study.pulse.toward)
        second = second - level_at(study.pulse, time)[:, None] * toward
        moved = moved - gained(study.pulse, time)[:, None] * toward
    cfc, note = _filter_class(point, study, (len(time) - 1) / (time[-1] - time[0]))
    if cfc is not None:
        time, values = evenly(clock, np.stack([position, moved, second], axis=1))
        position, moved, second = values.transpose(1, 0, 2)
        try:
            second = cfc_filter(time, second, cfc=cfc)
        except UsageError as error:
            raise UsageError(f"filter_class of {point.name}: {error}") from None
    bare = Signal(point, time, position, moved, second, cfc, {}, note)
    level = np.linalg.norm(second, axis=1)
    most = int(np.argmax(level))
    figures = {"peak": (float(level[most]) / GRAVITY, float(time[most]), float(time[most]))}
    figures["delta-v"] = _change(bare)
    for (figure, span), name in _USUAL.items():
        if figure == "hic" and study.body.segments[point.segment] != "H":
            continue
        if np.isinf(span) or time[-1] - time[0] >= span >= np.diff(time).max():
            figures[name] = figure_of(bare, Limit(figure, "", span, 0.0, ""))
    return replace(bare, figures=figures)


def _filter_class(point: SignalPoint, study: MotionCase, rate: float) -> tuple[int | None, str]:
    """The class that a point is filtered by, None for no filter, and how that differs from SAE
    J211-1. rate: samples a second."""
    usual = _J211.get(study.body.segments[point.segment], 1000)
    asked = point.filter_class
    if asked == "j211":
        if carries(rate, usual):
            return usual, ""
        return None, f"CFC {usual} of SAE J211-1 needs {5 * usual:,} samples a second or more"
    if asked is not None and asked < usual:
        return asked, f"SAE J211-1 has CFC {usual} for it: peaks and HIC come out too low"
    return asked, ""


def figure_of(signal: Signal, limit: Limit) -> tuple[float, float, float]:
    """A limit's figure of a signal (HIC without a unit, a held level in g), and from when to when
    [s] it is."""
    known = _USUAL.get((limit.figure, limit.span), "")
    if known in signal.figures:
        return signal.figures[known]
    level = np.linalg.norm(signal.acceleration, axis=1)
    if limit.figure == "hic":
        found = hic(signal.time, level, window=min(limit.span, LONGEST_HIC))
        return found.value, found.start, found.end
    most = float(signal.time[int(np.argmax(level))])
    return held_level(signal.time, level, hold=limit.span) / GRAVITY, most, most


def _change(signal: Signal) -> tuple[float, float, float]:
    """The largest change of velocity [m/s] from the first sample on, and when."""
    change = np.linalg.norm(signal.velocity - signal.velocity[0], axis=1)
    most = int(np.argmax(change))
    return float(change[most]), float(signal.time[0]), float(signal.time[most])
