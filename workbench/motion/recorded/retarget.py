"""Transfer the motion of an unknown skeleton to a body.

Each segment turns from its zero pose as its bone turns from the rest pose. The rest pose of the
skeleton is arbitrary (arms out or down), so the shortest rotation first takes the segment's axis to
the bone's axis at rest. Trunk and feet are taken to stand as the body's do.

A skeleton may turn a limb in a joint where the body has a hinge, such as a forearm that twists in
the elbow. Such a turn is moved to the neighbouring ball joints (`_make_hinge`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.motion import Bones
from workbench.model.poses import Poses
from workbench.model.quaternions import (
    conjugate,
    exponential,
    from_matrices,
    matrices,
    multiply,
    rotate,
    shortest,
    swing_twist,
)
from workbench.motion.recorded.bone_names import bone_map

__all__ = [
    "IDENTITY",
    "body_lengths",
    "bone_lengths",
    "bone_positions",
    "rest_positions",
    "retarget",
]

_HINGES = (("LS", "LE", "LW"), ("RS", "RE", "RW"), ("LH", "LK", "LA"), ("RH", "RK", "RA"))
_STRAIGHT = np.radians(15.0)
"""Flexion [rad] of a hinge below which its plane says little about the turn of the limb above."""
_AXIS_JOINTS = {
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


def retarget(
    body: Body,
    bones: Bones,
    *,
    names: Mapping[str, str] | None = None,
    up: str | None = None,
    metres: float | None = None,
) -> tuple[Poses, tuple[str, ...]]:
    """Compute the motion of a skeleton as poses of a body.

    The lower torso is placed so that the middle of the hips is where it is in the file.

    Parameters
    ----------
    body
        A body with the paper's joints.
    bones
        The skeleton and its motion in P frames.
    names
        Bones by segment, where the usual names do not apply.
    up
        The file's upward axis ("y", "-z"), found from the skeleton if None.
    metres
        One unit of the file [m]. If neither it nor the file states the unit, the skeleton's legs
        are taken to be as long as the body's.

    Returns
    -------
    tuple of Poses and str
        The poses, and what was assumed, in sentences.

    Raises
    ------
    InputError
        If bones are missing, or the body has other joints.
    """
    _require_joints(body)
    skeleton = _Skeleton.of(bones, bone_map(bones, names), up)
    notes = list(bones.notes)
    if not up:
        up_axis = _axis_name(skeleton.world_from_file[2])
        notes.append(f"up is {up_axis} of the file, as its skeleton stands")
    unit = metres if metres is not None else bones.metres
    if not np.isfinite(unit):
        unit = _unit_by_legs(body, skeleton)
        notes.append(
            f"the file does not say its unit of length; one unit is taken as {1000 * unit:.4g} mm, which makes "
            f"its legs as long as those of {body.name}"
        )
    attitudes = _segment_attitudes(body, skeleton)
    rotations = _joint_rotations(body, attitudes, len(bones.time))
    pelvis = _pelvis_frames(body, skeleton, attitudes["LT"], unit)
    return Poses(rotations, body.segment("LT"), pelvis, bones.time), tuple(notes)


def _require_joints(body: Body) -> None:
    needed = ("LH", "RH", *(joint for pair in _AXIS_JOINTS.values() for joint in pair))
    missing = [joint for joint in needed if joint not in body.joints]
    if missing:
        raise InputError(
            f"body {body.name}: a motion is mapped by the paper's joints, {', '.join(missing)} are missing"
        )


@dataclass(frozen=True, eq=False)
class _Skeleton:
    """A recorded skeleton whose bones are known by segment."""

    bones: Bones
    bone: Mapping[str, str]
    """Names of bones by segment."""
    attitude: Floats
    """(P, B, 4) file from bone, as quaternions."""
    rest: Floats
    """(B, 3) where each bone begins in the rest pose, in the file's axes and units."""
    world_from_file: Floats
    """(3, 3) world from file, x forward and z up."""

    @classmethod
    def of(cls, bones: Bones, bone: Mapping[str, str], up: str | None) -> _Skeleton:
        """Compute attitudes, rest positions and the file's axes."""
        rest = rest_positions(bones)
        begin = {segment: rest[bones.names.index(name)] for segment, name in bone.items()}
        return cls(bones, bone, _bone_attitudes(bones), rest, _world_from_file(begin, up))

    def index(self, segment: str) -> int:
        """The number of a segment's bone."""
        return self.bones.names.index(self.bone[segment])


def _pelvis_frames(body: Body, skeleton: _Skeleton, attitude: Floats, unit: float) -> Floats:
    """(P, 3, 4) world from pelvis, of attitudes (P, 4): the middle of the hips is as in the file."""
    hips = [skeleton.index(segment) for segment in ("LUL", "RUL")]
    middle = bone_positions(skeleton.bones)[:, hips].mean(axis=1)
    left = body.joint_in_parent[0, body.joint("LH")]
    right = body.joint_in_parent[0, body.joint("RH")]
    own_middle = np.broadcast_to(0.5 * (left + right), (len(attitude), 3))
    frames = np.zeros((len(attitude), 3, 4))
    frames[:, :, :3] = matrices(attitude)
    frames[:, :, 3] = middle @ skeleton.world_from_file.T * unit - rotate(attitude, own_middle)
    return frames


