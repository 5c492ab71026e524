"""Find how a recorded skeleton stands: which way is up, which side is left, how each bone is turned
where its segment is in the zero pose.

A file states a rest pose, which is arbitrary. Where it stands (legs down, trunk up), the shortest
rotation takes each segment's axis to its bone's axis at rest; trunk and feet are taken to stand as
the body's do. Where it does not stand (optical capture exports all bones along one axis), only
what the frames show is used: the lines between the joints, and that limbs are not twisted against
what carries them on average over the frames.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Bools, Floats
from workbench.model.body import Body
from workbench.model.motion import Bones
from workbench.model.quaternions import (
    conjugate,
    from_matrices,
    matrices,
    multiply,
    rotate,
    shortest,
)
from workbench.motion.recorded.bone_names import bone_map

__all__ = [
    "AXIS_JOINTS",
    "IDENTITY",
    "Skeleton",
    "body_lengths",
    "bone_attitudes",
    "bone_lengths",
    "bone_positions",
    "find_skeleton",
]

AXIS_JOINTS = {
    "LUA": ("LS", "LE"),
    "RUA": ("RS", "RE"),
    "LLA": ("LE", "LW"),
    "RLA": ("RE", "RW"),
    "LUL": ("LH", "LK"),
    "RUL": ("RH", "RK"),
    "LLL": ("LK", "LA"),
    "RLL": ("RK", "RA"),
    "CT": ("W", "SP"),
    "N": ("NP", "HP"),
}
"""Joints at both ends of a segment, whose line is aligned with the bone."""
_NEXT_SEGMENT = {
    "LUA": "LLA",
    "RUA": "RLA",
    "LLA": "LHN",
    "RLA": "RHN",
    "LUL": "LLL",
    "RUL": "RLL",
    "LLL": "LF",
    "RLL": "RF",
}
"""The segment at whose bone the bone of a limb segment ends."""
IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])
"""(4,) the quaternion of no rotation."""
_UPRIGHT = 0.8
"""Least cosine between the vertical and trunk, thighs and shanks of a rest pose that stands: legs may
be 37 degrees apart from it."""
_BENT = np.sin(np.radians(15.0))
"""Sine of the flexion beyond which a knee tells front from back; straight ones may be overstretched."""
_CLEAR = 0.8
"""Share of frames in which an axis leads from feet to head before it outweighs the rest pose."""
_SHIFTED = 0.01
"""Distance of a position channel from its OFFSET, as a share of a leg, up to which nothing is said."""


@dataclass(frozen=True, eq=False)
class Skeleton:
    """A recorded skeleton whose bones are known by segment."""

    bones: Bones
    """Mirrored where its left and right are exchanged."""
    bone: Mapping[str, str]
    """Names of bones by segment."""
    world_from_file: Floats
    """(3, 3) axes forward, left and up."""
    bone_from_segment: Mapping[str, Floats]
    """(4,) quaternion by segment: how the segment is turned against its bone, always."""
    notes: tuple[str, ...]
    """What was assumed, and what the frames say of it, in sentences."""

    def index(self, segment: str) -> int:
        """The number of a segment's bone."""
        return self.bones.names.index(self.bone[segment])


def find_skeleton(
    body: Body, bones: Bones, *, names: Mapping[str, str] | None = None, up: str | None = None
) -> Skeleton:
    """Find the bones of a body's segments and how they stand.

    Parameters
    ----------
    body
        A body with the paper's joints.
    bones
        The skeleton and its motion; what is assumed is judged by its `overview`.
    names
        Bones by segment, where the usual names do not apply.
    up
        The file's upward axis ("y", "-z"). If None, the axis along which the rest pose stands, or
        the one along which the frames do, where they say otherwise.

    Raises
    ------
    InputError
        If bones are missing or have no length, or it cannot be told which way is up.
    """
    bone = bone_map(bones, names)
    bones, notes = _with_seen_offsets(bones, bone)
    seen = _Seen.of(bones, bone)
    _require_lengths(seen)
    mirrored, doubts = _is_mirrored(seen)
    notes += doubts
    if mirrored:
        bones = _mirrored(bones, int(np.argmax(np.abs(seen.across()).mean(axis=0))))
        seen = _Seen.of(bones, bone)
    rest = {s: _rest_positions(bones)[bones.names.index(name)] for s, name in bone.items()}
    stands = _rest_axes(rest)
    vertical, said = _upward(seen, None if stands is None else stands[2], up)
    notes += said
    if stands is None:
        ahead = np.roll(vertical, 1)  # y up: z forward; z up: x forward
        world = np.array([ahead, np.cross(vertical, ahead), vertical])
        upright = _upright_by_frames(body, seen, world)
        notes += (
            "its zero pose does not stand: how its bones are turned is taken from its frames "
            f"({_axis_name(ahead)} is forward; trunk, head and ankles are straight, and limbs "
            "untwisted, on average)",
        )
    else:
        turn = matrices(shortest(vertical, stands[2]))
        world = stands @ turn
        upright = _upright_by_rest(body, rest, stands)
    return Skeleton(bones, bone, world, upright, notes)


