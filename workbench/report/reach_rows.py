"""Reaches and envelopes of a result: rows for result.json, tables, sentences, and the sections of an envelope drawn."""

from __future__ import annotations

import math

import numpy as np

from workbench.files.results import EnvelopeRow, ReachRow, ResultFile
from workbench.model.arrays import Floats
from workbench.model.envelope import Envelope
from workbench.model.result import ControlReach, Result
from workbench.report.tables import csv_text
from workbench.report.words import millimetres

__all__ = ["envelope_rows", "reach_rows", "reach_tables", "section_svg"]

SIZE, SCALE = 420, 0.11
"""Pixels of a section's picture, and pixels a millimetre."""


def reach_rows(result: Result) -> list[ReachRow]:
    """The reaches of a result in millimetres and words."""
    return [
        ReachRow(
            person=row.person,
            control=row.control,
            zone=row.zone,
            own_zone=row.own_zone,
            limb=row.limb,
            reached=row.reached,
            miss_mm=0.0 if row.reached else round(1000 * row.miss, 3),
            overlap_mm=round(1000 * row.overlap, 3),
            limit=row.limit,
            discomfort=round(row.discomfort, 4),
            sentence=_sentence(row),
        )
        for row in result.reaches
    ]


def _sentence(row: ControlReach) -> str:
    lead = f"{row.person}, zone {row.zone}: the {row.limb}"
    if row.reached:
        return f"{lead} reaches {row.control}."
    entered = f", {millimetres(row.overlap)} into it" if row.overlap > 0 else ""
    return f"{lead} stays {millimetres(row.miss)} from {row.control}, limited by {row.limit}{entered}."


def envelope_rows(result: Result) -> list[EnvelopeRow]:
    """The envelopes of a result in millimetres, litres and degrees."""
    return [
        EnvelopeRow(
            person=e.person,
            limb=e.limb,
            zone=e.zone,
            origin_mm=tuple(round(1000 * float(v), 3) for v in e.origin),  # type: ignore[arg-type]
            volume_litres=round(1000 * e.volume, 3),
            obstacles=e.obstacles,
            lost_litres=round(1000 * e.lost, 3),
            rays=[_ray(e, ray) for ray in range(len(e.direction))],
        )
        for e in result.envelopes
    ]


def _ray(e: Envelope, ray: int) -> tuple[float, float, float | None, float | None, float]:
    x, y, z = e.direction[ray]
    azimuth = round(math.degrees(math.atan2(y, x))) + 0.0
    elevation = round(math.degrees(math.asin(max(-1.0, min(1.0, float(z)))))) + 0.0
    if not e.any_reached[ray]:
        return azimuth, elevation, None, None, 0.0
    return (azimuth, elevation, round(1000 * float(e.outer[ray]), 1), round(1000 * float(e.inner[ray]), 1),
            round(float(e.blocked[ray]), 3))  # fmt: skip


def reach_tables(result: ResultFile) -> dict[str, str]:
    """reaches.csv and envelopes.csv, where there is something in them."""
    tables = {}
    if result.reaches:
        tables["reaches.csv"] = csv_text(
            ["person", "control", "zone", "own_zone", "limb", "reached", "miss_mm", "overlap_mm", "limit", "sentence"],
            ([r.person, r.control, r.zone, r.own_zone, r.limb, "yes" if r.reached else "no", r.miss_mm, r.overlap_mm,
              r.limit, r.sentence] for r in result.reaches),
        )  # fmt: skip
    if result.envelopes:
        tables["envelopes.csv"] = csv_text(
            ["person", "limb", "zone", "azimuth_deg", "elevation_deg", "outer_mm", "inner_mm", "blocked_share"],
            ([e.person, e.limb, e.zone, *ray] for e in result.envelopes for ray in e.rays),
        )
    return tables


def section_svg(envelope: Envelope, *, level: bool) -> str:
    """A section through the seat reference point as SVG: level, forward up the page; or upright, forward to the right.
    The outer boundary is drawn whole, the inner one broken."""
    direction, middle = envelope.direction, SIZE / 2
    along = np.abs(direction[:, 2]) < 1e-9 if level else np.abs(direction[:, 1]) < 1e-9
    rays = np.flatnonzero(along)
    across = direction[rays] @ (np.array([[0, -1.0, 0], [1, 0, 0]]) if level else np.array([[1.0, 0, 0], [0, 0, 1]])).T
    rays = rays[np.argsort(np.arctan2(across[:, 1], across[:, 0]), kind="stable")]
    across = across[np.argsort(np.arctan2(across[:, 1], across[:, 0]), kind="stable")]
    lines = [_line(across, envelope.outer[rays], "outer"), _line(across, envelope.inner[rays], "inner")]
    axes = "".join(
        f'<circle cx="{middle}" cy="{middle}" r="{r * SCALE:.0f}" fill="none" stroke="#d8dde3"/>'
        f'<text x="{middle + 3}" y="{middle - r * SCALE - 3:.0f}" font-size="10" fill="#8a94a0">{r}</text>'
        for r in (500, 1000, 1500)
    )
    words = "level section, forward is up" if level else "upright section, forward is right"
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {SIZE} {SIZE}" width="{SIZE}" role="img" '
        f'aria-label="{words}">{axes}{"".join(lines)}'
        f'<circle cx="{middle}" cy="{middle}" r="3" fill="#343c48"/></svg>'
    )


def _line(across: Floats, radius: Floats, kind: str) -> str:
    points = SIZE / 2 + across * [1, -1] * radius[:, None] * 1000 * SCALE
    text = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    style = 'fill="#cfe0f2" stroke="#143a7a"' if kind == "outer" else 'fill="#ffffff" stroke="#7a3a14"'
    dash = ' stroke-dasharray="5 3"' if kind == "inner" else ""
    return f'<polygon points="{text}" {style} stroke-width="1.5"{dash}/>'