def bone_positions(bones: Bones) -> Floats:
    """Return where each bone begins, (P, B, 3), in the file's axes and units."""
    attitude = _bone_attitudes(bones)
    position = np.array(bones.shift)
    for b, parent in enumerate(bones.parent):
        if parent >= 0:
            position[:, b] = position[:, parent] + rotate(attitude[:, parent], bones.shift[:, b])
    return position


def bone_lengths(bones: Bones, bone: Mapping[str, str]) -> dict[str, float]:
    """Return the length of each limb segment's bone at rest, in the file's units.

    bone: names of bones by segment, see `bone_map`.
    """
    rest = rest_positions(bones)
    begin = {segment: rest[bones.names.index(name)] for segment, name in bone.items()}
    return {
        segment: float(np.linalg.norm(begin[end] - begin[segment]))
        for segment, end in _NEXT_SEGMENT.items()
        if segment in begin and end in begin
    }


def body_lengths(body: Body) -> dict[str, float]:
    """Return the length [m] between its joints of each limb segment of a body."""
    return {segment: float(np.linalg.norm(_axis(body, segment))) for segment in _NEXT_SEGMENT}


def _bone_attitudes(bones: Bones) -> Floats:
    """(P, B, 4) file from bone, as quaternions."""
    attitude = np.array(bones.rotations)
    for b, parent in enumerate(bones.parent):
        if parent >= 0:
            attitude[:, b] = multiply(attitude[:, parent], attitude[:, b])
    return attitude


def rest_positions(bones: Bones) -> Floats:
    """Return where each bone begins in the rest pose, (B, 3), in the file's axes and units."""
    position = np.array(bones.offset)
    for b, parent in enumerate(bones.parent):
        if parent >= 0:
            position[b] += position[parent]
    return position


def _world_from_file(begin: Mapping[str, Floats], up: str | None) -> Floats:
    """(3, 3) the axes forward, left and up of the skeleton at rest, each one of the file's axes.

    begin: where the bones begin, by segment. Up is from the knees to the head, left is from the
    right hip to the left one.
    """
    head = begin.get("H", 0.5 * (begin["LUA"] + begin["RUA"]))
    knees = 0.5 * (begin["LLL"] + begin["RLL"])
    vertical = _named_axis(up) if up else _main_axis(head - knees)
    across = begin["LUL"] - begin["RUL"]
    left = _main_axis(across - vertical * (across @ vertical))
    return np.array([np.cross(left, vertical), left, vertical])


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


def _unit_by_legs(body: Body, skeleton: _Skeleton) -> float:
    """The unit of the file [m] that makes the skeleton's legs as long as the body's."""
    lengths = bone_lengths(skeleton.bones, skeleton.bone)
    own = body_lengths(body)
    legs = [segment for segment in ("LUL", "RUL", "LLL", "RLL") if segment in lengths]
    total = sum(lengths[segment] for segment in legs)
    if not legs or total <= 0:
        raise InputError(
            f"{skeleton.bones.file}: the bones of the legs have no length, so the unit cannot be "
            "found; state it"
        )
    return sum(own[segment] for segment in legs) / total


def _segment_attitudes(body: Body, skeleton: _Skeleton) -> dict[str, Floats]:
    """(P, 4) world from segment of the segments that have a bone, by name."""
    basis = from_matrices(skeleton.world_from_file[None])[0]
    attitudes = {}
    for segment in skeleton.bone:
        bone = skeleton.attitude[:, skeleton.index(segment)]
        world = multiply(multiply(basis, bone), conjugate(basis))
        attitudes[segment] = multiply(world, _alignment(body, skeleton, segment))
    return attitudes


def _alignment(body: Body, skeleton: _Skeleton, segment: str) -> Floats:
    """(4,) the shortest rotation from a segment's axis in the zero pose to its bone's axis at rest.

    It is the identity for trunk and feet, and for bones without length.
    """
    rest = skeleton.rest @ skeleton.world_from_file.T
    bone_axis = _rest_axis(skeleton, segment, rest)
    own_axis = _axis(body, segment) if segment in _AXIS_JOINTS else None
    if segment in ("LHN", "RHN"):
        own_axis = np.array([0.0, 0.0, -1.0])
    if bone_axis is None or own_axis is None:
        return IDENTITY
    length = float(np.linalg.norm(bone_axis))
    if length < 1e-9 * (1 + np.abs(rest).max()):
        return IDENTITY
    return shortest(own_axis / np.linalg.norm(own_axis), bone_axis / length)


def _rest_axis(skeleton: _Skeleton, segment: str, rest: Floats) -> Floats | None:
    """(3,) from the beginning to the end of a segment's bone, of rest positions (B, 3).

    A hand goes on as the forearm. None for a bone whose end is unknown.
    """
    begin = rest[skeleton.index(segment)]
    if segment in _NEXT_SEGMENT and _NEXT_SEGMENT[segment] in skeleton.bone:
        return np.asarray(rest[skeleton.index(_NEXT_SEGMENT[segment])] - begin)
    if segment in ("LHN", "RHN"):
        return np.asarray(begin - rest[skeleton.index(segment[0] + "LA")])
    return None