@dataclass(frozen=True, eq=False)
class _Seen:
    """Frames (F) of a skeleton from its whole motion."""

    bones: Bones
    bone: Mapping[str, str]
    attitude: Floats
    """(F, B, 4) file from bone, as quaternions."""
    position: Floats
    """(F, B, 3) where bones begin, in the file's axes and units."""

    @classmethod
    def of(cls, bones: Bones, bone: Mapping[str, str]) -> _Seen:
        """Place the bones in the frames of the overview."""
        frames = bones.overview or bones
        return cls(bones, bone, bone_attitudes(frames), bone_positions(frames))

    def index(self, segment: str) -> int:
        """The number of a segment's bone."""
        return self.bones.names.index(self.bone[segment])

    def at(self, segment: str) -> Floats:
        """(F, 3) where the bone of a segment begins."""
        return np.asarray(self.position[:, self.index(segment)])

    def middle(self, limb: str) -> Floats:
        """(F, 3) half way between the left and the right bone of a limb."""
        return 0.5 * (self.at("L" + limb) + self.at("R" + limb))

    def across(self) -> Floats:
        """(F, 3) from the right hip to the left one."""
        return self.at("LUL") - self.at("RUL")

    def trunk(self) -> Floats:
        """(F, 3) from the middle of the hips to that of the shoulders."""
        return self.middle("UA") - self.middle("UL")

    def line(self, segment: str) -> Floats | None:
        """(F, 3) from the beginning to the end of a segment's bone, None if its end is unknown."""
        following = {"CT": "UT", "N": "H"} | _NEXT_SEGMENT
        end = following.get(segment, "")
        if segment not in self.bone or (segment in following and end in self.bone):
            return self.at(end) - self.at(segment) if segment in self.bone else None
        bone = self.index(segment)
        children = np.flatnonzero(self.bones.parent == bone)
        if len(children):
            return np.asarray(self.position[:, children[0]] - self.position[:, bone])
        tail = self.bones.ends.get(self.bones.names[bone])
        return None if tail is None else rotate(self.attitude[:, bone], np.array(tail))


def bone_attitudes(bones: Bones) -> Floats:
    """Return file from bone, (P, B, 4), as quaternions."""
    attitude = np.array(bones.rotations)
    for b, parent in enumerate(bones.parent):
        if parent >= 0:
            attitude[:, b] = multiply(attitude[:, parent], attitude[:, b])
    return attitude


def bone_positions(bones: Bones) -> Floats:
    """Return where each bone begins, (P, B, 3), in the file's axes and units."""
    attitude = bone_attitudes(bones)
    position = np.array(bones.shift)
    for b, parent in enumerate(bones.parent):
        if parent >= 0:
            position[:, b] = position[:, parent] + rotate(attitude[:, parent], bones.shift[:, b])
    return position


def bone_lengths(bones: Bones, bone: Mapping[str, str]) -> dict[str, float]:
    """Return the length of each limb segment's bone, and of the "trunk", in the file's units.

    They are medians over the frames of the overview. The trunk is from the middle of the hips to
    that of the shoulders. bone: names of bones by segment, see `bone_map`.
    """
    seen = _Seen.of(bones, bone)
    lines = {segment: seen.line(segment) for segment in _NEXT_SEGMENT if segment in bone}
    lines["trunk"] = seen.trunk()
    return {
        segment: float(np.median(np.linalg.norm(line, axis=-1)))
        for segment, line in lines.items()
        if line is not None
    }


def body_lengths(body: Body) -> dict[str, float]:
    """Return the length [m] between its joints of each limb segment of a body."""
    return {segment: float(np.linalg.norm(_axis(body, segment))) for segment in _NEXT_SEGMENT}


