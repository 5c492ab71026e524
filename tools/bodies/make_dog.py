"""Writes dog.yaml from dog_outlines.yaml: cross sections become one smooth surface, the surface
spheres.

Run `python tools/bodies/make_dog.py` from anywhere; the same outlines give the same file. The sections of
each part carry ellipsoids along its middle line; parts flow into each other over `blend` (smooth
minimum of distances); the surface of the field is cut by the nearest bone and each segment fitted.
Limbs are fitted on the left and mirrored.
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import gaussian_filter

import workbench as wb
from workbench.body.fitting.segmenting import Bones, SegmentedFit, fit_segments, regions_of
from workbench.body.outlines import level_surface
from workbench.body.surface import Surface, sealed
from workbench.files.postures import load_postures, posture_pose

__all__ = ["body_text", "dog_surface", "main"]

Row = dict[str, Any]
Array = NDArray[np.float64]

HERE = Path(__file__).resolve().parent
BODIES = HERE.parents[1] / "bodies"
MASS = 24.0
PITCH = 0.0045
FAR = 0.05
LOW = np.array([-0.56, -0.16, -0.03])
HIGH = np.array([0.58, 0.16, 0.83])
FIT = {"outward": 0.003, "inward": 0.0025, "least_radius": 0.003, "greatest_radius": 0.2}
MIRROR = np.array([1.0, -1.0, 1.0])
OUTWARD = {
    "front": np.array([1.0, 0.0, 0.0]),
    "back": np.array([-1.0, 0.0, 0.0]),
    "left": np.array([0.0, 1.0, 0.0]),
    "right": np.array([0.0, -1.0, 0.0]),
    "top": np.array([0.0, 0.0, 1.0]),
    "bottom": np.array([0.0, 0.0, -1.0]),
}
HEADER = """\
# A dog of medium size, 550 mm at the withers: {spheres} spheres, {segments} segments. Own work; licence: CC0-1.0.
# Made from tools/bodies/dog_outlines.yaml: change that, then run `python tools/bodies/make_dog.py`.
body: dog
description: dog of medium size, 550 mm at the withers
source: outlines drawn by eye to common breed measures
licence: CC0-1.0
length: mm
postures: dog_postures.yaml
"""
FLEXION = ("flexion", "extension")
OUT = ("abduction", "adduction")
INWARD = ("turn_in", "turn_out")
# what turns a limb out, and its toes in, by side
AXES = {"L": {"out": "+x", "in": "-z"}, "R": {"out": "-x", "in": "+z"}, "": {}}
# motions (first, second name), axis of the first; two of swing, one of twist; limits in the order
# of five numbers: both of the first swing, both of the second, twist both ways
MOTIONS = {
    "spine": (
        (FLEXION, "+y"),
        (("bend_left", "bend_right"), "+z"),
        (("roll_right", "roll_left"), "+x"),
    ),
    "tail": (
        (("raise", "lower"), "+y"),
        (("wag_right", "wag_left"), "+z"),
        (("roll_left", "roll_right"), "-x"),
    ),
    "blade": ((("protraction", "retraction"), "-y"), (OUT, "out"), (INWARD, "in")),
    "fore": ((FLEXION, "-y"), (OUT, "out"), (INWARD, "in")),
    "back": ((FLEXION, "+y"), (OUT, "out"), (INWARD, "in")),
}


@dataclass(frozen=True, eq=False)
class Segment:
    """A segment of the dog: mnemonic, name, number, its origin (3,), spheres (n, 3), (n,) [m],
    errors, volume."""

    key: str
    entry: Row
    origin: Array
    centre: Array
    radius: Array
    error: tuple[float, float]
    volume: float


def dog_surface(parts: dict[str, Row]) -> Surface:
    """The closed skin of all parts [m]."""
    axes = [np.arange(a, b, PITCH) for a, b in zip(LOW, HIGH, strict=True)]
    field = np.full([len(a) for a in axes], FAR)
    for part in parts.values():
        own = np.full_like(field, FAR)
        for side in (1.0, -1.0) if part.get("side") == "both" else (1.0,):
            _add_tube(own, axes, 1e-3 * np.array(part["rows"], dtype=float) * [1, side, 1, 1, 1])
        blend = 1e-3 * part.get("blend", 0)
        overlap = np.maximum(blend - np.abs(field - own), 0.0)
        field = np.minimum(field, own) - (overlap**2 / (4 * blend) if blend else 0.0)
    vertices, faces = level_surface(gaussian_filter(field, 0.7), LOW, np.full(3, PITCH))
    return sealed(vertices, faces, what="dog")


def _add_tube(field: Array, axes: list[Array], rows: Array) -> None:
    """Put into the field the distances to ellipsoids along the middle line of a part."""
    step = np.linalg.norm(np.diff(rows[:, :3], axis=0), axis=1)
    way = np.concatenate([[0.0], np.cumsum(step)])
    places = PchipInterpolator(way, rows)(np.linspace(0, way[-1], max(2, int(way[-1] / 0.006) + 1)))
    along = np.gradient(places[:, :3], axis=0)
    for place, tangent in zip(places, along / np.linalg.norm(along, axis=1)[:, None], strict=True):
        across = np.array([0.0, 1.0, 0.0]) - tangent[1] * tangent
        across /= np.linalg.norm(across)
        frame = np.stack([across, np.cross(tangent, across), tangent], axis=1)
        half = np.array([place[3], place[4], min(place[3:])])
        reach = half.max() + 0.9 * FAR
        box = tuple(
            slice(*np.searchsorted(a, [c - reach, c + reach]))
            for a, c in zip(axes, place[:3], strict=True)
        )
        near = [a[s] - c for a, s, c in zip(axes, box, place[:3], strict=True)]
        offset = np.stack(np.meshgrid(*near, indexing="ij"), axis=-1) @ frame
        # distance to an ellipsoid to first order: |p / h| (|p / h| - 1) / |p / h^2|
        first = np.linalg.norm(offset / half, axis=-1)
        second = np.linalg.norm(offset / half**2, axis=-1)
        field[box] = np.minimum(field[box], first * (first - 1) / np.maximum(second, 1e-9))


def both_sides(data: Row) -> tuple[dict[str, Row], dict[str, Row]]:
    """Segments and joints of both sides, L and R before the mnemonics of paired ones; places in
    metres."""
    paired = {key for key, entry in data["segments"].items() if entry.get("side") == "both"}
    joints = {
        key: 1e-3 * np.array(entry["at"], dtype=float) for key, entry in data["joints"].items()
    }
    found: list[dict[str, Row]] = []
    for kind in ("segments", "joints"):
        rows: dict[str, Row] = {}
        for key, entry in data[kind].items():
            sides = ("L", "R") if entry.get("side") == "both" else ("",)
            for turn, side in enumerate(sides):
                mirror = MIRROR if side == "R" else np.ones(3)
                row = entry | {"number": entry["number"] + turn, "side": side}
                row["name"] = {"L": "left ", "R": "right ", "": ""}[side] + entry["name"]
                if kind == "joints":
                    row["at"] = joints[key] * mirror
                    row["between"] = [(side if s in paired else "") + s for s in entry["between"]]
                else:
                    ends = [
                        [
                            joints[p] if isinstance(p, str) else 1e-3 * np.array(p, dtype=float)
                            for p in bone
                        ]
                        for bone in entry["bones"]
                    ]
                    row["bones"] = np.array(ends) * mirror
                rows[side + key] = row
        found.append(rows)
    return found[0], found[1]


def fitted(surface: Surface, segments: dict[str, Row], claims: list[Row]) -> list[Segment]:
    """The segments with their spheres; right limbs are the left ones mirrored. claims: spheres of
    one segment whose centres lie in a box (left, or mirrored) belong to another: the back of an ear
    is near the neck but moves with the head."""
    names = [key for key, entry in segments.items() for _ in entry["bones"]]
    ends = np.concatenate([entry["bones"] for entry in segments.values()])
    bones = Bones(tuple(names), ends[:, 0], ends[:, 1])
    cut = _claimed(fit_segments(surface, bones, **FIT), claims)
    middle = _middles(surface, bones)
    rows = []
    for key, entry in segments.items():
        like = "L" + key[1:] if entry["side"] == "R" else key
        mirror = MIRROR if entry["side"] == "R" else np.ones(3)
        centre, radius = _bridged(*cut.spheres(like))
        part = cut.parts[cut.segments.index(like)]
        origin = np.round(middle[cut.segments.index(like)] * mirror, 3)
        rows.append(
            Segment(
                key,
                entry,
                origin,
                centre * mirror - origin,
                radius,
                (part.outside, part.inside),
                part.volume,
            )
        )
    _tell(cut)
    return rows


def _bridged(centre: Array, radius: Array) -> tuple[Array, Array]:
    """Spheres (n, 3), (n,) of a segment with one more of the least radius between each that touches
    no other and the nearest: what hangs on a neighbour alone falls off where a joint turns."""
    more = []
    for k in range(len(radius)):
        way = centre - centre[k]
        far = np.linalg.norm(way, axis=1)
        gap = far - radius - radius[k]
        gap[k] = np.inf
        near = int(gap.argmin())
        if gap[near] >= 0.0 and len(radius) > 1:
            more.append(centre[k] + (radius[k] + 0.5 * gap[near]) / far[near] * way[near])
    if not more:
        return centre, radius
    least = np.full(len(more), FIT["least_radius"])
    return np.concatenate([centre, more]), np.concatenate([radius, least])


def _claimed(cut: SegmentedFit, claims: list[Row]) -> SegmentedFit:
    member = cut.member.copy()
    names = cut.segments
    for claim in claims:
        low, high = 1e-3 * np.array(claim["box"], dtype=float)
        for side, mirror in (("L", np.ones(3)), ("R", MIRROR)):
            inside = np.all(
                (cut.fit.centre * mirror >= low) & (cut.fit.centre * mirror <= high), axis=1
            )
            gives = names.index(claim["from"])
            takes = names.index(claim["to"] if claim["to"] in names else side + claim["to"])
            moved = inside & member[:, gives] & (np.arange(len(member)) >= cut.fit.joints)
            member[moved, gives] = False
            member[moved, takes] = True
    return replace(cut, member=member)


def _middles(surface: Surface, bones: Bones) -> Array:
    """(N, 3) the middle of each segment's volume, which is its centre of gravity."""
    low = surface.vertices.min(axis=0)
    high = surface.vertices.max(axis=0)
    axes = [np.arange(a, b, 0.006) for a, b in zip(low, high, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    points = points[surface.distance(points) < 0]
    number = regions_of(surface, bones).number(points)
    return np.array(
        [
            points[number == k].mean(axis=0) * [1, len(name) > 2, 1]
            for k, name in enumerate(bones.names)
        ]
    )


def body_text(data: Row, rows: list[Segment], joints: dict[str, Row]) -> str:
    """The YAML text of the body file."""
    spheres = sum(len(row.radius) for row in rows)
    lines = [HEADER.format(spheres=spheres, segments=len(rows)) + "segments:"]
    density = MASS / sum(row.volume for row in rows)
    for row in rows:
        error = {"outside": _up(row.error[0]), "inside": _up(row.error[1])}
        lines += [
            f"  {row.key}:",
            f"    name: {row.entry['name']}",
            f"    number: {row.entry['number']}",
            f"    mass: {density * row.volume:.3f}",
            "    directions: {front: +x, left: +y, top: +z}",
            f"    fit_error: {_flow(error)}",
            "    spheres:",
        ]
        names = _names(data["names"], row)
        at = [joint["at"] - row.origin for joint in joints.values() if row.key in joint["between"]]
        for k, centre in enumerate(row.centre):
            for joint in at:
                if np.linalg.norm(joint - centre) < 1e-4:
                    centre = joint
            lines.append(
                f"      - {_flow([*_mm(centre), *_mm([row.radius[k]]), *names.get(k, ())])}"
            )
    lines.append("joints:")
    origin = {row.key: row.origin for row in rows}
    for key, entry in joints.items():
        lines += _joint(key, entry, origin)
    return "\n".join(lines) + "\n"


def _joint(key: str, entry: Row, origin: dict[str, Array]) -> list[str]:
    limits = [float(v) for v in entry["limits"]]
    spans = [limits[:2], limits[2:4], [limits[4], limits[4]]]
    axes = AXES[entry["side"]]
    rows = [
        {"motion": list(names), "axis": axes.get(axis, axis), "limits": span}
        for (names, axis), span in zip(MOTIONS[entry["swing"]], spans, strict=True)
    ]
    at = {s: _mm(entry["at"] - origin[s]) for s in entry["between"]}
    return [
        f"  {key}:",
        f"    name: {entry['name']}",
        f"    number: {entry['number']}",
        f"    between: [{', '.join(entry['between'])}]",
        f"    at: {_flow(at)}",
        "    stop: cone",
        "    swing:",
        *(f"      - {_flow(row)}" for row in rows[:2]),
        f"    twist: {_flow(rows[2])}",
    ]


def _names(table: dict[str, Row], row: Segment) -> dict[int, tuple[str, str]]:
    """Names and directions of a segment's spheres by row.

    A name goes to the sphere whose outermost point in the direction, c + r u, is nearest to the
    place: where two are about as near, either has its point about as near. A sphere whose surface is
    near may be large, and its outermost point far away.
    """
    side = row.entry["side"]
    mirror = MIRROR if side == "R" else np.ones(3)
    found: dict[int, tuple[str, str]] = {}
    for name, (x, y, z, direction) in table.get(row.key[1:] if side else row.key, {}).items():
        place = 1e-3 * np.array([x, y, z]) * mirror - row.origin
        word = {"L": "left ", "R": "right ", "": ""}[side]
        direction = {"L": "left", "R": "right"}[side] if direction == "out" else direction
        outermost = row.centre + row.radius[:, None] * OUTWARD[direction]
        gap = np.linalg.norm(outermost - place, axis=1)
        gap[list(found)] = np.inf
        found[int(gap.argmin())] = (word + name, direction)
    return found


def folds(file: Path) -> dict[tuple[str, str], int]:
    """Depth [mm] by which segments that share no joint overlap in the dog's own postures: folds of
    its skin."""
    body = wb.load_body(file)
    postures = load_postures(BODIES / "dog_postures.yaml", body)[0]
    found: dict[tuple[str, str], int] = {}
    for name in postures.postures:
        rows = wb.self_contacts(wb.place(body, posture_pose(body, postures, name)))
        of = body.sphere_segment
        for one, other, distance in zip(
            of[rows.sphere], of[rows.other_sphere], rows.distance, strict=True
        ):
            pair = [body.segments[int(one)], body.segments[int(other)]]
            for turned in (pair, [_mirrored(s) for s in pair]):
                first, second = sorted(turned, key=body.segments.index)
                key = (first, second)
                found[key] = max(found.get(key, 0), 5 * int(np.ceil((-1e3 * distance + 1) / 5)))
    return dict(sorted(found.items(), key=lambda item: [body.segments.index(s) for s in item[0]]))


def _mirrored(segment: str) -> str:
    return {"L": "R", "R": "L"}[segment[0]] + segment[1:] if len(segment) == 3 else segment


def _tell(cut: SegmentedFit) -> None:
    q = cut.fit.quality
    print(
        f"{q.spheres} spheres, mean {q.mean * 1e3:.2f} mm, largest {q.largest * 1e3:.1f} mm, IoU {q.iou:.3f}, "
        f"{q.seconds:.0f} s"
    )


def _mm(values: Any) -> list[float]:
    return [round(1e3 * float(v), 2) + 0.0 for v in values]


def _up(value: float) -> float:
    return float(np.ceil(1e4 * value + 1.0) / 10)


def _flow(value: Any) -> str:
    return json.dumps(value).replace('"', "")


def main() -> None:
    """Write dog.yaml into a folder, beside this file where none is given."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else BODIES
    data = yaml.safe_load((HERE / "dog_outlines.yaml").read_text(encoding="utf-8"))
    segments, joints = both_sides(data)
    rows = fitted(dog_surface(data["parts"]), segments, data["claims"])
    file = folder / "dog.yaml"
    text = body_text(data, rows, joints)
    file.write_text(text, encoding="utf-8")
    pairs = [
        f"  - {_flow({'between': pair, 'depth': depth})}" for pair, depth in folds(file).items()
    ]
    file.write_text("\n".join([text.rstrip(), "allowances:", *pairs, ""]), encoding="utf-8")


if __name__ == "__main__":
    main()