def _axis(body: Body, segment: str) -> Floats:
    """(3,) from the proximal to the distal joint of a segment in the zero pose."""
    proximal, distal = (body.joint(j) for j in _AXIS_JOINTS[segment])
    return np.asarray(body.joint_in_parent[0, distal] - body.joint_in_child[0, proximal])


def _joint_rotations(body: Body, attitudes: Mapping[str, Floats], frames: int) -> Floats:
    """(P, J, 4) joint rotations of segments' attitudes (P, 4)."""
    full = _all_attitudes(body, attitudes, frames)
    rotations = np.tile(IDENTITY, (frames, len(body.joints), 1))
    for joint in range(len(body.joints)):
        child = body.segments[joint + 1]
        parent = body.segments[int(body.parent[joint + 1])]
        rotations[:, joint] = multiply(conjugate(full[parent]), full[child])
    rotations[:, body.joint("PV")] = full["LT"]
    for above, hinge, below in _HINGES:
        _make_hinge(rotations, _Hinge.of(body, above, hinge, below))
    return np.asarray(rotations / np.linalg.norm(rotations, axis=-1, keepdims=True))


def _all_attitudes(body: Body, attitudes: Mapping[str, Floats], frames: int) -> dict[str, Floats]:
    """(P, 4) of every segment. Those without a bone are half way between, or follow their parent."""
    still = np.tile(IDENTITY, (frames, 1))
    full = dict(attitudes)
    if "CT" not in full:
        full["CT"] = _halfway(full["LT"], full.get("UT", full["LT"]))
    full.setdefault("UT", full["CT"])
    if "H" in full and "N" not in full:
        full["N"] = _halfway(full["UT"], full["H"])
    for joint in range(len(body.joints)):
        child = body.segments[joint + 1]
        parent = body.segments[int(body.parent[joint + 1])]
        full.setdefault(child, full.get(parent, still))
        full.setdefault(parent, still)
    return full


@dataclass(frozen=True, eq=False)
class _Hinge:
    """A hinge between two ball joints, as indices, and the limb's lines in the zero pose."""

    above: int
    joint: int
    below: int
    axis: Floats
    """(3,) unit axis of the hinge."""
    upper: Floats
    """(3,) unit vector from the joint above to the hinge."""
    lower: Floats
    """(3,) unit vector from the hinge to the joint below."""

    @classmethod
    def of(cls, body: Body, above: str, hinge: str, below: str) -> _Hinge:
        """Find the lines between three joints of a limb."""
        first, middle, last = (body.joint(name) for name in (above, hinge, below))
        upper, lower = _line(body, first, middle), _line(body, middle, last)
        return cls(first, middle, last, body.stops.axes[middle, 0], upper, lower)


def _make_hinge(rotations: Floats, hinge: _Hinge) -> None:
    """Change joint rotations (P, J, 4) so that a hinge turns about its own axis only.

    The limb above is turned about its line until the hinge bends in its own plane. The twist of the
    limb below about its line moves to the joint below. All three joints stay where they are, since
    both turns are about lines between them.
    """
    swing, _ = swing_twist(rotations[:, hinge.joint], hinge.lower[None])
    # angle of the swing vector about the upper line, from the hinge's axis to it
    side = hinge.axis - hinge.upper * (hinge.upper @ hinge.axis)
    across = np.cross(hinge.upper, side)
    angle = np.arctan2(
        (swing * across).sum(axis=-1) / np.linalg.norm(across),
        (swing * side).sum(axis=-1) / np.linalg.norm(side),
    )
    # a limb that is nearly straight has no plane: the turn fades out as f^4 / (f^4 + f0^4)
    flexion = np.linalg.norm(swing, axis=-1)
    faded = angle * flexion**4 / (flexion**4 + _STRAIGHT**4)
    turn = exponential(faded[:, None] * hinge.upper)
    rotations[:, hinge.above] = multiply(rotations[:, hinge.above], turn)
    bend, twist = swing_twist(
        multiply(conjugate(turn), rotations[:, hinge.joint]), hinge.lower[None]
    )
    rotations[:, hinge.joint] = exponential(bend)
    passed_on = exponential(twist[:, None] * hinge.lower)
    rotations[:, hinge.below] = multiply(passed_on, rotations[:, hinge.below])


def _line(body: Body, upper: int, lower: int) -> Floats:
    """(3,) unit vector in the zero pose from one joint of a limb segment to the next one down."""
    line = body.joint_in_parent[0, lower] - body.joint_in_child[0, upper]
    return np.asarray(line / np.linalg.norm(line))


def _halfway(a: Floats, b: Floats) -> Floats:
    """(P, 4) the rotations half way between two, as the normalized mean of quaternions."""
    near = np.where(np.sum(a * b, axis=-1, keepdims=True) < 0, -b, b)  # q and -q are one rotation
    middle = a + near
    return np.asarray(middle / np.linalg.norm(middle, axis=-1, keepdims=True))
