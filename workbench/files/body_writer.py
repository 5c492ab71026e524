"""A changed body as a file: the text of the body it came from, with the numbers of the new one."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from workbench.files.schema import metres_in
from workbench.files.yaml_text import read_yaml
from workbench.model.body import Body

__all__ = ["body_text"]

DIGITS = 3


def body_text(body: Body, origin: Path, *, name: str, description: str) -> str:
    """YAML text of a body with the segments, joints and sphere order of the body file `origin`.

    Lengths in the unit of that file, to 3 decimals; a sphere at a joint is written with the joint's own numbers.
    """
    value = dict(read_yaml(origin).value)
    unit = metres_in[value["length"]]
    lines = [f"body: {_flow(name)}", f"description: {_flow(description)}"]
    lines += [f"{key}: {_flow(value[key])}" for key in ("source", "licence", "length") if key in value]
    if "postures" in value:
        lines.append(f"postures: {_flow(value['postures'])}")
    lines.append("segments:")
    for segment, entry in value["segments"].items():
        lines += _segment(body, (segment, dict(entry)), unit)
    if value.get("joints"):
        lines.append("joints:")
    for joint, entry in value.get("joints", {}).items():
        j = body.joint(joint)
        parent, child = entry["between"]
        at = {parent: _numbers(body.joint_in_parent[j], unit), child: _numbers(body.joint_in_child[j], unit)}
        lines.append(f"  {_flow(joint)}:")
        lines += [f"    {key}: {_flow(at if key == 'at' else item)}" for key, item in entry.items()]
    lines += ["allowances:", *_allowances(body, unit)]
    return "\n".join(lines) + "\n"


def _segment(body: Body, entry: tuple[str, dict[str, Any]], unit: float) -> list[str]:
    name, given = entry
    n = body.segment(name)
    rows = given.pop("spheres", [])
    given["mass"] = round(float(body.mass[n]), 4)
    lines = [f"  {_flow(name)}:", *(f"    {key}: {_flow(item)}" for key, item in given.items()), "    spheres:"]
    if not rows:
        return [*lines[:-1], "    spheres: []"]
    for place, row in zip(range(body.start[n], body.start[n + 1]), rows, strict=True):
        numbers = [*_numbers(body.centre[place], unit), round(float(body.radius[place]) / unit, DIGITS)]
        lines.append(f"      - {_flow([*numbers, *row[4:]])}")
    return lines


def _allowances(body: Body, unit: float) -> list[str]:
    lines = []
    for a in range(len(body.segments)):
        for b in range(a + 1, len(body.segments)):
            if body.allowance[a, b] > 0:
                depth = round(float(body.allowance[a, b]) / unit + 0.5 * 10**-DIGITS, DIGITS)
                between = [body.segments[a], body.segments[b]]
                lines.append(f"  - {_flow({'between': between, 'depth': depth})}")
    return lines or ["  []"]


def _numbers(point: Any, unit: float) -> list[float]:
    return [round(float(v) / unit, DIGITS) + 0.0 for v in point]


def _flow(value: Any) -> str:
    """A value in YAML flow style: JSON is YAML 1.2."""
    return json.dumps(value, ensure_ascii=False)