def _axis(body: Body, segment: str) -> Floats:
    """(3,) from the proximal to the distal joint of a segment in the zero pose."""
    proximal, distal = (body.joint(j) for j in AXIS_JOINTS[segment])
    return np.asarray(body.joint_in_parent[0, distal] - body.joint_in_child[0, proximal])


def _rest_positions(bones: Bones) -> Floats:
    """(B, 3) where each bone begins in the rest pose, in the file's axes and units."""
    position = np.array(bones.offset)
    for b, parent in enumerate(bones.parent):
        if parent >= 0:
            position[b] += position[parent]
    return position


def _with_seen_offsets(bones: Bones, bone: Mapping[str, str]) -> tuple[Bones, tuple[str, ...]]:
    """The bones with offsets where their position channels put them, and a note where they differ."""
    shift = (bones.overview or bones).shift
    inner = bones.parent >= 0
    offset = np.where(inner[:, None], np.median(shift, axis=0), bones.offset)
    away = np.where(inner, np.linalg.norm(shift - bones.offset, axis=-1).max(axis=0), 0.0)
    apart = np.where(inner, np.linalg.norm(shift - offset, axis=-1).max(axis=0), 0.0)
    leg = sum(bone_lengths(bones, bone).get(segment, 0.0) for segment in ("LUL", "LLL"))
    worst = int(np.argmax(away))
    if away[worst] <= _SHIFTED * leg:
        return bones, ()
    others = int((away > _SHIFTED * leg).sum()) - 1
    more = f" (and {others} more bones)" if others else ""
    moves = (
        f"; it moves there by up to {apart.max():.4g} units: lengths are medians over the frames"
        if apart.max() > _SHIFTED * leg
        else ""
    )
    note = (
        f"position channels put {bones.names[worst]} {away[worst]:.4g} units from its OFFSET{more}: "
        f"they are used, the OFFSET is not{moves}"
    )
    return replace(bones, offset=offset), (note,)


def _require_lengths(seen: _Seen) -> None:
    """Refuse limbs whose bones have no length: their direction is unknown."""
    lengths = bone_lengths(seen.bones, seen.bone)
    none = [s for s, length in lengths.items() if not length > 1e-6 * max(lengths.values())]
    across = np.linalg.norm(seen.across(), axis=-1).max()
    if not none and across > 1e-6 * lengths["trunk"]:
        return
    named = ", ".join(seen.bone.get(segment, segment) for segment in none) or "the hips"
    raise InputError(
        f"{seen.bones.file}: the bones of {named} have no length (OFFSET 0 0 0), so it is unknown "
        "where they point: export the skeleton with its offsets, or name other bones for these "
        "segments (map in a study, --names FILE)"
    )


def _is_mirrored(seen: _Seen) -> tuple[bool, tuple[str, ...]]:
    """Whether left and right are exchanged, by the knees and the toes; and a doubt in a sentence.

    A flexing knee turns its shank about an axis that points to the left, and toes point forward:
    left x up. Shoulders have their left where hips have it.
    """
    left = _unit(seen.across())
    shoulders = _unit(seen.at("LUA") - seen.at("RUA"))
    if (shoulders * left).sum(axis=-1).mean() < -_BENT:
        return False, (
            "its arms have their left where its legs have their right: are the bones of both named "
            "rightly (map in a study, --names FILE)?",
        )
    knees = []
    toes = []
    for side in "LR":
        thigh, shank, toe = (seen.line(side + limb) for limb in ("UL", "LL", "F"))
        if shank is not None and thigh is not None:
            hinge = np.cross(_unit(thigh), _unit(shank))
            bent = np.linalg.norm(hinge, axis=-1) > _BENT
            knees += (_unit(hinge[bent]) * left[bent]).sum(axis=-1).tolist()
        if toe is not None:
            ahead = np.cross(left, _unit(seen.trunk()))
            toes += (_unit(toe) * ahead).sum(axis=-1).tolist()
    signs = [float(np.mean(found)) for found in (knees, toes) if found]
    signs = [sign for sign in signs if abs(sign) > 0.3]
    if not signs:
        return False, ("neither bent knees nor toes tell left from right: as its bones are named",)
    if max(signs) < 0:
        return True, (
            "knees and toes point backward as its bones are named: its axes are left-handed, or left "
            "and right are exchanged in it: mirrored (y)",
        )
    if min(signs) < 0:
        return False, (
            "knees bend one way and toes point the other: are the bones of legs and feet the right "
            "ones (map in a study, --names FILE)?",
        )
    return False, ()


