"""A crash in words: what meets what, when, how fast and how deep; one story from the same data
every time."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from workbench.model.motion_case import Agreement, ContactEvent, StopBreach
from workbench.model.result import MotionFound, Verdict
from workbench.model.simulation import STANDARD_GRAVITY, Pulse, gained
from workbench.model.stops import motion_words
from workbench.model.units import plain
from workbench.report.sentences import milliseconds

__all__ = [
    "agreement_sentence",
    "breach_sentence",
    "differs_words",
    "happening",
    "meeting_sentence",
    "motion_scope",
    "pulse_words",
]

_MOST_AT_ONCE = 3
"""Contacts of one moment that are named."""


def meeting_sentence(meeting: ContactEvent) -> str:
    """ "At 83.4 ms the head, forehead (front) meets the upper panel at 6.1 m/s and is 31.0 mm deep
    at 91.0 ms." """
    other = plain(meeting.other)
    deep = f"{1000 * meeting.depth:.1f} mm deep at {milliseconds(meeting.deepest)}"
    deep += f", pushed back with {_newtons(meeting.force)}" if meeting.force else ""
    allowed = f" ({1000 * meeting.allowed:.0f} mm allowed)" if meeting.allowed > 0 else ""
    if meeting.began:
        text = f"From the beginning the {meeting.who} is in contact with the {other}; it is {deep}{allowed}"
    else:
        text = (
            f"At {milliseconds(meeting.enter)} the {meeting.who} meets the {other} at {meeting.speed:.1f} m/s "
            f"({max(meeting.normal, 0.0):.1f} m/s toward it) and is {deep}{allowed}"
        )
    return text + ("." if meeting.lasts else f"; they part at {milliseconds(meeting.leave)}.")


def happening(motion: MotionFound, time: float) -> str:
    """What is deepest in something it may not be at a time: "upper torso in the left stick (up to
    102 mm), head in the coaming (up to 53 mm)"."""
    here = [
        meeting
        for meeting in motion.meetings
        if not meeting.own
        and meeting.depth > meeting.allowed
        and meeting.enter <= time <= meeting.leave
    ]
    if not here:
        return "nothing is deeper than allowed"
    names = dict(zip(motion.study.body.segments, motion.study.body.segment_names, strict=True))
    here.sort(key=lambda meeting: meeting.allowed - meeting.depth)
    said = [
        f"{names.get(meeting.segment, meeting.segment)} in the {plain(meeting.other)} "
        f"(up to {1000 * meeting.depth:.0f} mm)"
        for meeting in here[:_MOST_AT_ONCE]
    ]
    more = len(here) - len(said)
    return ", ".join(said) + (f", and {more} more" if more else "")


def _newtons(force: float) -> str:
    tenths = round(force, 1)  # as in the tables
    return f"{tenths / 1000:.1f} kN" if tenths >= 1000 else f"{tenths:.0f} N"


def pulse_words(pulse: Pulse) -> str:
    """ "half-sine of 16.0 g over 90 ms, which changes the vehicle's velocity by 9.0 m/s"."""
    speed = float(gained(pulse, np.array([np.inf]))[0])
    peak = pulse.peak / STANDARD_GRAVITY
    return (
        f"{pulse.shape} of {peak:.1f} g over {1000 * pulse.duration:g} ms, which changes the "
        f"vehicle's velocity by {speed:.1f} m/s"
    )


def breach_sentence(breach: StopBreach, names: dict[str, str]) -> str:
    """ "From 60.0 to 75.0 ms the neck pivot is past its stop in flexion, by 12.0 degrees at 70.0
    ms." """
    degrees = round(math.degrees(breach.worst), 2)  # as in the tables
    when = (
        f"At {milliseconds(breach.begin)}"
        if breach.end <= breach.begin
        else f"From {milliseconds(breach.begin)} to {milliseconds(breach.end)}"
    )
    return (
        f"{when} the {names[breach.joint]} is past its stop in {motion_words(breach.motion)}, by {degrees:.1f} "
        f"degrees at {milliseconds(breach.at)}."
    )


def agreement_sentence(rows: tuple[Agreement, ...], other: str) -> str:
    """The worst and the mean agreement of two motions."""
    worst = max(rows, key=lambda row: row.peak)
    mean = sum(row.rms for row in rows) / len(rows)
    return (
        f"Against {other}, joints and segments are {1000 * mean:.0f} mm apart on average (root mean square over time); "
        f"the farthest apart is the {worst.name}, {1000 * worst.peak:.0f} mm at {milliseconds(worst.at)}."
    )


def motion_scope(motion: MotionFound) -> str:
    """ "200.0 ms of pilot's motion"."""
    start, end = motion.episodes.span
    return f"{milliseconds(end - start)} of {motion.study.person}'s motion"


def differs_words(verdicts: Sequence[Verdict], motions: Sequence[str]) -> str:
    """Which criteria do not come out alike in all motions: "4 of 7 criteria fail with “the lap belt
    alone” and hold with “lap and shoulder belts”: head excursion, ...; 1 of 7 criteria ...".

    motions: their names.
    """
    failing: dict[str, list[str]] = {}
    for verdict in verdicts:
        fails = failing.setdefault(verdict.criterion.name, [])
        if not verdict.passed:
            fails.append(verdict.motion)
    by_motions: dict[tuple[str, ...], list[str]] = {}
    for name, fails in failing.items():
        by_motions.setdefault(tuple(fails), []).append(name)
    if list(by_motions) in ([], [()]):
        return "all criteria hold in all motions" if failing else "no criterion is asked"
    count = len(failing)
    return "; ".join(
        _fails_words(failed, [name for name in motions if name not in failed], names, count)
        for failed, names in by_motions.items()
        if failed
    )


def _fails_words(failed: Sequence[str], held: Sequence[str], names: list[str], count: int) -> str:
    """Which of so many criteria fail in some motions and hold in the others."""
    one = len(names) == 1
    lead = f"{len(names)} of {count} criteria" if count > 1 else "the criterion"
    fails = f"{lead} {'fails' if one else 'fail'} with {_listed(failed)}"
    holds = f" and {'holds' if one else 'hold'} with {_listed(held)}" if held else ""
    return f"{fails}{holds}: {', '.join(names)}"


def _listed(names: Sequence[str]) -> str:
    return " and ".join(f"“{name}”" for name in names)
