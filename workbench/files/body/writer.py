"""Body files: a changed body with the text of the body it came from, and fitted spheres with the
segments and joints of a skeleton, or one segment alone."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from workbench.files.catalogue import is_file, roots
from workbench.files.file_errors import note_input
from workbench.files.schema import metres_in
from workbench.files.yaml_changes import Key, yaml_text
from workbench.files.yaml_text import read_yaml
from workbench.model.arrays import Floats
from workbench.model.body import DIRECTIONS, Body, check_one

__all__ = ["FittedSegment", "SkeletonFile", "body_text", "fitted_text"]

_ALONE: dict[str, Any] = {
    "name": "body",
    "number": 1,
    "directions": {"front": "+x", "left": "+y", "top": "+z"},
}
_KEPT = ("licence", "postures", "seated")


@dataclass(frozen=True, eq=False)
class FittedSegment:
    """Spheres of a segment in its frame, centre (n, 3), radius (n,) [m], name and direction of some
    by row; mass [kg]; outside, inside [m]: how far the true surface may lie outside and inside the
    spheres."""

    centre: Floats
    radius: Floats
    names: dict[int, tuple[str, ...]]
    mass: float
    outside: float
    inside: float


@dataclass(frozen=True, eq=False)
class SkeletonFile:
    """A body, and its file, whose segments, joints and stops a fitted body keeps."""

    body: Body
    file: Path


def body_text(
    body: Body, origin: Path, *, name: str, description: str, folder: Path | None = None
) -> str:
    """Write a body with the segments and joints of a body file as YAML.

    Lengths are in the unit of that file, to a thousandth of a millimetre; a sphere at a joint is
    written with the joint's own numbers.

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
    head["segments"] = {
        segment: _segment(body, segment, entry, unit)
        for segment, entry in value["segments"].items()
    }
    head |= _joints(body, value, unit)
    head["allowances"] = _allowances(body, unit)
    return yaml_text(head, {}, _in_block)


def fitted_text(
    segments: Mapping[str, FittedSegment],
    *,
    name: str,
    description: str,
    source: str,
    skeleton: SkeletonFile | None = None,
) -> str:
    """Write a fitted body as YAML.

    Lengths are in the skeleton's unit, to a thousandth of a millimetre; errors are rounded up.

    Parameters
    ----------
    segments
        The spheres of each segment.
    name, description, source
        Those of the new body.
    skeleton
        Whose segments and joints are kept; without one there is one segment.
    """
    given: dict[str, Any] = {"length": "mm", "segments": dict.fromkeys(segments, _ALONE)}
    if skeleton is not None:
        given = dict(read_yaml(skeleton.file).value)
    unit = metres_in[given["length"]]
    head: dict[str, Any] = {"body": name, "description": description, "source": source}
    head |= {key: given[key] for key in (*_KEPT, "length") if key in given}
    head["segments"] = {
        mnemonic: _fitted_segment(entry, segments[mnemonic], unit)
        for mnemonic, entry in given["segments"].items()
    }
    if skeleton is not None:
        head |= _joints(skeleton.body, given, unit)
    if given.get("allowances"):
        head["allowances"] = given["allowances"]
    return yaml_text(head, {}, _in_block)


def _in_block(key: Key) -> bool:
    """Whether a mapping or list is written line by line: segments, joints, spheres, allowances."""
    if key[0] == "allowances":
        return len(key) == 1
    return key[0] in ("segments", "joints") and (len(key) < 3 or key[2:] == ("spheres",))


def _fitted_segment(entry: Mapping[str, Any], fitted: FittedSegment, unit: float) -> dict[str, Any]:
    """A segment of the skeleton with the mass, fit error and spheres found for it."""
    found = {key: item for key, item in entry.items() if key not in ("spheres", "blend")}
    found["mass"] = round(fitted.mass, 4)
    found["fit_error"] = {"outside": _up(fitted.outside, unit), "inside": _up(fitted.inside, unit)}
    found["spheres"] = [
        [*_numbers([*centre, radius], unit), *fitted.names.get(k, ())]
        for k, (centre, radius) in enumerate(zip(fitted.centre, fitted.radius, strict=True))
    ]
    return found