def _mirrored(bones: Bones, axis: int) -> Bones:
    """The bones seen in a mirror across one of the file's axes: M R M, and M t of places."""
    place = np.where(np.arange(3) == axis, -1.0, 1.0)
    turn = np.concatenate([[1.0], -place])  # rotation vectors are axial: they turn the other way
    overview = None if bones.overview is None else _mirrored(bones.overview, axis)
    return replace(
        bones,
        offset=bones.offset * place,
        rotations=bones.rotations * turn,
        shift=bones.shift * place,
        ends={name: tuple((np.array(end) * place).tolist()) for name, end in bones.ends.items()},
        overview=overview,
    )


def _rest_axes(rest: Mapping[str, Floats]) -> Floats | None:
    """(3, 3) the axes forward, left and up of the skeleton at rest, each one of the file's axes.

    rest: where bones begin, by segment. Up is from the knees to the head, left from the right hip
    to the left one. None if the pose does not stand.
    """
    head = rest.get("H", 0.5 * (rest["LUA"] + rest["RUA"]))
    vertical = _main_axis(head - 0.5 * (rest["LLL"] + rest["RLL"]))
    across = rest["LUL"] - rest["RUL"]
    lines = [0.5 * (rest["LUA"] + rest["RUA"] - rest["LUL"] - rest["RUL"])]
    for side in "LR":
        lines.append(rest[side + "UL"] - rest[side + "LL"])
        if side + "F" in rest:
            lines.append(rest[side + "LL"] - rest[side + "F"])
    level = across - vertical * (across @ vertical)
    stands = all(_unit(line) @ vertical > _UPRIGHT for line in lines)
    if not stands or np.linalg.norm(level) < _UPRIGHT * np.linalg.norm(across):
        return None
    left = _main_axis(level)
    return np.array([np.cross(left, vertical), left, vertical])


def _upward(seen: _Seen, rest: Floats | None, up: str | None) -> tuple[Floats, tuple[str, ...]]:
    """The file's upward axis (3,): the given one, or that of the rest pose, or of the frames.

    Returns also what is said of it. rest: the axis along which the rest pose stands, if it does.
    """
    head = seen.at("H") if "H" in seen.bone else seen.middle("UA")
    foot = "F" if {"LF", "RF"} <= seen.bone.keys() else "LL"
    rise = 2.0 * head - seen.middle("UL") - seen.middle(foot)
    main = _main_axis(rise.mean(axis=0))
    if up:
        axis = _named_axis(up)
        why = "as stated"
    elif rest is not None and (main @ rest > 0 or _leads(rise, main).mean() < _CLEAR):
        axis = rest
        why = "as its skeleton stands"
    elif rest is not None:
        axis = main
        why = (
            f"as its frames stand; its zero pose stands along {_axis_name(rest)}: if the person lies, "
            f"state it (up in a study, --up {_axis_name(rest)})"
        )
    elif _leads(rise, main).mean() >= 0.5:
        axis = main
        why = "as its frames stand"
    else:
        raise InputError(
            f"{seen.bones.file}: its zero pose does not stand, and neither do its frames: which axis is up "
            "cannot be told; state it (up in a study, --up: x, y, z, -x, -y or -z)"
        )
    share = float(_leads(rise, axis).mean())
    doubt = "" if share >= 0.5 else ". Where another axis is up, state it (up in a study, --up)"
    if up and not doubt:
        return axis, ()
    return axis, (
        f"up is {_axis_name(axis)} of the file, {why}; along it the head is above the feet in "
        f"{100 * share:.0f} % of the frames{doubt}",
    )


def _leads(rise: Floats, axis: Floats) -> Bools:
    """(F,) whether an axis is within 45 degrees of the way from the feet to the head."""
    return np.asarray(rise @ axis >= np.sqrt(0.5) * np.linalg.norm(rise, axis=-1))


