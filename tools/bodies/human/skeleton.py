"""Joint centres from the mesh, the share of each segment in each vertex, and the zero pose.

Joint centres: places of the mesh's own joint markers, moved to where anatomy has them. The markers
of an artist's rig have the hips 220 mm apart on a man of 1755 mm; 176 mm is measured (AnyBody's
AMMR after ANSUR), the shoulder joint lies about 40 mm under the acromion, the clavicle's joint
beside the breastbone. All are smooth functions of the shape.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from human.source import Source

__all__ = ["BETWEEN", "JOINTS", "OTHER_JOINT", "OTHER_SEGMENT", "SEGMENTS", "Skeleton", "posed"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
SEGMENTS = (
    "STG",
    "LT",
    "CT",
    "UT",
    "N",
    "H",
    "LSM",
    "RSM",
    "LUA",
    "RUA",
    "LLA",
    "RLA",
    "LHN",
    "RHN",
    "LUL",
    "RUL",
    "LLL",
    "RLL",
    "LF",
    "RF",
)
BETWEEN = {
    "PV": "STG LT",
    "W": "LT CT",
    "SP": "CT UT",
    "NP": "UT N",
    "HP": "N H",
    "LC": "UT LSM",
    "RC": "UT RSM",
    "LS": "LSM LUA",
    "RS": "RSM RUA",
    "LE": "LUA LLA",
    "RE": "RUA RLA",
    "LW": "LLA LHN",
    "RW": "RLA RHN",
    "LH": "LT LUL",
    "RH": "LT RUL",
    "LK": "LUL LLL",
    "RK": "RUL RLL",
    "LA": "LLL LF",
    "RA": "RLL RF",
}
JOINTS = tuple(BETWEEN)
FLIP = np.array([1.0, -1.0, 1.0])
ALONG_INDEX = np.array([0.75, 0.7, 1.3])
SIDE_BY_SIDE = np.array([0.6, 1.0, 1.0])
"""Shares of a finger's forward, sideways and downward way that are kept: of the thumb, and of the
others."""


def _twin(name: str, names: tuple[str, ...]) -> int:
    other = {"L": "R", "R": "L"}.get(name[0], name[0]) + name[1:]
    return names.index(other if other in names and name != "LT" else name)


OTHER_SEGMENT = np.array([_twin(name, SEGMENTS) for name in SEGMENTS])
OTHER_JOINT = np.array([_twin(name, JOINTS) for name in JOINTS])
BONES = {
    "N": ("neck01", "neck02", "neck03"),
    "LUA": ("upperarm01", "upperarm02"),
    "LLA": ("lowerarm01", "lowerarm02"),
    "LHN": ("wrist", "metacarpal", "finger"),
    "LUL": ("upperleg",),
    "LLL": ("lowerleg",),
    "LF": ("foot", "toe"),
}
TRUNK = ("root", "pelvis", "spine", "breast", "clavicle", "shoulder")


@dataclass(frozen=True, eq=False)
class Skeleton:
    """What is the same for all shapes: groups of the joint markers, the segments' shares (V, N) in
    the vertices, and those of thumb and fingers of both hands (V, 5)."""

    markers: dict[str, Ints]
    share: Floats
    notch: Ints
    fingers: Floats

    @classmethod
    def of(cls, source: Source, points: Floats) -> Skeleton:
        """Made once, on a typical adult (V, 3)."""
        markers = {
            name[6:]: rows for name, rows in source.groups.items() if name.startswith("joint-")
        }
        body = source.groups["body"]
        spot = np.array([0, 0.024, points[markers["l-clavicle"]].mean(axis=0)[2]])
        gap = np.linalg.norm((points[body] - spot)[:, 1:], axis=1) - 0.2 * points[body, 0]
        bare = cls(
            markers,
            np.zeros((len(points), len(SEGMENTS))),
            body[np.argsort(gap)[:6]],
            np.zeros((len(points), 5)),
        )
        joint = bare.joints(points)
        return cls(
            markers, _shares(source, points, joint), bare.notch, _fingers(source, len(points))
        )

    def at(self, points: Floats, name: str) -> Floats:
        """A joint marker (3,)."""
        place: Floats = points[self.markers[name]].mean(axis=0)
        return place

    def joints(self, points: Floats) -> Floats:
        """(J, 3) joint centres of a shape in the pose it has."""
        at = {name: self.at(points, name) for name in self.markers if not name.startswith("r-")}
        thigh = at["l-knee"] - at["l-upper-leg"]
        shank = at["l-ankle"] - at["l-knee"]
        long = float(np.linalg.norm(thigh))
        arm = at["l-elbow"] - at["l-shoulder"]
        place = {
            "LH": at["l-upper-leg"] * [1, 0.8, 1] + [0.045 * long, 0, -0.055 * long],
            "LK": at["l-knee"] + 0.02 * shank + [-0.005 * long, 0, 0],
            "LA": at["l-ankle"],
            "LS": at["l-shoulder"] * [1, 0.92, 1],
            "LE": at["l-elbow"],
            "LW": at["l-hand"],
            "W": 0.6 * at["spine-4"] + 0.4 * at["spine-3"],
            "SP": 0.28 * at["spine-2"] + 0.72 * at["spine-1"],
            "NP": at["neck"] + np.linalg.norm(arm) * np.array([-0.085, 0, 0.025]),
            "HP": at["head"] + np.linalg.norm(arm) * np.array([-0.055, 0, 0.0]),
            "LC": points[self.notch].mean(axis=0) * [1, 0, 1]
            + [-0.075 * np.linalg.norm(arm), at["l-clavicle"][1], 0],
        }
        place["PV"] = place["LH"] * [1, 0, 1]
        for name in ("W", "SP", "NP", "HP"):
            place[name] = place[name] * [1, 0, 1]
        place |= {"R" + name[1:]: spot * FLIP for name, spot in place.items() if name[0] == "L"}
        return np.array([place[name] for name in JOINTS])


def _fingers(source: Source, count: int) -> Floats:
    """(V, 5) the shares of thumb to little finger."""
    share = np.zeros((count, 5))
    for bone, (rows, weight) in source.weights().items():
        if bone.startswith("finger") and bone[6] in "12345":
            share[rows, int(bone[6]) - 1] += weight
    return 0.5 * (share + share[source.mirror])


def _ramp(x: Floats, low: float, high: float) -> Floats:
    t = np.clip((x - low) / (high - low), 0, 1)
    smooth: Floats = t * t * (3 - 2 * t)
    return smooth


def _shares(source: Source, points: Floats, joint: Floats) -> Floats:
    """(V, N) the skin weights of the rig summed by segment; the trunk is divided anew by smooth
    ramps.

    The rig gives neither the shoulder masses nor the lower torso borders of their own; they follow
    from the joints.
    """
    share = np.zeros((len(points), len(SEGMENTS)))
    trunk = np.zeros(len(points))
    head = np.zeros(len(points))
    for bone, (rows, weight) in source.weights().items():
        found = [name for name, stems in BONES.items() if bone.startswith(stems)]
        if bone.startswith(TRUNK):
            trunk[rows] += weight
        elif not found:
            head[rows] += weight
        else:
            name = "R" + found[0][1:] if bone.endswith(".R") else found[0]
            share[rows, SEGMENTS.index(name)] += weight
    at = dict(zip(JOINTS, joint, strict=True))
    _, y, z = points.T
    size = float(np.linalg.norm(at["LE"] - at["LS"])) / 0.27
    low = _ramp(z, at["W"][2] - 0.05 * size, at["W"][2] + 0.05 * size)
    high = _ramp(z, at["SP"][2] - 0.06 * size, at["SP"][2] + 0.06 * size)
    # shoulder mass: outward of the neck's side, above the arm pit
    mass = _ramp(np.abs(y), 0.07 * size, 0.145 * size) * _ramp(
        z, at["LS"][2] - 0.12 * size, at["LS"][2] - 0.02 * size
    )
    column = {name: SEGMENTS.index(name) for name in SEGMENTS}
    share[:, column["H"]] = head
    share[:, column["LT"]] = trunk * (1 - low)
    share[:, column["CT"]] = trunk * low * (1 - high)
    upper = trunk * high
    for name, side in (("LSM", y > 0), ("RSM", y < 0)):
        share[:, column[name]] = upper * mass * side
    share[:, column["UT"]] = upper * (1 - mass)
    # borders where the masses of segments are told: the thigh up to the groin, the head down to its
    # pivot
    for name, low, power in (("LUL", "LT", 1.5), ("RUL", "LT", 1.5), ("H", "N", 1.5)):
        both = share[:, column[name]] + share[:, column[low]]
        part = np.where(both > 0, share[:, column[name]] / np.where(both > 0, both, 1), 0)
        share[:, column[name]] = both * (1 - (1 - part) ** power)
        share[:, column[low]] = both * (1 - part) ** power
    total = share.sum(axis=1, keepdims=True)
    share = np.where(total > 0, share / np.where(total > 0, total, 1), 0)
    mirrored = share[source.mirror][:, OTHER_SEGMENT]
    return 0.5 * (share + mirrored)


# ----------------------------------------------------------------------------------------------------------
# posing


def _frame(along: Floats, side: Floats) -> Floats:
    """Rotation matrix whose columns are `along`, the part of `side` across it, and their cross
    product."""
    a = along / np.linalg.norm(along)
    b = side - (side @ a) * a
    b = b / np.linalg.norm(b)
    return np.column_stack([a, b, np.cross(a, b)])


def _turn(first: Floats, second: Floats) -> Floats:
    """The smallest rotation that takes one direction to another, (3, 3)."""
    a = first / np.linalg.norm(first)
    b = second / np.linalg.norm(second)
    v = np.cross(a, b)
    c = float(a @ b)
    k = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.eye(3) + k + k @ k / (1 + c)


def posed(
    skeleton: Skeleton, points: Floats, *, arm: float, leg: float = 0.0
) -> tuple[Floats, Floats]:
    """Vertices (V, 3) and joints (J, 3) of a shape with straight limbs: the zero pose, or one with
    the limbs apart.

    arm, leg [rad]: how far upper arms and legs slant outward from hanging. Forearm and hand hang
    straight down with the palm inward, feet stay flat; dual quaternions blend the segments' turns,
    upper arm and forearm share their twist along their length. Feet on z = 0.
    """
    rest = skeleton.joints(points)
    at = dict(zip(JOINTS, rest, strict=True))
    turns, place = _left_turns(skeleton, points, at, (arm, leg))
    left = [name for name in SEGMENTS if name[0] == "L" and name != "LT"]
    moves = {name: (np.eye(3), np.zeros(3), np.zeros(3)) for name in SEGMENTS}
    share = {name: skeleton.share[:, SEGMENTS.index(name)].copy() for name in SEGMENTS}
    for name in left:
        joint = next(j for j, pair in BETWEEN.items() if pair.split()[1] == name)
        moves[name] = (turns[name], at[joint], place[joint])
    for name, near, far in (("LUA", "LS", "LE"), ("LLA", "LE", "LW")):
        span = at[far] - at[near]
        t = np.clip((points * [1, 1, 1] - at[near]) @ span / (span @ span), 0, 1)
        mirror = np.clip((points * FLIP - at[near]) @ span / (span @ span), 0, 1)
        moves[name + "'"] = (turns[name + "'"], at[near], place[near])
        for side, s in (("L", t), ("R", mirror)):
            whole = share[side + name[1:]]
            share[side + name[1:] + "'"] = whole * s
            share[side + name[1:]] = whole * (1 - s)
    hand = moves["LHN"]
    for k in range(5):
        moves[f"LHN{k}"] = _closed(skeleton, points, k, hand)
        for side, half in (("L", points[:, 1] > 0), ("R", points[:, 1] < 0)):
            share[f"{side}HN{k}"] = np.minimum(skeleton.fingers[:, k] * half, share[f"{side}HN"])
            share[f"{side}HN"] = share[f"{side}HN"] - share[f"{side}HN{k}"]
    for name in [n for n in moves if n[0] == "L" and n != "LT"]:
        turn, old, new = moves[name]
        moves["R" + name[1:]] = (turn * np.outer(FLIP, FLIP), old * FLIP, new * FLIP)
    names = list(share)
    moved = _blended(points, np.column_stack([share[n] for n in names]), [moves[n] for n in names])
    joint = np.array(
        [
            place.get(n, at[n]) if n[0] != "R" else place.get("L" + n[1:], at[n]) * FLIP
            for n in JOINTS
        ]
    )
    floor = moved[:13380, 2].min()
    return moved - [0, 0, floor], joint - [0, 0, floor]


def _closed(
    skeleton: Skeleton, points: Floats, finger: int, hand: tuple[Floats, Floats, Floats]
) -> tuple[Floats, Floats, Floats]:
    """The move of a finger that lays it beside the others: most of its slant across the palm is
    taken out. The thumb comes to lie along the index finger, as for the measure of thumb-tip
    reach."""
    knuckle, tip = (skeleton.at(points, f"l-finger-{finger + 1}-{k}") for k in (1, 4))
    turn, old, new = hand
    way = turn @ (tip - knuckle)
    straight = _turn(way, way * (ALONG_INDEX if finger == 0 else SIDE_BY_SIDE))
    return straight @ turn, knuckle, new + turn @ (knuckle - old)


def _left_turns(
    skeleton: Skeleton, points: Floats, at: dict[str, Floats], slants: tuple[float, float]
) -> tuple[dict[str, Floats], dict[str, Floats]]:
    """Rotations of the left segments (those with ' at the far end) and the places of their
    joints."""
    arm, leg = slants
    down = np.array([0.0, 0.0, -1.0])
    out = np.array([0.0, np.sin(arm), -np.cos(arm)])
    aside = np.array([0.0, np.sin(leg), -np.cos(leg)])
    upper = at["LE"] - at["LS"]
    fore = at["LW"] - at["LE"]
    hinge = np.cross(upper, fore)
    knuckles = [skeleton.at(points, f"l-finger-{k}-1") for k in (2, 3, 4, 5)]
    hand = (
        knuckles[1] * 0.5
        + knuckles[2] * 0.25
        + skeleton.at(points, "l-finger-3-3") * 0.25
        - at["LW"]
    )
    across = (
        knuckles[0] - knuckles[3]
    )  # from the little finger to the index: forward in the zero pose
    turns = {"LSM": np.eye(3), "LF": np.eye(3)}
    turns["LUA'"] = (
        _frame(out, np.array([0.0, -np.cos(arm), -np.sin(arm)])) @ _frame(upper, hinge).T
    )
    turns["LUA"] = _turn(upper, out)
    turns["LLA"] = _frame(down, np.array([0.0, -1.0, 0.0])) @ _frame(fore, hinge).T
    turns["LHN"] = _frame(down, np.array([1.0, 0.0, 0.0])) @ _frame(hand, across).T
    turns["LLA'"] = _turn(turns["LHN"] @ fore, down) @ turns["LHN"]
    turns["LUL"], turns["LLL"] = (
        _turn(at["LK"] - at["LH"], aside),
        _turn(at["LA"] - at["LK"], aside),
    )
    place = {"LC": at["LC"], "LS": at["LS"], "LH": at["LH"]}
    place["LE"] = at["LS"] + np.linalg.norm(upper) * out
    place["LW"] = place["LE"] + np.linalg.norm(fore) * down
    place["LK"] = at["LH"] + np.linalg.norm(at["LK"] - at["LH"]) * aside
    place["LA"] = place["LK"] + np.linalg.norm(at["LA"] - at["LK"]) * aside
    return turns, place


def _quaternion(turn: Floats) -> Floats:
    """Unit quaternion (w, x, y, z) of a rotation matrix, by the largest component."""
    t = np.array([1 + turn[0, 0] + turn[1, 1] + turn[2, 2], 1 + turn[0, 0] - turn[1, 1] - turn[2, 2],
                  1 - turn[0, 0] + turn[1, 1] - turn[2, 2], 1 - turn[0, 0] - turn[1, 1] + turn[2, 2]])  # fmt: skip
    k = int(np.argmax(t))
    a = [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]
    b = {
        (1, 2): turn[0, 1] + turn[1, 0],
        (1, 3): turn[0, 2] + turn[2, 0],
        (2, 3): turn[1, 2] + turn[2, 1],
    }
    q = (
        np.array([t[0], *a])
        if k == 0
        else np.array([a[k - 1], *(t[k] if i == k else b[min(i, k), max(i, k)] for i in (1, 2, 3))])
    )
    return q / np.linalg.norm(q)


def _product(p: Floats, q: Floats) -> Floats:
    w = p[..., :1] * q[..., :1] - np.sum(p[..., 1:] * q[..., 1:], axis=-1, keepdims=True)
    v = p[..., :1] * q[..., 1:] + q[..., :1] * p[..., 1:] + np.cross(p[..., 1:], q[..., 1:])
    return np.concatenate([w, v], axis=-1)


def _blended(points: Floats, share: Floats, moves: list[tuple[Floats, Floats, Floats]]) -> Floats:
    """Points moved by the blend of rigid moves (turn, old place, new place) as dual quaternions
    (Kavan et al. 2007)."""
    real = np.array([_quaternion(turn) for turn, _, _ in moves])
    shift = np.array([new - turn @ old for turn, old, new in moves])
    dual = 0.5 * _product(np.column_stack([np.zeros(len(shift)), shift]), real)
    lead = real[share.argmax(axis=1)]
    signed = share * np.where(lead @ real.T < 0, -1.0, 1.0)
    a = signed @ real
    b = signed @ dual
    size = np.linalg.norm(a, axis=1, keepdims=True)
    size[size < 1e-9] = 1
    a = a / size
    b = b / size
    turned = points + 2 * np.cross(a[:, 1:], np.cross(a[:, 1:], points) + a[:, :1] * points)
    back = a * [1, -1, -1, -1]
    moved: Floats = turned + 2 * _product(b, back)[:, 1:]
    return moved
