"""The files: the basis as a NumPy archive with deterministic bytes, and a body of the family as
YAML.

Joint stops, numbers, names and directions are those of bubbleman.yaml; segments stand in the same
order.
"""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from human.basis import Basis
from human.skeleton import JOINTS, SEGMENTS

__all__ = ["BODY_JOINTS", "BODY_SEGMENTS", "archive", "body_text"]

Floats = NDArray[np.float64]
BODY_SEGMENTS = (
    "STG",
    "LT",
    "CT",
    "UT",
    "N",
    "H",
    "LSM",
    "LUA",
    "LLA",
    "LHN",
    "RSM",
    "RUA",
    "RLA",
    "RHN",
    "LUL",
    "LLL",
    "LF",
    "RUL",
    "RLL",
    "RF",
)
BODY_JOINTS = (
    "PV",
    "W",
    "SP",
    "NP",
    "HP",
    "LC",
    "LS",
    "LE",
    "LW",
    "RC",
    "RS",
    "RE",
    "RW",
    "LH",
    "LK",
    "LA",
    "RH",
    "RK",
    "RA",
)
"""Depth first from the stage, as a Body has them."""


def archive(path: Path, basis: Basis, extra: dict[str, NDArray[Any]]) -> None:
    """Write the basis; `extra` holds density, anchors and fit errors. The same arrays always give
    the same bytes."""
    order = [SEGMENTS.index(name) for name in BODY_SEGMENTS]
    joints = [JOINTS.index(name) for name in BODY_JOINTS]
    arrays: dict[str, NDArray[Any]] = {
        "format": np.int64(1),
        "segments": np.array(BODY_SEGMENTS),
        "joints": np.array(BODY_JOINTS),
        "licence": np.array(["CC0-1.0; made from the MakeHuman base mesh and targets (CC0)"]),
    }
    for key, rows in (("joint", joints), ("origin", order)):
        mean, parts = basis.table[key]
        arrays[f"{key}_mean"], arrays[f"{key}_basis"] = (
            mean[rows],
            parts[:, rows].astype(np.float32),
        )
    for name, level in basis.levels.items():
        place = np.array([order.index(n) for n in level.segment])
        rows = np.argsort(place, kind="stable").tolist()
        arrays[f"{name}_segment"] = place[rows]
        for key in ("centre", "radius"):
            mean, parts = basis.table[f"{name}_{key}"]
            arrays[f"{name}_{key}_mean"], arrays[f"{name}_{key}_basis"] = (
                mean[rows],
                parts[:, rows].astype(np.float32),
            )
        blend = np.array([joints.index(j) if j >= 0 else -1 for j in level.blend_joint])
        arrays[f"{name}_blend_joint"], arrays[f"{name}_blend_share"] = (
            blend[rows],
            level.blend_share[rows].round(3),
        )
        arrays[f"{name}_name"] = np.array([level.name[k] for k in rows])
        arrays[f"{name}_direction"] = np.array([level.direction[k] for k in rows])
    arrays |= extra
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name in sorted(arrays):
            data = io.BytesIO()
            np.lib.format.write_array(
                data,
                np.ascontiguousarray(arrays[name])
                if arrays[name].shape
                else np.asarray(arrays[name]),
                allow_pickle=False,
            )
            entry = zipfile.ZipInfo(f"{name}.npy", date_time=(1980, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            file.writestr(entry, data.getvalue())


def body_text(
    basis: Basis, level_name: str, z: Floats, head: dict[str, Any], tables: dict[str, Any]
) -> str:
    """The body at coefficients z as YAML.

    head: the first keys of the file, and "comment"; tables: mass (N,), fit_error (N, 2) [m],
    allowances (list of segment, segment, depth [m]).
    """
    template = yaml.safe_load(
        (Path(__file__).resolve().parents[3] / "bodies" / "bubbleman.yaml").read_text(
            encoding="utf-8"
        )
    )
    level = basis.levels[level_name]
    origin = basis.at("origin", z)
    joint = basis.at("joint", z)
    centre = basis.at(f"{level_name}_centre", z)
    radius = basis.at(f"{level_name}_radius", z)
    lines = [f"# {line}" for line in head["comment"]]
    lines += [f"{key}: {_flow(value)}" for key, value in head.items() if key != "comment"]
    lines.append("segments:")
    for n, name in enumerate(SEGMENTS):
        given = template["segments"][name]
        lines += [
            f"  {name}:",
            f"    name: {given['name']}",
            f"    number: {given['number']}",
            f"    mass: {tables['mass'][n]:.3f}",
            f"    directions: {_flow(given['directions'])}",
        ]
        if "twist_along" in given:
            lines.append(f"    twist_along: {given['twist_along']}")
        rows = np.flatnonzero(level.segment == n)
        if not len(rows):
            lines.append("    spheres: []")
            continue
        out, into = 1000 * tables["fit_error"][n]
        lines.append(f"    fit_error: {{outside: {out:.1f}, inside: {into:.1f}}}")
        lines += _blend_lines(level, rows)
        lines.append("    spheres:")
        for row in rows:
            place = [_number(1000 * v) for v in centre[row] - origin[n]]
            words = [w for w in (level.name[row], level.direction[row]) if w]
            lines.append(f"      - [{', '.join([*place, _number(1000 * radius[row]), *words])}]")
    lines.append("joints:")
    for j, name in enumerate(JOINTS):
        lines += _joint_lines(name, template["joints"][name], joint[j], origin)
    lines.append("allowances:" if tables["allowances"] else "allowances: []")
    lines += [
        f"  - {{between: [{a}, {b}], depth: {_number(1000 * d)}}}"
        for a, b, d in tables["allowances"]
    ]
    return "\n".join(lines) + "\n"


def _blend_lines(level: Any, rows: NDArray[np.int64]) -> list[str]:
    """Shares of the spheres of one segment, by joint."""
    lines = []
    for j in sorted({int(v) for v in level.blend_joint[rows]} - {-1}):
        parts = [
            f'"{k}": {level.blend_share[row]:.3g}'
            for k, row in enumerate(rows)
            if level.blend_joint[row] == j
        ]
        lines.append(f"      {JOINTS[j]}: {{{', '.join(parts)}}}")
    return ["    blend:", *lines] if lines else []


def _joint_lines(name: str, given: dict[str, Any], place: Floats, origin: Floats) -> list[str]:
    ends = [SEGMENTS.index(segment) for segment in given["between"]]
    at = {SEGMENTS[n]: [float(_number(1000 * v)) for v in place - origin[n]] for n in ends}
    lines = [f"  {name}:"]
    for key, value in given.items():
        if key in ("swing", "couplings"):
            lines += [f"    {key}:", *(f"      - {_flow(row)}" for row in value)]
        elif key == "polygon":
            lines += ["    polygon:", *(f"      {k}: {_flow(v)}" for k, v in value.items())]
        else:
            lines.append(f"    {key}: {_flow(at if key == 'at' else value)}")
    return lines


def _number(value: float) -> str:
    """Millimetres to 0.01; the same place written from two sides differs by no more."""
    text = f"{value:.2f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def _flow(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{k}: {_flow(v)}" for k, v in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_flow(v) for v in value) + "]"
    if isinstance(value, float):
        return f"{value:.6g}"
    return str(value)