def _upright_by_rest(body: Body, rest: Mapping[str, Floats], axes: Floats) -> dict[str, Floats]:
    """(4,) bone from segment by segment, of a rest pose that stands with these axes (3, 3)."""
    basis = from_matrices(axes[None])[0]
    found = {}
    for segment in rest:
        limb = segment[0] + "LA" if segment in ("LHN", "RHN") else segment  # with its forearm
        end = _NEXT_SEGMENT.get(limb, "")
        laid = IDENTITY
        if end in rest:
            laid = shortest(_unit(_axis(body, limb)), _unit(axes @ (rest[end] - rest[limb])))
        found[segment] = multiply(conjugate(basis), laid)
    return found


def _upright_by_frames(body: Body, seen: _Seen, world: Floats) -> dict[str, Floats]:
    """(4,) bone from segment by segment, whatever the rest pose is.

    Lower and upper torso: y along hips and shoulders, z along the trunk. A segment with an axis is
    that which carries it, turned the shortest way to the line between its joints; one without
    follows what carries it. Both hold on average over the frames, the axis exactly.
    """
    basis = from_matrices(world[None])[0]
    found: dict[str, Floats] = {}
    attitudes: dict[str, Floats] = {}
    for segment in (name for name in body.segments if name in seen.bone):
        bone = multiply(basis, seen.attitude[:, seen.index(segment)])
        carrier = attitudes.get(_carrier(body, segment, attitudes), bone)
        line = seen.line(segment) if segment in _NEXT_SEGMENT or segment in ("CT", "N") else None
        own = _axis(body, segment) if segment in _NEXT_SEGMENT else np.array([0.0, 0.0, 1.0])
        if segment in ("LT", "UT"):
            sides = seen.across() if segment == "LT" else seen.at("LUA") - seen.at("RUA")
            wanted = _trunk_attitudes(sides @ world.T, seen.trunk() @ world.T)
            weight = np.ones(len(bone))
        elif line is None:
            wanted = carrier
            weight = np.ones(len(bone))
        else:
            along = rotate(carrier, _unit(own))
            way = _unit(line @ world.T)
            wanted = multiply(shortest(along, way), carrier)
            weight = 1.0 + (along * way).sum(axis=-1)  # opposite ones say nothing about the twist
        mean = _mean_rotation(multiply(conjugate(bone), wanted), weight)
        if line is not None and segment not in ("LT", "UT"):
            seen_axis = _unit(rotate(conjugate(bone), _unit(line @ world.T)).mean(axis=0))
            mean = multiply(shortest(rotate(mean, _unit(own)), seen_axis), mean)
        found[segment] = mean
        attitudes[segment] = multiply(bone, mean)
    return found


def _carrier(body: Body, segment: str, known: Mapping[str, Floats]) -> str:
    """The nearest segment toward the lower torso that is known, the lower torso at last."""
    while True:
        segment = body.segments[int(body.parent[body.segment(segment)])]
        if segment in known or body.parent[body.segment(segment)] < 0:
            return segment if segment in known else "LT"


def _trunk_attitudes(left: Floats, line: Floats) -> Floats:
    """(F, 4) rotations whose y is along lines (F, 3) and whose z is nearest to others (F, 3)."""
    y = _unit(left)
    z = _unit(line - y * (y * line).sum(axis=-1, keepdims=True))
    return from_matrices(np.stack([np.cross(y, z), y, z], axis=-1))


def _mean_rotation(rotations: Floats, weight: Floats) -> Floats:
    """(4,) the mean of rotations (F, 4): the first eigenvector of sum w q q^T (Markley et al. 2007)."""
    _, vectors = np.linalg.eigh(np.einsum("f,fi,fj->ij", weight, rotations, rotations))
    return np.asarray(vectors[:, -1])


def _unit(vectors: Floats) -> Floats:
    """Unit vectors (..., 3); zero ones stay."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0.0, length, 1.0))


def _main_axis(vector: Floats) -> Floats:
    """(3,) the positive or negative axis nearest to a vector."""
    k = int(np.argmax(np.abs(vector)))
    return np.asarray(np.eye(3)[k] * (1.0 if vector[k] >= 0 else -1.0))


def _named_axis(name: str) -> Floats:
    if name.lstrip("+-") not in ("x", "y", "z"):
        raise InputError(f"up: {name!r} is not an axis; valid: x, y, z, -x, -y, -z")
    return np.asarray((-1.0 if name.startswith("-") else 1.0) * np.eye(3)["xyz".index(name[-1])])


def _axis_name(axis: Floats) -> str:
    k = int(np.argmax(np.abs(axis)))
    return ("-" if axis[k] < 0 else "") + "xyz"[k]
