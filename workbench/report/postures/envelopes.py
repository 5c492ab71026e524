"""Reach envelopes of a result: rows for result.json, tables, solids for other programs."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from markupsafe import Markup

from workbench.draw.envelopes import envelope_image, envelope_sections, turnable_envelope
from workbench.draw.lines.svg import compacted
from workbench.draw.scene import Scene, SceneBody
from workbench.draw.web.snippet import picture_address
from workbench.files.exports.solids import stl_bytes
from workbench.files.output_file import Content
from workbench.files.results.postures import EnvelopeRayRow, EnvelopeRow, PosturesRows
from workbench.model.envelope import Envelope, RayReach
from workbench.model.result import PosturesFound
from workbench.report.tables import Table
from workbench.report.turnable import PageViews

__all__ = ["envelope_pictures", "envelope_rows", "envelope_solids", "envelope_tables"]

_LENGTHS = (
    "outer_mm",
    "inner_mm",
    "clear_outer_mm",
    "clear_inner_mm",
    "easy_outer_mm",
    "easy_inner_mm",
    "moderate_outer_mm",
    "moderate_inner_mm",
)


def envelope_rows(result: PosturesFound) -> list[EnvelopeRow]:
    """The envelopes of a result in millimetres, litres and degrees."""
    return [
        EnvelopeRow(
            person=e.person,
            limb=e.limb,
            zone=e.zone,
            people=e.people,
            origin_mm=tuple(round(1000 * float(v), 3) for v in e.origin),  # type: ignore[arg-type]
            volume_litres=round(1000 * e.volume, 3),
            obstacles=e.obstacles,
            lost_litres=round(1000 * e.lost, 3),
            lost_litres_to={part: round(1000 * litres, 3) for part, litres in e.lost_to.items()},
            rays=[_ray(e, e.about, ray) for ray in range(len(e.about))],
            levels=[_ray(e, e.levels, ray) for ray in range(len(e.levels))],
        )
        for e in result.envelopes
    ]


def _ray(e: Envelope, about: RayReach, ray: int) -> EnvelopeRayRow:
    """One ray: its direction, between which lengths it is reached, and what takes of it."""
    x, y, z = about.direction[ray].tolist()
    reached = bool(about.reached[ray])
    clear = bool(about.clear[ray])
    lost = np.flatnonzero(about.lost.ray == ray)
    return EnvelopeRayRow(
        azimuth_deg=round(math.degrees(math.atan2(y, x))) + 0.0,
        elevation_deg=round(math.degrees(math.asin(max(-1.0, min(1.0, z))))) + 0.0,
        height_mm=round(1000 * float(about.origin[ray, 2] - e.origin[2])) + 0.0,
        outer_mm=_millimetres(about.outer[ray]) if reached else None,
        inner_mm=_millimetres(about.inner[ray]) if reached else None,
        clear_outer_mm=_millimetres(about.clear_outer[ray]) if clear else None,
        clear_inner_mm=_millimetres(about.clear_inner[ray]) if clear else None,
        easy_outer_mm=_millimetres(about.easy_outer[0, ray]),
        easy_inner_mm=_millimetres(about.easy_inner[0, ray]),
        moderate_outer_mm=_millimetres(about.easy_outer[1, ray]),
        moderate_inner_mm=_millimetres(about.easy_inner[1, ray]),
        lost=[_lost(e, about, k) for k in lost.tolist()],
    )


def _lost(e: Envelope, about: RayReach, k: int) -> tuple[float, float, str]:
    """From where to where [mm] a part takes of a ray, and the part, "" for another obstacle."""
    part = about.lost.part[k]
    begin, end = (round(1000 * float(v[k]), 1) for v in (about.lost.begin, about.lost.end))
    return begin, end, e.parts[part] if part >= 0 else ""


def _millimetres(value: float) -> float | None:
    """A length [m] in mm, None where there is none."""
    return round(1000 * float(value), 1) + 0.0 if math.isfinite(value) else None


def envelope_tables(found: Sequence[PosturesRows]) -> dict[str, Table]:
    """By name: envelopes (a row a ray about the point) and envelope_levels (a row a ray of a level
    section), with the size first where several sizes take a role one at a time."""
    lead = ["size"] if any(rows.row for rows in found) else []
    tables = {}
    for name, field, place in (
        ("envelopes", "rays", "elevation_deg"),
        ("envelope_levels", "levels", "height_mm"),
    ):
        lines = [
            [*([rows.row] if rows.row else []), *_line(e, ray, place)]
            for rows in found
            for e in rows.envelopes
            for ray in getattr(e, field)
        ]
        if lines:
            head = ["person", "limb", "zone", place, "azimuth_deg", *_LENGTHS, "lost_mm", "lost_to"]
            tables[name] = Table([*lead, *head], lines)
    return tables


def _line(e: EnvelopeRow, ray: EnvelopeRayRow, place: str) -> list[object]:
    """A ray in a table. place: the field that says where it stands in the envelope."""
    lengths = (getattr(ray, length) for length in _LENGTHS)
    return [
        e.person,
        e.limb,
        e.zone,
        getattr(ray, place),
        ray.azimuth_deg,
        *lengths,
        round(sum(end - begin for begin, end, _ in ray.lost), 1),
        " ".join(dict.fromkeys(part for _, _, part in ray.lost if part)),
    ]


def envelope_solids(found: Sequence[PosturesFound]) -> dict[str, Content]:
    """The envelopes as closed surfaces (STL), obstacles aside and, where these are heeded, clear of
    them."""
    files: dict[str, Content] = {}
    envelopes = [(rows.row, e) for rows in found for e in rows.envelopes]
    for number, (size, e) in enumerate(envelopes, start=1):
        words = f"envelope_{number}_{size}_{e.person}_{e.limb}_zone_{e.zone}"
        name = re.sub(r"[^a-z0-9]+", "_", words.lower()).strip("_")
        files[f"{name}.stl"] = stl_bytes({name: e.surface()})
        if e.obstacles:
            files[f"{name}_clear.stl"] = stl_bytes({f"{name}_clear": e.surface(clear=True)})
    return files


# The pictures of a reach envelope in a report: one that can be turned, with the person in place,
# and its sections.

_PARTS = 5
"""How many obstacles are named."""


def envelope_pictures(
    result: PosturesFound, envelope: Envelope, views: PageViews
) -> dict[str, Any]:
    """The place of the turnable picture, sections as names and SVG, what the obstacles take that
    take most (part and litres), and how many others take how many litres.

    views: the pictures of the page; one is added.
    """
    person = next(person for person in result.people if person.name == envelope.person)
    environment = result.environment
    title = f"Reach envelope of {envelope.person}, {envelope.limb}"
    scene = Scene((SceneBody(person.placed, 0),), environment, (), title)
    caption = f"{title} in the posture of the first case"
    if envelope.obstacles:
        caption += "; blue where the limb comes clear, red where obstacles stop it short"
    shown = turnable_envelope(envelope, person.placed, environment, name=person.name)
    place = views.place(
        views.add(shown),
        still=picture_address(envelope_image(envelope, scene, "corner")),
        alt=f"{title}, corner view",
        caption=caption,
    )
    sections = [
        (name, Markup(compacted(svg)))
        for name, svg in envelope_sections(envelope, environment=environment)
    ]
    named, others, by_others = litres_taken(envelope.lost_to)
    return {
        "place": place,
        "main": sections[:2],
        "rest": sections[2:],
        "taken": named,
        "others": others,
        "by_others": by_others,
    }


def litres_taken(lost_to: Mapping[str, float]) -> tuple[list[tuple[str, int]], int, int]:
    """The parts that take most of an envelope, how many others take of it, and how much they do: whole
    litres that add up to the whole.

    lost_to: by part the volume [m^3] that it takes, "" for what no part is named for, most first.
    """
    parts = [part for part in lost_to if part][:_PARTS]
    taken = np.array([*(lost_to[part] for part in parts), 0.0]) * 1000
    total = 1000 * sum(lost_to.values())
    taken[-1] = total - taken.sum()
    whole = np.floor(taken).astype(np.int64)
    by_remainder = np.argsort(whole - taken, kind="stable")
    whole[by_remainder[: round(total) - whole.sum()]] += 1  # the largest remainders go up
    return list(zip(parts, whole.tolist(), strict=False)), len(lost_to) - len(parts), int(whole[-1])
