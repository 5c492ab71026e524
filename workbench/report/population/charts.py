"""Small charts of an accommodation as SVG: one a table row, as wide as its cell, so that text stays
readable."""

from __future__ import annotations

import math
from html import escape

import numpy as np

from workbench.model.arrays import Floats

__all__ = [
    "bar",
    "change_whisker",
    "changes_axis",
    "margin_axis",
    "margin_range",
    "margin_strip",
    "share_axis",
    "whisker",
]

OUT, ALONE, BLUE, SOFT, GRID = "#eab3ac", "#b3261e", "#1f5fa8", "#5c6b7a", "#d9dfe5"
_HEIGHT = 20
_MOST = 0.4  # [m] margins beyond are shown at the end of the axis


def bar(whole: float, part: float, *, most: float, said: str) -> str:
    """A bar of a share with a darker part at its beginning; most: the share at the right end of the
    cell."""
    scale = 100 / max(most, 1e-9)
    shapes = [
        f'<rect x="0" y="4" width="{min(share * scale, 100):.2f}%" height="12" rx="1.5" fill="{colour}"/>'
        for share, colour in ((whole, OUT), (part, ALONE))
        if share > 0
    ]
    return _picture([*shapes, f'<path d="M0.5 1v18" stroke="{GRID}"/>'], said)


def whisker(low: float, share: float, high: float, *, least: float, said: str) -> str:
    """A share as a dot on its interval; least: the share at the left end of the cell, 1 at its
    right."""
    x = [f"{4 + 92 * (value - least) / max(1 - least, 1e-9):.2f}%" for value in (low, share, high)]
    shapes = [f'<line x1="{x[0]}" x2="{x[2]}" y1="10" y2="10" stroke="{BLUE}" stroke-width="2"/>']
    shapes += [
        f'<line x1="{end}" x2="{end}" y1="5" y2="15" stroke="{BLUE}" stroke-width="2"/>'
        for end in x[::2]
    ]
    shapes.append(f'<circle cx="{x[1]}" cy="10" r="4.5" fill="{BLUE}"/>')
    return _picture(shapes, said)


def share_axis(least: float) -> str:
    """The axis of whiskers, in per cent."""
    step = next(step for step in (0.02, 0.05, 0.1, 0.25, 0.5) if (1 - least) / step < 2.51)
    ticks = np.arange(math.ceil(least / step - 1e-9) * step, 1 + step / 2, step)
    marks = [(4 + 92 * (t - least) / max(1 - least, 1e-9), f"{100 * t:.0f}") for t in ticks]
    return _picture(_ticks(marks, " %"), "share that fits, in per cent")


def change_whisker(low: float, change: float, high: float, *, reach: float, said: str) -> str:
    """A change of a share as a dot on its interval about a zero in the middle; reach: the change at
    the right end. Green where all of the interval is a gain, red where all is a loss."""
    colour = "#1f7a4d" if low > 0 else ALONE if high < 0 else BLUE
    x = [f"{50 + 46 * value / reach:.2f}%" for value in (low, change, high)]
    shapes = [f'<line x1="50%" x2="50%" y1="0" y2="{_HEIGHT}" stroke="#8d99a8"/>']
    shapes.append(
        f'<line x1="{x[0]}" x2="{x[2]}" y1="10" y2="10" stroke="{colour}" stroke-width="2"/>'
    )
    shapes += [
        f'<line x1="{end}" x2="{end}" y1="5" y2="15" stroke="{colour}" stroke-width="2"/>'
        for end in x[::2]
    ]
    return _picture([*shapes, f'<circle cx="{x[1]}" cy="10" r="4.5" fill="{colour}"/>'], said)


def changes_axis(reach: float) -> str:
    """The axis of changes, in points of per cent."""
    step = _step(100 * reach, wanted=2)
    count = math.floor(100 * reach / step + 1e-9)
    numbers = [step * k for k in range(-count, count + 1)]
    marks = [(50 + 0.46 * n / reach, f"{n:+g}".replace("-", "−") if n else "0") for n in numbers]
    return _picture(_ticks(marks, ""), "change, in points of per cent")


