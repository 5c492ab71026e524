"""What a body is, as data and as text."""

from __future__ import annotations

import math
from typing import Any

from workbench.files.body.bodies import load_body
from workbench.files.catalogue import find, names
from workbench.files.kinds import named_kind
from workbench.files.postures import load_postures, posture_path
from workbench.model.body import Body
from workbench.model.stops import StopKind
from workbench.model.units import plain

__all__ = ["body_list", "body_sheet", "body_text"]


def body_list() -> list[dict[str, Any]]:
    """One row for each body of the catalogue."""
    bodies = [
        load_body(name) for name in names("bodies") if named_kind(find("bodies", name)) == "body"
    ]
    return [_head(body) for body in bodies]


def _head(body: Body) -> dict[str, Any]:
    return {
        "name": body.name,
        "description": body.description,
        "segments": len(body.segments),
        "spheres": len(body.sphere_names),
        "mass_kg": round(float(body.mass[0].sum()), 3),
    }


def body_sheet(source: str) -> dict[str, Any]:
    """Segments with masses and subparts, joints with their limits in degrees, postures of a
    body."""
    body = load_body(source)
    path = posture_path(source)
    postures = {} if path is None else load_postures(path, body)[0].postures
    return _head(body) | {
        "segment_table": [_segment(body, n) for n in range(len(body.segments))],
        "joint_table": [_joint(body, j) for j in range(len(body.joints))],
        "postures": {name: posture.description for name, posture in postures.items()},
    }


def _segment(body: Body, n: int) -> dict[str, Any]:
    rows = body.spheres(n)
    return {
        "number": body.segment_numbers[n],
        "segment": body.segments[n],
        "name": body.segment_names[n],
        "mass_kg": round(float(body.mass[0, n]), 3),
        "spheres": rows.stop - rows.start,
        "subparts": [name for name in body.sphere_names[rows] if name],
    }


def _joint(body: Body, j: int) -> dict[str, Any]:
    limits: dict[str, float] = {}
    if body.stops.kind[j] != StopKind.FREE:
        for pair, row in zip(body.stops.motions[j], body.stops.limits[j].tolist(), strict=True):
            limits |= {
                name: round(math.degrees(limit), 3) for name, limit in zip(pair, row, strict=True)
            }
    return {
        "number": body.joint_numbers[j],
        "joint": body.joints[j],
        "name": body.joint_names[j],
        "between": [body.segments[body.parent[j + 1]], body.segments[j + 1]],
        "stop": StopKind(int(body.stops.kind[j])).name.lower(),
        "limits_deg": limits,
    }


def body_text(sheet: dict[str, Any]) -> str:
    """A body sheet for reading."""
    size = f"{sheet['segments']} segments, {sheet['spheres']} spheres, {sheet['mass_kg']} kg"
    return "\n".join(
        [
            f"{sheet['name']}: {sheet['description']}",
            size,
            "",
            "segments",
            *(_segment_line(segment) for segment in sheet["segment_table"]),
            "",
            "joints",
            *(_joint_line(joint) for joint in sheet["joint_table"]),
            "",
            "postures",
            *(f"  {name}: {words}" for name, words in sheet["postures"].items()),
        ]
    )


def _segment_line(s: dict[str, Any]) -> str:
    subparts = ": " + ", ".join(s["subparts"]) if s["subparts"] else ""
    return (
        f"  {s['number']:>3} {s['segment']:<4} {s['name']} ({s['mass_kg']} kg, "
        f"{s['spheres']} spheres){subparts}"
    )


def _joint_line(j: dict[str, Any]) -> str:
    limits = ", ".join(f"{plain(name)} {limit:g}" for name, limit in j["limits_deg"].items())
    return (
        f"  {j['number']:>3} {j['joint']:<4} {j['name']}, {'-'.join(j['between'])}, {j['stop']}: "
        f"{limits or 'no stop'}"
    )
