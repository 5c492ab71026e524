"""Charts of a crash as SVG: when what is in contact, and curves over time."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.motion_case import ContactEvent
from workbench.model.result import MotionFound
from workbench.model.units import plain
from workbench.report.sentences import milliseconds, proper_minus

__all__ = ["clearance_curves", "curves", "timeline"]

WIDTH = 1100
_LEFT = 330
_RIGHT = 32
_ROW = 22
_COLOURS = ("#0072b2", "#c1440e", "#00785a", "#8f4478", "#7a5c00", "#333f4c")
"""Colours of curves, after Okabe and Ito, darker where they are thin on white."""
_DASHES = ("", "7 3", "2 3", "10 3 2 3", "4 2", "12 4")
"""Strokes of curves, so that they differ without their colours."""
_FONT = "font-family=\"system-ui, 'DejaVu Sans', sans-serif\""
_SOFT = f'font-size="12" fill="#5c6b7a" {_FONT}'
_MOST_ROWS = 24
_HEIGHT = 260
_TOP = 14
_KEY_ROW = 18
"""Height [pixels] of a row of the key, which stands above the curves."""
_BOTTOM = 34
_CURVES_LEFT = 70


def timeline(result: MotionFound) -> str:
    """A row for each pair that meets, a bar for each contact from first touch to parting, the
    deepest moment marked."""
    kept = _worst_pairs(result.meetings)
    if not kept:
        return ""
    body = result.study.body
    names = dict(zip(body.segments, body.segment_names, strict=True))
    axis = _Axis(result.episodes.span)
    height = 34 + _ROW * len(kept)
    parts = [_open(height, "Contacts over time"), *axis.grid(height)]
    for row, ((segment, other), meetings) in enumerate(kept):
        y = 8 + _ROW * row
        label = f"{names.get(segment, segment)}: {plain(other)}"
        parts.append(
            f'<text x="{_LEFT - 10}" y="{y + 13}" text-anchor="end" font-size="12.5" fill="#1d2733" {_FONT}>'
            f"{escape(_cut(label))}</text>"
        )
        for meeting in meetings:
            parts += _bar(axis, y, meeting)
    return "\n".join([*parts, "</svg>"])


def _worst_pairs(
    meetings: Iterable[ContactEvent],
) -> list[tuple[tuple[str, str], list[ContactEvent]]]:
    """The pairs of a segment and what it meets that go deepest, by when they first meet."""
    rows: dict[tuple[str, str], list[ContactEvent]] = {}
    for meeting in meetings:
        rows.setdefault((meeting.segment, meeting.other), []).append(meeting)
    deepest = sorted(rows.items(), key=lambda item: -max(m.depth - m.allowed for m in item[1]))
    return sorted(deepest[:_MOST_ROWS], key=lambda item: min(m.enter for m in item[1]))


def _bar(axis: _Axis, y: float, meeting: ContactEvent) -> list[str]:
    """The bar of a contact in the row at y [pixels], and the mark of its deepest moment."""
    left = axis.x(meeting.enter)
    width = max(axis.x(meeting.leave), left + 2) - left
    at = axis.x(meeting.deepest)
    deep = meeting.depth > meeting.allowed + 1e-9
    look = (
        f'y="{y + 2}" height="14" fill="#b3261e"'
        if deep
        else f'y="{y + 6}" height="6" fill="#7fa3cc"'
    )
    if meeting.own:
        look = f'y="{y + 2.5}" height="13" fill="#f2cf6b" stroke="#5f4a00"'
    other = plain(meeting.other)
    said = (
        f"{meeting.who}, {other}: from {milliseconds(meeting.enter)} to "
        f"{milliseconds(meeting.leave)}, {1000 * meeting.depth:.1f} mm deep at "
        f"{milliseconds(meeting.deepest)}, {1000 * meeting.allowed:.0f} mm allowed"
    )
    box = f'x="{left:.1f}" width="{width:.1f}" {look}'
    return [
        f'<rect {box} rx="2"><title>{escape(said)}</title></rect>',
        f'<path d="M{at:.1f} {y + 1}v16" stroke="#1d2733" stroke-width="1.4"/>',
    ]


def clearance_curves(result: MotionFound, *, most: int = 6) -> str:
    """Clearance over time of the segments that come nearest to what they may not touch [mm]."""
    near = result.clearance.min(axis=0)
    order = [n for n in np.argsort(near, kind="stable")[:most] if np.isfinite(near[n])]
    clock = result.study.motion.clock
    lines = [
        (result.study.body.segment_names[n], 1000 * np.minimum(result.clearance[:, n], 0.5))
        for n in order
    ]
    return curves(clock, lines, unit="mm", title="Clearance over time", zero=True) if lines else ""


def curves(
    time: Floats, lines: Sequence[tuple[str, Floats]], *, unit: str, title: str, zero: bool = False
) -> str:
    """Draw curves over time with a key.

    Parameters
    ----------
    time
        (T,) [s].
    lines
        The name of each curve, and its values (T,).
    unit
        The unit of the values.
    title
        The title of the chart.
    zero
        Whether the part below 0 is shaded.
    """
    axis = _Axis((float(time[0]), float(time[-1])), left=_CURVES_LEFT)
    top = _TOP + _KEY_ROW * (1 + (len(lines) - 1) // 3)
    height = _HEIGHT + top - _TOP
    levels = _levels([values for _, values in lines], top)
    across = f"{_CURVES_LEFT} {WIDTH - _RIGHT} {1000 * axis.start:g} {1000 * axis.end:g}"
    down = f"{top} {height - _BOTTOM} {levels.high:g} {levels.low:g}"
    data = f' data-across="{across}" data-down="{down}" data-unit="{escape(unit)}"'
    parts = [_open(height, title, data)]
    if zero and levels.low < 0:
        parts.append(levels.shade())
    parts += levels.grid()
    parts += [*axis.grid(height, top), f'<text x="8" y="{top}" {_SOFT}>{unit}</text>']
    for k, (name, values) in enumerate(lines):
        samples = zip(*_thinned(time, values), strict=True)
        points = " ".join(f"{axis.x(t):.1f},{levels.y(v):.1f}" for t, v in samples)
        colour = _COLOURS[k % len(_COLOURS)]
        parts.append(
            f'<polyline data-name="{escape(name)}" points="{points}" fill="none" stroke="{colour}" '
            f'stroke-width="1.8"{_dash(k)}/>'
        )
        parts.append(_key(k, name, colour))
    return "\n".join([*parts, "</svg>"])


def _dash(k: int) -> str:
    """The stroke of the k-th curve as an attribute."""
    dash = _DASHES[k % len(_DASHES)]
    return f' stroke-dasharray="{dash}"' if dash else ""


def _key(k: int, name: str, colour: str) -> str:
    """The k-th entry of the key, three a row."""
    x = 84 + (k % 3) * 330
    y = 12 + _KEY_ROW * (k // 3)
    return (
        f'<path d="M{x - 12} {y - 4}h30" stroke="{colour}" stroke-width="2.4"{_dash(k)}/>'
        f'<text x="{x + 24}" y="{y}" '
        f'font-size="12.5" fill="#1d2733" {_FONT}>{escape(name)}</text>'
    )


@dataclass(frozen=True)
class _Levels:
    """The values of curves from bottom to top: round numbers low and high, steps between, and where
    the highest stands [pixels]."""

    low: float
    high: float
    step: float
    top: int

    def y(self, value: float) -> float:
        """Where a value stands [pixels]."""
        share = (self.high - value) / (self.high - self.low)
        return float(self.top + share * (_HEIGHT - _TOP - _BOTTOM))

    def shade(self) -> str:
        """The part below 0."""
        return (
            f'<rect x="{_CURVES_LEFT}" y="{self.y(0):.1f}" width="{WIDTH - _CURVES_LEFT - _RIGHT}" '
            f'height="{self.y(self.low) - self.y(0):.1f}" fill="#fbe9e7"/>'
        )

    def grid(self) -> list[str]:
        """A line and a number for each step."""
        parts = []
        for value in np.arange(self.low, self.high + self.step / 2, self.step):
            y = self.y(value)
            parts.append(f'<path d="M{_CURVES_LEFT} {y:.1f}H{WIDTH - _RIGHT}" stroke="#d9dfe5"/>')
            parts.append(
                f'<text x="62" y="{y + 4:.1f}" text-anchor="end" {_SOFT}>{proper_minus(f"{value + 0.0:g}")}</text>'
            )
        return parts


def _levels(values: Sequence[Floats], top: int) -> _Levels:
    """Levels that hold all values, and 0."""
    low = min([float(v.min()) for v in values] + [0.0])
    high = max([float(v.max()) for v in values] + [low + 1e-9])
    step = _step(high - low)
    return _Levels(step * np.floor(low / step), step * np.ceil(high / step), step, top)


def _thinned(time: Floats, values: Floats, most: int = 900) -> tuple[Floats, Floats]:
    """At most some 900 samples, of each group its least and its greatest, so that no peak is
    lost."""
    if len(time) <= most:
        return time, values
    groups = np.array_split(np.arange(len(time)), most // 2)
    kept = sorted(
        {int(g[np.argmin(values[g])]) for g in groups}
        | {int(g[np.argmax(values[g])]) for g in groups}
    )
    return time[kept], values[kept]


class _Axis:
    """Time from left to right."""

    def __init__(self, span: tuple[float, float], *, left: int = _LEFT) -> None:
        self.left = left
        self.start, self.end = span
        self.scale = (WIDTH - left - _RIGHT) / max(self.end - self.start, 1e-9)

    def x(self, time: float) -> float:
        return self.left + (time - self.start) * self.scale

    def grid(self, height: int, top: int = 4) -> list[str]:
        step = _step(1000 * (self.end - self.start), wanted=8)
        first = step * np.ceil(1000 * self.start / step - 1e-9)
        parts = []
        for ms in np.arange(first, 1000 * self.end + step * 1e-6, step):
            x = self.x(ms / 1000)
            parts.append(f'<path d="M{x:.1f} {top}V{height - 24}" stroke="#d9dfe5"/>')
            parts.append(
                f'<text x="{x:.1f}" y="{height - 8}" text-anchor="middle" {_SOFT}>{proper_minus(f"{ms + 0.0:g}")} ms</text>'
            )
        return parts


def _step(span: float, *, wanted: int = 5) -> float:
    """A round step that divides a span into about `wanted` parts."""
    rough = max(span, 1e-9) / wanted
    power = 10.0 ** np.floor(np.log10(rough))
    return float(power * min((1, 2, 5, 10), key=lambda m: abs(m * power - rough)))


def _cut(text: str) -> str:
    return text if len(text) <= 46 else text[:45] + "…"


def _open(height: int, title: str, data: str = "") -> str:
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" height="{height}" '
        f'role="img"{data}><title>{escape(title)}</title>'
    )
