"""A body file for fitted spheres: a skeleton's segments and joints with new spheres, or one segment
alone."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from workbench.files.schema import metres_in
from workbench.files.yaml_text import read_yaml
from workbench.model.arrays import Floats
from workbench.model.body import Body

__all__ = ["FittedSegment", "SkeletonFile", "fitted_text"]

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
    lines = [*(f"{key}: {_flow(item)}" for key, item in head.items()), "segments:"]
    for mnemonic, entry in given["segments"].items():
        lines += _segment(mnemonic, dict(entry), segments[mnemonic], unit)
    if skeleton is not None and given.get("joints"):
        lines.append("joints:")
        for joint, entry in given["joints"].items():
            lines += _joint(skeleton.body, joint, entry, unit)
    if given.get("allowances"):
        lines += ["allowances:", *(f"  - {_flow(row)}" for row in given["allowances"])]
    return "\n".join(lines) + "\n"


def _segment(mnemonic: str, entry: dict[str, Any], fitted: FittedSegment, unit: float) -> list[str]:
    """A segment of the skeleton with the mass, fit error and spheres found for it."""
    items = {key: item for key, item in entry.items() if key not in ("spheres", "blend")}
    items["mass"] = round(fitted.mass, 4)
    items["fit_error"] = {"outside": _up(fitted.outside, unit), "inside": _up(fitted.inside, unit)}
    spheres = [
        [*_numbers([*centre, radius], unit), *fitted.names.get(k, ())]
        for k, (centre, radius) in enumerate(zip(fitted.centre, fitted.radius, strict=True))
    ]
    return [
        f"  {_flow(mnemonic)}:",
        *(f"    {key}: {_flow(item)}" for key, item in items.items()),
        "    spheres:" if spheres else "    spheres: []",
        *(f"      - {_flow(row)}" for row in spheres),
    ]


def _joint(body: Body, joint: str, entry: dict[str, Any], unit: float) -> list[str]:
    """A joint with its coordinates in the digits of the spheres, so that a sphere is exactly at
    it."""
    j = body.joint(joint)
    parent, child = entry["between"]
    at = {
        parent: _numbers(body.joint_in_parent[0, j], unit),
        child: _numbers(body.joint_in_child[0, j], unit),
    }
    return [
        f"  {_flow(joint)}:",
        *(f"    {k}: {_flow(at if k == 'at' else item)}" for k, item in entry.items()),
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


def _flow(value: Any) -> str:
    """A value in YAML flow style: JSON is YAML 1.2."""
    return json.dumps(value, ensure_ascii=False)
