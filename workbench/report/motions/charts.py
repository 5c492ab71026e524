"""Charts of a crash as SVG: when what is in contact, and curves over time."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.motion_case import Meeting
from workbench.model.result import MotionFound
from workbench.report.words import milliseconds

__all__ = ["clearance_curves", "curves", "timeline"]

WIDTH = 1100
_LEFT = 330
_RIGHT = 32
_ROW = 22
_COLOURS = ("#1f5fa8", "#b3261e", "#1f7a4d", "#8a5a00", "#6b3fa0", "#00798c")
_FONT = "font-family=\"system-ui, 'DejaVu Sans', sans-serif\""
_SOFT = f'font-size="12" fill="#5c6b7a" {_FONT}'
_MOST_ROWS = 24


def timeline(result: MotionFound) -> str:
    """A row for each pair that meets, a bar for each contact from first touch to parting, the
    deepest moment marked."""
    rows: dict[tuple[str, str], list[Meeting]] = {}
    for meeting in result.meetings:
        rows.setdefault((meeting.segment, meeting.other), []).append(meeting)
    kept = sorted(rows.items(), key=lambda item: -max(m.depth - m.allowed for m in item[1]))[
        :_MOST_ROWS
    ]
    kept.sort(key=lambda item: min(m.enter for m in item[1]))
    if not kept:
        return ""
    names = dict(zip(result.study.body.segments, result.study.body.segment_names, strict=True))
    axis = _Axis(result.episodes.span)
    height = 34 + _ROW * len(kept)
    parts = [_open(height, "Contacts over time"), *axis.grid(height)]
    for row, ((segment, other), meetings) in enumerate(kept):
        y = 8 + _ROW * row
        label = f"{names.get(segment, segment)}: {other.replace('_', ' ')}"
        parts.append(
            f'<text x="{_LEFT - 10}" y="{y + 13}" text-anchor="end" font-size="12.5" fill="#1d2733" {_FONT}>'
            f"{escape(_cut(label))}</text>"
        )
        for m in meetings:
            left = axis.x(m.enter)
            right = max(axis.x(m.leave), axis.x(m.enter) + 2)
            over = m.depth > m.allowed + 1e-9
            colour = ("#b3261e" if over else "#8fa8c2") if not m.own else "#d79a00"
            said = f"{m.who}, {m.other}: {1000 * m.depth:.1f} mm deep at {milliseconds(m.deepest)}"
            box = f'x="{left:.1f}" y="{y + 2}" width="{right - left:.1f}" height="14"'
            parts.append(f'<rect {box} rx="2" fill="{colour}"><title>{escape(said)}</title></rect>')
            at = axis.x(m.deepest)
            parts.append(f'<path d="M{at:.1f} {y + 1}v16" stroke="#1d2733" stroke-width="1.4"/>')
    return "\n".join([*parts, "</svg>"])


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
    """Curves over time with a key; zero: the part below 0 is shaded."""
    height = 260
    top = 14
    bottom = 34
    axis = _Axis((float(time[0]), float(time[-1])), left=70)
    low = min([float(v.min()) for _, v in lines] + [0.0])
    high = max([float(v.max()) for _, v in lines] + [low + 1e-9])
    step = _step(high - low)
    low = step * np.floor(low / step)
    high = step * np.ceil(high / step)

    def y(value: float) -> float:
        return float(top + (high - value) / (high - low) * (height - top - bottom))

    parts = [_open(height, title)]
    if zero and low < 0:
        parts.append(
            f'<rect x="70" y="{y(0):.1f}" width="{WIDTH - 70 - _RIGHT}" height="{y(low) - y(0):.1f}" fill="#fbe9e7"/>'
        )
    for value in np.arange(low, high + step / 2, step):
        parts.append(f'<path d="M70 {y(value):.1f}H{WIDTH - _RIGHT}" stroke="#d9dfe5"/>')
        parts.append(
            f'<text x="62" y="{y(value) + 4:.1f}" text-anchor="end" {_SOFT}>{value + 0.0:g}</text>'
        )
    parts += [*axis.grid(height), f'<text x="8" y="12" {_SOFT}>{unit}</text>']
    for k, (name, values) in enumerate(lines):
        points = " ".join(
            f"{axis.x(t):.1f},{y(v):.1f}" for t, v in zip(*_thinned(time, values), strict=True)
        )
        colour = _COLOURS[k % len(_COLOURS)]
        parts.append(
            f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="1.6"/>'
        )
        x = 84 + (k % 3) * 330
        row = top + 12 + 16 * (k // 3)
        parts.append(
            f'<path d="M{x} {row - 4}h18" stroke="{colour}" stroke-width="3"/><text x="{x + 24}" y="{row}" '
            f'font-size="12.5" fill="#1d2733" {_FONT}>{escape(name)}</text>'
        )
    return "\n".join([*parts, "</svg>"])


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
        self.left, (self.start, self.end) = left, span
        self.scale = (WIDTH - left - _RIGHT) / max(span[1] - span[0], 1e-9)

    def x(self, time: float) -> float:
        return self.left + (time - self.start) * self.scale

    def grid(self, height: int) -> list[str]:
        step = _step(1000 * (self.end - self.start), wanted=8)
        first = step * np.ceil(1000 * self.start / step - 1e-9)
        parts = []
        for ms in np.arange(first, 1000 * self.end + step * 1e-6, step):
            x = self.x(ms / 1000)
            parts.append(f'<path d="M{x:.1f} 4V{height - 24}" stroke="#d9dfe5"/>')
            parts.append(
                f'<text x="{x:.1f}" y="{height - 8}" text-anchor="middle" {_SOFT}>{ms + 0.0:g} ms</text>'
            )
        return parts


def _step(span: float, *, wanted: int = 5) -> float:
    """A round step that divides a span into about `wanted` parts."""
    rough = max(span, 1e-9) / wanted
    power = 10.0 ** np.floor(np.log10(rough))
    return float(power * min((1, 2, 5, 10), key=lambda m: abs(m * power - rough)))


def _cut(text: str) -> str:
    return text if len(text) <= 46 else text[:45] + "…"


def _open(height: int, title: str) -> str:
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" height="{height}" '
        f'role="img"><title>{escape(title)}</title>'
    )
