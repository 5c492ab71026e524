"""Injury rules: figures of the signals of a motion against the limits of a rule set."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from workbench.model.criterion import Criterion, Limit
from workbench.model.motion_case import Signal
from workbench.model.result import Finding, MotionFound
from workbench.study.crash.frames import figure_of

__all__ = ["moments", "too_coarse"]


def moments(found: MotionFound, criterion: Criterion) -> list[Finding]:
    """The figures of the rules, that first of which most is used up."""
    findings = [_figure(found, limit, signal) for limit, signal in _pairs(found, criterion)]
    return sorted(findings, key=lambda finding: -finding.value / finding.limit)


def too_coarse(found: MotionFound, criterion: Criterion) -> str:
    """Why the rules cannot be judged: samples too far apart for a figure; "" where they can."""
    for limit, signal in _pairs(found, criterion):
        step = float(np.diff(signal.time).max())
        if step > 0.5 * limit.span:
            return (
                f"samples of {signal.point.name} are {1000 * step:.3g} ms apart; a figure over "
                f"{1000 * limit.span:g} ms needs denser ones"
            )
    return ""


def _pairs(found: MotionFound, criterion: Criterion) -> Iterator[tuple[Limit, Signal]]:
    """Each limit with the signals that it is about."""
    for limit in criterion.limits:
        segment = found.study.body.segment(limit.segment)
        for signal in found.signals:
            if signal.point.segment == segment:
                yield limit, signal


def _figure(found: MotionFound, limit: Limit, signal: Signal) -> Finding:
    """A limit of a rule set and its figure of a signal."""
    value, begin, end = figure_of(signal, limit)
    window = "" if np.isinf(limit.span) else f"{1000 * limit.span:g}"
    if limit.figure == "hic":
        which = f"HIC{window}" if window else "HIC (window of any length)"
        figure = f"{which} from {1000 * begin:.1f} to {1000 * end:.1f} ms"
    else:
        figure = f"acceleration held for {window} ms"
    return Finding(
        case=found.study.case,
        person=found.study.person,
        other_person="",
        subject=f"{signal.point.name}, {figure}",
        target=limit.source,
        value=-value,
        limit=-limit.value,
        unit="" if limit.figure == "hic" else "g",
        time=begin,
    )