def margin_range(spread: Floats) -> tuple[float, float]:
    """Least and greatest margin [m] of the axis that all strips share, from the spreads (R, 5) [m];
    zero is on it."""
    known = spread[np.isfinite(spread)]
    low = float(np.clip(known.min(), -_MOST, 0)) if len(known) else 0.0
    high = float(np.clip(known.max(), 0, _MOST)) if len(known) else 0.0
    room = max(0.06 * (high - low), 0.01)
    return low - room, high + room


def margin_strip(spread: Floats, ends: tuple[float, float], *, said: str) -> str:
    """The spread (5,) [m] of a margin at 1, 5, 50, 95 and 99 %: a line, a box from 5 to 95 %, a
    stroke at the median; what is below zero is red. What lies beyond the ends of the axis ends in
    an arrow."""
    if not np.isfinite(spread).all():
        return ""
    zero = _along(0.0, ends)
    x = [_along(float(value), ends) for value in spread]
    shapes = [
        f'<rect x="0" y="0" width="{zero:.2f}%" height="{_HEIGHT}" fill="#fbe9e7"/>',
        *_span(x[0], x[4], zero, 'y="9"', 'height="2"'),
        *_span(x[1], x[3], zero, 'y="5"', 'height="10"'),
        f'<line x1="{zero:.2f}%" x2="{zero:.2f}%" y1="0" y2="{_HEIGHT}" stroke="#1d2733"/>',
    ]
    if ends[0] <= spread[2] <= ends[1]:
        median = f'x1="{x[2]:.2f}%" x2="{x[2]:.2f}%" y1="3" y2="17"'
        shapes.append(f'<line {median} stroke="#1d2733" stroke-width="2.4"/>')
    if spread[0] < ends[0]:
        shapes.append('<path d="M7 6L1 10L7 14Z" fill="#b3261e"/>')
    if spread[4] > ends[1]:
        shapes.append(
            '<svg x="100%" overflow="visible"><path d="M-7 6L-1 10L-7 14Z" fill="#7fa3cc"/></svg>'
        )
    return _picture(shapes, said)


def _span(first: float, last: float, zero: float, y: str, height: str) -> list[str]:
    """A bar from one place to another [%], red below zero."""
    parts = ((first, min(last, zero), ALONE), (max(first, zero), last, "#7fa3cc"))
    return [
        f'<rect x="{low:.2f}%" {y} width="{max(high - low, 0.15):.2f}%" {height} fill="{colour}"/>'
        for low, high, colour in parts
        if high > low or first == last == low == high
    ]


def margin_axis(ends: tuple[float, float]) -> str:
    """The axis of margin strips, in millimetres."""
    step = _step(1000 * (ends[1] - ends[0]))
    first = math.ceil(1000 * ends[0] / step)
    numbers = [step * k for k in range(first, math.floor(1000 * ends[1] / step) + 1)]
    return _picture(
        _ticks([(_along(n / 1000, ends), f"{n:g}".replace("-", "−")) for n in numbers], ""),
        "margin in mm",
    )


def _along(value: float, ends: tuple[float, float]) -> float:
    """Per cent from the left end of an axis."""
    return float(np.clip(100 * (value - ends[0]) / (ends[1] - ends[0]), 0, 100))


def _ticks(marks: list[tuple[float, str]], unit: str) -> list[str]:
    shapes = []
    for k, (x, text) in enumerate(marks):
        anchor = "start" if x < 5 else "end" if x > 95 else "middle"
        shapes.append(f'<line x1="{x:.2f}%" x2="{x:.2f}%" y1="15" y2="20" stroke="{SOFT}"/>')
        shapes.append(
            f'<text x="{x:.2f}%" y="12" text-anchor="{anchor}" font-size="11.5" fill="{SOFT}">'
            f"{text}{unit if k == len(marks) - 1 else ''}</text>"
        )
    return shapes


def _step(span: float, *, wanted: int = 5) -> float:
    """A round step [mm] that divides a span [mm] into about `wanted` parts."""
    power = 10.0 ** math.floor(math.log10(max(span, 1e-6) / wanted))
    return power * min((1, 2, 5, 10), key=lambda m: abs(m * power - span / wanted))


def _picture(shapes: list[str], said: str) -> str:
    return (
        f'<svg class="small" width="100%" height="{_HEIGHT}" role="img"><title>{escape(said)}</title>'
        f"{''.join(shapes)}</svg>"
    )
