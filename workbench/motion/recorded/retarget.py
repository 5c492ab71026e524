"""Motion of a strange skeleton, told of a body: each segment turns from its rest as its bone turns
from its own.

The rest pose of the skeleton may be any (arms out or down): the shortest turn takes the segment's
axis in the zero pose to the bone's axis at rest, the pelvis and upper torso by two directions. Then
what the skeleton does in a joint that the body has not (a forearm that turns at the elbow) is given
to the joint that has it.
"""

from __future__ import annotations

from collections.abc import Mapping

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

__all__ = ["body_lengths", "bone_lengths", "bone_positions", "retarget"]

_HINGES = (("LS", "LE", "LW"), ("RS", "RE", "RW"), ("LH", "LK", "LA"), ("RH", "RK", "RA"))
_STRAIGHT = np.radians(15.0)
"""Below this bend a hinge tells less and less of how its limb is turned."""
_AXIS_JOINTS = {  # the joints at both ends of a segment: the axis that is laid along its bone
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
_SPAN = {
    "LUA": "LLA",
    "RUA": "RLA",
    "LLA": "LHN",
    "RLA": "RHN",
    "LUL": "LLL",
    "RUL": "RLL",
    "LLL": "LF",
    "RLL": "RF",
}
"""A bone's length reaches to the bone of this segment."""


def retarget(
    body: Body,
    bones: Bones,
    *,
    names: Mapping[str, str] | None = None,
    up: str | None = None,
    metres: float | None = None,
) -> tuple[Poses, tuple[str, ...]]:
    """The motion as poses of a body with the paper's joints, and what was assumed, in sentences.

    names: bones by segment where the usual names do not tell; up: the file's upward axis, found
    from the skeleton where None; metres: one unit of the file [m]; where None and the file does not
    say, the unit is what makes the skeleton's leg as long as the body's. The lower torso is placed
    so that the middle of the hips is where it is in the file. InputError where bones are missing or
    the body has other joints.
    """
    wanted = ("LH", "RH", *(j for pair in _AXIS_JOINTS.values() for j in pair))
    lacking = [j for j in wanted if j not in body.joints]
    if lacking:
        raise InputError(
            f"body {body.name}: a motion is mapped by the paper's joints, {', '.join(lacking)} are missing"
        )
    chosen = bone_map(bones, names)
    turns = _world_turns(bones)
    rest = _rest_positions(bones)
    world = bone_positions(bones)
    frame, axis = _file_axes(bones, chosen, rest, up)
    notes = list(bones.notes) + (
        [] if up else [f"up is {axis} of the file, as its skeleton stands"]
    )
    unit = metres if metres is not None else bones.metres
    if not np.isfinite(unit):
        unit, said = _unit(body, bones, chosen)
        notes.append(said)
    segments = _segment_turns(body, bones, (chosen, turns, rest @ frame.T), frame)
    rotations = _joint_rotations(body, segments, len(bones.time))
    hips = [bones.names.index(chosen[s]) for s in ("LUL", "RUL")]
    middle = world[:, hips].mean(axis=1) @ frame.T * unit
    place = np.zeros((len(bones.time), 3, 4))
    pelvis = segments["LT"]
    place[:, :, :3] = matrices(pelvis)
    own = 0.5 * (
        body.joint_in_parent[0, body.joint("LH")] + body.joint_in_parent[0, body.joint("RH")]
    )
    place[:, :, 3] = middle - rotate(pelvis, np.broadcast_to(own, (len(pelvis), 3)))
    return Poses(rotations, body.segment("LT"), place, bones.time), tuple(notes)


def bone_positions(bones: Bones) -> Floats:
    """(P, B, 3) where each bone begins, in the file's axes and units."""
    turns = _world_turns(bones)
    place = np.array(bones.shift)
    for b, parent in enumerate(bones.parent):
        if parent >= 0:
            place[:, b] = place[:, parent] + rotate(turns[:, parent], bones.shift[:, b])
    return place


def bone_lengths(bones: Bones, chosen: Mapping[str, str]) -> dict[str, float]:
    """Length of each limb segment's bone at rest, in the file's units."""
    rest = _rest_positions(bones)
    at = {s: rest[bones.names.index(name)] for s, name in chosen.items()}
    return {
        s: float(np.linalg.norm(at[end] - at[s]))
        for s, end in _SPAN.items()
        if s in at and end in at
    }


def body_lengths(body: Body) -> dict[str, float]:
    """Length [m] of each limb segment of a body between its joints."""
    return {s: float(np.linalg.norm(_axis(body, s))) for s in _SPAN}


def _world_turns(bones: Bones) -> Floats:
    turns = np.array(bones.rotations)
    for b, parent in enumerate(bones.parent):
        if parent >= 0:
            turns[:, b] = multiply(turns[:, parent], turns[:, b])
    return turns


def _rest_positions(bones: Bones) -> Floats:
    place = np.array(bones.offset)
    for b, parent in enumerate(bones.parent):
        if parent >= 0:
            place[b] += place[parent]
    return place


def _file_axes(
    bones: Bones, chosen: Mapping[str, str], rest: Floats, up: str | None
) -> tuple[Floats, str]:
    """(3, 3) world from file, x forward and z up, by the skeleton at rest; and the axis that is
    up."""
    at = {s: rest[bones.names.index(name)] for s, name in chosen.items()}
    top = at.get("H", 0.5 * (at["LUA"] + at["RUA"]))
    rise = _main_axis(top - 0.5 * (at["LLL"] + at["RLL"])) if not up else _named_axis(up)
    across = at["LUL"] - at["RUL"]
    left = _main_axis(across - rise * (across @ rise))
    return np.array([np.cross(left, rise), left, rise]), _axis_name(rise)


def _main_axis(vector: Floats) -> Floats:
    k = int(np.argmax(np.abs(vector)))
    return np.asarray(np.eye(3)[k] * (1.0 if vector[k] >= 0 else -1.0))


def _named_axis(name: str) -> Floats:
    if name.lstrip("+-") not in ("x", "y", "z"):
        raise InputError(f"up: {name!r} is not an axis; valid: x, y, z, -x, -y, -z")
    return np.asarray((-1.0 if name.startswith("-") else 1.0) * np.eye(3)["xyz".index(name[-1])])


def _axis_name(axis: Floats) -> str:
    k = int(np.argmax(np.abs(axis)))
    return ("-" if axis[k] < 0 else "") + "xyz"[k]


def _unit(body: Body, bones: Bones, chosen: Mapping[str, str]) -> tuple[float, str]:
    lengths = bone_lengths(bones, chosen)
    own = body_lengths(body)
    legs = [s for s in ("LUL", "RUL", "LLL", "RLL") if s in lengths]
    total = sum(lengths[s] for s in legs)
    if not legs or total <= 0:
        raise InputError(
            f"{bones.file}: the bones of the legs have no length: the unit cannot be told, state it"
        )
    unit = sum(own[s] for s in legs) / total
    return unit, (
        f"the file does not say its unit of length; one unit is taken as {1000 * unit:.4g} mm, which makes "
        f"its legs as long as those of {body.name}"
    )


def _segment_turns(
    body: Body, bones: Bones, found: tuple[Mapping[str, str], Floats, Floats], frame: Floats
) -> dict[str, Floats]:
    """(P, 4) by segment that has a bone: world from segment."""
    chosen, turns, rest = found
    basis = from_matrices(frame[None])[0]
    result = {}
    for segment, name in chosen.items():
        b = bones.names.index(name)
        world = multiply(multiply(basis, turns[:, b]), conjugate(basis))
        result[segment] = multiply(world, _alignment(body, bones, segment, (chosen, rest)))
    return result


def _alignment(
    body: Body, bones: Bones, segment: str, found: tuple[Mapping[str, str], Floats]
) -> Floats:
    """(4,) the turn from the segment's zero pose to its bone at rest."""
    chosen, rest = found
    end = _rest_end(bones, segment, chosen, rest)
    own = _axis(body, segment) if segment in _AXIS_JOINTS else None
    if segment in ("LHN", "RHN"):
        own = np.array([0.0, 0.0, -1.0])
    if end is None or own is None or np.linalg.norm(end) < 1e-9 * (1 + np.abs(rest).max()):
        return np.array([1.0, 0.0, 0.0, 0.0])
    return shortest(own / np.linalg.norm(own), end / np.linalg.norm(end))


def _rest_end(bones: Bones, segment: str, chosen: Mapping[str, str], rest: Floats) -> Floats | None:
    """From where a bone begins at rest to where the next one does, in the world's axes; None for
    trunk and feet, which stand as the body does."""
    begin = rest[bones.names.index(chosen[segment])]
    if segment in _SPAN and _SPAN[segment] in chosen:
        return np.asarray(rest[bones.names.index(chosen[_SPAN[segment]])] - begin)
    if segment in ("LHN", "RHN"):
        arm = segment[0] + "LA"
        return np.asarray(
            begin - rest[bones.names.index(chosen[arm])]
        )  # a flat hand goes on as the forearm
    return None


def _axis(body: Body, segment: str) -> Floats:
    """(3,) from the proximal to the distal joint of a segment in the zero pose."""
    proximal, distal = (body.joint(j) for j in _AXIS_JOINTS[segment])
    return np.asarray(body.joint_in_parent[0, distal] - body.joint_in_child[0, proximal])


def _joint_rotations(body: Body, segments: Mapping[str, Floats], frames: int) -> Floats:
    """(P, J, 4): each joint from the turns of its two segments; segments without a bone lie halfway
    or follow."""
    still = np.tile([1.0, 0.0, 0.0, 0.0], (frames, 1))
    full = dict(segments)
    if "CT" not in full:
        full["CT"] = _halfway(full["LT"], full.get("UT", full["LT"]))
    full.setdefault("UT", full["CT"])
    if "H" in full and "N" not in full:
        full["N"] = _halfway(full["UT"], full["H"])
    rotations = np.tile([1.0, 0.0, 0.0, 0.0], (frames, len(body.joints), 1))
    for j in range(len(body.joints)):
        child = body.segments[j + 1]
        parent = body.segments[int(body.parent[j + 1])]
        full.setdefault(child, full.get(parent, still))
        full.setdefault(parent, still)
        rotations[:, j] = multiply(conjugate(full[parent]), full[child])
    rotations[:, body.joint("PV")] = full["LT"]
    for joints in _HINGES:
        _one_axis(body, rotations, joints)
    return np.asarray(rotations / np.linalg.norm(rotations, axis=-1, keepdims=True))


def _one_axis(body: Body, rotations: Floats, joints: tuple[str, str, str]) -> None:
    """Turn the limb above a hinge so that the hinge bends about its own axis; what the limb below
    turns about itself goes to the joint below. Turns are about the lines from joint to joint, so
    all three joints stay where they are."""
    above, hinge, below = (body.joint(j) for j in joints)
    upper, lower = (_line(body, pair) for pair in ((above, hinge), (hinge, below)))
    first = body.stops.axes[hinge, 0]
    swing, _ = swing_twist(rotations[:, hinge], lower[None])
    side = first - upper * (upper @ first)
    across = np.cross(upper, side)
    turn = np.arctan2(
        (swing * across).sum(axis=-1) / np.linalg.norm(across),
        (swing * side).sum(axis=-1) / np.linalg.norm(side),
    )
    size = np.linalg.norm(swing, axis=-1)
    about = exponential((turn * size**4 / (size**4 + _STRAIGHT**4))[:, None] * upper)
    rotations[:, above] = multiply(rotations[:, above], about)
    bent, own = swing_twist(multiply(conjugate(about), rotations[:, hinge]), lower[None])
    rotations[:, hinge] = exponential(bent)
    rotations[:, below] = multiply(exponential(own[:, None] * lower), rotations[:, below])


def _line(body: Body, joints: tuple[int, int]) -> Floats:
    """(3,) unit vector in the zero pose from one joint of a limb segment to the next one down."""
    upper, lower = joints
    line = body.joint_in_parent[0, lower] - body.joint_in_child[0, upper]
    return np.asarray(line / np.linalg.norm(line))


def _halfway(a: Floats, b: Floats) -> Floats:
    near = np.where(np.sum(a * b, axis=-1, keepdims=True) < 0, -b, b)
    middle = a + near
    return np.asarray(middle / np.linalg.norm(middle, axis=-1, keepdims=True))