def _beside(body: Body, value: dict[str, Any], origin: Path, folder: Path | None) -> dict[str, Any]:
    """The files that the origin names beside itself, and where the body stands in its family."""
    found: dict[str, Any] = {}
    if "postures" in value:
        found["postures"] = _named(str(value["postures"]), origin, folder)
    if body.basis is not None:
        found["basis"] = _named(str(value.get("basis", body.basis.name)), origin, folder)
        found["basis_at"] = [round(float(z), 6) + 0.0 for z in body.basis_at[0]]
    return found


def _joints(body: Body, value: Mapping[str, Any], unit: float) -> dict[str, Any]:
    """The joints of a file, if it has any, with the coordinates of a body, in the digits of the
    spheres, so that a sphere is exactly at a joint."""
    joints = {}
    for joint, entry in (value.get("joints") or {}).items():
        j = body.joint(joint)
        parent, child = entry["between"]
        at = {
            parent: _numbers(body.joint_in_parent[0, j], unit),
            child: _numbers(body.joint_in_child[0, j], unit),
        }
        joints[joint] = {key: at if key == "at" else item for key, item in entry.items()}
    return {"joints": joints} if joints else {}


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


def _segment(body: Body, name: str, entry: Mapping[str, Any], unit: float) -> dict[str, Any]:
    """A segment of the origin with the mass, fit error, blends and spheres of the body."""
    n = body.segment(name)
    replaced = ("spheres", "blend", "fit_error")
    found = {key: item for key, item in entry.items() if key not in replaced}
    found["mass"] = round(float(body.mass[0, n]), 4)
    if not np.isnan(body.fit_error[0, n]).any():
        outside, inside = _numbers(body.fit_error[0, n], unit)
        found["fit_error"] = {"outside": outside, "inside": inside}
    if blend := _blend(body, n):
        found["blend"] = blend
    found["spheres"] = [_sphere(body, s, unit) for s in range(body.start[n], body.start[n + 1])]
    return found


def _sphere(body: Body, sphere: int, unit: float) -> list[Any]:
    """[x, y, z, radius, name, direction], the last two where there are any."""
    row: list[Any] = _numbers([*body.centre[0, sphere], body.radius[0, sphere]], unit)
    if name := body.sphere_names[sphere]:
        side = int(body.sphere_direction[sphere])
        row += [name, DIRECTIONS[side]] if side >= 0 else [name]
    return row


def _blend(body: Body, segment: int) -> dict[str, dict[str, float]]:
    """The blended spheres of a segment by joint and row."""
    rows: dict[str, dict[str, float]] = {}
    for place, s in enumerate(range(body.start[segment], body.start[segment + 1])):
        if body.blend_joint[s] >= 0:
            joint = body.joints[int(body.blend_joint[s])]
            rows.setdefault(joint, {})[str(place)] = round(float(body.blend_share[0, s]), 4)
    return rows


def _allowances(body: Body, unit: float) -> list[dict[str, Any]]:
    """The overlaps that are allowed, rounded up."""
    step = 10.0 ** _digits(unit)
    rows = np.argwhere(np.triu(body.allowance[0], 1) > 0).tolist()
    return [
        {
            "between": [body.segments[a], body.segments[b]],
            "depth": round(float(body.allowance[0, a, b]) / unit + 0.5 / step, _digits(unit)),
        }
        for a, b in rows
    ]


def _digits(unit: float) -> int:
    """Decimals that are a thousandth of a millimetre or finer."""
    return max(0, math.ceil(math.log10(unit / 1e-6) - 1e-9))


def _numbers(values: Any, unit: float) -> list[float]:
    return [round(float(v) / unit, _digits(unit)) + 0.0 for v in values]


def _up(value: float, unit: float) -> float:
    """Rounded up to a hundredth of a millimetre."""
    step = 10.0 ** (_digits(unit) - 1)
    return math.ceil(value / unit * step - 1e-9) / step
