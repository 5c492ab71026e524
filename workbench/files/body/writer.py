"""A changed body as a file: the text of the body it came from, with the numbers of the new one."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from workbench.files.catalogue import is_file, roots
from workbench.files.inputs import note_input
from workbench.files.schema import metres_in
from workbench.files.yaml_text import read_yaml
from workbench.model.body import Body, check_one
from workbench.model.vocabulary import DIRECTIONS

__all__ = ["body_text"]

DIGITS = 3


def body_text(
    body: Body, origin: Path, *, name: str, description: str, folder: Path | None = None
) -> str:
    """Write a body with the segments and joints of a body file as YAML.

    Lengths are in the unit of that file, to 3 decimals; a sphere at a joint is written with the
    joint's own numbers.

    Parameters
    ----------
    body
        The body of one size; its spheres may be others than those of the origin.
    origin
        The body file.
    name, description
        Those of the new body.
    folder
        Where the file will lie, the origin's own folder where None. What the origin names beside
        itself is named from there, unless it is among the bodies that come along.
    """
    check_one(body)
    value = dict(read_yaml(origin).value)
    unit = metres_in[value["length"]]
    head: dict[str, Any] = {"body": name, "description": description}
    head |= {key: value[key] for key in ("source", "licence", "length") if key in value}
    breadth, thickness = body.seated_factors[0].tolist()
    if (breadth, thickness) != (1.0, 1.0):
        head["seated"] = {"breadth": round(breadth, 6), "thickness": round(thickness, 6)}
    head |= _beside(body, value, origin, folder)
    lines = [*(f"{key}: {_flow(item)}" for key, item in head.items()), "segments:"]
    for segment, entry in value["segments"].items():
        lines += _segment(body, segment, entry, unit)
    if value.get("joints"):
        lines.append("joints:")
    for joint, entry in value.get("joints", {}).items():
        lines += _joint(body, joint, entry, unit)
    lines += ["allowances:", *_allowances(body, unit)]
    return "\n".join(lines) + "\n"


def _beside(body: Body, value: dict[str, Any], origin: Path, folder: Path | None) -> dict[str, Any]:
    """The files that the origin names beside itself, and where the body stands in its family."""
    found: dict[str, Any] = {}
    if "postures" in value:
        found["postures"] = _named(str(value["postures"]), origin, folder)
    if body.basis is not None:
        found["basis"] = _named(str(value.get("basis", body.basis.name)), origin, folder)
        found["basis_at"] = [round(float(z), 6) + 0.0 for z in body.basis_at[0]]
    return found


def _joint(body: Body, joint: str, entry: dict[str, Any], unit: float) -> list[str]:
    """A joint of the origin with the coordinates of the body."""
    j = body.joint(joint)
    parent, child = entry["between"]
    at = {
        parent: _numbers(body.joint_in_parent[0, j], unit),
        child: _numbers(body.joint_in_child[0, j], unit),
    }
    items = {key: at if key == "at" else item for key, item in entry.items()}
    return [f"  {_flow(joint)}:", *(f"    {key}: {_flow(item)}" for key, item in items.items())]


def _named(name: str, origin: Path, folder: Path | None) -> str:
    """How a file that the origin names beside itself is named from another folder."""
    beside = origin.parent / name
    note_input(beside)  # the new file names it too
    if (
        folder is None
        or not is_file(beside)
        or any(is_file(root / "bodies" / name) for root in roots()[1:])
    ):
        return name
    return Path(os.path.relpath(beside.resolve(), folder.resolve())).as_posix()


def _segment(body: Body, name: str, entry: dict[str, Any], unit: float) -> list[str]:
    """A segment of the origin with the mass, fit error, blends and spheres of the body."""
    n = body.segment(name)
    replaced = ("spheres", "blend", "fit_error")
    given = {key: item for key, item in entry.items() if key not in replaced}
    given["mass"] = round(float(body.mass[0, n]), 4)
    if not np.isnan(body.fit_error[0, n]).any():
        outside, inside = (round(float(v) / unit, DIGITS) for v in body.fit_error[0, n])
        given["fit_error"] = {"outside": outside, "inside": inside}
    if blend := _blend(body, n):
        given["blend"] = blend
    rows = range(body.start[n], body.start[n + 1])
    return [
        f"  {_flow(name)}:",
        *(f"    {key}: {_flow(item)}" for key, item in given.items()),
        "    spheres:" if rows else "    spheres: []",
        *(f"      - {_sphere(body, s, unit)}" for s in rows),
    ]


def _sphere(body: Body, sphere: int, unit: float) -> str:
    """[x, y, z, radius, name, direction], the last two where there are any."""
    row: list[Any] = [
        *_numbers(body.centre[0, sphere], unit),
        round(float(body.radius[0, sphere]) / unit, DIGITS),
    ]
    if name := body.sphere_names[sphere]:
        side = int(body.sphere_direction[sphere])
        row += [name, DIRECTIONS[side]] if side >= 0 else [name]
    return _flow(row)


def _blend(body: Body, segment: int) -> dict[str, dict[str, float]]:
    """The blended spheres of a segment by joint and row."""
    rows: dict[str, dict[str, float]] = {}
    for place, s in enumerate(range(body.start[segment], body.start[segment + 1])):
        if body.blend_joint[s] >= 0:
            joint = body.joints[int(body.blend_joint[s])]
            rows.setdefault(joint, {})[str(place)] = round(float(body.blend_share[0, s]), 4)
    return rows


def _allowances(body: Body, unit: float) -> list[str]:
    lines = []
    for a in range(len(body.segments)):
        for b in range(a + 1, len(body.segments)):
            if body.allowance[0, a, b] > 0:
                depth = round(float(body.allowance[0, a, b]) / unit + 0.5 * 10**-DIGITS, DIGITS)
                between = [body.segments[a], body.segments[b]]
                lines.append(f"  - {_flow({'between': between, 'depth': depth})}")
    return lines or ["  []"]


def _numbers(point: Any, unit: float) -> list[float]:
    return [round(float(v) / unit, DIGITS) + 0.0 for v in point]


def _flow(value: Any) -> str:
    """A value in YAML flow style: JSON is YAML 1.2."""
    return json.dumps(value, ensure_ascii=False)
